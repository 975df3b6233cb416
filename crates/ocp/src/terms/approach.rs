//! Approach cost: an interface that is about to touch, or has just let go, keeps off the other surface along its normal.
//!
//! With p = ʲr_i and the wanted distance h: ½ max(0, h − p_z)² for what lands, and for what is led to the place of contact c, as hands
//! are, half the squared distance from the point above it, ½ ((p_z − h)² + (p_x − c_x)² + (p_y − c_y)²).
//!
//! Source: ours; shapes the path that guides the optimiser, no part of its problem.

use super::PoseTerm;
use super::pose_functions::{point_gradient, point_hessian, point_jacobian};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use spatial::Pose;

/// One row [m²].
#[derive(Debug)]
pub struct Approach {
    /// Wanted distance h [m].
    pub distance: f64,
    /// Place of contact c above which to come to that distance [m]; `None` to stay beyond the plane.
    pub above: Option<[f64; 2]>,
}

impl Approach {
    /// Difference to what is wanted, in axes of b.
    fn difference(&self, p: &Vector3<f64>) -> Vector3<f64> {
        let z = p.z - self.distance;
        match self.above {
            Some([x, y]) => Vector3::new(p.x - x, p.y - y, z),
            None => Vector3::new(0.0, 0.0, z.min(0.0)),
        }
    }
}

impl PoseTerm for Approach {
    fn name(&self) -> &'static str {
        "approach"
    }
    fn unit(&self) -> &'static str {
        "m²"
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        vec![(f64::NEG_INFINITY, f64::INFINITY)]
    }
    fn values(&self, b_from_a: &Pose, out: &mut [f64]) {
        out[0] = 0.5 * self.difference(&b_from_a.origin()).norm_squared();
    }
    fn gradients(&self, b_from_a: &Pose, out: &mut [Vector6<f64>]) {
        let difference = self.difference(&b_from_a.origin());
        out[0] = point_gradient(b_from_a, &Vector3::zeros(), &difference);
    }
    fn hessian(&self, b_from_a: &Pose, weights: &[f64]) -> Matrix6<f64> {
        let difference = self.difference(&b_from_a.origin());
        let counts = if self.above.is_some() {
            Vector3::repeat(1.0)
        } else {
            Vector3::new(0.0, 0.0, if difference.z < 0.0 { 1.0 } else { 0.0 })
        };
        let j = point_jacobian(b_from_a, &Vector3::zeros());
        let square = j.transpose() * Matrix3::from_diagonal(&counts) * j;
        (square + point_hessian(b_from_a, &Vector3::zeros(), &difference)) * weights[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_foot_above_the_wanted_height_costs_nothing_and_a_hand_beside_it_does() {
        let high = Pose::from_translation(0.1, 0.0, 0.2);
        let mut out = [f64::NAN];
        let lands = Approach {
            distance: 0.05,
            above: None,
        };
        lands.values(&high, &mut out);
        assert!(out[0].abs() < 1e-15);
        lands.values(&Pose::from_translation(0.1, 0.0, 0.0), &mut out);
        assert!((out[0] - 0.5 * 0.05 * 0.05).abs() < 1e-15);
        let reaches = Approach {
            distance: 0.2,
            above: Some([0.0, 0.0]),
        };
        reaches.values(&high, &mut out);
        assert!((out[0] - 0.005).abs() < 1e-15);
        let beside = Approach {
            above: Some([0.1, 0.2]),
            ..reaches
        };
        beside.values(&high, &mut out);
        assert!((out[0] - 0.02).abs() < 1e-15);
    }
}
