//! Rows of an element that have a block of their own, taken together.
//!
//! Many elements have many rows that touch some tens of columns each, in orders of their own, where the columns of all
//! together are not many more: they are packed into one dense matrix, without those that are zero. One product with it is
//! cheaper than those with the rows one by one.

use crate::assembly::{Assembly, Run, runs};
use crate::kernels::{add_scaled, dot, gram_of_rows};
use crate::{BlockStructure, ElementData, ElementStructure};

/// Rows with no more columns stay on their own.
const NARROW: usize = 4;

/// The wide rows of one element.
pub(crate) struct WideRows {
    blocks: Vec<Block>,
    /// The columns of all of them in the order of the front: positions among the element's variables.
    cols: Vec<usize>,
    /// Where these columns lie in the front.
    runs: Vec<Run>,
    /// The rows that were not zero when they were packed last, and their entries, row by row.
    packed: Vec<usize>,
    entries: Vec<f64>,
}

/// One wide row.
struct Block {
    index: usize,
    row: usize,
    /// Where its columns are among those of all rows.
    places: Vec<u32>,
}

impl WideRows {
    /// True of a block that is one wide row.
    pub fn has(block: &BlockStructure) -> bool {
        block.n_rows == 1 && block.cols.len() > NARROW
    }

    /// Those of an element whose variables have these positions in its front.
    pub fn new(element: &ElementStructure, positions: &[usize]) -> Self {
        let blocks = element.blocks.iter().enumerate();
        let wide = || blocks.clone().filter(|b| Self::has(b.1));
        let mut cols: Vec<usize> = wide().flat_map(|b| b.1.cols.iter().copied()).collect();
        cols.sort_unstable_by_key(|&c| positions[c]);
        cols.dedup();
        let place = |c: &usize| cols.partition_point(|&p| positions[p] < positions[*c]) as u32;
        let blocks: Vec<Block> = wide()
            .map(|(index, block)| Block {
                index,
                row: block.first_row,
                places: block.cols.iter().map(place).collect(),
            })
            .collect();
        Self {
            packed: Vec::with_capacity(blocks.len()),
            entries: vec![0.0; blocks.len() * cols.len()],
            runs: runs(cols.iter().map(|&c| positions[c])),
            blocks,
            cols,
        }
    }

    /// Columns of all rows together.
    pub fn width(&self) -> usize {
        self.cols.len()
    }

    /// Most entries of the packed matrix.
    pub fn n_entries(&self) -> usize {
        self.entries.len()
    }

    /// Takes the rows from the element's Jacobians.
    pub fn pack(&mut self, data: &ElementData) {
        self.packed.clear();
        let mut rows = self.entries.chunks_exact_mut(self.cols.len().max(1));
        for block in &self.blocks {
            let jacobian = &data.jacobians[block.index];
            // Not rare: rows that have levelled out.
            if jacobian.iter().all(|x| *x == 0.0) {
                continue;
            }
            let row = rows.next().expect("room for all rows");
            row.fill(0.0);
            for (x, &place) in jacobian.iter().zip(&block.places) {
                row[place as usize] = *x;
            }
            self.packed.push(block.row);
        }
    }

    /// The packed rows: row of the element, and entries.
    fn rows(&self) -> impl Iterator<Item = (usize, &[f64])> {
        let entries = self.entries.chunks_exact(self.cols.len().max(1));
        self.packed.iter().copied().zip(entries)
    }

    /// Adds Jᵀ diag(weight) J to the front, with the weight of each row of the element. `scaled` and `gram` are scratch.
    pub fn add_gram(
        &self,
        weight: impl Fn(usize) -> f64,
        scaled: &mut [f64],
        gram: &mut [f64],
        front: &mut Assembly<'_>,
    ) {
        let (count, width) = (self.packed.len(), self.cols.len());
        if count == 0 {
            return;
        }
        for ((row, entries), scaled) in self.rows().zip(scaled.chunks_exact_mut(width)) {
            let root = weight(row).sqrt();
            for (to, from) in scaled.iter_mut().zip(entries) {
                *to = root * from;
            }
        }
        gram_of_rows(scaled, count, width, gram);
        front.add_symmetric(&self.runs, width, gram);
    }

    /// Adds J x to `out`; `x` over the element's variables, `out` over its rows.
    pub fn multiply(&self, x: &[f64], scratch: &mut [f64], out: &mut [f64]) {
        for (to, &c) in scratch.iter_mut().zip(&self.cols) {
            *to = x[c];
        }
        for (row, entries) in self.rows() {
            out[row] += dot(entries, &scratch[..entries.len()]);
        }
    }

    /// Adds Jᵀ y to `out`; `y` over the element's rows, `out` over its variables.
    pub fn transpose_multiply(&self, y: &[f64], scratch: &mut [f64], out: &mut [f64]) {
        let sums = &mut scratch[..self.cols.len()];
        sums.fill(0.0);
        for (row, entries) in self.rows() {
            add_scaled(sums, entries, y[row]);
        }
        for (sum, &c) in sums.iter().zip(&self.cols) {
            out[c] += sum;
        }
    }
}
