//! How long a phase may take: bounds from the robot's size, for scenes that give none.
//!
//! A robot that stands on its feet with its base at height h sways in multiples of √(h/g), its time scale as an inverted
//! pendulum; so do robots of other sizes. A phase takes 0.9 to 7.2 of them, to 50 ms: 0.25 to 2 s for a G1.

use crate::types::{Interface, Owner, Robot, Role};
use multibody::Kinematics;

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

/// Height of the base above the lowest foot in the home posture [m]; `None` without feet.
fn height(robot: &Robot, interfaces: &[Interface]) -> Option<f64> {
    let mut kinematics = Kinematics::new(&robot.model);
    let mut q = vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    q.extend(&robot.home);
    kinematics.update(&robot.model, &q);
    let foot = |interface: &Interface| match interface.owner {
        Owner::Robot { frame } if interface.role == Role::Foot => {
            let world_from_link = kinematics.frame_pose(&robot.model, frame);
            Some((world_from_link * interface.body_from_interface).origin().z)
        }
        _ => None,
    };
    interfaces
        .iter()
        .filter_map(foot)
        .min_by(f64::total_cmp)
        .map(|lowest| -lowest)
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
        let (without_feet, _) = durations(&scene.robot, &[], 9.81);
        assert!((without_feet - 0.25).abs() < 1e-12);
    }
}
