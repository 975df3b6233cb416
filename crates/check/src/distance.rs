//! Signed distance of two convex solids: positive apart, minus the penetration depth when they overlap.
//!
//! A capsule is a segment (its core) with a radius. Cores that are apart: distance of the cores minus the radii, the
//! distance of a segment to a box by GJK (`parry3d`). Cores that overlap: the penetration depth is the least overlap
//! over the separating axes (face normals and cross products of edges), which for boxes and segments is exact: the
//! faces of their Minkowski difference have no other normals.
//! Source: Ericson, *Real-Time Collision Detection*, sections 4.4, 5.1.9 and 9.5.

use nalgebra::{Matrix3, Vector3};
use parry3d_f64::math::{Pose as ParryPose, Rotation, Vector};
use parry3d_f64::query::ClosestPoints;
use parry3d_f64::query::details::{
    closest_points_segment_segment, distance_support_map_support_map,
};
use parry3d_f64::shape::{Cuboid, Segment};
use spatial::Pose;

use crate::shapes::Solid;

/// Signed distance of two solids [m].
pub(crate) fn signed_distance(
    a: &Solid,
    world_from_a: &Pose,
    b: &Solid,
    world_from_b: &Pose,
) -> f64 {
    let a_from_b = world_from_a.inverse() * *world_from_b;
    match (a, b) {
        (
            Solid::Capsule {
                radius: ra,
                half_length: la,
            },
            Solid::Capsule {
                radius: rb,
                half_length: lb,
            },
        ) => segment_to_segment(*la, *lb, &a_from_b) - ra - rb,
        (
            Solid::Cuboid(half),
            Solid::Capsule {
                radius,
                half_length,
            },
        ) => cuboid_to_segment(half, *half_length, &a_from_b) - radius,
        (
            Solid::Capsule {
                radius,
                half_length,
            },
            Solid::Cuboid(half),
        ) => cuboid_to_segment(half, *half_length, &a_from_b.inverse()) - radius,
        (Solid::Cuboid(half_a), Solid::Cuboid(half_b)) => {
            cuboid_to_cuboid(half_a, half_b, &a_from_b)
        }
    }
}

/// Signed distance of a point to a box centred at the origin [m].
pub(crate) fn point_to_cuboid(point: &Vector3<f64>, half: &Vector3<f64>) -> f64 {
    let beyond = point.abs() - half;
    beyond.sup(&Vector3::zeros()).norm() + beyond.max().min(0.0)
}

/// Signed distance of a point, in the frame of the solid, to its surface [m].
pub(crate) fn point_to_solid(point: &Vector3<f64>, solid: &Solid) -> f64 {
    match solid {
        Solid::Cuboid(half) => point_to_cuboid(point, half),
        Solid::Capsule {
            radius,
            half_length,
        } => {
            let nearest = Vector3::new(0.0, 0.0, point.z.clamp(-half_length, *half_length));
            (point - nearest).norm() - radius
        }
    }
}

/// Distance of two segments along the z axes of their frames; a point if the length is zero.
fn segment_to_segment(half_a: f64, half_b: f64, a_from_b: &Pose) -> f64 {
    let (a, b) = (
        segment(half_a, &Pose::identity()),
        segment(half_b, a_from_b),
    );
    match closest_points_segment_segment(&ParryPose::IDENTITY, &a, &b, f64::MAX) {
        ClosestPoints::WithinMargin(on_a, on_b) => (on_a - on_b).length(),
        ClosestPoints::Intersecting => 0.0,
        ClosestPoints::Disjoint => f64::MAX,
    }
}

