//! Factorisation with the least diagonal shift that gives the Newton system the right inertia.
//!
//! Source: Wächter and Biegler 2006, section 3.1. **Departs:** instead of large shifts the curvature of the rows is
//! dropped (Gauss–Newton).

use std::time::Instant;

use super::InteriorPoint;
use super::state::State;
use crate::Problem;
use crate::kkt::Diagonals;

/// Largest shift.
const MAX_SHIFT: f64 = 1e12;
const FIRST_SHIFT: f64 = 1e-4;
/// Shift from which on the curvature of the rows is dropped instead.
const GN_SHIFT: f64 = 1.0;

/// How the system was made positive definite.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shift {
    /// δ_w.
    pub value: f64,
    /// True if the curvature of the rows was dropped.
    gauss_newton: bool,
}

impl Shift {
    /// As the iteration log shows it: below −1 without the curvature of the rows.
    pub fn reported(self) -> f64 {
        if self.gauss_newton {
            -1.0 - self.value
        } else {
            self.value
        }
    }
}

impl<P: Problem> InteriorPoint<P> {
    /// Factorises the Newton system at the current point; `None` if no shift helps.
    pub(super) fn factorise(
        &mut self,
        problem: &mut P,
        x: &P::Point,
        state: &mut State,
    ) -> Option<Shift> {
        let clock = Instant::now();
        for (i, d) in self.scratch.diagonal_y.iter_mut().enumerate() {
            *d = if state.equality[i] {
                0.0
            } else {
                1.0 / state.slack_sigma(i)
            };
        }
        let mut shift = Shift {
            value: state.forced_shift,
            gauss_newton: false,
        };
        while !self.factorise_shifted(state, shift.value) {
            if !shift.gauss_newton && shift.value >= GN_SHIFT.max(state.forced_shift) {
                problem.linearise(x, &self.scratch.no_multipliers, &mut self.data);
                shift.gauss_newton = true;
                shift.value = state.forced_shift;
                continue;
            }
            shift.value = if shift.value > 0.0 {
                shift.value * if state.last_shift == 0.0 { 100.0 } else { 8.0 }
            } else if state.last_shift > 0.0 {
                (state.last_shift / 3.0).max(1e-9)
            } else {
                FIRST_SHIFT
            };
            if shift.value > MAX_SHIFT {
                break;
            }
        }
        self.timing.factorise += clock.elapsed();
        if shift.value > MAX_SHIFT {
            return None;
        }
        if shift.value > 0.0 {
            state.last_shift = shift.value;
        }
        Some(shift)
    }

    /// True if the system with this shift is positive definite.
    fn factorise_shifted(&mut self, state: &State, shift: f64) -> bool {
        for (i, d) in self.scratch.diagonal_x.iter_mut().enumerate() {
            *d = state.vars.sigma(i) + shift;
        }
        let diagonals = Diagonals {
            variables: &self.scratch.diagonal_x,
            rows: &self.scratch.diagonal_y,
            delta: state.options.row_regularisation,
        };
        self.factorisations += 1;
        self.kkt
            .factorise(&self.structure, &self.data, diagonals)
            .is_ok()
    }
}
