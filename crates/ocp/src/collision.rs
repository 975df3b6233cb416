//! The collision model: balls that cover links and objects, obstacles that they avoid, and which pairs get rows.
//!
//! Rows are made only for balls that come near an obstacle in given node configurations (the initial guess or the last
//! solution); whoever solves checks the result and asks again with the pairs that were missed.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::program::{Grid, Phase, Program};
use crate::relative::{Body, Carrier, RelativeFrame};
use crate::settings::Preset;
use crate::system::System;
use crate::terms::PoseTerm;
use crate::terms::distance::{Distance, Obstacle, box_distance};
use crate::terms::sigmoid::Sigmoid;
use multibody::Kinematics;
use nalgebra::Vector3;
use scene::{Owner, PlacedShape, Role, Scene, Shape};
use spatial::Pose;

/// A ball nearer than this to an obstacle in the guide configurations gets a row [m].
const NEAR: f64 = 0.07;
/// The same between two links of the robot [m].
const NEAR_SELF: f64 = 0.04;
/// Largest ball that stands for a box [m]; corners of a box stick out of its balls by at most 0.73 of the radius.
const BOX_BALL: f64 = 0.035;
/// Radius of the balls at the edges and corners of a box [m], and their distance from its faces in radii: they bulge
/// by a quarter of the radius and leave a quarter of it uncovered at the corners.
const EDGE_BALL: f64 = 0.01;
const EDGE_INSET: f64 = 0.75;
/// Half length from which on an edge gets a ball in its middle [m].
const LONG_EDGE: f64 = 0.03;
/// Clearance demanded one node away from a contact of the same bodies [m], and its growth per node.
const RAMP: (f64, f64) = (-0.008, 0.008);
/// Slope of the sigmoid penalties of the paper preset [1/m] (the yardstick's).
const SIGMOID_SLOPE: f64 = 40.0;

type Ball = (Vector3<f64>, f64);

/// The body that a ball avoids: a joint, or a static body.
pub type Other = Result<usize, usize>;

/// More clearance for a pair at a node [m], where the way between two nodes would collide.
pub type ExtraClearance = BTreeMap<(usize, usize, Other), f64>;

/// A primitive that balls avoid.
#[derive(Debug, Clone)]
struct Primitive {
    /// Joint that carries it; `None` for the world.
    joint: Option<usize>,
    /// Static body, if it is one.
    body: Option<usize>,
    /// Pose of the body in the primitive's frame.
    from_body: Pose,
    obstacle: Obstacle,
}

/// Two bodies in contact: joint, and joint or static body.
type Touch = (usize, Other);

/// Balls and obstacles of a scene.
#[derive(Debug, Clone)]
pub struct CollisionModel {
    balls: Vec<Vec<Ball>>,
    primitives: Vec<Primitive>,
    self_pairs: Vec<(usize, usize)>,
    feet: Vec<bool>,
    hands: Vec<bool>,
}

/// One pair that gets rows (or a penalty) at a node.
#[derive(Debug, Clone)]
pub struct Pair {
    /// Node.
    pub node: usize,
    /// Joint that carries the balls.
    pub a: usize,
    /// Joint that carries the obstacle; `None` for the world.
    pub b: Option<usize>,
    /// Rows.
    pub term: Arc<dyn PoseTerm>,
}

impl CollisionModel {
    /// Covers all links and objects.
    pub fn new(scene: &Scene, system: &System) -> Self {
        let n = system.model.joints.len();
        let mut balls: Vec<Vec<Ball>> = vec![vec![]; n];
        for (frame, shapes) in system.model.frames.iter().zip(&scene.robot.shapes) {
            if let Some(joint) = frame.joint {
                for shape in shapes {
                    cover(
                        &(frame.joint_from_frame * shape.body_from_shape),
                        &shape.shape,
                        &mut balls[joint],
                    );
                }
            }
        }
        let mut primitives = Vec::new();
        for (o, object) in scene.objects.iter().enumerate() {
            let joint = system.object_joint(o);
            for placed in &object.shapes {
                corners(placed, &mut balls[joint]);
                primitives.push(primitive(Some(joint), None, placed));
            }
        }
        for (s, body) in scene.statics.iter().enumerate() {
            primitives.extend(
                body.shapes
                    .iter()
                    .map(|placed| primitive(None, Some(s), placed)),
            );
        }
        let carries = |role: Role| {
            let mut out = vec![false; n];
            for i in scene.interfaces.iter().filter(|i| i.role == role) {
                if let Body::Joint(j) = system.carrier(i.owner, &i.body_from_interface).body {
                    out[j] = true;
                }
            }
            out
        };
        let mut model = Self {
            balls,
            primitives,
            self_pairs: vec![],
            feet: carries(Role::Foot),
            hands: carries(Role::Hand),
        };
        model.self_pairs = model.find_self_pairs(scene, system);
        model
    }

