//! Patch alignment: the normals of two patches in contact are opposite.
//!
//! Source: paper, eq. (patch_patch_orientation), first part, log₃(ʲR_i)_xy = 0.
//! **Departs:** interface normals point outward on both sides (formulation, section 1), so the normal of a is −z of b;
//! and two entries of the rotation replace the logarithm, which has the same zeros and is singular at a half turn. A
//! third row keeps the solution in which the normals are opposite, not equal.

use super::PoseTerm;
use super::pose_functions::{direction_gradient, direction_hessian};
use nalgebra::{Matrix6, Vector3, Vector6};
use spatial::Pose;

/// Smallest cosine between the normal of a and −z of b; only guards the choice of the branch.
const BRANCH: f64 = 0.2;

/// (R e_z)_x = (R e_z)_y = 0, −(R e_z)_z ≥ 0.2 [rad to first order].
#[derive(Debug)]
pub struct Alignment;

fn directions() -> [Vector3<f64>; 3] {
    [Vector3::x(), Vector3::y(), -Vector3::z()]
}

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
        out.copy_from_slice(&[normal.x, normal.y, -normal.z]);
    }
    fn gradients(&self, b_from_a: &Pose, out: &mut [Vector6<f64>]) {
        for (g, u) in out.iter_mut().zip(directions()) {
            *g = direction_gradient(b_from_a, &Vector3::z(), &u);
        }
    }
    fn hessian(&self, b_from_a: &Pose, weights: &[f64]) -> Matrix6<f64> {
        let u = directions().iter().zip(weights).map(|(u, w)| u * *w).sum();
        direction_hessian(b_from_a, &Vector3::z(), &u)
    }
}
