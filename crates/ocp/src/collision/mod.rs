//! The collision model: balls that cover links and objects, obstacles that they avoid, and which pairs get rows.
//!
//! A link or object is seen twice: as balls that cover it, which avoid, and as boxes and balls, which are avoided. A pair of
//! bodies has one row per node if it comes near in given configurations (the initial guess or the last solution); whoever
//! solves checks the result and asks again with the pairs that were missed.

mod cover;
mod edges;
mod links;
mod pairs;
mod passages;
#[cfg(test)]
pub(crate) mod samples;
mod self_pair;
mod shared;
mod touches;
mod under;
mod watch;

use std::collections::{BTreeMap, BTreeSet};

pub(crate) use cover::corners;
use cover::parts;
use links::LinkShape;
pub use pairs::{Pair, Place};
pub use passages::{Crossing, Crossings};
use self_pair::SelfPair;
pub use watch::Watched;

use crate::program::{Grid, Phase, Program};
use crate::relative::{Body, Carrier, RelativeFrame};
use crate::settings::Integrator;
use crate::system::System;
use crate::terms::distance::{Ball, Obstacle, Part, bounding_ball};
use multibody::Kinematics;
use nalgebra::Vector3;
use scene::{Interface, Owner, PlacedShape, Role, Scene, Shape};
use spatial::Pose;
use symbolic::Contact;

/// Half length from which on a link's box counts for the penalties: torso, thighs, shins, forearms [m].
const LARGE_BOX: f64 = 0.07;
/// Joints up and down a limb from a contact within which links may come as near as they like to what it touches.
const NEIGHBOURS: usize = 2;

/// The body that a ball avoids: a joint, or a static body.
pub type Other = Result<usize, usize>;

/// What decides which pairs of bodies get clearance rows.
#[derive(Debug, Clone, Copy)]
pub enum Clearances<'a> {
    /// Those that come near in one configuration per node, or cross one another on the way between two.
    Near {
        /// Configurations of the system.
        nodes: &'a [Vec<f64>],
        /// Where they cross.
        crossings: &'a Crossings,
    },
    /// Those that an earlier solution has violated.
    Watched(&'a Watched),
}

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

/// Distance of balls around bodies from which on these do not overlap for sure [m].
const FAR: f64 = 0.02;

impl Primitive {
    /// Is it one of this body.
    fn is_of(&self, body: Other) -> bool {
        match body {
            Ok(joint) => self.joint == Some(joint),
            Err(body) => self.body == Some(body),
        }
    }

    /// Pose of a joint in the primitive's frame.
    fn pose_of_joint(&self, kinematics: &Kinematics, a: usize) -> Pose {
        let body_from_a = match self.joint {
            Some(j) => kinematics.world_from_joint[j].inverse() * kinematics.world_from_joint[a],
            None => kinematics.world_from_joint[a],
        };
        self.from_body * body_from_a
    }
}

/// Balls and obstacles of a scene.
#[derive(Debug, Clone)]
pub struct CollisionModel {
    balls: Vec<Vec<Ball>>,
    /// A ball around all balls of a body.
    bounds: Vec<Ball>,
    /// Shapes of links.
    parts: Vec<Vec<Part>>,
    primitives: Vec<Primitive>,
    /// Boxes of links.
    link_boxes: Vec<Vec<Primitive>>,
    self_pairs: Vec<SelfPair>,
    /// Joints within a few of each joint, up and down its limb.
    neighbours: Vec<Vec<usize>>,
    feet: Vec<bool>,
    /// What the paper's penalties see of a body: a point per end-effector, the centre of an object's shapes with their
    /// smallest half size.
    points: Vec<Vec<Ball>>,
    /// The same for the boxes of torso, thighs, shins and forearms, against objects and the environment.
    link_points: Vec<Vec<Ball>>,
    /// Rows that keyframes can have.
    rows: Vec<watch::Row>,
    /// Pairs of bodies that some contact could bring together.
    touchable: BTreeSet<Touch>,
}

