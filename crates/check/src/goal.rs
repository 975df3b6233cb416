//! Whether the goal is reached: contacts that the last phase lists, places at the last node.

use nalgebra::Vector3;
use plan::GoalRegion;
use spatial::Pose;

use crate::categories::Category;
use crate::measure::Measurements;
use crate::motion::Motion;

/// Judges goal contacts and goal regions.
pub(crate) fn judge(motion: &Motion, found: &mut Measurements) {
    let plan = motion.plan;
    for goal in &plan.goal {
        found.looked_at(Category::Goal);
        let held = plan
            .phases
            .last()
            .into_iter()
            .flat_map(|phase| &phase.contacts)
            .any(|contact| {
                let (a, b) = (&contact.a, &contact.b);
                (a, b) == (&goal.a, &goal.b) || (a, b) == (&goal.b, &goal.a)
            });
        if !held {
            found.count(Category::Goal, &format!("{}/{}", goal.a, goal.b));
        }
    }
    for region in &plan.goal_regions {
        let pose = last_pose(motion, &region.body);
        let place = || motion.place(motion.n_intervals(), &region.body);
        let distance = pose.map_or(f64::INFINITY, |pose| beyond(region, &pose.origin()));
        found.add(Category::GoalRegion, distance, place);
        if region.yaw.is_some() || region.tilt.is_some() {
            let angle = pose.map_or(f64::INFINITY, |pose| turned_beyond(region, pose));
            found.add(Category::GoalOrientation, angle.to_degrees(), place);
        }
    }
}

/// Pose of an object, interface or link at the last node, in the world: of a link and an interface of one name the interface.
fn last_pose<'m>(motion: &'m Motion, body: &str) -> Option<&'m Pose> {
    let last = motion.n_intervals();
    let object = motion
        .plan
        .objects
        .iter()
        .position(|x| x.name == body)
        .map(|o| &motion.objects[last][o]);
    let link = || motion.robot.link(body).map(|i| &motion.links[last][i]);
    let interface = || {
        motion
            .interfaces
            .iter()
            .position(|x| x.name == body)
            .map(|i| &motion.frames[last][i])
    };
    object
        .or_else(interface)
        .or_else(link)
        .map(|frame| &frame.world_from_frame)
}

/// How far a body is turned out of its goal, by heading or tilt, whichever is more [rad].
fn turned_beyond(region: &GoalRegion, world_from_body: &Pose) -> f64 {
    let rotation = world_from_body.rotation();
    let heading = region.yaw.map_or(0.0, |[least, greatest]| {
        let yaw = rotation[(1, 0)].atan2(rotation[(0, 0)]);
        let from_middle = yaw - f64::midpoint(least, greatest);
        let (sin, cos) = from_middle.sin_cos();
        sin.atan2(cos).abs() - (greatest - least) / 2.0
    });
    let tilt = region.tilt.map_or(0.0, |greatest| {
        rotation[(0, 2)]
            .hypot(rotation[(1, 2)])
            .atan2(rotation[(2, 2)])
            - greatest
    });
    heading.max(tilt).max(0.0)
}

/// How far a position is outside a region along the worst axis [m].
fn beyond(region: &GoalRegion, position: &Vector3<f64>) -> f64 {
    let axis = |i: usize| {
        let below = region.lower[i].map_or(0.0, |lower| lower - position[i]);
        let above = region.upper[i].map_or(0.0, |upper| position[i] - upper);
        below.max(above).max(0.0)
    };
    (0..3).map(axis).fold(0.0, f64::max)
}
