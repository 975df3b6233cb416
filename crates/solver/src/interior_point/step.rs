//! The Newton step of variables, row multipliers and slacks.

use std::time::Instant;

use super::state::State;
use super::{InteriorPoint, Scratch};
use crate::kkt::{Diagonals, jacobian_multiply};
use crate::{ElementData, Problem, Structure};

/// Steps of the variables, the row multipliers and the slacks.
pub(super) struct Direction {
    pub dx: Vec<f64>,
    pub dy: Vec<f64>,
    pub ds: Vec<f64>,
}

impl Direction {
    /// Room for `n` variables and `m` rows.
    pub fn new(n: usize, m: usize) -> Self {
        Self {
            dx: vec![f64::NAN; n],
            dy: vec![f64::NAN; m],
            ds: vec![f64::NAN; m],
        }
    }

    /// Steps of the slacks, and multiplier steps made consistent with them to the last digit: with b = y − ∇barrier,
    /// Σ ds − dy = b and J dx − ds = −c. Where Σ is large, an error of the row equation times Σ would spoil the
    /// multiplier, so ds follows from dy there; elsewhere dy follows from ds.
    fn add_slacks(
        &mut self,
        structure: &Structure,
        data: &[ElementData],
        first_row: &[usize],
        state: &State,
        residual_y: &[f64],
    ) {
        let Self { dx, dy, ds } = self;
        ds.fill(0.0);
        jacobian_multiply(structure, data, first_row, dx, ds);
        for i in 0..ds.len() {
            if state.equality[i] {
                ds[i] = 0.0;
                continue;
            }
            let sigma = state.slack_sigma(i);
            let b = state.y[i] - state.slacks.barrier_gradient(i, state.mu);
            if sigma * state.options.row_regularisation > 1.0 {
                ds[i] = (dy[i] + b) / sigma;
            } else {
                ds[i] += residual_y[i] + b / sigma;
                dy[i] = sigma * ds[i] - b;
            }
        }
    }
}

impl<P: Problem> InteriorPoint<P> {
    /// The step for `residual_y`, into `step`.
    pub(super) fn newton_step(&mut self, state: &State) {
        self.solve_newton(state, false);
    }

    /// The step for `corrected`, into `second`.
    pub(super) fn corrected_step(&mut self, state: &State) {
        self.solve_newton(state, true);
    }

    fn solve_newton(&mut self, state: &State, corrected: bool) {
        let clock = Instant::now();
        let Scratch {
            residual_x,
            residual_y,
            corrected: corrected_y,
            diagonal_x,
            diagonal_y,
            step,
            second,
            ..
        } = &mut self.scratch;
        let diagonals = Diagonals {
            variables: diagonal_x,
            rows: diagonal_y,
            delta: state.options.row_regularisation,
        };
        let (residual_y, direction) = if corrected {
            (&*corrected_y, second)
        } else {
            (&*residual_y, step)
        };
        self.kkt.solve(
            &self.structure,
            &self.data,
            diagonals,
            residual_x,
            residual_y,
            state.options.refinements,
            &mut direction.dx,
            &mut direction.dy,
        );
        direction.add_slacks(
            &self.structure,
            &self.data,
            self.kkt.first_row(),
            state,
            residual_y,
        );
        self.timing.solve += clock.elapsed();
    }
}
