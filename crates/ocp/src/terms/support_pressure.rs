//! Centre of pressure inside the supporting patch b, where a may overhang it.
//!
//! Source: formulation 2.4 and 2.5. The centre of pressure is (m_y, −m_x)/f_n in a's plane, f_n = −f_z; in b's plane it
//! is r + R (m_y, −m_x, 0)/f_n, and each of its coordinates stays within ξ_b.

use super::pose_functions::{direction_gradient, direction_hessian, point_gradient, point_hessian};
use super::{ForceHessian, ForceTerm};
use nalgebra::{Matrix6, Vector3, Vector6};
use spatial::Pose;

/// Four rows ≥ 0: f_n ξ_b ∓ (f_n r + R (m_y, −m_x, 0)) [N·m / scale].
#[derive(Debug)]
pub struct SupportPressure {
    /// Half extents of b [m].
    pub half_size: [f64; 2],
    /// Moment that counts as one [N·m].
    pub scale: f64,
}

fn arm(w: &Vector6<f64>) -> Vector3<f64> {
    Vector3::new(w[4], -w[3], 0.0)
}

/// Gradient by the moment of (R (m_y, −m_x, 0))_i.
fn moment_gradient(x: &Pose, i: usize) -> Vector6<f64> {
    let rot = x.rotation();
    Vector6::new(0.0, 0.0, 0.0, -rot[(i, 1)], rot[(i, 0)], 0.0)
}

/// Calls `row(number, axis, sign)` for the four rows.
fn for_each_row(mut row: impl FnMut(usize, usize, f64)) {
    for i in 0..2 {
        row(2 * i, i, -1.0);
        row(2 * i + 1, i, 1.0);
    }
}

impl ForceTerm for SupportPressure {
    fn name(&self) -> &'static str {
        "centre of pressure"
    }
    fn uses_pose(&self) -> bool {
        true
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        vec![(0.0, f64::INFINITY); 4]
    }
    fn values(&self, x: &Pose, w: &Vector6<f64>, out: &mut [f64]) {
        let (r, turned, normal) = (x.origin(), x.rotate(arm(w)), -w[2]);
        for_each_row(|row, i, sign| {
            out[row] =
                (normal * self.half_size[i] + sign * (normal * r[i] + turned[i])) / self.scale;
        });
    }
    fn gradients(&self, x: &Pose, w: &Vector6<f64>, out: &mut [(Vector6<f64>, Vector6<f64>)]) {
        let (r, normal) = (x.origin(), -w[2]);
        for_each_row(|row, i, sign| {
            let u = Vector3::ith(i, 1.0);
            let pose = point_gradient(x, &Vector3::zeros(), &u) * normal
                + direction_gradient(x, &arm(w), &u);
            let mut wrench = moment_gradient(x, i) * sign;
            wrench[2] = -(self.half_size[i] + sign * r[i]);
            out[row] = (pose * (sign / self.scale), wrench / self.scale);
        });
    }
    fn hessian(&self, x: &Pose, w: &Vector6<f64>, weights: &[f64]) -> ForceHessian {
        let normal = -w[2];
        let mut out = ForceHessian::zero();
        for_each_row(|row, i, sign| {
            let weight = weights[row] * sign / self.scale;
            let u = Vector3::ith(i, 1.0);
            out.pose += (point_hessian(x, &Vector3::zeros(), &u) * normal
                + direction_hessian(x, &arm(w), &u))
                * weight;
            let mut mixed = Matrix6::zeros();
            mixed.set_column(2, &-point_gradient(x, &Vector3::zeros(), &u));
            mixed.set_column(3, &-direction_gradient(x, &Vector3::y(), &u));
            mixed.set_column(4, &direction_gradient(x, &Vector3::x(), &u));
            out.mixed += mixed * weight;
        });
        out
    }
}
