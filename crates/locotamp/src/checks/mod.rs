//! What the sequence search asks of geometry, remembered by content.
//!
//! A contact state is possible if one configuration satisfies its contacts, a transition if one satisfies the contacts of
//! both states ([`Planner::state`]). So both are questions about sets of contacts: subsets of a possible set are possible,
//! supersets of an impossible one are not. An impossible set is reduced to contacts that are all needed for it to be
//! impossible, so that one rejection concerns as many states as it can.

mod alone;
mod beginnings;
mod feet_anew;
mod refusals;
mod walks;

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use crate::api::{Impossible, Refusal, Stop};
use crate::journal::{Answer, Journal, States};
use crate::{summary, weight};
use alone::Crowded;
use beginnings::Refused;
use feet_anew::FeetAnew;
use ocp::{Keyframes, Phase, Planner, Settings};
use refusals::Refusals;
use scene::{Owner, Role, Scene};
use symbolic::{Anew, Contact, ContactState, Oracle, Verdict};

/// Checks of one scene with one set of options.
pub(crate) struct Checks<'a> {
    scene: &'a Scene,
    planner: &'a Planner<'a>,
    settings: &'a Settings,
    /// Intervals per phase.
    steps: usize,
    /// When the search ends at the latest.
    begin: Instant,
    time_limit: f64,
    stop: Stop,
    /// What has been answered.
    pub journal: Journal,
    /// What the answers of beginnings have taken, or took the run that is continued, roughly, as work of motions.
    pub work: u64,
    /// The work at which drawing pauses.
    pub pause_at: u64,
    /// Keyframes of beginnings.
    nodes: BTreeMap<Vec<ContactState>, Option<Vec<Vec<f64>>>>,
    /// The last beginning that setting feet anew made possible.
    anew: Option<FeetAnew>,
    refused: Option<Refused>,
    /// Beginnings that have no room for the objects.
    crowded: Vec<Crowded>,
    /// Sets that one configuration satisfies.
    possible: BTreeSet<ContactState>,
    /// Smallest sets that none satisfies.
    impossible: Vec<Core>,
    /// What else was refused.
    refusals: Refusals,
}

/// Contacts that exclude one another.
struct Core {
    contacts: ContactState,
    reason: String,
    refused: usize,
}

