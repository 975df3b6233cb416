//! What the sequence search asks of geometry, remembered by content.
//!
//! A contact state is possible if one configuration satisfies its contacts, a transition if one satisfies the contacts of
//! both states ([`Planner::state`]). So both are questions about sets of contacts: subsets of a possible set are possible,
//! supersets of an impossible one are not. An impossible set is reduced to contacts that are all needed for it to be
//! impossible, so that one rejection concerns as many states as it can.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use crate::api::Impossible;
use crate::summary;
use ocp::{Keyframes, Phase, Planner, Settings};
use scene::Scene;
use symbolic::{Contact, ContactState, Oracle, Verdict};

/// Checks of one scene with one set of options.
pub(crate) struct Checks<'a> {
    scene: &'a Scene,
    planner: &'a Planner<'a>,
    settings: &'a Settings,
    /// When the search ends at the latest.
    begin: Instant,
    time_limit: f64,
    /// Sets that one configuration satisfies.
    possible: BTreeSet<ContactState>,
    /// Smallest sets that none satisfies.
    impossible: Vec<Core>,
    /// Beginnings of sequences.
    prefixes: BTreeMap<Vec<ContactState>, bool>,
}

/// Contacts that exclude one another.
struct Core {
    contacts: ContactState,
    reason: String,
    refused: usize,
}

impl<'a> Checks<'a> {
    /// Nothing known yet.
    pub fn new(
        planner: &'a Planner<'a>,
        settings: &'a Settings,
        begin: Instant,
        time_limit: f64,
    ) -> Self {
        Self {
            scene: planner.scene,
            planner,
            settings,
            begin,
            time_limit,
            possible: BTreeSet::new(),
            impossible: Vec::new(),
            prefixes: BTreeMap::new(),
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
        let found = self.planner.state(set, self.settings);
        if found.possible {
            self.possible.insert(set.clone());
            return None;
        }
        Some(self.reduce(set.clone(), found))
    }

    /// Leaves out every contact without which the rest is still impossible.
    fn reduce(&mut self, mut core: ContactState, mut found: Keyframes) -> usize {
        for contact in core.clone().iter() {
            let mut less = core.clone();
            less.contacts.remove(&contact);
            if self.possible.iter().any(|known| less.is_subset(known)) {
                continue;
            }
            let without = self.planner.state(&less, self.settings);
            if without.possible {
                self.possible.insert(less);
            } else {
                (core, found) = (less, without);
            }
        }
        let reason = self.reason(&core, &found);
        self.impossible.push(Core {
            contacts: core,
            reason,
            refused: 0,
        });
        self.impossible.len() - 1
    }

    fn reason(&self, core: &ContactState, found: &Keyframes) -> String {
        let contacts: Vec<String> = core.iter().map(|c| self.name(c)).collect();
        let together = contacts.join(" with ");
        let worst = found.worst.as_ref();
        let by = worst.map_or_else(String::new, |w| summary::amount(self.scene, w));
        format!("no configuration has {together}: {by}")
    }

    fn name(&self, contact: Contact) -> String {
        let name = |i: symbolic::InterfaceId| &self.scene.interfaces[i.0].name;
        format!("{} on {}", name(contact.a), name(contact.b))
    }

    fn verdict(&mut self, set: &ContactState) -> Option<(ContactState, String)> {
        let core = self.core(set)?;
        let core = &mut self.impossible[core];
        core.refused += 1;
        Some((core.contacts.clone(), core.reason.clone()))
    }

    /// True if keyframes satisfy a beginning of a sequence, the goal aside.
    pub fn prefix_possible(&mut self, phases: &[Phase]) -> bool {
        let states: Vec<ContactState> = phases.iter().map(|p| p.state.clone()).collect();
        if let Some(&known) = self.prefixes.get(&states) {
            return known;
        }
        let keyframes = self.planner.keyframes_of_prefix(phases, self.settings);
        self.prefixes.insert(states, keyframes.possible);
        keyframes.possible
    }

    /// Contacts that were found to exclude one another, in the order in which they were found.
    pub fn impossible(&self) -> Vec<Impossible> {
        let one = |core: &Core| Impossible {
            contacts: core.contacts.iter().map(|c| self.name(c)).collect(),
            reason: core.reason.clone(),
            refused: core.refused,
        };
        self.impossible.iter().map(one).collect()
    }
}

impl Oracle for Checks<'_> {
    fn state(&mut self, state: &ContactState) -> Verdict {
        match self.verdict(state) {
            None => Verdict::Accept,
            Some((contacts, reason)) => Verdict::RejectContacts(contacts, reason),
        }
    }

    fn transition(&mut self, from: &ContactState, to: &ContactState) -> Verdict {
        let both = from.iter().chain(to.iter()).collect();
        match self.verdict(&both) {
            None => Verdict::Accept,
            Some((_, reason)) => Verdict::Reject(reason),
        }
    }

    fn stop(&mut self) -> bool {
        self.begin.elapsed().as_secs_f64() > self.time_limit
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocp::Preset;
    use symbolic::{ContactType, InterfaceId};

    fn state(scene: &Scene, pairs: &[(&str, &str)]) -> ContactState {
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
        let mut checks = Checks::new(&planner, &settings, Instant::now(), f64::INFINITY);
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
    fn a_hand_on_the_far_side_of_a_box_is_possible_since_the_box_may_be_turned() {
        let scene = Scene::builtin("lift-box").expect("a built-in scene");
        let planner = Planner::new(&scene).expect("a model");
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let mut checks = Checks::new(&planner, &settings, Instant::now(), f64::INFINITY);
        let crossed = [
            ("left_foot", "ground_top"),
            ("right_foot", "ground_top"),
            ("right_hand", "box_left"),
            ("box_bottom", "table_top"),
        ];
        assert_eq!(checks.state(&state(&scene, &crossed)), Verdict::Accept);
    }
}
