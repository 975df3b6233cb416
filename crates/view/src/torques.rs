//! What a joint can give in an interval: its torque limit, less at speed where the plan says so.
//!
//! Source: `docs/plan-format.md`, "Torque at speed".

use crate::motion::Motion;
use plan::{Integrator, TorqueSpeed};

/// Torque limits of all joints of a plan.
pub(crate) struct TorqueLimits {
    /// Per joint of the plan: largest torque [N m] and whether the plan enforces it; `None`: unlimited.
    pub largest: Vec<Option<(f64, bool)>>,
    /// Per joint how its torque falls with speed; `None`: not at all.
    at_speed: Vec<Option<TorqueSpeed>>,
}

impl TorqueLimits {
    /// The limits that the plan enforces, where it does not those of the URDF.
    pub fn new(motion: &Motion) -> Self {
        let robot = &motion.plan.robot;
        let largest = robot.joints.iter().enumerate().map(|(j, joint)| {
            let enforced = robot.torque_limits.as_ref().and_then(|limits| limits[j]);
            let rated = || {
                let id = motion.model.joint_id(joint)?;
                let limit = motion.model.joints[id].torque_limit;
                limit.is_finite().then_some((limit, false))
            };
            enforced.map(|limit| (limit, true)).or_else(rated)
        });
        let at_speed = robot.joints.iter();
        let at_speed = at_speed.map(|joint| robot.torque_speed.get(joint).copied());
        Self {
            largest: largest.collect(),
            at_speed: at_speed.collect(),
        }
    }

    /// The limit of joint `j` in interval `t` [N m].
    pub fn at(&self, motion: &Motion, j: usize, t: usize) -> Option<f64> {
        let (largest, enforced) = self.largest[j]?;
        let Some(TorqueSpeed { corner, max }) = self.at_speed[j].filter(|_| enforced) else {
            return Some(largest);
        };
        let plan = motion.plan;
        let nodes: &[usize] = match plan.integrator {
            Integrator::Euler => &[t],
            Integrator::SemiImplicitEuler => &[t + 1],
            Integrator::ConstantAcceleration => &[t, t + 1],
        };
        let left = |node: &usize| {
            let speed = plan.v[*node][6 + j] * plan.tau[t][j].signum();
            ((max - speed) / (max - corner).max(1e-9)).clamp(0.0, 1.0)
        };
        Some(largest * nodes.iter().map(left).fold(1.0, f64::min))
    }

    /// Torque over limit of joint `j` in interval `t`; zero without a limit, at most ten.
    pub fn share(&self, motion: &Motion, j: usize, t: usize) -> f64 {
        let torque = motion.plan.tau[t][j].abs();
        let limit = self.at(motion, j, t);
        limit.map_or(0.0, |limit| (torque / limit.max(1e-9)).min(10.0))
    }
}