    /// Pairs of links more than two joints apart that are clear of one another in the home posture.
    fn find_self_pairs(&self, scene: &Scene, system: &System) -> Vec<(usize, usize)> {
        let model = &system.model;
        let mut home = system.start(scene);
        let first = model.joints[0].kind.nq();
        home[first..first + scene.robot.home.len()].copy_from_slice(&scene.robot.home);
        let mut kinematics = Kinematics::new(model);
        kinematics.update(model, &home);
        let path = |j: usize| {
            let mut out = vec![j];
            while let Some(parent) = model.joints[out[out.len() - 1]].parent {
                out.push(parent);
            }
            out
        };
        let mut pairs = Vec::new();
        for a in 0..system.n_robot_joints {
            for b in 0..a {
                if self.balls[a].is_empty() || self.balls[b].is_empty() {
                    continue;
                }
                let (pa, pb) = (path(a), path(b));
                let Some(common) = pa.iter().find(|j| pb.contains(j)) else {
                    continue;
                };
                let steps = |p: &[usize]| p.iter().position(|j| j == common).unwrap_or(0);
                if steps(&pa) + steps(&pb) > 2 && self.link_distance(&kinematics, a, b) > 0.0 {
                    pairs.push((a, b));
                }
            }
        }
        pairs
    }

    fn link_distance(&self, kinematics: &Kinematics, a: usize, b: usize) -> f64 {
        let b_from_a = kinematics.world_from_joint[b].inverse() * kinematics.world_from_joint[a];
        let mut least = f64::INFINITY;
        for (ca, ra) in &self.balls[a] {
            let p = b_from_a.act(*ca);
            for (cb, rb) in &self.balls[b] {
                least = least.min((p - cb).norm() - ra - rb);
            }
        }
        least
    }

    /// The relative frame of two bodies.
    pub fn frame(&self, system: &System, a: usize, b: Option<usize>) -> RelativeFrame {
        let carrier = |body| Carrier {
            body,
            body_from_frame: Pose::identity(),
        };
        RelativeFrame::new(
            &system.model,
            carrier(Body::Joint(a)),
            carrier(b.map_or(Body::World, Body::Joint)),
        )
    }

    /// Bodies that touch at a node: contacts that bind one of its two intervals.
    fn touching(scene: &Scene, program: &Program, phases: &[Phase], t: usize) -> BTreeSet<Touch> {
        let mut out = BTreeSet::new();
        let n = program.n_intervals();
        let reach = if program.grid == Grid::Motion { 2 } else { 1 };
        for i in t.saturating_sub(reach)..=t.min(n - 1) {
            for contact in &phases[program.phase_of(i)].state.contacts {
                let (a, b) = (
                    &scene.interfaces[contact.a.0],
                    &scene.interfaces[contact.b.0],
                );
                let Body::Joint(joint) =
                    program.system.carrier(a.owner, &a.body_from_interface).body
                else {
                    continue;
                };
                let other = match (
                    b.owner,
                    program.system.carrier(b.owner, &b.body_from_interface).body,
                ) {
                    (Owner::Static(s), _) => Err(s),
                    (_, Body::Joint(j)) => Ok(j),
                    (_, Body::World) => continue,
                };
                out.insert((joint, other));
                if let Ok(j) = other {
                    out.insert((j, Ok(joint)));
                }
            }
        }
        out
    }

    /// Clearance demanded of a pair that touches `d` nodes away (`None`: never).
    fn ramp(full: f64, d: Option<usize>) -> f64 {
        d.map_or(full, |d| full.min(RAMP.0 + RAMP.1 * d as f64))
    }

