//! Goal regions at the last node, with the orientation that they ask for.

use std::sync::Arc;

use super::label::label;
use super::{Builder, Grid, Subject};
use crate::relative::{Body, Carrier, RelativeFrame};
use crate::system::System;
use crate::terms::{heading::Heading, region::Region, tilt_limit::TiltLimit};
use nalgebra::Vector6;
use scene::{Owner, Scene};
use spatial::Pose;

/// Name of the robot's floating base.
pub(super) const BASE: &str = "base";

impl Builder<'_> {
    /// The terms of every goal region whose body exists: place, heading, tilt.
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
            let subject = Subject::Goal(r);
            let frame = self.frame_in(body, Pose::identity());
            let term = Arc::new(Region {
                lower: region.lower,
                upper: region.upper,
            });
            if region
                .lower
                .iter()
                .chain(&region.upper)
                .any(|x| x.is_finite())
            {
                let label = label("goal region", subject, 1.0, "m");
                self.node_term(element, node, frame, term, label);
            }
            if let Some(max) = region.tilt {
                let label = label("goal orientation", subject, 1.0, "rad");
                self.node_term(element, node, frame, Arc::new(TiltLimit { max }), label);
            }
            if let Some([least, greatest]) = region.yaw {
                let middle = Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, f64::midpoint(least, greatest));
                let frame = self.frame_in(body, Pose::exp(&middle));
                let term = Arc::new(Heading {
                    half_width: (greatest - least) / 2.0,
                });
                let label = label("goal orientation", subject, 1.0, "rad");
                self.node_term(element, node, frame, term, label);
            }
        }
    }

    /// A new relative frame: the body in a frame that is fixed in the world.
    pub(super) fn frame_in(&mut self, body: Carrier, world_from_frame: Pose) -> usize {
        let world = Carrier {
            body: Body::World,
            body_from_frame: world_from_frame,
        };
        let frame = self.program.frames.len();
        let model = &self.program.system.model;
        self.program
            .frames
            .push(RelativeFrame::new(model, body, world));
        self.keys.push((usize::MAX, frame));
        frame
    }
}

/// The frame of a body that a goal names: "base", an object, a robot link or an interface.
pub fn goal_body(scene: &Scene, system: &System, name: &str) -> Option<Carrier> {
    if name == BASE {
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
