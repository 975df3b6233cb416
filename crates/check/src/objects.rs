//! Newton–Euler equations of the objects, about their centres of mass.
//!
//! With the body-frame twist (v, ω) and its derivative, m the mass and I the inertia in body axes:
//! `m (v̇ + ω × v) = Rᵀ (Σ f + m g)` and `I ω̇ + ω × I ω = Rᵀ Σ ((x − c) × f + μ)`.
//! Source: paper, object dynamics.

use nalgebra::{Matrix3, Vector3};

use crate::categories::Category;
use crate::measure::Measurements;
use crate::motion::{Motion, Owner};

/// Judges every object in every interval.
pub(crate) fn judge(motion: &Motion, found: &mut Measurements) {
    for (o, object) in motion.plan.objects.iter().enumerate() {
        let [ixx, iyy, izz, ixy, ixz, iyz] = object.inertia;
        #[rustfmt::skip]
        let inertia_in_body = Matrix3::new(
            ixx, ixy, ixz,
            ixy, iyy, iyz,
            ixz, iyz, izz,
        );
        for t in 0..motion.n_intervals() {
            let at = &motion.objects[t][o];
            let world_from_body = &at.world_from_frame;
            let [omega, alpha] = [at.omega, at.alpha].map(|x| world_from_body.rotate_inverse(x));
            let (force, moment) = total_load(motion, t, o);
            let force_gap = (at.acceleration - motion.gravity()) * object.mass - force;
            let moment_gap = inertia_in_body * alpha + omega.cross(&(inertia_in_body * omega))
                - world_from_body.rotate_inverse(moment);
            found.add(Category::ObjectForce, force_gap.norm(), || {
                motion.place(t, &object.name)
            });
            found.add(Category::ObjectMoment, moment_gap.norm(), || {
                motion.place(t, &object.name)
            });
        }
    }
}

/// Sum of the contact wrenches on object `o` about its centre of mass, world axes.
fn total_load(motion: &Motion, t: usize, o: usize) -> (Vector3<f64>, Vector3<f64>) {
    let centre = motion.objects[t][o].world_from_frame.origin();
    let (mut total_force, mut total_moment) = (Vector3::zeros(), Vector3::zeros());
    for (contact, force, moment) in motion.loads(t) {
        let point = motion.frames[t][contact.a].world_from_frame.origin();
        for (interface, sign) in [(contact.a, 1.0), (contact.b, -1.0)] {
            if motion.interfaces[interface].owner == Owner::Object(o) {
                total_force += force * sign;
                total_moment += ((point - centre).cross(&force) + moment) * sign;
            }
        }
    }
    (total_force, total_moment)
}