    /// All pairs that get rows, given one guide configuration per node.
    pub fn pairs(
        &self,
        program: &Program,
        scene: &Scene,
        phases: &[Phase],
        near: &[Vec<f64>],
        extra: &ExtraClearance,
    ) -> Vec<Pair> {
        let mut kinematics = Kinematics::new(&program.system.model);
        let mut out = Vec::new();
        let n = program.n_intervals();
        let touching: Vec<_> = (0..=n)
            .map(|t| Self::touching(scene, program, phases, t))
            .collect();
        for t in 0..=n {
            if program.nodes[t].var.is_none() || program.master_node(t) != t {
                continue;
            }
            kinematics.update(&program.system.model, &near[t]);
            let since = |a: usize, other: Result<usize, usize>| -> Option<usize> {
                (0..=n)
                    .filter(|&i| touching[i].contains(&(a, other)))
                    .map(|i| i.abs_diff(t))
                    .min()
            };
            self.pairs_at(program, t, &kinematics, &since, extra, &mut out);
        }
        out
    }

    fn pairs_at(
        &self,
        program: &Program,
        t: usize,
        kinematics: &Kinematics,
        since: &dyn Fn(usize, Other) -> Option<usize>,
        extra: &ExtraClearance,
        out: &mut Vec<Pair>,
    ) {
        let margins = &program.settings.margins;
        let keyframes = program.grid.is_keyframes();
        let paper = program.settings.preset == Preset::Paper;
        for a in 0..self.balls.len() {
            // The paper penalises end-effectors and objects, not every link.
            if paper && a < program.system.n_robot_joints && !self.feet[a] && !self.hands[a] {
                continue;
            }
            for primitive in &self.primitives {
                if primitive.joint == Some(a) || self.balls[a].is_empty() {
                    continue;
                }
                let Some(other) = primitive.joint.map(Ok).or(primitive.body.map(Err)) else {
                    continue;
                };
                let d = since(a, other);
                if d == Some(0) {
                    continue;
                }
                let full = if self.feet[a] && primitive.joint.is_none() {
                    margins.swing
                } else {
                    margins.clearance
                };
                let more = extra.get(&(t, a, other)).copied().unwrap_or(0.0);
                let clearance = if keyframes {
                    0.0
                } else {
                    Self::ramp(full, d) + more
                };
                let body_from_a = match primitive.joint {
                    Some(j) => {
                        kinematics.world_from_joint[j].inverse() * kinematics.world_from_joint[a]
                    }
                    None => kinematics.world_from_joint[a],
                };
                let primitive_from_a = primitive.from_body * body_from_a;
                let balls: Vec<Ball> = self.balls[a]
                    .iter()
                    .filter(|(c, r)| {
                        paper || distance(&primitive_from_a.act(*c), &primitive.obstacle) - r < NEAR
                    })
                    .copied()
                    .collect();
                if balls.is_empty() {
                    continue;
                }
                let (obstacle, obstacle_from_b) = (primitive.obstacle.clone(), primitive.from_body);
                let term: Arc<dyn PoseTerm> = if paper {
                    Arc::new(Sigmoid {
                        points: balls,
                        obstacle,
                        obstacle_from_b,
                        slope: SIGMOID_SLOPE,
                    })
                } else {
                    Arc::new(Distance {
                        balls,
                        obstacle,
                        obstacle_from_b,
                        clearance,
                    })
                };
                out.push(Pair {
                    node: t,
                    a,
                    b: primitive.joint,
                    term,
                });
            }
        }
        if paper {
            return;
        }
        for &(a, b) in &self.self_pairs {
            let b_from_a =
                kinematics.world_from_joint[b].inverse() * kinematics.world_from_joint[a];
            let (near_a, near_b) = near_balls(&self.balls[a], &self.balls[b], &b_from_a);
            if !near_a.is_empty() {
                let clearance = if keyframes {
                    0.0
                } else {
                    margins.self_clearance
                };
                let obstacle = Obstacle::Balls(near_b);
                let term = Arc::new(Distance {
                    balls: near_a,
                    obstacle,
                    obstacle_from_b: Pose::identity(),
                    clearance,
                });
                out.push(Pair {
                    node: t,
                    a,
                    b: Some(b),
                    term,
                });
            }
        }
    }

