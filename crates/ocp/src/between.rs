//! What the equations of motion say between the nodes, with acceleration and wrenches held.
//!
//! At time s after node t: q(s) = q ⊕ s (β v + γ v(s)), v(s) = v + a s ([`crate::Integrator::shares`]), the wrenches of the
//! interval in the axes of their interfaces a.

use crate::point::Point;
use crate::problem::{Trajectory, physical_wrench};
use multibody::JointKind;

/// Largest residuals between nodes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Between {
    /// Force that is missing at the robot's base [N].
    pub base_force: f64,
    /// Moment that is missing at the robot's base [N m].
    pub base_moment: f64,
    /// Force that is missing at an object [N].
    pub object_force: f64,
    /// Largest torque over its limit.
    pub torque_share: f64,
    /// Largest change of a torque within an interval [N m].
    pub torque_change: f64,
}

impl Between {
    /// The larger of each.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            base_force: self.base_force.max(other.base_force),
            base_moment: self.base_moment.max(other.base_moment),
            object_force: self.object_force.max(other.object_force),
            torque_share: self.torque_share.max(other.torque_share),
            torque_change: self.torque_change.max(other.torque_change),
        }
    }
}

impl Trajectory {
    /// Samples the motion every `step` seconds.
    pub fn between(&mut self, x: &Point, step: f64) -> Between {
        let intervals = 0..self.program.n_intervals();
        intervals.fold(Between::default(), |most, t| {
            most.max(self.between_of(x, t, step))
        })
    }

    /// The same of interval `t`.
    pub fn between_of(&mut self, x: &Point, t: usize, step: f64) -> Between {
        let mut found = Between::default();
        let (beta, gamma) = self.program.settings.integrator.shares();
        let mut kinematics = multibody::Kinematics::new(&self.program.system.model);
        let mut relatives: Vec<_> = (self.program.frames.iter())
            .map(crate::relative::RelativeFrame::relative)
            .collect();
        let (v, a) = self.velocity_and_acceleration(x, t);
        let at_node = self.torques(x, t);
        let samples = (self.dt(x, t) / step).floor() as usize;
        for k in 0..=samples {
            let s = k as f64 * step;
            let program = &self.program;
            let model = &program.system.model;
            let speed: Vec<f64> = v.iter().zip(&a).map(|(v, a)| v + a * s).collect();
            let moved: Vec<f64> = v
                .iter()
                .zip(&speed)
                .map(|(v, now)| s * (beta * v + gamma * now))
                .collect();
            kinematics.update(model, &model.integrate(&x.nodes[t], &moved));
            let mut tau = self.scratches[0]
                .rnea
                .compute(model, &kinematics, &speed, &a)
                .to_vec();
            for force in &program.intervals[t].forces {
                let frame = &program.frames[force.frame];
                let relative = &mut relatives[force.frame];
                frame.update(&kinematics, relative);
                let wrench = physical_wrench(force, &x.wrenches[t]);
                for (&col, column) in frame.cols.iter().zip(&relative.columns) {
                    tau[col] -= column.dot(&wrench);
                }
            }
            self.note(&tau, &at_node, &mut found);
        }
        found
    }

    fn note(&self, tau: &[f64], at_node: &[f64], found: &mut Between) {
        let system = &self.program.system;
        for (j, joint) in system.model.joints.iter().enumerate() {
            let i = joint.idx_v;
            if joint.kind == JointKind::FreeFlyer {
                let norm = |part: &[f64]| part.iter().map(|x| x * x).sum::<f64>().sqrt();
                if j < system.n_robot_joints {
                    found.base_force = found.base_force.max(norm(&tau[i..i + 3]));
                    found.base_moment = found.base_moment.max(norm(&tau[i + 3..i + 6]));
                } else {
                    found.object_force = found.object_force.max(norm(&tau[i..i + 3]));
                }
            } else {
                found.torque_change = found.torque_change.max((tau[i] - at_node[i]).abs());
                if joint.torque_limit.is_finite() {
                    let share = tau[i].abs() / joint.torque_limit.max(1e-9);
                    found.torque_share = found.torque_share.max(share);
                }
            }
        }
    }
}
