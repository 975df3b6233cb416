//! Loads of contacts: what they bear at rest, and how a contact that begins or ends takes its load up or gives it away.
//!
//! With u from 0 to 1 the way that a contact has behind it since it began, or before it until it ends, in so many
//! sixteenths of a phase (margin `ramp`; F times as many on fine grids) or, on grids with velocities, in T_u if that is less:
//! |f_i| ≤ u W, and for feet
//! f_n ≥ min(λ W, ½ u W) (margin `load`, λ) and the centre of pressure within max(u, u_0) of its extents around the last
//! joint, moving to the middle with u. On fine grids u² σ W of f_n counts for nothing there (margin `spare`, σ), so that feet bear
//! u² σ W at least. There the cost w ((f_n − W/n) / W)² draws n feet to equal shares (weight `sharing`, w), less where one lands or
//! leaves.
//!
//! Source: ours. A foot that bears little is turned by any moment that its controller counts on, so it should not stay so for
//! long; benches/runs/2026-11-23-double-support.md, benches/runs/2026-11-23-calm-landings.md,
//! benches/runs/2026-11-24-landings.md, benches/runs/2026-11-27-spare-load.md, benches/runs/2026-11-29-shared-loads.md.

use super::{Builder, PARTS, Phase, Stage};
use scene::{Owner, Role};
use symbolic::{Contact, ContactState, InterfaceId};

/// Longest ramp on grids with velocities, T_u [s].
const LONGEST_RAMP: f64 = 0.1;
/// Factor of the margin `ramp` on fine grids, F.
const FINE_RAMP: f64 = 2.0;
/// Time before a landing in which standing feet have `landing_pressure` and the base `landing_acceleration`, and time after
/// one in which the base has it [s].
const BEFORE_LANDING: f64 = 0.3;
const AFTER_LANDING: f64 = 0.2;
/// Time before a landing in which the centre of mass is drawn over the feet that stand [s].
pub(super) const BALANCED: f64 = 0.4;
/// Time from a landing or a leave of a foot from which on loads of feet have all their weight `sharing` [s], and its least part.
const SHARED_AFTER: f64 = 0.2;
const LEAST_SHARING: f64 = 0.05;
/// Share of the area for the centre of pressure that a foot has when its ramp begins.
const FIRST_AREA: f64 = 0.15;