    /// Overlaps deeper than `tolerance` half-way between neighbouring nodes: interval, pair, depth [m].
    pub fn between(
        &self,
        program: &Program,
        scene: &Scene,
        phases: &[Phase],
        nodes: &[Vec<f64>],
        tolerance: f64,
    ) -> Vec<(usize, usize, Other, f64)> {
        let model = &program.system.model;
        let mut kinematics = Kinematics::new(model);
        let mut out = Vec::new();
        for t in 0..program.n_intervals() {
            let half: Vec<f64> = model
                .difference(&nodes[t], &nodes[t + 1])
                .iter()
                .map(|d| 0.5 * d)
                .collect();
            kinematics.update(model, &model.integrate(&nodes[t], &half));
            let touching: BTreeSet<_> = Self::touching(scene, program, phases, t)
                .union(&Self::touching(scene, program, phases, t + 1))
                .copied()
                .collect();
            self.overlaps(
                &kinematics,
                &|a, b| touching.contains(&(a, b)),
                &mut |depth, a, other| {
                    if depth > tolerance {
                        out.push((t, a, other, depth));
                    }
                },
            );
        }
        out
    }

    /// Worst overlap of the system at a configuration, of bodies that do not touch: depth [m] and the pair.
    pub fn deepest(
        &self,
        kinematics: &Kinematics,
        touching: &dyn Fn(usize, Other) -> bool,
    ) -> Option<(f64, usize, Other)> {
        let mut worst: Option<(f64, usize, Other)> = None;
        self.overlaps(kinematics, touching, &mut |depth, a, b| {
            if depth > 0.0 && worst.as_ref().is_none_or(|w| depth > w.0) {
                worst = Some((depth, a, b));
            }
        });
        worst
    }

    /// Calls `see(depth, a, b)` for every pair of bodies that do not touch; a negative depth is a distance.
    fn overlaps(
        &self,
        kinematics: &Kinematics,
        touching: &dyn Fn(usize, Other) -> bool,
        see: &mut dyn FnMut(f64, usize, Other),
    ) {
        for a in 0..self.balls.len() {
            for primitive in &self.primitives {
                let Some(other) = primitive.joint.map(Ok).or(primitive.body.map(Err)) else {
                    continue;
                };
                if primitive.joint == Some(a) || self.balls[a].is_empty() || touching(a, other) {
                    continue;
                }
                let body_from_a = match primitive.joint {
                    Some(j) => {
                        kinematics.world_from_joint[j].inverse() * kinematics.world_from_joint[a]
                    }
                    None => kinematics.world_from_joint[a],
                };
                let x = primitive.from_body * body_from_a;
                let depth = self.balls[a]
                    .iter()
                    .map(|(c, r)| r - distance(&x.act(*c), &primitive.obstacle))
                    .fold(f64::NEG_INFINITY, f64::max);
                see(depth, a, other);
            }
        }
        for &(a, b) in &self.self_pairs {
            see(-self.link_distance(kinematics, a, b), a, Ok(b));
        }
    }

    /// Bodies that the start contacts of a scene bring together.
    pub fn start_touches(scene: &Scene, system: &System) -> Vec<Touch> {
        let mut out = Vec::new();
        for contact in &scene.start_contacts {
            let (a, b) = (
                &scene.interfaces[contact.a.0],
                &scene.interfaces[contact.b.0],
            );
            let body = |i: &scene::Interface| system.carrier(i.owner, &i.body_from_interface).body;
            match (body(a), b.owner, body(b)) {
                (Body::Joint(j), Owner::Static(s), _) => out.push((j, Err(s))),
                (Body::Joint(j), _, Body::Joint(k)) => out.extend([(j, Ok(k)), (k, Ok(j))]),
                _ => {}
            }
        }
        out
    }
}

/// Balls of two links that are near one another.
fn near_balls(a: &[Ball], b: &[Ball], b_from_a: &Pose) -> (Vec<Ball>, Vec<Ball>) {
    let near = |x: &Ball, y: &Ball| (b_from_a.act(x.0) - y.0).norm() - x.1 - y.1 < NEAR_SELF;
    let near_a = a
        .iter()
        .filter(|x| b.iter().any(|y| near(x, y)))
        .copied()
        .collect();
    let near_b = b
        .iter()
        .filter(|y| a.iter().any(|x| near(x, y)))
        .copied()
        .collect();
    (near_a, near_b)
}

