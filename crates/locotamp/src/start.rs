//! The start must not be in collision, nor should the home posture.

use crate::api::Error;
use crate::summary;
use ocp::Planner;
use scene::Scene;

/// Overlap of bodies at the start that is tolerated [m]: less than the collision model's own accuracy.
const START_OVERLAP: f64 = 0.005;

/// Says which links overlap in the robot's home posture: plans may leave them so, which checkers and simulators may not like.
///
/// # Errors
/// If the robot has no model.
pub fn home_note(scene: &Scene) -> Result<Option<String>, Error> {
    let planner = Planner::new(scene)?;
    let overlaps = planner.collisions.overlaps_at_home();
    let mut deep = overlaps.iter().filter(|(depth, ..)| *depth > START_OVERLAP);
    let Some(&(depth, a, b)) = deep.next() else {
        return Ok(None);
    };
    let [a, b] = [a, b].map(|joint| summary::body_name(scene, &planner.system, Ok(joint)));
    let more = match deep.count() {
        0 => String::new(),
        1 => ", one more pair of links too".into(),
        n => format!(", {n} more pairs of links too"),
    };
    Ok(Some(format!(
        "in the home posture {a} is {:.0} mm inside {b}{more}: plans keep them from getting deeper, no more than that; [home] of the \
         robot file changes it",
        1e3 * depth
    )))
}

/// Refuses a start in which bodies that do not touch overlap.
pub(crate) fn check_start(scene: &Scene, planner: &Planner<'_>) -> Result<(), Error> {
    let model = &planner.system.model;
    let mut kinematics = multibody::Kinematics::new(model);
    kinematics.update(model, &planner.system.start(scene));
    let touches = ocp::collision::CollisionModel::start_touches(scene, &planner.system);
    let deepest = planner
        .collisions
        .deepest(&kinematics, &|a, b| touches.contains(&(a, b)));
    match deepest {
        Some((depth, a, b)) if depth > START_OVERLAP => Err(Error::StartInCollision {
            a: summary::body_name(scene, &planner.system, Ok(a)),
            b: summary::body_name(scene, &planner.system, b),
            depth_mm: depth * 1e3,
        }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_that_overlap_in_the_home_posture_are_told() {
        let mut scene = Scene::builtin("pick-place").unwrap();
        assert_eq!(home_note(&scene).unwrap(), None);
        let mut joints = scene.robot.model.joints.iter();
        let roll = joints
            .position(|j| j.name == "left_shoulder_roll_joint")
            .unwrap();
        scene.robot.home[roll] = -0.6;
        let note = home_note(&scene).unwrap().expect("the arm is in the trunk");
        assert!(
            note.contains("mm inside") && note.contains("[home]"),
            "{note}"
        );
    }
}
