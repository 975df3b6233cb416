//! Friction cone of a patch contact: the tangential force is at most μ times the normal force.
//!
//! Source: paper, eq. (unilateral_patch), first line. In axes of a, whose z is opposite to b's normal, f_n = −f_z.
//! **Departs:** written as √2 μ f_n − √(f_x² + f_y² + μ² f_n² + ε²) ≥ 0. With ε = 0 this is the same cone, but smooth
//! everywhere except at its tip, also where the tangential force vanishes; ε bounds the curvature at the tip. It is on
//! the safe side: a listed contact carries at least ε/μ.

use super::{ForceHessian, ForceTerm};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use spatial::Pose;

/// The cone of normal n (outward of b) around the force: value, gradient and Hessian by (f_x, f_y, f_n).
pub fn cone(
    tangential: [f64; 2],
    normal: f64,
    mu: f64,
    epsilon: f64,
) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let [x, y] = tangential;
    let root = (x * x + y * y + mu * mu * normal * normal + epsilon * epsilon).sqrt();
    let scaled = Vector3::new(x, y, mu * mu * normal);
    let gradient = Vector3::new(0.0, 0.0, std::f64::consts::SQRT_2 * mu) - scaled / root;
    let hessian = scaled * scaled.transpose() / root.powi(3)
        - Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, mu * mu)) / root;
    (
        std::f64::consts::SQRT_2 * mu * normal - root,
        gradient,
        hessian,
    )
}

/// One row ≥ 0 [N / scale].
#[derive(Debug)]
pub struct Friction {
    /// Sliding friction coefficient.
    pub mu: f64,
    /// ε [N].
    pub epsilon: f64,
    /// Force that counts as one [N].
    pub scale: f64,
}

impl ForceTerm for Friction {
    fn name(&self) -> &'static str {
        "friction cone"
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        vec![(0.0, f64::INFINITY)]
    }
    fn values(&self, _: &Pose, w: &Vector6<f64>, out: &mut [f64]) {
        out[0] = cone([w[0], w[1]], -w[2], self.mu, self.epsilon).0 / self.scale;
    }
    fn gradients(&self, _: &Pose, w: &Vector6<f64>, out: &mut [(Vector6<f64>, Vector6<f64>)]) {
        let g = cone([w[0], w[1]], -w[2], self.mu, self.epsilon).1 / self.scale;
        out[0] = (
            Vector6::zeros(),
            Vector6::new(g.x, g.y, -g.z, 0.0, 0.0, 0.0),
        );
    }
    fn hessian(&self, _: &Pose, w: &Vector6<f64>, weights: &[f64]) -> ForceHessian {
        let flip = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0));
        let h = cone([w[0], w[1]], -w[2], self.mu, self.epsilon).2 * (weights[0] / self.scale);
        let mut out = ForceHessian::zero();
        out.wrench
            .fixed_view_mut::<3, 3>(0, 0)
            .copy_from(&(flip * h * flip));
        out
    }
}

/// Rows that are linear in the wrench share this: row = coefficients · w.
pub(super) fn linear_rows(coefficients: &[Vector6<f64>], w: &Vector6<f64>, out: &mut [f64]) {
    for (o, c) in out.iter_mut().zip(coefficients) {
        *o = c.dot(w);
    }
}

/// Gradients of rows that are linear in the wrench.
pub(super) fn linear_gradients(
    coefficients: &[Vector6<f64>],
    out: &mut [(Vector6<f64>, Vector6<f64>)],
) {
    for (o, c) in out.iter_mut().zip(coefficients) {
        *o = (Matrix6::zeros() * c, *c);
    }
}
