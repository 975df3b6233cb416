//! The place of a contact on its support: in-plane position and, for patches, yaw. Sticking keeps it constant.
//!
//! Source: paper, eq. (patch_patch_position) and (patch_patch_orientation), second parts, in the displacement form of
//! formulation 2.2: r_xy[t+1] = r_xy[t], yaw[t+1] = yaw[t].

use super::PoseTerm;
use super::pose_functions::{point_gradient, point_hessian, yaw, yaw_gradient, yaw_hessian};
use nalgebra::{Matrix6, Vector3, Vector6};
use spatial::Pose;

/// (r_x, r_y) [m] and, if `yaw`, the angle of a's x axis in b's plane [rad].
#[derive(Debug)]
pub struct Place {
    /// True for patches.
    pub yaw: bool,
}

impl Place {
    /// Number of rows.
    pub fn n_rows(&self) -> usize {
        if self.yaw { 3 } else { 2 }
    }

    /// Difference of two places, the yaw wrapped into (−π, π].
    pub fn difference(from: &[f64], to: &[f64], out: &mut [f64]) {
        for i in 0..out.len() {
            out[i] = to[i] - from[i];
        }
        if out.len() == 3 {
            let (s, c) = out[2].sin_cos();
            out[2] = s.atan2(c);
        }
    }
}

impl PoseTerm for Place {
    fn name(&self) -> &'static str {
        "contact slip"
    }
    fn unit(&self) -> &'static str {
        "m"
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        vec![(0.0, 0.0); self.n_rows()]
    }
    fn values(&self, b_from_a: &Pose, out: &mut [f64]) {
        let r = b_from_a.origin();
        out[0] = r.x;
        out[1] = r.y;
        if self.yaw {
            out[2] = yaw(b_from_a);
        }
    }
    fn gradients(&self, b_from_a: &Pose, out: &mut [Vector6<f64>]) {
        out[0] = point_gradient(b_from_a, &Vector3::zeros(), &Vector3::x());
        out[1] = point_gradient(b_from_a, &Vector3::zeros(), &Vector3::y());
        if self.yaw {
            out[2] = yaw_gradient(b_from_a);
        }
    }
    fn hessian(&self, b_from_a: &Pose, weights: &[f64]) -> Matrix6<f64> {
        let mut h = point_hessian(
            b_from_a,
            &Vector3::zeros(),
            &Vector3::new(weights[0], weights[1], 0.0),
        );
        if self.yaw {
            h += yaw_hessian(b_from_a) * weights[2];
        }
        h
    }
}
