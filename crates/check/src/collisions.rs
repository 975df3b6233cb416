//! Collisions of the real shapes: robot, objects and environment, at nodes and between.
//!
//! Links collide by their primitive shapes; pairs of links at most two joints apart, or overlapping when all joints are
//! at zero, are left out. Bodies that are in contact in a phase may overlap: reported apart, as `contact_overlap`. Between
//! nodes the robot and the objects move along the screws between their poses. Bodies whose shapes are not read (meshes)
//! are reported as not checked.

use std::collections::BTreeSet;

use nalgebra::Vector3;
use plan::Geometry;
use spatial::Pose;

use crate::categories::Category;
use crate::distance::signed_distance;
use crate::kinematics;
use crate::measure::Measurements;
use crate::motion::{Motion, Owner};
use crate::report::Location;
use crate::shapes::{LARGEST, Solid};

/// Bodies that move as one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Group {
    Robot(usize),
    Object(usize),
    Static(usize),
}

/// What a shape is fixed to.
#[derive(Debug, Clone, Copy)]
enum Carrier {
    Link(usize),
    Object(usize),
    World,
}

struct Shape<'a> {
    name: &'a str,
    group: Group,
    carrier: Carrier,
    carrier_from_shape: Pose,
    solid: Solid,
}

struct Plane<'a> {
    name: &'a str,
    group: Group,
    world_from_plane: Pose,
}

/// Which shapes are where, and which pairs to look at.
struct Scene<'a> {
    shapes: Vec<Shape<'a>>,
    planes: Vec<Plane<'a>>,
    pairs: Vec<(usize, usize, Category)>,
}

/// Looks for collisions at every node and at `substeps − 1` places between each node and the next.
pub(crate) fn judge(motion: &Motion, substeps: usize, found: &mut Measurements) {
    let scene = Scene::new(motion, found);
    looked_at(motion, found);
    let touching: Vec<_> = (0..motion.phases.len())
        .map(|k| touching(motion, k))
        .collect();
    let substeps = substeps.max(1);
    let last = motion.n_intervals();
    for sample in 0..=last * substeps {
        let (t, step) = (sample / substeps, sample % substeps);
        let mut excluded = touching[motion.phase_of[t.min(last - 1)]].clone();
        if step == 0 && t > 0 {
            excluded.extend(&touching[motion.phase_of[t - 1]]);
        }
        let share = step as f64 / substeps as f64;
        let poses = scene.poses(motion, t, share);
        if let Some(lost) = scene.lost(&poses) {
            // Absurd numbers: distances would not be finite either.
            let place = || motion.place(t, lost);
            for category in CATEGORIES {
                found.add(category, f64::INFINITY, place);
            }
            continue;
        }
        let at = Sample {
            motion,
            t,
            share: (step > 0).then_some(share),
            excluded: &excluded,
        };
        scene.judge_pairs(&poses, &at, found);
        scene.judge_planes(&poses, &at, found);
    }
}

/// A moment of the plan, and the pairs that may overlap at it.
struct Sample<'a> {
    motion: &'a Motion<'a>,
    t: usize,
    share: Option<f64>,
    excluded: &'a BTreeSet<(Group, Group)>,
}

impl Sample<'_> {
    fn category(&self, a: Group, b: Group, otherwise: Category) -> Category {
        if self.excluded.contains(&ordered(a, b)) {
            Category::ContactOverlap
        } else {
            otherwise
        }
    }

    fn place(&self, a: &str, b: &str) -> Location {
        Location {
            share: self.share,
            ..self.motion.place(self.t, format!("{a} / {b}"))
        }
    }
}

fn ordered(a: Group, b: Group) -> (Group, Group) {
    if a <= b { (a, b) } else { (b, a) }
}

/// Pairs of groups in contact in phase `k`.
fn touching(motion: &Motion, k: usize) -> BTreeSet<(Group, Group)> {
    let group = |i: usize| match motion.interfaces[i].owner {
        Owner::Link(link) => Group::Robot(motion.robot.links[link].group),
        Owner::Object(object) => Group::Object(object),
        Owner::Static(body) => Group::Static(body),
    };
    motion.phases[k]
        .contacts
        .iter()
        .map(|contact| ordered(group(contact.a), group(contact.b)))
        .collect()
}

