//! The configuration manifold: neutral element, q ⊕ δ, q₁ ⊖ q₀, random configurations.

use crate::{JointKind, Model};
use nalgebra::Vector6;
use spatial::{Pose, Random};
use std::f64::consts::PI;

/// Random positions stay within ± this, whatever the limits [rad or m].
const WIDEST_RANGE: f64 = PI;

impl Model {
    /// All zeros, no rotation of the base.
    pub fn neutral(&self) -> Vec<f64> {
        let mut q = vec![0.0; self.nq];
        for joint in &self.joints {
            if joint.kind == JointKind::FreeFlyer {
                q[joint.idx_q + 6] = 1.0;
            }
        }
        q
    }

    /// q ⊕ δ: the configuration after one unit of time with the constant velocity `dv`.
    ///
    /// # Panics
    /// If `q` or `dv` has the wrong length.
    #[must_use]
    pub fn integrate(&self, q: &[f64], dv: &[f64]) -> Vec<f64> {
        let mut out = vec![f64::NAN; self.nq];
        self.integrate_into(q, dv, &mut out);
        out
    }

    /// [`Model::integrate`] into a given slice. The quaternion is normalised, on the side of the one in `q`.
    ///
    /// # Panics
    /// If `q`, `dv` or `out` has the wrong length.
    pub fn integrate_into(&self, q: &[f64], dv: &[f64], out: &mut [f64]) {
        self.integrate_scaled_into(q, dv, 1.0, out);
    }

    /// q ⊕ step · δ, as [`Model::integrate_into`].
    ///
    /// # Panics
    /// If `q`, `dv` or `out` has the wrong length.
    pub fn integrate_scaled_into(&self, q: &[f64], dv: &[f64], step: f64, out: &mut [f64]) {
        assert_eq!(
            (q.len(), dv.len(), out.len()),
            (self.nq, self.nv, self.nq),
            "lengths of q, dv, out"
        );
        self.integrate_by_into(q, |i| step * dv[i], out);
    }

    /// q ⊕ δ, with δ by velocity index.
    ///
    /// # Panics
    /// If `q` or `out` is too short.
    pub fn integrate_by_into(&self, q: &[f64], dv: impl Fn(usize) -> f64, out: &mut [f64]) {
        for joint in &self.joints {
            let (i, k) = (joint.idx_q, joint.idx_v);
            if joint.kind == JointKind::FreeFlyer {
                let xi = Vector6::from_fn(|row, _| dv(k + row));
                let mut moved = base_pose(&q[i..]).plus(&xi).to_xyzquat();
                let same_side: f64 = (3..7).map(|c| moved[c] * q[i + c]).sum();
                if same_side < 0.0 {
                    moved[3..].iter_mut().for_each(|c| *c = -*c);
                }
                out[i..i + 7].copy_from_slice(&moved);
            } else {
                out[i] = q[i] + dv(k);
            }
        }
    }

    /// q₁ ⊖ q₀: the velocity that leads from `q0` to `q1` in one unit of time.
    ///
    /// # Panics
    /// If `q0` or `q1` has the wrong length.
    pub fn difference(&self, q0: &[f64], q1: &[f64]) -> Vec<f64> {
        let mut out = vec![f64::NAN; self.nv];
        self.difference_into(q0, q1, &mut out);
        out
    }

    /// [`Model::difference`] into a given slice.
    ///
    /// # Panics
    /// If `q0`, `q1` or `out` has the wrong length.
    pub fn difference_into(&self, q0: &[f64], q1: &[f64], out: &mut [f64]) {
        assert_eq!(
            (q0.len(), q1.len(), out.len()),
            (self.nq, self.nq, self.nv),
            "lengths of q0, q1, out"
        );
        for joint in &self.joints {
            let (i, k) = (joint.idx_q, joint.idx_v);
            if joint.kind == JointKind::FreeFlyer {
                let xi = base_pose(&q1[i..]).minus(&base_pose(&q0[i..]));
                out[k..k + 6].copy_from_slice(xi.as_slice());
            } else {
                out[k] = q1[i] - q0[i];
            }
        }
    }

    /// A random configuration within the limits, the same for the same seed; base within 1 m, joints within ±π.
    pub fn random_configuration(&self, seed: u64) -> Vec<f64> {
        let mut random = Random::new(seed);
        let mut q = vec![0.0; self.nq];
        for joint in &self.joints {
            let i = joint.idx_q;
            if joint.kind == JointKind::FreeFlyer {
                q[i..i + 7].copy_from_slice(&Pose::random(seed).to_xyzquat());
            } else {
                let lower = (-WIDEST_RANGE).clamp(joint.lower, joint.upper);
                let upper = WIDEST_RANGE.clamp(joint.lower, joint.upper);
                q[i] = random.uniform(lower, upper);
            }
        }
        q
    }
}

/// Pose of a free flyer from its seven entries of q.
#[inline]
pub(crate) fn base_pose(q: &[f64]) -> Pose {
    Pose::from_xyzquat(&[q[0], q[1], q[2], q[3], q[4], q[5], q[6]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Root;

    #[test]
    fn integrate_and_difference_undo_each_other() {
        for seed in 0..10 {
            let model = Model::random(seed, Root::Floating, 8);
            let (q0, q1) = (
                model.random_configuration(seed),
                model.random_configuration(seed + 50),
            );
            let again = model.integrate(&q0, &model.difference(&q0, &q1));
            let gap = model.difference(&q1, &again);
            assert!(gap.iter().all(|x| x.abs() < 1e-12), "{gap:?}");
        }
    }

    #[test]
    fn a_scaled_increment_is_the_increment_scaled() {
        let model = Model::random(2, Root::Floating, 5);
        let q = model.random_configuration(2);
        let (whole, half) = (vec![0.4; model.nv], vec![0.2; model.nv]);
        let mut out = vec![f64::NAN; model.nq];
        model.integrate_scaled_into(&q, &whole, 0.5, &mut out);
        assert_eq!(out, model.integrate(&q, &half));
    }

    #[test]
    fn a_turned_base_slides_along_its_own_axis() {
        let model = Model::random(1, Root::Floating, 1);
        let mut q = model.neutral();
        let half = 0.5f64.sqrt();
        q[..7].copy_from_slice(&[1.0, 0.0, 0.0, 0.0, 0.0, half, half]);
        let moved = model.integrate(&q, &[0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1]);
        assert!((moved[0] - 1.0).abs() < 1e-15 && (moved[1] - 0.3).abs() < 1e-15);
        assert_eq!(moved[7], 0.1);
    }

    #[test]
    fn quaternions_stay_on_their_side() {
        let model = Model::random(1, Root::Floating, 1);
        let mut q = model.neutral();
        q[6] = -1.0;
        assert!(model.integrate(&q, &[0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0])[6] < 0.0);
    }

    #[test]
    fn random_configurations_respect_limits() {
        let model = Model::random(3, Root::Fixed, 6);
        let q = model.random_configuration(9);
        assert!(
            model
                .joints
                .iter()
                .all(|joint| (joint.lower..=joint.upper).contains(&q[joint.idx_q]))
        );
    }
}
