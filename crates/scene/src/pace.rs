//! How long a phase may take: bounds from the robot's size, for scenes that give none.
//!
//! A robot that stands on its feet with its base at height h sways in multiples of √(h/g), its time scale as an inverted
//! pendulum; so do robots of other sizes. A phase takes 0.9 to 7.2 of them, to 50 ms: 0.25 to 2 s for a G1.

use crate::types::{Interface, Owner, Robot, Role};
use multibody::Kinematics;
use nalgebra::Vector3;
use spatial::Pose;

/// Shortest phase, in time scales.
const SHORTEST: f64 = 0.9;
/// Longest phase, in shortest ones.
const LONGEST: f64 = 8.0;
/// Bounds are multiples of this [s].
const GRAIN: f64 = 0.05;
/// Time scale of a robot without feet, or without weight [s]: that of a G1.
const OTHERWISE: f64 = 0.28;

/// Shortest and longest phase [s]; `gravity` is its amount [m/s²].
pub(crate) fn durations(robot: &Robot, interfaces: &[Interface], gravity: f64) -> (f64, f64) {
    let scale = match height(robot, interfaces) {
        Some(height) if height > 0.0 && gravity > 0.0 => (height / gravity).sqrt(),
        _ => OTHERWISE,
    };
    let shortest = (SHORTEST * scale / GRAIN).round().max(1.0) * GRAIN;
    (shortest, LONGEST * shortest)
}

/// Height of the base above the lowest foot in the home posture, with the soles down [m]; `None` without feet. The base's own axes may
/// point anywhere.
fn height(robot: &Robot, interfaces: &[Interface]) -> Option<f64> {
    let mut kinematics = Kinematics::new(&robot.model);
    let mut q = vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    q.extend(&robot.home);
    kinematics.update(&robot.model, &q);
    let sole = |interface: &Interface| match interface.owner {
        Owner::Robot { frame } if interface.role == Role::Foot => {
            let base_from_link = kinematics.frame_pose(&robot.model, frame);
            Some(base_from_link * interface.body_from_interface)
        }
        _ => None,
    };
    let soles: Vec<_> = interfaces.iter().filter_map(sole).collect();
    let down: Vector3<f64> = soles.iter().map(|sole| sole.rotate(Vector3::z())).sum();
    let down = down.try_normalize(1e-3)?;
    let below = |sole: &Pose| sole.origin().dot(&down);
    soles.iter().map(below).max_by(f64::total_cmp)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;

    #[test]
    fn bounds_grow_with_the_time_scale_of_the_pendulum() {
        let scene = Scene::builtin("pick-place").expect("a built-in scene");
        let bounds = |gravity| durations(&scene.robot, &scene.interfaces, gravity);
        let (shortest, longest) = bounds(9.81);
        assert!((shortest - 0.25).abs() < 1e-12 && (longest - 2.0).abs() < 1e-12);
        let (on_moon, _) = bounds(9.81 / 9.0);
        assert!((on_moon - 0.75).abs() <= GRAIN + 1e-12, "{on_moon}");
        // A base that is built on its side.
        let mut other = scene.robot.clone();
        let turn = Pose::from_xyzquat(&[0.0, 0.0, 0.0, 0.5, 0.5, 0.5, 0.5]);
        for joint in &mut other.model.joints {
            if joint.parent == Some(0) {
                joint.parent_from_joint = turn * joint.parent_from_joint;
            }
        }
        assert_eq!(
            durations(&other, &scene.interfaces, 9.81),
            (shortest, longest)
        );
        let (without_feet, _) = durations(&scene.robot, &[], 9.81);
        assert!((without_feet - 0.25).abs() < 1e-12);
    }
}
