//! Contacts that transmit what they cannot.

use check::{Options, Status, check};
use plan::{ContactType, Plan};

use super::{Case, case, contact, interface, judge_all, push, static_box};
use crate::toy::{lift, stand};

/// Corruptions of contact wrenches within the dynamics.
pub(crate) fn cases() -> Vec<Case> {
    let shift = |p: &mut Plan, entry: usize, by: f64| {
        push(p, 0, "left_foot", entry, by);
        push(p, 0, "right_foot", entry, -by);
    };
    vec![
        case(
            "a foot pulls",
            "normal_force",
            &[
                "centroidal_moment",
                "unactuated_moment",
                "torque_file",
                "friction_cone",
                "cop",
            ],
            stand(),
            |p| {
                shift(p, 2, -100.0);
            },
        ),
        case(
            "a foot pushes sideways",
            "friction_cone",
            &["centroidal_moment", "unactuated_moment"],
            stand(),
            |p| shift(p, 1, 60.0),
        ),
        case(
            "a floor more slippery than planned",
            "friction_cone",
            &["mu_r"],
            stand(),
            |p| contact(p, 0, "tip").mu = 0.1,
        ),
        case(
            "pressure beyond the foot's edge",
            "cop",
            &[],
            stand(),
            |p| shift(p, 3, 5.0),
        ),
        case(
            "pressure beyond a small support",
            "cop",
            &["contact_bounds"],
            stand(),
            |p| {
                // A narrow ledge beside the middle of the box, which may overhang.
                interface(p, "table_top").half_size = Some([Some(0.01), Some(0.02)]);
                interface(p, "table_top").pose[1] += 0.03;
                contact(p, 0, "box_bottom").overhang = true;
            },
        ),
        case(
            "more torsion than friction gives",
            "torsion",
            &[],
            stand(),
            |p| shift(p, 5, 5.0),
        ),
        case(
            "a moment through a point",
            "point_moment",
            &["centroidal_moment"],
            stand(),
            |p| {
                push(p, 0, "tip", 4, 0.5);
            },
        ),
        case(
            "a moment through a ball joint",
            "point_moment",
            &[],
            lift(),
            |p| {
                for k in 0..2 {
                    contact(p, k, "palm").kind = ContactType::BilateralPoint;
                }
            },
        ),
        case(
            "an implausible torsional friction",
            "mu_r",
            &[],
            stand(),
            |p| contact(p, 0, "left_foot").mu_r = 0.2,
        ),
    ]
}

#[test]
fn contacts_that_transmit_what_they_cannot() {
    judge_all(cases());
}

#[test]
fn a_tolerance_can_be_relaxed_and_collisions_left_out() {
    let mut plan = stand();
    push(&mut plan, 0, "tip", 4, 0.05);
    static_box(&mut plan, [0.0, 0.15, 0.2], [0.02; 3]);
    let mut options = Options::default();
    assert_eq!(
        check(&plan, &options).failed().collect::<Vec<_>>(),
        ["point_moment", "collision_env"]
    );
    options.set_tolerance("point_moment", 0.1).unwrap();
    options.collisions = false;
    let report = check(&plan, &options);
    assert!(report.ok());
    assert_eq!(
        report.row("collision_env").unwrap().status,
        Status::NotApplicable
    );
}
