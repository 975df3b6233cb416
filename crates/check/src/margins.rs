//! How much of the limits on contact forces and torques a plan uses.

use std::fmt;

use serde::Serialize;

use crate::cones::in_own_axes;
use crate::dynamics::{effort_limit, left_at_speed, torques};
use crate::motion::Motion;
use crate::report::Location;

/// Least normal force of a contact that counts as loaded [N].
const LOADED: f64 = 2.0;

/// Use from which a limit counts as nearly reached.
const NEARLY: f64 = 0.95;

/// How much of one kind of limit is used; 1 is all.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Margin {
    /// `friction`, `cop`, `torsion`, `torque` or `torque_speed` (of what is left of the torque at speed).
    pub limit: &'static str,
    /// Largest use.
    pub largest: f64,
    /// Share of the samples (contacts or intervals) above 95 %.
    pub share_above_95_percent: f64,
    /// Where the largest use is.
    pub location: Location,
}

impl fmt::Display for Margin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} {:.2} ({:.0} %)",
            self.limit,
            self.largest,
            100.0 * self.share_above_95_percent
        )
    }
}

#[derive(Default)]
struct Samples {
    count: usize,
    near: usize,
    largest: Option<(f64, Location)>,
}

impl Samples {
    fn add(&mut self, use_of_limit: f64, location: impl FnOnce() -> Location) {
        if !use_of_limit.is_finite() {
            return;
        }
        self.count += 1;
        self.near += usize::from(use_of_limit > NEARLY);
        if self
            .largest
            .as_ref()
            .is_none_or(|(largest, _)| use_of_limit > *largest)
        {
            self.largest = Some((use_of_limit, location()));
        }
    }

    /// The largest use among joints in interval `t`.
    fn add_largest(&mut self, uses: impl Iterator<Item = (usize, f64)>, motion: &Motion, t: usize) {
        let finite = uses.filter(|(_, x)| x.is_finite());
        if let Some((j, largest)) = finite.max_by(|x, y| x.1.total_cmp(&y.1)) {
            self.add(largest, || motion.place(t, &motion.robot.joints[j]));
        }
    }
}

/// Use of friction, centre-of-pressure, torsion and torque limits, over loaded unilateral contacts and all intervals.
pub(crate) fn used(motion: &Motion) -> Vec<Margin> {
    let [
        mut friction,
        mut cop,
        mut torsion,
        mut torque,
        mut torque_speed,
    ] = [(); 5].map(|()| Samples::default());
    for t in 0..motion.n_intervals() {
        for (contact, force, moment) in motion.loads(t) {
            let (force_in_b, moment_in_a) = in_own_axes(motion, contact, t, &force, &moment);
            let normal = force_in_b.z;
            if !contact.kind.is_unilateral() || normal < LOADED {
                continue;
            }
            let place = || motion.place(t, &contact.name);
            friction.add(force_in_b.xy().norm() / (contact.mu * normal), place);
            let a = &motion.interfaces[contact.a];
            if contact.kind.is_patch() && a.is_bounded() {
                let about_x = moment_in_a.x.abs() / (normal * a.half[1]);
                cop.add(
                    about_x.max(moment_in_a.y.abs() / (normal * a.half[0])),
                    place,
                );
                torsion.add(
                    moment_in_a.z.abs() / (contact.mu_r * normal).max(1e-9),
                    place,
                );
            }
        }
        let torques = torques(motion, t);
        let uses = || {
            let torques = torques.iter().enumerate();
            torques.map(|(j, tau)| (j, tau.abs() / effort_limit(motion, j)))
        };
        let at_speed = uses().flat_map(|(j, share)| {
            let left = left_at_speed(motion, t, j, torques[j]);
            left.map(move |(_, left)| (j, share / left))
        });
        torque.add_largest(uses(), motion, t);
        torque_speed.add_largest(at_speed, motion, t);
    }
    let named = [
        ("friction", friction),
        ("cop", cop),
        ("torsion", torsion),
        ("torque", torque),
        ("torque_speed", torque_speed),
    ];
    let margin = |(limit, samples): (&'static str, Samples)| {
        let (largest, location) = samples.largest?;
        let share_above_95_percent = samples.near as f64 / samples.count as f64;
        Some(Margin {
            limit,
            largest,
            share_above_95_percent,
            location,
        })
    };
    named.into_iter().filter_map(margin).collect()
}
