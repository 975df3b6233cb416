//! Keyframes of beginnings of sequences: each from those of a shorter one, remembered.

use super::Checks;
use crate::journal::{Answer, States};
use ocp::{Keyframes, Phase};
use scene::Owner;
use std::time::Instant;
use symbolic::{Contact, ContactState, InterfaceId, in_place};

/// Beginnings whose keyframes are remembered.
const MOST_NODES: usize = 2000;

/// Work of motions that is done in about the time of a beginning's keyframes, over the square of its phases: they take more iterations the
/// longer it is, and to refuse one all attempts.
const POSSIBLE: u64 = 2;
const REFUSED: u64 = 6;

/// The beginning that was refused last.
pub(super) struct Refused {
    pub states: Vec<ContactState>,
    /// What came nearest to keyframes of it, if by little.
    pub nearest: Option<Vec<Vec<f64>>>,
}

impl Checks<'_> {
    /// Are there keyframes of a beginning of a sequence, the goal aside? If not, why.
    pub fn beginning(&mut self, phases: &[Phase]) -> Answer {
        self.answered(phases, |checks| checks.solve_beginning(phases))
    }

    /// The same of one that ends, after a flight, with objects where they are at the start, the others wherever they are.
    pub(super) fn before_moved(&mut self, phases: &[Phase], unmoved: &[usize]) -> Answer {
        let moved = |o: &usize| !unmoved.contains(o);
        let moved: Vec<usize> = (0..self.scene.objects.len()).filter(moved).collect();
        self.answered(phases, |checks| {
            (checks.planner).keyframes_anywhere(phases, checks.settings, &moved)
        })
    }

    /// What the journal knows of a beginning, or else what solving says.
    pub(super) fn answered(
        &mut self,
        phases: &[Phase],
        solve: impl FnOnce(&mut Self) -> Keyframes,
    ) -> Answer {
        let answer = self.known_or(phases, solve);
        let work = if answer.possible { POSSIBLE } else { REFUSED };
        self.work += work * (phases.len() * phases.len()) as u64;
        answer
    }

    fn known_or(&mut self, phases: &[Phase], solve: impl FnOnce(&mut Self) -> Keyframes) -> Answer {
        let states: States = phases.iter().map(|p| self.names(&p.state)).collect();
        if let Some(known) = self.journal.prefix(&states) {
            return known.clone();
        }
        let clock = Instant::now();
        let keyframes = solve(self);
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
    pub(super) fn solve_beginning(&mut self, phases: &[Phase]) -> Keyframes {
        let telling = |k: &usize| self.is_telling(&phases[k - 1].state, &phases[*k].state);
        let shorter = (2..phases.len()).rev().find(|k| telling(&(k - 1)));
        let (planner, settings) = (self.planner, self.settings);
        if let Some(guess) = self.guess_of_swings(phases) {
            let found = planner.keyframes_near(&guess, phases, settings, true);
            if found.possible {
                self.remember(phases, &found);
                return found;
            }
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
        let still = in_place(&states, false, stands)?;
        let phases = |states: Vec<ContactState>| -> Vec<Phase> {
            states.into_iter().map(|s| self.phase(s)).collect()
        };
        let (with_middles, without) = (phases(still.with_middles()), phases(still.states.clone()));
        let nodes = self.nodes(&with_middles).or_else(|| {
            let nodes = self.nodes(&without)?;
            let guess = still.middles_between(&nodes, |a, b| self.on_the_way(a, b, 0.5));
            let found = (self.planner).keyframes_near(&guess, &with_middles, self.settings, true);
            found.possible.then_some(found.nodes)
        })?;
        Some(still.with_steps(&nodes))
    }

    /// The configuration at a share of the way from one to another.
    pub(super) fn on_the_way(&self, from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
        let model = &self.planner.system.model;
        let way = model.difference(from, to);
        let part: Vec<f64> = way.iter().map(|d| share * d).collect();
        model.integrate(from, &part)
    }

    fn remember(&mut self, phases: &[Phase], found: &Keyframes) {
        if self.nodes.len() >= MOST_NODES {
            self.nodes.clear();
        }
        let key: Vec<ContactState> = phases.iter().map(|p| p.state.clone()).collect();
        if !found.possible {
            let near = !found.is_hopeless();
            self.refused = Some(Refused {
                states: key.clone(),
                nearest: near.then(|| found.nodes.clone()),
            });
        }
        let nodes = found.possible.then(|| found.nodes.clone());
        self.nodes.insert(key, nodes);
    }

    /// Keyframes of a beginning; they depend on nothing but the beginning, be they remembered or not.
    pub(super) fn nodes(&mut self, phases: &[Phase]) -> Option<Vec<Vec<f64>>> {
        let key: Vec<ContactState> = phases.iter().map(|p| p.state.clone()).collect();
        if let Some(known) = self.nodes.get(&key) {
            return known.clone();
        }
        let found = self.solve_beginning(phases);
        found.possible.then_some(found.nodes)
    }
}
