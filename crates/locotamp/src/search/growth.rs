//! What motions cost more than their keyframes promise, and at which step.
//!
//! Keyframes know neither velocities nor torques: a lunge onto a platform promises hardly more than a step. A motion that costs more
//! than twice what was promised is strained. None that was tried held on a finer grid (benches/runs/2026-11-27-strained.md). What it
//! costs more is expected of other sequences with the same dearest step too, until one of them has a motion that is not strained.
//! So is one with a serious lapse between its nodes ([`Lapse`]): it will cost about twice as much on the finer grid.
//!
//! Where an attempt fails without having cost much, others that do the same there wait behind what promises a little more. So do those
//! that have a motion on the coarse grid, if another one failed there on the finer grid.

use super::places::{Place, Places};
use super::reward::Worth;
use crate::lapse::Lapse;
use scene::Objective;
use std::collections::{BTreeMap, BTreeSet};
use symbolic::ContactState;

/// What a motion costs, in that of what its keyframes promised, from which on it is strained.
const STRAINED: f64 = 2.0;
/// The same up to which it is as promised, and worth trying on the finer grid before there is another to choose from
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
    /// The most that a motion on the coarse grid gets of that.
    most_reward: Option<f64>,
    /// What has to be got more to be worth more whatever it costs.
    least_gain: f64,
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
    /// The part of it that is not for the scene's objective.
    pub effort: f64,
    /// Phase that costs most, from 0.
    pub dearest_phase: Option<usize>,
    /// What it lacks between its nodes.
    pub lapse: Lapse,
}

impl Costs {
    /// What it is worth.
    pub fn worth(&self) -> Worth {
        Worth {
            cost: self.cost,
            effort: self.effort,
        }
    }
}

impl Growth {
    /// Nothing is known of a scene.
    pub fn new(places: Places, objective: &Objective, least_gain: f64) -> Self {
        Self {
            places,
            least_gain,
            has_reward: *objective != Objective::Time,
            ..Self::default()
        }
    }

    /// True if a motion will hardly hold on a finer grid.
    pub fn is_strained(&self, costs: &Costs) -> bool {
        self.is_within(STRAINED, costs) == Some(false) || costs.lapse.is_serious()
    }

    /// True if a motion will probably hold on a finer grid as it is, and where the scene rewards something gets about as much as others.
    pub fn is_likely(&self, costs: &Costs) -> bool {
        let as_promised = self.is_within(AS_PROMISED, costs);
        let most = self.most_reward;
        let gets_enough = most.is_none_or(|most| costs.worth().is_enough(most, self.least_gain));
        let probably = as_promised.unwrap_or(costs.lapse.is_slight() && gets_enough);
        probably && !costs.lapse.is_serious()
    }

    /// Does a motion cost at most so many times what its keyframes promised? Not told where the scene rewards something.
    fn is_within(&self, times: f64, costs: &Costs) -> Option<bool> {
        (!self.has_reward).then(|| costs.cost <= times * costs.promise.max(LEAST_PROMISE))
    }

    /// Takes note of a motion on the coarse grid and its costs.
    pub fn found(&mut self, states: &[ContactState], costs: &Costs) {
        let gets = costs.worth().gets();
        self.most_reward = Some(self.most_reward.map_or(gets, |most| most.max(gets)));
        if self.is_strained(costs) {
            self.strained_at(states, costs);
        } else {
            self.usual.push(costs.cost - costs.promise);
            self.passed.extend(self.places.of(states));
        }
    }

