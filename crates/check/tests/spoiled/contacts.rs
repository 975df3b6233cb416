//! Contacts that are not where they should be.

use check::{Options, check};
use plan::Plan;

use super::{Case, box_states, case, contact, interface, judge_all};
use crate::toy::stand;

/// Corruptions of contact geometry.
pub(crate) fn cases() -> Vec<Case> {
    let raise = |p: &mut Plan, by: f64| p.q.iter_mut().for_each(|q| q[2] += by);
    vec![
        case(
            "the robot floats 3 cm",
            "contact_distance",
            &[],
            stand(),
            |p| raise(p, 0.03),
        ),
        case(
            "the box lies askew on the table",
            "contact_alignment",
            &["object_moment", "collision_obj", "collision_scene"],
            stand(),
            |p| {
                for pose in &mut box_states(p).pose {
                    (pose[3], pose[6]) = (0.01_f64.sin(), 0.01_f64.cos());
                }
            },
        ),
        case(
            "the stick comes from below the shelf",
            "halfspace",
            &["normal_force", "friction_cone"],
            stand(),
            |p| {
                interface(p, "shelf_top").pose[3..].copy_from_slice(&[1.0, 0.0, 0.0, 0.0]);
            },
        ),
        case("a shelf too small", "contact_bounds", &[], stand(), |p| {
            interface(p, "shelf_top").half_size = Some([Some(0.05), Some(0.05)]);
            interface(p, "tip").pose[1] += 0.06;
            // The lever arm of the load changes with it.
            p.phases[0].contacts.iter_mut().for_each(|c| {
                c.wrench.iter_mut().for_each(|w| {
                    if c.a == "tip" {
                        *w = [0.0; 6];
                    }
                });
            });
            let stripped = crate::toy::stand_without_leaning();
            p.tau = stripped.tau;
            for a in ["left_foot", "right_foot"] {
                let rows = stripped.phases[0]
                    .contacts
                    .iter()
                    .find(|c| c.a == a)
                    .unwrap()
                    .wrench
                    .clone();
                contact(p, 0, a).wrench = rows;
            }
        }),
        case(
            "a table too small for the box",
            "contact_bounds",
            &[],
            stand(),
            |p| {
                interface(p, "table_top").half_size = Some([Some(0.08), Some(0.04)]);
            },
        ),
    ]
}

#[test]
fn contacts_that_are_not_where_they_should_be() {
    judge_all(cases());
}

#[test]
fn an_overhanging_patch_is_judged_by_its_centre() {
    let mut plan = stand();
    interface(&mut plan, "table_top").half_size = Some([Some(0.08), Some(0.04)]);
    contact(&mut plan, 0, "box_bottom").overhang = true;
    assert!(check(&plan, &Options::default()).ok());
}
