//! Whether a solve still gets anywhere.

use crate::Options;

/// Steps shorter than this count as none when a stall is judged.
const JAMMED_STEP: f64 = 0.02;

/// Violation and step length of the last iterations.
pub(super) struct Stall {
    /// As many as are judged, the oldest one overwritten by the next.
    recent: Vec<(f64, f64)>,
    count: usize,
}

impl Stall {
    /// Room for the iterations that are judged, which are none if there are not so many.
    pub fn new(options: &Options) -> Self {
        let window = options.stall_iterations;
        let judged = window <= options.max_iterations;
        Self {
            recent: vec![(f64::NAN, f64::NAN); if judged { window } else { 0 }],
            count: 0,
        }
    }

    /// Takes the violation at the current point and the length of the step that led there.
    pub fn push(&mut self, violation: f64, step: f64) {
        if let Some(next) = self.count.checked_rem(self.recent.len()) {
            self.recent[next] = (violation, step);
            self.count += 1;
        }
    }

    /// True when the last iterations hardly moved and did not lower the violation by a tenth.
    pub fn is_stalled(&self, options: &Options) -> bool {
        let window = self.recent.len();
        if window == 0 || self.count <= window {
            return false;
        }
        let jammed = self.recent.iter().all(|&(_, step)| step < JAMMED_STEP);
        let first = self.recent[self.count % window].0;
        let last = self.recent[(self.count - 1) % window].0;
        last > 10.0 * options.feasibility_tolerance && jammed && last > 0.9 * first
    }
}
