//! Torsional friction of a patch contact: |m_z| ≤ μ_r f_n.
//!
//! Source: paper, eq. (unilateral_patch), |κ_z| ≤ μ_r f_z; axes of a, f_n = −f_z.

use super::friction::{linear_gradients, linear_rows};
use super::{ForceHessian, ForceTerm};
use nalgebra::Vector6;
use spatial::Pose;

/// Two rows ≥ 0: μ_r f_n ∓ m_z [N·m / scale].
#[derive(Debug)]
pub struct Torsion {
    coefficients: [Vector6<f64>; 2],
}

impl Torsion {
    /// Torsional friction coefficient [m] and the moment that counts as one [N·m].
    pub fn new(mu_r: f64, scale: f64) -> Self {
        let row = |sign: f64| Vector6::new(0.0, 0.0, -mu_r, 0.0, 0.0, sign) / scale;
        Self {
            coefficients: [row(-1.0), row(1.0)],
        }
    }
}

impl ForceTerm for Torsion {
    fn name(&self) -> &'static str {
        "torsional friction"
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        vec![(0.0, f64::INFINITY); 2]
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
