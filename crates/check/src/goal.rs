//! Whether the goal is reached: contacts that the last phase lists, places at the last node.

use nalgebra::Vector3;
use plan::GoalRegion;

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
        let beyond = match last_position(motion, &region.body) {
            Some(position) => beyond(region, &position),
            None => f64::INFINITY,
        };
        found.add(Category::GoalRegion, beyond, || {
            motion.place(motion.n_intervals(), &region.body)
        });
    }
}

/// Position of an object, link or interface at the last node, world [m].
fn last_position(motion: &Motion, body: &str) -> Option<Vector3<f64>> {
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
        .or_else(link)
        .or_else(interface)
        .map(|frame| frame.world_from_frame.origin())
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
