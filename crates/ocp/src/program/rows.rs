//! Rows of pose terms at a node, and the clearances among them.

use std::sync::Arc;

use super::label::label;
use super::{Builder, NodeCost, NodeTerm, Phase, RowLabel, Subject};
use crate::collision::{Clearances, CollisionModel};
use crate::objective::CostTerm;
use crate::settings::Preset;
use crate::terms::PoseTerm;
use solver::BlockStructure;

impl Builder<'_> {
    /// Adds rows of a pose term at a node to an element.
    #[allow(clippy::needless_pass_by_value)] // the label is made for this call
    pub(super) fn node_term(
        &mut self,
        element: usize,
        node: usize,
        frame: usize,
        term: Arc<dyn PoseTerm>,
        label: RowLabel,
    ) {
        let p = &mut self.program;
        let bounds = term.bounds();
        let slot = p.nodes[node].slot(frame);
        let e = &mut p.structure.elements[element];
        let (first_row, block, n_rows) = (e.n_rows(), e.blocks.len(), bounds.len());
        for (l, u) in bounds {
            e.row_lower.push(l);
            e.row_upper.push(u);
            self.labels[element].push(label.clone());
        }
        e.blocks.push(BlockStructure {
            first_row,
            n_rows,
            cols: vec![],
        });
        p.nodes[node].terms.push(NodeTerm {
            slot,
            term,
            first_row,
            n_rows,
            block,
        });
    }

    /// Rows (or, with the preset `paper`, costs) of collision pairs.
    pub(super) fn clearances(
        &mut self,
        collisions: &CollisionModel,
        phases: &[Phase],
        clearances: Clearances<'_>,
    ) {
        let n = self.program.n_intervals();
        let paper = self.program.settings.preset == Preset::Paper;
        let pairs = collisions.pairs(&self.program, self.scene, phases, clearances);
        for pair in pairs {
            let key = (
                usize::MAX - 1 - pair.a,
                pair.b.map_or(usize::MAX, |b| usize::MAX - 1 - b),
            );
            let frame = self.keys.iter().position(|k| *k == key).unwrap_or_else(|| {
                self.program
                    .frames
                    .push(collisions.frame(&self.program.system, pair.a, pair.b));
                self.keys.push(key);
                self.keys.len() - 1
            });
            if paper {
                let slot = self.program.nodes[pair.node].slot(frame);
                let weights = vec![self.program.settings.weights.penalty];
                self.program.nodes[pair.node].costs.push(NodeCost {
                    slot,
                    term: pair.term,
                    weights,
                    kind: CostTerm::Collision,
                });
            } else {
                let label = label("clearance", Subject::Pair(pair.a, pair.b), 1.0, "m");
                self.node_term(pair.node.min(n - 1), pair.node, frame, pair.term, label);
            }
        }
    }
}
