//! Rows that tie configurations to velocities, and rest at new contacts, where node velocities are unknowns.

use super::label::label;
use super::{Builder, IntegratorRows, Subject, Touch};
use solver::BlockStructure;
use symbolic::Contact;

/// Displacement over an interval that counts as one [m or rad]: a tolerance of 1e-6 is then 1e-7 m, 5e-6 m/s on a grid of
/// 20 ms.
pub const DISPLACEMENT_SCALE: f64 = 0.1;

impl Builder<'_> {
    /// q⁺ ⊖ q − dt (β v + γ v⁺) = 0 of interval `t`, one block per joint.
    pub(super) fn integrator(&mut self, t: usize) {
        let p = &mut self.program;
        if !p.has_velocities() || !p.moves(t) {
            return;
        }
        let element = &mut p.structure.elements[t];
        p.intervals[t].integrator = Some(IntegratorRows {
            first_row: element.n_rows(),
            first_block: element.blocks.len(),
        });
        for (j, joint) in p.system.model.joints.iter().enumerate() {
            let (first_row, n_rows) = (element.n_rows(), joint.kind.nv());
            // What is at rest has nothing to integrate.
            let object = j.checked_sub(p.system.n_robot_joints);
            let moves = object.is_none_or(|o| !p.rests.stays(o, t + 1));
            let bound = if moves { 0.0 } else { f64::INFINITY };
            for k in 0..n_rows {
                element.row_lower.push(-bound);
                element.row_upper.push(bound);
                let subject = Subject::Coordinate(joint.idx_v + k);
                let unit = if n_rows == 6 && k < 3 { "m" } else { "rad" };
                self.labels[t].push(label("integrator", subject, DISPLACEMENT_SCALE, unit));
            }
            element.blocks.push(BlockStructure {
                first_row,
                n_rows,
                cols: vec![],
            });
        }
    }

    /// The relative velocity of a contact that comes into being at node `t` is zero there (formulation 2.19: no impact).
    pub(super) fn touch_rows(&mut self, t: usize, contact: Contact, frame: usize) {
        self.velocity_rows(t, contact, frame, "contact velocity", [0.0; 3]);
    }

    /// Relative twist of a contact's interfaces at node `t`, of points the velocity only: every component is at most as
    /// large as said: velocities along the surface and along the normal [m/s], angular velocities [rad/s].
    pub(super) fn velocity_rows(
        &mut self,
        t: usize,
        contact: Contact,
        frame: usize,
        category: &'static str,
        limits: [f64; 3],
    ) {
        let n_rows = if contact.kind.is_patch() { 6 } else { 3 };
        let p = &mut self.program;
        let slot = p.nodes[t].slot(frame);
        let element = &mut p.structure.elements[t];
        let (first_row, block) = (element.n_rows(), element.blocks.len());
        for r in 0..n_rows {
            let limit = limits[[0, 0, 1, 2, 2, 2][r]];
            let unit = if r < 3 { "m/s" } else { "rad/s" };
            element.row_lower.push(-limit);
            element.row_upper.push(limit);
            self.labels[t].push(label(category, Subject::Contact(contact), 1.0, unit));
        }
        element.blocks.push(BlockStructure {
            first_row,
            n_rows,
            cols: vec![],
        });
        p.intervals[t].touches.push(Touch {
            slot,
            n_rows,
            first_row,
            block,
        });
    }
}
