//! Rows of pose terms at a node, and the clearances among them.

use std::sync::Arc;

use super::label::label;
use super::node::slot;
use super::{Builder, NodeCost, NodeTerm, Passage, Phase, RowLabel, Subject};
use crate::collision::{Clearances, CollisionModel, Place};
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
        let slot = self.program.nodes[node].slot(frame);
        let term = self.term_rows(element, slot, term, &label);
        self.program.nodes[node].terms.push(term);
    }

    /// Adds rows of a pose term on the way from a node to the next one.
    fn passage_term(
        &mut self,
        (interval, share): (usize, f64),
        frame: usize,
        term: Arc<dyn PoseTerm>,
        label: &RowLabel,
    ) {
        let passages = &mut self.program.intervals[interval].passages;
        let known = passages.iter().position(|p| p.share == share);
        let passage = known.unwrap_or_else(|| {
            passages.push(Passage {
                share,
                frames: vec![],
                terms: vec![],
            });
            passages.len() - 1
        });
        let slot = slot(&mut passages[passage].frames, frame);
        let term = self.term_rows(interval, slot, term, label);
        let passages = &mut self.program.intervals[interval].passages;
        passages[passage].terms.push(term);
    }

    /// Rows of a pose term, with a block that has no columns yet.
    fn term_rows(
        &mut self,
        element: usize,
        slot: usize,
        term: Arc<dyn PoseTerm>,
        label: &RowLabel,
    ) -> NodeTerm {
        let bounds = term.bounds();
        let e = &mut self.program.structure.elements[element];
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
        NodeTerm {
            slot,
            term,
            first_row,
            n_rows,
            block,
        }
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
            let subject = Subject::Pair(pair.a, pair.b);
            let node = match pair.place {
                Place::Node(node) => node,
                Place::Way { interval, share } => {
                    let label = label("clearance between nodes", subject, 1.0, "m");
                    self.passage_term((interval, share), frame, pair.term, &label);
                    continue;
                }
            };
            if paper {
                let slot = self.program.nodes[node].slot(frame);
                let weights = vec![self.program.settings.weights.penalty];
                self.program.nodes[node].costs.push(NodeCost {
                    slot,
                    term: pair.term,
                    weights,
                    kind: CostTerm::Collision,
                });
            } else {
                let label = label("clearance", subject, 1.0, "m");
                self.node_term(node.min(n - 1), node, frame, pair.term, label);
            }
        }
    }
}
