//! Contacts that slide.

use plan::{Contact, ContactType, Plan};

use super::{Case, box_states, case, judge_all};
use crate::toy::{lift, stand};

/// Corruptions that make contacts slide or spin.
#[allow(clippy::too_many_lines, reason = "a table")]
pub(crate) fn cases() -> Vec<Case> {
    let creep = |p: &mut Plan| {
        p.q.iter_mut()
            .enumerate()
            .for_each(|(t, q)| q[1] += 4e-4 * t as f64);
    };
    let slide_rates = |p: &mut Plan| p.v.iter_mut().for_each(|v| v[1] += 0.04);
    let rates = &[
        "integration_q",
        "momentum_file",
        "end_velocity",
        "contact_velocity",
        "node_velocity",
    ];
    vec![
        case(
            "the feet slide",
            "contact_velocity",
            &[
                "node_velocity",
                "end_velocity",
                "momentum_file",
                "slip_phase",
                "slip_contact",
                "centroidal_moment",
                "unactuated_moment",
            ],
            stand(),
            |p| {
                creep(p);
                slide_rates(p);
            },
        ),
        case(
            "the feet creep, in poses only",
            "slip_phase",
            &["integration_q", "slip_contact", "centroidal_moment"],
            stand(),
            creep,
        ),
        case(
            "the feet creep over the whole contact",
            "slip_contact",
            &[
                "integration_q",
                "slip_phase",
                "centroidal_moment",
                "unactuated_moment",
                "torque_file",
                "object_moment",
            ],
            lift(),
            creep,
        ),
        case(
            "velocities without motion",
            "node_velocity",
            rates,
            stand(),
            slide_rates,
        ),
        case(
            "velocities without motion",
            "integration_q",
            rates,
            stand(),
            slide_rates,
        ),
        case(
            "still moving at the end",
            "end_velocity",
            &["integration_v", "momentum_file", "centroidal_force"],
            stand(),
            |p| {
                p.v.last_mut().unwrap()[0] += 0.02;
            },
        ),
        case(
            "the box turns on the table",
            "contact_spin",
            &["slip_yaw_phase", "collision_obj"],
            stand(),
            |p| {
                for (t, pose) in box_states(p).pose.iter_mut().enumerate() {
                    (pose[5], pose[6]) = ((0.001 * t as f64).sin(), (0.001 * t as f64).cos());
                }
                box_states(p)
                    .twist
                    .iter_mut()
                    .for_each(|twist| twist[5] = 0.2);
            },
        ),
        case(
            "the box turns, in poses only",
            "slip_yaw_phase",
            &["integration_obj_q"],
            stand(),
            |p| {
                for (t, pose) in box_states(p).pose.iter_mut().enumerate() {
                    (pose[5], pose[6]) = ((0.001 * t as f64).sin(), (0.001 * t as f64).cos());
                }
            },
        ),
        case(
            "the box slides on the table",
            "contact_velocity",
            &[
                "node_velocity",
                "end_velocity",
                "slip_phase",
                "slip_contact",
            ],
            stand(),
            |p| {
                for (t, pose) in box_states(p).pose.iter_mut().enumerate() {
                    pose[1] += 4e-4 * t as f64;
                }
                box_states(p)
                    .twist
                    .iter_mut()
                    .for_each(|twist| twist[1] = 0.04);
            },
        ),
        case(
            "a contact that starts in motion",
            "touchdown",
            &[
                "contact_distance",
                "contact_velocity",
                "contact_bounds",
                "node_velocity",
                "slip_phase",
                "slip_contact",
            ],
            lift(),
            |p| {
                let second = split_last_phase(p);
                p.phases[second].contacts.push(Contact {
                    a: "tip".into(),
                    b: "shelf_top".into(),
                    kind: ContactType::UnilateralPoint,
                    mu: 0.5,
                    mu_r: 0.0,
                    overhang: false,
                    wrench: vec![[0.0; 6]; 20],
                    extra: plan::Extra::new(),
                });
            },
        ),
    ]
}

#[test]
fn contacts_that_slide() {
    judge_all(cases());
}

/// Cuts the last phase of `lift` in two halves of 20 steps; returns the index of the second.
fn split_last_phase(plan: &mut Plan) -> usize {
    let mut second = plan.phases[1].clone();
    let first = &mut plan.phases[1];
    for (phase, range) in [(first, 0..20), (&mut second, 20..40)] {
        phase.steps = 20;
        phase.duration = 0.2;
        for c in &mut phase.contacts {
            c.wrench = c.wrench[range.clone()].to_vec();
        }
    }
    plan.phases.push(second);
    2
}
