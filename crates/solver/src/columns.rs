//! The columns of one block of rows in the front.

use crate::BlockStructure;
use crate::assembly::{NOWHERE, Run, runs};
use crate::kernels::add_scaled_by;

/// Blocks with at least this many Jacobian entries go through the dense kernel.
const DENSE_BLOCK: usize = 600;

/// True of a block for the dense kernel.
pub(crate) fn is_dense(block: &BlockStructure) -> bool {
    block.n_rows * block.cols.len() >= DENSE_BLOCK
}

/// Where the columns of a block lie in the front.
pub(crate) struct Columns {
    /// Those of a dense block after packing, else the block's own.
    pub runs: Vec<Run>,
    /// Number of packed columns.
    pub width: usize,
    /// Column of the block, packed column, and if it is added to one of the same unknown; in the order of the packed ones.
    packing: Vec<(usize, usize, bool)>,
}

impl Columns {
    /// Of columns at these positions of the front. Those of a dense block are packed: in the order of the front, none of
    /// fixed variables, one per unknown.
    pub fn new(positions: impl Iterator<Item = usize>, dense: bool) -> Self {
        if !dense {
            let (runs, packing) = (runs(positions), Vec::new());
            return Self {
                runs,
                width: 0,
                packing,
            };
        }
        let mut cols: Vec<(usize, usize)> = positions.zip(0..).collect();
        cols.retain(|(position, _)| *position != NOWHERE);
        cols.sort_unstable();
        let (mut packing, mut packed) = (Vec::new(), Vec::<usize>::new());
        for (position, column) in cols {
            let again = packed.last() == Some(&position);
            if !again {
                packed.push(position);
            }
            packing.push((column, packed.len() - 1, again));
        }
        Self {
            width: packed.len(),
            runs: runs(packed),
            packing,
        }
    }

    /// `out` = diag(√weights) J with packed columns, column-major. The weights become their roots.
    pub fn scale_rows(&self, jacobian: &[f64], weights: &mut [f64], out: &mut [f64]) {
        let m = weights.len();
        for w in weights.iter_mut() {
            *w = w.sqrt();
        }
        for &(from, to, again) in &self.packing {
            let from = &jacobian[from * m..(from + 1) * m];
            let to = &mut out[to * m..(to + 1) * m];
            if again {
                add_scaled_by(to, from, weights);
            } else {
                for ((to, from), w) in to.iter_mut().zip(from).zip(&*weights) {
                    *to = from * w;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_the_same_unknown_are_added_and_fixed_ones_left_out() {
        let columns = Columns::new([5, 2, NOWHERE, 5, 3].into_iter(), true);
        assert_eq!(columns.runs, runs([2, 3, 5]));
        let jacobian = [1.0, 2.0, 3.0, 4.0, f64::NAN, f64::NAN, 10.0, 20.0, 5.0, 6.0];
        let (mut weights, mut out) = ([4.0, 9.0], [f64::NAN; 6]);
        columns.scale_rows(&jacobian, &mut weights, &mut out);
        assert_eq!(out, [6.0, 12.0, 10.0, 18.0, 22.0, 66.0]);
    }
}
