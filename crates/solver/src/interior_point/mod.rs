//! Primal-dual interior-point method with a filter line search.
//!
//! Rows get slacks: c(x) − s = 0 with l ≤ s ≤ u; an equality row keeps s = l. A variable with l = u is put there at the
//! start and has no step. Legend: μ barrier parameter, y row multipliers, z bound multipliers, δ diagonal shift,
//! κ share of the rows' curvature.
//!
//! Source: Wächter and Biegler 2006 (algorithm A without its restoration phase, which the regularised rows replace);
//! the barrier parameter follows the adaptive strategy of Nocedal, Wächter, Waltz 2009 with a monotone safeguard.
//! **Departs:** where the inertia is wrong the rows' curvature is reduced ([`crate::Convexification`]); when no step is
//! acceptable the system is shifted and, at last, the least violated point is returned.

mod acceptable;
mod barrier_update;
mod best;
mod contradiction;
mod fixed;
mod inertia;
mod line_search;
mod residuals;
mod stall;
mod state;
mod step;

use std::time::Instant;

use crate::filter::Verdict;
use crate::kkt::Kkt;
use crate::{ElementData, Iteration, Options, Problem, Report, Status, Structure, Timing};
use acceptable::Acceptable;
use best::Best;
use fixed::Fixed;
use residuals::gather_rows;
use stall::Stall;
use step::Direction;

/// A solver with the memory for one structure.
pub struct InteriorPoint<P: Problem> {
    structure: Structure,
    kkt: Kkt,
    fixed: Fixed,
    /// Values and derivatives at the current point.
    data: Vec<ElementData>,
    /// Values at the trial point.
    trial: Vec<ElementData>,
    scratch: Scratch,
    timing: Timing,
    factorisations: usize,
    _problem: std::marker::PhantomData<P>,
}

/// Vectors of one iteration.
struct Scratch {
    /// c(x).
    rows: Vec<f64>,
    /// c at the trial point.
    trial_rows: Vec<f64>,
    /// Residual of the variables: ∇f + Jᵀy, later the right-hand side of the Newton system.
    residual_x: Vec<f64>,
    /// Right-hand side of the rows.
    residual_y: Vec<f64>,
    /// The same for the second-order correction.
    corrected: Vec<f64>,
    /// Diagonals of the Newton system.
    diagonal_x: Vec<f64>,
    diagonal_y: Vec<f64>,
    /// The step, and its second-order correction.
    step: Direction,
    second: Direction,
}

impl<P: Problem> InteriorPoint<P> {
    /// Analyses the structure and allocates; the problems to solve must have this structure, bounds included.
    ///
    /// # Panics
    /// If a variable belongs to no element: such a problem is ill-posed by construction.
    pub fn new(structure: &Structure) -> Self {
        let elements = || structure.elements.iter();
        let kkt = Kkt::new(structure);
        let (n, m) = (structure.n_vars, kkt.n_rows());
        let unwritten = |length: usize| vec![f64::NAN; length];
        Self {
            structure: structure.clone(),
            kkt,
            fixed: Fixed::new(structure),
            data: elements().map(ElementData::new).collect(),
            trial: elements().map(ElementData::of_values).collect(),
            scratch: Scratch {
                rows: unwritten(m),
                trial_rows: unwritten(m),
                residual_x: unwritten(n),
                residual_y: unwritten(m),
                corrected: unwritten(m),
                diagonal_x: unwritten(n),
                diagonal_y: unwritten(m),
                step: Direction::new(n, m),
                second: Direction::new(n, m),
            },
            timing: Timing::default(),
            factorisations: 0,
            _problem: std::marker::PhantomData,
        }
    }

    /// Bytes held by the factor.
    pub fn memory(&self) -> usize {
        self.kkt.memory()
    }

