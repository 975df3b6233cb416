//! Tilt cost: 1 − cos of the angle between the body's z axis and the vertical.
//!
//! Source: ours, a posture term ("φ" of eq. (TAMP)); half the square of the tilt for small angles.

use super::PoseTerm;
use super::pose_functions::{direction_gradient, direction_hessian};
use nalgebra::{Matrix6, Vector3, Vector6};
use spatial::Pose;

/// 1 − (R e_z)_z.
#[derive(Debug)]
pub struct Tilt;

impl PoseTerm for Tilt {
    fn name(&self) -> &'static str {
        "tilt"
    }
    fn unit(&self) -> &'static str {
        "rad²/2"
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        vec![(f64::NEG_INFINITY, f64::INFINITY)]
    }
    fn values(&self, b_from_a: &Pose, out: &mut [f64]) {
        out[0] = 1.0 - b_from_a.rotation()[(2, 2)];
    }
    fn gradients(&self, b_from_a: &Pose, out: &mut [Vector6<f64>]) {
        out[0] = -direction_gradient(b_from_a, &Vector3::z(), &Vector3::z());
    }
    fn hessian(&self, b_from_a: &Pose, weights: &[f64]) -> Matrix6<f64> {
        direction_hessian(b_from_a, &Vector3::z(), &Vector3::z()) * -weights[0]
    }
}
