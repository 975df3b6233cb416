//! Balls that stand for shapes.

use super::Ball;
use crate::terms::distance::Part;
use nalgebra::Vector3;
use scene::{PlacedShape, Shape};
use spatial::Pose;

/// Largest ball that stands for a box [m]; corners of a box stick out of its balls by at most 0.73 of the radius.
const BOX_BALL: f64 = 0.035;
/// Radius of the balls at the edges and corners of a box [m], and their distance from its faces in radii: they bulge
/// by a quarter of the radius and leave a quarter of it uncovered at the corners.
const EDGE_BALL: f64 = 0.01;
const EDGE_INSET: f64 = 0.75;
/// Half length from which on an edge gets a ball in its middle [m].
const LONG_EDGE: f64 = 0.03;

/// The parts that a shape is: boxes as they are, anything round as balls.
pub(super) fn parts(pose: &Pose, shape: &Shape, out: &mut Vec<Part>) {
    match shape {
        Shape::Box { half_size } => out.push(Part::Box(pose.inverse(), *half_size)),
        Shape::Sphere { .. } | Shape::Capsule { .. } => {
            let mut balls = Vec::new();
            cover(pose, shape, &mut balls);
            out.extend(
                balls
                    .into_iter()
                    .map(|(centre, radius)| Part::Ball(centre, radius)),
            );
        }
        Shape::HalfSpace => {}
    }
}

/// Balls that cover a shape (a box up to its edges), in the frame in which the shape's pose is given.
pub(super) fn cover(pose: &Pose, shape: &Shape, out: &mut Vec<Ball>) {
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

/// By how much a part sticks out of the balls that cover it, at most: the corners of a box do, of small balls [m].
pub(super) fn sticks_out(part: &Part) -> f64 {
    match part {
        Part::Box(_, half_size) => {
            let small = half_size.min().min(EDGE_BALL);
            (EDGE_INSET * 3.0_f64.sqrt() - 1.0) * small
        }
        Part::Ball(..) => 0.0,
    }
}

/// The corners of a part that is a box, in the frame of its body.
pub(super) fn box_corners(part: &Part) -> Vec<Vector3<f64>> {
    let Part::Box(box_from_body, half_size) = part else {
        return vec![];
    };
    let body_from_box = box_from_body.inverse();
    let signs = (0..8_u8).map(|code| Vector3::from_fn(|k, _| f64::from(code >> k & 1) * 2.0 - 1.0));
    signs
        .map(|sign| body_from_box.act(half_size.component_mul(&sign)))
        .collect()
}

/// Points that stand for an object: the corners and edge middles of a box, the balls of anything else.
pub(crate) fn corners(placed: &PlacedShape, out: &mut Vec<Ball>) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_boxes_stick_out_of_their_balls_by_no_more_than_is_said() {
        let pose = Pose::random(3);
        for half_size in [[0.05, 0.04, 0.15], [0.006, 0.1, 0.1], [0.2, 0.01, 0.3]] {
            let shape = Shape::Box {
                half_size: Vector3::from(half_size),
            };
            let (mut balls, mut boxes) = (vec![], vec![]);
            cover(&pose, &shape, &mut balls);
            parts(&pose, &shape, &mut boxes);
            let said = sticks_out(&boxes[0]);
            let corners = box_corners(&boxes[0]);
            assert_eq!(corners.len(), 8);
            for corner in corners {
                let from_balls = balls.iter().map(|(c, r)| (corner - c).norm() - r);
                let out = from_balls.fold(f64::INFINITY, f64::min);
                assert!(out > 0.0 && out < said + 1e-12, "{out}, {said}");
            }
        }
    }
}