    /// The same of an attempt that ended without one, in phase `worst` (from 0): what is costly and does not even hold says as much.
    pub fn failed(&mut self, states: &[ContactState], costs: &Costs, worst: Option<usize>) {
        if self.is_strained(costs) {
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
    pub fn expected_to_hold(&self, states: &[ContactState], costs: &Costs) -> f64 {
        let lapse = if costs.lapse.is_serious() {
            costs.effort
        } else {
            0.0
        };
        costs.cost + lapse + most(&self.places.of(states), &self.unheld, &self.held)
    }

    fn strained_at(&mut self, states: &[ContactState], costs: &Costs) {
        let (phase, more) = if costs.lapse.is_serious() {
            (Some(costs.lapse.phase), costs.effort)
        } else {
            (costs.dearest_phase, costs.cost - costs.promise)
        };
        if let Some(phase) = phase.filter(|&phase| phase < states.len()) {
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
            effort: cost,
            dearest_phase: Some(dearest),
            lapse: Lapse::default(),
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
        let cheap = costs(30.0, 30.0, 1);
        growth.did_not_hold(&sequence(&[5, 1, 2, 3]), 40.0, 2);
        assert_eq!(growth.expected_to_hold(&there, &cheap), 40.0);
        assert_eq!(growth.expected(&there, 30.0), 40.0);
        assert_eq!(growth.expected_to_hold(&sequence(&[2, 3, 4]), &cheap), 30.0);
        // A motion on the coarse grid is none on the finer one.
        growth.found(&there, &cheap);
        assert_eq!(growth.expected_to_hold(&there, &cheap), 40.0);
        growth.holds(&sequence(&[1, 2, 3, 9]));
        assert_eq!(growth.expected_to_hold(&there, &cheap), 30.0);
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

    /// Costs of a motion that lacks twice what is serious in phase `phase`.
    fn lapsed(promise: f64, cost: f64, phase: usize) -> Costs {
        Costs {
            effort: cost + 80.0,
            lapse: Lapse {
                torque: 3.0,
                force: 2.0,
                phase,
            },
            ..costs(promise, cost, 0)
        }
    }

    #[test]
    fn a_lapse_strains_a_motion_and_those_that_do_the_same_there_whatever_the_scene_rewards() {
        let mut growth = Growth::new(Places::default(), &Objective::BaseHeight, 7.0);
        let lunge = lapsed(-1300.0, -10.0, 2);
        growth.found(&sequence(&[7, 1, 2, 3]), &lunge);
        assert_eq!(growth.expected(&sequence(&[1, 2, 3, 4]), -1300.0), -1230.0);
        assert_eq!(growth.expected(&sequence(&[1, 2, 4]), -1290.0), -1290.0);
        assert_eq!(
            growth.expected_to_hold(&sequence(&[7, 1, 2, 3]), &lunge),
            60.0
        );
        growth.found(&sequence(&[5, 1, 2, 3]), &costs(-1290.0, 10.0, 0));
        assert_eq!(growth.expected(&sequence(&[1, 2, 3, 4]), -1300.0), 0.0);
    }

    #[test]
    fn what_costs_as_promised_is_likely_and_where_the_scene_rewards_something_what_has_a_slight_lapse()
     {
        let of = |objective| Growth::new(Places::default(), &objective, 7.0);
        let (time, height) = (of(Objective::Time), of(Objective::BaseHeight));
        let (cheap, dear) = (costs(20.0, 27.0, 0), costs(20.0, 29.0, 0));
        assert!(time.is_likely(&cheap) && !time.is_likely(&dear));
        assert!(height.is_likely(&cheap) && height.is_likely(&dear));
        let middling = Lapse {
            torque: 1.2,
            ..Lapse::default()
        };
        let with = |lapse| Costs { lapse, ..cheap };
        assert!(time.is_likely(&with(middling)) && !height.is_likely(&with(middling)));
        let serious = lapsed(20.0, 20.0, 0);
        assert!(!time.is_likely(&serious) && !height.is_likely(&serious));
    }

    #[test]
    fn what_gets_much_less_than_another_motion_is_not_likely() {
        let mut growth = Growth::new(Places::default(), &Objective::BaseHeight, 7.0);
        let with_reward = |reward| Costs {
            effort: 20.0,
            ..costs(0.0, 20.0 - reward, 0)
        };
        let low = with_reward(50.0);
        assert!(growth.is_likely(&low), "there is no other");
        growth.found(&sequence(&[1, 2]), &with_reward(75.0));
        assert!(!growth.is_likely(&low));
        assert!(growth.is_likely(&with_reward(70.0)));
    }

    #[test]
    fn cost_strains_nothing_where_the_scene_rewards_something() {
        let of = |objective| Growth::new(Places::default(), &objective, 7.0);
        let (time, height) = (of(Objective::Time), of(Objective::BaseHeight));
        let strains = |growth: &Growth, promise, cost| growth.is_strained(&costs(promise, cost, 0));
        assert!(strains(&time, 20.0, 41.0) && !strains(&time, 20.0, 39.0));
        assert!(!strains(&time, 1.0, 19.0) && !strains(&height, 20.0, 41.0));
    }
}
