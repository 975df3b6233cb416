//! Which pairs of bodies get rows (or a penalty) at which node, and with which balls.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::cover::{box_corners, sticks_out};
use super::edges::edge_row;
use super::shared::Shared;
use super::touches::{Since, Touches};
use super::{Ball, Clearances, CollisionModel, Crossings, Other, Primitive, Touch};
use crate::program::{Grid, Phase, Program, landing};
use crate::settings::Preset;
use crate::terms::PoseTerm;
use crate::terms::distance::{Distance, EVENNESS, MOST_CLEARANCE, Obstacle, Part};
use crate::terms::sigmoid::Sigmoid;
use multibody::Kinematics;
use scene::Scene;
use solver::threads;
use spatial::Pose;

/// A pair of bodies nearer than this in the guide configurations gets a row [m].
pub(super) const NEAR: f64 = 0.15;
/// Sixteenths of a phase before and after a node of a motion whose guide configurations count for it: phases shift while
/// they are optimised.
const WINDOW: f64 = 2.0;
/// Configurations looked at on either side.
const WINDOW_SAMPLES: usize = 2;
/// What the smooth least distance may fall short of the true one where a keyframe must not be rejected [m].
pub(super) const BLUR: f64 = 1.4 * EVENNESS;
/// Clearance demanded at a contact of the same bodies, beside what its row says there, and its growth per sixteenth of a
/// phase away from it [m].
const RAMP: (f64, f64) = (-0.002, 0.008);
/// How deep what touches by a point alone may be in what it touches, beyond what its point is inside its own link [m].
const POINT_PLAY: f64 = 0.003;
/// The most that is demanded at a contact [m].
const MOST_AT_CONTACT: f64 = -0.008;
/// The least and the most that is demanded there of the neighbours in the limb of what touches [m]: no overlap, of which a smooth
/// distance falls short by some millimetres.
const BESIDE_CONTACT: (f64, f64) = (-0.005, -0.003);
/// The same beside a foot where boxes have corners near what it touches, less what these stick out of their balls: a flat face takes all of
/// them alike.
const BESIDE_FOOT: (f64, f64) = (-0.007, -0.004);
/// What is near there [m].
const NEAR_FOOT: f64 = 0.01;
/// Share of the clearance that is demanded of a hand and its wrist from what the object that it grasps or places stands on.
pub(super) const THROUGH: f64 = 0.25;
/// Sixteenths of a phase after a body has left where it stands at the start in which what is near there may still be so.
const FROM_START: f64 = 6.0;
/// Slope of the sigmoid penalties of the paper preset [1/m] (the yardstick's).
const SIGMOID_SLOPE: f64 = 40.0;

/// What a row says in a configuration, and by how much that is less than the distance [m].
#[derive(Debug, Clone, Copy)]
pub(super) struct Said {
    pub row: f64,
    pub less: f64,
}

impl Said {
    /// By a row where a is at `b_from_a`.
    pub fn by(row: &Distance, b_from_a: &Pose) -> Self {
        Self {
            row: value(row, b_from_a),
            less: row.falls_short(b_from_a),
        }
    }
}

/// What a row says in a configuration.
pub(super) type Says<'a> = &'a dyn Fn(&Kinematics) -> Said;

/// Where a pair gets rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// At a node.
    Node(usize),
    /// On the way from a node to the next one.
    Way {
        /// The first node.
        interval: usize,
        /// Share of the way.
        share: f64,
    },
}

/// One pair that gets rows (or a penalty).
#[derive(Debug, Clone)]
pub struct Pair {
    /// Where.
    pub place: Place,
    /// Joint that carries the balls.
    pub a: usize,
    /// Joint that carries the obstacle; `None` for the world.
    pub b: Option<usize>,
    /// Rows.
    pub term: Arc<dyn PoseTerm>,
}