    /// Minimises from `x`, which is replaced by the last (or, when it gives up, the least violated) point.
    ///
    /// `observe` is called once per iteration and stops the solve by returning false. Between two calls nothing is
    /// allocated but by the problem.
    pub fn solve(
        &mut self,
        problem: &mut P,
        x: &mut P::Point,
        options: &Options,
        warm_multipliers: Option<&[f64]>,
        observe: &mut dyn FnMut(&Iteration) -> bool,
    ) -> Report {
        let begin = Instant::now();
        (self.timing, self.factorisations) = (Timing::default(), 0);
        self.kkt.set_threads(options.threads);
        if self.structure.contradiction().is_some() {
            return self.refuse(problem, x);
        }
        let mut state = self.start(problem, x, options, warm_multipliers);
        let mut stall = Stall::new(options);
        let mut acceptable = Acceptable::new(options);
        let mut trial_x = x.clone();
        let mut best = Best::new(x, state.multipliers());
        let mut line = Iteration {
            elements: self.structure.elements.len(),
            ..Iteration::default()
        };
        let mut errors;
        let status = loop {
            self.linearise(problem, x, &state.y);
            errors = self.errors(&state);
            line.objective = self.data.iter().map(|d| d.objective).sum();
            (line.violation, line.dual) = (errors.violation, errors.dual);
            line.barrier = state.mu;
            let go_on = observe(&line);
            best.note(errors.violation, state.multipliers());
            stall.push(errors.violation, line.step);
            acceptable.push(errors.violation, line.objective);
            if !self.is_finite(line.objective) {
                break Status::Failed;
            } else if errors.within(options) {
                break Status::Solved;
            } else if !go_on || begin.elapsed().as_secs_f64() > options.time_limit {
                break Status::Interrupted;
            } else if errors.are_enough(options, state.mu) {
                break Status::Enough;
            } else if acceptable.is_reached() {
                break Status::Acceptable;
            } else if stall.is_stalled() {
                break Status::Stalled;
            } else if line.number == options.max_iterations {
                break Status::IterationLimit;
            }

            state.choose_barrier(errors);
            self.right_hand_side(&state);
            let Some(inertia) = self.factorise(problem, x, &mut state, errors.violation) else {
                break Status::Failed;
            };
            (line.curvature, line.shift) = (inertia.curvature, inertia.shift);
            self.newton_step(&state);
            let now = self.current(&state, line.objective, errors.theta);
            let search = self.search(problem, x, &mut trial_x, &state, now);
            line.trials = search.trials;
            line.step = match search.accepted {
                Some((alpha, verdict)) => {
                    if verdict == Verdict::Filter {
                        state.filter.add(now);
                    }
                    state.step_multipliers(&self.scratch.step, search.alpha_dual);
                    best.advance(x, &mut trial_x);
                    problem.coordinates(x, &mut state.vars.value);
                    state.step_rows(&self.scratch.step, alpha, errors.violation);
                    alpha
                }
                None if state.shift_more(inertia) => 0.0,
                None => break Status::Failed,
            };
            line.number += 1;
        };
        let ended_well = matches!(status, Status::Solved | Status::Acceptable | Status::Enough);
        if !ended_well && best.violation() < errors.violation {
            errors.violation = best.violation();
            let bounds = &mut state.vars;
            best.restore(x, [&mut state.y, &mut bounds.z_lower, &mut bounds.z_upper]);
            problem.evaluate(x, &mut self.data);
            gather_rows(&self.data, &mut self.scratch.rows);
            line.objective = self.data.iter().map(|d| d.objective).sum();
        }
        self.timing.total = begin.elapsed();
        Report {
            status,
            iterations: line.number,
            objective: line.objective,
            violation: errors.violation,
            dual: errors.dual,
            bound_multipliers: state.bound_multipliers(),
            multipliers: state.y,
            rows: self.scratch.rows.clone(),
            factorisations: self.factorisations,
            timing: self.timing,
        }
    }

    /// Values and derivatives at `x`.
    fn linearise(&mut self, problem: &mut P, x: &P::Point, multipliers: &[f64]) {
        let clock = Instant::now();
        problem.linearise(x, multipliers, &mut self.data);
        self.timing.linearise += clock.elapsed();
    }
}
