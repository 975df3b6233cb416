//! Grasps in which no motion was found: keyframes know no torques, so that a bar at whose end the wrist is too weak is carried in one hand
//! by sequence after sequence, each of which fails at another place. Others in which it is carried so wait behind what promises more.

use scene::{Owner, Scene};
use std::collections::{BTreeMap, BTreeSet};
use symbolic::{Contact, ContactState};

/// Failures from which on a grasp is doubtful: of sequences that begin well about as many fail as not.
const PATIENCE: usize = 3;

/// Contacts of the robot by which an object is carried that rests on nothing.
type Grasp = ContactState;

/// What is known of grasps.
#[derive(Debug, Default)]
pub(super) struct Grasps {
    /// Owners of the interfaces.
    owners: Vec<Owner>,
    failures: BTreeMap<Grasp, usize>,
    carried: BTreeSet<Grasp>,
}

impl Grasps {
    /// Nothing is known of a scene.
    pub fn new(scene: &Scene) -> Self {
        Self {
            owners: scene.interfaces.iter().map(|i| i.owner).collect(),
            ..Self::default()
        }
    }

    /// Takes note of a sequence that has no motion, or none that is likely to hold on a finer grid.
    pub fn failed(&mut self, states: &[ContactState]) {
        for grasp in self.of(states) {
            *self.failures.entry(grasp).or_default() += 1;
        }
    }

    /// The same of one that has.
    pub fn succeeded(&mut self, states: &[ContactState]) {
        let grasps = self.of(states);
        self.carried.extend(grasps);
    }

    /// How many failures more than are usual tell against one of the grasps of a sequence.
    pub fn doubts(&self, states: &[ContactState]) -> usize {
        let unknown = |grasp: &Grasp| !self.carried.contains(grasp);
        let grasps = self.of(states).into_iter().filter(unknown);
        let failures = grasps.filter_map(|grasp| self.failures.get(&grasp).copied());
        (failures.max().unwrap_or(0) + 1).saturating_sub(PATIENCE)
    }

    /// All grasps of a sequence.
    fn of(&self, states: &[ContactState]) -> BTreeSet<Grasp> {
        let grasps = states.iter().flat_map(|state| self.of_state(state));
        grasps.collect()
    }

    fn of_state(&self, state: &ContactState) -> impl Iterator<Item = Grasp> {
        let mut grasps: BTreeMap<usize, Grasp> = BTreeMap::new();
        for contact in state.iter() {
            if let [Some(Owner::Robot { .. }), Some(Owner::Object(object))] = self.owners(&contact)
            {
                let grasp = grasps.entry(object).or_default();
                grasp.contacts.insert(contact);
            }
        }
        for contact in state.iter() {
            if let [Some(Owner::Object(object)), _] = self.owners(&contact) {
                grasps.remove(&object);
            }
        }
        grasps.into_values()
    }

    fn owners(&self, contact: &Contact) -> [Option<Owner>; 2] {
        [contact.a, contact.b].map(|i| self.owners.get(i.0).copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::tests::state;

    #[test]
    fn a_grasp_is_doubtful_after_three_failures_until_something_is_carried_so() {
        let scene = Scene::builtin("lift-box").expect("a built-in scene");
        let rest = ("box_bottom", "table_top");
        let (left, right) = (("left_hand", "box_left"), ("right_hand", "box_right"));
        let with = |pairs: &[(&str, &str)]| state(&scene, pairs);
        let taken_by = |hands: &[(&str, &str)]| {
            let held = [hands, &[rest]].concat();
            [with(&[rest]), with(&held), with(hands)]
        };
        let (one, both) = (taken_by(&[left]), taken_by(&[left, right]));
        let mut grasps = Grasps::new(&scene);
        let counts: Vec<usize> = (0..4)
            .map(|_| {
                grasps.failed(&one);
                grasps.doubts(&one)
            })
            .collect();
        assert_eq!(counts, [0, 0, 1, 2]);
        assert_eq!(grasps.doubts(&both), 0, "another grasp");
        assert_eq!(grasps.doubts(&one[..2]), 0, "it rests on the table");
        let regrasped = [both[2].clone(), one[2].clone()];
        assert_eq!(grasps.doubts(&regrasped), 2);
        grasps.succeeded(&one);
        assert_eq!(grasps.doubts(&one), 0);
    }
}
