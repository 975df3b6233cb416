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
use crate::front::{Assembly, Fronts, NotPositiveDefinite};
use crate::kernels::gram;
use crate::products::{block_multiply, block_transpose_multiply, symmetric_multiply};
pub(crate) use crate::products::{jacobian_multiply, transpose_multiply};
use crate::wide_rows::WideRows;
use crate::{BlockStructure, ElementData, ElementStructure, Structure};
use std::ops::Range;

/// Matrix, factorisation and scratch of the Newton system.
pub struct Kkt {
    fronts: Fronts,
    /// First row of each element in the concatenated rows.
    first_row: Vec<usize>,
    places: Vec<Places>,
    /// Threads to work on, two at most.
    threads: usize,
    scratch: [Scratch; 2],
    /// What the refinement has not removed yet, by rows, and the right-hand side for the variables that follows from it.
    left_y: Vec<f64>,
    right: Vec<f64>,
    /// J dx of all rows in all solves.
    products: Vec<f64>,
    /// Weights of Jᵀ in the next right-hand side.
    row_weights: Vec<f64>,
}

/// Scratch of one half of the elements.
#[derive(Clone)]
struct Scratch {
    /// Weights of a block's rows, the block scaled by them, their product.
    weights: Vec<f64>,
    scaled: Vec<f64>,
    gram: Vec<f64>,
    /// J dx of one element in the last solve.
    product: Vec<f64>,
    local: Vec<f64>,
    local_out: Vec<f64>,
    /// What the elements have in the next right-hand side for the variables.
    next_right: Vec<f64>,
}

/// Where an element's entries lie in its front.
struct Places {
    /// Variables, among the element's, whose diagonal enters with it.
    diagonal: Vec<usize>,
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
        let fronts = Fronts::new(structure);
        let places = places(structure, &fronts);
        let scratch = Scratch::new(structure, &places);
        Self {
            places,
            fronts,
            first_row,
            threads: 1,
            scratch: [scratch.clone(), scratch],
            left_y: vec![0.0; n_rows],
            right: vec![0.0; structure.n_vars],
            products: vec![0.0; n_rows],
            row_weights: vec![0.0; n_rows],
        }
    }

    /// Works on so many threads from now on; two at most are of use. The results are the same.
    pub fn set_threads(&mut self, threads: usize) {
        self.threads = threads.max(1);
    }

    /// Threads that it works on.
    pub fn threads(&self) -> usize {
        self.threads
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
        let n_first = self.fronts.n_first();
        let (first, second) = self.places.split_at_mut(n_first);
        let [first_scratch, second_scratch] = &mut self.scratch;
        let mut halves = [(0, first, first_scratch), (n_first, second, second_scratch)];
        let first_row = &self.first_row;
        let hessian = |e: usize| Some(&data[e].hessian[..]);
        let [first, second] = &mut halves;
        (self.fronts).factorise_from(
            self.threads,
            [first, second],
            hessian,
            |(begin, places, scratch), e, front| {
                let rows = first_row[e]..first_row[e + 1];
                let diagonals = Diagonals {
                    rows: &diagonals.rows[rows],
                    ..diagonals
                };
                let element = (&structure.elements[e], &data[e]);
                places[e - *begin].assemble(element, diagonals, scratch, front);
            },
        )
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
            let system = System {
                structure,
                data,
                diagonals,
                residual_y,
                first_row: &self.first_row,
                places: &self.places,
                dx,
                next,
            };
            let n_first = self.fronts.n_first();
            let border = self.first_row[n_first];
            let [left_y, products, row_weights] =
                [&mut self.left_y, &mut self.products, &mut self.row_weights];
            let (left, left_after) = left_y.split_at_mut(border);
            let (sums, sums_after) = products.split_at_mut(border);
            let (weights, weights_after) = row_weights.split_at_mut(border);
            let (dy, dy_after) = dy.split_at_mut(border);
            let [scratch, scratch_after] = &mut self.scratch;
            let first = Rows {
                left,
                sums,
                weights,
                dy,
            };
            let second = Rows {
                left: left_after,
                sums: sums_after,
                weights: weights_after,
                dy: dy_after,
            };
            self.fronts.solve_then(
                self.threads,
                &mut self.right,
                |step| system.step_rows(0..n_first, step, first, scratch),
                |step| system.step_rows(n_first..data.len(), step, second, scratch_after),
            );
            for (a, b) in dx.iter_mut().zip(&self.right) {
                *a += b;
            }
            let [first, second] = &self.scratch;
            let both = first.next_right.iter().zip(&second.next_right);
            for (right, (a, b)) in self.right.iter_mut().zip(both) {
                *right = a + b;
            }
            if next == Next::Exact {
                for (i, right) in self.right.iter_mut().enumerate() {
                    *right -= residual_x[i] + diagonals.variables[i] * dx[i];
                }
            }
        }
    }
}

