//! Rows tell the right number and place, not only a verdict.

use check::{Options, Report, Status, check};
use plan::{Contact, Integrator, Plan};

use crate::toy::{lift, stand};

fn value(report: &Report, category: &str) -> f64 {
    report.row(category).unwrap().value.unwrap()
}

fn assert_near(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() < 1e-9 + 1e-6 * expected.abs(),
        "{found}, expected {expected}"
    );
}

fn contact<'a>(plan: &'a mut Plan, k: usize, a: &str) -> &'a mut Contact {
    plan.phases[k]
        .contacts
        .iter_mut()
        .find(|c| c.a == a)
        .unwrap()
}

#[test]
fn drift_is_counted_from_the_start_of_the_phase_and_of_the_contact() {
    let mut plan = lift();
    plan.q
        .iter_mut()
        .enumerate()
        .for_each(|(t, q)| q[1] += 4e-4 * t as f64);
    let report = check(&plan, &Options::default());
    assert_near(value(&report, "slip_phase"), 40.0 * 0.4);
    assert_near(value(&report, "slip_contact"), 46.0 * 0.4);
    assert_eq!(report.row("slip_phase").unwrap().location.node, Some(46));
}

#[test]
fn a_contact_that_lasts_over_two_phases_does_not_touch_down_twice() {
    assert_eq!(
        check(&lift(), &Options::default())
            .row("touchdown")
            .unwrap()
            .value,
        None
    );
}

#[test]
fn a_contact_that_slides_in_its_last_interval_only_is_found() {
    for (integrator, node) in [(Integrator::Euler, 19), (Integrator::SemiImplicitEuler, 20)] {
        let mut plan = stand();
        plan.integrator = integrator;
        plan.q[20][1] += 1e-3;
        plan.v[node][1] += 0.04;
        let report = check(&plan, &Options::default());
        let row = report.row("contact_velocity").unwrap();
        assert_eq!(
            (row.status, row.location.node),
            (Status::Fail, Some(node)),
            "{report}"
        );
        assert_near(row.value.unwrap(), 0.04);
    }
}

#[test]
fn either_a_resting_velocity_or_a_resting_pose_is_enough() {
    let mut plan = stand();
    plan.v[7][1] += 0.04;
    let report = check(&plan, &Options::default());
    assert_near(value(&report, "node_velocity"), 0.04);
    assert!(value(&report, "contact_velocity") < 1e-9, "{report}");
}

/// The palm as the side that is landed on: its wrench is what the box feels.
#[test]
fn the_two_sides_of_a_grasp_may_change_places() {
    let mut plan = lift();
    for k in 0..2 {
        let palm = contact(&mut plan, k, "palm");
        std::mem::swap(&mut palm.a, &mut palm.b);
        palm.overhang = true;
        palm.wrench.iter_mut().flatten().for_each(|x| *x = -*x);
    }
    let report = check(&plan, &Options::accept());
    assert!(report.ok(), "{report}");
}

#[test]
fn a_goal_may_name_its_pair_either_way() {
    let mut plan = lift();
    let goal = &mut plan.goal[0];
    std::mem::swap(&mut goal.a, &mut goal.b);
    assert!(check(&plan, &Options::default()).ok());
}

/// A support that holds the sole's origin and the centre of pressure passes, its mirror image does not.
#[test]
fn the_centre_of_pressure_is_on_the_side_where_it_is() {
    let bounded = |towards: f64| {
        let mut plan = stand();
        let origin_x = 0.05;
        let row = contact(&mut plan, 0, "left_foot").wrench[0];
        let offset = -row[4] / row[2];
        assert!(offset.abs() > 0.01, "{offset}");
        for foot in ["left_foot", "right_foot"] {
            contact(&mut plan, 0, foot).overhang = true;
        }
        let ground = plan
            .interfaces
            .iter_mut()
            .find(|i| i.name == "ground_top")
            .unwrap();
        ground.pose[0] = origin_x + towards * offset / 2.0;
        ground.half_size = Some([Some(offset.abs() / 2.0 + 1e-4), Some(0.3)]);
        check(&plan, &Options::default())
    };
    assert!(bounded(1.0).ok(), "{}", bounded(1.0));
    assert_eq!(bounded(-1.0).failed().collect::<Vec<_>>(), ["cop"]);
}

#[test]
fn the_surplus_of_torsional_friction_is_told() {
    let mut plan = stand();
    contact(&mut plan, 0, "left_foot").mu_r = 0.2;
    // Mean distance from the centre over a rectangle of 0.24 m by 0.08 m: 0.0659 m.
    let surplus = value(&check(&plan, &Options::default()), "mu_r");
    assert!((surplus - (0.2 - 0.7 * 0.0659)).abs() < 2e-4, "{surplus}");
}

#[test]
fn margins_count_the_samples_near_their_limit() {
    let mut plan = stand();
    contact(&mut plan, 0, "tip").mu = 1.5 / 8.0 / 0.99;
    let report = check(&plan, &Options::default());
    let friction = report
        .margins_used
        .iter()
        .find(|m| m.limit == "friction")
        .unwrap();
    assert_near(friction.largest, 0.99);
    assert_near(friction.share_above_95_percent, 0.25);
    assert_eq!(friction.location.what, "tip/shelf_top");
}

#[test]
fn bodies_may_overlap_up_to_the_node_where_their_contact_ends() {
    let mut plan = lift();
    let table = plan
        .environment
        .iter_mut()
        .find(|e| e.name == "table")
        .unwrap();
    table.geometry[0].pose[2] += 0.008;
    let report = check(&plan, &Options::default());
    let row = report.row("collision_scene").unwrap();
    assert_near(row.value.unwrap(), 8.0);
    assert_eq!(
        (row.location.node, row.location.share),
        (Some(6), Some(0.5)),
        "{report}"
    );
    assert_near(value(&report, "contact_overlap"), 8.0);
}
