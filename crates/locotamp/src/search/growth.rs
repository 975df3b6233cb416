//! What motions cost more than their keyframes promise, and at which step.
//!
//! Keyframes know neither velocities nor torques: a lunge onto a platform promises hardly more than a step. A motion that costs more
//! than twice what was promised is strained. None that was tried held on a finer grid (benches/runs/2026-11-27-strained.md). What it
//! costs more is expected of other sequences with the same dearest step too, until one of them has a motion that is not strained.
//!
//! Where an attempt fails without having cost much, others that do the same there wait behind what promises a little more. So do those
//! that have a motion on the coarse grid, if another one failed there on the finer grid.

use super::places::{Place, Places};
use scene::Objective;
use std::collections::{BTreeMap, BTreeSet};
use symbolic::ContactState;

/// What a motion costs, in that of what its keyframes promised, from which on it is strained.
const STRAINED: f64 = 2.0;
/// The same up to which it is as promised: it is worth trying on the finer grid before there is another to choose from
/// (benches/runs/2026-11-28-due-results.md).
const AS_PROMISED: f64 = 1.4;
/// Promises below this count as this much: a few steps more or less of so short a motion say nothing.
const LEAST_PROMISE: f64 = 10.0;
/// What a failure adds to the cost that is expected of others at its place, in what was promised; on the finer grid, in what its coarse
/// motion cost.
const DOUBT: f64 = 0.25;

/// What is known of costs.
#[derive(Debug, Default)]
pub(super) struct Growth {
    places: Places,
    /// The scene rewards something: what keyframes promise of that is another number than what motions get.
    has_reward: bool,
    /// What motions that are not strained cost more than promised.
    usual: Vec<f64>,
    /// The least that strained ones cost more, by their dearest phase.
    strained: BTreeMap<Place, f64>,
    /// What failures of others add, by the phase of the most violated row.
    doubtful: BTreeMap<Place, f64>,
    /// Where motions passed that are not strained.
    passed: BTreeSet<Place>,
    /// What failures on the finer grid add, by the phase of the most violated row.
    unheld: BTreeMap<Place, f64>,
    /// Where motions passed on the finer grid.
    held: BTreeSet<Place>,
}

/// What a motion costs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Costs {
    /// What its keyframes promised.
    pub promise: f64,
    pub cost: f64,
    /// Phase that costs most, from 0.
    pub dearest_phase: Option<usize>,
}

impl Growth {
    /// Nothing is known of a scene.
    pub fn new(places: Places, objective: &Objective) -> Self {
        Self {
            places,
            has_reward: *objective != Objective::Time,
            ..Self::default()
        }
    }

    /// True if a motion costs far more than its keyframes promised; not told where the scene rewards something.
    pub fn is_strained(&self, promise: f64, cost: f64) -> bool {
        !self.has_reward && cost > STRAINED * promise.max(LEAST_PROMISE)
    }

    /// True if a motion costs about what its keyframes promised; not told where the scene rewards something.
    pub fn is_as_promised(&self, promise: f64, cost: f64) -> bool {
        !self.has_reward && cost <= AS_PROMISED * promise.max(LEAST_PROMISE)
    }

    /// Takes note of a motion on the coarse grid and its costs.
    pub fn found(&mut self, states: &[ContactState], costs: &Costs) {
        if self.is_strained(costs.promise, costs.cost) {
            self.strained_at(states, costs);
        } else {
            self.usual.push(costs.cost - costs.promise);
            self.passed.extend(self.places.of(states));
        }
    }

    /// The same of an attempt that ended without one, in phase `worst` (from 0): what is costly and does not even hold says as much.
    pub fn failed(&mut self, states: &[ContactState], costs: &Costs, worst: Option<usize>) {
        if self.is_strained(costs.promise, costs.cost) {
            self.strained_at(states, costs);
        } else if let Some(phase) = worst.filter(|&phase| phase < states.len() && !self.has_reward)
        {
            let place = self.places.at(states, phase);
            *self.doubtful.entry(place).or_default() += DOUBT * costs.promise.max(LEAST_PROMISE);
        }
    }

    /// Takes note of a motion that does not hold on the finer grid, in phase `worst` (from 0); on the coarse grid it cost `effort` without
    /// what is for the scene's objective.
    pub fn did_not_hold(&mut self, states: &[ContactState], effort: f64, worst: usize) {
        if worst < states.len() {
            let place = self.places.at(states, worst);
            *self.unheld.entry(place).or_default() += DOUBT * effort.max(LEAST_PROMISE);
        }
    }

    /// The same of one that holds.
    pub fn holds(&mut self, states: &[ContactState]) {
        self.held.extend(self.places.of(states));
    }

    /// What a sequence whose coarse motion costs so much is likely to cost: more, where others failed on the finer grid.
    pub fn expected_to_hold(&self, states: &[ContactState], cost: f64) -> f64 {
        cost + most(&self.places.of(states), &self.unheld, &self.held)
    }

    fn strained_at(&mut self, states: &[ContactState], costs: &Costs) {
        if let Some(phase) = costs.dearest_phase.filter(|&phase| phase < states.len()) {
            let more = costs.cost - costs.promise;
            let place = self.places.at(states, phase);
            let least = self.strained.entry(place).or_insert(more);
            *least = least.min(more);
        }
    }