impl<'a> Checks<'a> {
    /// Nothing known but what the journal holds, and lifts that were found to be impossible.
    pub fn new(
        (planner, settings, steps): (&'a Planner<'a>, &'a Settings, usize),
        (begin, time_limit, stop): (Instant, f64, Stop),
        (journal, too_heavy): (Journal, Vec<Impossible>),
    ) -> Self {
        Self {
            scene: planner.scene,
            planner,
            settings,
            steps,
            begin,
            time_limit,
            stop,
            journal,
            work: 0,
            pause_at: u64::MAX,
            nodes: BTreeMap::new(),
            anew: None,
            refused: None,
            crowded: Vec::new(),
            possible: BTreeSet::new(),
            impossible: Vec::new(),
            refusals: Refusals {
                too_heavy,
                ..Refusals::default()
            },
        }
    }

    /// Is there a configuration with these contacts? If not, why.
    fn ask(&mut self, set: &ContactState) -> Answer {
        let states = vec![self.names(set)];
        if let Some(known) = self.journal.state(&states) {
            return known.clone();
        }
        let clock = Instant::now();
        let answer = self.answer(states, &self.planner.state(set, self.settings), clock);
        self.journal.note_state(answer.clone());
        answer
    }

    fn answer(&self, states: States, found: &Keyframes, clock: Instant) -> Answer {
        let worst = found.worst.as_ref().filter(|_| !found.possible);
        Answer {
            states,
            possible: found.possible,
            reason: worst.map(|w| summary::amount(self.scene, w)),
            seconds: clock.elapsed().as_secs_f64(),
        }
    }

    /// The contacts of a set that exclude one another, as a position in the list of such sets; `None` if the set is possible.
    fn core(&mut self, set: &ContactState) -> Option<usize> {
        if let Some(core) = self
            .impossible
            .iter()
            .position(|c| c.contacts.is_subset(set))
        {
            return Some(core);
        }
        if self.possible.iter().any(|known| set.is_subset(known)) {
            return None;
        }
        let found = self.ask(set);
        if found.possible {
            self.possible.insert(set.clone());
            return None;
        }
        Some(self.reduce(set.clone(), found))
    }

    /// Leaves out every contact without which the rest is still impossible.
    fn reduce(&mut self, mut core: ContactState, mut found: Answer) -> usize {
        for contact in core.clone().iter() {
            let mut less = core.clone();
            less.contacts.remove(&contact);
            if self.possible.iter().any(|known| less.is_subset(known)) {
                continue;
            }
            let without = self.ask(&less);
            if without.possible {
                self.possible.insert(less);
            } else {
                (core, found) = (less, without);
            }
        }
        let reason = format!(
            "no configuration has {}: {}",
            self.names(&core).join(" with "),
            found.reason.unwrap_or_default()
        );
        self.impossible.push(Core {
            contacts: core,
            reason,
            refused: 0,
        });
        self.impossible.len() - 1
    }

    /// The contacts of a state in words, in order.
    pub fn names(&self, state: &ContactState) -> Vec<String> {
        let name = |i: symbolic::InterfaceId| &self.scene.interfaces[i.0].name;
        let words = |c: Contact| {
            let verb = if c.kind.is_unilateral() {
                "on"
            } else {
                "holds"
            };
            format!("{} {verb} {}", name(c.a), name(c.b))
        };
        state.iter().map(words).collect()
    }

    fn verdict(&mut self, set: &ContactState) -> Option<(ContactState, String)> {
        let core = self.core(set)?;
        let core = &mut self.impossible[core];
        core.refused += 1;
        Some((core.contacts.clone(), core.reason.clone()))
    }

    /// True if the step from one state to the next may take a beginning out of reach: something else than a foot on an
    /// unbounded surface is landed. A foot finds a place on the ground wherever it is.
    fn is_telling(&self, from: &ContactState, to: &ContactState) -> bool {
        let interface = |i: symbolic::InterfaceId| &self.scene.interfaces[i.0];
        let made = to.iter().filter(|c| !from.contains(c));
        let on_ground =
            |c: &Contact| interface(c.a).role == Role::Foot && interface(c.b).half_size.is_none();
        made.into_iter().any(|c| !on_ground(&c))
    }

    /// The contacts of a state that may be impossible while objects are where they are at the start: those of the robot with the
    /// objects, beside which others may stand, and with bounded surfaces, with which the objects' places have to agree. Empty if they
    /// concern bounded surfaces of one body only: the robot finds a place on it.
    fn bound_by(&self, state: &ContactState, objects: &[usize]) -> ContactState {
        let interface = |i: symbolic::InterfaceId| &self.scene.interfaces[i.0];
        let body = |c: &Contact| match (interface(c.a).owner, interface(c.b).owner) {
            (Owner::Robot { .. }, Owner::Object(o)) if objects.contains(&o) => Some((0, o)),
            (Owner::Robot { .. }, Owner::Static(s)) if interface(c.b).half_size.is_some() => {
                Some((1, s))
            }
            _ => None,
        };
        let bodies: BTreeSet<_> = state.iter().filter_map(|c| body(&c)).collect();
        if bodies.len() < 2 && bodies.iter().all(|body| body.0 == 1) {
            return ContactState::default();
        }
        state.iter().filter(|c| body(c).is_some()).collect()
    }

    /// The contacts of objects with what is no robot.
    fn resting(&self, state: &ContactState, objects: &[usize]) -> ContactState {
        let owner = |c: &Contact| self.scene.interfaces[c.a.0].owner;
        let of_these = |c: &Contact| objects.iter().any(|&o| owner(c) == Owner::Object(o));
        state.iter().filter(of_these).collect()
    }

    fn phase(&self, state: ContactState) -> Phase {
        Phase {
            state,
            steps: self.steps,
        }
    }
}

impl Oracle for Checks<'_> {
    fn state(&mut self, state: &ContactState) -> Verdict {
        match self.verdict(state) {
            None => Verdict::Accept,
            Some((contacts, reason)) => Verdict::RejectContacts(contacts, reason),
        }
    }

    fn unmoved(&mut self, state: &ContactState, objects: &[usize]) -> Verdict {
        let bound = self.bound_by(state, objects);
        if bound.is_empty() {
            return Verdict::Accept;
        }
        // From the start the robot gets there through the air.
        let start = self.scene.start_state();
        let air = self.resting(&start, objects);
        let there = air.iter().chain(bound.iter()).collect();
        let phases = [start, air, there].map(|state| self.phase(state));
        let answer = self.before_moved(&phases, objects);
        if answer.possible {
            return Verdict::Accept;
        }
        let reason = format!(
            "before {} is moved, {} is impossible: {}",
            objects
                .iter()
                .map(|&o| self.scene.objects[o].name.as_str())
                .collect::<Vec<_>>()
                .join(" or "),
            self.names(&bound).join(" with "),
            answer.reason.unwrap_or_default()
        );
        self.refusals.before_moved.push(Impossible {
            what: Refusal::Contacts,
            contacts: self.names(&bound),
            reason: reason.clone(),
            refused: 1,
        });
        Verdict::RejectContacts(bound, reason)
    }

