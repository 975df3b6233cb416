//! Primal-dual interior-point method with a filter line search.
//!
//! Rows get slacks: c(x) − s = 0 with l ≤ s ≤ u; an equality row keeps s = l. Legend: μ barrier parameter, y row
//! multipliers, z bound multipliers, δ_w diagonal shift.
//!
//! Source: Wächter and Biegler 2006 (algorithm A without its restoration phase, which the regularised rows replace);
//! the barrier parameter follows the adaptive strategy of Nocedal, Wächter, Waltz 2009 with a monotone safeguard.
//! **Departs:** when no step is acceptable the system is shifted and, at last, the least violated point is returned.

use std::time::Instant;

use crate::barrier::{Bounded, Complementarity, push_inside};
use crate::filter::{Current, Filter, Verdict};
use crate::kkt::{Diagonals, Kkt, jacobian_multiply, transpose_multiply};
use crate::{ElementData, Iteration, Options, Problem, Report, Status, Structure, Timing};

/// Bound on one component of a step at most this far, in scaled units; guards wild first steps.
const MAX_SHIFT: f64 = 1e12;
const FIRST_SHIFT: f64 = 1e-4;
/// Shift from which on the curvature of the rows is dropped instead (Gauss–Newton).
const GN_SHIFT: f64 = 1.0;
/// Share of the distance by which relaxed bounds of violated rows move to their true place per iteration.
const TIGHTENING: f64 = 0.25;
/// Relaxation that is given up in one go [scaled rows].
const CLOSE: f64 = 1e-3;
/// Share of the row violation that a step is asked to remove: at first, and at least.
const FIRST_DAMPING: f64 = 0.25;
const MIN_DAMPING: f64 = 0.1;
/// Violation below which steps ask for all of it.
const FULL_STEP: f64 = 1e-3;
/// Trial points of one line search.
const MAX_TRIALS: usize = 12;
/// Steps shorter than this count as none when a stall is judged.
const JAMMED_STEP: f64 = 0.02;

/// A solver with the memory for one structure.
pub struct InteriorPoint<P: Problem> {
    kkt: Kkt,
    data: Vec<ElementData>,
    trial: Vec<ElementData>,
    _problem: std::marker::PhantomData<P>,
}

/// The mutable state of one solve.
struct State {
    vars: Bounded,
    slacks: Bounded,
    equality: Vec<bool>,
    goal_lower: Vec<f64>,
    goal_upper: Vec<f64>,
    y: Vec<f64>,
    damping: f64,
    mu: f64,
    monotone: bool,
    last_shift: f64,
}

/// Residuals at the current point.
#[derive(Debug, Clone, Copy, Default)]
struct Errors {
    violation: f64,
    dual: f64,
    complementarity: f64,
    theta: f64,
}

struct Direction {
    dx: Vec<f64>,
    dy: Vec<f64>,
    ds: Vec<f64>,
}

impl<P: Problem> InteriorPoint<P> {
    /// Analyses the structure and allocates.
    pub fn new(structure: &Structure) -> Self {
        let data: Vec<_> = structure.elements.iter().map(ElementData::new).collect();
        Self {
            kkt: Kkt::new(structure),
            trial: data.clone(),
            data,
            _problem: std::marker::PhantomData,
        }
    }

    /// Bytes held by the factor.
    pub fn memory(&self) -> usize {
        self.kkt.memory()
    }

