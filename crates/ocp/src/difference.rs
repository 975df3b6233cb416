//! From node configurations to velocities and accelerations, and derivatives back.
//!
//! Explicit Euler ("eq:robot_integration", "eq:object_integration") makes both functions of three neighbouring nodes:
//!
//! ```text
//! v = (B ⊖ A) / dt,   v⁺ = (C ⊖ B) / dt⁺,   a = (v⁺ − v) / dt
//! ```
//!
//! A, B, C: configurations of nodes t, t+1, t+2; dt of this interval, dt⁺ of the next. Derivatives of a function of
//! (q, v, a) at node t go through (q, v, v⁺, dt) to (A, B, C, T, T⁺) with dt = T/steps.

use nalgebra::{DMatrix, Matrix6, Vector6};
use spatial::{left_jacobian_inverse, log_hessian, right_jacobian_inverse};

/// Difference of two neighbouring nodes: value and the blocks of its derivatives.
///
/// All velocity components are listed in the order of the node's increments. Floating bodies have 6×6 blocks, joints
/// ±1.
#[derive(Debug, Clone)]
pub struct Difference {
    /// ξ = B ⊖ A.
    pub xi: Vec<f64>,
    /// Start of the six increments of each floating body.
    pub floating: Vec<usize>,
    /// ∂ξ/∂A of each floating body.
    pub by_a: Vec<Matrix6<f64>>,
    /// ∂ξ/∂B of each floating body.
    pub by_b: Vec<Matrix6<f64>>,
    is_floating: Vec<bool>,
}

impl Difference {
    /// Buffers for nodes with `n` increments whose floating bodies start at `floating`.
    pub fn new(n: usize, floating: &[usize]) -> Self {
        let mut is_floating = vec![false; n];
        for &f in floating {
            is_floating[f..f + 6].fill(true);
        }
        Self {
            xi: vec![f64::NAN; n],
            floating: floating.to_vec(),
            by_a: vec![Matrix6::repeat(f64::NAN); floating.len()],
            by_b: vec![Matrix6::repeat(f64::NAN); floating.len()],
            is_floating,
        }
    }

    fn body(&self, i: usize) -> Vector6<f64> {
        let f = self.floating[i];
        Vector6::from_row_slice(&self.xi[f..f + 6])
    }

    /// First derivatives at the present ξ.
    pub fn linearise(&mut self) {
        for i in 0..self.floating.len() {
            let xi = self.body(i);
            self.by_a[i] = -left_jacobian_inverse(&xi);
            self.by_b[i] = right_jacobian_inverse(&xi);
        }
    }

    /// `m · ∂ξ/∂A` (or `∂ξ/∂B`) in place: columns of floating bodies are recombined, the others get the sign.
    pub fn chain_columns(&self, m: &mut DMatrix<f64>, by_b: bool) {
        if !by_b {
            for (c, mut column) in m.column_iter_mut().enumerate() {
                if !self.is_floating[c] {
                    column.neg_mut();
                }
            }
        }
        for (i, &f) in self.floating.iter().enumerate() {
            let block = if by_b { &self.by_b[i] } else { &self.by_a[i] };
            let mut six = m.fixed_columns_mut::<6>(f);
            for mut row in six.row_iter_mut() {
                let chained = &row * block;
                row.copy_from(&chained);
            }
        }
    }

    /// `(∂ξ/∂A)ᵀ · m` (or `(∂ξ/∂B)ᵀ · m`) in place.
    pub fn chain_rows(&self, m: &mut DMatrix<f64>, by_b: bool) {
        for mut column in m.column_iter_mut() {
            self.chain_vector(column.as_mut_slice(), by_b);
        }
    }

    /// `(∂ξ/∂A)ᵀ · v` (or `(∂ξ/∂B)ᵀ · v`) in place.
    pub fn chain_vector(&self, v: &mut [f64], by_b: bool) {
        if !by_b {
            for (x, floating) in v.iter_mut().zip(&self.is_floating) {
                if !floating {
                    *x = -*x;
                }
            }
        }
        for (i, &f) in self.floating.iter().enumerate() {
            let block = if by_b { &self.by_b[i] } else { &self.by_a[i] };
            let chained = block.tr_mul(&Vector6::from_row_slice(&v[f..f + 6]));
            v[f..f + 6].copy_from_slice(chained.as_slice());
        }
    }

    /// Calls `add(block_row, i, block_col, j, value)` (block 0: A, 1: B; i, j: increments) for the curvature of wᵀξ,
    /// lower triangle of the 2×2 block matrix, within-block lower triangle included.
    pub fn curvature(&self, w: &[f64], mut add: impl FnMut(usize, usize, usize, usize, f64)) {
        for (body, &f) in self.floating.iter().enumerate() {
            let weight = Vector6::from_row_slice(&w[f..f + 6]);
            let h = log_hessian(&self.body(body), &weight);
            for j in 0..12 {
                for i in j..12 {
                    add(i / 6, f + i % 6, j / 6, f + j % 6, h[(i, j)]);
                }
            }
        }
    }
}
