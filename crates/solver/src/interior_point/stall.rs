//! Whether a solve still gets anywhere.

use crate::Options;

/// Mean step length below which iterations count as hardly moving. Over ten iterations that hardly lower the violation,
/// solves that end well keep above 0.02 (most above 0.07), those of contact sequences without a motion come to 0.001.
const SHORT_STEP: f64 = 0.02;
/// Violation (scaled rows) below which a solve goes on whatever its steps: short ones near a solution mean a small barrier
/// parameter, not that there is no motion (`yardstick/two_box`, 50 iterations long).
const SERIOUS: f64 = 1e-2;
/// Share of the least violation so far that the window must come below.
const PROGRESS: f64 = 0.9;

/// Violation and step length of the last iterations.
pub(super) struct Stall {
    /// As many as are judged, the oldest one overwritten by the next.
    recent: Vec<(f64, f64)>,
    count: usize,
    /// Least violation before those.
    before: f64,
}

impl Stall {
    /// Room for the iterations that are judged, which are none if there are not so many.
    pub fn new(options: &Options) -> Self {
        let window = options.stall_iterations;
        let judged = window <= options.max_iterations;
        Self {
            recent: vec![(f64::NAN, f64::NAN); if judged { window } else { 0 }],
            count: 0,
            before: f64::INFINITY,
        }
    }

    /// Takes the violation at the current point and the length of the step that led there.
    pub fn push(&mut self, violation: f64, step: f64) {
        if let Some(next) = self.count.checked_rem(self.recent.len()) {
            if self.count >= self.recent.len() {
                self.before = self.before.min(self.recent[next].0);
            }
            self.recent[next] = (violation, step);
            self.count += 1;
        }
    }

    /// True when the last iterations made short steps and hardly lowered the least violation.
    pub fn is_stalled(&self) -> bool {
        let window = self.recent.len();
        if window == 0 || self.count <= window {
            return false;
        }
        let moved: f64 = self.recent.iter().map(|&(_, step)| step).sum();
        let violations = self.recent.iter().map(|&(violation, _)| violation);
        let least = violations.fold(f64::INFINITY, f64::min);
        least > SERIOUS && moved < SHORT_STEP * window as f64 && least > PROGRESS * self.before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stalls(lines: impl Iterator<Item = (f64, f64)>) -> bool {
        let mut stall = Stall::new(&Options::default());
        lines.into_iter().any(|(violation, step)| {
            stall.push(violation, step);
            stall.is_stalled()
        })
    }

    #[test]
    fn long_steps_or_a_falling_violation_are_no_stall() {
        let fall = |i: i32, rate: f64| rate.powi(i);
        assert!(stalls((0..30).map(|i| (fall(i, 0.995), 0.01))));
        assert!(!stalls((0..30).map(|i| (fall(i, 0.995), 0.03))));
        assert!(!stalls((0..30).map(|i| (fall(i, 0.98), 0.01))));
        assert!(!stalls((0..30).map(|_| (1e-3, 0.0))), "not serious");
    }
}
