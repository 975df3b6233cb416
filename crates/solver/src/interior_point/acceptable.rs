//! Whether a solve that is as good as feasible still gets anywhere.
//!
//! Rows that nearly depend on one another (both feet on the ground with straight knees) leave a residual of micrometres that
//! goes away over hundreds of iterations, while the objective stands still.
//!
//! Source: the acceptable termination of Wächter and Biegler's IPOPT, with the violation as the condition.

use crate::Options;

/// Change of the objective, in its size, that counts as none.
const STILL: f64 = 1e-3;

/// For how long the violation has been acceptable, and the objective still.
pub(super) struct Acceptable {
    tolerance: f64,
    wanted: usize,
    count: usize,
    /// Objective when the count began.
    objective: f64,
}

impl Acceptable {
    pub fn new(options: &Options) -> Self {
        Self {
            tolerance: options.acceptable_tolerance,
            wanted: options.acceptable_iterations,
            count: 0,
            objective: f64::NAN,
        }
    }

    /// Takes violation and objective at the current point.
    pub fn push(&mut self, violation: f64, objective: f64) {
        let moved = (objective - self.objective).abs();
        let still = moved <= STILL * self.objective.abs().max(1.0);
        if violation > self.tolerance {
            self.count = 0;
        } else if self.count == 0 || !still {
            (self.count, self.objective) = (1, objective);
        } else {
            self.count += 1;
        }
    }

    /// True once that has lasted.
    pub fn is_reached(&self) -> bool {
        self.wanted > 0 && self.count >= self.wanted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(lines: impl Iterator<Item = (f64, f64)>) -> Option<usize> {
        let options = Options {
            acceptable_iterations: 10,
            ..Options::default()
        };
        let mut acceptable = Acceptable::new(&options);
        lines.into_iter().position(|(violation, objective)| {
            acceptable.push(violation, objective);
            acceptable.is_reached()
        })
    }

    #[test]
    fn a_still_objective_and_a_small_violation_for_ten_iterations_are_enough() {
        assert_eq!(ends((0..30).map(|_| (2e-6, 200.0))), Some(9));
        assert_eq!(ends((0..30).map(|_| (2e-5, 200.0))), None, "too large");
        assert_eq!(
            ends((0..30).map(|i| (2e-6, 200.0 - f64::from(i)))),
            None,
            "still falling"
        );
        let once = |i| if i == 5 { 2e-5 } else { 2e-6 };
        assert_eq!(ends((0..30).map(|i| (once(i), 200.0))), Some(15));
    }
}
