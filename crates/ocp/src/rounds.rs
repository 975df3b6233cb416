//! How a round of solving begins and where it may end.

use crate::motion::SOLVED;
use crate::program::Program;
use crate::settings::{Ending, NEARLY_SOLVED};
use solver::{Enough, Norm, Options};

/// Barrier parameter with which the motion of a sequence with a flight begins, and begins anew: half the iterations of the solver's own
/// (benches/runs/2026-12-01-pushes.md).
const FLIGHT_BARRIER: f64 = 0.5;
/// Barrier parameter and relaxation with which a repair starts from the last solution.
const REPAIR_BARRIER: f64 = 1e-3;
const REPAIR_PUSH: f64 = 1e-4;
/// The same where a coarser grid's motion is the start: that may be far from a solution; nearer if it had velocities too.
const FINER_BARRIER: f64 = 0.1;
const FINEST_BARRIER: f64 = 0.01;
const FINER_PUSH: f64 = 1e-3;
/// Where a motion may end that is the start of another one: mostly within a few per cent of the least cost.
const ROUGH: Enough = Enough {
    violation: NEARLY_SOLVED,
    dual: 5.0,
    barrier: 4e-3,
};
/// Where one may end that is not: within one per cent or two; a tenth of the violation that the checker allows.
const GOOD: Enough = Enough {
    violation: 10.0 * SOLVED,
    dual: 1.0,
    barrier: 5e-4,
};
/// Barrier parameter at which one may end, in the smallest one, where that is larger.
const NEAR_BARRIER: f64 = 1.5;
/// Iterations that stand still within ten times that (a tenth of what the checker allows) before they count as one.
const STILL_ITERATIONS: usize = 10;
/// Complementarity products and dual residual at the solution of a barrier problem: the products come to about the barrier
/// parameter, and the last Newton steps, which make the rows hold, leave far smaller residuals.
const COMPLEMENTARITY: f64 = 10.0;
const BARRIER_DUAL_TOLERANCE: f64 = 0.1;
/// Tolerances where velocities are unknowns: on a fine grid positions are so stiff that refinement of the linear solves
/// gains its last digits slowly.
const STATE_TOLERANCE: f64 = 1e-6;
const STATE_DUAL_TOLERANCE: f64 = 1e-2;
/// With so little regularisation one refinement removes it; on coarse grids, in configurations alone, more rounds with more
/// of it need fewer iterations.
const STATE_REGULARISATION: f64 = 1e-8;
const STATE_REFINEMENTS: usize = 1;

/// How the first round is solved.
#[derive(Clone)]
pub(crate) struct First {
    /// Options of the solver.
    pub options: Options,
    /// Multipliers of the rows.
    pub multipliers: Option<Vec<f64>>,
    /// Most iterations of any round.
    pub max_iterations: usize,
}

impl First {
    /// From a guess.
    fn cold() -> Self {
        Self {
            options: Options::default(),
            multipliers: None,
            max_iterations: usize::MAX,
        }
    }

    /// The same with the barrier parameter that the settings ask for. Guesses of flights are far from any motion.
    pub fn guessed(program: &Program) -> Self {
        let settings = &program.settings;
        let mut first = Self::cold();
        if program.flies.contains(&true) {
            first.options.initial_barrier = FLIGHT_BARRIER;
        }
        if settings.first_barrier > 0.0 {
            first.options.initial_barrier = settings.first_barrier;
        }
        first
    }

    /// The solver's options for a program after so many iterations of earlier rounds.
    pub fn options_of_round(&self, program: &Program, iterations: usize) -> Options {
        let settings = &program.settings;
        let left = settings.max_iterations.saturating_sub(iterations).max(1);
        let mut options = Options {
            max_iterations: left.min(self.max_iterations),
            threads: settings.threads,
            ..self.options.clone()
        };
        if settings.barrier > options.min_barrier {
            options.min_barrier = settings.barrier;
            options.complementarity_tolerance = COMPLEMENTARITY * settings.barrier;
            options.dual_tolerance = BARRIER_DUAL_TOLERANCE;
            options.feasibility_tolerance = SOLVED;
            options.acceptable_iterations = STILL_ITERATIONS;
        }
        options.enough = match settings.ending {
            Ending::Exact => None,
            Ending::Good => Some(Enough {
                barrier: GOOD.barrier.max(NEAR_BARRIER * settings.barrier),
                ..GOOD
            }),
            Ending::Rough => Some(ROUGH),
        };
        if program.has_velocities() {
            options.feasibility_tolerance = STATE_TOLERANCE;
            options.dual_tolerance = STATE_DUAL_TOLERANCE;
            options.row_regularisation = STATE_REGULARISATION;
            options.refinements = STATE_REFINEMENTS;
        }
        options
    }

    /// From a point near a solution.
    pub fn near_solution() -> Self {
        Self::with(REPAIR_BARRIER, REPAIR_PUSH)
    }

    /// From a point that a repair finds far from any solution.
    pub fn far_off(program: &Program) -> Self {
        let mut first = Self::finer();
        if program.flies.contains(&true) {
            first.options.initial_barrier = FLIGHT_BARRIER;
            first.options.bound_push = Options::default().bound_push;
        }
        first
    }

    /// From the motion on a coarser grid.
    pub fn finer() -> Self {
        Self::with(FINER_BARRIER, FINER_PUSH)
    }

    /// The same from one with velocities.
    pub fn finest() -> Self {
        Self::with(FINEST_BARRIER, FINER_PUSH)
    }

    fn with(initial_barrier: f64, bound_push: f64) -> Self {
        Self {
            options: Options {
                initial_barrier,
                bound_push,
                norm: Norm::Euclidean,
                ..Options::default()
            },
            ..Self::cold()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::samples::Sequence;
    use crate::collision::{Clearances, Watched};
    use crate::motion::Planner;
    use crate::program::Grid;
    use crate::settings::{Preset, Settings};

    #[test]
    fn sequences_with_a_flight_begin_farther_from_their_limits() {
        let barriers = |sequence: &str| {
            let Sequence { scene, phases } = Sequence::with_steps(sequence, 4);
            let planner = Planner::new(&scene).unwrap();
            let settings = Settings::new(Preset::Default, &scene.optimiser);
            let nothing = Watched::new();
            let clearances = Clearances::Watched(&nothing);
            let program = planner.program(&phases, &settings, Grid::Motion, clearances);
            let firsts = [First::guessed(&program), First::far_off(&program)];
            firsts.map(|first| first.options.initial_barrier)
        };
        let [jump, walk] = ["flat/jump.toml", "flat/forward_2.toml"].map(barriers);
        assert_eq!(jump, [FLIGHT_BARRIER; 2]);
        assert!(walk.iter().all(|&b| b < FLIGHT_BARRIER), "{walk:?}");
    }
}
