//! Validation: every fault with its place, its value and what was expected.

use crate::sample::sample;
use plan::{Plan, PlanError};

/// The message of the only fault of the spoiled sample.
fn fault(corrupt: impl FnOnce(&mut Plan)) -> String {
    let mut plan = sample();
    corrupt(&mut plan);
    let faults: Vec<_> = plan.faults().iter().map(PlanError::to_string).collect();
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert_eq!(plan.validate().unwrap_err().to_string(), faults[0]);
    faults.into_iter().next().unwrap()
}

#[test]
fn the_sample_has_no_fault() {
    sample().validate().unwrap();
}

#[test]
fn wrong_row_counts_are_found() {
    assert_eq!(fault(|p| p.q.truncate(3)), "q: 3 rows, expected 4");
    assert_eq!(fault(|p| p.v[2].truncate(5)), "v[2]: 5 numbers, expected 7");
    assert_eq!(fault(|p| p.h.clear()), "h: 0 rows, expected 4");
    assert_eq!(fault(|p| p.a.push(vec![0.0; 7])), "a: 4 rows, expected 3");
    assert_eq!(
        fault(|p| p.tau[0].push(1.0)),
        "tau[0]: 2 numbers, expected 1"
    );
    assert_eq!(fault(|p| p.time.truncate(1)), "time: 1 values, expected 4");
    assert_eq!(
        fault(|p| p.robot.torque_limits = Some(vec![])),
        "robot.torque_limits: 0 values, expected 1"
    );
    let text = fault(|p| p.object_states.get_mut("box").unwrap().accel.truncate(1));
    assert_eq!(text, "object_states.box.accel: 1 rows, expected 3");
    let text = fault(|p| p.phases[1].contacts[0].wrench.clear());
    assert_eq!(
        text,
        "phases[1].contacts[0].wrench (sole/ground_top): 0 rows, expected 1"
    );
}

