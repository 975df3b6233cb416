//! Half-space: the limb that carries a point contact stays on the positive side of the patch.
//!
//! Source: paper, eq. (halfspace_inequality), with the limb's own direction (formulation 2.8).

use super::PoseTerm;
use super::pose_functions::{direction_gradient, direction_hessian};
use nalgebra::{Matrix6, Vector3, Vector6};
use spatial::Pose;

/// (R limb)_z ≥ 0 [sine of the limb's elevation].
#[derive(Debug)]
pub struct HalfSpace {
    /// Unit direction from the contact into the limb, in axes of a.
    pub limb: Vector3<f64>,
}

impl PoseTerm for HalfSpace {
    fn name(&self) -> &'static str {
        "half-space"
    }
    fn unit(&self) -> &'static str {
        "rad"
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        vec![(0.0, f64::INFINITY)]
    }
    fn values(&self, b_from_a: &Pose, out: &mut [f64]) {
        out[0] = b_from_a.rotate(self.limb).z;
    }
    fn gradients(&self, b_from_a: &Pose, out: &mut [Vector6<f64>]) {
        out[0] = direction_gradient(b_from_a, &self.limb, &Vector3::z());
    }
    fn hessian(&self, b_from_a: &Pose, weights: &[f64]) -> Matrix6<f64> {
        direction_hessian(b_from_a, &self.limb, &Vector3::z()) * weights[0]
    }
}
