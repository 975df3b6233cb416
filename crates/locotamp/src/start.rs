//! The start must not be in collision.

use crate::api::Error;
use crate::summary;
use ocp::Planner;
use scene::Scene;

/// Overlap of bodies at the start that is tolerated [m]: less than the collision model's own accuracy.
const START_OVERLAP: f64 = 0.005;

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
