//! An independent judge of plan files.
//!
//! Recomputes every constraint of the paper from `q`, `v`, `a`, wrenches, object states and durations of a plan
//! (`docs/plan-format.md`) and reports, per category, the largest residual, where and when it occurs, and whether
//! it is within tolerance.
//!
//! The crate shares nothing with the planner but `spatial` (poses) and `plan` (the file). The dynamics are derived
//! another way than the planner's recursive algorithms: every link has its own world pose, velocity and
//! acceleration, by differentiating the chain; Newton's and Euler's equations of the single bodies are then
//! projected by virtual power (Kane). Momentum is the plain sum over the bodies.
//!
//! Frames: all intermediate quantities are in world axes unless their name says otherwise.

#![allow(
    rustdoc::broken_intra_doc_links,
    reason = "units stand in square brackets"
)]
#![allow(
    clippy::struct_field_names,
    reason = "poses are named <to>_from_<of>, whatever carries them"
)]

mod categories;
mod collisions;
mod cones;
mod contact_geometry;
mod distance;
mod dynamics;
mod goal;
mod integration;
mod interfaces;
mod kinematics;
mod limits;
mod margins;
mod measure;
mod motion;
mod objects;
mod options;
#[cfg(test)]
mod random_robot;
mod report;
mod robot;
mod schema;
mod shapes;
mod sticking;
mod transitions;
mod urdf;

pub use categories::Level;
pub use margins::Margin;
pub use options::{Options, OptionsError, Profile};
pub use report::{Location, Report, Row, Series, Status};

use measure::Measurements;
use motion::Motion;
use plan::Plan;

/// Judges a plan. Never fails: a plan that cannot be evaluated fails the category `schema`, and the rows that need
/// the evaluation are not applicable.
pub fn check(plan: &Plan, options: &Options) -> Report {
    judge(plan, options, &mut Measurements::default())
}

/// Judges a plan like [`check`] and tells the residuals at every node, for charts.
pub fn check_over_time(plan: &Plan, options: &Options) -> (Report, Vec<Series>) {
    let mut found = Measurements::by_node();
    let report = judge(plan, options, &mut found);
    let series = report::series(&report, &found, plan.time.len());
    (report, series)
}

fn judge(plan: &Plan, options: &Options, found: &mut Measurements) -> Report {
    let motion = schema::judge(plan, found);
    let mut margins = Vec::new();
    if let Some(motion) = motion {
        judge_motion(&motion, options, found);
        margins = margins::used(&motion);
    }
    report::assemble(plan, options, found, margins)
}

fn judge_motion(motion: &Motion, options: &Options, found: &mut Measurements) {
    integration::judge(motion, found);
    limits::judge(motion, found);
    dynamics::judge(motion, found);
    objects::judge(motion, found);
    contact_geometry::judge(motion, found);
    sticking::judge(motion, found);
    let bounds_tolerance =
        options.tolerance(motion.plan.dynamics, categories::Category::ContactBounds);
    cones::judge(motion, bounds_tolerance, found);
    goal::judge(motion, found);
    transitions::judge(motion, found);
    interfaces::judge(motion, found);
    if options.collisions {
        collisions::judge(motion, options.substeps, found);
    }
}
