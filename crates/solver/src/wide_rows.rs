//! Rows of an element that have a block of their own, taken together.
//!
//! Many elements have many rows that touch some tens of columns each, in orders of their own, where the columns of all
//! together are not many more: they are packed into one dense matrix, without those that are zero. One product with it is
//! cheaper than those with the rows one by one. Columns of the same unknown are one.

use crate::assembly::{Assembly, NOWHERE, Run, runs};
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
    /// Its columns, and where they are among those of all rows; without fixed variables.
    places: Vec<(u32, u32)>,
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
        cols.retain(|&c| positions[c] != NOWHERE);
        cols.sort_unstable_by_key(|&c| positions[c]);
        cols.dedup_by_key(|c| positions[*c]);
        let place = |c: usize| cols.partition_point(|&p| positions[p] < positions[c]) as u32;
        let blocks: Vec<Block> = wide()
            .map(|(index, block)| Block {
                index,
                row: block.first_row,
                places: (0..)
                    .zip(&block.cols)
                    .filter(|(_, c)| positions[**c] != NOWHERE)
                    .map(|(from, &c)| (from, place(c)))
                    .collect(),
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
            for &(from, place) in &block.places {
                row[place as usize] += jacobian[from as usize];
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_rows_multiply_as_they_are_one_by_one() {
        let positions = [3, 0, 5, 1, 4, 2];
        let block = |first_row, cols: &[usize]| BlockStructure {
            first_row,
            n_rows: 1,
            cols: cols.to_vec(),
        };
        let element = ElementStructure {
            vars: (0..6).collect(),
            row_lower: vec![0.0; 4],
            row_upper: vec![0.0; 4],
            blocks: vec![
                block(2, &[5, 0, 1, 2, 3]),
                block(0, &[0, 1]),
                block(3, &[0, 1, 2, 3, 5]),
                block(1, &[1, 0, 3, 2, 5]),
            ],
        };
        let mut data = ElementData::new(&element);
        data.jacobians = vec![
            vec![1.0, 2.0, 3.0, 4.0, 5.0],
            vec![7.0, 7.0],
            vec![0.0; 5],
            vec![-1.0, 0.0, 2.0, 0.5, 3.0],
        ];
        let mut wide = WideRows::new(&element, &positions);
        wide.pack(&data);
        assert_eq!((wide.width(), wide.packed.as_slice()), (5, &[2, 1][..]));

        let x = [1.0, -2.0, 3.0, 0.5, 9.0, 4.0];
        let (mut scratch, mut products) = ([0.0; 15], [0.0; 4]);
        wide.multiply(&x, &mut scratch, &mut products);
        let row = 1.0 * 4.0 + 2.0 * 1.0 + 3.0 * -2.0 + 4.0 * 3.0 + 5.0 * 0.5;
        let other = -1.0 * -2.0 + 2.0 * 0.5 + 0.5 * 3.0 + 3.0 * 4.0;
        assert_eq!(products, [0.0, other, row, 0.0]);

        let mut sums = [0.0; 6];
        wide.transpose_multiply(&[9.0, 2.0, 1.0, 9.0], &mut scratch, &mut sums);
        assert_eq!(sums, [2.0, 1.0, 5.0, 9.0, 0.0, 7.0]);

        let (mut panel, mut gram) = ([0.0; 36], [0.0; 25]);
        let mut front = Assembly {
            panel: &mut panel,
            schur: &mut [],
            n_front: 6,
            n_eliminated: 6,
            of_element: &positions,
        };
        wide.add_gram(|row| row as f64, &mut scratch, &mut gram, &mut front);
        // Variables 0 and 1, at positions 3 and 0: 2 · 2 · 3 of row 2, nothing of row 1.
        assert!((panel[3] - 12.0).abs() < 1e-12);
        // Variable 5 at position 2 with itself: 2 · 1 + 1 · 3².
        assert!((panel[2 * 6 + 2] - 11.0).abs() < 1e-12);
    }
}