fn cuboid_to_segment(half: &Vector3<f64>, half_length: f64, box_from_segment: &Pose) -> f64 {
    if half_length == 0.0 {
        return point_to_cuboid(&box_from_segment.origin(), half);
    }
    let direction: Vector3<f64> = box_from_segment.rotation().column(2).into();
    let axes = Matrix3::identity();
    let crossed = (0..3).map(|i| axes.column(i).cross(&direction));
    let faces = (0..3).map(|i| axes.column(i).into_owned());
    let depth = least_overlap(&box_from_segment.origin(), faces.chain(crossed), |axis| {
        half.dot(&axis.abs()) + half_length * axis.dot(&direction).abs()
    });
    if depth > 0.0 {
        return -depth;
    }
    let cuboid = Cuboid::new(vector(half));
    let segment = segment(half_length, box_from_segment);
    // Where GJK does not converge (it then says 0), the separating axes still give a lower bound.
    distance_support_map_support_map(&ParryPose::IDENTITY, &cuboid, &segment).max(-depth)
}

fn cuboid_to_cuboid(half_a: &Vector3<f64>, half_b: &Vector3<f64>, a_from_b: &Pose) -> f64 {
    let rotation = a_from_b.rotation();
    let axes_a = Matrix3::<f64>::identity();
    let faces_a = (0..3).map(|i| axes_a.column(i).into_owned());
    let faces_b = (0..3).map(|i| rotation.column(i).into_owned());
    let edges = (0..9).map(|n| axes_a.column(n / 3).cross(&rotation.column(n % 3)));
    let depth = least_overlap(
        &a_from_b.origin(),
        faces_a.chain(faces_b).chain(edges),
        |axis| half_a.dot(&axis.abs()) + half_b.dot(&rotation.tr_mul(axis).abs()),
    );
    if depth > 0.0 {
        return -depth;
    }
    let (a, b) = (Cuboid::new(vector(half_a)), Cuboid::new(vector(half_b)));
    distance_support_map_support_map(&parry_pose(a_from_b), &a, &b).max(-depth)
}

/// Least overlap of two convex bodies over separating axes: the sum of their extents minus the distance of their
/// centres along the axis. Not positive if some axis separates them.
fn least_overlap(
    centre_to_centre: &Vector3<f64>,
    axes: impl Iterator<Item = Vector3<f64>>,
    extents: impl Fn(&Vector3<f64>) -> f64,
) -> f64 {
    // Cross products of nearly parallel edges give no axis of their own.
    axes.filter_map(|axis| axis.try_normalize(1e-9))
        .map(|axis| extents(&axis) - centre_to_centre.dot(&axis).abs())
        .fold(f64::INFINITY, f64::min)
}

fn vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn segment(half_length: f64, to_from_segment: &Pose) -> Segment {
    let end = |z| vector(&to_from_segment.act(Vector3::new(0.0, 0.0, z)));
    Segment::new(end(-half_length), end(half_length))
}

fn parry_pose(pose: &Pose) -> ParryPose {
    let [x, y, z, qx, qy, qz, qw] = pose.to_xyzquat();
    ParryPose::from_parts(Vector::new(x, y, z), Rotation::from_xyzw(qx, qy, qz, qw))
}

#[cfg(test)]
mod tests {
    use super::*;
    use spatial::Random;

    fn random_solid(random: &mut Random) -> Solid {
        let mut size = || random.uniform(0.02, 0.5);
        match size() {
            s if s < 0.2 => Solid::Capsule {
                radius: size(),
                half_length: size(),
            },
            s if s < 0.25 => Solid::Capsule {
                radius: size(),
                half_length: 0.0,
            },
            _ => Solid::Cuboid(Vector3::new(size(), size(), size())),
        }
    }

    #[test]
    fn boxes_side_by_side_and_overlapping() {
        let cube = Solid::Cuboid(Vector3::repeat(0.5));
        let at = |x, y| {
            signed_distance(
                &cube,
                &Pose::identity(),
                &cube,
                &Pose::from_translation(x, y, 0.0),
            )
        };
        assert!((at(1.2, 0.0) - 0.2).abs() < 1e-12);
        assert!((at(0.9, 0.3) + 0.1).abs() < 1e-12);
        assert!((at(1.3, 1.4) - 0.5).abs() < 1e-12);
        assert!(
            (at(0.0, 0.0) + 1.0).abs() < 1e-12,
            "one inside the other leaves by the shortest way"
        );
    }