/// Guide configurations that count for a node, and how long ago pairs touched.
pub(super) struct At<'a> {
    pub(super) node: usize,
    pub(super) kinematics: &'a [Kinematics],
    pub(super) window: &'a [&'a Kinematics],
    /// These and those of earlier rounds.
    window_of_edges: &'a [&'a Kinematics],
    touches: &'a Touches,
    /// Sixteenths of a phase since each body, and its neighbours, stopped standing where they stand at the start.
    from_start: &'a [f64],
    /// Bodies that touch by points alone, and how far these are inside the first one [m].
    points: &'a BTreeMap<Touch, f64>,
}

impl At<'_> {
    /// True if the pair touches at the node.
    fn touches(&self, a: usize, other: Other) -> bool {
        (self.since(a, other)).is_some_and(|since| since.node == self.node)
    }

    /// The nearest contact of the pair in time.
    fn since(&self, a: usize, other: Other) -> Option<Since> {
        self.touches.since((a, other), self.node)
    }

    /// The same where the first one touches an object that touches the other.
    fn since_through(&self, a: usize, other: Other) -> Option<Since> {
        self.touches.since_through((a, other), self.node)
    }
}

impl CollisionModel {
    /// All pairs that get rows.
    pub fn pairs(
        &self,
        program: &Program,
        scene: &Scene,
        phases: &[Phase],
        clearances: Clearances<'_>,
    ) -> Vec<Pair> {
        match clearances {
            Clearances::Near { nodes, crossings } => {
                self.near_pairs(program, scene, phases, nodes, crossings)
            }
            Clearances::Watched(watched) => self.watched_pairs(program, scene, phases, watched),
        }
    }

    /// Pairs that come near in one guide configuration per node.
    fn near_pairs(
        &self,
        program: &Program,
        scene: &Scene,
        phases: &[Phase],
        near: &[Vec<f64>],
        crossings: &Crossings,
    ) -> Vec<Pair> {
        let model = &program.system.model;
        let at_nodes = |nodes: &[Vec<f64>]| -> Vec<Kinematics> {
            let at = |q: &Vec<f64>| {
                let mut kinematics = Kinematics::new(model);
                kinematics.update(model, q);
                kinematics
            };
            nodes.iter().map(at).collect()
        };
        let kinematics = at_nodes(near);
        let earlier: Vec<_> = crossings.earlier.iter().map(|q| at_nodes(q)).collect();
        let n = program.n_intervals();
        let touching: Vec<_> = (0..=n)
            .map(|t| Self::touching(scene, program, phases, t))
            .collect();
        let along = program.along();
        let window = |t: usize| -> Vec<usize> {
            let width = match program.grid {
                Grid::Motion => {
                    let here = along[t.min(n - 1) + 1] - along[t.min(n - 1)];
                    (WINDOW / here).round().max(1.0) as usize
                }
                Grid::Path => 1,
                Grid::Keyframes | Grid::OpenKeyframes | Grid::State => 0,
            };
            let samples = WINDOW_SAMPLES.min(width);
            let mut nodes: Vec<usize> = (1..=samples)
                .map(|i| i * width / samples)
                .flat_map(|d| [t.saturating_sub(d), (t + d).min(n)])
                .chain([t])
                .collect();
            nodes.sort_unstable();
            nodes.dedup();
            nodes
        };
        let leaves = self.leaves(&touching, &along);
        let objects = program.system.n_robot_joints..model.joints.len();
        let touches = Touches::new(&touching, along.clone(), &objects);
        let at_node = |t: usize, shared: &mut Shared, out: &mut Vec<Pair>| {
            let nodes = window(t);
            let window: Vec<_> = nodes.iter().map(|&i| &kinematics[i]).collect();
            let before = earlier.iter().flat_map(|k| nodes.iter().map(|&i| &k[i]));
            let window_of_edges: Vec<_> = window.iter().copied().chain(before).collect();
            let points = Self::touching_by_points(scene, program, phases, t);
            let at = At {
                node: t,
                kinematics: &kinematics,
                window: &window,
                window_of_edges: &window_of_edges,
                touches: &touches,
                from_start: &leaves
                    .iter()
                    .map(|left| along[t] - left)
                    .collect::<Vec<_>>(),
                points: &points,
            };
            self.obstacle_pairs(program, &at, shared, out);
            if program.settings.preset == Preset::Default {
                self.link_pairs(program, &at, shared, out);
            } else {
                self.link_penalties(&at, out);
            }
        };
        let is_own = |&t: &usize| program.nodes[t].var.is_some() && program.master_node(t) == t;
        let nodes: Vec<usize> = (0..=n).filter(is_own).collect();
        let size = nodes.len().div_ceil(program.settings.threads.max(1));
        let part = |nodes| (nodes, Shared::default(), Vec::new());
        let mut parts: Vec<_> = nodes.chunks(size.max(1)).map(part).collect();
        threads::each(parts.iter_mut(), |(nodes, shared, out)| {
            for &t in *nodes {
                at_node(t, shared, out);
            }
        });
        let mut out: Vec<Pair> = parts.into_iter().flat_map(|part| part.2).collect();
        let of_nodes = (near, &kinematics[..]);
        self.crossing_pairs(
            program,
            of_nodes,
            crossings,
            &mut Shared::default(),
            &mut out,
        );
        out
    }