    /// Minimises from `x`, which is replaced by the last (or, when it gives up, the least violated) point.
    ///
    /// `observe` is called once per iteration and stops the solve by returning false.
    #[allow(clippy::too_many_lines)] // the algorithm's main loop, in the order of its source
    pub fn solve(
        &mut self,
        problem: &mut P,
        x: &mut P::Point,
        options: &Options,
        warm_multipliers: Option<&[f64]>,
        observe: &mut dyn FnMut(&Iteration) -> bool,
    ) -> Report {
        let begin = Instant::now();
        let mut timing = Timing::default();
        let structure = problem.structure().clone();
        let (n, m) = (structure.n_vars, self.kkt.n_rows());
        let mut state = self.start(problem, &structure, x, options, warm_multipliers);
        let mut filter = Filter::default();
        let mut direction = Direction {
            dx: vec![0.0; n],
            dy: vec![0.0; m],
            ds: vec![0.0; m],
        };
        let mut trial_x = x.clone();
        let mut rows = vec![0.0; m];
        let mut residual_x = vec![0.0; n];
        let (mut diag_x, mut diag_y, mut residual_y) = (vec![0.0; n], vec![0.0; m], vec![0.0; m]);
        let mut best: Option<(f64, P::Point, Vec<f64>)> = None;
        let mut kkt_history: Vec<f64> = Vec::new();
        let mut violation_history: Vec<(f64, f64)> = Vec::new();
        let mut line = Iteration {
            number: 0,
            objective: 0.0,
            violation: 0.0,
            dual: 0.0,
            barrier: state.mu,
            step: 0.0,
            shift: 0.0,
            trials: 0,
        };
        let zeros = vec![0.0; m];
        let mut factorisations = 0;
        let mut status = Status::IterationLimit;
        let mut errors = Errors::default();
        let mut forced_shift = 0.0_f64;
        let mut need_reset = true;
        for number in 0..=options.max_iterations {
            let clock = Instant::now();
            problem.linearise(x, &state.y, &mut self.data);
            timing.linearise += clock.elapsed();
            gather_rows(&self.data, &mut rows);
            errors = self.errors(&structure, &state, &rows, &mut residual_x);
            line = Iteration {
                number,
                objective: self.data.iter().map(|d| d.objective).sum(),
                violation: errors.violation,
                dual: errors.dual,
                barrier: state.mu,
                ..line
            };
            let go_on = observe(&line);
            if best.as_ref().is_none_or(|b| errors.violation < b.0) {
                best = Some((errors.violation, x.clone(), state.y.clone()));
            }
            violation_history.push((errors.violation, line.step));
            let finite = line.objective.is_finite()
                && rows.iter().all(|r| r.is_finite())
                && residual_x.iter().all(|r| r.is_finite());
            if !finite {
                status = Status::Failed;
                break;
            }
            if errors.violation <= options.feasibility_tolerance
                && errors.dual <= options.dual_tolerance
                && errors.complementarity <= options.complementarity_tolerance
            {
                status = Status::Solved;
                break;
            }
            if !go_on || begin.elapsed().as_secs_f64() > options.time_limit {
                status = Status::Interrupted;
                break;
            }
            if stalled(&violation_history, options) {
                status = Status::Stalled;
                break;
            }
            if number == options.max_iterations {
                break;
            }

            let old_mu = state.mu;
            Self::choose_barrier(&mut state, errors, &mut kkt_history, options);
            if state.mu != old_mu || need_reset {
                filter.reset(errors.theta);
                need_reset = false;
            }

            // Newton direction, with the least shift that gives the right inertia.
            Self::right_hand_side(&state, &rows, &mut residual_x, &mut residual_y);
            for i in 0..m {
                diag_y[i] = if state.equality[i] {
                    0.0
                } else {
                    1.0 / state.slacks.sigma(i).max(1e-16)
                };
            }
            let clock = Instant::now();
            let mut shift = forced_shift;
            let mut gauss_newton = false;
            loop {
                for i in 0..n {
                    diag_x[i] = state.vars.sigma(i) + shift;
                }
                let diagonals = Diagonals {
                    variables: &diag_x,
                    rows: &diag_y,
                    delta: options.row_regularisation,
                };
                factorisations += 1;
                if self
                    .kkt
                    .factorise(&structure, &self.data, diagonals)
                    .is_ok()
                {
                    break;
                }
                if !gauss_newton && shift >= GN_SHIFT.max(forced_shift) {
                    problem.linearise(x, &zeros, &mut self.data);
                    gauss_newton = true;
                    shift = forced_shift;
                    continue;
                }
                shift = if shift > 0.0 {
                    shift * if state.last_shift == 0.0 { 100.0 } else { 8.0 }
                } else if state.last_shift > 0.0 {
                    (state.last_shift / 3.0).max(1e-9)
                } else {
                    FIRST_SHIFT
                };
                if shift > MAX_SHIFT {
                    break;
                }
            }
            timing.factorise += clock.elapsed();
            if shift > MAX_SHIFT {
                status = Status::Failed;
                break;
            }
            if shift > 0.0 {
                state.last_shift = shift;
            }
            line.shift = if gauss_newton { -1.0 - shift } else { shift };
            let diagonals = Diagonals {
                variables: &diag_x,
                rows: &diag_y,
                delta: options.row_regularisation,
            };
            let clock = Instant::now();
            self.kkt.solve(
                &structure,
                &self.data,
                diagonals,
                &residual_x,
                &residual_y,
                options.refinements,
                &mut direction.dx,
                &mut direction.dy,
            );
            self.slack_steps(
                &structure,
                &state,
                &residual_y,
                options.row_regularisation,
                &mut direction,
            );
            timing.solve += clock.elapsed();

            // Line search on the filter.
            let tau = (1.0 - state.mu).max(0.99);
            let (p1, d1) = state.vars.longest_steps(&direction.dx, state.mu, tau);
            let (p2, d2) = state.slacks.longest_steps(&direction.ds, state.mu, tau);
            let (alpha_max, alpha_dual) = (p1.min(p2), d1.min(d2));
            let now = Current {
                theta: errors.theta,
                phi: line.objective
                    + state.vars.barrier(state.mu, &direction.dx, 0.0)
                    + state.slacks.barrier(state.mu, &direction.ds, 0.0),
                slope: self.slope(&structure, &state, &direction),
            };
            let mut alpha = alpha_max;
            let mut accepted = None;
            line.trials = 0;
            for trial in 0..MAX_TRIALS {
                let clock = Instant::now();
                problem.retract(x, &direction.dx, alpha, &mut trial_x);
                problem.evaluate(&trial_x, &mut self.trial);
                timing.evaluate += clock.elapsed();
                line.trials = trial + 1;
                let (theta, phi) = self.merit(&state, &direction, alpha);
                let verdict = filter.judge(now, alpha, theta, phi);
                if verdict != Verdict::Refused {
                    accepted = Some((alpha, verdict));
                    break;
                }
                if trial == 0 && theta >= errors.theta {
                    // Second-order correction: Wächter and Biegler 2006, section 2.4.
                    let clock = Instant::now();
                    let mut corrected = residual_y.clone();
                    let mut trial_rows = vec![0.0; m];
                    gather_rows(&self.trial, &mut trial_rows);
                    for i in 0..m {
                        let s = state.slacks.value[i] + alpha * direction.ds[i];
                        let now_c = rows[i] - state.slacks.value[i];
                        corrected[i] += (alpha - 1.0) * now_c + trial_rows[i] - s;
                    }
                    let mut second = Direction {
                        dx: vec![0.0; n],
                        dy: vec![0.0; m],
                        ds: vec![0.0; m],
                    };
                    self.kkt.solve(
                        &structure,
                        &self.data,
                        diagonals,
                        &residual_x,
                        &corrected,
                        options.refinements,
                        &mut second.dx,
                        &mut second.dy,
                    );
                    self.slack_steps(
                        &structure,
                        &state,
                        &corrected,
                        options.row_regularisation,
                        &mut second,
                    );
                    timing.solve += clock.elapsed();
                    let (p1, _) = state.vars.longest_steps(&second.dx, state.mu, tau);
                    let (p2, _) = state.slacks.longest_steps(&second.ds, state.mu, tau);
                    let alpha_second = p1.min(p2);
                    problem.retract(x, &second.dx, alpha_second, &mut trial_x);
                    problem.evaluate(&trial_x, &mut self.trial);
                    let (theta, phi) = self.merit(&state, &second, alpha_second);
                    let verdict = filter.judge(now, alpha, theta, phi);
                    line.trials += 1;
                    if verdict != Verdict::Refused {
                        direction.dx.copy_from_slice(&second.dx);
                        direction.ds.copy_from_slice(&second.ds);
                        direction.dy.copy_from_slice(&second.dy);
                        accepted = Some((alpha_second, verdict));
                        break;
                    }
                }
                alpha *= 0.5;
            }
            let Some((alpha, verdict)) = accepted else {
                // No acceptable step: shift the system and forget the filter; after that, give up.
                if forced_shift > 1e6 {
                    status = Status::Failed;
                    break;
                }
                forced_shift = (forced_shift * 100.0).max(1e-2).max(shift * 10.0);
                need_reset = true;
                line.step = 0.0;
                continue;
            };
            forced_shift = if forced_shift > 1e-3 {
                forced_shift * 0.1
            } else {
                0.0
            };
            if verdict == Verdict::Filter {
                filter.add(now);
            }

            // Move.
            state
                .vars
                .step_multipliers(&direction.dx, state.mu, alpha_dual);
            state
                .slacks
                .step_multipliers(&direction.ds, state.mu, alpha_dual);
            std::mem::swap(x, &mut trial_x);
            problem.coordinates(x, &mut state.vars.value);
            for i in 0..m {
                state.slacks.value[i] += alpha * direction.ds[i];
                state.y[i] += alpha * direction.dy[i];
            }
            for i in 0..m {
                if !state.equality[i] {
                    let (l, u, v) = (
                        state.slacks.lower[i],
                        state.slacks.upper[i],
                        state.slacks.value[i],
                    );
                    let (mut new_l, mut new_u) = (l, u);
                    if l < state.goal_lower[i] {
                        let full = state.goal_lower[i] - l;
                        new_l = if full < CLOSE {
                            state.goal_lower[i]
                        } else {
                            l + TIGHTENING * full
                        };
                    }
                    if u > state.goal_upper[i] {
                        let full = u - state.goal_upper[i];
                        new_u = if full < CLOSE {
                            state.goal_upper[i]
                        } else {
                            u - TIGHTENING * full
                        };
                    }
                    if new_l != l || new_u != u {
                        let room = 0.25 * (new_u - new_l);
                        let low = new_l + (v - l).min(0.01).min(room);
                        let high = new_u - (u - v).min(0.01).min(room);
                        state.slacks.lower[i] = new_l;
                        state.slacks.upper[i] = new_u;
                        state.slacks.value[i] = v.max(low).min(high);
                    }
                }
            }
            state.vars.safeguard(state.mu);
            state.slacks.safeguard(state.mu);
            line.step = alpha;
            if errors.violation < FULL_STEP {
                state.damping = 1.0;
            } else if alpha < 0.3 {
                state.damping = (0.7 * state.damping).max(MIN_DAMPING);
            } else if alpha > 0.5 {
                state.damping = (2.0 * state.damping).min(1.0);
            }
        }
        if status != Status::Solved
            && let Some((violation, point, y)) = best
            && violation < errors.violation
        {
            *x = point;
            state.y = y;
            errors.violation = violation;
            problem.evaluate(x, &mut self.data);
            gather_rows(&self.data, &mut rows);
            line.objective = self.data.iter().map(|d| d.objective).sum();
        }
        timing.total = begin.elapsed();
        Report {
            status,
            iterations: line.number,
            objective: line.objective,
            violation: errors.violation,
            dual: errors.dual,
            multipliers: state.y,
            rows,
            factorisations,
            timing,
        }
    }

