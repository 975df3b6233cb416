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

use crate::columns::{Columns, is_dense};
use crate::front::{Fronts, NotPositiveDefinite};
use crate::kernels::gram;
use crate::products::{block_multiply, block_transpose_multiply, symmetric_multiply};
pub(crate) use crate::products::{jacobian_multiply, transpose_multiply};
use crate::wide_rows::WideRows;
use crate::{BlockStructure, ElementData, ElementStructure, Structure};

/// Matrix, factorisation and scratch of the Newton system.
pub struct Kkt {
    fronts: Fronts,
    /// First row of each element in the concatenated rows.
    first_row: Vec<usize>,
    places: Vec<Places>,
    /// Scratch: weights of a block's rows, the block scaled by them, their product.
    weights: Vec<f64>,
    scaled: Vec<f64>,
    gram: Vec<f64>,
    var_scratch: Vec<f64>,
    /// What the refinement has not removed yet, by rows, and the right-hand side for the variables that follows from it.
    left_y: Vec<f64>,
    right: Vec<f64>,
    next_right: Vec<f64>,
    /// J dx of one element in the last solve, and of all rows in all solves.
    product: Vec<f64>,
    products: Vec<f64>,
    /// Weights of Jᵀ in the next right-hand side.
    row_weights: Vec<f64>,
    local: Vec<f64>,
    local_out: Vec<f64>,
}

