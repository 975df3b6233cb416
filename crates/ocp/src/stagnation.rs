//! When a solve for keyframes or a path has stopped getting anywhere.

use crate::keyframes::KEYFRAME_TOLERANCE;
use solver::Iteration;

/// Iterations after which the violation must have fallen by this share.
const PATIENCE: usize = 12;
const PROGRESS: f64 = 0.1;

/// Ends a solve whose violation has stopped falling.
#[derive(Default)]
pub(crate) struct Stagnation {
    /// Least violation, and the iteration at which it had last fallen clearly.
    best: Option<(f64, usize)>,
}

impl Stagnation {
    /// False once it has.
    pub fn goes_on(&mut self, iteration: &Iteration) -> bool {
        let (violation, number) = (iteration.violation, iteration.number);
        match self.best {
            Some((best, since)) if violation > (1.0 - PROGRESS) * best => {
                best <= KEYFRAME_TOLERANCE || number < since + PATIENCE
            }
            _ => {
                self.best = Some((violation, number));
                true
            }
        }
    }
}