    fn start(
        &mut self,
        problem: &mut P,
        structure: &Structure,
        x: &mut P::Point,
        options: &Options,
        warm: Option<&[f64]>,
    ) -> State {
        let (n, m) = (structure.n_vars, self.kkt.n_rows());
        let mut vars = Bounded::new(&structure.lower, &structure.upper);
        problem.coordinates(x, &mut vars.value);
        let mut dx = vec![0.0; n];
        for i in 0..n {
            let (l, u) = (vars.lower[i], vars.upper[i]);
            if l.is_finite() || u.is_finite() {
                dx[i] = push_inside(vars.value[i], l, u, options.bound_push) - vars.value[i];
            } else {
                vars.value[i] = 0.0;
            }
        }
        let mut inside = x.clone();
        problem.retract(x, &dx, 1.0, &mut inside);
        *x = inside;
        problem.coordinates(x, &mut vars.value);
        problem.evaluate(x, &mut self.data);
        let lower: Vec<f64> = structure
            .elements
            .iter()
            .flat_map(|e| e.row_lower.iter().copied())
            .collect();
        let upper: Vec<f64> = structure
            .elements
            .iter()
            .flat_map(|e| e.row_upper.iter().copied())
            .collect();
        let equality: Vec<bool> = lower.iter().zip(&upper).map(|(l, u)| l == u).collect();
        let mut slacks = Bounded::new(&lower, &upper);
        gather_rows(&self.data, &mut slacks.value);
        for i in 0..m {
            if equality[i] {
                // An equality has no slack to move: s = l, no barrier.
                slacks.value[i] = lower[i];
                slacks.lower[i] = f64::NEG_INFINITY;
                slacks.upper[i] = f64::INFINITY;
            } else {
                slacks.lower[i] = lower[i].min(slacks.value[i] - options.bound_push);
                slacks.upper[i] = upper[i].max(slacks.value[i] + options.bound_push);
            }
        }
        let mu = options.initial_barrier;
        vars.start(mu);
        slacks.start(mu);
        let mut y = vec![0.0; m];
        for i in 0..m {
            // Stationarity of the slacks: y = zu − zl.
            y[i] = warm.map_or(slacks.z_upper[i] - slacks.z_lower[i], |w| w[i]);
        }
        State {
            vars,
            slacks,
            equality,
            goal_lower: lower,
            goal_upper: upper,
            y,
            damping: FIRST_DAMPING,
            mu,
            monotone: false,
            last_shift: 0.0,
        }
    }

