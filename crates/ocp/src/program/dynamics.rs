//! Rows of every interval that no contact makes: equations of motion with torque limits, and velocity limits.

use super::label::label;
use super::{Builder, RowLabel, Subject};
use multibody::JointKind;
use solver::BlockStructure;

impl Builder<'_> {
    /// Rows of M a + b − Σ Jᵀλ: base and objects zero, joints within the torque limits; with `momentum` the base's six are
    /// those of the robot's momentum. The first blocks of the element: the robot's rows, then each object's.
    pub(super) fn equations_of_motion(&mut self, t: usize) {
        if !self.program.intervals[t].dynamics {
            return;
        }
        let p = &mut self.program;
        let share = p.settings.margins.torque;
        let idle: Vec<usize> = (p.intervals[t].idle.iter())
            .map(|&o| p.system.object_joint(o))
            .collect();
        for (j, joint) in p.system.model.joints.iter().enumerate() {
            let free = joint.kind == JointKind::FreeFlyer;
            for k in 0..joint.kind.nv() {
                let i = joint.idx_v + k;
                let bound = if idle.contains(&j) {
                    f64::INFINITY
                } else if free {
                    0.0
                } else if p.settings.torque_limits && joint.torque_limit.is_finite() {
                    share
                } else {
                    f64::INFINITY
                };
                let element = &mut p.structure.elements[t];
                element.row_lower.push(-bound);
                element.row_upper.push(bound);
                let (category, unit) = match (free, p.momentum && i < 6, k < 3) {
                    (false, ..) => ("torque limit", "N m"),
                    (true, true, true) => ("momentum", "N s"),
                    (true, true, false) => ("momentum", "N m s"),
                    (true, false, true) => ("equations of motion", "N"),
                    (true, false, false) => ("equations of motion", "N m"),
                };
                let label = label(category, Subject::Coordinate(i), p.dynamics_scale[i], unit);
                self.labels[t].push(label);
            }
        }
        for rows in p.system.motion_blocks() {
            p.structure.elements[t].blocks.push(BlockStructure {
                first_row: rows.start,
                n_rows: rows.len(),
                cols: vec![],
            });
        }
    }

    /// One row and block per actuated joint.
    pub(super) fn velocity_limits(&mut self, t: usize) {
        let p = &mut self.program;
        if !p.intervals[t].dynamics || !p.intervals[t].v || p.has_velocities() {
            return;
        }
        let share = p.settings.margins.velocity;
        let element = &mut p.structure.elements[t];
        p.intervals[t].velocity_rows = Some(element.n_rows());
        p.intervals[t].velocity_block = element.blocks.len();
        for joint in p.system.actuated() {
            let limit = if joint.velocity_limit.is_finite() {
                share
            } else {
                f64::INFINITY
            };
            let first_row = element.n_rows();
            element.row_lower.push(-limit);
            element.row_upper.push(limit);
            element.blocks.push(BlockStructure {
                first_row,
                n_rows: 1,
                cols: vec![],
            });
            self.labels[t].push(RowLabel {
                category: "joint velocity",
                subject: Subject::Coordinate(joint.idx_v),
                scale: joint.velocity_limit.min(1e3),
                unit: "rad/s",
            });
        }
    }
}
