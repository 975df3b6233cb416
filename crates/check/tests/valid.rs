//! Valid plans pass, whatever their integrator, form of dynamics and place in the world.

use check::{Options, Report, check};
use nalgebra::{Matrix3, Vector3, Vector6};
use plan::{Dynamics, Integrator, Plan, Pose7, Row6};
use spatial::Pose;

use crate::toy::{Recipe, lift, lift_by, stand};

fn strict() -> Options {
    // Only the hand's unread mesh and the base's idle shapes are not errors of a plan.
    let mut options = Options {
        strict: true,
        ..Options::accept()
    };
    options.set_tolerance("not_checked", 1.0).unwrap();
    options
}

fn assert_passes(plan: &Plan, options: &Options) -> Report {
    let report = check(plan, options);
    assert!(report.ok(), "{report}");
    report
}

#[test]
fn a_robot_that_stands_and_leans_passes_strictly() {
    let report = assert_passes(&stand(), &strict());
    for name in [
        "centroidal_force",
        "unactuated_force",
        "torque_file",
        "object_force",
        "normal_force",
    ] {
        assert!(report.row(name).unwrap().value.unwrap() < 1e-9, "{report}");
    }
}

#[test]
fn a_lift_passes_under_every_integrator_and_form_of_dynamics() {
    for dynamics in [Dynamics::Momentum, Dynamics::BaseRows] {
        for integrator in [
            Integrator::Euler,
            Integrator::SemiImplicitEuler,
            Integrator::ConstantAcceleration,
        ] {
            let swing = if integrator == Integrator::ConstantAcceleration {
                0.0
            } else {
                1.0
            };
            let plan = lift_by(Recipe {
                integrator,
                dynamics,
                travel: [0.08, -0.25 * swing, 0.15 * swing],
            });
            let report = assert_passes(&plan, &Options::accept());
            assert!(
                report.row("slip_contact").unwrap().value.unwrap() < 1e-6,
                "{report}"
            );
            let (rows, other) = match dynamics {
                Dynamics::Momentum => ("centroidal_force", "unactuated_force"),
                Dynamics::BaseRows => ("unactuated_force", "centroidal_force"),
            };
            assert!(report.row(rows).unwrap().value.unwrap() < 1e-9, "{report}");
            if swing > 0.0 {
                assert!(
                    report.row(other).unwrap().value.unwrap() > 1e-3,
                    "the forms differ by the time step: {report}"
                );
            }
        }
    }
}

#[test]
fn margins_tell_the_most_used_limit_of_each_kind() {
    let report = check(&lift(), &Options::default());
    let largest = |limit: &str| {
        report
            .margins_used
            .iter()
            .find(|m| m.limit == limit)
            .unwrap()
            .largest
    };
    assert!((0.1..1.0).contains(&largest("cop")), "{report}");
    assert!((0.1..1.0).contains(&largest("torque")), "{report}");
    assert!(largest("friction") < 0.2, "{report}");
}

/// Turns and moves the world: gravity, bodies and wrenches with it.
fn displaced(plan: &Plan, new_from_old: &Pose) -> Plan {
    let pose = |p: &mut Pose7| *p = (*new_from_old * Pose::from_xyzquat(p)).to_xyzquat();
    let turn = |x: &mut [f64]| {
        let v = new_from_old.rotate(Vector3::new(x[0], x[1], x[2]));
        x.copy_from_slice(v.as_slice());
    };
    let both = |row: &mut Row6| {
        turn(&mut row[..3]);
        turn(&mut row[3..]);
    };
    let mut plan = plan.clone();
    turn(&mut plan.gravity);
    for q in &mut plan.q {
        let mut base: Pose7 = std::array::from_fn(|i| q[i]);
        pose(&mut base);
        q[..7].copy_from_slice(&base);
    }
    plan.h.iter_mut().for_each(both);
    plan.object_states
        .values_mut()
        .flat_map(|s| &mut s.pose)
        .for_each(pose);
    plan.environment
        .iter_mut()
        .flat_map(|e| &mut e.geometry)
        .for_each(|g| pose(&mut g.pose));
    let statics: Vec<_> = plan.environment.iter().map(|e| e.name.clone()).collect();
    plan.interfaces
        .iter_mut()
        .filter(|i| statics.contains(&i.body))
        .for_each(|i| pose(&mut i.pose));
    plan.phases
        .iter_mut()
        .flat_map(|p| &mut p.contacts)
        .flat_map(|c| &mut c.wrench)
        .for_each(both);
    plan
}

