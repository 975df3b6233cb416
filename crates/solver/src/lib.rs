//! Interior-point solver for stage-structured nonlinear programs
//!
//! ```text
//! min  Σ_e f_e(x)   s.t.  l ≤ c_e(x) ≤ u  (l = u: equality),   lower ≤ x ≤ upper
//! ```
//!
//! where every *element* e touches few variables and the elements follow one another in time. The solver knows no
//! robot: a [`Problem`] gives values and derivatives per element, the solver condenses all rows, factorises the
//! result front by front ([`front`]) and iterates a primal-dual interior-point method ([`interior_point`]).
//!
//! Sources: Wächter and Biegler, "On the implementation of an interior-point filter line-search algorithm for
//! large-scale nonlinear programming" (2006); Nocedal, Wächter, Waltz, "Adaptive barrier update strategies for
//! nonlinear interior methods" (2009); Duff and Reid, "The multifrontal solution of indefinite sparse symmetric
//! linear systems" (1983).

mod assembly;
mod barrier;
mod columns;
mod elimination;
mod filter;
pub mod front;
pub mod interior_point;
mod kernels;
mod kkt;
mod options;
mod problem;
mod products;
mod report;
pub mod threads;
mod wide_rows;

pub use interior_point::InteriorPoint;
pub use kkt::{Diagonals, Kkt};
pub use options::{Convexification, Enough, Norm, Options};
pub use problem::{
    BlockStructure, Contradiction, ElementData, ElementStructure, Problem, Structure,
};
pub use report::{Iteration, Report, Status, Timing};
