//! More steps for a sequence whose keyframes lean far: the policy draws the fewest with which everything is within reach, and strides
//! at the edge of that cost more than some steps do, and are harder to find a motion for.
//!
//! Feet are set anew where the robot leans most, once each, as long as the keyframes of the longer sequence promise less. Swings in place
//! at the end are left out where they can bring nothing.

use super::Run;
use super::stances::Stances;
use ocp::Keyframes;
use scene::Objective;
use std::collections::BTreeMap;
use symbolic::{ContactState, Sequence};

/// How often the feet are set anew at most.
const MOST_ROUNDS: usize = 6;
/// Places in the sequence that are tried in one round, those of the farthest lean first.
const PLACES: usize = 2;
/// What a round must save of the promised cost: its time is more than the half second per phase that is promised.
const SAVING: f64 = 5.0;

/// A sequence, the cost that its keyframes promise, and these.
pub(super) struct Promise {
    pub sequence: Sequence,
    pub cost: f64,
    pub nodes: Vec<Vec<f64>>,
}

/// Where feet are set anew: the phase, and which of them is the first.
pub(crate) type Round = (usize, usize);

/// How the sequences that are tried were drawn: some have more steps now.
#[derive(Default)]
pub(super) struct Longer(BTreeMap<Vec<ContactState>, Drawn>);

struct Drawn {
    number: usize,
    states: Vec<ContactState>,
}

impl Longer {
    /// Takes note of what became of a drawn sequence.
    pub fn note(&mut self, number: usize, drawn: &Sequence, now: &Sequence) {
        let states = drawn.states.clone();
        let drawn = Drawn { number, states };
        self.0.insert(now.states.clone(), drawn);
    }

    /// The number under which a sequence is tried.
    pub fn number_of(&self, sequence: &Sequence) -> Option<usize> {
        self.0.get(&sequence.states).map(|drawn| drawn.number)
    }
}

impl Run<'_> {
    /// Tells the policy what a sequence was worth, by the states with which it was drawn.
    pub(super) fn learn(&mut self, states: &[ContactState], reward: f64) {
        let drawn = self.longer.0.get(states);
        let states = drawn.map_or(states, |drawn| &drawn.states);
        self.policy.learn(states, reward);
    }

    /// The sequence without swings in place at its end, which bring the base no higher where that is all that is asked for.
    pub(super) fn without_idle_end(&self, drawn: &Sequence) -> Sequence {
        let scene = self.shop.planner.scene;
        let mut sequence = drawn.clone();
        if scene.objective == Objective::BaseHeight && scene.goal_regions.is_empty() {
            let needed = self.stances().idle_after(&drawn.states);
            sequence.states.truncate(needed);
            sequence.labels.truncate(needed);
        }
        sequence
    }

    /// The sequence with as many steps as pay; it does not become another that is tried.
    pub(super) fn with_more_steps(&mut self, drawn: Promise) -> Promise {
        let states = self.names(&drawn.sequence);
        let mut best = drawn;
        let mut rounds = vec![];
        while rounds.len() < MOST_ROUNDS {
            if self.is_stopped() || self.is_late() {
                return best; // a run that continues this one looks again
            }
            let Some((better, round)) = self.one_more_round(&best) else {
                break;
            };
            best = better;
            rounds.push(round);
        }
        if !rounds.is_empty() {
            self.checks.journal.note_steps(states, rounds);
        }
        best
    }

    /// The sequence with the steps that it got in the run that is continued.
    pub(super) fn with_remembered_steps(&self, drawn: &Sequence) -> Sequence {
        let rounds = self.checks.journal.steps(&self.names(drawn));
        let more = |sequence: Sequence, &round: &Round| self.after_round(&sequence, round);
        rounds.iter().fold(drawn.clone(), more)
    }

    fn after_round(&self, sequence: &Sequence, (at, first): Round) -> Sequence {
        let mut feet = self.stances().whole(&sequence.states, at);
        feet.rotate_left(first);
        sequence.with_swings(self.policy.graph().domain(), at, &feet)
    }

    /// The least that another round promises, if it is less than so far.
    fn one_more_round(&self, now: &Promise) -> Option<(Promise, Round)> {
        let mut best: Option<(Promise, Round)> = None;
        let (states, stances) = (&now.sequence.states, self.stances());
        for at in self.places(now) {
            let n = stances.whole(states, at).len();
            let orders = stances.feet(&states[at]).len();
            if states.len() + 2 * n > self.policy.max_phases() {
                return None;
            }
            for first in 0..orders {
                let round = (at, first);
                let sequence = self.after_round(&now.sequence, round);
                let Some((cost, nodes)) = self.promise_of_longer(&sequence, now, at) else {
                    continue;
                };
                let least = best
                    .as_ref()
                    .map_or(now.cost - SAVING, |(best, _)| best.cost);
                let is_new = self.longer.number_of(&sequence).is_none();
                if cost < least && is_new {
                    let promise = Promise {
                        sequence,
                        cost,
                        nodes,
                    };
                    best = Some((promise, round));
                }
            }
        }
        best
    }

    /// What keyframes of a sequence with a round of swings promise: from those without, or if that fails, from the sequence alone.
    /// `None` if there are none.
    fn promise_of_longer(
        &self,
        longer: &Sequence,
        without: &Promise,
        at: usize,
    ) -> Option<(f64, Vec<Vec<f64>>)> {
        let phases = self.phases(longer);
        let more = longer.states.len() - without.sequence.states.len();
        let (before, after) = without.nodes.split_at(at + 1);
        let stance = vec![after[0].clone(); more];
        let guess: Vec<Vec<f64>> = before.iter().chain(&stance).chain(after).cloned().collect();
        let (planner, settings) = (self.shop.planner, self.shop.settings);
        let promise = |found: Keyframes| {
            let found = Some(found).filter(|found| found.possible)?;
            Some((self.promise(&phases, &found), found.nodes))
        };
        let near = planner.keyframes_at(&guess, &phases, settings);
        near.and_then(promise)
            .or_else(|| promise(planner.keyframes_at_once(&phases, settings)))
    }

    /// Where the feet are set anew, at most [`PLACES`].
    fn places(&self, promise: &Promise) -> Vec<usize> {
        let phases = self.phases(&promise.sequence);
        let leans = self.shop.planner.leans(&phases, &promise.nodes);
        let mut places = self.stances().strained(&promise.sequence.states, &leans);
        places.truncate(PLACES);
        places
    }

    fn stances(&self) -> Stances<'_> {
        Stances::new(self.shop.planner.scene)
    }
}
