//! Residuals of the optimality conditions and the right-hand side of the Newton system.

use super::InteriorPoint;
use super::state::State;
use crate::barrier::Complementarity;
use crate::kkt::transpose_multiply;
use crate::{ElementData, Options, Problem};

/// Errors at the current point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Errors {
    /// Largest violation of the rows' own bounds.
    pub violation: f64,
    /// Largest dual residual, scaled.
    pub dual: f64,
    /// Largest complementarity product, scaled.
    pub complementarity: f64,
    /// θ = ‖c − s‖ ([`Options::norm`]).
    pub theta: f64,
}

impl Errors {
    /// True if all tolerances are met.
    pub fn within(&self, options: &Options) -> bool {
        self.violation <= options.feasibility_tolerance
            && self.dual <= options.dual_tolerance
            && self.complementarity <= options.complementarity_tolerance
    }

    /// True at a barrier parameter if that is [`Options::enough`].
    pub fn are_enough(&self, options: &Options, barrier: f64) -> bool {
        options.enough.is_some_and(|enough| {
            self.violation <= enough.violation
                && self.dual <= enough.dual
                && barrier <= enough.barrier
        })
    }
}

impl<P: Problem> InteriorPoint<P> {
    /// Errors; `rows` and `residual_x` = ∇f + Jᵀy are written on the way.
    pub(super) fn errors(&mut self, state: &State) -> Errors {
        let (rows, residual_x) = (&mut self.scratch.rows, &mut self.scratch.residual_x);
        gather_rows(&self.data, rows);
        residual_x.fill(0.0);
        for (element, data) in self.structure.elements.iter().zip(&self.data) {
            for (g, &v) in data.gradient.iter().zip(&element.vars) {
                residual_x[v] += g;
            }
        }
        transpose_multiply(
            &self.structure,
            &self.data,
            self.kkt.first_row(),
            &state.y,
            residual_x,
            1.0,
        );
        self.fixed.erase(residual_x);
        let mut multiplier_sum = 0.0;
        let mut dual = 0.0_f64;
        for (i, r) in residual_x.iter().enumerate() {
            dual = dual.max((r - state.vars.z_lower[i] + state.vars.z_upper[i]).abs());
            multiplier_sum += state.vars.z_lower[i] + state.vars.z_upper[i];
        }
        let mut violation = 0.0_f64;
        for i in 0..rows.len() {
            violation = violation.max(state.violation(i, rows[i]));
            if !state.equality[i] {
                dual = dual
                    .max((-state.y[i] - state.slacks.z_lower[i] + state.slacks.z_upper[i]).abs());
            }
            multiplier_sum += state.y[i].abs() + state.slacks.z_lower[i] + state.slacks.z_upper[i];
        }
        let residuals = rows.iter().zip(&state.slacks.value).map(|(c, s)| c - s);
        let count = (residual_x.len() + 2 * rows.len()).max(1) as f64;
        let scale = (multiplier_sum / count / 100.0).max(1.0);
        let mut products = Complementarity::default();
        state.vars.complementarity(&mut products);
        state.slacks.complementarity(&mut products);
        Errors {
            violation,
            dual: dual / scale,
            complementarity: products.max / scale,
            theta: state.options.norm.of(residuals),
        }
    }

    /// True if the objective, the rows and their residuals are numbers.
    pub(super) fn is_finite(&self, objective: f64) -> bool {
        objective.is_finite()
            && self.scratch.rows.iter().all(|r| r.is_finite())
            && self.scratch.residual_x.iter().all(|r| r.is_finite())
    }

    /// Right-hand side of the Newton system with the slacks eliminated.
    pub(super) fn right_hand_side(&mut self, state: &State) {
        for (i, r) in self.scratch.residual_x.iter_mut().enumerate() {
            *r += state.vars.barrier_gradient(i, state.mu);
        }
        for (i, r) in self.scratch.residual_y.iter_mut().enumerate() {
            *r = (self.scratch.rows[i] - state.slacks.value[i]) * state.damping;
            if !state.equality[i] {
                let b = state.y[i] - state.slacks.barrier_gradient(i, state.mu);
                *r -= b / state.slack_sigma(i);
            }
        }
    }
}

/// Row values of all elements, concatenated.
pub(super) fn gather_rows(data: &[ElementData], rows: &mut [f64]) {
    let mut i = 0;
    for element in data {
        rows[i..i + element.values.len()].copy_from_slice(&element.values);
        i += element.values.len();
    }
}
