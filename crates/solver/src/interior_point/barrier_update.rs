//! The barrier parameter: LOQO's rule while it makes progress, else a monotone decrease.
//!
//! Source: Nocedal, Wächter, Waltz 2009.

use super::residuals::Errors;
use super::state::State;
use crate::barrier::Complementarity;

/// Iterations whose largest error the next one must beat.
const MEMORY: usize = 4;
/// Share of that error which counts as progress.
const PROGRESS: f64 = 0.9999;

/// Errors of the last iterations that made progress.
#[derive(Default)]
pub(super) struct Progress {
    recent: [f64; MEMORY],
    count: usize,
}

impl Progress {
    fn push(&mut self, error: f64) {
        self.recent[self.count % MEMORY] = error;
        self.count += 1;
    }

    fn is_full(&self) -> bool {
        self.count >= MEMORY
    }

    /// Largest of the last errors; zero without any.
    fn reference(&self) -> f64 {
        self.recent.iter().copied().fold(0.0, f64::max)
    }
}

impl State {
    /// Chooses μ; a new μ is a new barrier problem and empties the filter.
    pub fn choose_barrier(&mut self, errors: Errors) {
        let old_mu = self.mu;
        self.update_mu(errors);
        if self.mu != old_mu || self.needs_reset {
            self.filter.reset(errors.theta);
            self.needs_reset = false;
        }
    }

    fn update_mu(&mut self, errors: Errors) {
        let min_barrier = self.options.min_barrier;
        let mut products = Complementarity::default();
        self.vars.complementarity(&mut products);
        self.slacks.complementarity(&mut products);
        let total = errors
            .violation
            .max(errors.dual)
            .max(errors.complementarity);
        let reference = self.progress.reference();
        if self.monotone {
            let barrier_error = errors
                .dual
                .max(errors.violation)
                .max((products.max - self.mu).abs());
            if barrier_error <= 10.0 * self.mu {
                self.mu = (0.2 * self.mu).min(self.mu.powf(1.5)).max(min_barrier);
            }
            if total < PROGRESS * reference {
                self.monotone = false;
                self.progress.push(total);
            }
        } else if self.progress.is_full() && total > PROGRESS * reference {
            self.monotone = true;
            self.mu = (0.8 * products.average()).clamp(min_barrier, 1e5);
        } else {
            self.progress.push(total);
        }
        if !self.monotone {
            let tolerance = self.options.complementarity_tolerance;
            let floor = min_barrier.max(0.01 * tolerance.min(products.average()));
            self.mu = products.loqo().clamp(floor, 1e5);
        }
    }
}