/// All kinds of overlap.
const CATEGORIES: [Category; 5] = [
    Category::CollisionEnv,
    Category::CollisionObj,
    Category::CollisionScene,
    Category::CollisionSelf,
    Category::ContactOverlap,
];

/// Takes note of the categories that there are shapes for.
fn looked_at(motion: &Motion, found: &mut Measurements) {
    let robot = !motion.robot.shapes.is_empty();
    let (objects, statics) = (
        !motion.plan.objects.is_empty(),
        !motion.plan.environment.is_empty(),
    );
    for category in CATEGORIES {
        let any = match category {
            Category::CollisionEnv => robot && statics,
            Category::CollisionObj => robot && objects,
            Category::CollisionScene => objects,
            _ => robot,
        };
        if any {
            found.looked_at(category);
        }
    }
}

impl<'a> Scene<'a> {
    fn new(motion: &'a Motion, found: &mut Measurements) -> Self {
        found.looked_at(Category::NotCollided);
        let mut scene = Self {
            shapes: robot_shapes(motion),
            planes: Vec::new(),
            pairs: Vec::new(),
        };
        for name in &motion.robot.unread {
            found.count(Category::NotCollided, name);
        }
        for (i, object) in motion.plan.objects.iter().enumerate() {
            let (group, carrier) = (Group::Object(i), Carrier::Object(i));
            scene.add_body(&object.name, group, carrier, &object.geometry, found);
        }
        for (i, body) in motion.plan.environment.iter().enumerate() {
            scene.add_body(
                &body.name,
                Group::Static(i),
                Carrier::World,
                &body.geometry,
                found,
            );
        }
        scene.pairs = scene.pairs_to_look_at(motion);
        scene
    }

    fn add_body(
        &mut self,
        name: &'a str,
        group: Group,
        carrier: Carrier,
        geometry: &'a [Geometry],
        found: &mut Measurements,
    ) {
        for shape in geometry {
            let carrier_from_shape = Pose::from_xyzquat(&shape.pose);
            match (shape.half_size, carrier) {
                _ if shape.is_plane() && matches!(carrier, Carrier::World) => {
                    self.planes.push(Plane {
                        name,
                        group,
                        world_from_plane: carrier_from_shape,
                    });
                }
                (Some(half), _) if !shape.is_plane() => {
                    let solid = Solid::Cuboid(Vector3::from(half).abs()).bounded();
                    self.shapes.push(Shape {
                        name,
                        group,
                        carrier,
                        carrier_from_shape,
                        solid,
                    });
                }
                _ => found.count(Category::NotCollided, name),
            }
        }
    }

    fn pairs_to_look_at(&self, motion: &Motion) -> Vec<(usize, usize, Category)> {
        let n = motion.robot.joints.len();
        let mut neutral = vec![0.0; 7 + n];
        neutral[6] = 1.0;
        let at_rest = vec![0.0; 6 + n];
        let links = kinematics::links(&motion.robot, &neutral, &at_rest, &at_rest);
        let home = |shape: &Shape| match shape.carrier {
            Carrier::Link(link) => links[link].world_from_frame * shape.carrier_from_shape,
            _ => shape.carrier_from_shape,
        };
        let mut pairs = Vec::new();
        for (j, b) in self.shapes.iter().enumerate() {
            for (i, a) in self.shapes[..j].iter().enumerate() {
                if a.group == b.group {
                    continue;
                }
                let category = match ordered(a.group, b.group) {
                    (Group::Static(_), Group::Static(_)) => continue,
                    (Group::Robot(g), Group::Robot(h)) => {
                        let near = motion.robot.joints_between(g, h) <= 2;
                        if near || signed_distance(&a.solid, &home(a), &b.solid, &home(b)) < 0.0 {
                            continue;
                        }
                        Category::CollisionSelf
                    }
                    (Group::Robot(_), Group::Static(_)) => Category::CollisionEnv,
                    (Group::Robot(_), _) => Category::CollisionObj,
                    _ => Category::CollisionScene,
                };
                pairs.push((i, j, category));
            }
        }
        pairs
    }

