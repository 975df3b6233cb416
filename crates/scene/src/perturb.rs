//! Random variants of a scene, to see how much a planner depends on its numbers.

use crate::types::{Owner, Scene, Shape};
use nalgebra::Vector3;
use spatial::{Pose, Random};

/// How far a variant may be from its scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Perturbation {
    /// Objects on their supports, in x and in y [m].
    pub position: f64,
    /// Largest factor of a mass, and one over the smallest.
    pub mass: f64,
    /// Heights of static bodies with a surface, those apart on which the robot stands [m].
    pub height: f64,
    /// Share of the friction coefficients of each surface.
    pub friction: f64,
}

impl Default for Perturbation {
    fn default() -> Self {
        Self {
            position: 0.05,
            mass: 2.0,
            height: 0.03,
            friction: 0.2,
        }
    }
}

impl Scene {
    /// The variant that belongs to a seed; objects stay on what they stand on, within its bounds.
    #[must_use]
    pub fn perturbed(&self, perturbation: &Perturbation, seed: u64) -> Self {
        let mut scene = self.clone();
        let mut random = Random::new(seed);
        let mut around = |most: f64| random.uniform(-most, most);
        for object in &mut scene.objects {
            let factor = around(perturbation.mass.ln()).exp();
            object.mass *= factor;
            object.inertia *= factor;
        }
        for interface in &mut scene.interfaces {
            let factor = 1.0 + around(perturbation.friction);
            interface.mu *= factor;
            interface.mu_r *= factor;
        }
        for body in 0..scene.statics.len() {
            let rise = around(perturbation.height);
            if self.may_rise(body) {
                scene.raise(body, rise);
            }
        }
        for object in 0..scene.objects.len() {
            let shift = [around(perturbation.position), around(perturbation.position)];
            scene.shift(object, shift);
        }
        scene
    }

    /// True for a bounded static body on which the robot does not stand at the start.
    fn may_rise(&self, body: usize) -> bool {
        let shapes = &self.statics[body].shapes;
        let bounded = shapes.iter().all(|s| s.shape != Shape::HalfSpace);
        let stood_on = self.start_contacts.iter().any(|contact| {
            let owner = |i: symbolic::InterfaceId| self.interfaces[i.0].owner;
            matches!(owner(contact.a), Owner::Robot { .. })
                && owner(contact.b) == Owner::Static(body)
        });
        bounded && !stood_on
    }

    /// Raises a static body and what stands on it.
    fn raise(&mut self, body: usize, rise: f64) {
        let up =
            |pose: &Pose| Pose::from_parts(*pose.rotation(), pose.origin() + Vector3::z() * rise);
        for placed in &mut self.statics[body].shapes {
            placed.body_from_shape = up(&placed.body_from_shape);
        }
        for interface in &mut self.interfaces {
            if interface.owner == Owner::Static(body) {
                interface.body_from_interface = up(&interface.body_from_interface);
            }
        }
        for contact in &self.start_contacts {
            let (a, b) = (&self.interfaces[contact.a.0], &self.interfaces[contact.b.0]);
            if let (Owner::Object(o), true) = (a.owner, b.owner == Owner::Static(body)) {
                let object = &mut self.objects[o];
                object.world_from_start = up(&object.world_from_start);
            }
        }
    }

    /// Moves an object along the surface it stands on at the start, as far as that reaches.
    fn shift(&mut self, object: usize, shift: [f64; 2]) {
        let stands = |contact: &&symbolic::Contact| {
            self.interfaces[contact.a.0].owner == Owner::Object(object)
                && matches!(self.interfaces[contact.b.0].owner, Owner::Static(_))
        };
        let Some(contact) = self.start_contacts.iter().find(stands) else {
            return;
        };
        let (a, b) = (&self.interfaces[contact.a.0], &self.interfaces[contact.b.0]);
        let world_from_b = b.body_from_interface;
        let start = self.objects[object].world_from_start;
        let in_b = (world_from_b.inverse() * start * a.body_from_interface).origin();
        let moved: [f64; 2] = std::array::from_fn(|i| {
            let Some(half_b) = b.half_size else {
                return shift[i];
            };
            let half_a = a.half_size.filter(|_| !b.overhang).unwrap_or([0.0; 2]);
            let room = (half_b[i] - half_a[0].max(half_a[1])).max(in_b[i].abs());
            (in_b[i] + shift[i]).clamp(-room, room) - in_b[i]
        });
        let along = world_from_b.rotate(Vector3::new(moved[0], moved[1], 0.0));
        self.objects[object].world_from_start =
            Pose::from_parts(*start.rotation(), start.origin() + along);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variant_keeps_objects_on_their_tables_and_the_robot_on_the_ground() {
        let scene = Scene::builtin("pick-place").unwrap();
        for seed in 0..20 {
            let variant = scene.perturbed(&Perturbation::default(), seed);
            assert_eq!(variant.start, scene.start);
            let factor = variant.objects[0].mass / scene.objects[0].mass;
            assert!((0.5..=2.0).contains(&factor), "{factor}");
            for contact in &variant.start_contacts {
                let (a, b) = (
                    &variant.interfaces[contact.a.0],
                    &variant.interfaces[contact.b.0],
                );
                let Owner::Object(o) = a.owner else { continue };
                let b_from_a = b.body_from_interface.inverse()
                    * variant.objects[o].world_from_start
                    * a.body_from_interface;
                assert!(b_from_a.origin().z.abs() < 1e-9);
                let half = b.half_size.unwrap();
                assert!(b_from_a.origin().x.abs() <= half[0]);
                assert!(b_from_a.origin().y.abs() <= half[1]);
            }
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_variant_and_another_one_another() {
        let scene = Scene::builtin("pick-place").unwrap();
        let mass = |seed| scene.perturbed(&Perturbation::default(), seed).objects[0].mass;
        assert_eq!(mass(3), mass(3));
        assert!(mass(3) != mass(4));
    }
}
