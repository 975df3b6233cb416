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

/// One of the two nodes of a difference B ⊖ A.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The first node.
    A,
    /// The second node.
    B,
}

impl End {
    /// Sign with which its increments enter the difference.
    pub fn sign(self) -> f64 {
        match self {
            Self::A => -1.0,
            Self::B => 1.0,
        }
    }
}

/// Difference of two neighbouring nodes: value and the blocks of its derivatives.
///
/// All velocity components are listed in the order of the node's increments. ∂ξ/∂A = −X_A and ∂ξ/∂B = X_B, where the
/// X have 6×6 blocks for floating bodies and are the identity for joints.
#[derive(Debug, Clone)]
pub struct Difference {
    /// ξ = B ⊖ A.
    pub xi: Vec<f64>,
    /// Start of the six increments of each floating body.
    pub floating: Vec<usize>,
    /// −∂ξ/∂A of each floating body.
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
            self.by_a[i] = left_jacobian_inverse(&xi);
            self.by_b[i] = right_jacobian_inverse(&xi);
        }
    }

    fn blocks(&self, end: End) -> impl Iterator<Item = (usize, &Matrix6<f64>)> {
        let blocks = match end {
            End::A => &self.by_a,
            End::B => &self.by_b,
        };
        self.floating.iter().copied().zip(blocks)
    }

    /// `m · X` in place, with ∂ξ/∂end = sign · X: only columns of floating bodies change.
    pub fn recombine_columns(&self, m: &mut DMatrix<f64>, end: End) {
        let n = m.nrows();
        for (f, block) in self.blocks(end) {
            let mut columns = m.as_mut_slice()[f * n..(f + 6) * n].chunks_exact_mut(n.max(1));
            let mut six: [&mut [f64]; 6] =
                std::array::from_fn(|_| columns.next().expect("six columns"));
            for r in 0..n {
                let row: [f64; 6] = std::array::from_fn(|k| six[k][r]);
                for (c, column) in six.iter_mut().enumerate() {
                    column[r] = (0..6).map(|k| row[k] * block[(k, c)]).sum();
                }
            }
        }
    }

    /// `Xᵀ · m` in place, with ∂ξ/∂end = sign · X: only rows of floating bodies change.
    pub fn recombine_rows(&self, m: &mut DMatrix<f64>, end: End) {
        for mut column in m.column_iter_mut() {
            self.recombine(column.as_mut_slice(), end);
        }
    }

    /// `Xᵀ · v` in place, with ∂ξ/∂end = sign · X.
    pub fn recombine(&self, v: &mut [f64], end: End) {
        for (f, block) in self.blocks(end) {
            let chained = block.tr_mul(&Vector6::from_row_slice(&v[f..f + 6]));
            v[f..f + 6].copy_from_slice(chained.as_slice());
        }
    }

    /// Lower triangle or, for `all`, every entry of Xᵀ diag(w) Y with the blocks X of `self` at `end` and Y of `other`
    /// at `other_end`: calls `add(row, column, value)` for all that are not zero by structure.
    pub fn weighted_product(
        &self,
        end: End,
        (other, other_end): (&Self, End),
        w: &[f64],
        all: bool,
        mut add: impl FnMut(usize, usize, f64),
    ) {
        for (i, &floating) in self.is_floating.iter().enumerate() {
            if !floating {
                add(i, i, w[i]);
            }
        }
        for ((f, x), (_, y)) in self.blocks(end).zip(other.blocks(other_end)) {
            let weights = Vector6::from_column_slice(&w[f..f + 6]);
            let product = x.tr_mul(&Matrix6::from_fn(|r, c| weights[r] * y[(r, c)]));
            for c in 0..6 {
                for r in (if all { 0 } else { c })..6 {
                    add(f + r, f + c, product[(r, c)]);
                }
            }
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
