//! Keyframes of a given sequence whose beginnings are refused: what a search learns while it draws steps one by one is not known of it.
//!
//! A walk is flown first, as the search does before it draws steps ([`Checks::feet_anew`]); or the keyframes of the same sequence with
//! fewer steps are a guess, as where the search adds some.

use super::Checks;
use ocp::{Keyframes, Phase};
use scene::{Role, Scene};
use std::ops::RangeInclusive;
use symbolic::{Anew, Contact, ContactState, Oracle};

/// Sequences with fewer steps that are tried at most.
const MOST_SHORTER: usize = 8;

impl Checks<'_> {
    /// Keyframes of a whole sequence from those of its beginnings, with walks flown first where these are refused, or else from those of the
    /// sequence with fewer steps; `None` if that leads nowhere.
    pub fn keyframes_by_walks(&mut self, phases: &[Phase]) -> Option<Keyframes> {
        self.by_walks(phases, &mut vec![])
    }

    /// The same but for sequences that have been tried.
    fn by_walks(&mut self, phases: &[Phase], tried: &mut Vec<Vec<Phase>>) -> Option<Keyframes> {
        tried.push(phases.to_vec());
        let are_possible = self.fly_walks(phases);
        let found = are_possible.then(|| self.keyframes_by_beginnings(phases));
        found
            .flatten()
            .or_else(|| self.with_fewer_steps(phases, tried))
    }

    /// Are all beginnings possible, where they are not otherwise, from a guess in which a walk was flown?
    fn fly_walks(&mut self, phases: &[Phase]) -> bool {
        (2..=phases.len()).all(|k| {
            let beginning = &phases[..k];
            let telling = self.is_telling(&phases[k - 2].state, &phases[k - 1].state);
            let possible = !telling || self.nodes(beginning).is_some() || self.fly_one(beginning);
            possible && !self.stop()
        })
    }

    /// Is a beginning possible from a guess in which one of its walks was flown, the last ones first?
    fn fly_one(&mut self, phases: &[Phase]) -> bool {
        let walks = walks(self.scene, phases);
        walks.iter().rev().any(|walk| {
            let flown = without(phases, walk);
            let states: Vec<&ContactState> = flown.iter().map(|p| &p.state).collect();
            let anew = self.feet_anew(&states, &[*walk.start()]);
            let is_possible = matches!(anew, Some(Anew::Possible { .. }));
            is_possible && self.solve_beginning(phases).possible
        })
    }

    /// From the keyframes of the sequence without a round of steps of all feet in one of its walks, the last ones first: it stands there
    /// meanwhile.
    fn with_fewer_steps(
        &mut self,
        phases: &[Phase],
        tried: &mut Vec<Vec<Phase>>,
    ) -> Option<Keyframes> {
        let more = 2 * feet(self.scene, &phases[0].state).len();
        for walk in walks(self.scene, phases).iter().rev() {
            let again = |at: &usize| phases[*at].state == phases[at + more].state;
            let last = (walk.end() + 1).saturating_sub(more);
            for at in (*walk.start()..last).filter(again) {
                let fewer = without(phases, &(at..=at + more));
                if tried.contains(&fewer) || tried.len() > MOST_SHORTER || self.stop() {
                    continue;
                }
                let Some(found) = self.by_walks(&fewer, tried) else {
                    continue;
                };
                let stance = vec![found.nodes[at + 1].clone(); more];
                let (before, after) = found.nodes.split_at(at + 1);
                let guess = [before, &stance, after].concat();
                let found = self.planner.keyframes_at(&guess, phases, self.settings);
                if found.is_some() {
                    return found;
                }
            }
        }
        None
    }
}

fn feet(scene: &Scene, state: &ContactState) -> ContactState {
    let is_foot = |c: &Contact| scene.interfaces[c.a.0].role == Role::Foot;
    state.iter().filter(is_foot).collect()
}

/// Phases but those after the first of a walk up to its last.
fn without(phases: &[Phase], walk: &RangeInclusive<usize>) -> Vec<Phase> {
    [&phases[..=*walk.start()], &phases[walk.end() + 1..]].concat()
}

