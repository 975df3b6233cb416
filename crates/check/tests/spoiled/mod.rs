//! Spoiled plans are rejected, each for the named reason and no others than follow from it.

mod contacts;
mod dynamics;
mod files;
mod forces;
mod scene;
mod sequence;
mod sliding;
mod states;

use std::collections::BTreeSet;

use check::{Options, Status, check};
use plan::{Contact, Geometry, Plan, StaticBody};

/// A corruption: what it is, the category that must reject it, others that may, the plan, the change.
pub(crate) struct Case {
    what: &'static str,
    category: &'static str,
    also: &'static [&'static str],
    plan: Plan,
}

pub(crate) fn case(
    what: &'static str,
    category: &'static str,
    also: &'static [&'static str],
    mut plan: Plan,
    corrupt: impl FnOnce(&mut Plan),
) -> Case {
    corrupt(&mut plan);
    Case {
        what,
        category,
        also,
        plan,
    }
}

/// Categories that a wrong force on the robot upsets.
pub(crate) const FORCES: &[&str] = &[
    "centroidal_force",
    "centroidal_moment",
    "unactuated_force",
    "unactuated_moment",
    "torque_file",
    "object_force",
];

pub(crate) fn judge(case: &Case) {
    let mut options = Options {
        strict: true,
        ..Options::default()
    };
    options.set_tolerance("not_checked", 1.0).unwrap();
    let report = check(&case.plan, &options);
    let failed: Vec<_> = report.failed().collect();
    let Case {
        what,
        category,
        also,
        ..
    } = case;
    assert!(
        failed.contains(category),
        "{what}: {category} does not fail\n{report}"
    );
    let strangers: Vec<_> = failed
        .iter()
        .filter(|name| *name != category && !also.contains(name))
        .collect();
    assert!(
        strangers.is_empty(),
        "{what}: {strangers:?} fail too\n{report}"
    );
    assert_eq!(report.row(category).unwrap().status, Status::Fail);
}

pub(crate) fn judge_all(cases: impl IntoIterator<Item = Case>) {
    for case in cases {
        judge(&case);
    }
}

pub(crate) fn contact<'a>(plan: &'a mut Plan, k: usize, a: &str) -> &'a mut Contact {
    plan.phases[k]
        .contacts
        .iter_mut()
        .find(|c| c.a == a)
        .expect("the contact is listed")
}

pub(crate) fn interface<'a>(plan: &'a mut Plan, name: &str) -> &'a mut plan::Interface {
    plan.interfaces
        .iter_mut()
        .find(|i| i.name == name)
        .expect("the interface is there")
}

pub(crate) fn push(plan: &mut Plan, k: usize, a: &str, entry: usize, by: f64) {
    contact(plan, k, a)
        .wrench
        .iter_mut()
        .for_each(|row| row[entry] += by);
}

pub(crate) fn box_states(plan: &mut Plan) -> &mut plan::ObjectStates {
    plan.object_states
        .get_mut("box")
        .expect("the box has states")
}

pub(crate) fn static_box(plan: &mut Plan, centre: [f64; 3], half: [f64; 3]) {
    let [x, y, z] = centre;
    let geometry = vec![Geometry::cuboid(half, [x, y, z, 0.0, 0.0, 0.0, 1.0])];
    plan.environment.push(StaticBody {
        name: "wall".into(),
        geometry,
        extra: plan::Extra::new(),
    });
}

pub(crate) fn column(plan: &Plan, joint: &str) -> usize {
    plan.robot
        .joints
        .iter()
        .position(|name| name == joint)
        .expect("the joint is listed")
}

pub(crate) fn in_urdf(plan: &mut Plan, from: &str, to: &str) {
    assert!(plan.robot.urdf.contains(from), "{from}");
    plan.robot.urdf = plan.robot.urdf.replacen(from, to, 1);
}

fn all_cases() -> Vec<Case> {
    let groups = [
        files::cases(),
        states::cases(),
        dynamics::cases(),
        dynamics::speed_cases(),
        dynamics::object_cases(),
        contacts::cases(),
        sliding::cases(),
        forces::cases(),
        sequence::goal_cases(),
        sequence::transition_cases(),
        scene::cases(),
    ];
    groups.into_iter().flatten().collect()
}

#[test]
fn every_category_rejects_some_plan() {
    let report = check(&crate::toy::stand(), &Options::default());
    let all: BTreeSet<_> = report.rows.iter().map(|row| row.category).collect();
    let covered: BTreeSet<_> = all_cases().iter().map(|case| case.category).collect();
    let missing: Vec<_> = all.difference(&covered).collect();
    assert!(missing.is_empty(), "{missing:?}");
    assert!(all_cases().len() >= 70, "{}", all_cases().len());
}
