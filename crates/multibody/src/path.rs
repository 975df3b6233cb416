//! Six-vectors of the velocity indices from the root to the current joint, laid out for many products at once.
//!
//! In a depth-first walk the ancestors of the current joint sit at positions 0..depth; a sibling overwrites what its
//! brother left behind. Components lie in blocks of four positions, so that products with four ancestors are one pass.

use crate::Model;
use spatial::{Twist, Wrench};

/// Positions in one block.
pub(crate) const LANES: usize = 4;

/// One block of six-vectors.
pub(crate) type Block = [[f64; LANES]; 6];

/// `N` six-vectors per position.
#[derive(Debug, Clone)]
pub(crate) struct Path<const N: usize> {
    blocks: Vec<[Block; N]>,
}

impl<const N: usize> Path<N> {
    pub fn new(model: &Model) -> Self {
        let depth = model.supports.iter().map(Vec::len).max().unwrap_or(0);
        Self {
            blocks: vec![[[[f64::NAN; LANES]; 6]; N]; depth.div_ceil(LANES)],
        }
    }

    /// Stores the vectors of the velocity index at `position`.
    #[inline]
    pub fn set(&mut self, position: usize, vectors: [&Twist; N]) {
        let block = &mut self.blocks[position / LANES];
        let lane = position % LANES;
        for (rows, twist) in block.iter_mut().zip(vectors) {
            let (v, w) = (&twist.linear, &twist.angular);
            for (row, x) in rows.iter_mut().zip([v.x, v.y, v.z, w.x, w.y, w.z]) {
                row[lane] = x;
            }
        }
    }

    /// The blocks that hold the first `depth` positions; the rest of the last block is left over from other branches.
    #[inline]
    pub fn blocks(&self, depth: usize) -> &[[Block; N]] {
        &self.blocks[..depth.div_ceil(LANES)]
    }
}

/// Adds the products of the vectors of a block with one wrench.
#[inline]
pub(crate) fn add_products(sums: &mut [f64; LANES], block: &Block, wrench: &Wrench) {
    let (f, n) = (&wrench.linear, &wrench.angular);
    for (row, x) in block.iter().zip([f.x, f.y, f.z, n.x, n.y, n.z]) {
        for (sum, y) in sums.iter_mut().zip(row) {
            *sum += x * y;
        }
    }
}

/// Adds the products of the angular parts of a block with one moment.
#[inline]
pub(crate) fn add_angular_products(
    sums: &mut [f64; LANES],
    block: &Block,
    moment: &nalgebra::Vector3<f64>,
) {
    for (row, x) in block[3..].iter().zip([moment.x, moment.y, moment.z]) {
        for (sum, y) in sums.iter_mut().zip(row) {
            *sum += x * y;
        }
    }
}