/// Walks: phases in which nothing changes but what the feet have contact with, from a state to the same again, each as long as it can be.
fn walks(scene: &Scene, phases: &[Phase]) -> Vec<RangeInclusive<usize>> {
    let others = |k: usize| -> ContactState {
        let state = &phases[k].state;
        let feet = feet(scene, state);
        state.iter().filter(|c| !feet.contains(c)).collect()
    };
    let mut found = vec![];
    let mut first = 0;
    while first < phases.len() {
        let same = |&k: &usize| others(k) == others(first);
        let end = first + (first..phases.len()).take_while(same).count();
        let again = |k: usize| (k + 1..end).rfind(|&j| phases[j].state == phases[k].state);
        found.extend((first..end).find_map(|k| Some(k..=again(k)?)));
        first = end;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::tests::state;
    use super::*;
    use crate::api::Stop;
    use crate::journal::Journal;
    use crate::search::balanced;
    use ocp::{Planner, Preset, Settings};
    use std::path::Path;
    use std::time::Instant;

    const UNSEEN: &str = "../../benches/unseen/sequences";

    /// A variant of a scene with a sequence, whose keyframes are asked for: by walks, and from nothing.
    fn with_walks(name: &str, variant: u64) -> (Option<Keyframes>, Keyframes) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join(UNSEEN)
            .join(name);
        let file = scene::SequenceFile::load(&path).expect("a sequence file");
        let known = file.load_scene().expect("its scene");
        let sequence = file.resolve(&known).expect("a sequence of the scene");
        let scene = known.perturbed(&scene::Perturbation::default(), variant);
        let phase = |p: &scene::SequencePhase| Phase {
            state: p.state.clone(),
            steps: p.steps,
        };
        let phases: Vec<Phase> = sequence.phases.iter().map(phase).collect();
        let planner = Planner::new(&scene).expect("a model");
        let settings = balanced(Settings::new(Preset::Default, &scene.optimiser));
        let fresh = || {
            let limits = (Instant::now(), f64::INFINITY, Stop::default());
            Checks::new(
                (&planner, &settings, 8),
                limits,
                (Journal::default(), vec![]),
            )
        };
        assert!(fresh().keyframes_by_beginnings(&phases).is_none(), "{name}");
        (
            fresh().keyframes_by_walks(&phases),
            planner.keyframes(&phases, &settings),
        )
    }

    #[test]
    fn what_is_behind_a_walk_around_a_table_is_found_by_flying_there() {
        let (by_walks, at_once) = with_walks("sort.toml", 1);
        assert!(by_walks.is_some_and(|found| found.possible));
        assert!(!at_once.possible);
    }

    #[test]
    fn what_is_found_with_fewer_steps_is_found_with_more() {
        let (by_walks, at_once) = with_walks("skew.toml", 6);
        assert!(by_walks.is_some_and(|found| found.possible));
        assert!(!at_once.possible);
    }

    #[test]
    fn walks_end_where_they_begin_and_are_as_long_as_they_can_be() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/from-floor.toml");
        let scene = scene::Scene::load(path).expect("a scene of the repository");
        let feet = [("left_foot", "ground_top"), ("right_foot", "ground_top")];
        let hand = ("left_hand", "crate_left");
        let phase = |pairs: &[(&str, &str)]| Phase {
            state: state(&scene, pairs),
            steps: 4,
        };
        let (both, left, right) = (phase(&feet), phase(&feet[..1]), phase(&feet[1..]));
        let held = phase(&[feet[0], feet[1], hand]);
        let swung = phase(&[feet[0], hand]);
        // A step of both feet, the hand's contact on one foot, then a step of the right foot.
        let phases = [&both, &left, &both, &right, &swung, &held, &swung, &held]
            .map(Clone::clone)
            .to_vec();
        assert_eq!(walks(&scene, &phases), [0..=2, 4..=6]);
        let fewer = without(&phases, &(0..=2));
        assert_eq!(fewer[..2], [both, right]);
        assert_eq!(fewer.len(), 6);
    }
}
