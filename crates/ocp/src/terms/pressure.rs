//! Centre of pressure: it stays inside patch a.
//!
//! Source: paper, eq. (unilateral_patch), |κ_xy| ≤ f_z ξ_xy, with the indices exchanged as they must be (formulation
//! 2.3): |m_x| ≤ f_n ξ_y, |m_y| ≤ f_n ξ_x, axes of a, f_n = −f_z.

use super::friction::{linear_gradients, linear_rows};
use super::{ForceHessian, ForceTerm};
use nalgebra::Vector6;
use spatial::Pose;

/// Four rows ≥ 0: f_n ξ ∓ m [N·m / scale].
#[derive(Debug)]
pub struct Pressure {
    coefficients: [Vector6<f64>; 4],
}

impl Pressure {
    /// Half extents [m] of the area that the centre of pressure may use, and the moment that counts as one [N·m].
    pub fn new(half_size: [f64; 2], scale: f64) -> Self {
        let row = |half: f64, axis: usize, sign: f64| {
            let mut c = Vector6::zeros();
            c[2] = -half / scale;
            c[axis] = sign / scale;
            c
        };
        let [x, y] = half_size;
        Self {
            coefficients: [
                row(y, 3, -1.0),
                row(y, 3, 1.0),
                row(x, 4, -1.0),
                row(x, 4, 1.0),
            ],
        }
    }
}

impl ForceTerm for Pressure {
    fn name(&self) -> &'static str {
        "centre of pressure"
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        vec![(0.0, f64::INFINITY); 4]
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
