//! Pairs that keyframes watch: only those that an earlier solution has violated get rows.
//!
//! Most pairs never matter for a keyframe, and with none at all the problem is a relaxation: what fails without them fails
//! with them.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::pairs::{BLUR, THROUGH};
use super::{Ball, CollisionModel, Other, Pair, Part, Place, Primitive, Touch, touches};
use crate::program::{Grid, Phase, Program};
use crate::system::System;
use crate::terms::PoseTerm;
use crate::terms::distance::{Distance, EVENNESS, MOST_CLEARANCE, Obstacle, bounding_ball};
use multibody::Kinematics;
use scene::{Interface, Owner, Scene};
use spatial::Pose;
use symbolic::{Contact, ContactState};

/// Violation from which on a pair is watched [m].
const VIOLATED: f64 = 1e-5;

/// Nodes and rows that get a place in the program.
pub type Watched = BTreeSet<(usize, usize)>;

/// Clearance of one body from one primitive or link, whatever the node.
#[derive(Debug, Clone)]
pub(super) struct Row {
    /// Joint that carries the balls.
    a: usize,
    /// Joint that carries the obstacle; `None` for the world.
    b: Option<usize>,
    /// The pair that may touch, or the index of a pair of links.
    pair: Result<Touch, usize>,
    term: Arc<Distance>,
    /// What it demands at least [m].
    clearance: f64,
    /// A ball around the obstacle, in the frame of b; `None` if it is unbounded.
    bound: Option<Ball>,
    /// Distance of bounding balls from which on the row cannot be violated [m].
    blur: f64,
    /// Are these two objects that stand at the start at least as far from one another as any clearance?
    begins_apart: bool,
}

impl CollisionModel {
    /// All rows that a keyframe can have, demanding what can be demanded of any.
    pub(super) fn find_rows(&self) -> Vec<Row> {
        let mut out = Vec::new();
        for (a, balls) in self.balls.iter().enumerate() {
            for primitive in &self.primitives {
                let other: Option<Other> = primitive.joint.map(Ok).or(primitive.body.map(Err));
                let (false, true, Some(other)) =
                    (balls.is_empty(), primitive.joint != Some(a), other)
                else {
                    continue;
                };
                out.push(row(
                    (a, primitive.joint),
                    Ok((a, other)),
                    balls,
                    (primitive.obstacle.clone(), primitive.from_body),
                    bound_of(primitive),
                    -BLUR,
                ));
            }
        }
        for (index, pair) in self.self_pairs.iter().enumerate() {
            out.push(row(
                (pair.a, Some(pair.b)),
                Err(index),
                &pair.balls,
                (Obstacle::Parts(pair.parts.clone()), Pose::identity()),
                Some(self.bounds[pair.b]),
                pair.clearance(-BLUR),
            ));
        }
        out
    }

    /// Notes which objects are apart at the start: those that are not may stand as near to one another as they do there.
    pub(super) fn note_start(&mut self, scene: &Scene, system: &System) {
        let mut kinematics = Kinematics::new(&system.model);
        kinematics.update(&system.model, &system.start(scene));
        let objects = system.n_robot_joints..;
        let both =
            |row: &Row| objects.contains(&row.a) && row.b.is_some_and(|b| objects.contains(&b));
        let begins_apart: Vec<bool> = (self.rows.iter())
            .map(|row| {
                both(row) && self.distance(row, &kinematics, MOST_CLEARANCE) >= MOST_CLEARANCE
            })
            .collect();
        for (row, apart) in self.rows.iter_mut().zip(begins_apart) {
            row.begins_apart = apart;
        }
    }

    /// Pairs of bodies whose interfaces could touch.
    pub(super) fn find_touchable(scene: &Scene, system: &System) -> BTreeSet<Touch> {
        let interfaces = &scene.interfaces;
        let on_robot = |i: &Interface| matches!(i.owner, Owner::Robot { .. });
        let mut out = BTreeSet::new();
        for a in interfaces.iter().filter(|a| a.lands) {
            for b in interfaces
                .iter()
                .filter(|b| !on_robot(b) && b.owner != a.owner)
            {
                out.extend(touches(scene, system, a, b));
            }
        }
        out
    }

