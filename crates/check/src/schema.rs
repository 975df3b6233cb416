//! Whether the plan can be evaluated: sizes, numbers, names, the robot description; kinds of contacts.

use nalgebra::Vector3;
use plan::{InterfaceKind, Plan, PlanError};
use spatial::Pose;

use crate::categories::Category;
use crate::measure::Measurements;
use crate::motion::{Interface, Motion, Owner};
use crate::robot::Robot;
use crate::urdf;

/// Judges the file and evaluates its motion, if that is possible.
pub(crate) fn judge<'a>(plan: &'a Plan, found: &mut Measurements) -> Option<Motion<'a>> {
    found.looked_at(Category::Schema);
    let mut structural = false;
    for fault in plan.faults() {
        structural |= fault.is_structural();
        // Durations, times and quaternions have categories of their own.
        if !matches!(fault, PlanError::Time { .. } | PlanError::Quaternion { .. }) {
            found.count(Category::Schema, &fault.to_string());
        }
    }
    if structural {
        return None;
    }
    let robot = match urdf::read(&plan.robot.urdf, &plan.robot.joints) {
        Ok(robot) => robot,
        Err(error) => {
            found.count(Category::Schema, &error.to_string());
            return None;
        }
    };
    let interfaces = interfaces(plan, &robot, found)?;
    contacts(plan, &interfaces, found);
    Some(Motion::new(plan, robot, interfaces))
}

fn interfaces<'a>(
    plan: &'a Plan,
    robot: &Robot,
    found: &mut Measurements,
) -> Option<Vec<Interface<'a>>> {
    let mut all = Vec::new();
    for interface in &plan.interfaces {
        let Some(owner) = owner(plan, robot, &interface.body) else {
            let (name, body) = (&interface.name, &interface.body);
            found.count(
                Category::Schema,
                &format!("interface {name:?}: no body {body:?}"),
            );
            continue;
        };
        let half = interface
            .half_size
            .unwrap_or_default()
            .map(|h| h.unwrap_or(f64::INFINITY));
        let limb = interface.limb.map_or(-Vector3::z(), Vector3::from);
        all.push(Interface {
            name: &interface.name,
            owner,
            body_from_interface: Pose::from_xyzquat(&interface.pose),
            kind: interface.kind,
            half,
            limb: limb.try_normalize(0.0).unwrap_or(-Vector3::z()),
        });
    }
    (all.len() == plan.interfaces.len()).then_some(all)
}

/// Objects come before static bodies, static bodies before links.
fn owner(plan: &Plan, robot: &Robot, body: &str) -> Option<Owner> {
    let object = plan
        .objects
        .iter()
        .position(|x| x.name == body)
        .map(Owner::Object);
    let fixed = || {
        plan.environment
            .iter()
            .position(|x| x.name == body)
            .map(Owner::Static)
    };
    object
        .or_else(fixed)
        .or_else(|| robot.link(body).map(Owner::Link))
}

fn contacts(plan: &Plan, interfaces: &[Interface], found: &mut Measurements) {
    let find = |name: &str| interfaces.iter().find(|i| i.name == name);
    for (k, phase) in plan.phases.iter().enumerate() {
        for contact in &phase.contacts {
            let (Some(a), Some(b)) = (find(&contact.a), find(&contact.b)) else {
                continue;
            };
            let place = format!("phase {k} {}/{}", contact.a, contact.b);
            let needs_patch = contact.kind.is_patch();
            if b.kind != InterfaceKind::Patch || (needs_patch && a.kind != InterfaceKind::Patch) {
                let (kind, a, b) = (contact.kind, a.kind, b.kind);
                found.count(
                    Category::Schema,
                    &format!("{place}: {kind:?} between {a:?} and {b:?}"),
                );
            }
            if contact.kind.is_unilateral() && contact.mu <= 0.0 {
                found.count(
                    Category::Schema,
                    &format!("{place}: unilateral contact with mu = {}", contact.mu),
                );
            }
            let immovable = |owner| matches!(owner, Owner::Static(_));
            if a.owner == b.owner || (immovable(a.owner) && immovable(b.owner)) {
                found.count(
                    Category::Schema,
                    &format!("{place}: the two cannot move relative to each other"),
                );
            }
        }
    }
}
