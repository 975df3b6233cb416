//! What motions are worth: to the search, between 0 and 1, from violation and cost (paper, "Implementation Details"); to who asked
//! for plans, by what the scene's objective gets of them before what they cost.

use std::cmp::Ordering;

use ocp::Settings;
use plan::Plan;
use scene::{Objective, Scene};

/// Reward of a sequence that is not optimised, and bounds of the others.
pub(super) const LEFT_OUT: f64 = 0.0;
const NO_MOTION: f64 = 0.3;
const MOTION: f64 = 0.5;

/// What a scene's objective has to get more, height or reach, to be worth more whatever it costs, in heights of the robot's base.
const COUNTS: f64 = 0.2;

/// What a scene's objective has to get more to be worth more whatever it costs, in units of the cost.
pub(crate) fn least_gain(scene: &Scene, settings: &Settings) -> f64 {
    COUNTS * ocp::base_height(scene) * settings.weights.height
}

/// What a motion costs, and the part of it that is not for the scene's objective.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Worth {
    pub cost: f64,
    pub effort: f64,
}

impl Worth {
    /// Of a plan, with the weight of its height or reach.
    pub fn of(plan: &Plan, scene: &Scene, settings: &Settings) -> Self {
        let objective = plan.objective.as_ref();
        let cost = objective.and_then(|o| o.cost).unwrap_or(f64::INFINITY);
        let gets = match scene.objective {
            Objective::Time => 0.0,
            Objective::BaseHeight | Objective::Reach { .. } => objective.map_or(0.0, |o| o.value),
        };
        let effort = cost + settings.weights.height * gets;
        Self { cost, effort }
    }

    /// What it gets for the scene's objective.
    pub fn gets(&self) -> f64 {
        self.effort - self.cost
    }

    /// True if it gets about as much as what gets the most, or more.
    pub fn is_enough(&self, most: f64, least_gain: f64) -> bool {
        self.gets() >= most - least_gain
    }

    /// What gets about the most is first, then what costs less.
    fn order(&self, other: &Self, most: f64, least_gain: f64) -> Ordering {
        let [this, that] = [self, other].map(|worth| worth.is_enough(most, least_gain));
        that.cmp(&this).then(self.cost.total_cmp(&other.cost))
    }
}

/// The most that any of them gets for the scene's objective.
fn most(all: impl Iterator<Item = Worth>) -> f64 {
    all.map(|worth| worth.gets())
        .fold(f64::NEG_INFINITY, f64::max)
}

/// Puts the best first.
pub(crate) fn sort<T>(plans: &mut [T], least_gain: f64, worth: impl Fn(&T) -> Worth) {
    let most = most(plans.iter().map(&worth));
    plans.sort_by(|a, b| worth(a).order(&worth(b), most, least_gain));
}

/// What the plans so far are worth.
#[derive(Debug)]
pub(super) struct Rewards {
    plans: Vec<Worth>,
    least_gain: f64,
}

impl Rewards {
    /// Without any plan.
    pub fn new(least_gain: f64) -> Self {
        let plans = vec![];
        Self { plans, least_gain }
    }

    /// Of a plan: its rank among all so far, since costs of different objectives have different scales.
    pub fn of_plan(&mut self, worth: Worth) -> f64 {
        self.plans.push(worth);
        let most = most(self.plans.iter().copied());
        let order = |other: &&Worth| other.order(&worth, most, self.least_gain).is_ge();
        let behind = self.plans.iter().filter(order).count();
        MOTION + (1.0 - MOTION) * behind as f64 / self.plans.len() as f64
    }

    /// Of a motion that violates its constraints (scaled rows).
    pub fn of_failure(violation: f64) -> f64 {
        NO_MOTION / (1.0 + violation.max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn worth(gets: f64, effort: f64) -> Worth {
        Worth {
            cost: effort - gets,
            effort,
        }
    }

    #[test]
    fn standing_on_the_platform_is_better_than_standing_cheaply_on_the_box() {
        let (platform, as_high, on_box) =
            (worth(77.0, 140.0), worth(75.0, 120.0), worth(55.0, 14.0));
        let mut plans = [on_box, platform, as_high];
        sort(&mut plans, 7.0, |worth| *worth);
        assert_eq!(plans, [as_high, platform, on_box]);
    }

    #[test]
    fn a_few_centimetres_more_are_not_worth_any_cost() {
        let mut plans = [worth(40.0, 90.0), worth(36.0, 20.0)];
        sort(&mut plans, 7.0, |worth| *worth);
        assert_eq!(plans[0], worth(36.0, 20.0));
    }

    #[test]
    fn rewards_rank_plans_as_their_user_does() {
        let mut rewards = Rewards::new(7.0);
        assert_eq!(rewards.of_plan(worth(55.0, 14.0)), 1.0);
        assert_eq!(rewards.of_plan(worth(77.0, 140.0)), 1.0);
        assert_eq!(
            rewards.of_plan(worth(56.0, 10.0)),
            MOTION + (1.0 - MOTION) * 2.0 / 3.0
        );
    }
}
