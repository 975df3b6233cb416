//! Dynamics that do not add up.

use check::{Options, Status, check};
use plan::Plan;

use super::{Case, FORCES, case, column, contact, in_urdf, judge, judge_all, push};
use crate::toy::{Recipe, lift, lift_by, stand};

/// Corruptions of the robot's dynamics.
pub(crate) fn cases() -> Vec<Case> {
    vec![
        case("h wrong", "momentum_file", &[], lift(), |p| {
            p.h[12][2] += 0.5;
        }),
        case(
            "a foot pushes 10 N too little",
            "centroidal_force",
            FORCES,
            stand(),
            |p| push(p, 0, "left_foot", 2, -10.0),
        ),
        case(
            "the palm's force forgotten",
            "centroidal_force",
            FORCES,
            lift(),
            |p| {
                contact(p, 1, "palm").wrench.fill([0.0; 6]);
            },
        ),
        case(
            "another gravity",
            "centroidal_force",
            FORCES,
            stand(),
            |p| p.gravity[2] = -9.0,
        ),
        case(
            "a foot's moment too large",
            "centroidal_moment",
            FORCES,
            stand(),
            |p| push(p, 0, "left_foot", 5, 1.2),
        ),
        case(
            "a foot pushes 60 N too little",
            "unactuated_force",
            FORCES,
            stand(),
            |p| {
                push(p, 0, "left_foot", 2, -30.0);
                push(p, 0, "right_foot", 2, -30.0);
            },
        ),
        case(
            "a base moment",
            "unactuated_moment",
            &["centroidal_moment", "cop"],
            stand(),
            |p| push(p, 0, "left_foot", 4, 20.0),
        ),
        case(
            "a link heavier than planned",
            "centroidal_force",
            FORCES,
            stand(),
            |p| {
                in_urdf(p, "<mass value=\"10\"/>", "<mass value=\"12\"/>");
            },
        ),
        case(
            "a link's inertia wrong",
            "torque_file",
            &["centroidal_moment", "momentum_file"],
            lift(),
            |p| {
                in_urdf(p, "iyy=\"0.008\"", "iyy=\"0.2\"");
            },
        ),
        case("tau wrong", "torque_file", &[], stand(), |p| {
            p.tau[3][2] += 1.0;
        }),
        case(
            "two joints exchanged",
            "torque_file",
            &[
                "momentum_file",
                "centroidal_force",
                "centroidal_moment",
                "contact_velocity",
                "node_velocity",
                "slip_phase",
                "contact_alignment",
                "contact_distance",
                "slip_contact",
                "object_moment",
                "contact_overlap",
                "unactuated_force",
                "unactuated_moment",
                "contact_bounds",
            ],
            lift(),
            |p| p.robot.joints.swap(2, 3),
        ),
        case("a motor too weak", "torque_limit", &[], stand(), |p| {
            in_urdf(p, "effort=\"30\"", "effort=\"2\"");
        }),
    ]
}

/// Corruptions of torque at speed.
pub(crate) fn speed_cases() -> Vec<Case> {
    vec![case(
        "a motor too weak at speed",
        "torque_speed",
        &[],
        lift(),
        |p| {
            slow_motors(p, 1e-3, 2e-3);
        },
    )]
}

/// Lets all torques fall with speed.
fn slow_motors(plan: &mut Plan, corner: f64, max: f64) {
    let line = plan::TorqueSpeed { corner, max };
    let joints = plan.robot.joints.iter();
    plan.robot.torque_speed = joints.map(|joint| (joint.clone(), line)).collect();
}

#[test]
fn torque_at_speed_is_judged_where_it_is_declared_and_enforced() {
    let verdict = |plan: &Plan| {
        check(plan, &Options::default())
            .row("torque_speed")
            .unwrap()
            .status
    };
    let mut plan = lift();
    assert_eq!(verdict(&plan), Status::NotApplicable);
    slow_motors(&mut plan, 50.0, 60.0);
    assert_eq!(verdict(&plan), Status::Pass);
    slow_motors(&mut plan, 1e-3, 2e-3);
    assert_eq!(verdict(&plan), Status::Fail);
    plan.robot.torque_limits.as_mut().unwrap().fill(None);
    assert_eq!(verdict(&plan), Status::NotApplicable);
}

#[test]
fn dynamics_that_do_not_add_up() {
    judge_all(cases());
    judge_all(speed_cases());
}

#[test]
fn base_rows_are_judged_when_the_plan_names_them() {
    let recipe = Recipe {
        dynamics: plan::Dynamics::BaseRows,
        travel: [0.08, -0.25, 0.15],
        ..Recipe::default()
    };
    judge(&case(
        "a foot pushes 2 N too little",
        "unactuated_force",
        FORCES,
        lift_by(recipe),
        |p| {
            push(p, 1, "left_foot", 2, -1.0);
            push(p, 1, "right_foot", 2, -1.0);
        },
    ));
    // The same plan under the other name is off by more than `accept` allows, from the time step alone.
    let mut plan = lift_by(Recipe {
        travel: [0.1, -0.5, 0.4],
        ..recipe
    });
    assert!(check(&plan, &Options::accept()).ok());
    plan.dynamics = plan::Dynamics::Momentum;
    assert!(
        check(&plan, &Options::accept())
            .failed()
            .any(|name| name == "centroidal_force")
    );
}

#[test]
fn a_torque_limit_that_is_declared_as_not_enforced_is_not() {
    let mut plan = stand();
    in_urdf(&mut plan, "effort=\"30\"", "effort=\"2\"");
    let shoulder = column(&plan, "shoulder");
    plan.robot.torque_limits.as_mut().unwrap()[shoulder] = None;
    assert!(check(&plan, &Options::default()).ok());
}

/// Corruptions of the objects' dynamics.
pub(crate) fn object_cases() -> Vec<Case> {
    vec![
        case("a heavier object", "object_force", &[], lift(), |p| {
            p.objects[0].mass = 2.0;
        }),
        case(
            "an object's wrench with the wrong sign",
            "object_force",
            FORCES,
            lift(),
            |p| {
                contact(p, 1, "palm")
                    .wrench
                    .iter_mut()
                    .flatten()
                    .for_each(|x| *x = -*x);
            },
        ),
        case("another inertia", "object_moment", &[], lift(), |p| {
            p.objects[0].inertia = [0.5, 0.5, 0.5, 0.0, 0.0, 0.0];
        }),
        case(
            "a moment about the wrong point",
            "object_moment",
            &[],
            stand(),
            |p| push(p, 0, "box_bottom", 3, 0.2),
        ),
        case(
            "a box that hangs in the air",
            "object_force",
            &[],
            stand(),
            |p| {
                p.phases[0].contacts.retain(|c| c.a != "box_bottom");
                p.goal.clear();
            },
        ),
    ]
}

#[test]
fn objects_that_do_not_obey_newton_and_euler() {
    judge_all(object_cases());
}
