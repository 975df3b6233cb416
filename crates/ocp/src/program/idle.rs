//! Objects that nothing touches but the level surface they stand on: what bears them is known.
//!
//! With z of the lower surface along −g, and r the centre of mass in it, the wrench is f = (0, 0, −m g), τ = r × f, whatever
//! the turn about the vertical. In a motion it is no unknown then, and the object has no equations of motion.

use super::{Builder, Phase};
use nalgebra::Vector3;
use scene::{Interface, Owner};
use symbolic::{Contact, ContactType};

/// Largest angle between a surface and the horizontal that counts as level [rad]: an error of so much of the weight.
const LEVEL: f64 = 1e-7;

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
            && self.is_level(object, contact, t)
            && self.ramp(t, contact, phases) >= 1.0
            && self.is_borne(object, contact)
    }

    /// True if what bears an object is at rest since the start and level, and the object on it: at the start it may be tilted by what
    /// scenes are forgiven, later rows have seen to it.
    fn is_level(&self, object: usize, contact: Contact, t: usize) -> bool {
        let p = &self.program;
        let from_start = |o: usize| p.rests.since(o, t) == Some(0);
        let [a, b] = [contact.a, contact.b].map(|i| &self.scene.interfaces[i.0]);
        let still = match b.owner {
            Owner::Static(_) => true,
            Owner::Object(o) => from_start(o),
            Owner::Robot { .. } => false,
        };
        let up = -self.scene.gravity.normalize();
        let faces = |i: &Interface, direction: Vector3<f64>| {
            let placed = p.system.world_from_interface(i, &self.start);
            (placed.rotate(Vector3::z()) - direction).norm() < LEVEL
        };
        still && faces(b, up) && (!from_start(object) || faces(a, -up))
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
