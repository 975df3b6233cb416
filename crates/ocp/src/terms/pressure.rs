//! Centre of pressure: it stays inside patch a.
//!
//! Source: paper, eq. (unilateral_patch), |κ_xy| ≤ f_z ξ_xy, with the indices exchanged as they must be (formulation
//! 2.3): |m_x| ≤ f_n ξ_y, |m_y| ≤ f_n ξ_x, axes of a, f_n = −f_z. Here about a centre c, which need not be the patch's:
//! |m_x + f_n c_y| ≤ (f_n − s) ξ_y, |m_y − f_n c_x| ≤ (f_n − s) ξ_x, with a part s of the normal force that counts for nothing: the
//! moment s ξ stays in reserve. A foot that bears little is tipped by small errors of the torques otherwise.

use super::friction::{linear_gradients, linear_rows};
use super::{ForceHessian, ForceTerm};
use nalgebra::Vector6;
use spatial::Pose;

/// Four rows ≥ s ξ: f_n ξ ∓ m [N·m / scale].
#[derive(Debug)]
pub struct Pressure {
    coefficients: [Vector6<f64>; 4],
    /// s ξ [N·m / scale].
    reserves: [f64; 4],
}

impl Pressure {
    /// Centre in a's frame and half extents [m] of the area that the centre of pressure may use, the moment that counts as one
    /// [N·m], and s [N].
    pub fn new(center: [f64; 2], half_size: [f64; 2], scale: f64, spare: f64) -> Self {
        let row = |reach: f64, axis: usize, sign: f64| {
            let mut c = Vector6::zeros();
            c[2] = -reach / scale;
            c[axis] = sign / scale;
            c
        };
        let ([c_x, c_y], [x, y]) = (center, half_size);
        Self {
            coefficients: [
                row(y - c_y, 3, -1.0),
                row(y + c_y, 3, 1.0),
                row(x + c_x, 4, -1.0),
                row(x - c_x, 4, 1.0),
            ],
            reserves: [y, y, x, x].map(|reach| spare * reach / scale),
        }
    }
}

impl ForceTerm for Pressure {
    fn name(&self) -> &'static str {
        "centre of pressure"
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        self.reserves.map(|least| (least, f64::INFINITY)).to_vec()
    }
    fn values(&self, _: &Pose, w: &Vector6<f64>, out: &mut [f64]) {
        linear_rows(&self.coefficients, w, out);
    }
    fn gradients(&self, _: &Pose, _: &Vector6<f64>, out: &mut [(Vector6<f64>, Vector6<f64>)]) {
        linear_gradients(&self.coefficients, out);
    }
    fn hessian(&self, _: &Pose, _: &Vector6<f64>, _: &[f64]) -> ForceHessian {
        ForceHessian::zero()
    }
}
