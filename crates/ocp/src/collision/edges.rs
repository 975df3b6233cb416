//! Edges of boxes: two boxes can be in one another though all corners of both are outside, and then an edge of one goes
//! through a face of the other.

use super::Ball;
use crate::terms::distance::{EVENNESS, Obstacle};
use nalgebra::Vector3;
use spatial::Pose;

/// Radius of the points that stand for an edge [m].
const POINT: f64 = 0.003;
/// Distance of neighbouring points [m].
const STEP: f64 = 0.02;
/// Least distance of those that get a say at once [m]: many that are equally near would make an edge look nearer than it is.
const APART: f64 = 0.04;

/// Points on the edges of a box, in its frame, that are in a ball.
fn along_edges(half: &Vector3<f64>, (centre, radius): Ball) -> Vec<Vector3<f64>> {
    let reach = half.map(|h| (h - POINT).max(0.0));
    let mut out = Vec::new();
    for k in 0..3 {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let count = (2.0 * reach[k] / STEP).ceil().max(1.0);
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
    let points = along_edges(half, near).into_iter().map(distance);
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