#[test]
fn the_verdict_does_not_depend_on_where_the_world_is() {
    let plan = lift();
    let here = check(&plan, &Options::default());
    for seed in 0..5 {
        let there = check(&displaced(&plan, &Pose::random(seed)), &Options::default());
        assert!(there.ok(), "{there}");
        for (a, b) in here.rows.iter().zip(&there.rows) {
            let (x, y) = (a.value.unwrap_or(-1.0), b.value.unwrap_or(-1.0));
            let tolerance = 1e-6
                + 1e-6 * x.abs()
                + if a.category == "contact_alignment" {
                    1e-6
                } else {
                    0.0
                };
            assert!(
                (x - y).abs() < tolerance,
                "{}: {x} here, {y} there",
                a.category
            );
        }
    }
}

/// Lets the box of `stand` fly from the table, tumbling, under gravity alone.
fn throw_the_box(plan: &mut Plan) {
    let inertia = Matrix3::new(
        0.02, 0.003, -0.001, 0.003, 0.03, 0.002, -0.001, 0.002, 0.045,
    );
    plan.objects[0].inertia = [0.02, 0.03, 0.045, 0.003, -0.001, 0.002];
    plan.phases[0].contacts.retain(|c| c.a != "box_bottom");
    plan.goal.clear();
    let (gravity, n) = (Vector3::from(plan.gravity), plan.n_intervals());
    let states = plan.object_states.get_mut("box").unwrap();
    let mut pose = Pose::from_xyzquat(&states.pose[0]);
    let (mut v, mut w) = (Vector3::new(0.5, -0.3, 2.0), Vector3::new(3.0, -2.0, 4.0));
    for t in 0..=n {
        let dv = pose.rotate_inverse(gravity) - w.cross(&v);
        let dw = -inertia.try_inverse().unwrap() * w.cross(&(inertia * w));
        let dt = plan.time[n] / n as f64;
        states.pose[t] = pose.to_xyzquat();
        states.twist[t] = [v.x, v.y, v.z, w.x, w.y, w.z];
        if t < n {
            states.accel[t] = [dv.x, dv.y, dv.z, dw.x, dw.y, dw.z];
        }
        pose = pose.plus(&(Vector6::from(states.twist[t]) * dt));
        (v, w) = (v + dv * dt, w + dw * dt);
    }
}

#[test]
fn an_object_may_tumble_through_the_air_as_euler_says() {
    let mut plan = stand();
    throw_the_box(&mut plan);
    let options = Options {
        collisions: false,
        ..Options::accept()
    };
    let report = assert_passes(&plan, &options);
    assert!(
        report.row("object_moment").unwrap().value.unwrap() < 1e-12,
        "{report}"
    );
    // The gyroscopic term is not small: another product of inertia is noticed.
    plan.objects[0].inertia[4] = 0.001;
    assert_eq!(
        check(&plan, &options).failed().collect::<Vec<_>>(),
        ["object_moment"]
    );
}

#[test]
fn a_plan_survives_its_file() {
    let plan = lift();
    let back = Plan::from_json(&plan.to_json().unwrap()).unwrap();
    assert_eq!(
        check(&back, &Options::default()),
        check(&plan, &Options::default())
    );
}

#[test]
fn the_report_reads_as_a_table_and_as_json() {
    let report = check(&stand(), &Options::default());
    let text = report.to_string();
    assert!(
        text.starts_with("stand: feasible, 1 phases, 20 intervals, 0.20 s, integrator euler\n"),
        "{text}"
    );
    assert!(text.ends_with("PASS"), "{text}");
    let json = serde_json::to_value(&report).unwrap();
    assert_eq!(json["ok"], true);
    assert_eq!(json["rows"].as_array().unwrap().len(), report.rows.len());
    assert_eq!(json["rows"][0]["category"], "schema");
    assert_eq!(json["rows"][0]["status"], "PASS");
}
