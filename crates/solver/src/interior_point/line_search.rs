//! Line search on the filter, with a second-order correction of the first trial.
//!
//! Source: Wächter and Biegler 2006, sections 2.3 and 2.4.

use std::time::Instant;

use super::InteriorPoint;
use super::residuals::gather_rows;
use super::state::State;
use crate::Problem;
use crate::filter::{Current, Verdict};

/// Trial points of one line search, the corrected one not counted.
const MAX_TRIALS: usize = 12;

/// Result of a line search; the accepted step is in the scratch's `step`, its point in `trial_x`.
pub(super) struct Search {
    /// Primal step length and why it is acceptable.
    pub accepted: Option<(f64, Verdict)>,
    /// Step length of the bound multipliers.
    pub alpha_dual: f64,
    /// Trial points.
    pub trials: usize,
}

impl<P: Problem> InteriorPoint<P> {
    /// What the filter compares trial points with.
    pub(super) fn current(&self, state: &State, objective: f64, theta: f64) -> Current {
        let step = &self.scratch.step;
        Current {
            theta,
            phi: objective
                + state.vars.barrier(state.mu, &step.dx, 0.0)
                + state.slacks.barrier(state.mu, &step.ds, 0.0),
            slope: self.slope(state),
        }
    }

    /// Shortens the step until the filter accepts a trial point.
    pub(super) fn search(
        &mut self,
        problem: &mut P,
        x: &P::Point,
        trial_x: &mut P::Point,
        state: &State,
        now: Current,
    ) -> Search {
        let (alpha_max, alpha_dual) = self.longest_steps(state);
        let mut search = Search {
            accepted: None,
            alpha_dual,
            trials: 0,
        };
        let mut alpha = alpha_max;
        for trial in 0..MAX_TRIALS {
            let (theta, phi) = self.merit_at(problem, x, trial_x, state, alpha);
            search.trials = trial + 1;
            let verdict = state.filter.judge(now, alpha, theta, phi);
            if verdict != Verdict::Refused {
                search.accepted = Some((alpha, verdict));
                break;
            }
            if trial == 0 && theta >= now.theta {
                search.trials += 1;
                search.accepted = self.correct(problem, x, trial_x, state, now, alpha);
                if search.accepted.is_some() {
                    break;
                }
            }
            alpha *= 0.5;
        }
        search
    }

    /// Second-order correction of the refused step of length `alpha`: replaces the step if its point is acceptable.
    fn correct(
        &mut self,
        problem: &mut P,
        x: &P::Point,
        trial_x: &mut P::Point,
        state: &State,
        now: Current,
        alpha: f64,
    ) -> Option<(f64, Verdict)> {
        let scratch = &mut self.scratch;
        gather_rows(&self.trial, &mut scratch.trial_rows);
        for (i, corrected) in scratch.corrected.iter_mut().enumerate() {
            let s = state.slacks.value[i] + alpha * scratch.step.ds[i];
            let now_c = scratch.rows[i] - state.slacks.value[i];
            *corrected =
                scratch.residual_y[i] + ((alpha - 1.0) * now_c + scratch.trial_rows[i] - s);
        }
        self.corrected_step(state);
        std::mem::swap(&mut self.scratch.step, &mut self.scratch.second);
        let (alpha_second, _) = self.longest_steps(state);
        let (theta, phi) = self.merit_at(problem, x, trial_x, state, alpha_second);
        let verdict = state.filter.judge(now, alpha, theta, phi);
        if verdict == Verdict::Refused {
            std::mem::swap(&mut self.scratch.step, &mut self.scratch.second);
            return None;
        }
        Some((alpha_second, verdict))
    }

    /// Largest steps (primal, dual) that keep all distances from bounds positive.
    fn longest_steps(&self, state: &State) -> (f64, f64) {
        let step = &self.scratch.step;
        let tau = (1.0 - state.mu).max(0.99);
        let (p1, d1) = state.vars.longest_steps(&step.dx, state.mu, tau);
        let (p2, d2) = state.slacks.longest_steps(&step.ds, state.mu, tau);
        (p1.min(p2), d1.min(d2))
    }

    /// Directional derivative of the barrier objective.
    fn slope(&self, state: &State) -> f64 {
        let step = &self.scratch.step;
        let mut slope = 0.0;
        for (element, data) in self.structure.elements.iter().zip(&self.data) {
            for (g, &v) in data.gradient.iter().zip(&element.vars) {
                slope += g * step.dx[v];
            }
        }
        for (i, dx) in step.dx.iter().enumerate() {
            slope += state.vars.barrier_gradient(i, state.mu) * dx;
        }
        for (i, ds) in step.ds.iter().enumerate() {
            slope += state.slacks.barrier_gradient(i, state.mu) * ds;
        }
        slope
    }

    /// Moves to the trial point of length `alpha` and evaluates (θ, φ) there.
    fn merit_at(
        &mut self,
        problem: &mut P,
        x: &P::Point,
        trial_x: &mut P::Point,
        state: &State,
        alpha: f64,
    ) -> (f64, f64) {
        let step = &self.scratch.step;
        let clock = Instant::now();
        problem.retract(x, &step.dx, alpha, trial_x);
        problem.evaluate(trial_x, &mut self.trial);
        self.timing.evaluate += clock.elapsed();
        let rows = self.trial.iter().flat_map(|data| &data.values);
        let slacks = (0..).map(|i: usize| state.slacks.value[i] + alpha * step.ds[i]);
        let theta = state.options.norm.of(rows.zip(slacks).map(|(c, s)| c - s));
        let phi = self.trial.iter().map(|d| d.objective).sum::<f64>()
            + state.vars.barrier(state.mu, &step.dx, alpha)
            + state.slacks.barrier(state.mu, &step.ds, alpha);
        (theta, phi)
    }
}