    /// Residuals; `residual_x` becomes ∇f + Jᵀy − zl + zu.
    fn errors(
        &self,
        structure: &Structure,
        state: &State,
        rows: &[f64],
        residual_x: &mut [f64],
    ) -> Errors {
        residual_x.fill(0.0);
        for (element, data) in structure.elements.iter().zip(&self.data) {
            for (g, &v) in data.gradient.iter().zip(&element.vars) {
                residual_x[v] += g;
            }
        }
        transpose_multiply(
            structure,
            &self.data,
            self.kkt.first_row(),
            &state.y,
            residual_x,
            1.0,
        );
        let mut multiplier_sum = 0.0;
        let mut dual = 0.0_f64;
        for (i, r) in residual_x.iter().enumerate() {
            dual = dual.max((r - state.vars.z_lower[i] + state.vars.z_upper[i]).abs());
            multiplier_sum += state.vars.z_lower[i] + state.vars.z_upper[i];
        }
        let (mut violation, mut theta) = (0.0_f64, 0.0);
        for i in 0..rows.len() {
            let c = rows[i] - state.slacks.value[i];
            theta += c.abs();
            // What counts for the user is the violation of the row's own bounds, not of its slack.
            let real = if state.equality[i] {
                c.abs()
            } else {
                (state.goal_lower[i] - rows[i])
                    .max(rows[i] - state.goal_upper[i])
                    .max(0.0)
            };
            violation = violation.max(real);
            if !state.equality[i] {
                dual = dual
                    .max((-state.y[i] - state.slacks.z_lower[i] + state.slacks.z_upper[i]).abs());
            }
            multiplier_sum += state.y[i].abs() + state.slacks.z_lower[i] + state.slacks.z_upper[i];
        }
        let count = (residual_x.len() + 2 * rows.len()).max(1) as f64;
        let scale = (multiplier_sum / count / 100.0).max(1.0);
        let mut products = Complementarity::default();
        state.vars.complementarity(&mut products);
        state.slacks.complementarity(&mut products);
        Errors {
            violation,
            dual: dual / scale,
            complementarity: products.max / scale,
            theta,
        }
    }

