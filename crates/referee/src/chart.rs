//! Tangent coordinates d about a base point, x = base ⊕ d, where some runs of six variables are floating bodies.
//!
//! Body increments are linear before angular. For a floating body base · exp(d + e) ≈ x · exp(Jr(d) e), with Jr the right
//! Jacobian of SE(3); all other variables are plain numbers. With g and H the gradient and the (symmetric) Hessian by
//! increments at x:
//!
//! ```text
//! ∇_d = Jrᵀ g,     ∇²_d = Jrᵀ H Jr + sym(∂(Jrᵀ g)/∂d with g held fixed)
//! ```
//!
//! The last term is the curvature of the chart; it vanishes at d = 0. The antisymmetric part of ∂(Jrᵀ g)/∂d cancels with
//! that of the derivative of g along the group.

use nalgebra::{Matrix6, Vector6};
use spatial::right_jacobian;

/// Step of the central differences of the chart's curvature: error about 1e-10, a Hessian needs less.
const STEP: f64 = 1e-5;

/// Which variables belong to floating bodies.
#[derive(Debug, Clone)]
pub struct Chart {
    /// Per variable the number of its floating body, if it belongs to one.
    body_of: Vec<Option<usize>>,
    /// First variable of each floating body.
    floating: Vec<usize>,
}

impl Chart {
    /// A chart of `n_vars` variables; `floating` are the first variables of each run of six.
    ///
    /// # Panics
    /// If two runs overlap or one leaves the variables.
    pub fn new(n_vars: usize, floating: &[usize]) -> Self {
        let mut body_of = vec![None; n_vars];
        for (body, &first) in floating.iter().enumerate() {
            for entry in &mut body_of[first..first + 6] {
                assert!(entry.is_none(), "floating bodies overlap at {first}");
                *entry = Some(body);
            }
        }
        Self {
            body_of,
            floating: floating.to_vec(),
        }
    }

    /// First variable of each floating body.
    pub fn floating(&self) -> &[usize] {
        &self.floating
    }

    /// The floating body of a variable and the variable's place among its six.
    pub fn place(&self, var: usize) -> Option<(usize, usize)> {
        self.body_of[var].map(|body| (body, var - self.floating[body]))
    }

    /// Jr(d) of every floating body.
    pub fn jacobians(&self, d: &[f64]) -> Vec<Matrix6<f64>> {
        self.floating
            .iter()
            .map(|&first| right_jacobian(&six(d, first)))
            .collect()
    }

    /// Replaces a gradient by increments at x with the one by d.
    pub fn pull_back(&self, jacobians: &[Matrix6<f64>], gradient: &mut [f64]) {
        for (&first, jacobian) in self.floating.iter().zip(jacobians) {
            let pulled = jacobian.tr_mul(&six(gradient, first));
            gradient[first..first + 6].copy_from_slice(pulled.as_slice());
        }
    }

    /// Curvature of the chart of one body, contracted with the gradient `g` by increments at x.
    pub fn curvature(d: &Vector6<f64>, g: &Vector6<f64>) -> Matrix6<f64> {
        let mut m = Matrix6::zeros();
        for j in 0..6 {
            let mut step = Vector6::zeros();
            step[j] = STEP;
            let difference = right_jacobian(&(d + step)) - right_jacobian(&(d - step));
            m.set_column(j, &(difference.tr_mul(g) / (2.0 * STEP)));
        }
        0.5 * (m + m.transpose())
    }
}

/// Six consecutive entries.
pub(crate) fn six(values: &[f64], first: usize) -> Vector6<f64> {
    Vector6::from_column_slice(&values[first..first + 6])
}
