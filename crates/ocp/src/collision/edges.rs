//! Edges of boxes: two boxes can be in one another though all corners of both are outside, and then an edge of one goes
//! through a face of the other.

use super::pairs::{Said, Says};
use super::{Ball, CollisionModel, Primitive};
use crate::terms::distance::{Distance, EVENNESS, Obstacle};
use crate::terms::inverse::Inverse;
use multibody::Kinematics;
use nalgebra::Vector3;
use spatial::Pose;

/// Radius of the points that stand for an edge [m].
pub(super) const POINT: f64 = 0.003;
/// Distance of neighbouring points [m].
const STEP: f64 = 0.02;
/// To which the nearest point of an edge is found [m].
const RESOLUTION: f64 = 0.002;
/// Least distance of those that get a say at once [m]: many that are equally near would make an edge look nearer than it is.
const APART: f64 = 0.04;
/// By how much a point on an edge is nearer than the corners of an object where it gets a say, if it is inside the other box
/// [m]: edges that go through faces are rare, and rows for all that come near cost iterations.
const NEARER: f64 = 0.002;
/// The most that is demanded of edges of the other box [m].
const MOST_OF_EDGES: f64 = 0.005;

/// Edges of a box, drawn in by the radius of its points: axis, half length, and their middle, in its frame.
fn edges(half: &Vector3<f64>) -> impl Iterator<Item = (usize, f64, Vector3<f64>)> {
    let reach = half.map(|h| (h - POINT).max(0.0));
    let sides = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
    (0..3).flat_map(move |k| {
        sides.map(|(side_i, side_j)| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let mut middle = Vector3::zeros();
            middle[i] = side_i * reach[i];
            middle[j] = side_j * reach[j];
            (k, reach[k], middle)
        })
    })
}

/// Points on the edges of a box, in its frame, that are in a ball; neighbouring ones are `apart` [m] at most.
pub(super) fn along_edges(
    half: &Vector3<f64>,
    apart: f64,
    (centre, radius): Ball,
) -> Vec<Vector3<f64>> {
    let mut out = Vec::new();
    for (k, length, middle) in edges(half) {
        let count = (2.0 * length / apart).ceil().max(1.0);
        let points = (0..=count as usize).map(|at| {
            let mut point = middle;
            point[k] = (2.0 * at as f64 / count - 1.0) * length;
            point
        });
        out.extend(points.filter(|p| (p - centre).norm() <= radius));
    }
    out
}

/// The point of each edge of a box that is nearest to another one, in the frame of the first. The distance along an edge is
/// convex, inside too, so that a golden section finds it.
fn nearest_of_edges(
    half: &Vector3<f64>,
    distance: impl Fn(&Vector3<f64>) -> f64,
    below: f64,
) -> Vec<Vector3<f64>> {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let mut out = Vec::new();
    for (k, length, mut point) in edges(half) {
        if distance(&point) - length > below {
            continue;
        }
        let mut at = |along: f64| {
            point[k] = along;
            distance(&point)
        };
        let (mut from, mut to) = (-length, length);
        while to - from > RESOLUTION {
            let inner = golden * (to - from);
            if at(to - inner) < at(from + inner) {
                to = from + inner;
            } else {
                from = to - inner;
            }
        }
        point[k] = 0.5 * (from + to);
        out.push(point);
    }
    out
}

/// True if no point on the edges of either box can be as near to the other one as `below` [m], by the middle of the first alone.
fn are_apart(of: &Vector3<f64>, to: &Obstacle, to_from_of: &Pose, below: f64) -> bool {
    to.roughly_nearest(&to_from_of.origin()) - of.norm() - 2.0 * POINT >= below
}

/// Points on the edges of a box that are nearer to another one than `below` [m], the nearest ones of each surrounding: their
/// distances [m], least first, and balls in the frame of the box whose edges they are. None unless both are boxes.
pub(super) fn nearest(
    of: &Obstacle,
    to: &Obstacle,
    to_from_of: &Pose,
    below: f64,
) -> Vec<(f64, Ball)> {
    let (Obstacle::Box(half), Obstacle::Box(other)) = (of, to) else {
        return vec![];
    };
    if are_apart(half, to, to_from_of, below) {
        return vec![];
    }
    let reach = other.norm() + POINT + EVENNESS + below.max(0.0);
    let near = (to_from_of.inverse().origin(), reach);
    let distance = |p: Vector3<f64>| (to.roughly_nearest(&to_from_of.act(p)) - POINT, p);
    let own = nearest_of_edges(half, |p| distance(*p).0, below);
    let points = own.into_iter().chain(along_edges(half, STEP, near));
    let mut points: Vec<_> = points.map(distance).filter(|(d, _)| *d < below).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut out: Vec<(f64, Ball)> = Vec::new();
    for (d, p) in points {
        if out.iter().all(|(_, (q, _))| (p - q).norm() >= APART) {
            out.push((d, (p, POINT)));
        }
    }
    out
}

impl CollisionModel {
    /// Points on the edges of a box of a body that are inside another box though its corners and balls are not as deep, and on
    /// those of the other box inside it; in the frames of the bodies, in any of the configurations. Two objects are looked at from
    /// both sides, so that those of the other one are left out.
    pub(super) fn edges_inside(
        &self,
        (a, own): (usize, &Primitive),
        other: &Primitive,
        window: &[&Kinematics],
    ) -> (Vec<Ball>, Vec<Ball>) {
        let (mut of_own, mut of_other) = (vec![], vec![]);
        let add = |found: Vec<(f64, Ball)>, body_from_box: Pose, out: &mut Vec<Ball>| {
            for (_, (p, r)) in found {
                let ball = (body_from_box.act(p), r);
                if !out.contains(&ball) {
                    out.push(ball);
                }
            }
        };
        let (a_from_own, b_from_other) = (own.from_body.inverse(), other.from_body.inverse());
        for kinematics in window {
            let x = other.pose_of_joint(kinematics, a);
            let there = x * a_from_own;
            let Obstacle::Box(half) = &own.obstacle else {
                continue;
            };
            if are_apart(half, &other.obstacle, &there, 0.0) {
                continue;
            }
            let distance = |(c, r): &Ball| other.obstacle.roughly_nearest(&x.act(*c)) - r;
            let corners = self.balls[a].iter().map(distance);
            let below = (corners.fold(f64::INFINITY, f64::min) - NEARER).min(0.0);
            let found = nearest(&own.obstacle, &other.obstacle, &there, below);
            add(found, a_from_own, &mut of_own);
            if other.body.is_some() || !self.parts[a].is_empty() {
                let there = there.inverse();
                let found = nearest(&other.obstacle, &own.obstacle, &there, below);
                add(found, b_from_other, &mut of_other);
            }
        }
        (of_own, of_other)
    }
}

/// Points on edges of a body, in its frame, against a box of another one; `demanded` makes what a row says in a configuration a
/// clearance.
pub(super) fn edge_row(
    (a, own): (usize, &Primitive),
    of: &Primitive,
    points: &[Ball],
    demanded: &dyn Fn(Says<'_>) -> f64,
) -> Inverse<Distance> {
    let row = |clearance: f64| {
        let (balls, obstacle) = (points.to_vec(), own.obstacle.clone());
        Inverse(Distance::new(balls, obstacle, own.from_body, clearance))
    };
    let free = row(0.0);
    let a_from_other = |k: &Kinematics| of.pose_of_joint(k, a).inverse() * of.from_body;
    let clearance = demanded(&|k| Said::by(&free.0, &a_from_other(k)));
    row(clearance.min(MOST_OF_EDGES))
}