    /// World poses of all shapes, a `share` of the way from node `t` to the next.
    fn poses(&self, motion: &Motion, t: usize, share: f64) -> Vec<Pose> {
        let between;
        let (links, objects): (_, Vec<Pose>) = if share == 0.0 {
            (
                &motion.links[t],
                motion.objects[t]
                    .iter()
                    .map(|object| object.world_from_frame)
                    .collect(),
            )
        } else {
            let q = kinematics::between(&motion.plan.q[t], &motion.plan.q[t + 1], share);
            let at_rest = vec![0.0; 6 + motion.robot.joints.len()];
            between = kinematics::links(&motion.robot, &q, &at_rest, &at_rest);
            let pairs = motion.objects[t].iter().zip(&motion.objects[t + 1]);
            let objects = pairs.map(|(from, to)| {
                let (from, to) = (from.world_from_frame, to.world_from_frame);
                from.plus(&(to.minus(&from) * share))
            });
            (&between, objects.collect())
        };
        let pose = |shape: &Shape| match shape.carrier {
            Carrier::Link(link) => links[link].world_from_frame * shape.carrier_from_shape,
            Carrier::Object(object) => objects[object] * shape.carrier_from_shape,
            Carrier::World => shape.carrier_from_shape,
        };
        self.shapes.iter().map(pose).collect()
    }

    /// A shape that is nowhere near.
    fn lost(&self, poses: &[Pose]) -> Option<&str> {
        let is_near = |pose: &Pose| {
            pose.rotation().iter().all(|x| x.is_finite()) && pose.origin().norm() < LARGEST
        };
        let lost = poses.iter().position(|pose| !is_near(pose))?;
        Some(self.shapes[lost].name)
    }

    fn judge_pairs(&self, poses: &[Pose], at: &Sample, found: &mut Measurements) {
        for (i, j, category) in &self.pairs {
            let (a, b) = (&self.shapes[*i], &self.shapes[*j]);
            let reach = a.solid.reach() + b.solid.reach();
            let apart = (poses[*i].origin() - poses[*j].origin()).norm_squared();
            if apart >= reach * reach {
                continue;
            }
            let depth = -signed_distance(&a.solid, &poses[*i], &b.solid, &poses[*j]);
            // Not `depth > 0`: what is not a number is a collision.
            if !matches!(
                depth.partial_cmp(&0.0),
                Some(std::cmp::Ordering::Less | std::cmp::Ordering::Equal)
            ) {
                found.add(
                    at.category(a.group, b.group, *category),
                    1e3 * depth,
                    || at.place(a.name, b.name),
                );
            }
        }
    }

    fn judge_planes(&self, poses: &[Pose], at: &Sample, found: &mut Measurements) {
        for plane in &self.planes {
            let normal_in_world: Vector3<f64> = plane.world_from_plane.rotation().column(2).into();
            for (shape, pose) in self.shapes.iter().zip(poses) {
                let otherwise = match shape.group {
                    Group::Static(_) => continue,
                    Group::Robot(_) => Category::CollisionEnv,
                    Group::Object(_) => Category::CollisionScene,
                };
                let height =
                    (pose.origin() - plane.world_from_plane.origin()).dot(&normal_in_world);
                let depth = shape.solid.extent(&pose.rotate_inverse(normal_in_world)) - height;
                if depth > 0.0 {
                    let category = at.category(shape.group, plane.group, otherwise);
                    found.add(category, 1e3 * depth, || at.place(shape.name, plane.name));
                }
            }
        }
    }
}

fn robot_shapes<'a>(motion: &'a Motion) -> Vec<Shape<'a>> {
    let shape = |s: &crate::shapes::LinkShape| {
        let link = &motion.robot.links[s.link];
        Shape {
            name: link.name.as_str(),
            group: Group::Robot(link.group),
            carrier: Carrier::Link(s.link),
            carrier_from_shape: s.link_from_shape,
            solid: s.solid,
        }
    };
    motion.robot.shapes.iter().map(shape).collect()
}
