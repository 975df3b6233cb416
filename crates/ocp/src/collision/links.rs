//! Links of the robot against one another.
//!
//! Links more than two joints apart keep out of one another, shape by shape: what robots are described by overlaps where links are
//! joined, which is no collision. Shapes that overlap in the home posture and with all joints at zero are left alone; those that
//! overlap in the home posture only may do so as deep as there, no deeper. Those that all but touch at rest three joints apart, as in
//! a hip, may overlap by less than shapes stick out of meshes. Of a capsule that is joined its elements are looked at, the
//! cylinder and the balls at its ends, as they are written in URDFs.

use super::cover::{cover, parts};
use super::edges;
use super::pairs::{At, BLUR, NEAR, Place, Says};
use super::self_pair::{SelfPair, from_link};
use super::shared::Shared;
use super::{Ball, CollisionModel, Pair, Part};
use crate::program::{Grid, Program};
use crate::system::System;
use crate::terms::distance::Obstacle;
use multibody::{Kinematics, Model};
use scene::{Scene, Shape};
use spatial::Pose;

/// Joints between a link and the root of its limb from which on it swings about: knees, shins, feet, forearms, hands.
const LIMB: usize = 4;
/// Distance from which on two such links of different limbs get a row [m].
const NEAR_LIMBS: f64 = 0.35;

/// One shape of a link: the balls that cover it and the parts that it is.
#[derive(Debug, Clone, Default)]
pub(super) struct LinkShape {
    pub balls: Vec<Ball>,
    pub parts: Vec<Part>,
    /// A capsule's balls at its ends, and what is between.
    elements: Vec<LinkShape>,
}

impl LinkShape {
    /// A shape that is placed in the frame of its joint.
    pub fn new(joint_from_shape: &Pose, shape: &Shape) -> Self {
        let mut out = Self::whole(joint_from_shape, shape);
        if let Shape::Capsule {
            radius,
            half_length,
        } = *shape
        {
            let at = |z: f64| *joint_from_shape * Pose::from_translation(0.0, 0.0, z);
            let ball = Shape::Sphere { radius };
            let between = Shape::Capsule {
                radius,
                half_length: (half_length - radius).max(0.0),
            };
            let elements = [(-half_length, &ball), (half_length, &ball), (0.0, &between)];
            out.elements = elements.map(|(z, shape)| Self::whole(&at(z), shape)).into();
        }
        out
    }

    /// The same without its elements.
    fn whole(joint_from_shape: &Pose, shape: &Shape) -> Self {
        let mut out = Self::default();
        cover(joint_from_shape, shape, &mut out.balls);
        parts(joint_from_shape, shape, &mut out.parts);
        out
    }

    fn extend(&mut self, other: &Self) {
        self.balls.extend_from_slice(&other.balls);
        self.parts.extend_from_slice(&other.parts);
    }
}

/// Postures that tell which links can come near one another: home, start, all joints at zero.
pub(super) struct Postures(pub [Kinematics; 3]);

impl Postures {
    fn new(scene: &Scene, system: &System) -> Self {
        let model = &system.model;
        let start = system.start(scene);
        let (mut home, mut zero) = (start.clone(), start.clone());
        let first = model.joints[0].kind.nq();
        home[first..first + scene.robot.home.len()].copy_from_slice(&scene.robot.home);
        zero[first..first + scene.robot.home.len()].fill(0.0);
        Self([&home, &start, &zero].map(|q| {
            let mut kinematics = Kinematics::new(model);
            kinematics.update(model, q);
            kinematics
        }))
    }

    /// Do shapes of two links overlap because of how the robot is built.
    fn are_joined(&self, (a, of_a): (usize, &LinkShape), (b, of_b): (usize, &LinkShape)) -> bool {
        let [home, _, zero] = &self.0;
        let in_posture = |k: &Kinematics| {
            let b_from_a = from_link(k, a, b);
            let mut pairs =
                (of_a.parts.iter()).flat_map(|x| of_b.parts.iter().map(move |y| (x, y)));
            pairs.any(|(x, y)| overlap(x, y, &b_from_a))
        };
        in_posture(home) && in_posture(zero)
    }
}

/// Do two parts overlap, as they are.
fn overlap(of_a: &Part, of_b: &Part, b_from_a: &Pose) -> bool {
    match (of_a, of_b) {
        (Part::Ball(centre, radius), Part::Ball(other, other_radius)) => {
            (b_from_a.act(*centre) - other).norm() < radius + other_radius
        }
        (Part::Ball(centre, radius), Part::Box(box_from_b, half)) => {
            let p = box_from_b.act(b_from_a.act(*centre));
            (p.abs() - half).map(|out| out.max(0.0)).norm() < *radius
        }
        (_, Part::Ball(..)) => overlap(of_b, of_a, &b_from_a.inverse()),
        (Part::Box(own_from_a, half), Part::Box(other_from_b, other)) => {
            let there = *other_from_b * *b_from_a * own_from_a.inverse();
            let (own, other) = (Obstacle::Box(*half), Obstacle::Box(*other));
            let inside = |of: &Obstacle, to: &Obstacle, x: &Pose| {
                to.roughly_nearest(&x.origin()) < 0.0 || !edges::nearest(of, to, x, 0.0).is_empty()
            };
            inside(&own, &other, &there) || inside(&other, &own, &there.inverse())
        }
    }
}