    /// What a motion is likely to cost: as much more than promised as half of those that are not strained did, and what a step adds
    /// that is known to be strained, or at which others failed.
    pub fn expected(&self, states: &[ContactState], promise: f64) -> f64 {
        let places = self.places.of(states);
        let more = [
            most(&places, &self.strained, &self.passed),
            most(&places, &self.doubtful, &self.passed),
            most(&places, &self.unheld, &self.held),
        ];
        promise + self.usual() + more.into_iter().fold(0.0, f64::max)
    }

    /// The median; 0 if nothing is known.
    fn usual(&self) -> f64 {
        let mut more = self.usual.clone();
        more.sort_by(f64::total_cmp);
        more.get(more.len() / 2).copied().unwrap_or(0.0)
    }
}

/// The most that one of these places adds where no motion passed.
fn most(places: &[Place], more: &BTreeMap<Place, f64>, passed: &BTreeSet<Place>) -> f64 {
    let unpassed = places.iter().filter(|place| !passed.contains(*place));
    let here = unpassed.filter_map(|place| more.get(place).copied());
    here.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::super::places::tests::sequence;
    use super::*;

    fn costs(promise: f64, cost: f64, dearest: usize) -> Costs {
        Costs {
            promise,
            cost,
            dearest_phase: Some(dearest),
        }
    }

    #[test]
    fn what_a_strained_step_costs_is_expected_of_it_elsewhere_until_a_motion_passes_it() {
        let mut growth = Growth::default();
        growth.found(&sequence(&[1, 2, 3, 4]), &costs(20.0, 110.0, 1));
        growth.failed(&sequence(&[5, 1, 2, 3]), &costs(20.0, 100.0, 2), None);
        assert_eq!(growth.expected(&sequence(&[7, 1, 2, 3, 8]), 25.0), 105.0);
        assert_eq!(growth.expected(&sequence(&[2, 3, 4]), 25.0), 25.0);
        growth.found(&sequence(&[1, 2, 3, 9]), &costs(20.0, 23.0, 1));
        assert_eq!(growth.expected(&sequence(&[7, 1, 2, 3, 8]), 25.0), 28.0);
    }

    #[test]
    fn every_failure_adds_to_what_is_expected_at_its_place_until_a_motion_passes_it() {
        let mut growth = Growth::default();
        let there = || sequence(&[7, 1, 2, 3, 8]);
        growth.failed(&sequence(&[1, 2, 3, 4]), &costs(20.0, 21.0, 3), Some(1));
        growth.failed(&sequence(&[5, 6, 4]), &costs(20.0, 21.0, 0), None);
        assert_eq!(growth.expected(&there(), 24.0), 29.0);
        growth.failed(&sequence(&[5, 1, 2, 3]), &costs(40.0, 41.0, 0), Some(2));
        assert_eq!(growth.expected(&there(), 24.0), 39.0);
        assert_eq!(growth.expected(&sequence(&[2, 3, 4]), 24.0), 24.0);
        growth.found(&sequence(&[1, 2, 3, 9]), &costs(20.0, 20.0, 1));
        assert_eq!(growth.expected(&there(), 24.0), 24.0);
    }

    #[test]
    fn a_motion_waits_where_others_failed_on_the_finer_grid_until_one_holds_there() {
        let mut growth = Growth::default();
        let there = sequence(&[7, 1, 2, 3, 8]);
        growth.did_not_hold(&sequence(&[5, 1, 2, 3]), 40.0, 2);
        assert_eq!(growth.expected_to_hold(&there, 30.0), 40.0);
        assert_eq!(growth.expected(&there, 30.0), 40.0);
        assert_eq!(growth.expected_to_hold(&sequence(&[2, 3, 4]), 30.0), 30.0);
        // A motion on the coarse grid is none on the finer one.
        growth.found(&there, &costs(30.0, 30.0, 1));
        assert_eq!(growth.expected_to_hold(&there, 30.0), 40.0);
        growth.holds(&sequence(&[1, 2, 3, 9]));
        assert_eq!(growth.expected_to_hold(&there, 30.0), 30.0);
    }

    #[test]
    fn strained_motions_and_failures_do_not_count_among_what_motions_usually_cost_more() {
        let mut growth = Growth::default();
        for cost in [90.0, 95.0, 99.0] {
            growth.found(&sequence(&[1, 2, 3]), &costs(20.0, cost, 1));
        }
        growth.failed(&sequence(&[4, 5]), &costs(20.0, 39.0, 1), None);
        growth.found(&sequence(&[4, 5]), &costs(20.0, 24.0, 1));
        assert_eq!(growth.expected(&sequence(&[6, 7]), 20.0), 24.0);
    }

    #[test]
    fn nothing_is_strained_where_the_scene_rewards_something() {
        let of = |objective| Growth::new(Places::default(), &objective);
        let (time, height) = (of(Objective::Time), of(Objective::BaseHeight));
        assert!(time.is_strained(20.0, 41.0) && !time.is_strained(20.0, 39.0));
        assert!(!time.is_strained(1.0, 19.0) && !height.is_strained(20.0, 41.0));
    }
}