impl CollisionModel {
    /// Covers all links and objects.
    pub fn new(scene: &Scene, system: &System) -> Self {
        let n = system.model.joints.len();
        let mut balls: Vec<Vec<Ball>> = vec![vec![]; n];
        let mut link_parts: Vec<Vec<Part>> = vec![vec![]; n];
        let mut link_shapes: Vec<Vec<LinkShape>> = vec![vec![]; n];
        for (frame, shapes) in system.model.frames.iter().zip(&scene.robot.shapes) {
            if let Some(joint) = frame.joint {
                for shape in shapes {
                    let pose = frame.joint_from_frame * shape.body_from_shape;
                    let own = LinkShape::new(&pose, &shape.shape);
                    balls[joint].extend_from_slice(&own.balls);
                    link_parts[joint].extend_from_slice(&own.parts);
                    link_shapes[joint].push(own);
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
            bounds: balls.iter().map(|b| bounding_ball(b)).collect(),
            balls,
            parts: link_parts.clone(),
            primitives,
            link_boxes: link_parts.iter().enumerate().map(boxes_of).collect(),
            self_pairs: vec![],
            neighbours: neighbours(system),
            feet: carries(Role::Foot),
            points: penalty_points(scene, system),
            link_points: link_parts.iter().map(|p| link_penalty_points(p)).collect(),
            rows: vec![],
            touchable: Self::find_touchable(scene, system),
        };
        model.self_pairs = links::self_pairs(scene, system, &link_shapes);
        model.rows = model.find_rows();
        model.note_start(scene, system);
        model
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
        let contacts = Self::contacts_at(program, phases, t);
        contacts
            .flat_map(|contact| touches_of(scene, &program.system, &contact))
            .collect()
    }

    /// Bodies that touch at a node by points of the first one alone, and how far the deepest of these is inside its own link [m].
    fn touching_by_points(
        scene: &Scene,
        program: &Program,
        phases: &[Phase],
        t: usize,
    ) -> BTreeMap<Touch, f64> {
        let (mut points, mut others) = (BTreeMap::new(), BTreeSet::new());
        for contact in Self::contacts_at(program, phases, t) {
            let a = &scene.interfaces[contact.a.0];
            let by_point = !a.patch && matches!(a.owner, Owner::Robot { .. });
            for touch in touches_of(scene, &program.system, &contact) {
                if by_point {
                    let inside = 1e-3 * f64::from(scene.inside_own_link(a));
                    let deepest = points.entry(touch).or_insert(inside);
                    *deepest = inside.max(*deepest);
                } else {
                    others.insert(touch);
                }
            }
        }
        points.retain(|touch, _| !others.contains(touch));
        points
    }

    /// Contacts that bind one of the two intervals at a node, and those whose bodies cannot have moved since then or until then: what
    /// is at rest at a node is where it was before with semi-implicit Euler, and where it will be with explicit Euler.
    fn contacts_at(program: &Program, phases: &[Phase], t: usize) -> impl Iterator<Item = Contact> {
        let (before, after) = match (program.grid, program.settings.integrator) {
            (Grid::Motion, Integrator::SemiImplicitEuler) => (1, 1),
            (Grid::Motion, _) => (2, 0),
            _ => (1, 0),
        };
        let intervals = t.saturating_sub(before)..=(t + after).min(program.n_intervals() - 1);
        intervals.flat_map(|i| phases[program.phase_of(i)].state.iter())
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

    /// Calls `see(depth, a, b)` for pairs of bodies that do not touch, those that overlap among them; a negative depth is a
    /// distance.
    fn overlaps(
        &self,
        kinematics: &Kinematics,
        touching: &dyn Fn(usize, Other) -> bool,
        see: &mut dyn FnMut(f64, usize, Other),
    ) {
        for a in 0..self.balls.len() {
            let (centre, radius) = self.bounds[a];
            for primitive in &self.primitives {
                let Some(other) = primitive.joint.map(Ok).or(primitive.body.map(Err)) else {
                    continue;
                };
                if primitive.joint == Some(a) || self.balls[a].is_empty() {
                    continue;
                }
                let x = primitive.pose_of_joint(kinematics, a);
                let far = primitive.obstacle.roughly_nearest(&x.act(centre)) > radius + FAR;
                if far || touching(a, other) {
                    continue;
                }
                let depth = self.balls[a]
                    .iter()
                    .map(|(c, r)| r - primitive.obstacle.nearest(&x.act(*c)))
                    .fold(f64::NEG_INFINITY, f64::max);
                let crossing = self.own(a).chain(&self.link_boxes[a]).flat_map(|own| {
                    let other_from_own = x * own.from_body.inverse();
                    let (own, other) = (&own.obstacle, &primitive.obstacle);
                    let of_own = edges::nearest(own, other, &other_from_own, 0.0);
                    let own_from_other = other_from_own.inverse();
                    let of_other = edges::nearest(other, own, &own_from_other, 0.0);
                    of_own.into_iter().chain(of_other)
                });
                let depth = crossing.fold(depth, |most, (distance, _)| most.max(-distance));
                see(depth, a, other);
            }
        }
        for pair in &self.self_pairs {
            if pair.is_far(kinematics) {
                continue;
            }
            see(-pair.beyond_home(kinematics), pair.a, Ok(pair.b));
        }
    }

    /// Links that keep out of one another, with their distance in the home posture [m], negative where they overlap; nearest first.
    pub fn distances_at_home(&self) -> Vec<(f64, usize, usize)> {
        let mut out: Vec<_> = (self.self_pairs.iter())
            .map(|pair| (pair.at_home, pair.a, pair.b))
            .collect();
        out.sort_by(|x, y| x.0.total_cmp(&y.0));
        out
    }

    /// Links that overlap in the home posture though not because of how the robot is built: how deep [m] and which, deepest first.
    pub fn overlaps_at_home(&self) -> Vec<(f64, usize, usize)> {
        let deep = self.self_pairs.iter().filter(|pair| pair.at_home < 0.0);
        let mut out: Vec<_> = deep.map(|pair| (-pair.at_home, pair.a, pair.b)).collect();
        out.sort_by(|x, y| y.0.total_cmp(&x.0));
        out
    }

    /// The boxes and other shapes that an object is.
    fn own(&self, joint: usize) -> impl Iterator<Item = &Primitive> {
        let of_joint = move |p: &&Primitive| p.joint == Some(joint);
        self.primitives.iter().filter(of_joint)
    }

    /// Bodies that the start contacts of a scene bring together.
    pub fn start_touches(scene: &Scene, system: &System) -> Vec<Touch> {
        let interface = |i: symbolic::InterfaceId| &scene.interfaces[i.0];
        let contacts = scene.start_contacts.iter();
        contacts
            .flat_map(|c| touches(scene, system, interface(c.a), interface(c.b)))
            .collect()
    }
}

/// The bodies that a contact brings together.
fn touches_of(scene: &Scene, system: &System, contact: &Contact) -> Vec<Touch> {
    let [a, b] = [contact.a, contact.b].map(|i| &scene.interfaces[i.0]);
    touches(scene, system, a, b)
}

/// The bodies that a contact of `a` on `b` brings together, each way round where both move. What stands on a mat is as near to the floor
/// under it as the mat makes it, so that these count as touching too.
fn touches(scene: &Scene, system: &System, a: &Interface, b: &Interface) -> Vec<Touch> {
    let body = |i: &Interface| system.carrier(i.owner, &i.body_from_interface).body;
    match (body(a), b.owner, body(b)) {
        (Body::Joint(j), Owner::Static(s), _) => {
            let below = |&o: &usize| o == s || under::is_close_under(b, &scene.statics[o]);
            let all = (0..scene.statics.len()).filter(below);
            all.map(|o| (j, Err(o))).collect()
        }
        (Body::Joint(j), _, Body::Joint(k)) => vec![(j, Ok(k)), (k, Ok(j))],
        _ => vec![],
    }
}

/// End-effector frames and centres of objects, for the paper's eq. (penalties).
fn penalty_points(scene: &Scene, system: &System) -> Vec<Vec<Ball>> {
    let mut out = vec![vec![]; system.model.joints.len()];
    for interface in &scene.interfaces {
        let carrier = system.carrier(interface.owner, &interface.body_from_interface);
        let end_effector = matches!(interface.role, Role::Foot | Role::Hand);
        if let (true, Owner::Robot { .. }, Body::Joint(j)) =
            (end_effector, interface.owner, carrier.body)
        {
            out[j].push((carrier.body_from_frame.origin(), 0.0));
        }
    }
    for (o, object) in scene.objects.iter().enumerate() {
        for placed in &object.shapes {
            let radius = match &placed.shape {
                Shape::Box { half_size } => half_size.min(),
                Shape::Sphere { radius } | Shape::Capsule { radius, .. } => *radius,
                Shape::HalfSpace => continue,
            };
            out[system.object_joint(o)].push((placed.body_from_shape.origin(), radius));
        }
    }
    out
}

/// Three balls along each large box of a link.
fn link_penalty_points(parts: &[Part]) -> Vec<Ball> {
    let mut out = Vec::new();
    for part in parts {
        let Part::Box(box_from_link, half) = part else {
            continue;
        };
        if half.max() < LARGE_BOX {
            continue;
        }
        let link_from_box = box_from_link.inverse();
        let along = Vector3::ith(half.imax(), half.max() - half.min());
        for s in [-1.0, 0.0, 1.0] {
            out.push((link_from_box.act(along * s), half.min()));
        }
    }
    out
}

/// Joints at most [`NEIGHBOURS`] up or down the tree from each joint.
fn neighbours(system: &System) -> Vec<Vec<usize>> {
    let joints = &system.model.joints;
    let mut out = vec![vec![]; joints.len()];
    for a in 0..joints.len() {
        let up = std::iter::successors(joints[a].parent, |&j| joints[j].parent);
        for b in up.take(NEIGHBOURS) {
            out[a].push(b);
            out[b].push(a);
        }
    }
    out
}

/// The boxes among the parts of a link, as primitives.
fn boxes_of((joint, parts): (usize, &Vec<Part>)) -> Vec<Primitive> {
    let primitive = |part: &Part| match part {
        Part::Box(box_from_link, half) => Some(Primitive {
            joint: Some(joint),
            body: None,
            from_body: *box_from_link,
            obstacle: Obstacle::Box(*half),
        }),
        Part::Ball(..) => None,
    };
    parts.iter().filter_map(primitive).collect()
}

fn primitive(joint: Option<usize>, body: Option<usize>, placed: &PlacedShape) -> Primitive {
    let (obstacle, turn) = match &placed.shape {
        Shape::Box { half_size } => (Obstacle::Box(*half_size), placed.body_from_shape),
        Shape::HalfSpace => (Obstacle::HalfSpace, placed.body_from_shape),
        Shape::Sphere { .. } | Shape::Capsule { .. } => {
            let mut balls = Vec::new();
            parts(&Pose::identity(), &placed.shape, &mut balls);
            (Obstacle::Parts(balls), placed.body_from_shape)
        }
    };
    Primitive {
        joint,
        body,
        from_body: turn.inverse(),
        obstacle,
    }
}

#[cfg(test)]
mod tests;
