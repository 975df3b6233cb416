//! Goal regions at the last node.

use std::sync::Arc;

use super::label::label;
use super::{Builder, Grid, Subject};
use crate::relative::{Body, Carrier, RelativeFrame};
use crate::system::System;
use crate::terms::region::Region;
use scene::{Owner, Scene};
use spatial::Pose;

impl Builder<'_> {
    /// One term per goal region whose body exists.
    pub(super) fn goal(&mut self) {
        let n = self.program.n_intervals();
        let node = self.program.master_node(n);
        let element = node.min(n - 1);
        if matches!(self.program.grid, Grid::OpenKeyframes | Grid::State) {
            return;
        }
        for (r, region) in self.scene.goal_regions.iter().enumerate() {
            let Some(body) = goal_body(self.scene, &self.program.system, &region.body) else {
                continue;
            };
            let world = Carrier {
                body: Body::World,
                body_from_frame: Pose::identity(),
            };
            let frame = self.program.frames.len();
            self.program
                .frames
                .push(RelativeFrame::new(&self.program.system.model, body, world));
            self.keys.push((usize::MAX, frame));
            let term = Arc::new(Region {
                lower: region.lower,
                upper: region.upper,
            });
            self.node_term(
                element,
                node,
                frame,
                term,
                label("goal region", Subject::Goal(r), 1.0, "m"),
            );
        }
    }
}

/// The frame of a body that a goal names: "base", an object, a robot link or an interface.
pub fn goal_body(scene: &Scene, system: &System, name: &str) -> Option<Carrier> {
    if name == "base" {
        return Some(Carrier {
            body: Body::Joint(0),
            body_from_frame: Pose::identity(),
        });
    }
    if let Some(o) = scene.objects.iter().position(|o| o.name == name) {
        return Some(system.carrier(Owner::Object(o), &Pose::identity()));
    }
    if let Some(i) = scene.interfaces.iter().find(|i| i.name == name) {
        return Some(system.carrier(i.owner, &i.body_from_interface));
    }
    let frame = scene.robot.model.frame_id(name)?;
    Some(system.carrier(Owner::Robot { frame }, &Pose::identity()))
}
