//! Poses and vectors of the parser as ours.

use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use spatial::Pose;

/// A vector.
pub fn vector(v: [f64; 3]) -> Vector3<f64> {
    Vector3::from(v)
}

/// The pose; MuJoCo normalises quaternions, and so does this.
pub fn pose(p: &mjcf_rs::Pose) -> Pose {
    let (r, t) = (p.rotation, p.translation);
    let rotation = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(r.w, r.x, r.y, r.z));
    Pose::from_parts(
        *rotation.to_rotation_matrix().matrix(),
        Vector3::new(t.x, t.y, t.z),
    )
}

/// A translation.
pub fn shift(by: Vector3<f64>) -> Pose {
    Pose::from_translation(by.x, by.y, by.z)
}

/// A turn by an angle [rad] about an axis of any length.
pub fn turn(axis: Vector3<f64>, angle: f64) -> Pose {
    let axis = nalgebra::Unit::new_normalize(axis);
    Pose::from_parts(
        *Rotation3::from_axis_angle(&axis, angle).matrix(),
        Vector3::zeros(),
    )
}

/// A frame with its origin half-way between two points and its z axis from the first to the second, and half their distance.
pub fn between(ends: [f64; 6]) -> (Pose, f64) {
    let [from, to] = [0, 3].map(|i| Vector3::new(ends[i], ends[i + 1], ends[i + 2]));
    let along = to - from;
    let rotation = Rotation3::rotation_between(&Vector3::z(), &along)
        .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    (
        Pose::from_parts(*rotation.matrix(), (from + to) * 0.5),
        0.5 * along.norm(),
    )
}