    #[test]
    fn a_capsule_beside_a_box_and_through_it() {
        let cube = Solid::Cuboid(Vector3::repeat(0.5));
        let capsule = Solid::Capsule {
            radius: 0.1,
            half_length: 0.4,
        };
        let at = |x, z| {
            signed_distance(
                &cube,
                &Pose::identity(),
                &capsule,
                &Pose::from_translation(x, 0.0, z),
            )
        };
        assert!((at(0.7, 0.0) - 0.1).abs() < 1e-12);
        assert!((at(0.55, 0.0) + 0.05).abs() < 1e-12);
        assert!((at(0.0, 1.0) - 0.0).abs() < 1e-12);
        assert!(
            (at(0.3, 0.0) + 0.3).abs() < 1e-12,
            "core inside the box: depth of the core plus the radius"
        );
    }

    #[test]
    fn capsules_crossing_at_a_distance() {
        let capsule = Solid::Capsule {
            radius: 0.1,
            half_length: 1.0,
        };
        let lying = Pose::from_xyzquat(&[0.5, 0.0, 0.0, 0.5f64.sqrt(), 0.0, 0.0, 0.5f64.sqrt()]);
        assert!(
            (signed_distance(&capsule, &Pose::identity(), &capsule, &lying) - 0.3).abs() < 1e-12
        );
        let parallel = Pose::from_translation(0.0, 0.15, 0.4);
        assert!(
            (signed_distance(&capsule, &Pose::identity(), &capsule, &parallel) + 0.05).abs()
                < 1e-12
        );
    }

    /// Moving apart by the penetration depth along some direction must separate, by less must not.
    #[test]
    fn the_depth_is_the_shortest_way_out() {
        let mut random = Random::new(7);
        let mut overlaps = 0;
        for seed in 0..300 {
            let (a, b) = (random_solid(&mut random), random_solid(&mut random));
            let (pose_a, pose_b) = (Pose::random(seed), Pose::random(seed + 1000));
            let shifted =
                |by: Vector3<f64>| Pose::from_parts(*pose_b.rotation(), pose_b.origin() * 0.3 + by);
            let depth = -signed_distance(&a, &pose_a, &b, &shifted(Vector3::zeros()));
            if depth <= 0.0 {
                continue;
            }
            overlaps += 1;
            let mut least = f64::INFINITY;
            for _ in 0..400 {
                let way = Vector3::from_fn(|_, _| random.uniform(-1.0, 1.0)).normalize();
                assert!(signed_distance(&a, &pose_a, &b, &shifted(way * depth * 0.999)) < 0.0);
                let apart = signed_distance(&a, &pose_a, &b, &shifted(way * depth * 1.2));
                least = least.min(-apart);
            }
            assert!(least < 0.0, "seed {seed}: no way out of {depth} m");
        }
        assert!(overlaps > 50);
    }

    #[test]
    fn the_distance_does_not_depend_on_the_order_and_agrees_with_points() {
        let mut random = Random::new(3);
        for seed in 0..300 {
            let (a, b) = (random_solid(&mut random), random_solid(&mut random));
            let (pose_a, pose_b) = (Pose::random(seed), Pose::random(seed + 1000));
            let there = signed_distance(&a, &pose_a, &b, &pose_b);
            let back = signed_distance(&b, &pose_b, &a, &pose_a);
            assert!((there - back).abs() < 1e-9, "{a:?} {b:?}: {there} {back}");
            let dot = Solid::Capsule {
                radius: 1e-9,
                half_length: 0.0,
            };
            let near = signed_distance(&a, &pose_a, &dot, &pose_b);
            let point = point_to_solid(&(pose_a.inverse() * pose_b).origin(), &a);
            assert!((near - point).abs() < 1e-8, "{a:?}: {near} {point}");
        }
    }
}
