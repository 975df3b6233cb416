//! States that do not follow from each other.

use super::{Case, box_states, case, in_urdf, interface, judge_all};
use crate::toy::{lift, stand};

/// Corruptions of states, times and limits.
#[allow(clippy::too_many_lines, reason = "a table")]
pub(crate) fn cases() -> Vec<Case> {
    let moving = || lift();
    vec![
        case(
            "a quaternion that is not unit",
            "quaternion",
            &[],
            stand(),
            |p| p.q[5][6] = 1.01,
        ),
        case(
            "an object's quaternion that is not unit",
            "quaternion",
            &[],
            stand(),
            |p| box_states(p).pose[7][6] = 0.98,
        ),
        case(
            "an interface's quaternion that is not unit",
            "quaternion",
            &[],
            stand(),
            |p| {
                interface(p, "palm").pose[3] = 1.1;
            },
        ),
        case("stretched time", "time_grid", &[], stand(), |p| {
            p.time.iter_mut().for_each(|t| *t *= 1.1);
        }),
        case(
            "a duration of zero",
            "time_grid",
            &[
                "integration_q",
                "integration_v",
                "integration_obj_q",
                "integration_obj_v",
                "centroidal_force",
                "centroidal_moment",
                "contact_velocity",
                "contact_spin",
            ],
            stand(),
            |p| p.phases[0].duration = 0.0,
        ),
        case(
            "one joint sample moved",
            "integration_q",
            &["torque_file", "centroidal_force", "centroidal_moment"],
            moving(),
            |p| {
                p.q[20][9] += 0.002;
            },
        ),
        case(
            "the wrong integrator named",
            "integration_q",
            &["integration_obj_q", "node_velocity"],
            moving(),
            |p| {
                p.integrator = plan::Integrator::SemiImplicitEuler;
            },
        ),
        case(
            "a wrong acceleration",
            "integration_v",
            &["torque_file"],
            moving(),
            |p| p.a[20][8] += 1.0,
        ),
        case(
            "a wrong acceleration of the object",
            "integration_obj_v",
            &["object_force"],
            moving(),
            |p| {
                box_states(p).accel[20][2] += 1.0;
            },
        ),
        case(
            "an object's twist in world axes",
            "integration_obj_q",
            &[
                "integration_obj_v",
                "object_force",
                "object_moment",
                "node_velocity",
                "contact_velocity",
            ],
            moving(),
            |p| {
                for t in 0..p.time.len() {
                    let states = box_states(p);
                    let pose = spatial::Pose::from_xyzquat(&states.pose[t]);
                    let twist = states.twist[t];
                    let linear =
                        pose.rotate(nalgebra::Vector3::new(twist[0], twist[1], twist[2])) * 1.2;
                    states.twist[t][..3].copy_from_slice(linear.as_slice());
                }
            },
        ),
        case(
            "a joint beyond its limit",
            "joint_position",
            &[],
            moving(),
            |p| in_urdf(p, "lower=\"-1\"", "lower=\"-0.1\""),
        ),
        case("a joint too fast", "joint_velocity", &[], moving(), |p| {
            in_urdf(p, "velocity=\"3\"", "velocity=\"0.5\"");
        }),
    ]
}

#[test]
fn states_that_do_not_follow_from_each_other() {
    judge_all(cases());
}
