//! Files whose parts do not fit together.

use check::{Options, Status, check};
use plan::{Contact, InterfaceKind, Phase};

use super::{Case, case, contact, in_urdf, interface, judge_all};
use crate::toy::{lift, stand};

/// Corruptions of the file itself.
pub(crate) fn cases() -> Vec<Case> {
    vec![
        case("rows missing", "schema", &[], stand(), |p| p.q.truncate(5)),
        case(
            "a value that is not a number",
            "schema",
            &[],
            stand(),
            |p| p.tau[3][1] = f64::NAN,
        ),
        case("an unknown interface", "schema", &[], stand(), |p| {
            p.phases[0].contacts[0].a = "tail".into();
        }),
        case("an unknown body", "schema", &[], stand(), |p| {
            interface(p, "palm").body = "tail".into();
        }),
        case(
            "a joint that the URDF does not have",
            "schema",
            &[],
            stand(),
            |p| p.robot.joints[2] = "tail".into(),
        ),
        case("a broken URDF", "schema", &[], stand(), |p| {
            p.robot.urdf.truncate(900);
        }),
        case("a URDF with a loop", "schema", &[], stand(), |p| {
            in_urdf(p, "<child link=\"arm\"/>", "<child link=\"base\"/>");
        }),
        case("a patch contact on a point", "schema", &[], stand(), |p| {
            interface(p, "left_foot").kind = InterfaceKind::Point;
        }),
        case(
            "a unilateral contact without friction",
            "schema",
            &["friction_cone", "mu_r"],
            stand(),
            |p| {
                let tip = contact(p, 0, "tip");
                tip.mu = 0.0;
            },
        ),
        case(
            "a contact of a body with itself",
            "schema",
            &["contact_distance", "contact_bounds", "transitions"],
            lift(),
            |p| {
                let twin = Contact {
                    a: "box_top".into(),
                    b: "box_bottom".into(),
                    ..contact(p, 1, "palm").clone()
                };
                p.phases[1].contacts.push(Contact {
                    wrench: vec![[0.0; 6]; 40],
                    ..twin
                });
            },
        ),
        case(
            "a mass below zero",
            "schema",
            &["object_force", "object_moment"],
            stand(),
            |p| p.objects[0].mass = -1.0,
        ),
        case(
            "a phase of no steps",
            "schema",
            &["transitions"],
            stand(),
            |p| {
                let empty = Phase {
                    steps: 0,
                    contacts: Vec::new(),
                    ..p.phases[0].clone()
                };
                p.phases.insert(
                    0,
                    Phase {
                        duration: 1e-9,
                        ..empty
                    },
                );
            },
        ),
    ]
}

#[test]
fn files_that_do_not_fit_together() {
    judge_all(cases());
}

#[test]
fn a_plan_that_cannot_be_evaluated_has_no_other_rows() {
    let mut plan = stand();
    plan.v.clear();
    let report = check(&plan, &Options::default());
    assert_eq!(report.failed().collect::<Vec<_>>(), ["schema"]);
    assert!(
        report.rows[1..]
            .iter()
            .all(|row| row.status == Status::NotApplicable)
    );
    assert!(
        report.rows[0]
            .location
            .what
            .contains("v: 0 rows, expected 21"),
        "{report}"
    );
}
