//! The robot as a tree of bodies: links joined by fixed joints are one, and it has the index of the joint that moves it.
//!
//! Frames: `joint`, that of a body; `base`, that of the root link, which stands upright in the origin here.

use multibody::{Kinematics, Model};
use nalgebra::Vector3;
use scene::BareRobot;

/// A point of a body, with the radius of what is round about it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tip {
    /// The link that it belongs to.
    pub frame: usize,
    /// [m]
    pub in_joint: Vector3<f64>,
    /// [m]
    pub radius: f64,
}

/// The bodies of a robot at rest: with the home of its description, the base upright in the origin.
pub(crate) struct Bodies<'a> {
    pub bare: &'a BareRobot,
    /// Positions of base and joints at rest.
    pub q: Vec<f64>,
    pub kinematics: Kinematics,
    pub children: Vec<Vec<usize>>,
    /// Points of every body.
    pub tips: Vec<Vec<Tip>>,
}

impl<'a> Bodies<'a> {
    pub fn new(bare: &'a BareRobot) -> Self {
        let model = &bare.robot.model;
        let mut q = model.neutral();
        let first = model.joints[0].kind.nq();
        q[first..].copy_from_slice(&bare.robot.home);
        let mut kinematics = Kinematics::new(model);
        kinematics.update(model, &q);
        let mut children = vec![vec![]; model.joints.len()];
        for (j, joint) in model.joints.iter().enumerate() {
            if let Some(parent) = joint.parent {
                children[parent].push(j);
            }
        }
        let mut tips = vec![vec![]; model.joints.len()];
        for (index, frame) in model.frames.iter().enumerate() {
            if let Some(joint) = frame.joint {
                let points = bare.points(index).into_iter();
                tips[joint].extend(points.map(|(p, radius)| Tip {
                    frame: index,
                    in_joint: frame.joint_from_frame.act(p),
                    radius,
                }));
            }
        }
        Self {
            bare,
            q,
            kinematics,
            children,
            tips,
        }
    }

    pub fn model(&self) -> &'a Model {
        &self.bare.robot.model
    }

    /// Origin of a body's joint at rest, in the base [m].
    pub fn origin(&self, joint: usize) -> Vector3<f64> {
        self.kinematics.world_from_joint[joint].origin()
    }

    /// Height of the lowest point of a body at rest, of its joint if it has no shape, in the base [m].
    pub fn lowest(&self, joint: usize) -> f64 {
        let base_from_joint = &self.kinematics.world_from_joint[joint];
        let tips = self.tips[joint].iter();
        let heights = tips.map(|tip| base_from_joint.act(tip.in_joint).z - tip.radius);
        let least = heights.fold(f64::INFINITY, f64::min);
        if least.is_finite() {
            least
        } else {
            self.origin(joint).z
        }
    }

    /// A body and those that carry it, up to the base, which is left out.
    pub fn up(&self, joint: usize) -> impl Iterator<Item = usize> + use<'a> {
        let joints = &self.model().joints;
        let up = std::iter::successors(Some(joint), |&j| joints[j].parent);
        up.take_while(|&j| j != 0)
    }

    /// Is a body the other one or carried by it.
    pub fn is_behind(&self, joint: usize, other: usize) -> bool {
        self.up(joint).any(|j| j == other)
    }

    /// The two chains of bodies from what carries both to each of two, outwards; `None` if one carries the other.
    pub fn chains(&self, a: usize, b: usize) -> Option<[Vec<usize>; 2]> {
        let below = |of: usize, other: usize| {
            let own = self.up(of).take_while(|&j| !self.is_behind(other, j));
            let mut chain: Vec<usize> = own.collect();
            chain.reverse();
            chain
        };
        let chains = [below(a, b), below(b, a)];
        (!chains.iter().any(Vec::is_empty)).then_some(chains)
    }

    /// Joints between two bodies.
    pub fn joints_between(&self, a: usize, b: usize) -> usize {
        let own =
            |of: usize, other: usize| self.up(of).filter(|&j| !self.is_behind(other, j)).count();
        own(a, b) + own(b, a)
    }

    /// Mass of a body and all that it carries [kg].
    pub fn mass_behind(&self, joint: usize) -> f64 {
        let joints = self.model().joints.iter().enumerate();
        let behind = joints.filter(|(j, _)| self.is_behind(*j, joint));
        behind.map(|(_, of)| of.inertia.mass).sum()
    }

    /// Most joints from a body outwards, itself included.
    pub fn depth_behind(&self, joint: usize) -> usize {
        let children = self.children[joint].iter();
        1 + children.map(|&j| self.depth_behind(j)).max().unwrap_or(0)
    }

    /// Name of the link of a body that carries its joint.
    pub fn name(&self, joint: usize) -> &'a str {
        let frames = &self.model().frames;
        let of_body = frames.iter().find(|frame| frame.joint == Some(joint));
        of_body.map_or("?", |frame| frame.name.as_str())
    }
}
