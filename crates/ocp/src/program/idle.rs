//! Objects that nothing touches but the level surface they stand on: what bears them is known.
//!
//! With z of the lower surface along −g, and r the centre of mass in it, the wrench is f = (0, 0, −m g), τ = r × f, whatever
//! the turn about the vertical. In a motion it is no unknown then, and the object has no equations of motion.

use super::{Builder, Phase};
use nalgebra::Vector3;
use scene::Owner;
use symbolic::{Contact, ContactType};

/// Largest sine between a surface and the horizontal that counts as level.
const LEVEL: f64 = 1e-9;

impl Builder<'_> {
    /// Finds such objects in every interval, once it is known where they rest.
    pub(super) fn idle(&mut self, phases: &[Phase]) {
        for t in 0..self.program.intervals.len() {
            let objects = 0..self.scene.objects.len();
            let idle = objects.filter(|&o| self.is_idle(o, t, phases)).collect();
            self.program.intervals[t].idle = idle;
        }
    }

    fn is_idle(&self, object: usize, t: usize, phases: &[Phase]) -> bool {
        let (p, n) = (&self.program, self.program.n_intervals());
        let owner = |i: symbolic::InterfaceId| self.scene.interfaces[i.0].owner;
        let own = Owner::Object(object);
        let state = &phases[p.phase_of(t)].state;
        let mut touching = state
            .iter()
            .filter(|c| owner(c.a) == own || owner(c.b) == own);
        let (Some(contact), None) = (touching.next(), touching.next()) else {
            return false;
        };
        // Accelerations reach two nodes ahead.
        let stays = (t + 1..=(t + 2).min(n)).all(|node| p.rests.stays(object, node));
        stays
            && owner(contact.a) == own
            && contact.kind == ContactType::UnilateralPatch
            && self.is_level(contact, t)
            && self.ramp(t, contact, phases) >= 1.0
            && self.is_borne(object, contact)
    }

    /// True if what bears a contact is at rest since the start and level.
    fn is_level(&self, contact: Contact, t: usize) -> bool {
        let b = &self.scene.interfaces[contact.b.0];
        let still = match b.owner {
            Owner::Static(_) => true,
            Owner::Object(o) => self.program.rests.since(o, t) == Some(0),
            Owner::Robot { .. } => false,
        };
        let placed = self
            .program
            .system
            .world_from_interface(b, &self.start)
            .rotate(Vector3::z());
        let up = -self.scene.gravity.normalize();
        still && placed.dot(&up) > 0.0 && placed.cross(&up).norm() < LEVEL
    }

    /// True if a level surface can bear the object as the rows of its wrench demand.
    fn is_borne(&self, object: usize, contact: Contact) -> bool {
        let [a, b] = [contact.a, contact.b].map(|i| &self.scene.interfaces[i.0]);
        let wrench = self.weight(object, contact);
        let share = self.program.settings.margins.support;
        let inside = a.half_size.is_none_or(|[x, y]| {
            let at = [-wrench[4] / wrench[2], wrench[3] / wrench[2]];
            at[0].abs() <= share * x && at[1].abs() <= share * y
        });
        inside && !b.overhang && -wrench[2] <= a.max_force.min(b.max_force)
    }

    /// The wrench that bears an object on a level surface, at its interface [N, N·m].
    pub(super) fn weight(&self, object: usize, contact: Contact) -> [f64; 6] {
        let from_centre = &self.scene.interfaces[contact.a.0].body_from_interface;
        let weight = self.scene.objects[object].mass * self.scene.gravity.norm();
        let force = -weight * Vector3::z();
        let moment = from_centre.inverse().origin().cross(&force);
        [0.0, 0.0, force.z, moment.x, moment.y, 0.0]
    }
}
