//! Keyframes of beginnings of sequences: each from those of a shorter one, remembered, with feet set anew where they stand wrong.

use super::Checks;
use crate::journal::{Answer, States};
use ocp::{Keyframes, Phase};
use scene::{Owner, Role};
use std::time::Instant;
use symbolic::{Anew, Contact, ContactState, InterfaceId, in_place};

/// Way of the base that one swing allows at most [m], and what turning by 1 rad counts for [m].
const STRIDE: f64 = 0.5;
const TURN: f64 = 0.3;
/// Beginnings whose keyframes are remembered.
const MOST_NODES: usize = 2000;

/// A beginning that would be possible if the feet were set anew in one state.
pub(super) struct FeetAnew {
    states: Vec<ContactState>,
    at: usize,
    /// Keyframes of the beginning with two more phases after that state: in the air, and the state again.
    nodes: Vec<Vec<f64>>,
}

impl Checks<'_> {
    /// Are there keyframes of a beginning of a sequence, the goal aside? If not, why.
    pub fn beginning(&mut self, phases: &[Phase]) -> Answer {
        let states: States = phases.iter().map(|p| self.names(&p.state)).collect();
        if let Some(known) = self.journal.prefix(&states) {
            return known.clone();
        }
        let clock = Instant::now();
        let keyframes = self.solve_beginning(phases);
        let answer = self.answer(states, &keyframes, clock);
        self.journal.note_prefix(answer.clone());
        answer
    }

    /// Keyframes of a whole sequence, goal regions included.
    pub fn keyframes(&mut self, phases: &[Phase]) -> Keyframes {
        let found = self.keyframes_by_beginnings(phases);
        found.unwrap_or_else(|| self.planner.keyframes(phases, self.settings))
    }

    /// The same from those of its beginnings, one after the other; `None` if that leads nowhere.
    pub fn keyframes_by_beginnings(&mut self, phases: &[Phase]) -> Option<Keyframes> {
        let known = self.nodes(phases)?;
        let (planner, settings) = (self.planner, self.settings);
        let from = planner.keyframes_after(&known, phases, settings, false);
        if from.possible {
            return Some(from);
        }
        planner.keyframes_at(&known, phases, settings)
    }

    /// From the keyframes of the longest shorter beginning that had to be checked; if that fails, from nothing.
    fn solve_beginning(&mut self, phases: &[Phase]) -> Keyframes {
        let telling = |k: &usize| self.is_telling(&phases[k - 1].state, &phases[*k].state);
        let shorter = (2..phases.len()).rev().find(|k| telling(&(k - 1)));
        let (planner, settings) = (self.planner, self.settings);
        if let Some(guess) = self.guess_of_swings(phases) {
            let found = planner.keyframes_near(&guess, phases, settings, true);
            self.remember(phases, &found);
            return found;
        }
        let known = shorter.and_then(|k| self.nodes(&phases[..k]));
        let found = match known {
            Some(known) => {
                let mut in_place = || self.guess_in_place(phases);
                planner.keyframes_of_longer(&known, phases, settings, &mut in_place)
            }
            None => planner.keyframes_of_prefix(phases, settings),
        };
        self.remember(phases, &found);
        found
    }

    /// From keyframes in which nobody takes a step, if there are any.
    fn guess_in_place(&mut self, phases: &[Phase]) -> Option<Vec<Vec<f64>>> {
        let states: Vec<ContactState> = phases.iter().map(|p| p.state.clone()).collect();
        let interface = |i: InterfaceId| &self.scene.interfaces[i.0];
        let stands = |c: &Contact| {
            let pair = (interface(c.a).owner, interface(c.b).owner);
            matches!(pair, (Owner::Robot { .. }, Owner::Static(_)))
        };
        let still = in_place(&states, stands)?;
        let phases: Vec<Phase> = still.states.iter().map(|s| self.phase(s.clone())).collect();
        let nodes = self.nodes(&phases)?;
        Some(still.with_steps(&nodes))
    }

    fn remember(&mut self, phases: &[Phase], found: &Keyframes) {
        if self.nodes.len() >= MOST_NODES {
            self.nodes.clear();
        }
        let key = phases.iter().map(|p| p.state.clone()).collect();
        let nodes = found.possible.then(|| found.nodes.clone());
        self.nodes.insert(key, nodes);
    }

    /// If the phases are the beginning for which feet were set anew last, with swings in place of that: the way there in as many
    /// parts.
    fn guess_of_swings(&self, phases: &[Phase]) -> Option<Vec<Vec<f64>>> {
        let FeetAnew { states, at, nodes } = self.anew.as_ref()?;
        let more = phases.len().checked_sub(states.len()).filter(|&n| n > 0)?;
        let same = |(phase, state): (&Phase, &ContactState)| phase.state == *state;
        let (before, after) = (&states[..=*at], &states[at + 1..]);
        if !phases.iter().zip(before).all(same)
            || !phases[at + 1 + more..].iter().zip(after).all(same)
        {
            return None;
        }
        let model = &self.planner.system.model;
        let (from, to) = (&nodes[at + 1], &nodes[at + 3]);
        let way = model.difference(from, to);
        let part = |n: usize| -> Vec<f64> {
            let share = n as f64 / more as f64;
            let way: Vec<f64> = way.iter().map(|d| share * d).collect();
            model.integrate(from, &way)
        };
        let first = nodes[..=at + 1].iter().cloned();
        let rest = nodes[at + 4..].iter().cloned();
        Some(first.chain((1..=more).map(part)).chain(rest).collect())
    }

    /// Keyframes of a beginning; they depend on nothing but the beginning, be they remembered or not.
    fn nodes(&mut self, phases: &[Phase]) -> Option<Vec<Vec<f64>>> {
        let key: Vec<ContactState> = phases.iter().map(|p| p.state.clone()).collect();
        if let Some(known) = self.nodes.get(&key) {
            return known.clone();
        }
        let found = self.solve_beginning(phases);
        found.possible.then_some(found.nodes)
    }

    /// Is a beginning possible if the feet are set anew in the states of these positions; with how many swings at least?
    pub(super) fn least_swings(&mut self, states: &[&ContactState], at: &[usize]) -> Anew {
        let is_foot = |c: &Contact| self.scene.interfaces[c.a.0].role == Role::Foot;
        let so_far: Vec<Phase> = states.iter().map(|&s| self.phase(s.clone())).collect();
        let (planner, settings) = (self.planner, self.settings);
        // From the keyframes of what was possible before the last step, the rest as a first guess has it.
        let telling = |k: &usize| self.is_telling(states[k - 1], states[*k]);
        let known = (2..states.len()).rev().find(|k| telling(&(k - 1)));
        let known = known.and_then(|k| self.nodes(&so_far[..k]));
        let guess = planner.guess_after(known.as_deref().unwrap_or_default(), &so_far);
        let (mut phases, mut nodes) = (vec![], vec![guess[0].clone()]);
        for (k, &state) in states.iter().enumerate() {
            phases.push(so_far[k].clone());
            nodes.push(guess[k + 1].clone());
            if at.contains(&k) {
                // Geometry does not ask what holds the robot meanwhile.
                let without = state.iter().filter(|c| !is_foot(c)).collect();
                phases.extend([self.phase(without), so_far[k].clone()]);
                nodes.extend([guess[k + 1].clone(), guess[k + 1].clone()]);
            }
        }
        let found = planner.keyframes_near(&nodes, &phases, settings, true);
        if !found.possible {
            return if found.is_hopeless() { Anew::Far } else { Anew::Near };
        }
        let [at] = *at else { return Anew::Possible(1) };
        let way = planner
            .system
            .model
            .difference(&found.nodes[at + 1], &found.nodes[at + 3]);
        let distance = way[0].hypot(way[1]) + TURN * way[5].abs();
        self.anew = Some(FeetAnew {
            states: states.iter().map(|&s| s.clone()).collect(),
            at,
            nodes: found.nodes,
        });
        Anew::Possible(((distance / STRIDE).ceil() as usize).max(1))
    }
}
