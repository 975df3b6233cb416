//! The Newton system of the interior-point method
//!
//! ```text
//! [ W + D   Jᵀ ] [dx]     [r_x]
//! [ J      −R  ] [dy] = − [r_y]
//! ```
//!
//! with the elements' Hessians W, a diagonal D of the variables (bounds, shift) and a diagonal R of the rows: zero
//! for equalities, s/z for inequalities. It is condensed to W + D + Jᵀ (R + δ)⁻¹ J, which is positive definite exactly
//! when the inertia of the system is right, factorised front by front, and refined to remove δ.

use crate::assembly::{Run, runs};
use crate::front::{Fronts, NotPositiveDefinite, dot, gram};
use crate::{BlockStructure, ElementData, Structure};

/// Blocks with at least this many Jacobian entries go through the dense kernel.
const DENSE_BLOCK: usize = 600;

/// Matrix, factorisation and scratch of the Newton system.
pub struct Kkt {
    fronts: Fronts,
    /// First row of each element in the concatenated rows.
    first_row: Vec<usize>,
    places: Vec<Places>,
    /// Scratch: weights of a block's rows, the block scaled by them, their product.
    weights: Vec<f64>,
    scaled: Vec<f64>,
    product: Vec<f64>,
    var_scratch: Vec<f64>,
    row_scratch: Vec<f64>,
    dx_correction: Vec<f64>,
    dy_correction: Vec<f64>,
    /// What the refinement has not removed yet.
    left_x: Vec<f64>,
    left_y: Vec<f64>,
    local: Vec<f64>,
    local_out: Vec<f64>,
}

/// Where an element's variables and the columns of its blocks lie in its front.
struct Places {
    variables: Vec<Run>,
    blocks: Vec<Vec<Run>>,
}

/// The diagonals of the Newton system.
#[derive(Debug, Clone, Copy)]
pub struct Diagonals<'a> {
    /// D per variable.
    pub variables: &'a [f64],
    /// R per row (without δ).
    pub rows: &'a [f64],
    /// δ, added to R in the factorisation only.
    pub delta: f64,
}

impl Kkt {
    /// Analyses the structure and allocates everything.
    pub fn new(structure: &Structure) -> Self {
        let mut first_row = vec![0];
        for e in &structure.elements {
            first_row.push(first_row.last().copied().unwrap_or(0) + e.n_rows());
        }
        let n_rows = first_row[structure.elements.len()];
        let blocks = || structure.elements.iter().flat_map(|e| &e.blocks);
        let widest = blocks().map(|b| b.cols.len()).max().unwrap_or(0);
        let largest = blocks().map(|b| b.cols.len() * b.n_rows).max().unwrap_or(0);
        let highest = blocks().map(|b| b.n_rows).max().unwrap_or(0);
        let n_local = structure
            .elements
            .iter()
            .map(|e| e.vars.len())
            .max()
            .unwrap_or(0);
        let fronts = Fronts::new(structure);
        let elements = structure.elements.iter().enumerate();
        let places = elements.map(|(e, element)| {
            let positions = fronts.positions(e);
            let of_block = |b: &BlockStructure| runs(b.cols.iter().map(|&c| positions[c]));
            Places {
                variables: runs(positions.iter().copied()),
                blocks: element.blocks.iter().map(of_block).collect(),
            }
        });
        Self {
            places: places.collect(),
            fronts,
            first_row,
            weights: vec![0.0; highest],
            scaled: vec![0.0; largest],
            product: vec![0.0; widest * widest],
            var_scratch: vec![0.0; structure.n_vars],
            row_scratch: vec![0.0; n_rows],
            dx_correction: vec![0.0; structure.n_vars],
            dy_correction: vec![0.0; n_rows],
            left_x: vec![0.0; structure.n_vars],
            left_y: vec![0.0; n_rows],
            local: vec![0.0; n_local],
            local_out: vec![0.0; n_local],
        }
    }

    /// Number of rows of all elements.
    pub fn n_rows(&self) -> usize {
        self.row_scratch.len()
    }

    /// First row of each element in the concatenated rows, one entry more than elements.
    pub fn first_row(&self) -> &[usize] {
        &self.first_row
    }

    /// Bytes held by the factor.
    pub fn memory(&self) -> usize {
        self.fronts.memory()
    }

    /// Assembles and factorises.
    ///
    /// # Errors
    /// [`NotPositiveDefinite`]: the inertia is wrong; shift the diagonal.
    pub fn factorise(
        &mut self,
        structure: &Structure,
        data: &[ElementData],
        diagonals: Diagonals<'_>,
    ) -> Result<(), NotPositiveDefinite> {
        let Self {
            fronts,
            first_row,
            places,
            weights,
            scaled,
            product,
            var_scratch,
            ..
        } = self;
        // The diagonal of a variable enters with the first element that touches it.
        var_scratch.copy_from_slice(diagonals.variables);
        fronts.factorise(|e, front| {
            let (element, data, places) = (&structure.elements[e], &data[e], &places[e]);
            let n = element.vars.len();
            front.add_symmetric(&places.variables, n, &data.hessian);
            for (j, &v) in element.vars.iter().enumerate() {
                front.add(j, j, var_scratch[v]);
                var_scratch[v] = 0.0;
            }
            let rows = &diagonals.rows[first_row[e]..first_row[e + 1]];
            let blocks = element.blocks.iter().zip(&data.jacobians);
            for ((block, jacobian), places) in blocks.zip(&places.blocks) {
                let (m, width) = (block.n_rows, block.cols.len());
                // Nothing to add; not rare for rows that have levelled out.
                if m * width == 0 || (m == 1 && jacobian.iter().all(|x| *x == 0.0)) {
                    continue;
                }
                let rows = &rows[block.first_row..block.first_row + m];
                for (w, d) in weights.iter_mut().zip(rows) {
                    *w = 1.0 / (d + diagonals.delta);
                }
                weighted_gram(jacobian, width, &mut weights[..m], scaled, product);
                front.add_symmetric(places, width, product);
            }
        })
    }

