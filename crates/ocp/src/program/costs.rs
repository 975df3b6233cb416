//! Costs at the nodes: posture, tilt of the base, height of the base at the end.

use std::sync::Arc;

use super::{Builder, NodeCost};
use crate::relative::{Body, Carrier, RelativeFrame};
use crate::terms::{height::Height, tilt::Tilt};
use spatial::Pose;

impl Builder<'_> {
    /// Posture, tilt and height costs of every free node.
    pub(super) fn costs(&mut self) {
        let p = &mut self.program;
        let w = p.settings.weights.clone();
        let world = Carrier {
            body: Body::World,
            body_from_frame: Pose::identity(),
        };
        let base = Carrier {
            body: Body::Joint(0),
            body_from_frame: Pose::identity(),
        };
        p.frames
            .push(RelativeFrame::new(&p.system.model, base, world));
        self.keys.push((usize::MAX, usize::MAX));
        let last = p
            .nodes
            .iter()
            .rposition(|n| n.var.is_some())
            .map(|t| p.master_node(t));
        for t in 0..p.nodes.len() {
            if p.nodes[t].var.is_none() || p.master_node(t) != t {
                continue;
            }
            let is_last = last == Some(t);
            p.nodes[t].posture = if is_last { w.final_posture } else { w.posture };
            let slot = p.nodes[t].slot(0);
            p.nodes[t].costs.push(NodeCost {
                slot,
                term: Arc::new(Tilt),
                weights: vec![w.tilt],
            });
            if is_last && self.scene.objective == scene::Objective::BaseHeight {
                p.nodes[t].costs.push(NodeCost {
                    slot,
                    term: Arc::new(Height),
                    weights: vec![-w.height],
                });
            }
        }
    }
}
