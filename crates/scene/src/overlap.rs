//! Do objects share space with static bodies or each other at the start?
//!
//! Boxes against boxes and anything against half-spaces are tested, balls and capsules against boxes are not. The robot is
//! left to the optimiser, which measures its distances anyway.
//!
//! Source: C. Ericson, Real-Time Collision Detection, section 4.4.1 (separating axes of oriented boxes).

use crate::draft::Draft;
use crate::file::ObjectEntry;
use crate::touch::millimetres;
use crate::{Fault, PlacedShape, SceneError, Shape};
use nalgebra::Vector3;
use spatial::Pose;

/// Bodies in contact may overlap by this much [m].
const PLAY: f64 = 1e-3;

/// Axes shorter than this, cross products of parallel edges, are skipped.
const SHORTEST_AXIS: f64 = 1e-6;

/// Refuses a start where an object overlaps with something.
pub(crate) fn check(draft: &Draft, entries: &[ObjectEntry]) -> Result<(), SceneError> {
    for (index, object) in draft.objects.iter().enumerate() {
        let own = (object.shapes.as_slice(), object.world_from_start);
        let others = draft.objects[..index]
            .iter()
            .map(|other| (&other.name, other.shapes.as_slice(), other.world_from_start));
        let statics = draft
            .statics
            .iter()
            .map(|body| (&body.name, body.shapes.as_slice(), Pose::identity()));
        for (name, shapes, world_from_other) in others.chain(statics) {
            let depth = depth_of_bodies(own, (shapes, world_from_other));
            if depth > PLAY {
                let entry = &entries[index];
                let position = entry.position.as_ref().map(super::source::At::span);
                let fault = Fault::Overlap {
                    first: object.name.clone(),
                    second: name.clone(),
                    depth: millimetres(depth),
                };
                let span = position.unwrap_or(entry.name.span());
                return Err(draft.source.fault(span, fault));
            }
        }
    }
    Ok(())
}

/// Deepest overlap of two bodies' shapes [m], 0 if they are apart.
fn depth_of_bodies(a: (&[PlacedShape], Pose), b: (&[PlacedShape], Pose)) -> f64 {
    let mut deepest = 0f64;
    for x in a.0 {
        for y in b.0 {
            let (pose_x, pose_y) = (a.1 * x.body_from_shape, b.1 * y.body_from_shape);
            let depth = match (&x.shape, &y.shape) {
                (Shape::Box { half_size: hx }, Shape::Box { half_size: hy }) => {
                    depth_of_boxes((hx, &pose_x), (hy, &pose_y))
                }
                (shape, Shape::HalfSpace) => depth_below(shape, &pose_x, &pose_y),
                _ => 0.0,
            };
            deepest = deepest.max(depth);
        }
    }
    deepest
}

/// How far two oriented boxes overlap along the axis of least overlap [m]; 0 if an axis separates them.
fn depth_of_boxes(a: (&Vector3<f64>, &Pose), b: (&Vector3<f64>, &Pose)) -> f64 {
    let a_from_b = a.1.inverse() * *b.1;
    let (r, t) = (a_from_b.rotation(), a_from_b.origin());
    let axes_a = [Vector3::x(), Vector3::y(), Vector3::z()];
    let axes_b = [0, 1, 2].map(|i| r.column(i).into_owned());
    let crossed = axes_a
        .iter()
        .flat_map(|x| axes_b.iter().map(move |y| x.cross(y)));
    axes_a
        .iter()
        .chain(&axes_b)
        .copied()
        .chain(crossed)
        .filter_map(|axis| axis.try_normalize(SHORTEST_AXIS))
        .map(|axis| {
            let reach_a = axis.abs().dot(a.0);
            let reach_b = r.tr_mul(&axis).abs().dot(b.0);
            reach_a + reach_b - axis.dot(&t).abs()
        })
        .fold(f64::INFINITY, f64::min)
        .max(0.0)
}

/// How far a shape reaches below the plane of a half-space [m]; 0 if it does not.
fn depth_below(shape: &Shape, world_from_shape: &Pose, world_from_plane: &Pose) -> f64 {
    let plane_from_shape = world_from_plane.inverse() * *world_from_shape;
    let up_in_shape = plane_from_shape.rotate_inverse(Vector3::z());
    let reach = match shape {
        Shape::Box { half_size } => up_in_shape.abs().dot(half_size),
        Shape::Sphere { radius } => *radius,
        Shape::Capsule {
            radius,
            half_length,
        } => radius + half_length * up_in_shape.z.abs(),
        Shape::HalfSpace => return 0.0,
    };
    (reach - plane_from_shape.origin().z).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turned(x: f64, z: f64, yaw: f64) -> Pose {
        let (sin, cos) = (yaw / 2.0).sin_cos();
        Pose::from_xyzquat(&[x, 0.0, z, 0.0, 0.0, sin, cos])
    }

    #[test]
    fn boxes_overlap_by_the_least_push_that_parts_them() {
        let half = Vector3::new(0.1, 0.1, 0.1);
        let depth = |x, z, yaw| {
            depth_of_boxes((&half, &turned(0.0, 0.0, 0.0)), (&half, &turned(x, z, yaw)))
        };
        assert!((depth(0.15, 0.0, 0.0) - 0.05).abs() < 1e-15);
        assert!((depth(0.15, 0.18, 0.0) - 0.02).abs() < 1e-15);
        assert_eq!(depth(0.21, 0.0, 0.0), 0.0);
        // an edge at 45° reaches 0.1 √2
        let edge = depth(0.2, 0.0, std::f64::consts::FRAC_PI_4);
        assert!((edge - 0.1 * (2f64.sqrt() - 1.0)).abs() < 1e-12);
    }

    #[test]
    fn crossed_edges_are_separated_only_by_their_common_normal() {
        let rod = Vector3::new(1.0, 0.1, 0.1);
        let tilt = std::f64::consts::FRAC_PI_8;
        let world_from_a = Pose::from_xyzquat(&[0.0, 0.0, 0.0, tilt.sin(), 0.0, 0.0, tilt.cos()]);
        let half = 0.5f64.sqrt();
        // the second rod lies along y, on edge as well, 0.3 m higher: edges reach 0.1 √2 each
        let upright = Pose::from_xyzquat(&[0.0, 0.0, 0.3, 0.0, 0.0, half, half]) * world_from_a;
        assert_eq!(depth_of_boxes((&rod, &world_from_a), (&rod, &upright)), 0.0);
        let lower = Pose::from_translation(0.0, 0.0, -0.05) * upright;
        let depth = depth_of_boxes((&rod, &world_from_a), (&rod, &lower));
        assert!((depth - (0.2 * 2f64.sqrt() - 0.25)).abs() < 1e-12);
    }

    #[test]
    fn shapes_sink_into_the_ground_by_their_lowest_point() {
        let ground = Pose::identity();
        let lying = Pose::from_xyzquat(&[0.0, 0.0, 0.1, 0.0, 0.5f64.sqrt(), 0.0, 0.5f64.sqrt()]);
        let capsule = Shape::Capsule {
            radius: 0.15,
            half_length: 1.0,
        };
        assert!((depth_below(&capsule, &lying, &ground) - 0.05).abs() < 1e-12);
        let ball = Shape::Sphere { radius: 0.1 };
        assert!(depth_below(&ball, &lying, &ground) < 1e-12);
    }
}
