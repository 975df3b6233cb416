//! Goal heading: the x axis of a body points within a sector of the horizontal plane at the end.
//!
//! Source: paper, eq. (TAMP), x_N ∈ X_goal. `b` is the world turned by the middle of the sector, so that the angle's jump
//! at ±π lies opposite to the goal.

use super::PoseTerm;
use super::pose_functions::{yaw, yaw_gradient, yaw_hessian};
use nalgebra::{Matrix6, Vector6};
use spatial::Pose;

/// −half_width ≤ angle of a's x axis in b's xy plane ≤ half_width [rad].
#[derive(Debug)]
pub struct Heading {
    /// Half the width of the sector [rad].
    pub half_width: f64,
}

impl PoseTerm for Heading {
    fn name(&self) -> &'static str {
        "goal heading"
    }
    fn unit(&self) -> &'static str {
        "rad"
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        vec![(-self.half_width, self.half_width)]
    }
    fn values(&self, b_from_a: &Pose, out: &mut [f64]) {
        out[0] = yaw(b_from_a);
    }
    fn gradients(&self, b_from_a: &Pose, out: &mut [Vector6<f64>]) {
        out[0] = yaw_gradient(b_from_a);
    }
    fn hessian(&self, b_from_a: &Pose, weights: &[f64]) -> Matrix6<f64> {
        yaw_hessian(b_from_a) * weights[0]
    }
}
