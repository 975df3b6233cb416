//! What is in the arrays: the plan at its nodes, derivatives between them, what is held, signs of quaternions.

use crate::plans::{INTEGRATORS, moving};
use crate::{Found, assert_near};
use arrays::Values;
use nalgebra::{Quaternion, Vector3};
use plan::Integrator;
use spatial::Pose;

/// Samples per interval at the rate of 1 kHz.
const FINE: usize = 50;

fn quaternion(wxyz: &[f64]) -> Quaternion<f64> {
    Quaternion::new(wxyz[0], wxyz[1], wxyz[2], wxyz[3])
}

#[test]
fn at_the_nodes_the_arrays_are_the_plan() {
    for integrator in INTEGRATORS {
        let plan = moving(integrator);
        let found = Found::at(&plan, 20.0);
        assert_eq!(found.samples(), 11);
        for t in 0..11 {
            let (q, v) = (&plan.q[t], &plan.v[t]);
            assert_near(found.row("joint_pos", t), &q[7..], 1e-14, "joint_pos");
            assert_near(found.row("joint_vel", t), &v[6..], 1e-14, "joint_vel");
            assert_near(&found.row("body_pos_w", t)[..3], &q[..3], 1e-14, "base");
            let world_from_base = Pose::from_xyzquat(&q[..7].try_into().unwrap());
            let turned = world_from_base.rotate(Vector3::from_column_slice(&v[3..6]));
            let angular = &found.row("body_ang_vel_w", t)[..3];
            assert_near(angular, turned.as_slice(), 1e-13, "base's turning");
            let states = &plan.object_states["crate"];
            let [x, y, z, qx, qy, qz, qw] = states.pose[t];
            assert_near(found.row("object_pos_w", t), &[x, y, z], 1e-14, "object");
            let same =
                quaternion(found.row("object_quat_w", t)).dot(&Quaternion::new(qw, qx, qy, qz));
            assert!((same.abs() - 1.0).abs() < 1e-14, "object's quaternion");
            let moved = Pose::from_xyzquat(&states.pose[t])
                .rotate(Vector3::from_column_slice(&states.twist[t][..3]));
            let linear = found.row("object_lin_vel_w", t);
            assert_near(linear, moved.as_slice(), 1e-14, "object's velocity");
        }
    }
}

/// Derivative by five samples 1 ms apart, the middle one `k` [1/s].
fn rate(found: &Found, name: &str, k: usize) -> Vec<f64> {
    let row = |shift: isize| found.row(name, k.checked_add_signed(shift).unwrap());
    let five = |i: usize| 8.0 * (row(1)[i] - row(-1)[i]) - (row(2)[i] - row(-2)[i]);
    (0..row(0).len()).map(|i| five(i) / (12.0 * 1e-3)).collect()
}

/// Angular velocities in the world from quaternions and their derivatives: (0, ω) = 2 q̇ q*.
fn turning(quaternions: &[f64], rates: &[f64]) -> Vec<f64> {
    let bodies = quaternions.chunks(4).zip(rates.chunks(4));
    let omega = |(q, rate)| (quaternion(rate) * quaternion(q).conjugate() * 2.0).imag();
    bodies
        .flat_map(|body| Vec::from(omega(body).as_slice()))
        .collect()
}

#[test]
fn velocities_are_the_derivatives_of_what_moves_within_an_interval() {
    for integrator in INTEGRATORS {
        let found = Found::at(&moving(integrator), 1000.0);
        assert_eq!(found.samples(), 10 * FINE + 1);
        let inside = (2..10 * FINE - 1).filter(|k| (2..=FINE - 2).contains(&(k % FINE)));
        // At the node that begins an interval semi-implicit Euler has the velocity of the one before.
        for k in inside.filter(|k| k % FINE != 2) {
            let near = |value: &str, of: &[f64]| assert_near(found.row(value, k), of, 1e-7, value);
            near("joint_vel", &rate(&found, "joint_pos", k));
            for (kind, bodies) in [("body", 4), ("object", 1)] {
                let name = |what| format!("{kind}_{what}_w");
                let linear = rate(&found, &name("pos"), k);
                assert_eq!(linear.len(), 3 * bodies);
                near(&name("lin_vel"), &linear);
                let rates = rate(&found, &name("quat"), k);
                near(
                    &name("ang_vel"),
                    &turning(found.row(&name("quat"), k), &rates),
                );
            }
            if integrator == Integrator::ConstantAcceleration {
                near("joint_acc", &rate(&found, "joint_vel", k));
            }
        }
    }
}