    fn choose_barrier(
        state: &mut State,
        errors: Errors,
        history: &mut Vec<f64>,
        options: &Options,
    ) {
        let mut products = Complementarity::default();
        state.vars.complementarity(&mut products);
        state.slacks.complementarity(&mut products);
        let total = errors
            .violation
            .max(errors.dual)
            .max(errors.complementarity);
        if state.monotone {
            let barrier_error = errors
                .dual
                .max(errors.violation)
                .max((products.max - state.mu).abs());
            if barrier_error <= 10.0 * state.mu {
                state.mu = (0.2 * state.mu)
                    .min(state.mu.powf(1.5))
                    .max(options.min_barrier);
            }
            let reference = history.iter().rev().take(4).copied().fold(0.0, f64::max);
            if total < 0.9999 * reference {
                state.monotone = false;
                history.push(total);
            }
        } else {
            let reference = history.iter().rev().take(4).copied().fold(0.0, f64::max);
            if history.len() >= 4 && total > 0.9999 * reference {
                state.monotone = true;
                state.mu = (0.8 * products.average()).clamp(options.min_barrier, 1e5);
            } else {
                history.push(total);
            }
        }
        if !state.monotone {
            let floor = options
                .min_barrier
                .max(0.01 * options.complementarity_tolerance.min(products.average()));
            state.mu = products.loqo().clamp(floor, 1e5);
        }
    }

