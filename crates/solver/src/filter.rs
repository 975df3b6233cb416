//! The filter: pairs (violation θ, barrier objective φ) that a new iterate must not be dominated by.
//!
//! Source: Wächter and Biegler 2006, section 2.3.

const GAMMA_THETA: f64 = 1e-5;
const GAMMA_PHI: f64 = 1e-8;
const ETA_PHI: f64 = 1e-8;
const S_THETA: f64 = 1.1;
const S_PHI: f64 = 2.3;

/// Entries that fit without another allocation: more than a solve of the default length can add.
const CAPACITY: usize = 256;

/// Filter of one barrier problem.
#[derive(Debug)]
pub struct Filter {
    entries: Vec<(f64, f64)>,
    theta_max: f64,
    theta_min: f64,
}

/// What is known at the current iterate.
#[derive(Debug, Clone, Copy)]
pub struct Current {
    /// Violation θ (1-norm).
    pub theta: f64,
    /// Barrier objective φ.
    pub phi: f64,
    /// Directional derivative of φ along the step.
    pub slope: f64,
}

/// Why a trial point is acceptable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Sufficient decrease of φ (Armijo); the filter stays.
    Objective,
    /// Sufficient decrease of θ or φ; the filter grows.
    Filter,
    /// Refused.
    Refused,
}

impl Filter {
    /// No entries, and no limits before the first [`Filter::reset`].
    pub fn new() -> Self {
        Self {
            entries: Vec::with_capacity(CAPACITY),
            theta_max: 0.0,
            theta_min: 0.0,
        }
    }

    /// Empties the filter for a new barrier problem that starts with violation `theta`.
    pub fn reset(&mut self, theta: f64) {
        self.entries.clear();
        self.theta_max = 1e4 * theta.max(1.0);
        self.theta_min = 1e-4 * theta.max(1.0);
    }

    /// Judges a trial point reached with step length `alpha`.
    pub fn judge(&self, now: Current, alpha: f64, theta: f64, phi: f64) -> Verdict {
        if !theta.is_finite() || !phi.is_finite() || theta > self.theta_max {
            return Verdict::Refused;
        }
        let slack = 10.0 * f64::EPSILON * now.phi.abs().max(1.0);
        if self
            .entries
            .iter()
            .any(|&(t, p)| theta >= (1.0 - GAMMA_THETA) * t && phi >= p - GAMMA_PHI * t + slack)
        {
            return Verdict::Refused;
        }
        let switching = now.slope < 0.0
            && alpha * (-now.slope).powf(S_PHI) > now.theta.powf(S_THETA)
            && now.theta <= self.theta_min;
        if switching {
            if phi <= now.phi + ETA_PHI * alpha * now.slope + slack {
                Verdict::Objective
            } else {
                Verdict::Refused
            }
        } else if theta <= (1.0 - GAMMA_THETA) * now.theta
            || phi <= now.phi - GAMMA_PHI * now.theta + slack
        {
            Verdict::Filter
        } else {
            Verdict::Refused
        }
    }

    /// Adds the current iterate.
    pub fn add(&mut self, now: Current) {
        let entry = (
            (1.0 - GAMMA_THETA) * now.theta,
            now.phi - GAMMA_PHI * now.theta,
        );
        self.entries.retain(|e| e.0 < entry.0 || e.1 < entry.1);
        self.entries.push(entry);
    }
}