/// Shapes of links more than two joints apart, but for those that are joined.
pub(super) fn self_pairs(
    scene: &Scene,
    system: &System,
    shapes: &[Vec<LinkShape>],
) -> Vec<SelfPair> {
    let postures = Postures::new(scene, system);
    let mut out = Vec::new();
    for a in 0..system.n_robot_joints {
        for b in 0..a {
            let Some((up_a, up_b)) = steps_apart(&system.model, a, b) else {
                continue;
            };
            if up_a + up_b <= 2 {
                continue;
            }
            let near = if up_a.min(up_b) >= LIMB {
                NEAR_LIMBS
            } else {
                NEAR
            };
            // The cheaper way round.
            let size = |j: usize, of: &dyn Fn(&LinkShape) -> usize| {
                shapes[j].iter().map(of).sum::<usize>()
            };
            let cost = |a, b| size(a, &|s| s.balls.len()) * size(b, &|s| s.parts.len());
            let (a, b) = if cost(a, b) <= cost(b, a) {
                (a, b)
            } else {
                (b, a)
            };
            for (own, parts) in groups(&postures, (a, &shapes[a]), (b, &shapes[b])) {
                let beside = up_a + up_b == 3;
                out.push(SelfPair::new(
                    &postures,
                    (a, own),
                    (b, parts),
                    (near, beside),
                ));
            }
        }
    }
    out
}

/// Shapes of one link, capsules that are joined with a shape of another one taken apart.
fn taken_apart(
    postures: &Postures,
    (a, of_a): (usize, &[LinkShape]),
    (b, of_b): (usize, &[LinkShape]),
) -> Vec<LinkShape> {
    let mut out = Vec::new();
    for shape in of_a {
        let joined = |other: &LinkShape| postures.are_joined((a, shape), (b, other));
        if !shape.elements.is_empty() && of_b.iter().any(joined) {
            out.extend_from_slice(&shape.elements);
        } else {
            out.push(shape.clone());
        }
    }
    out
}

/// Shapes of one link with the parts of another that they keep out of: one group but where some shapes are joined.
fn groups(
    postures: &Postures,
    (a, of_a): (usize, &[LinkShape]),
    (b, of_b): (usize, &[LinkShape]),
) -> Vec<(LinkShape, Vec<Part>)> {
    let own = taken_apart(postures, (a, of_a), (b, of_b));
    let of_b = &taken_apart(postures, (b, of_b), (a, of_a));
    let mut out: Vec<(Vec<bool>, LinkShape)> = Vec::new();
    for shape in &own {
        let apart: Vec<bool> = (of_b.iter())
            .map(|other| !postures.are_joined((a, shape), (b, other)))
            .collect();
        match out.iter_mut().find(|(same, _)| *same == apart) {
            Some((_, group)) => group.extend(shape),
            None => out.push((apart, shape.clone())),
        }
    }
    let parts_of = |apart: &[bool]| {
        let kept = of_b.iter().zip(apart).filter(|(_, apart)| **apart);
        kept.flat_map(|(shape, _)| shape.parts.clone()).collect()
    };
    let groups = out.into_iter().map(|(apart, own)| (own, parts_of(&apart)));
    let is_empty = |(own, parts): &(LinkShape, Vec<Part>)| own.balls.is_empty() || parts.is_empty();
    groups.filter(|group| !is_empty(group)).collect()
}

/// Joints from each of two links up to what carries both.
fn steps_apart(model: &Model, a: usize, b: usize) -> Option<(usize, usize)> {
    let path = |j: usize| std::iter::successors(Some(j), |&j| model.joints[j].parent);
    path(a)
        .enumerate()
        .find_map(|(up_a, common)| Some((up_a, path(b).position(|j| j == common)?)))
}

impl CollisionModel {
    /// Links of the robot against one another.
    pub(super) fn link_pairs(
        &self,
        program: &Program,
        at: &At<'_>,
        shared: &mut Shared,
        out: &mut Vec<Pair>,
    ) {
        for (index, pair) in self.self_pairs.iter().enumerate() {
            let demanded = |_: Says<'_>| match program.grid {
                Grid::Keyframes | Grid::OpenKeyframes | Grid::State => pair.clearance(-BLUR),
                _ => pair.clearance_near(
                    program.settings.margins.self_clearance,
                    &at.kinematics[at.node],
                ),
            };
            let row = pair.row(index, at.window, &demanded, shared);
            out.extend(row.map(|term| Pair {
                place: Place::Node(at.node),
                a: pair.a,
                b: Some(pair.b),
                term,
            }));
        }
    }
}

#[cfg(test)]
mod tests;