    /// Sixteenths of a phase at which each body, and its neighbours, no longer touch a static body that they touch from the start
    /// on: a foot that stands cannot get farther from what it stands beside.
    fn leaves(&self, touching: &[BTreeSet<Touch>], along: &[f64]) -> Vec<f64> {
        let mut stands: Vec<&Touch> = touching[0].iter().filter(|t| t.1.is_err()).collect();
        let mut own = vec![along[0]; self.balls.len()];
        for (there, &now) in touching.iter().zip(along) {
            stands.retain(|&touch| there.contains(touch));
            for &&(a, _) in &stands {
                own[a] = now;
            }
        }
        let latest = |a: usize| {
            let beside = self.neighbours[a].iter().map(|&j| own[j]);
            beside.fold(own[a], f64::max)
        };
        (0..own.len()).map(latest).collect()
    }

    /// Links and objects against objects and the environment.
    fn obstacle_pairs(
        &self,
        program: &Program,
        at: &At<'_>,
        shared: &mut Shared,
        out: &mut Vec<Pair>,
    ) {
        let paper = program.settings.preset == Preset::Paper;
        for a in 0..self.balls.len() {
            for (index, primitive) in self.primitives.iter().enumerate() {
                if primitive.joint == Some(a) || self.balls[a].is_empty() {
                    continue;
                }
                let Some(other) = primitive.joint.map(Ok).or(primitive.body.map(Err)) else {
                    continue;
                };
                let touching = at.touches(a, other);
                let by_point = at.points.get(&(a, other)).filter(|_| touching && !paper);
                if touching && by_point.is_none() {
                    continue;
                }
                let place = Place::Node(at.node);
                let mut push = |b: Option<usize>, term: Arc<dyn PoseTerm>| {
                    out.push(Pair { place, a, b, term });
                };
                if paper {
                    // The paper penalises end-effectors, objects and large boxes, not every link.
                    let points = [&self.points[a][..], &self.link_points[a]].concat();
                    if !points.is_empty() {
                        let penalty = Sigmoid {
                            points,
                            obstacle: primitive.obstacle.clone(),
                            obstacle_from_b: primitive.from_body,
                            slope: SIGMOID_SLOPE,
                        };
                        push(primitive.joint, Arc::new(penalty));
                    }
                    continue;
                }
                let demanded = |says: Says<'_>| match by_point {
                    Some(inside) => -inside - POINT_PLAY,
                    None => (self.clearance(program, (a, says), primitive, other, at))
                        .min(MOST_CLEARANCE),
                };
                let near = (a, index, at.window, at.window_of_edges);
                self.obstacle_rows(near, self.own(a), &demanded, shared, &mut push);
            }
        }
    }

    /// Rows of a body and what comes near it of a primitive in any of the configurations: corners and balls, and edges that are
    /// inside in any of the second ones; `push` takes the joint that carries the obstacle, and the row.
    pub(super) fn obstacle_rows<'a>(
        &self,
        (a, index, window, of_edges): (usize, usize, &[&Kinematics], &[&Kinematics]),
        boxes: impl Iterator<Item = &'a Primitive>,
        demanded: &dyn Fn(Says<'_>) -> f64,
        shared: &mut Shared,
        push: &mut dyn FnMut(Option<usize>, Arc<dyn PoseTerm>),
    ) {
        let primitive = &self.primitives[index];
        let mut balls = self.balls_near(a, primitive, window);
        for own in boxes {
            let (of_own, of_other) = self.edges_inside((a, own), primitive, of_edges);
            balls.extend(of_own);
            if !of_other.is_empty() {
                let row = edge_row((a, own), primitive, &of_other, demanded);
                push(primitive.joint, Arc::new(row));
            }
        }
        if !balls.is_empty() {
            let clearance = demanded(&|k| distance_at((a, &balls), primitive, k));
            let shapes = (balls, primitive.obstacle.clone());
            let row = shared.row((a, Some(index)), shapes, primitive.from_body, clearance);
            push(primitive.joint, Arc::new(row));
        }
    }

    /// Clearance demanded of a body and a primitive, whose row says `says`: growing with the distance in time from where they touch, or where the
    /// body's neighbours in the limb do: a wrist is as near to a box as the hand that holds it makes it. The same from where a
    /// body has stood since the start, which may be nearer to something than a motion may come.
    fn clearance(
        &self,
        program: &Program,
        (a, says): (usize, Says<'_>),
        primitive: &Primitive,
        other: Other,
        at: &At<'_>,
    ) -> f64 {
        if matches!(
            program.grid,
            Grid::Keyframes | Grid::OpenKeyframes | Grid::State
        ) {
            return -BLUR;
        }
        let margins = &program.settings.margins;
        let full = if self.feet[a] && primitive.joint.is_none() {
            margins.swing
        } else {
            margins.clearance
        };
        let own = at.since(a, other);
        let neighbours = self.neighbours[a].iter();
        let beside = neighbours.filter_map(|&j| at.since(j, other));
        let sooner = |x: &Since, y: &Since| x.parts.total_cmp(&y.parts);
        let beside = beside.min_by(sooner);
        let rise = |parts: f64| landing::rise(program, at.node, parts).unwrap_or(RAMP.1 * parts);
        let there = |node: usize| says(&at.kinematics[node]).row + RAMP.0;
        let mut demanded = match (own, beside) {
            (Some(own), beside) if beside.is_none_or(|b| own.parts <= b.parts) => {
                there(own.node).min(MOST_AT_CONTACT) + rise(own.parts)
            }
            (_, Some(beside)) => {
                let overlap = self.depth(a, primitive, &at.kinematics[beside.node]);
                let without = there(beside.node) + overlap;
                let (mut least, mut most) = BESIDE_CONTACT;
                if self.neighbours[a].iter().any(|&j| self.feet[j]) {
                    let out = self.corners_out(a, primitive, &at.kinematics[beside.node]);
                    least = least.max(BESIDE_FOOT.0 + out);
                    most = most.max(BESIDE_FOOT.1 + out);
                }
                without.clamp(least, most) + rise(beside.parts)
            }
            _ => full,
        };
        demanded = demanded.min(full);
        // Where an object that is held stands, the hand that holds it, and its wrist, is as near as the grasp makes it.
        let limb = self.neighbours[a].iter().copied().chain([a]);
        let through = limb.filter_map(|j| at.since_through(j, other));
        if let Some(since) = through.min_by(sooner) {
            demanded = demanded.min(THROUGH * full + rise(since.parts));
        }
        if at.from_start[a] < FROM_START {
            demanded = demanded.min(there(0) + rise(at.from_start[a].max(0.0)));
        }
        demanded
    }

    /// How deep the balls of a body are in a primitive [m]; zero if they are outside.
    fn depth(&self, a: usize, primitive: &Primitive, at: &Kinematics) -> f64 {
        let x = primitive.pose_of_joint(at, a);
        let inside = |(c, r): &Ball| r - primitive.obstacle.roughly_nearest(&x.act(*c));
        self.balls[a].iter().map(inside).fold(0.0, f64::max)
    }

    /// By how much those boxes of a body stick out of its balls that have a corner near a primitive [m].
    fn corners_out(&self, a: usize, primitive: &Primitive, at: &Kinematics) -> f64 {
        let x = primitive.pose_of_joint(at, a);
        let is_near = |part: &&Part| {
            let mut corners = box_corners(part).into_iter();
            corners.any(|c| primitive.obstacle.roughly_nearest(&x.act(c)) < NEAR_FOOT)
        };
        let near = self.parts[a].iter().filter(is_near);
        near.map(sticks_out).fold(0.0, f64::max)
    }

    /// Balls of a body that come near a primitive in any of the configurations.
    fn balls_near(&self, a: usize, primitive: &Primitive, window: &[&Kinematics]) -> Vec<Ball> {
        let (centre, radius) = self.bounds[a];
        let poses: Vec<Pose> = window
            .iter()
            .map(|kinematics| primitive.pose_of_joint(kinematics, a))
            .filter(|x| primitive.obstacle.roughly_nearest(&x.act(centre)) - radius < NEAR)
            .collect();
        let near = |(c, r): &&Ball| {
            poses
                .iter()
                .any(|x| primitive.obstacle.roughly_nearest(&x.act(*c)) - r < NEAR)
        };
        self.balls[a].iter().filter(near).copied().collect()
    }

    /// The paper's penalties of end-effectors and objects against the boxes of torso, shins and forearms.
    fn link_penalties(&self, at: &At<'_>, out: &mut Vec<Pair>) {
        for a in 0..self.points.len() {
            if self.points[a].is_empty() {
                continue;
            }
            for b in 0..self.parts.len() {
                let near = a == b || self.neighbours[a].contains(&b) || at.touches(a, Ok(b));
                if near {
                    continue;
                }
                for part in &self.parts[b] {
                    let Part::Box(obstacle_from_b, half) = part else {
                        continue;
                    };
                    if half.max() < super::LARGE_BOX {
                        continue;
                    }
                    out.push(Pair {
                        place: Place::Node(at.node),
                        a,
                        b: Some(b),
                        term: Arc::new(Sigmoid {
                            points: self.points[a].clone(),
                            obstacle: Obstacle::Box(*half),
                            obstacle_from_b: *obstacle_from_b,
                            slope: SIGMOID_SLOPE,
                        }),
                    });
                }
            }
        }
    }
}

/// What the row of a body, covered by `balls`, and a primitive says in a configuration.
fn distance_at((a, balls): (usize, &[Ball]), primitive: &Primitive, at: &Kinematics) -> Said {
    let obstacle = primitive.obstacle.clone();
    let row = Distance::new(balls.to_vec(), obstacle, Pose::identity(), 0.0);
    Said::by(&row, &primitive.pose_of_joint(at, a))
}

/// What a row says [m].
pub(super) fn value(row: &dyn PoseTerm, b_from_a: &Pose) -> f64 {
    let mut value = [f64::NAN];
    row.values(b_from_a, &mut value);
    value[0]
}

#[cfg(test)]
mod tests;
