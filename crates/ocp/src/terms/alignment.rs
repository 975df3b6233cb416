//! Patch alignment: the normals of two patches in contact are opposite.
//!
//! Source: paper, eq. (patch_patch_orientation), first part, log₃(ʲR_i)_xy = 0.
//! **Departs:** interface normals point outward on both sides (formulation, section 1), so the normal of a is −z of b.
//! With n = ʲR_i e_z the rows are (2 + δ) n_xy / (1 + δ − n_z): the logarithm's zeros without its singularity at a half
//! turn, and, like 2 tan(θ/2), steeper the larger the angle; n_xy itself is flat at a right angle, where a palm often
//! starts. A third row keeps the solution in which the normals are opposite, not equal.

use super::PoseTerm;
use super::pose_functions::{direction_gradient, direction_hessian};
use nalgebra::{Matrix6, Vector3, Vector6};
use spatial::Pose;

/// Smallest cosine between the normal of a and −z of b; only guards the choice of the branch.
const BRANCH: f64 = 0.2;
/// δ.
const BLUNTNESS: f64 = 0.05;

/// Two rows zero, −n_z ≥ 0.2 [rad to first order].
#[derive(Debug)]
pub struct Alignment;

impl PoseTerm for Alignment {
    fn name(&self) -> &'static str {
        "contact alignment"
    }
    fn unit(&self) -> &'static str {
        "rad"
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        vec![(0.0, 0.0), (0.0, 0.0), (BRANCH, f64::INFINITY)]
    }
    fn values(&self, b_from_a: &Pose, out: &mut [f64]) {
        let normal = b_from_a.rotation().column(2);
        let scale = (2.0 + BLUNTNESS) / (1.0 + BLUNTNESS - normal.z);
        out.copy_from_slice(&[scale * normal.x, scale * normal.y, -normal.z]);
    }
    fn gradients(&self, b_from_a: &Pose, out: &mut [Vector6<f64>]) {
        let normal = b_from_a.rotation().column(2);
        let d = 1.0 + BLUNTNESS - normal.z;
        let along = |u| direction_gradient(b_from_a, &Vector3::z(), &u);
        let (x, y, z) = (
            along(Vector3::x()),
            along(Vector3::y()),
            along(Vector3::z()),
        );
        let scale = (2.0 + BLUNTNESS) / d;
        out[0] = (x + z * (normal.x / d)) * scale;
        out[1] = (y + z * (normal.y / d)) * scale;
        out[2] = -z;
    }
    fn hessian(&self, b_from_a: &Pose, weights: &[f64]) -> Matrix6<f64> {
        let normal = b_from_a.rotation().column(2);
        let d = 1.0 + BLUNTNESS - normal.z;
        let scale = (2.0 + BLUNTNESS) / d;
        // Σ w_i n_i of the first two rows, as one direction.
        let side = Vector3::new(weights[0], weights[1], 0.0) * scale;
        let value = side.dot(&normal);
        let along = |u: &Vector3<f64>| direction_gradient(b_from_a, &Vector3::z(), u);
        let (s, z) = (along(&side), along(&Vector3::z()));
        let first = side + Vector3::z() * (value / d - weights[2]);
        direction_hessian(b_from_a, &Vector3::z(), &first)
            + (s * z.transpose() + z * s.transpose()) / d
            + z * z.transpose() * (2.0 * value / (d * d))
    }
}

/// The same rows within bounds: a patch that touches next, or has just let go, is tilted by at most this [rad].
#[derive(Debug)]
pub struct Tilted(pub f64);

impl PoseTerm for Tilted {
    fn name(&self) -> &'static str {
        "contact approach"
    }
    fn unit(&self) -> &'static str {
        "rad"
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        vec![
            (-self.0, self.0),
            (-self.0, self.0),
            (BRANCH, f64::INFINITY),
        ]
    }
    fn values(&self, b_from_a: &Pose, out: &mut [f64]) {
        Alignment.values(b_from_a, out);
    }
    fn gradients(&self, b_from_a: &Pose, out: &mut [Vector6<f64>]) {
        Alignment.gradients(b_from_a, out);
    }
    fn hessian(&self, b_from_a: &Pose, weights: &[f64]) -> Matrix6<f64> {
        Alignment.hessian(b_from_a, weights)
    }
}
