//! Products with the elements' Hessians and Jacobians.

use crate::kernels::{add_scaled, dot};
use crate::{BlockStructure, ElementData, Structure};

/// `out += H x` for a symmetric matrix given by its lower triangle.
pub(crate) fn symmetric_multiply(h: &[f64], n: usize, x: &[f64], out: &mut [f64]) {
    for j in 0..n {
        let column = &h[j * n + j + 1..(j + 1) * n];
        let xj = x[j];
        for (o, hij) in out[j + 1..].iter_mut().zip(column) {
            *o += hij * xj;
        }
        out[j] += h[j * n + j] * xj + dot(column, &x[j + 1..]);
    }
}

/// The columns of a block; none of a block without rows.
fn columns<'a>(jacobian: &'a [f64], block: &BlockStructure) -> std::slice::ChunksExact<'a, f64> {
    jacobian.chunks_exact(block.n_rows.max(1))
}

/// `out += J x` of one block, with `x` over the element's variables and `out` over the block's rows.
pub(crate) fn block_multiply(block: &BlockStructure, jacobian: &[f64], x: &[f64], out: &mut [f64]) {
    if let [out] = out {
        let row = jacobian.iter().zip(&block.cols);
        *out += row.map(|(j, &c)| j * x[c]).sum::<f64>();
        return;
    }
    for (column, &c) in columns(jacobian, block).zip(&block.cols) {
        add_scaled(out, column, x[c]);
    }
}

/// `out += Jᵀ y` of one block, with `out` over the element's variables and `y` over the block's rows.
pub(crate) fn block_transpose_multiply(
    block: &BlockStructure,
    jacobian: &[f64],
    y: &[f64],
    out: &mut [f64],
) {
    if let [y] = y {
        for (x, &c) in jacobian.iter().zip(&block.cols) {
            out[c] += y * x;
        }
        return;
    }
    for (column, &c) in columns(jacobian, block).zip(&block.cols) {
        out[c] += dot(column, y);
    }
}

/// `out += sign · Jᵀ y`.
pub(crate) fn transpose_multiply(
    structure: &Structure,
    data: &[ElementData],
    first_row: &[usize],
    y: &[f64],
    out: &mut [f64],
    sign: f64,
) {
    for (e, (element, data)) in structure.elements.iter().zip(data).enumerate() {
        for (block, jacobian) in element.blocks.iter().zip(&data.jacobians) {
            let first = first_row[e] + block.first_row;
            let rows = first..first + block.n_rows;
            if block.n_rows == 1 {
                let weight = sign * y[first];
                for (x, &c) in jacobian.iter().zip(&block.cols) {
                    out[element.vars[c]] += weight * x;
                }
                continue;
            }
            for (column, &c) in columns(jacobian, block).zip(&block.cols) {
                out[element.vars[c]] += sign * dot(column, &y[rows.clone()]);
            }
        }
    }
}

/// `out += J x`.
pub(crate) fn jacobian_multiply(
    structure: &Structure,
    data: &[ElementData],
    first_row: &[usize],
    x: &[f64],
    out: &mut [f64],
) {
    for (e, (element, data)) in structure.elements.iter().zip(data).enumerate() {
        for (block, jacobian) in element.blocks.iter().zip(&data.jacobians) {
            let first = first_row[e] + block.first_row;
            if block.n_rows == 1 {
                let row = jacobian.iter().zip(&block.cols);
                out[first] += row.map(|(j, &c)| j * x[element.vars[c]]).sum::<f64>();
                continue;
            }
            let out = &mut out[first..first + block.n_rows];
            for (column, &c) in columns(jacobian, block).zip(&block.cols) {
                let xc = x[element.vars[c]];
                for (o, j) in out.iter_mut().zip(column) {
                    *o += j * xc;
                }
            }
        }
    }
}
