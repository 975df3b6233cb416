//! The posture that a file names for its robot.

use crate::robot::{Robot, is_hinge_or_slide};
use mjcf_rs::Model;
use mjcf_rs::body::JointType;

/// Names of keyframes that are a nominal stand.
const NAMES: [&str; 3] = ["home", "stand", "standing"];

/// Positions of the robot's joints in the keyframe of such a name, or the first one. None if the keyframe is not of this model.
pub fn home(model: &Model, robot: &Robot) -> Vec<(String, f64)> {
    let named = |name: &str| {
        let mut keys = model.keyframes.iter();
        keys.find(|key| key.name.as_deref() == Some(name))
    };
    let key = NAMES.iter().find_map(|name| named(name));
    let Some(key) = key.or(model.keyframes.first()) else {
        return vec![];
    };
    let (mut home, mut at) = (vec![], 0);
    let of_robot = robot.bodies();
    for body in robot.bodies_from(0) {
        for (index, joint) in model.bodies[body].body.joints.iter().enumerate() {
            if let (true, true, Some(&position)) = (
                of_robot.contains(&body),
                is_hinge_or_slide(joint),
                key.qpos.get(at),
            ) {
                home.push((robot.joint_name(body, index, joint), position));
            }
            at += match joint.type_ {
                JointType::Free => 7,
                JointType::Ball => 4,
                JointType::Hinge | JointType::Slide => 1,
            };
        }
    }
    if at == key.qpos.len() { home } else { vec![] }
}
