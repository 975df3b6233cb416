//! Contacts stick: no relative sliding and no relative spin while they last.
//!
//! In each interval either the relative velocity at the node whose velocity the integrator uses is zero, or the
//! relative pose is the same at both ends: the smaller of the two is judged. Drift over a phase and over a whole contact
//! is measured from poses alone.
//! Source: paper, sticking conditions; `docs/plan-format.md`, contact geometry.

use nalgebra::Vector3;
use plan::Integrator;
use spatial::{Pose, log_so3};

use crate::categories::Category;
use crate::measure::Measurements;
use crate::motion::{Contact, Motion, Phase};

/// Judges all contacts.
pub(crate) fn judge(motion: &Motion, found: &mut Measurements) {
    for (phase, contact) in motion.contacts() {
        in_each_interval(motion, phase, contact, found);
        at_the_ends(motion, phase, contact, found);
        drift(motion, phase, contact, found);
    }
}

fn in_each_interval(motion: &Motion, phase: &Phase, contact: &Contact, found: &mut Measurements) {
    let ahead = usize::from(motion.plan.integrator == Integrator::SemiImplicitEuler);
    for t in phase.start..phase.end {
        let (linear, angular) = relative_velocity(motion, contact, t + ahead);
        let (here, there) = (motion.b_from_a(contact, t), motion.b_from_a(contact, t + 1));
        let moved = (there.origin() - here.origin()).xy().norm() / motion.dt[t];
        let turned = yaw_between(&here, &there).abs() / motion.dt[t];
        let place = || motion.place(t + ahead, &contact.name);
        found.add(
            Category::ContactVelocity,
            smaller(linear.xy().norm(), moved),
            place,
        );
        found.add(Category::NodeVelocity, linear.xy().norm(), place);
        if contact.kind.is_patch() {
            found.add(
                Category::ContactSpin,
                smaller(angular.z.abs(), turned),
                place,
            );
        }
    }
}

/// The smaller of two numbers, or one that is not finite if either is not.
fn smaller(x: f64, y: f64) -> f64 {
    if x.is_finite() && y.is_finite() {
        x.min(y)
    } else {
        f64::INFINITY
    }
}

fn at_the_ends(motion: &Motion, phase: &Phase, contact: &Contact, found: &mut Measurements) {
    if contact.is_new {
        let (linear, _) = relative_velocity(motion, contact, phase.start);
        found.add(Category::Touchdown, linear.norm(), || {
            motion.place(phase.start, &contact.name)
        });
    }
    if phase.end == motion.n_intervals() {
        let (linear, _) = relative_velocity(motion, contact, phase.end);
        found.add(Category::EndVelocity, linear.norm(), || {
            motion.place(phase.end, &contact.name)
        });
    }
}

fn drift(motion: &Motion, phase: &Phase, contact: &Contact, found: &mut Measurements) {
    for (category, first) in [
        (Category::SlipPhase, phase.start),
        (Category::SlipContact, contact.since),
    ] {
        let start = motion.b_from_a(contact, first).origin();
        for t in first..=phase.end {
            let moved = (motion.b_from_a(contact, t).origin() - start).xy().norm();
            found.add(category, 1e3 * moved, || motion.place(t, &contact.name));
        }
    }
    if contact.kind.is_patch() {
        let start = motion.b_from_a(contact, phase.start);
        for t in phase.start..=phase.end {
            let turned = yaw_between(&start, &motion.b_from_a(contact, t)).abs();
            found.add(Category::SlipYawPhase, turned.to_degrees(), || {
                motion.place(t, &contact.name)
            });
        }
    }
}

/// Velocity of the origin of `a` as seen from `b`, and relative angular velocity, axes of `b` [m/s, rad/s].
fn relative_velocity(motion: &Motion, contact: &Contact, t: usize) -> (Vector3<f64>, Vector3<f64>) {
    let [a, b] = [contact.a, contact.b].map(|i| &motion.frames[t][i]);
    let linear = a.velocity - b.velocity_at(&a.world_from_frame.origin());
    let world_from_b = &b.world_from_frame;
    (
        world_from_b.rotate_inverse(linear),
        world_from_b.rotate_inverse(a.omega - b.omega),
    )
}

/// Turn of `a` about the normal of `b` from one relative pose to another [rad].
fn yaw_between(from: &Pose, to: &Pose) -> f64 {
    log_so3(&(to.rotation() * from.rotation().transpose())).z
}
