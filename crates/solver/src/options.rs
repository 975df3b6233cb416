//! Options of the solver.

/// Options of one solve; the defaults are those of the sources named in the crate documentation unless said.
#[derive(Debug, Clone)]
pub struct Options {
    /// Most iterations.
    pub max_iterations: usize,
    /// Largest row violation at a solution, in the problem's scaled rows.
    pub feasibility_tolerance: f64,
    /// The same for an end without a solution of the other conditions ([`crate::Status::Acceptable`]).
    pub acceptable_tolerance: f64,
    /// How many iterations it must hold for, and the objective stand still, before that end; 0: never.
    pub acceptable_iterations: usize,
    /// Largest scaled dual residual at a solution.
    pub dual_tolerance: f64,
    /// Largest complementarity product at a solution.
    pub complementarity_tolerance: f64,
    /// First barrier parameter.
    pub initial_barrier: f64,
    /// Smallest barrier parameter.
    pub min_barrier: f64,
    /// Regularisation of the rows in the factorisation; refinement removes its effect.
    pub row_regularisation: f64,
    /// Rounds of iterative refinement.
    pub refinements: usize,
    /// Relative distance kept from bounds at the start.
    pub bound_push: f64,
    /// Share of the row violation that the first step is asked to remove.
    pub first_damping: f64,
    /// Share of the distance by which relaxed bounds of violated rows move to their true place per iteration.
    pub tightening: f64,
    /// Does the filter stay when relaxed bounds move, and not only while the barrier parameter stays.
    pub keeps_filter: bool,
    /// Norm of the residuals c − s that the filter compares.
    pub norm: Norm,
    /// What changes where the Newton system has the wrong inertia.
    pub convexification: Convexification,
    /// Wall time limit [s].
    pub time_limit: f64,
    /// Stop when this many iterations made short steps and hardly lowered the least violation; 0: never.
    pub stall_iterations: usize,
    /// Stop ([`crate::Status::Enough`]) at a point that is so near to a solution; `None`: go on to the solution.
    pub enough: Option<Enough>,
    /// Threads that factorise and solve the Newton systems; two at most are of use. The results are the same.
    pub threads: usize,
}

/// What changes where the Newton system has the wrong inertia, until it has the right one.
///
/// A shift of the diagonal that makes up for the negative curvature of some rows holds back everything else too. Long motions
/// take about a fifth fewer iterations with less curvature instead; configurations gain nothing, and more of them end
/// without being found (`benches/runs/2026-11-26-curvature.md`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Convexification {
    /// The rows' curvature is halved again and again, with a small shift that doubles.
    Curvature,
    /// The diagonal is shifted more and more; where it takes much the rows' curvature is dropped.
    Shift,
}

/// How residuals of many rows make one number θ.
///
/// A step that mends a few rows leaves small residuals in all that are curved. Their sum may be more than what is mended, so that
/// only short steps are accepted; less so the root of the sum of their squares.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Norm {
    /// ‖·‖₁.
    Sum,
    /// ‖·‖₂.
    Euclidean,
}

impl Norm {
    /// θ of these residuals.
    pub fn of(self, residuals: impl Iterator<Item = f64>) -> f64 {
        match self {
            Self::Sum => residuals.map(f64::abs).sum(),
            Self::Euclidean => residuals.map(|c| c * c).sum::<f64>().sqrt(),
        }
    }
}

/// What is enough where a solution need not be one to the last digit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Enough {
    /// Largest row violation, in the problem's scaled rows.
    pub violation: f64,
    /// Largest scaled dual residual.
    pub dual: f64,
    /// Largest barrier parameter.
    pub barrier: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            max_iterations: 200,
            feasibility_tolerance: 1e-7,
            acceptable_tolerance: 1e-5,
            acceptable_iterations: 0,
            dual_tolerance: 1e-4,
            complementarity_tolerance: 1e-4,
            initial_barrier: 5e-3,
            min_barrier: 1e-8,
            row_regularisation: 1e-7,
            refinements: 2,
            bound_push: 1e-2,
            first_damping: 0.25,
            tightening: 0.25,
            keeps_filter: false,
            norm: Norm::Sum,
            convexification: Convexification::Curvature,
            time_limit: f64::INFINITY,
            stall_iterations: 15,
            enough: None,
            threads: 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_small_residuals_outweigh_a_large_one_in_the_sum_and_not_in_the_euclidean_norm() {
        let many = || std::iter::repeat_n(-1e-5, 10_000);
        let large = || std::iter::once(7e-3);
        assert!(Norm::Sum.of(many()) > 10.0 * Norm::Sum.of(large()));
        assert!(Norm::Euclidean.of(many()) < 0.2 * Norm::Euclidean.of(large()));
        assert!(Norm::Sum.of([f64::NAN, 1.0].into_iter()).is_nan());
    }
}
