//! Loops over columns of dense matrices.

use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatMut, MatRef, Par};

/// Dot product with eight partial sums, which the compiler vectorises.
#[inline]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (head_a, tail_a) = a.as_chunks::<8>();
    let (head_b, tail_b) = b[..a.len()].as_chunks::<8>();
    for (x, y) in head_a.iter().zip(head_b) {
        for i in 0..8 {
            sums[i] += x[i] * y[i];
        }
    }
    sums.iter().sum::<f64>() + tail_a.iter().zip(tail_b).map(|(x, y)| x * y).sum::<f64>()
}

/// `sums += factor · column`.
#[inline]
pub(crate) fn add_scaled(sums: &mut [f64], column: &[f64], factor: f64) {
    for (sum, x) in sums.iter_mut().zip(column) {
        *sum += factor * x;
    }
}

/// `sums += diag(factors) column`.
#[inline]
pub(crate) fn add_scaled_by(sums: &mut [f64], column: &[f64], factors: &[f64]) {
    for ((sum, x), factor) in sums.iter_mut().zip(column).zip(factors) {
        *sum += factor * x;
    }
}

/// `out` (lower triangle, column-major `n × n`) = aᵀ a with `a` column-major `m × n`.
pub(crate) fn gram(a: &[f64], m: usize, n: usize, out: &mut [f64]) {
    let a = MatRef::from_column_major_slice(&a[..m * n], m, n);
    lower_product(a.transpose(), a, out);
}

/// `out` (lower triangle, column-major `n × n`) = a aᵀ with `a` column-major `n × m`.
pub(crate) fn gram_of_rows(a: &[f64], m: usize, n: usize, out: &mut [f64]) {
    let a = MatRef::from_column_major_slice(&a[..m * n], n, m);
    lower_product(a, a.transpose(), out);
}

/// `out` (lower triangle) = a b.
fn lower_product(a: MatRef<'_, f64>, b: MatRef<'_, f64>, out: &mut [f64]) {
    let n = a.nrows();
    let out = MatMut::from_column_major_slice_mut(&mut out[..n * n], n, n);
    lower(out, Accum::Replace, a, b);
}

/// `out` (lower triangle) += a b.
pub(crate) fn add_lower_product(out: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    lower(out, Accum::Add, a, b);
}

fn lower(out: MatMut<'_, f64>, accumulate: Accum, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    triangular::matmul(
        out,
        BlockStructure::TriangularLower,
        accumulate,
        a,
        BlockStructure::Rectangular,
        b,
        BlockStructure::Rectangular,
        1.0,
        Par::Seq,
    );
}
