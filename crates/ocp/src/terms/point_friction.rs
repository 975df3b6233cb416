//! Friction cone of a point contact, whose orientation is free: the force is turned into b's axes.
//!
//! Source: paper, eq. (unilateral): |(ʲf)_xy| ≤ μ (ʲf)_z, (ʲf)_z ≥ 0, ʲκ = 0. The cone's form is that of `friction.rs`.

use super::friction::cone;
use super::{ForceHessian, ForceTerm};
use nalgebra::{Matrix3, Vector3, Vector6};
use spatial::{Pose, skew};

/// Two rows ≥ 0: the cone and the normal force [N / scale].
#[derive(Debug)]
pub struct PointFriction {
    /// Sliding friction coefficient.
    pub mu: f64,
    /// ε of the cone [N].
    pub epsilon: f64,
    /// Force that counts as one [N].
    pub scale: f64,
}

impl PointFriction {
    /// Per row: value, gradient and Hessian by the force in b.
    fn rows(&self, x: &Pose, w: &Vector6<f64>) -> [(f64, Vector3<f64>, Matrix3<f64>); 2] {
        let f = x.rotate(w.fixed_rows::<3>(0).into_owned());
        let (v, g, h) = cone([f.x, f.y], f.z, self.mu, self.epsilon);
        let s = self.scale;
        [
            (v / s, g / s, h / s),
            (f.z / s, Vector3::z() / s, Matrix3::zeros()),
        ]
    }
}

impl ForceTerm for PointFriction {
    fn name(&self) -> &'static str {
        "friction cone"
    }
    fn uses_pose(&self) -> bool {
        true
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        vec![(0.0, f64::INFINITY); 2]
    }
    fn values(&self, x: &Pose, w: &Vector6<f64>, out: &mut [f64]) {
        for (o, row) in out.iter_mut().zip(self.rows(x, w)) {
            *o = row.0;
        }
    }
    fn gradients(&self, x: &Pose, w: &Vector6<f64>, out: &mut [(Vector6<f64>, Vector6<f64>)]) {
        let force = w.fixed_rows::<3>(0).into_owned();
        for (o, row) in out.iter_mut().zip(self.rows(x, w)) {
            let u = x.rotate_inverse(row.1);
            let turn = force.cross(&u);
            *o = (
                Vector6::new(0.0, 0.0, 0.0, turn.x, turn.y, turn.z),
                Vector6::new(u.x, u.y, u.z, 0.0, 0.0, 0.0),
            );
        }
    }
    fn hessian(&self, x: &Pose, w: &Vector6<f64>, weights: &[f64]) -> ForceHessian {
        let force = w.fixed_rows::<3>(0).into_owned();
        let rot = x.rotation();
        // R exp(ω) f = R(f + ω×f + …): increments of the force in b are R(φ − [f]× ω), f → f + φ.
        let by_turn = -rot * skew(&force);
        let mut out = ForceHessian::zero();
        for (row, weight) in self.rows(x, w).iter().zip(weights) {
            let (g, h) = (row.1 * *weight, row.2 * *weight);
            let u = rot.tr_mul(&g);
            let outer = u * force.transpose();
            let curvature = (outer + outer.transpose()) * 0.5 - Matrix3::identity() * u.dot(&force);
            let turn = by_turn.transpose() * h * by_turn + curvature;
            // ∂/∂φ of ω·(f × u) = φ·(u × ω): the mixed block is −[u]×… as rows ω, columns φ.
            let mixed = by_turn.transpose() * h * rot - skew(&u);
            let force_block = rot.transpose() * h * rot;
            let add = |m: &mut nalgebra::Matrix6<f64>, i: usize, j: usize, b: Matrix3<f64>| {
                let mut view = m.fixed_view_mut::<3, 3>(i, j);
                view += b;
            };
            add(&mut out.pose, 3, 3, turn);
            add(&mut out.mixed, 3, 0, mixed);
            add(&mut out.wrench, 0, 0, force_block);
        }
        out
    }
}
