//! One node: its variables, relative frames, rows and costs.

use std::sync::Arc;

use crate::balance::Balance;
use crate::objective::CostTerm;
use crate::terms::PoseTerm;

/// Rows of a pose term at a node.
#[derive(Debug, Clone)]
pub struct NodeTerm {
    /// Position in [`Node::frames`].
    pub slot: usize,
    /// The term.
    pub term: Arc<dyn PoseTerm>,
    /// First row within the element.
    pub first_row: usize,
    /// Number of rows.
    pub n_rows: usize,
    /// Block within the element.
    pub block: usize,
}

/// A cost that is a pose term (summed over its rows).
#[derive(Debug, Clone)]
pub struct NodeCost {
    /// Position in [`Node::frames`].
    pub slot: usize,
    /// The term.
    pub term: Arc<dyn PoseTerm>,
    /// Weight per row.
    pub weights: Vec<f64>,
    /// As what it counts.
    pub kind: CostTerm,
}

/// The variables of a node's increments, or of its velocities.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Variables {
    /// First one of the robot.
    pub robot: usize,
    /// Number of those of the robot.
    pub n_robot: usize,
    /// First one of each object; `None` where it is at rest.
    pub objects: Vec<Option<usize>>,
}

impl Variables {
    /// The variable of a velocity index; `None` where there is nothing to change.
    pub fn get(&self, i: usize) -> Option<usize> {
        match i.checked_sub(self.n_robot) {
            None => Some(self.robot + i),
            Some(k) => self.objects[k / 6].map(|first| first + k % 6),
        }
    }
}

/// One node.
#[derive(Debug, Clone, Default)]
pub struct Node {
    /// Variables of its increments; `None` for a fixed node.
    pub var: Option<Variables>,
    /// Variables of its velocity; `None` where it is no unknown of its own.
    pub velocity_var: Option<Variables>,
    /// Relative frames evaluated here, indices into [`Program::frames`].
    pub frames: Vec<usize>,
    /// Rows.
    pub terms: Vec<NodeTerm>,
    /// Costs.
    pub costs: Vec<NodeCost>,
    /// Weight of the posture cost.
    pub posture: f64,
    /// As what that counts.
    pub posture_kind: CostTerm,
    /// In keyframes, and on fine grids before landings: what is to be balanced on what.
    pub balance: Option<Balance>,
}

impl Node {
    /// Position of a relative frame in [`Node::frames`], where it is put if it is new.
    pub(super) fn slot(&mut self, frame: usize) -> usize {
        slot(&mut self.frames, frame)
    }
}

/// Position of a relative frame among others, to which it is added if it is new.
pub(super) fn slot(frames: &mut Vec<usize>, frame: usize) -> usize {
    frames.iter().position(|&f| f == frame).unwrap_or_else(|| {
        frames.push(frame);
        frames.len() - 1
    })
}
