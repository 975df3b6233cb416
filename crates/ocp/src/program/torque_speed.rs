//! Rows of torque at speed ([`crate::torque_speed`]), for joints that declare it and may be fast enough for it to matter.

use super::label::label;
use super::{Builder, Subject};
use crate::torque_speed::TorqueSpeedRow;
use solver::BlockStructure;

impl Builder<'_> {
    /// One row per joint and free velocity of the interval, in one block.
    pub(super) fn torque_speed(&mut self, t: usize) {
        let p = &mut self.program;
        if !p.intervals[t].dynamics || !p.settings.torque_speed() {
            return;
        }
        let margins = &p.settings.margins;
        // Shares of the integrator: which of the two node velocities it uses. Those at rest limit nothing.
        let (first, last) = p.settings.integrator.shares();
        let free = if p.has_velocities() {
            [t, t + 1].map(|node| p.nodes[node].velocity_var.is_some())
        } else {
            [p.intervals[t].v, false]
        };
        let used = [
            (false, first > 0.0 && free[0]),
            (true, last > 0.0 && free[1]),
        ];
        let element = &mut p.structure.elements[t];
        let (first_row, mut rows) = (element.n_rows(), Vec::new());
        for joint in p.system.actuated() {
            let Some(curve) = joint
                .torque_speed
                .filter(|_| joint.torque_limit.is_finite())
            else {
                continue;
            };
            if joint.velocity_limit * margins.velocity <= curve.corner {
                continue;
            }
            let slope = margins.torque / (curve.no_load - curve.corner);
            for next in used.iter().filter(|(_, used)| *used).map(|(next, _)| *next) {
                let bound = slope * curve.no_load;
                rows.push(TorqueSpeedRow {
                    row: element.n_rows(),
                    coordinate: joint.idx_v,
                    slope,
                    next,
                });
                element.row_lower.push(-bound);
                element.row_upper.push(bound);
                let subject = Subject::Coordinate(joint.idx_v);
                let scale = p.dynamics_scale[joint.idx_v];
                self.labels[t].push(label("torque at speed", subject, scale, "N m"));
            }
        }
        if rows.is_empty() {
            return;
        }
        p.intervals[t].torque_speed.block = Some(element.blocks.len());
        element.blocks.push(BlockStructure {
            first_row,
            n_rows: rows.len(),
            cols: vec![],
        });
        p.intervals[t].torque_speed.rows = rows;
    }
}