    /// Solves the Newton system for (dx, dy) given the residuals, with `refinements` rounds that remove δ.
    ///
    /// But for rounding, one regularised solve leaves δ dy in the rows and nothing else. Every other round trusts that and
    /// saves the product with the matrix; the others take the rounding errors off too.
    #[allow(clippy::too_many_arguments)] // the pieces of one linear system; a struct would only rename them
    pub fn solve(
        &mut self,
        structure: &Structure,
        data: &[ElementData],
        diagonals: Diagonals<'_>,
        residual_x: &[f64],
        residual_y: &[f64],
        refinements: usize,
        dx: &mut [f64],
        dy: &mut [f64],
    ) {
        dx.fill(0.0);
        dy.fill(0.0);
        self.left_x.copy_from_slice(residual_x);
        self.left_y.copy_from_slice(residual_y);
        for round in 0..=refinements {
            if round % 2 == 1 {
                self.left_x.fill(0.0);
                for (left, y) in self.left_y.iter_mut().zip(&self.dy_correction) {
                    *left = diagonals.delta * y;
                }
            } else if round > 0 {
                self.left_x.copy_from_slice(residual_x);
                self.left_y.copy_from_slice(residual_y);
                self.add_product(structure, data, diagonals, dx, dy);
            }
            self.solve_regularised(structure, data, diagonals);
            for (a, b) in dx.iter_mut().zip(&self.dx_correction) {
                *a += b;
            }
            for (a, b) in dy.iter_mut().zip(&self.dy_correction) {
                *a += b;
            }
        }
    }

    /// One solve of what is left with the factorised, regularised system into the correction buffers.
    fn solve_regularised(
        &mut self,
        structure: &Structure,
        data: &[ElementData],
        diagonals: Diagonals<'_>,
    ) {
        let weighted = &mut self.row_scratch;
        for ((w, r), d) in weighted.iter_mut().zip(&self.left_y).zip(diagonals.rows) {
            *w = r / (d + diagonals.delta);
        }
        self.dx_correction
            .iter_mut()
            .zip(&self.left_x)
            .for_each(|(a, r)| *a = -r);
        transpose_multiply(
            structure,
            data,
            &self.first_row,
            weighted,
            &mut self.dx_correction,
            -1.0,
        );
        self.fronts.solve(&mut self.dx_correction);
        self.dy_correction.copy_from_slice(&self.left_y);
        jacobian_multiply(
            structure,
            data,
            &self.first_row,
            &self.dx_correction,
            &mut self.dy_correction,
        );
        for (y, d) in self.dy_correction.iter_mut().zip(diagonals.rows) {
            *y /= d + diagonals.delta;
        }
    }

    /// Adds the (unregularised) system's matrix times (dx, dy) to what is left.
    fn add_product(
        &mut self,
        structure: &Structure,
        data: &[ElementData],
        diagonals: Diagonals<'_>,
        dx: &[f64],
        dy: &[f64],
    ) {
        let (out_x, out_y) = (&mut self.left_x, &mut self.left_y);
        for (element, data) in structure.elements.iter().zip(data) {
            let n = element.vars.len();
            let (x, out) = (&mut self.local[..n], &mut self.local_out[..n]);
            for (a, &v) in x.iter_mut().zip(&element.vars) {
                *a = dx[v];
            }
            symmetric_multiply(&data.hessian, n, x, out);
            for (a, &v) in out.iter().zip(&element.vars) {
                out_x[v] += a;
            }
        }
        for ((o, d), x) in out_x.iter_mut().zip(diagonals.variables).zip(dx) {
            *o += d * x;
        }
        transpose_multiply(structure, data, &self.first_row, dy, out_x, 1.0);
        jacobian_multiply(structure, data, &self.first_row, dx, out_y);
        for ((o, d), y) in out_y.iter_mut().zip(diagonals.rows).zip(dy) {
            *o -= d * y;
        }
    }
}

/// Lower triangle of Jᵀ diag(weights) J into `out`, column-major `n × n`, for `jacobian` column-major `m × n`. The
/// weights are used up.
fn weighted_gram(
    jacobian: &[f64],
    n: usize,
    weights: &mut [f64],
    scaled: &mut [f64],
    out: &mut [f64],
) {
    let m = weights.len();
    if m * n >= DENSE_BLOCK {
        for w in weights.iter_mut() {
            *w = w.sqrt();
        }
        for (to, from) in scaled.chunks_exact_mut(m).zip(jacobian.chunks_exact(m)) {
            for ((to, from), w) in to.iter_mut().zip(from).zip(&*weights) {
                *to = from * w;
            }
        }
        gram(scaled, m, n, out);
        return;
    }
    let row = &mut scaled[..n];
    for r in 0..m {
        for (x, column) in row.iter_mut().zip(jacobian.chunks_exact(m)) {
            *x = column[r];
        }
        for j in 0..n {
            let wj = weights[r] * row[j];
            for (o, x) in out[j * n + j..(j + 1) * n].iter_mut().zip(&row[j..]) {
                *o = if r == 0 { wj * x } else { *o + wj * x };
            }
        }
    }
}

/// `out = H x` for a symmetric matrix given by its lower triangle.
fn symmetric_multiply(h: &[f64], n: usize, x: &[f64], out: &mut [f64]) {
    out.fill(0.0);
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
