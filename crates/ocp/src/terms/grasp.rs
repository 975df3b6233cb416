//! Strength of a bilateral grasp: |f| ≤ f_max and |m| ≤ m_max.
//!
//! Source: formulation 2.6; the paper bounds no grasp.

use super::{ForceHessian, ForceTerm};
use nalgebra::{Matrix3, Vector6};
use spatial::Pose;

/// Two rows: 1 − |f|²/f_max² ≥ 0 and, with moments, 1 − |m|²/m_max² ≥ 0.
#[derive(Debug)]
pub struct Grasp {
    /// f_max [N].
    pub max_force: f64,
    /// m_max [N·m]; `None` for a grasp that transmits no moment.
    pub max_moment: Option<f64>,
}

impl Grasp {
    fn limits(&self) -> impl Iterator<Item = (usize, f64)> {
        std::iter::once((0, self.max_force)).chain(self.max_moment.map(|m| (3, m)))
    }
}

impl ForceTerm for Grasp {
    fn name(&self) -> &'static str {
        "grasp strength"
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        self.limits().map(|_| (0.0, f64::INFINITY)).collect()
    }
    fn values(&self, _: &Pose, w: &Vector6<f64>, out: &mut [f64]) {
        for (o, (first, limit)) in out.iter_mut().zip(self.limits()) {
            *o = 1.0 - w.fixed_rows::<3>(first).norm_squared() / (limit * limit);
        }
    }
    fn gradients(&self, _: &Pose, w: &Vector6<f64>, out: &mut [(Vector6<f64>, Vector6<f64>)]) {
        for (o, (first, limit)) in out.iter_mut().zip(self.limits()) {
            let mut g = Vector6::zeros();
            g.fixed_rows_mut::<3>(first)
                .copy_from(&(w.fixed_rows::<3>(first) * (-2.0 / (limit * limit))));
            *o = (Vector6::zeros(), g);
        }
    }
    fn hessian(&self, _: &Pose, _: &Vector6<f64>, weights: &[f64]) -> ForceHessian {
        let mut out = ForceHessian::zero();
        for (weight, (first, limit)) in weights.iter().zip(self.limits()) {
            let block = Matrix3::identity() * (-2.0 * weight / (limit * limit));
            out.wrench
                .fixed_view_mut::<3, 3>(first, first)
                .copy_from(&block);
        }
        out
    }
}