#[test]
fn nothing_jumps_where_intervals_meet() {
    for integrator in INTEGRATORS {
        let found = Found::at(&moving(integrator), 1000.0);
        // Nothing is faster than 60 per second.
        for name in [
            "joint_pos",
            "body_pos_w",
            "body_quat_w",
            "object_pos_w",
            "object_quat_w",
        ] {
            for k in 1..found.samples() {
                assert_near(found.row(name, k), found.row(name, k - 1), 0.06, name);
            }
        }
    }
}

#[test]
fn quaternions_follow_full_turns_without_a_change_of_sign() {
    let found = Found::at(&moving(Integrator::ConstantAcceleration), 50.0);
    let base = |k: usize| quaternion(&found.row("body_quat_w", k)[..4]);
    assert!(base(0).w > 0.0, "the first has w ≥ 0");
    let samples = 0..found.samples();
    assert!(
        samples.clone().any(|k| base(k).w < -0.9),
        "more than a turn"
    );
    for k in samples.skip(1) {
        assert!(base(k).dot(&base(k - 1)) > 0.0, "sample {k}");
        assert!((base(k).norm() - 1.0).abs() < 1e-14);
    }
}

#[test]
fn torques_wrenches_and_phases_are_held_over_their_intervals() {
    let plan = moving(Integrator::ConstantAcceleration);
    let found = Found::at(&plan, 100.0);
    assert_eq!(
        found.text("contact_names"),
        ["sole on ground_top", "crate_bottom on ground_top"]
    );
    let Values::Whole(phase) = &found.0["phase"].values else {
        panic!("phase is no int array");
    };
    let Values::Truth(active) = &found.0["contact_active"].values else {
        panic!("contact_active is no bool array");
    };
    assert_eq!(found.samples(), 51);
    for k in 0..51 {
        let t = (k / 5).min(9);
        let second = usize::from(t >= 4);
        assert_eq!(phase[k], i64::from(t >= 4), "sample {k}");
        assert_eq!(
            active[2 * k..2 * k + 2],
            [second == 0, second == 1],
            "sample {k}"
        );
        assert_eq!(found.row("joint_torque", k), &plan.tau[t], "sample {k}");
        assert_eq!(found.row("joint_acc", k), &plan.a[t][6..], "sample {k}");
        let mut wrench = [0.0; 12];
        wrench[6 * second..][..6].copy_from_slice(&[1.0, 2.0, 100.0 + t as f64, 0.1, 0.2, 0.3]);
        assert_eq!(found.row("contact_wrench", k), wrench, "sample {k}");
    }
}

#[test]
fn the_last_sample_is_at_the_end_or_before_it() {
    let plan = moving(Integrator::ConstantAcceleration);
    // 0.5 s.
    for (rate, samples, last) in [
        (7.0, 4, 3.0 / 7.0),
        (50.0, 26, 0.5),
        (3.0, 2, 1.0 / 3.0),
        (1.0, 1, 0.0),
    ] {
        let found = Found::at(&plan, rate);
        assert_eq!(found.samples(), samples, "{rate} Hz");
        let Values::Real(times) = &found.0["time"].values else {
            panic!("time is no float array");
        };
        assert!((times[samples - 1] - last).abs() < 1e-15);
        assert_eq!(found.0["fps"].values, Values::Real(vec![rate]));
    }
}

#[test]
fn links_that_a_fixed_joint_holds_are_bodies_too_and_the_base_comes_first() {
    let found = Found::at(&moving(Integrator::Euler), 50.0);
    assert_eq!(found.text("body_names"), ["trunk", "arm", "palm", "foot"]);
    assert_eq!(found.text("joint_names"), ["slide", "shoulder"]);
    let position =
        |body: usize| Vector3::from_column_slice(&found.row("body_pos_w", 7)[3 * body..][..3]);
    assert!(((position(2) - position(1)).norm() - 0.3).abs() < 1e-14);
}