impl Scratch {
    /// For any of these elements.
    fn new(structure: &Structure, places: &[Places]) -> Self {
        let elements = || structure.elements.iter();
        let blocks = || elements().flat_map(|e| &e.blocks);
        let widest = blocks().map(|b| b.cols.len()).max().unwrap_or(0);
        let largest = blocks().map(|b| b.cols.len() * b.n_rows).max().unwrap_or(0);
        let highest = blocks().map(|b| b.n_rows).max().unwrap_or(0);
        let n_local = elements().map(|e| e.vars.len()).max().unwrap_or(0);
        let most_rows = elements().map(ElementStructure::n_rows).max().unwrap_or(0);
        let wide = || places.iter().map(|p| &p.wide_rows);
        let largest_wide = wide().map(WideRows::n_entries).max().unwrap_or(0);
        let widest = widest.max(wide().map(WideRows::width).max().unwrap_or(0));
        Self {
            weights: vec![0.0; highest],
            scaled: vec![0.0; largest.max(largest_wide)],
            gram: vec![0.0; widest * widest],
            product: vec![0.0; most_rows],
            local: vec![0.0; n_local],
            local_out: vec![0.0; n_local],
            next_right: vec![0.0; structure.n_vars],
        }
    }
}

/// Where the entries of each element lie in its front. The diagonal of a variable enters with the first element that touches it.
fn places(structure: &Structure, fronts: &Fronts) -> Vec<Places> {
    let mut has_diagonal = vec![false; structure.n_vars];
    let elements = structure.elements.iter().enumerate();
    let places = elements.map(|(e, element)| {
        let positions = fronts.positions(e);
        let of_block = |b: &BlockStructure| {
            let cols = if WideRows::has(b) { &[] } else { &b.cols[..] };
            Columns::new(cols.iter().map(|&c| positions[c]), is_dense(b))
        };
        let mut first = |v: usize| !std::mem::replace(&mut has_diagonal[v], true);
        let vars = element.vars.iter().enumerate();
        Places {
            diagonal: vars.filter(|(_, v)| first(**v)).map(|(j, _)| j).collect(),
            blocks: element.blocks.iter().map(of_block).collect(),
            wide_rows: WideRows::new(element, positions),
        }
    });
    places.collect()
}