    /// Right-hand side of the Newton system with the slacks eliminated.
    fn right_hand_side(
        state: &State,
        rows: &[f64],
        residual_x: &mut [f64],
        residual_y: &mut [f64],
    ) {
        for (i, r) in residual_x.iter_mut().enumerate() {
            *r += state.vars.barrier_gradient(i, state.mu);
        }
        for i in 0..rows.len() {
            residual_y[i] = (rows[i] - state.slacks.value[i]) * state.damping;
            if !state.equality[i] {
                let b = state.y[i] - state.slacks.barrier_gradient(i, state.mu);
                residual_y[i] -= b / state.slacks.sigma(i).max(1e-16);
            }
        }
    }

    /// Steps of the slacks, and multiplier steps made consistent with them to the last digit: with b = y − ∇barrier,
    /// Σ ds − dy = b and J dx − ds = −c. Where Σ is large, an error of the row equation times Σ would spoil the
    /// multiplier, so ds follows from dy there; elsewhere dy follows from ds.
    fn slack_steps(
        &self,
        structure: &Structure,
        state: &State,
        residual_y: &[f64],
        delta: f64,
        direction: &mut Direction,
    ) {
        let Direction { dx, ds, dy } = direction;
        ds.fill(0.0);
        jacobian_multiply(structure, &self.data, self.kkt.first_row(), dx, ds);
        for i in 0..ds.len() {
            if state.equality[i] {
                ds[i] = 0.0;
                continue;
            }
            let sigma = state.slacks.sigma(i).max(1e-16);
            let b = state.y[i] - state.slacks.barrier_gradient(i, state.mu);
            if sigma * delta > 1.0 {
                ds[i] = (dy[i] + b) / sigma;
            } else {
                ds[i] += residual_y[i] + b / sigma;
                dy[i] = sigma * ds[i] - b;
            }
        }
    }

    /// Directional derivative of the barrier objective.
    fn slope(&self, structure: &Structure, state: &State, direction: &Direction) -> f64 {
        let mut slope = 0.0;
        for (element, data) in structure.elements.iter().zip(&self.data) {
            for (g, &v) in data.gradient.iter().zip(&element.vars) {
                slope += g * direction.dx[v];
            }
        }
        for (i, dx) in direction.dx.iter().enumerate() {
            slope += state.vars.barrier_gradient(i, state.mu) * dx;
        }
        for (i, ds) in direction.ds.iter().enumerate() {
            slope += state.slacks.barrier_gradient(i, state.mu) * ds;
        }
        slope
    }

    /// (θ, φ) at the trial point whose values are in `self.trial`.
    fn merit(&self, state: &State, direction: &Direction, alpha: f64) -> (f64, f64) {
        let mut theta = 0.0;
        let mut i = 0;
        for data in &self.trial {
            for c in &data.values {
                theta += (c - state.slacks.value[i] - alpha * direction.ds[i]).abs();
                i += 1;
            }
        }
        let phi = self.trial.iter().map(|d| d.objective).sum::<f64>()
            + state.vars.barrier(state.mu, &direction.dx, alpha)
            + state.slacks.barrier(state.mu, &direction.ds, alpha);
        (theta, phi)
    }
}

fn gather_rows(data: &[ElementData], rows: &mut [f64]) {
    let mut i = 0;
    for element in data {
        rows[i..i + element.values.len()].copy_from_slice(&element.values);
        i += element.values.len();
    }
}

/// True when the last iterations hardly moved and did not lower the violation by a tenth.
fn stalled(history: &[(f64, f64)], options: &Options) -> bool {
    let window = options.stall_iterations;
    if window == 0 || history.len() <= window {
        return false;
    }
    let recent = &history[history.len() - window..];
    let jammed = recent.iter().all(|&(_, step)| step < JAMMED_STEP);
    let (first, last) = (recent[0].0, recent[window - 1].0);
    last > 10.0 * options.feasibility_tolerance && jammed && last > 0.9 * first
}
