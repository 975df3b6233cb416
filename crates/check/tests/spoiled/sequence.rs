//! Goals that are missed and sequences that are not legal.

use check::{Options, check};
use plan::{Contact, ContactType, GoalRegion};

use super::{Case, case, contact, judge_all};
use crate::toy::{lift, stand};

/// The box is at least at this height.
fn region(lower: f64) -> GoalRegion {
    GoalRegion {
        body: "box".into(),
        lower: [None, None, Some(lower)],
        upper: [Some(5.0), None, None],
        yaw: None,
        tilt: None,
        extra: plan::Extra::new(),
    }
}

/// The box has this heading and tilt.
fn turned(yaw: Option<[f64; 2]>, tilt: Option<f64>) -> GoalRegion {
    GoalRegion {
        lower: [None; 3],
        upper: [None; 3],
        yaw,
        tilt,
        ..region(0.0)
    }
}

/// Corruptions of the goal.
pub(crate) fn goal_cases() -> Vec<Case> {
    vec![
        case("a goal contact not held", "goal", &[], lift(), |p| {
            p.goal[0].b = "table_top".into();
        }),
        case("a goal region missed", "goal_region", &[], lift(), |p| {
            p.goal_regions.push(region(1.2));
        }),
        case(
            "a goal heading missed",
            "goal_orientation",
            &[],
            lift(),
            |p| {
                p.goal_regions.push(turned(Some([1.0, 2.0]), None));
            },
        ),
        case("a goal tilt missed", "goal_orientation", &[], lift(), |p| {
            p.goal_regions.push(GoalRegion {
                body: "left_foot".into(),
                ..turned(None, Some(0.2))
            });
        }),
    ]
}

#[test]
fn goals_that_are_missed() {
    judge_all(goal_cases());
    let mut reached = lift();
    reached.goal_regions.push(region(0.6));
    assert_eq!(
        check(&reached, &Options::default())
            .row("goal_region")
            .unwrap()
            .value,
        Some(0.0)
    );
    // At the end the box has pitched by 0.1 rad.
    let orientation = |yaw: [f64; 2], tilt: f64| {
        let mut plan = lift();
        plan.goal_regions.push(turned(Some(yaw), Some(tilt)));
        let report = check(&plan, &Options::default());
        report
            .row("goal_orientation")
            .unwrap()
            .value
            .unwrap()
            .to_radians()
    };
    assert_eq!(orientation([-0.1, 0.1], 0.11), 0.0);
    assert_eq!(orientation([6.2, 6.4], 0.11), 0.0, "a full turn further");
    assert!((orientation([0.2, 0.3], 0.11) - 0.2).abs() < 1e-9);
    assert!((orientation([-0.1, 0.1], 0.07) - 0.03).abs() < 1e-3);
}

/// Corruptions of the contact sequence.
pub(crate) fn transition_cases() -> Vec<Case> {
    let contact_rows = &[
        "contact_distance",
        "contact_bounds",
        "contact_alignment",
        "contact_velocity",
        "contact_spin",
        "node_velocity",
        "slip_phase",
        "slip_contact",
        "slip_yaw_phase",
        "touchdown",
        "end_velocity",
    ];
    vec![
        case(
            "a partner changed without a free phase",
            "transitions",
            contact_rows,
            lift(),
            |p| {
                let twin = Contact {
                    b: "shelf_top".into(),
                    ..contact(p, 0, "box_bottom").clone()
                };
                p.phases[1].contacts.push(Contact {
                    wrench: vec![[0.0; 6]; 40],
                    ..twin
                });
            },
        ),
        case(
            "one surface in two contacts",
            "transitions",
            contact_rows,
            stand(),
            |p| {
                let twin = Contact {
                    b: "ground_top".into(),
                    ..contact(p, 0, "tip").clone()
                };
                p.phases[0].contacts.push(Contact {
                    wrench: vec![[0.0; 6]; 20],
                    ..twin
                });
            },
        ),
        case(
            "a pair listed both ways",
            "transitions",
            contact_rows,
            lift(),
            |p| {
                let twin = Contact {
                    a: "box_top".into(),
                    b: "palm".into(),
                    ..contact(p, 1, "palm").clone()
                };
                p.phases[1].contacts.push(Contact {
                    wrench: vec![[0.0; 6]; 40],
                    ..twin
                });
            },
        ),
        case(
            "a contact that changes its type",
            "transitions",
            &["point_moment"],
            lift(),
            |p| {
                contact(p, 1, "palm").kind = ContactType::BilateralPoint;
            },
        ),
    ]
}

#[test]
fn sequences_that_are_not_legal() {
    judge_all(transition_cases());
}