impl Places {
    /// Adds to the front what an element has beside its Hessian: diagonals, of which those of rows are the element's own, and
    /// Jᵀ (R + δ)⁻¹ J.
    fn assemble(
        &mut self,
        (element, data): (&ElementStructure, &ElementData),
        diagonals: Diagonals<'_>,
        scratch: &mut Scratch,
        front: &mut Assembly<'_>,
    ) {
        let Scratch {
            weights,
            scaled,
            gram,
            ..
        } = scratch;
        for &j in &self.diagonal {
            front.add(j, j, diagonals.variables[element.vars[j]]);
        }
        let weight = |row: usize| 1.0 / (diagonals.rows[row] + diagonals.delta);
        self.wide_rows.pack(data);
        self.wide_rows.add_gram(weight, scaled, gram, front);
        let blocks = element.blocks.iter().zip(&data.jacobians);
        for ((block, jacobian), places) in blocks.zip(&self.blocks) {
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
    }
}

/// The system to solve, and the step of the variables until now.
#[derive(Clone, Copy)]
struct System<'a> {
    structure: &'a Structure,
    data: &'a [ElementData],
    diagonals: Diagonals<'a>,
    residual_y: &'a [f64],
    first_row: &'a [usize],
    places: &'a [Places],
    dx: &'a [f64],
    next: Next,
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

/// The rows of one half of the elements: what is left of them, J dx of all solves, weights of Jᵀ and the step of the multipliers.
struct Rows<'a> {
    left: &'a mut [f64],
    sums: &'a mut [f64],
    weights: &'a mut [f64],
    dy: &'a mut [f64],
}

impl System<'_> {
    /// Adds the steps of these elements' rows for a step of the variables to those of the multipliers; gathers what the elements have
    /// in the next right-hand side.
    fn step_rows(
        self,
        elements: Range<usize>,
        step: &[f64],
        Rows {
            left,
            sums,
            weights,
            dy,
        }: Rows<'_>,
        scratch: &mut Scratch,
    ) {
        let first = self.first_row[elements.start];
        scratch.next_right.fill(0.0);
        for e in elements {
            let here = self.first_row[e] - first..self.first_row[e + 1] - first;
            let rows = Rows {
                left: &mut left[here.clone()],
                sums: &mut sums[here.clone()],
                weights: &mut weights[here.clone()],
                dy: &mut dy[here],
            };
            self.step_element(e, step, rows, scratch);
        }
    }

    fn step_element(&self, e: usize, step: &[f64], here: Rows<'_>, scratch: &mut Scratch) {
        let (element, data) = (&self.structure.elements[e], &self.data[e]);
        let (n, delta) = (element.vars.len(), self.diagonals.delta);
        let (local, out) = (&mut scratch.local[..n], &mut scratch.local_out[..n]);
        for (x, &v) in local.iter_mut().zip(&element.vars) {
            *x = step[v];
        }
        let wide = &self.places[e].wide_rows;
        let Rows {
            left,
            sums,
            weights,
            dy,
        } = here;
        let product = &mut scratch.product[..left.len()];
        product.fill(0.0);
        for (block, jacobian) in element.blocks.iter().zip(&data.jacobians) {
            if !WideRows::has(block) {
                let product = &mut product[block.first_row..block.first_row + block.n_rows];
                block_multiply(block, jacobian, local, product);
            }
        }
        wide.multiply(local, &mut scratch.scaled, product);
        let here = self.first_row[e]..self.first_row[e + 1];
        let (rows, residual) = (&self.diagonals.rows[here.clone()], &self.residual_y[here]);
        for i in 0..rows.len() {
            let regularised = rows[i] + delta;
            let step = (left[i] + product[i]) / regularised;
            dy[i] += step;
            sums[i] += product[i];
            match self.next {
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
        if self.next == Next::Nothing {
            return;
        }
        out.fill(0.0);
        for (block, jacobian) in element.blocks.iter().zip(&data.jacobians) {
            if !WideRows::has(block) {
                let weights = &weights[block.first_row..block.first_row + block.n_rows];
                block_transpose_multiply(block, jacobian, weights, out);
            }
        }
        wide.transpose_multiply(weights, &mut scratch.scaled, out);
        if self.next == Next::Exact {
            for (x, &v) in local.iter_mut().zip(&element.vars) {
                *x += self.dx[v];
            }
            symmetric_multiply(&data.hessian, n, local, out);
        }
        for (a, &v) in out.iter().zip(&element.vars) {
            scratch.next_right[v] -= a;
        }
    }
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