/// Where the columns of an element's blocks lie in its front.
struct Places {
    /// No runs where the block is one of the wide rows.
    blocks: Vec<Columns>,
    wide_rows: WideRows,
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
        let most_rows = structure.elements.iter().map(ElementStructure::n_rows);
        let most_rows = most_rows.max().unwrap_or(0);
        let fronts = Fronts::new(structure);
        let elements = structure.elements.iter().enumerate();
        let places = elements.map(|(e, element)| {
            let positions = fronts.positions(e);
            let of_block = |b: &BlockStructure| {
                let cols = if WideRows::has(b) { &[] } else { &b.cols[..] };
                Columns::new(cols.iter().map(|&c| positions[c]), is_dense(b))
            };
            Places {
                blocks: element.blocks.iter().map(of_block).collect(),
                wide_rows: WideRows::new(element, positions),
            }
        });
        let places: Vec<Places> = places.collect();
        let wide = || places.iter().map(|p| &p.wide_rows);
        let largest_wide = wide().map(WideRows::n_entries).max().unwrap_or(0);
        let widest = widest.max(wide().map(WideRows::width).max().unwrap_or(0));
        Self {
            places,
            fronts,
            first_row,
            weights: vec![0.0; highest],
            scaled: vec![0.0; largest.max(largest_wide)],
            gram: vec![0.0; widest * widest],
            var_scratch: vec![0.0; structure.n_vars],
            left_y: vec![0.0; n_rows],
            right: vec![0.0; structure.n_vars],
            next_right: vec![0.0; structure.n_vars],
            product: vec![0.0; most_rows],
            products: vec![0.0; n_rows],
            row_weights: vec![0.0; n_rows],
            local: vec![0.0; n_local],
            local_out: vec![0.0; n_local],
        }
    }

    /// Number of rows of all elements.
    pub fn n_rows(&self) -> usize {
        self.left_y.len()
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
            gram,
            var_scratch,
            ..
        } = self;
        // The diagonal of a variable enters with the first element that touches it.
        var_scratch.copy_from_slice(diagonals.variables);
        let hessian = |e: usize| Some(&data[e].hessian[..]);
        fronts.factorise_from(hessian, |e, front| {
            let (element, data, places) = (&structure.elements[e], &data[e], &mut places[e]);
            for (j, &v) in element.vars.iter().enumerate() {
                front.add(j, j, var_scratch[v]);
                var_scratch[v] = 0.0;
            }
            let rows = &diagonals.rows[first_row[e]..first_row[e + 1]];
            let weight = |row: usize| 1.0 / (rows[row] + diagonals.delta);
            places.wide_rows.pack(data);
            places.wide_rows.add_gram(weight, scaled, gram, front);
            let blocks = element.blocks.iter().zip(&data.jacobians);
            for ((block, jacobian), places) in blocks.zip(&places.blocks) {
                let m = block.n_rows;
                if m == 0 || places.runs.is_empty() {
                    continue;
                }
                for (r, w) in weights[..m].iter_mut().enumerate() {
                    *w = weight(block.first_row + r);
                }
                let weights = &mut weights[..m];
                if !is_dense(block) {
                    small_gram(jacobian, block.cols.len(), weights, scaled, gram);
                    front.add_symmetric(&places.runs, block.cols.len(), gram);
                    continue;
                }
                places.scale_rows(jacobian, weights, scaled);
                if let [run] = places.runs[..] {
                    front.add_gram(run, m, scaled);
                } else {
                    self::gram(scaled, m, places.width, gram);
                    front.add_symmetric(&places.runs, places.width, gram);
                }
            }
        })
    }

    /// Solves the Newton system for (dx, dy) given the residuals, with `refinements` rounds that remove δ; `data` are those
    /// that were factorised.
    ///
    /// But for rounding, one regularised solve leaves δ dy in the rows and nothing else. Every other round trusts that and
    /// saves the product with the matrix; the others take the rounding errors off too. What is left of the rows, l, enters
    /// the right-hand side of the next solve as Jᵀ (R + δ)⁻¹ l, which is added up while the Jacobians of this one's steps
    /// dy = (R + δ)⁻¹ (l + J dx) are at hand.
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
        let system = System {
            structure,
            data,
            diagonals,
            residual_y,
        };
        dx.fill(0.0);
        dy.fill(0.0);
        self.products.fill(0.0);
        self.left_y.copy_from_slice(residual_y);
        for (i, weight) in self.row_weights.iter_mut().enumerate() {
            *weight = residual_y[i] / (diagonals.rows[i] + diagonals.delta);
        }
        for (right, r) in self.right.iter_mut().zip(residual_x) {
            *right = -r;
        }
        let (weights, first_row) = (&self.row_weights, &self.first_row);
        transpose_multiply(structure, data, first_row, weights, &mut self.right, -1.0);
        for round in 0..=refinements {
            let next = match round {
                last if last == refinements => Next::Nothing,
                even if even % 2 == 0 => Next::Trusted,
                _ => Next::Exact,
            };
            self.next_right.fill(0.0);
            self.fronts.solve(&mut self.right);
            for (a, b) in dx.iter_mut().zip(&self.right) {
                *a += b;
            }
            for e in 0..structure.elements.len() {
                self.step_rows(e, system, next, dx, dy);
            }
            if next == Next::Exact {
                for (i, right) in self.next_right.iter_mut().enumerate() {
                    *right -= residual_x[i] + diagonals.variables[i] * dx[i];
                }
            }
            std::mem::swap(&mut self.right, &mut self.next_right);
        }
    }

    /// Adds the steps of an element's rows for its variables' step in `right` to `dy`; adds what the element has in the
    /// next right-hand side.
    fn step_rows(&mut self, e: usize, system: System<'_>, next: Next, dx: &[f64], dy: &mut [f64]) {
        let Diagonals { rows, delta, .. } = system.diagonals;
        let (element, data) = (&system.structure.elements[e], &system.data[e]);
        let n = element.vars.len();
        let (local, out) = (&mut self.local[..n], &mut self.local_out[..n]);
        for (x, &v) in local.iter_mut().zip(&element.vars) {
            *x = self.right[v];
        }
        let wide = &self.places[e].wide_rows;
        let here = self.first_row[e]..self.first_row[e + 1];
        let product = &mut self.product[..here.len()];
        product.fill(0.0);
        for (block, jacobian) in element.blocks.iter().zip(&data.jacobians) {
            if !WideRows::has(block) {
                let product = &mut product[block.first_row..block.first_row + block.n_rows];
                block_multiply(block, jacobian, local, product);
            }
        }
        wide.multiply(local, &mut self.scaled, product);
        let left = &mut self.left_y[here.clone()];
        let (rows, dy) = (&rows[here.clone()], &mut dy[here.clone()]);
        let weights = &mut self.row_weights[here.clone()];
        let sums = &mut self.products[here.clone()];
        let residual = &system.residual_y[here];
        for i in 0..rows.len() {
            let regularised = rows[i] + delta;
            let step = (left[i] + product[i]) / regularised;
            dy[i] += step;
            sums[i] += product[i];
            match next {
                Next::Nothing => {}
                Next::Trusted => {
                    left[i] = delta * step;
                    weights[i] = left[i] / regularised;
                }
                Next::Exact => {
                    left[i] = residual[i] + sums[i] - rows[i] * dy[i];
                    weights[i] = dy[i] + left[i] / regularised;
                }
            }
        }
        if next == Next::Nothing {
            return;
        }
        out.fill(0.0);
        for (block, jacobian) in element.blocks.iter().zip(&data.jacobians) {
            if !WideRows::has(block) {
                let weights = &weights[block.first_row..block.first_row + block.n_rows];
                block_transpose_multiply(block, jacobian, weights, out);
            }
        }
        wide.transpose_multiply(weights, &mut self.scaled, out);
        if next == Next::Exact {
            for (x, &v) in local.iter_mut().zip(&element.vars) {
                *x = dx[v];
            }
            symmetric_multiply(&data.hessian, n, local, out);
        }
        for (a, &v) in out.iter().zip(&element.vars) {
            self.next_right[v] -= a;
        }
    }
}

/// The system to solve.
#[derive(Clone, Copy)]
struct System<'a> {
    structure: &'a Structure,
    data: &'a [ElementData],
    diagonals: Diagonals<'a>,
    residual_y: &'a [f64],
}

/// What the round after this one removes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Next {
    /// There is none.
    Nothing,
    /// δ dy of this round.
    Trusted,
    /// The residual of the whole system, whose part Jᵀ dy joins Jᵀ (R + δ)⁻¹ l.
    Exact,
}

/// Lower triangle of Jᵀ diag(weights) J into `out`, column-major `n × n`, for `jacobian` column-major `m × n`.
fn small_gram(jacobian: &[f64], n: usize, weights: &[f64], scaled: &mut [f64], out: &mut [f64]) {
    let m = weights.len();
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
