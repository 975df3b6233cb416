//! The short summary of a plan that people read first.

/// One phase.
#[derive(Debug, Clone, PartialEq)]
pub struct PhaseSummary {
    /// What changes on entering it.
    pub action: String,
    /// Its duration [s].
    pub duration: f64,
    /// Its contacts, "a on b".
    pub contacts: Vec<String>,
}

/// A plan in a few lines.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Phases in order.
    pub phases: Vec<PhaseSummary>,
    /// Sum of the durations [s].
    pub duration: f64,
    /// Number of intervals.
    pub intervals: usize,
    /// Cost of the optimiser.
    pub cost: f64,
    /// Iterations of the optimiser.
    pub iterations: usize,
    /// Time of the optimiser [s].
    pub seconds: f64,
    /// Largest violation in words and SI units, e.g. "contact slip of left_foot on ground_top, 3e-9 m in phase 2".
    pub violation: String,
    /// Largest torque over its limit (ratio), its joint, and the time [s].
    pub torque: (f64, String, f64),
}
