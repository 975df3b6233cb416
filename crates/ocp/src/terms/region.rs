//! Goal region: a point of a body lies inside a box of the world at the end.
//!
//! Source: paper, eq. (TAMP), x_N ∈ X_goal.

use super::PoseTerm;
use super::pose_functions::{point_gradient, point_hessian};
use nalgebra::{Matrix6, Vector3, Vector6};
use spatial::Pose;

/// lower ≤ origin of a in b ≤ upper [m].
#[derive(Debug)]
pub struct Region {
    /// Lower corner; −∞ where free.
    pub lower: Vector3<f64>,
    /// Upper corner; +∞ where free.
    pub upper: Vector3<f64>,
}

impl PoseTerm for Region {
    fn name(&self) -> &'static str {
        "goal region"
    }
    fn unit(&self) -> &'static str {
        "m"
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        (0..3).map(|i| (self.lower[i], self.upper[i])).collect()
    }
    fn values(&self, b_from_a: &Pose, out: &mut [f64]) {
        out.copy_from_slice(b_from_a.origin().as_slice());
    }
    fn gradients(&self, b_from_a: &Pose, out: &mut [Vector6<f64>]) {
        for (i, g) in out.iter_mut().enumerate() {
            *g = point_gradient(b_from_a, &Vector3::zeros(), &Vector3::ith(i, 1.0));
        }
    }
    fn hessian(&self, b_from_a: &Pose, weights: &[f64]) -> Matrix6<f64> {
        point_hessian(
            b_from_a,
            &Vector3::zeros(),
            &Vector3::from_row_slice(weights),
        )
    }
}