impl Builder<'_> {
    /// What a contact bears in a state in which nothing moves [N]: feet the robot, alike; what an object stands on, alike, the
    /// object and what stands on it.
    pub(super) fn load(&self, state: &ContactState, contact: Contact) -> f64 {
        self.load_below(state, contact, self.scene.objects.len())
    }

    /// The same for at most so many objects one above the other.
    fn load_below(&self, state: &ContactState, contact: Contact, most: usize) -> f64 {
        let owner = |i: InterfaceId| self.scene.interfaces[i.0].owner;
        let share_of = |lands: &dyn Fn(&Contact) -> bool| {
            state.iter().filter(|c| lands(c)).count().max(1) as f64
        };
        match owner(contact.a) {
            Owner::Robot { .. } => {
                let is_foot = |c: &Contact| self.scene.interfaces[c.a.0].role == Role::Foot;
                if is_foot(&contact) {
                    self.robot_weight() / share_of(&is_foot)
                } else {
                    0.0
                }
            }
            Owner::Object(o) => {
                self.weight_with_load(state, o, most)
                    / share_of(&|c| owner(c.a) == Owner::Object(o))
            }
            Owner::Static(_) => 0.0,
        }
    }

    /// Weight of an object and of what stands on it [N].
    fn weight_with_load(&self, state: &ContactState, object: usize, most: usize) -> f64 {
        let weight = self.scene.objects[object].mass * self.scene.gravity.norm();
        let owner = |c: &Contact| self.scene.interfaces[c.b.0].owner;
        let on_it = state.iter().filter(|c| owner(c) == Owner::Object(object));
        let above = |c| {
            most.checked_sub(1)
                .map(|most| self.load_below(state, c, most))
        };
        weight + on_it.filter_map(above).sum::<f64>()
    }

    /// The most of that in any phase [N].
    pub(super) fn heaviest(&self, object: usize, phases: &[Phase]) -> f64 {
        let most = self.scene.objects.len();
        let weights = phases.iter();
        let weights = weights.map(|phase| self.weight_with_load(&phase.state, object, most));
        weights.fold(0.0, f64::max)
    }

    /// Part of a foot's load on fine grids that counts for nothing in the limits of its centre of pressure [N], with so much of
    /// the ramp behind it.
    pub(super) fn spare_load(&self, contact: Contact, ramp: f64) -> f64 {
        let is_foot = self.scene.interfaces[contact.a.0].role == Role::Foot;
        if is_foot && self.program.is_fine() {
            self.program.settings.margins.spare * self.robot_weight() * ramp * ramp
        } else {
            0.0
        }
    }

    /// Weight of the robot [N].
    pub(super) fn robot_weight(&self) -> f64 {
        self.program.system.robot_mass * self.scene.gravity.norm()
    }

    /// How far a contact that bears the robot or an object has got with taking up its load after it began, or with giving it
    /// away before it ends: 0 to 1. At the beginning and end of a flight no other contact takes the load over, so there it
    /// comes and goes at once.
    pub(super) fn ramp(&self, t: usize, contact: Contact, phases: &[Phase]) -> f64 {
        let p = &self.program;
        if !self.bears_load(contact) {
            return 1.0;
        }
        let along = p.along();
        let here = 0.5 * (along[t] + along[t + 1]);
        let n = p.n_intervals();
        let active = |t: usize| phases[p.phase_of(t)].state.contains(&contact);
        let flies = |t: usize| p.flies[p.phase_of(t)];
        let came = (1..=t).rev().find(|&i| !active(i - 1));
        let came = came.filter(|&i| !flies(i - 1));
        let goes = (t + 1..n).find(|&i| !active(i));
        let goes = goes.filter(|&i| !flies(i));
        let apart = came
            .into_iter()
            .chain(goes)
            .map(|i| (along[i] - here).abs())
            .fold(f64::INFINITY, f64::min);
        let sixteenth = p.settings.max_step * p.steps[p.phase_of(t)] as f64 / PARTS;
        let longest = if p.has_velocities() {
            LONGEST_RAMP / sixteenth
        } else {
            f64::INFINITY
        };
        let ramp = p.settings.margins.ramp * if p.is_fine() { FINE_RAMP } else { 1.0 };
        let share = apart / ramp.min(longest);
        if share < 1.0 { share } else { 1.0 }
    }

    /// Weight of what a foot's load differs from an equal share: little at the moments at which a foot lands or leaves, so that nobody
    /// falls into a landing to share its load at once.
    pub(super) fn sharing(&self, t: usize, phases: &[Phase]) -> f64 {
        let away = self.time_to_change_of_feet(t, phases) / SHARED_AFTER;
        self.program.settings.weights.sharing * away.clamp(LEAST_SHARING, 1.0)
    }

    /// Time from the middle of an interval to the nearest moment at which a foot lands or leaves, in longest steps [s]; those at which
    /// a flight ends or begins do not count, since all feet share it.
    fn time_to_change_of_feet(&self, t: usize, phases: &[Phase]) -> f64 {
        let p = &self.program;
        let is_foot = |c: &Contact| self.scene.interfaces[c.a.0].role == Role::Foot;
        let feet = |k: usize| -> ContactState { phases[k].state.iter().filter(is_foot).collect() };
        let begin = |k: usize| p.steps[..k].iter().sum::<usize>();
        let k = p.phase_of(t);
        let here = feet(k);
        let before = (0..k).rev().find(|&i| feet(i) != here);
        let after = (k + 1..phases.len()).find(|&i| feet(i) != here);
        let stands = |&i: &usize| !p.flies[i];
        let since = before.filter(stands).map(|i| t - begin(i + 1));
        let until = after.filter(stands).map(|i| begin(i) - 1 - t);
        let steps = since.into_iter().chain(until).min();
        let steps = steps.map_or(f64::INFINITY, |n| n as f64 + 0.5);
        p.settings.max_step * steps
    }

    /// Does a foot land at the beginning of a phase.
    fn begins_with_landing(&self, k: usize, phases: &[Phase]) -> bool {
        let lands = |c: Contact| {
            let foot = self.scene.interfaces[c.a.0].role == Role::Foot;
            foot && !phases[k - 1].state.contains(&c)
        };
        k > 0 && k < phases.len() && phases[k].state.iter().any(lands)
    }

    /// Does a foot land at the end of the phase of an interval, so soon after its middle, in its longest steps.
    pub(super) fn before_landing(&self, t: usize, phases: &[Phase]) -> bool {
        self.lands_within(BEFORE_LANDING, t, phases)
    }

    /// The same within some time [s].
    pub(super) fn lands_within(&self, time: f64, t: usize, phases: &[Phase]) -> bool {
        let p = &self.program;
        let k = p.phase_of(t);
        let end: usize = p.steps[..=k].iter().sum();
        let until = p.settings.max_step * ((end - t) as f64 - 0.5);
        until < time && self.begins_with_landing(k + 1, phases)
    }

    /// Marks the intervals of fine grids before which a foot has landed, or after which one lands, but not around a flight: there the base
    /// falls.
    pub(super) fn around_landings(&mut self, phases: &[Phase]) {
        for t in 0..self.program.intervals.len() {
            let p = &self.program;
            let k = p.phase_of(t);
            let begin: usize = p.steps[..k].iter().sum();
            let since = p.settings.max_step * ((t - begin) as f64 + 0.5);
            let after =
                since < AFTER_LANDING && self.begins_with_landing(k, phases) && !p.flies[k - 1];
            let before = self.before_landing(t, phases) && !p.flies[k];
            if self.program.is_fine() && (after || before) {
                self.program.intervals[t].stage = Stage::Landing;
            }
        }
    }

    /// Does a contact take up load gradually: of the robot or of an object that stands on something.
    fn bears_load(&self, contact: Contact) -> bool {
        let [a, b] = [contact.a, contact.b].map(|i| &self.scene.interfaces[i.0]);
        match (a.owner, b.owner) {
            (Owner::Robot { .. } | Owner::Object(_), Owner::Static(_)) => true,
            (Owner::Robot { .. }, _) => a.role == Role::Foot,
            _ => false,
        }
    }

    /// Largest force of a contact with so much of its ramp behind it [N].
    pub(super) fn most_load(
        &self,
        t: usize,
        contact: Contact,
        share: f64,
        phases: &[Phase],
    ) -> f64 {
        if share >= 1.0 {
            return f64::INFINITY;
        }
        let state = &phases[self.program.phase_of(t)].state;
        let bears = match self.scene.interfaces[contact.a.0].owner {
            Owner::Object(_) => self.load(state, contact),
            _ => self.robot_weight(),
        };
        bears * share
    }

    /// Centre and half extents of the area that the centre of pressure may use, with so much of the ramp behind the contact
    /// [m]. A foot begins and ends below its last joint: there a force that is not as planned does not turn it.
    pub(super) fn area(
        &self,
        contact: Contact,
        [x, y]: [f64; 2],
        share: f64,
    ) -> ([f64; 2], [f64; 2]) {
        let a = &self.scene.interfaces[contact.a.0];
        if a.role != Role::Foot || share >= 1.0 {
            return ([0.0; 2], [x, y]);
        }
        let carrier = self.program.system.carrier(a.owner, &a.body_from_interface);
        let ankle = carrier.body_from_frame.inverse().origin();
        let share = share.max(FIRST_AREA);
        let around = |ankle: f64, half: f64| ankle.clamp(-half, half) * (1.0 - share);
        (
            [around(ankle.x, x), around(ankle.y, y)],
            [x * share, y * share],
        )
    }

    /// What a foot bears at least that may bear so much [N]. One that hardly touches rattles where a controller holds it fast.
    pub(super) fn least_load(&self, contact: Contact, most: f64) -> f64 {
        if self.scene.interfaces[contact.a.0].role == Role::Foot {
            (self.program.settings.margins.load * self.robot_weight()).min(0.5 * most)
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Refinement;
    use crate::collision::samples::Sequence;
    use crate::collision::{Clearances, Watched};
    use crate::motion::Planner;
    use crate::program::{Grid, Program};
    use crate::settings::{Preset, Settings};

    /// The program of a sequence on the finest grid.
    fn finest(sequence: &str) -> Program {
        let Sequence { scene, phases } = Sequence::with_steps(sequence, 50);
        let planner = Planner::new(&scene).unwrap();
        let coarse = Settings::new(Preset::Default, &scene.optimiser);
        let settings = Refinement::default().settings(&coarse);
        let nothing = Watched::new();
        let clearances = Clearances::Watched(&nothing);
        let program = planner.program(&phases, &settings, Grid::Motion, clearances);
        assert!(program.is_fine());
        program
    }

    /// How many intervals of a fine grid are around a landing.
    fn around_landings(sequence: &str) -> usize {
        let program = finest(sequence);
        let all = program.intervals.iter();
        all.filter(|interval| interval.stage == Stage::Landing)
            .count()
    }

    #[test]
    fn the_base_may_fall_before_and_after_the_landing_of_a_jump_but_not_of_a_step() {
        assert!(around_landings("flat/forward_2.toml") > 0);
        assert_eq!(around_landings("flat/jump.toml"), 0);
    }

    #[test]
    fn both_feet_share_the_load_of_a_push_until_they_leave() {
        // Weight of the normal force of a foot in the last interval before both leave the ground, or one does.
        let weight = |sequence: &str| finest(sequence).intervals[49].forces[0].weights[2];
        let (jump, walk) = (weight("flat/jump.toml"), weight("flat/forward_2.toml"));
        assert!(jump > 2.0 * walk, "{jump} {walk}");
    }
}
