//! Edges of boxes: two boxes can be in one another though all corners of both are outside, and then an edge of one goes
//! through a face of the other.

use super::pairs::{Says, value};
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
/// Least distance of those that get a say at once [m]: many that are equally near would make an edge look nearer than it is.
const APART: f64 = 0.04;
/// By how much a point on an edge is nearer than the corners of an object where it gets a say, if it is inside the other box
/// [m]: edges that go through faces are rare, and rows for all that come near cost iterations.
const NEARER: f64 = 0.002;
/// The most that is demanded of edges of static boxes [m].
const MOST_OF_EDGES: f64 = 0.005;

/// Points on the edges of a box, in its frame, that are in a ball; neighbouring ones are `apart` [m] at most.
pub(super) fn along_edges(
    half: &Vector3<f64>,
    apart: f64,
    (centre, radius): Ball,
) -> Vec<Vector3<f64>> {
    let reach = half.map(|h| (h - POINT).max(0.0));
    let mut out = Vec::new();
    for k in 0..3 {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let count = (2.0 * reach[k] / apart).ceil().max(1.0);
        let step = 2.0 * reach[k] / count;
        for at in 0..=count as usize {
            let along = at as f64 * step - reach[k];
            if (along - centre[k]).abs() > radius {
                continue;
            }
            for (side_i, side_j) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
                let mut point = Vector3::zeros();
                point[i] = side_i * reach[i];
                point[j] = side_j * reach[j];
                point[k] = along;
                if (point - centre).norm() <= radius {
                    out.push(point);
                }
            }
        }
    }
    out
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
    let reach = other.norm() + POINT + EVENNESS + below.max(0.0);
    let near = (to_from_of.inverse().origin(), reach);
    let distance = |p: Vector3<f64>| (to.roughly_nearest(&to_from_of.act(p)) - POINT, p);
    let points = along_edges(half, STEP, near).into_iter().map(distance);
    let mut points: Vec<_> = points.filter(|(d, _)| *d < below).collect();
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
    /// Points on the edges of a box of an object that are inside another box though its corners are not as deep, and on those of
    /// the other box, if it is static, inside it; in the frames of the bodies, in any of the configurations.
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
            let distance = |(c, r): &Ball| other.obstacle.roughly_nearest(&x.act(*c)) - r;
            let corners = self.balls[a].iter().map(distance);
            let below = (corners.fold(f64::INFINITY, f64::min) - NEARER).min(0.0);
            let there = x * a_from_own;
            let found = nearest(&own.obstacle, &other.obstacle, &there, below);
            add(found, a_from_own, &mut of_own);
            if other.body.is_some() {
                let there = there.inverse();
                let found = nearest(&other.obstacle, &own.obstacle, &there, below);
                add(found, b_from_other, &mut of_other);
            }
        }
        (of_own, of_other)
    }
}

/// Points on edges of static bodies, in the world, against a box of an object; `demanded` makes what a row says in a
/// configuration a clearance.
pub(super) fn edge_row(
    (a, own): (usize, &Primitive),
    points: &[Ball],
    demanded: &dyn Fn(Says<'_>) -> f64,
) -> Inverse<Distance> {
    let row = |clearance: f64| {
        let (balls, obstacle) = (points.to_vec(), own.obstacle.clone());
        Inverse(Distance::new(balls, obstacle, own.from_body, clearance))
    };
    let free = row(0.0);
    let clearance = demanded(&|kinematics| value(&free, &kinematics.world_from_joint[a]));
    row(clearance.min(MOST_OF_EDGES))
}
