//! What a solve reports.

use std::time::Duration;

/// How a solve ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// All tolerances are met.
    Solved,
    /// The violation was acceptable for long enough and the objective stood still ([`crate::Options::acceptable_iterations`]).
    Acceptable,
    /// The point is as near to a solution as was asked for ([`crate::Options::enough`]).
    Enough,
    /// The violation stopped falling above its tolerance.
    Stalled,
    /// The iteration limit was reached.
    IterationLimit,
    /// The time limit was reached or the caller asked to stop.
    Interrupted,
    /// No acceptable step or no factorisation was found.
    Failed,
    /// Bounds contradict each other ([`crate::Structure::contradiction`]); nothing was done.
    Contradictory,
}

/// One line of the iteration log.
#[derive(Debug, Clone, Copy, Default)]
pub struct Iteration {
    /// Number of the iteration.
    pub number: usize,
    /// Objective.
    pub objective: f64,
    /// Largest row violation (scaled rows).
    pub violation: f64,
    /// Scaled dual residual.
    pub dual: f64,
    /// Barrier parameter.
    pub barrier: f64,
    /// Primal step length of the step that led here.
    pub step: f64,
    /// Share of the rows' curvature in the system of that step.
    pub curvature: f64,
    /// Its diagonal shift.
    pub shift: f64,
    /// Trial points of the line search.
    pub trials: usize,
    /// Elements of the problem: an iteration's work is proportional to them.
    pub elements: usize,
}

/// Time spent per part of the iteration.
#[derive(Debug, Clone, Copy, Default)]
pub struct Timing {
    /// Values and derivatives for the Newton system.
    pub linearise: Duration,
    /// Assembly and factorisation.
    pub factorise: Duration,
    /// Right-hand sides and refinement.
    pub solve: Duration,
    /// Values at trial points.
    pub evaluate: Duration,
    /// Everything.
    pub total: Duration,
}

impl std::ops::AddAssign for Timing {
    fn add_assign(&mut self, other: Self) {
        self.linearise += other.linearise;
        self.factorise += other.factorise;
        self.solve += other.solve;
        self.evaluate += other.evaluate;
        self.total += other.total;
    }
}

/// Result of a solve beside the point.
#[derive(Debug, Clone)]
pub struct Report {
    /// How it ended.
    pub status: Status,
    /// Iterations done.
    pub iterations: usize,
    /// Objective at the point.
    pub objective: f64,
    /// Largest row violation (scaled rows).
    pub violation: f64,
    /// Scaled dual residual.
    pub dual: f64,
    /// Multipliers of the rows, all elements concatenated.
    pub multipliers: Vec<f64>,
    /// Multipliers of the variables' bounds, positive where the upper one pulls.
    pub bound_multipliers: Vec<f64>,
    /// Row values at the point, all elements concatenated.
    pub rows: Vec<f64>,
    /// Factorisations, failed ones included.
    pub factorisations: usize,
    /// Time per part.
    pub timing: Timing,
}