    fn set_anew(&mut self, states: &[&ContactState], at: &[usize]) -> Option<Anew> {
        self.feet_anew(states, at)
    }

    fn transition(&mut self, from: &ContactState, to: &ContactState) -> Verdict {
        if let Some(found) = weight::fault(self.scene, from, to) {
            let reason = found.reason.clone();
            self.refusals.note_lift(found);
            return Verdict::Reject(reason);
        }
        let both = from.iter().chain(to.iter()).collect();
        match self.verdict(&both) {
            None => Verdict::Accept,
            Some((_, reason)) => Verdict::Reject(reason),
        }
    }

    fn prefix(&mut self, states: &[&ContactState]) -> Verdict {
        let [.., from, to] = states else {
            return Verdict::Accept;
        };
        if !self.is_telling(from, to) {
            return Verdict::Accept;
        }
        if let Some(reason) = self.crowded(states).map(str::to_owned) {
            self.refusals.note_beginning(&reason);
            return Verdict::Reject(reason);
        }
        let phases: Vec<Phase> = states.iter().map(|&s| self.phase(s.clone())).collect();
        let answer = self.beginning(&phases);
        if answer.possible {
            return Verdict::Accept;
        }
        let reason = answer.reason.unwrap_or_default();
        self.note_refused(states, &reason);
        self.refusals.note_beginning(&reason);
        Verdict::Reject(reason)
    }

    fn pause(&mut self) -> bool {
        self.work >= self.pause_at
    }