    /// Rows of objects that stand on the same surface in one of the two phases at a node: once inside one another, nothing
    /// would part them again.
    pub fn watch_objects(
        &self,
        scene: &Scene,
        system: &System,
        phases: &[Phase],
        watched: &mut Watched,
    ) {
        let on = |state: &ContactState, o: usize| {
            let owner = |c: &Contact| scene.interfaces[c.a.0].owner;
            let mut on = state.iter().filter(|c| owner(c) == Owner::Object(o));
            on.next().map(|c| c.b)
        };
        for (index, row) in self.rows.iter().enumerate() {
            let object = |joint: usize| joint.checked_sub(system.n_robot_joints);
            let (Some(a), Some(b)) = (object(row.a), row.b.and_then(object)) else {
                continue;
            };
            for (t, phase) in phases.iter().enumerate() {
                let support = on(&phase.state, a);
                if support.is_some() && support == on(&phase.state, b) {
                    watched.extend([(t, index), (t + 1, index)]);
                }
            }
        }
    }

    /// Adds the rows whose bodies are nearer than `near` [m] at one configuration per node; true if a new one is violated.
    pub fn watch(
        &self,
        program: &Program,
        scene: &Scene,
        phases: &[Phase],
        nodes: &[Vec<f64>],
        near: f64,
        watched: &mut Watched,
    ) -> bool {
        let all = |_: usize, _: &Row| true;
        self.watch_these(program, scene, phases, (nodes, near), all, watched)
    }

    /// Adds those of static bodies at these nodes, floors aside: with these rows the robot stays on its side of what it walks around.
    pub fn watch_static(
        &self,
        program: &Program,
        scene: &Scene,
        phases: &[Phase],
        nodes: &[Vec<f64>],
        (here, near): (&[bool], f64),
        watched: &mut Watched,
    ) {
        let of_robot = |row: &Row| row.a < program.system.n_robot_joints;
        let these = |t: usize, row: &Row| {
            here[t] && of_robot(row) && row.pair.is_ok() && row.b.is_none() && row.bound.is_some()
        };
        self.watch_these(program, scene, phases, (nodes, near), these, watched);
    }

    fn watch_these(
        &self,
        program: &Program,
        scene: &Scene,
        phases: &[Phase],
        (nodes, near): (&[Vec<f64>], f64),
        these: impl Fn(usize, &Row) -> bool,
        watched: &mut Watched,
    ) -> bool {
        let model = &program.system.model;
        let mut kinematics = Kinematics::new(model);
        let mut is_new = false;
        for (t, q) in nodes.iter().enumerate() {
            if program.nodes[t].var.is_none() {
                continue;
            }
            let here;
            let touching = if program.grid == Grid::State {
                &self.touchable
            } else {
                here = Self::touching(scene, program, phases, t);
                &here
            };
            kinematics.update(model, q);
            for (index, row) in self.rows.iter().enumerate() {
                if !these(t, row) || row.pair.is_ok_and(|touch| touching.contains(&touch)) {
                    continue;
                }
                let demanded = self.demanded(program, row, t, touching);
                let near = near + (demanded - row.clearance);
                let distance = self.distance(row, &kinematics, near);
                if distance < near - BLUR {
                    is_new |= watched.insert((t, index)) && distance < demanded - VIOLATED;
                }
            }
        }
        is_new
    }

