//! What a sequence is worth to the search, between 0 and 1: its violation and cost (paper, "Implementation Details").

/// Reward of a sequence that is not optimised, and bounds of the others.
pub(super) const LEFT_OUT: f64 = 0.0;
const NO_MOTION: f64 = 0.3;
const MOTION: f64 = 0.5;

/// Costs of the plans so far.
#[derive(Debug, Default)]
pub(super) struct Rewards {
    costs: Vec<f64>,
}

impl Rewards {
    /// Of a plan: its rank by cost among all so far, since costs of different objectives have different scales.
    pub fn of_plan(&mut self, cost: f64) -> f64 {
        self.costs.push(cost);
        let behind = self.costs.iter().filter(|&&other| other >= cost).count();
        MOTION + (1.0 - MOTION) * behind as f64 / self.costs.len() as f64
    }

    /// Of a motion that violates its constraints (scaled rows).
    pub fn of_failure(violation: f64) -> f64 {
        NO_MOTION / (1.0 + violation.max(0.0))
    }
}
