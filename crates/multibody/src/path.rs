//! Six-vectors of the velocity indices from the root to the current joint, laid out for many products at once.
//!
//! In a depth-first walk the ancestors of the current joint sit at positions 0..depth; a sibling overwrites what its
//! brother left behind. Components lie in blocks of four positions, so that products with four ancestors are one pass.

use crate::Model;
use nalgebra::Vector3;
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

/// Products of the vectors of a block with one wrench.
#[inline]
pub(crate) fn products(block: &Block, wrench: &Wrench) -> [f64; LANES] {
    let (f, n) = (&wrench.linear, &wrench.angular);
    let force = plus_scaled(
        plus_scaled(scaled(&block[0], f.x), &block[1], f.y),
        &block[2],
        f.z,
    );
    plus(force, angular_products(block, n))
}

/// Products of the angular parts of a block with one moment.
#[inline]
pub(crate) fn angular_products(block: &Block, moment: &Vector3<f64>) -> [f64; LANES] {
    let first = scaled(&block[3], moment.x);
    plus_scaled(plus_scaled(first, &block[4], moment.y), &block[5], moment.z)
}

// Written out lane by lane, so that the compiler makes vector instructions of them.

#[inline]
fn scaled(row: &[f64; LANES], x: f64) -> [f64; LANES] {
    [x * row[0], x * row[1], x * row[2], x * row[3]]
}

#[inline]
fn plus_scaled(sum: [f64; LANES], row: &[f64; LANES], x: f64) -> [f64; LANES] {
    [
        sum[0] + x * row[0],
        sum[1] + x * row[1],
        sum[2] + x * row[2],
        sum[3] + x * row[3],
    ]
}

#[inline]
pub(crate) fn plus(a: [f64; LANES], b: [f64; LANES]) -> [f64; LANES] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]]
}
