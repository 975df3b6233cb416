//! More steps for a sequence whose keyframes lean far: the policy draws the fewest with which everything is within reach, and strides
//! at the edge of that cost more than some steps do, and are harder to find a motion for.
//!
//! Feet are set anew where the robot leans most, once each, as long as the keyframes of the longer sequence promise less.

use super::Run;
use ocp::{Keyframes, Phase};
use scene::{Owner, Role};
use std::collections::BTreeMap;
use symbolic::{Contact, ContactState, Sequence};

/// How often the feet are set anew at most.
const MOST_ROUNDS: usize = 6;
/// Places in the sequence that are tried in one round, those of the farthest lean first.
const PLACES: usize = 2;
/// What a round must save of the promised cost: its time is more than the half second per phase that is promised.
const SAVING: f64 = 5.0;
/// Lean from which on more steps are looked for.
const FAR_LEAN: f64 = 0.42;

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
        let mut feet = self.stance(&sequence.states, at);
        feet.rotate_left(first);
        sequence.with_swings(self.policy.graph().domain(), at, &feet)
    }

    /// The least that another round promises, if it is less than so far.
    fn one_more_round(&self, now: &Promise) -> Option<(Promise, Round)> {
        let mut best: Option<(Promise, Round)> = None;
        let states = &now.sequence.states;
        for at in self.strained(now) {
            let n = self.stance(states, at).len();
            let orders = self.feet(&states[at]).len();
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

    /// Where the feet are set anew: between two other changes where the robot leans beyond what is easy before the next one, or later on
    /// what it carries meanwhile. There the first stance on all feet, or, with something in its hands, that which it has. Those of the
    /// farthest leans first. None on a single foot.
    fn strained(&self, promise: &Promise) -> Vec<usize> {
        let states = &promise.sequence.states;
        let phases = self.phases(&promise.sequence);
        let leans = self.leans(&phases, &promise.nodes);
        let all = self.feet(&states[0]).len();
        let others = |k: usize| -> Vec<Contact> {
            let is_other = |c: &Contact| !self.is_foot(c);
            states[k].iter().filter(is_other).collect()
        };
        let most = |leans: &mut dyn Iterator<Item = f64>| leans.fold(0.0, f64::max);
        let mut places: Vec<(usize, f64)> = vec![];
        let mut first = 0;
        while first < states.len() && all > 1 {
            let same = |&k: &usize| others(k) == others(first);
            let end = first + (first..states.len()).take_while(same).count();
            let carried = self.carried(&states[first]);
            let own = leans.get(first..end).into_iter().flatten().copied();
            let later = (end..leans.len()).filter(|&k| self.stands_on(&states[k], &carried));
            let lean = most(&mut own.chain(later.map(|k| leans[k])));
            let on = |feet: usize| (first..end).find(|&k| self.feet(&states[k]).len() >= feet);
            let stance = on(all).or_else(|| on(1).filter(|_| !carried.is_empty()));
            places.extend(stance.filter(|_| lean > FAR_LEAN).map(|k| (k, lean)));
            first = end;
        }
        places.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        places.into_iter().map(|(k, _)| k).take(PLACES).collect()
    }

    /// Objects that the robot has in its hands and that rest on nothing.
    fn carried(&self, state: &ContactState) -> Vec<Owner> {
        let owner = |i: symbolic::InterfaceId| self.shop.planner.scene.interfaces[i.0].owner;
        let pairs = || state.iter().map(|c| (owner(c.a), owner(c.b)));
        let rests = |object: &Owner| pairs().any(|(a, _)| a == *object);
        let held = pairs().filter_map(|(a, b)| match (a, b) {
            (Owner::Robot { .. }, Owner::Object(_)) => Some(b),
            _ => None,
        });
        held.filter(|object| !rests(object)).collect()
    }

    /// True if a foot stands on one of the objects.
    fn stands_on(&self, state: &ContactState, objects: &[Owner]) -> bool {
        let owner = |c: &Contact| self.shop.planner.scene.interfaces[c.b.0].owner;
        self.feet(state).iter().any(|c| objects.contains(&owner(c)))
    }

    /// Contacts of all feet in a phase; of those in the air, the last that they had.
    fn stance(&self, states: &[ContactState], at: usize) -> Vec<Contact> {
        let before = states[..=at].iter().rev();
        let mut stance: Vec<Contact> = vec![];
        for contact in before.flat_map(|state| self.feet(state)) {
            if stance.iter().all(|c| c.a != contact.a) {
                stance.push(contact);
            }
        }
        stance.sort();
        stance
    }

    /// Leans of the robot at the phase boundaries.
    pub(super) fn leans(&self, phases: &[Phase], nodes: &[Vec<f64>]) -> Vec<f64> {
        self.shop.planner.leans(phases, nodes)
    }

    fn is_foot(&self, contact: &Contact) -> bool {
        self.shop.planner.scene.interfaces[contact.a.0].role == Role::Foot
    }

    /// Contacts of feet in a state.
    fn feet(&self, state: &ContactState) -> Vec<Contact> {
        state.iter().filter(|c| self.is_foot(c)).collect()
    }
}