    fn stop(&mut self) -> bool {
        self.stop.is_set() || self.begin.elapsed().as_secs_f64() > self.time_limit
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use ocp::Preset;
    use symbolic::{ContactType, InterfaceId};

    pub fn fresh<'a>(planner: &'a Planner<'a>, settings: &'a Settings) -> Checks<'a> {
        Checks::new(
            (planner, settings, 8),
            (Instant::now(), f64::INFINITY, Stop::default()),
            (Journal::default(), vec![]),
        )
    }

    /// Unilateral patches on one another, by name.
    pub fn state(scene: &Scene, pairs: &[(&str, &str)]) -> ContactState {
        let id = |name: &str| {
            let found = scene.interfaces.iter().position(|i| i.name == name);
            InterfaceId(found.expect("an interface of the scene"))
        };
        let contact = |(a, b): &(&str, &str)| Contact {
            a: id(a),
            b: id(b),
            kind: ContactType::UnilateralPatch,
        };
        pairs.iter().map(contact).collect()
    }

    #[test]
    fn contacts_that_exclude_one_another_are_found_once_and_refused_wherever_they_occur() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/stairs.toml");
        let scene = Scene::load(path).expect("a scene of the repository");
        let planner = Planner::new(&scene).expect("a model");
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let mut checks = fresh(&planner, &settings);
        let ground = [("left_foot", "ground_top"), ("right_foot", "ground_top")];
        assert_eq!(checks.state(&state(&scene, &ground)), Verdict::Accept);
        let astride = state(&scene, &[ground[0], ("right_foot", "wall_top")]);
        let Verdict::RejectContacts(contacts, reason) = checks.state(&astride) else {
            panic!("a foot on the ground and one on a wall of 1 m");
        };
        assert_eq!(contacts, astride, "either alone is possible");
        assert!(reason.contains("right_foot on wall_top"), "{reason}");

        let before = state(&scene, &ground[..1]);
        let after = state(&scene, &[("right_foot", "wall_top")]);
        assert_eq!(checks.state(&after), Verdict::Accept);
        assert!(matches!(
            checks.transition(&before, &after),
            Verdict::Reject(_)
        ));
        let impossible = checks.impossible();
        assert_eq!((impossible.len(), impossible[0].refused), (1, 2));
    }

    #[test]
    fn beginnings_of_sequences_with_a_motion_are_possible() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/sequences");
        let paths = scene::SequenceFile::find(std::path::Path::new(folder)).expect("sequences");
        let mut refused = vec![];
        for path in paths {
            let file = scene::SequenceFile::load(&path).expect("a sequence file");
            let scene = file.load_scene().expect("its scene");
            let sequence = file.resolve(&scene).expect("a sequence of the scene");
            if sequence.expect != Some(scene::Expectation::Feasible) {
                continue;
            }
            let planner = Planner::new(&scene).expect("a model");
            let settings = Settings::new(Preset::Default, &scene.optimiser);
            let mut checks = fresh(&planner, &settings);
            let states: Vec<&ContactState> = sequence.phases.iter().map(|p| &p.state).collect();
            for k in 2..=states.len() {
                if let Verdict::Reject(reason) = checks.prefix(&states[..k]) {
                    refused.push(format!("{} {k}: {reason}", path.display()));
                }
                if let Some(lift) = weight::fault(&scene, states[k - 2], states[k - 1]) {
                    refused.push(format!("{} {k}: {}", path.display(), lift.reason));
                }
                let all: Vec<usize> = (0..scene.objects.len()).collect();
                let resting = checks.resting(&scene.start_state(), &all);
                let rests = |o: &usize| {
                    let of_it = |c: &Contact| scene.interfaces[c.a.0].owner == Owner::Object(*o);
                    let mut own = resting.iter().filter(of_it);
                    own.all(|c| states[..k].iter().all(|s| s.contains(&c)))
                };
                let unmoved: Vec<usize> = all.iter().copied().filter(rests).collect();
                let verdict = checks.unmoved(states[k - 1], &unmoved);
                if let Verdict::RejectContacts(_, reason) = verdict {
                    refused.push(format!("{} {k}: {reason}", path.display()));
                }
            }
        }
        assert!(refused.is_empty(), "{refused:#?}");
    }

    #[test]
    fn a_step_before_a_possible_beginning_does_not_make_it_impossible() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/from-floor.toml");
        let scene = Scene::load(path).expect("a scene of the repository");
        let planner = Planner::new(&scene).expect("a model");
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let mut checks = fresh(&planner, &settings);
        let feet = [("left_foot", "ground_top"), ("right_foot", "ground_top")];
        let hands = [("left_hand", "crate_left"), ("right_hand", "crate_right")];
        let with = |pairs: &[&[(&str, &str)]]| state(&scene, &pairs.concat());
        let on_floor = [("crate_bottom", "ground_top")];
        let standing = with(&[&feet, &on_floor]);
        let carried = [
            with(&[&feet, &hands, &on_floor]),
            with(&[&feet, &hands]),
            with(&[&feet, &hands, &[("crate_bottom", "table_top")]]),
        ];
        let [held, lifted, placed] = &carried;
        assert_eq!(
            checks.prefix(&[&standing, held, lifted, placed]),
            Verdict::Accept
        );
        for foot in feet {
            let swing = with(&[&[foot], &on_floor]);
            let states = [&standing, &swing, &standing, held, lifted, placed];
            assert_eq!(checks.prefix(&states), Verdict::Accept, "{foot:?}");
        }
        // A step with the crate in the hands, which must be in the air meanwhile.
        let [left, right] = feet;
        let swing = with(&[&[right], &on_floor]);
        let carrying = with(&[&[left], &hands]);
        let states = [
            &standing, &swing, &standing, held, lifted, &carrying, lifted, placed,
        ];
        assert_eq!(checks.prefix(&states), Verdict::Accept);
    }

    #[test]
    fn a_beginning_that_is_missed_by_little_is_possible_with_feet_anew() {
        let scene = Scene::builtin("pick-place").expect("a built-in scene");
        let planner = Planner::new(&scene).expect("a model");
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let mut checks = fresh(&planner, &settings);
        let feet = [("left_foot", "ground_top"), ("right_foot", "ground_top")];
        let on = |table| [("red_box_bottom", table)];
        let held = [("left_hand", "red_box_handle")];
        let with = |pairs: &[&[(&str, &str)]]| state(&scene, &pairs.concat());
        let states = [
            with(&[&feet, &on("table_a_top")]),
            with(&[&feet, &held, &on("table_a_top")]),
            with(&[&feet, &held]),
            with(&[&feet, &held, &on("table_b_top")]),
        ];
        let states: Vec<&ContactState> = states.iter().collect();
        let verdict = checks.prefix(&states);
        assert!(matches!(verdict, Verdict::Reject(_)), "{verdict:?}");
        let stances: Vec<usize> = (0..states.len() - 1).collect();
        let anew = checks.set_anew(&states, &stances);
        let Some(Anew::Possible { at, swings }) = anew else {
            panic!("{anew:?}");
        };
        assert!(stances.contains(&at));
        assert!((1..=4).contains(&swings), "{swings} swings");
    }

    #[test]
    fn a_hand_on_the_far_side_of_a_box_is_possible_since_the_box_may_be_turned() {
        let scene = Scene::builtin("lift-box").expect("a built-in scene");
        let planner = Planner::new(&scene).expect("a model");
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let mut checks = fresh(&planner, &settings);
        let crossed = [
            ("left_foot", "ground_top"),
            ("right_foot", "ground_top"),
            ("right_hand", "box_left"),
            ("box_bottom", "table_top"),
        ];
        assert_eq!(checks.state(&state(&scene, &crossed)), Verdict::Accept);
    }
}