/// Signed distance of a point to an obstacle, smooth at edges.
fn distance(p: &Vector3<f64>, obstacle: &Obstacle) -> f64 {
    match obstacle {
        Obstacle::Box(half) => box_distance(p, half).0,
        Obstacle::HalfSpace => p.z,
        Obstacle::Balls(balls) => balls
            .iter()
            .map(|(c, r)| (p - c).norm() - r)
            .fold(f64::INFINITY, f64::min),
    }
}

fn primitive(joint: Option<usize>, body: Option<usize>, placed: &PlacedShape) -> Primitive {
    let (obstacle, turn) = match &placed.shape {
        Shape::Box { half_size } => (Obstacle::Box(*half_size), placed.body_from_shape),
        Shape::HalfSpace => (Obstacle::HalfSpace, placed.body_from_shape),
        Shape::Sphere { .. } | Shape::Capsule { .. } => {
            let mut balls = Vec::new();
            cover(&Pose::identity(), &placed.shape, &mut balls);
            (Obstacle::Balls(balls), placed.body_from_shape)
        }
    };
    Primitive {
        joint,
        body,
        from_body: turn.inverse(),
        obstacle,
    }
}

/// Balls that cover a shape (a box up to its edges), in the frame in which the shape's pose is given.
fn cover(pose: &Pose, shape: &Shape, out: &mut Vec<Ball>) {
    match shape {
        Shape::Sphere { radius } => out.push((pose.origin(), *radius)),
        Shape::Capsule {
            radius,
            half_length,
        } => {
            let pieces = (2.0 * half_length / radius).ceil().max(1.0) as usize;
            for i in 0..=pieces {
                let z = half_length * (2.0 * i as f64 / pieces as f64 - 1.0);
                out.push((pose.act(Vector3::new(0.0, 0.0, z)), *radius));
            }
        }
        Shape::Box { half_size } => {
            let radius = half_size.min().min(BOX_BALL);
            let count = half_size.map(|h| ((h - radius) / radius).ceil().max(0.0) as usize + 1);
            let at = |i: usize, k: usize| {
                if count[k] == 1 {
                    0.0
                } else {
                    (half_size[k] - radius) * (2.0 * i as f64 / (count[k] - 1) as f64 - 1.0)
                }
            };
            for i in 0..count[0] {
                for j in 0..count[1] {
                    for k in 0..count[2] {
                        let inner = |i: usize, n: usize| i > 0 && i + 1 < n;
                        // Balls in the middle are hidden by those at the faces.
                        if inner(i, count[0]) && inner(j, count[1]) && inner(k, count[2]) {
                            continue;
                        }
                        out.push((pose.act(Vector3::new(at(i, 0), at(j, 1), at(k, 2))), radius));
                    }
                }
            }
            // Small balls for the edges and corners that stick out of the large ones.
            let small = radius.min(EDGE_BALL);
            let inset = half_size.map(|h| h - EDGE_INSET * small);
            for code in 0..27_usize {
                let side = Vector3::new(
                    (code % 3) as f64 - 1.0,
                    (code / 3 % 3) as f64 - 1.0,
                    (code / 9) as f64 - 1.0,
                );
                let middles = side.iter().filter(|x| **x == 0.0).count();
                let long = (0..3).all(|k| side[k] != 0.0 || half_size[k] > LONG_EDGE);
                if middles == 0 || (middles == 1 && long) {
                    out.push((pose.act(inset.component_mul(&side)), small));
                }
            }
        }
        Shape::HalfSpace => {}
    }
}

/// Points that stand for an object: the corners and edge middles of a box, the balls of anything else.
fn corners(placed: &PlacedShape, out: &mut Vec<Ball>) {
    let Shape::Box { half_size } = &placed.shape else {
        cover(&placed.body_from_shape, &placed.shape, out);
        return;
    };
    let radius = 0.003;
    let reach = half_size.map(|h| h - radius);
    for code in 0..27_usize {
        let offset = Vector3::new(
            (code % 3) as f64 - 1.0,
            (code / 3 % 3) as f64 - 1.0,
            (code / 9) as f64 - 1.0,
        );
        if offset.iter().filter(|x| **x == 0.0).count() <= 1 {
            out.push((
                placed.body_from_shape.act(reach.component_mul(&offset)),
                radius,
            ));
        }
    }
}