#[test]
fn torque_at_speed_is_of_joints_that_exist_and_falls_beyond_the_corner() {
    let with = |joint: &str, corner: f64, max: f64| {
        let mut plan = sample();
        let line = plan::TorqueSpeed { corner, max };
        plan.robot.torque_speed.insert(joint.to_owned(), line);
        plan.validate().map_err(|error| error.to_string())
    };
    let joint = sample().robot.joints[0].clone();
    assert_eq!(with(&joint, 5.0, 9.0), Ok(()));
    let cases = [
        ("elbow", 5.0, 9.0, "no joint is called \"elbow\""),
        (joint.as_str(), 5.0, f64::NAN, "not a finite number"),
        (
            joint.as_str(),
            0.0,
            9.0,
            "corner: 0, expected a speed above zero",
        ),
        (
            joint.as_str(),
            5.0,
            5.0,
            "max: 5, expected a speed above the corner",
        ),
    ];
    for (joint, corner, max, expected) in cases {
        let message = with(joint, corner, max).unwrap_err();
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn costs_have_a_number_per_interval_and_term() {
    let with = |change: fn(&mut plan::Costs)| {
        fault(|p| change(p.costs.as_mut().expect("the sample has costs")))
    };
    assert_eq!(
        with(|c| c.per_interval.truncate(2)),
        "costs.per_interval: 2 rows, expected 3"
    );
    assert_eq!(
        with(|c| c.per_interval[1].push(0.0)),
        "costs.per_interval[1]: 3 numbers, expected 2"
    );
    let twice = with(|c| c.terms[1] = "time".into());
    assert!(twice.starts_with("costs.terms[1]: "), "{twice}");
    let end = with(|c| *c.end.get_mut("goal").unwrap() = f64::NAN);
    assert!(end.starts_with("costs.end[0]: "), "{end}");
}

#[test]
fn a_plan_without_intervals_is_a_fault() {
    let mut plan = sample();
    plan.phases.clear();
    assert!(
        plan.validate()
            .unwrap_err()
            .to_string()
            .contains("phases: 0 intervals in all, expected 1")
    );
}

#[test]
fn an_absurd_number_of_steps_does_not_overflow() {
    let mut plan = sample();
    plan.phases[0].steps = usize::MAX;
    plan.phases[1].steps = usize::MAX;
    assert!(plan.validate().is_err());
}

#[test]
fn numbers_that_are_not_finite_are_found() {
    assert_eq!(
        fault(|p| p.q[2][7] = f64::NAN),
        "q[2][7]: NaN is not a finite number"
    );
    assert_eq!(
        fault(|p| p.gravity[2] = f64::NEG_INFINITY),
        "gravity[2]: -inf is not a finite number"
    );
    assert_eq!(
        fault(|p| p.time[1] = f64::NAN),
        "time[1]: NaN is not a finite number"
    );
    assert_eq!(
        fault(|p| p.phases[0].duration = f64::INFINITY),
        "phases[0].duration[0]: inf is not a finite number"
    );
    let text = fault(|p| p.phases[0].contacts[0].wrench[1][4] = f64::NAN);
    assert_eq!(
        text,
        "phases[0].contacts[0].wrench[1][4]: NaN is not a finite number"
    );
    assert_eq!(
        fault(|p| p.objects[0].mass = f64::NAN),
        "objects[0].mass[0]: NaN is not a finite number"
    );
}

#[test]
fn unknown_names_are_found() {
    let text = fault(|p| p.interfaces[0].body = "hand".into());
    assert_eq!(
        text,
        "interfaces[0].body: no link, object or static body is called \"hand\"; known: box, foot, ground"
    );
    let text = fault(|p| p.phases[0].contacts[0].b = "table".into());
    assert_eq!(
        text,
        "phases[0].contacts[0].b: no interface is called \"table\"; known: ground_top, sole, tip"
    );
    assert!(fault(|p| p.goal[0].a = "x".into()).starts_with("goal[0].a: no interface"));
    assert!(
        fault(|p| p.goal_regions[0].body = "x".into()).starts_with("goal_regions[0].body: no link")
    );
    assert!(
        fault(|p| p.object_states.clear())
            .starts_with("objects[0]: no entry of object_states is called \"box\"")
    );
}

#[test]
fn names_that_are_taken_are_found() {
    assert_eq!(
        fault(|p| p.interfaces[1].name = "sole".into()),
        "interfaces[1]: the name \"sole\" is taken"
    );
    let twin = |p: &mut Plan| {
        p.environment[0].name = "box".into();
        p.interfaces[2].body = "box".into();
    };
    assert_eq!(fault(twin), "environment[0]: the name \"box\" is taken");
}

#[test]
fn durations_and_times_are_judged() {
    assert_eq!(
        fault(|p| p.phases[1].duration = 0.0),
        "phases[1].duration: 0 s, expected a positive number of seconds"
    );
    assert!(fault(|p| p.time[3] = 0.21).starts_with("time[3]: 0.21 s, expected the sum"));
}

#[test]
fn quaternions_that_are_not_unit_are_found() {
    assert_eq!(
        fault(|p| p.q[1][6] = 2.0),
        "q[1]: quaternion of norm 2, expected 1"
    );
    let text = fault(|p| p.object_states.get_mut("box").unwrap().pose[3][6] = 0.0);
    assert_eq!(
        text,
        "object_states.box.pose[3]: quaternion of norm 0, expected 1"
    );
    assert!(fault(|p| p.interfaces[0].pose[3] = 0.5).starts_with("interfaces[0].pose (sole)"));
    assert!(
        fault(|p| p.environment[0].geometry[0].pose[6] = 0.5)
            .starts_with("environment[0].geometry[0].pose")
    );
    assert!(fault(|p| p.q[1][6] = 1e300).contains("norm inf"));
}

#[test]
fn masses_sizes_and_coefficients_are_judged() {
    assert!(
        fault(|p| p.objects[0].mass = -1.0).contains("-1, expected a positive number of kilograms")
    );
    assert!(
        fault(|p| p.objects[0].geometry[0].half_size = Some([0.1, 0.0, 0.1]))
            .contains("positive half sizes")
    );
    assert!(
        fault(|p| p.interfaces[0].half_size = Some([Some(-0.1), None]))
            .contains("half sizes of at least zero")
    );
    assert!(fault(|p| p.interfaces[1].limb = Some([0.0; 3])).contains("a direction"));
    assert!(fault(|p| p.phases[0].contacts[0].mu = -0.1).contains("friction coefficient"));
}
