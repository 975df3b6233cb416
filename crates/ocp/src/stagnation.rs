//! When a solve for keyframes or a path has stopped getting anywhere.

use crate::keyframes::KEYFRAME_TOLERANCE;
use solver::Iteration;

/// Iterations after which the violation must have fallen by this share.
const PATIENCE: usize = 12;
const PROGRESS: f64 = 0.1;
/// Least violation from which keyframes are nearly found (m, rad): most that ended so were, once they were given time, and to look for
/// them from other guesses took longer (benches/runs/2026-11-30-nearly-found.md).
const NEARLY: f64 = 1e-2;
/// The same iterations for these.
const PATIENCE_NEARLY: usize = 50;
/// Scaled dual residual from which on they are not: what is left contradicts itself, and multipliers grow (the same record).
const CONTRADICTORY: f64 = 100.0;
/// Most iterations of keyframes that are not nearly found, or not waited for.
pub(crate) const MOST_HURRIED: usize = 80;

/// Ends a solve whose violation has stopped falling.
#[derive(Default)]
pub(crate) struct Stagnation {
    /// Least violation, and the iteration at which it had last fallen clearly.
    best: Option<(f64, usize)>,
    /// Is there more time once it is nearly zero?
    waits: bool,
}

impl Stagnation {
    /// The same with more time for what is nearly found, and less than the solver has for what is not.
    pub fn of_keyframes() -> Self {
        Self {
            waits: true,
            ..Self::default()
        }
    }

    /// False once it has.
    pub fn goes_on(&mut self, iteration: &Iteration) -> bool {
        let (violation, number) = (iteration.violation, iteration.number);
        let falls = |&(best, _): &(f64, usize)| violation <= (1.0 - PROGRESS) * best;
        if self.best.as_ref().is_none_or(falls) {
            self.best = Some((violation, number));
        }
        let (best, since) = self.best.expect("set above");
        let nearly = best <= NEARLY;
        let waits = self.waits && nearly && iteration.dual <= CONTRADICTORY;
        let patience = if waits { PATIENCE_NEARLY } else { PATIENCE };
        let in_time = nearly || !self.waits || number < MOST_HURRIED;
        best <= KEYFRAME_TOLERANCE || number < since + patience && in_time
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The iteration at which a solve ends whose violation falls to some value by the tenth and no further.
    fn end(mut stagnation: Stagnation, least: f64, dual: f64) -> usize {
        let violation = |number: usize| least.max(0.5 * (least / 0.5).powf(number as f64 / 10.0));
        let ends = |&number: &usize| {
            !stagnation.goes_on(&Iteration {
                number,
                violation: violation(number),
                dual,
                ..Iteration::default()
            })
        };
        (0..1000).find(ends).unwrap_or(1000)
    }

    #[test]
    fn keyframes_that_are_nearly_found_have_more_time_than_others_and_than_paths_unless_multipliers_grow()
     {
        let keyframes = Stagnation::of_keyframes;
        assert_eq!(end(keyframes(), 0.1, 1.0), 10 + PATIENCE);
        assert_eq!(end(Stagnation::default(), 5e-3, 1.0), 10 + PATIENCE);
        assert_eq!(end(keyframes(), 5e-3, 1.0), 10 + PATIENCE_NEARLY);
        assert_eq!(end(keyframes(), 5e-3, 1e4), 10 + PATIENCE);
        assert_eq!(end(keyframes(), 5e-5, 1e4), 1000);
    }

    #[test]
    fn keyframes_that_are_far_from_found_end_however_their_violation_falls() {
        let ends = |mut stagnation: Stagnation, first: f64| {
            (0..1000).find(|&number| {
                !stagnation.goes_on(&Iteration {
                    number,
                    violation: first * 0.98_f64.powi(i32::try_from(number).unwrap()),
                    ..Iteration::default()
                })
            })
        };
        assert_eq!(ends(Stagnation::of_keyframes(), 0.5), Some(MOST_HURRIED));
        assert_eq!(ends(Stagnation::default(), 0.5), None);
        // A fifth of it is left by then.
        assert_eq!(ends(Stagnation::of_keyframes(), 0.04), None);
    }
}
