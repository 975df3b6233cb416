//! Goal tilt: the z axis of a body is at most so far from the vertical at the end.
//!
//! Source: paper, eq. (TAMP), x_N ∈ X_goal. With φ the tilt and φ_max its limit the row is (1 − cos φ)/sin φ_max ≤
//! tan(φ_max/2), which is smooth at φ = 0 and grows like φ at the limit, so that a violation reads in radians.

use super::PoseTerm;
use super::tilt::Tilt;
use nalgebra::{Matrix6, Vector6};
use spatial::Pose;

/// One row [rad].
#[derive(Debug)]
pub struct TiltLimit {
    /// φ_max, above zero and at most a right angle [rad].
    pub max: f64,
}

impl PoseTerm for TiltLimit {
    fn name(&self) -> &'static str {
        "goal tilt"
    }
    fn unit(&self) -> &'static str {
        "rad"
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        vec![(f64::NEG_INFINITY, (self.max / 2.0).tan())]
    }
    fn values(&self, b_from_a: &Pose, out: &mut [f64]) {
        Tilt.values(b_from_a, out);
        out[0] /= self.max.sin();
    }
    fn gradients(&self, b_from_a: &Pose, out: &mut [Vector6<f64>]) {
        Tilt.gradients(b_from_a, out);
        out[0] /= self.max.sin();
    }
    fn hessian(&self, b_from_a: &Pose, weights: &[f64]) -> Matrix6<f64> {
        Tilt.hessian(b_from_a, &[weights[0] / self.max.sin()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_at_the_limit_is_at_the_bound_and_a_little_more_exceeds_it_by_that() {
        let limit = TiltLimit { max: 0.3 };
        let bound = limit.bounds()[0].1;
        let value = |angle: f64| {
            let mut out = [0.0];
            let turn = Vector6::new(0.0, 0.0, 0.0, angle, 0.0, 0.0);
            limit.values(&Pose::exp(&turn), &mut out);
            out[0]
        };
        assert!((value(0.3) - bound).abs() < 1e-15);
        assert!((value(0.301) - bound - 0.001).abs() < 1e-5);
        assert_eq!(value(0.0), 0.0);
    }
}