    /// Clearance demanded of a row at a node where these bodies touch [m]: what a motion demands there, less what its row may say more
    /// than this one, which is of all balls. Of a lone state, and at the end of a beginning of what may touch in the next phase, no more
    /// than that nothing is inside another.
    fn demanded(&self, program: &Program, row: &Row, t: usize, touching: &BTreeSet<Touch>) -> f64 {
        if program.grid == Grid::State {
            return row.clearance;
        }
        let open = program.grid == Grid::OpenKeyframes && t == program.n_intervals();
        let margins = &program.settings.margins;
        let wish = match row.pair {
            Err(links) => self.self_pairs[links].clearance(margins.self_clearance),
            Ok(touch) if open && self.touchable.contains(&touch) => return row.clearance,
            Ok((a, _)) if a >= program.system.n_robot_joints => {
                if !row.begins_apart {
                    return row.clearance;
                }
                margins.clearance.max(program.settings.objects_apart)
            }
            Ok((a, other)) => {
                let beside = |&j: &usize| touching.contains(&(j, other));
                if self.neighbours[a].iter().any(beside) {
                    return row.clearance;
                }
                let limb = self.neighbours[a].iter().copied().chain([a]);
                let mut held = limb.flat_map(|j| {
                    touching
                        .iter()
                        .filter(move |touch| touch.0 == j)
                        .filter_map(|touch| touch.1.ok())
                });
                let through = held.any(|object| touching.contains(&(object, other)));
                margins.clearance * if through { THROUGH } else { 1.0 }
            }
        };
        row.clearance.max(wish - BLUR)
    }

    /// Distance of a row's bodies [m]; infinite if it is more than `near` for sure.
    fn distance(&self, row: &Row, kinematics: &Kinematics, near: f64) -> f64 {
        let world_from_a = &kinematics.world_from_joint[row.a];
        let (centre, radius) = self.bounds[row.a];
        if let Some((other, other_radius)) = row.bound {
            let a = world_from_a.act(centre);
            let b = row
                .b
                .map_or(other, |b| kinematics.world_from_joint[b].act(other));
            let reach = radius + other_radius + row.blur + near;
            if (a - b).norm_squared() > reach * reach {
                return f64::INFINITY;
            }
        }
        let b_from_a = match row.b {
            Some(b) => kinematics.world_from_joint[b].inverse() * *world_from_a,
            None => *world_from_a,
        };
        let mut value = [f64::NAN];
        row.term.values(&b_from_a, &mut value);
        value[0]
    }

    /// The rows as pairs for the program.
    pub(super) fn watched_pairs(
        &self,
        program: &Program,
        scene: &Scene,
        phases: &[Phase],
        watched: &Watched,
    ) -> Vec<Pair> {
        let touching: Vec<_> = (0..program.nodes.len())
            .map(|t| Self::touching(scene, program, phases, t))
            .collect();
        let pair = |&(node, index): &(usize, usize)| {
            let row = &self.rows[index];
            let demanded = self.demanded(program, row, node, &touching[node]);
            Pair {
                place: Place::Node(node),
                a: row.a,
                b: row.b,
                term: Arc::new(row.term.demanding(demanded)),
            }
        };
        let free = |(t, _): &&(usize, usize)| program.nodes[*t].var.is_some();
        watched.iter().filter(free).map(pair).collect()
    }
}

fn row(
    (a, b): (usize, Option<usize>),
    pair: Result<Touch, usize>,
    balls: &[Ball],
    (obstacle, obstacle_from_b): (Obstacle, Pose),
    bound: Option<Ball>,
    clearance: f64,
) -> Row {
    let pairs = match &obstacle {
        Obstacle::Parts(parts) => balls.len() * parts.len(),
        _ => balls.len(),
    };
    Row {
        a,
        b,
        pair,
        term: Arc::new(Distance::new(
            balls.to_vec(),
            obstacle,
            obstacle_from_b,
            clearance,
        )),
        clearance,
        bound,
        blur: EVENNESS * (pairs as f64).ln(),
        begins_apart: false,
    }
}

/// A ball around a primitive, in the frame of its body.
fn bound_of(primitive: &Primitive) -> Option<Ball> {
    let body_from_primitive = primitive.from_body.inverse();
    match &primitive.obstacle {
        Obstacle::Box(half) => Some((body_from_primitive.origin(), half.norm())),
        Obstacle::HalfSpace => None,
        Obstacle::Parts(parts) => {
            let around = |part: &Part| match part {
                Part::Ball(centre, radius) => (*centre, *radius),
                Part::Box(part_from_b, half) => (part_from_b.inverse().origin(), half.norm()),
            };
            let (centre, radius) = bounding_ball(&parts.iter().map(around).collect::<Vec<_>>());
            Some((body_from_primitive.act(centre), radius))
        }
    }
}
