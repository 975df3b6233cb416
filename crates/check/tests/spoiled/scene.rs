//! Bodies that run into each other, and interfaces away from their bodies.

use check::{Options, Status, check};
use plan::Plan;

use super::{Case, FORCES, box_states, case, column, in_urdf, interface, judge_all, static_box};
use crate::toy::stand;

/// Corruptions of places and shapes.
pub(crate) fn cases() -> Vec<Case> {
    vec![
        case("a wall through a leg", "collision_env", &[], stand(), |p| {
            static_box(p, [0.0, 0.15, 0.2], [0.02; 3]);
        }),
        case(
            "the robot in the ground",
            "collision_env",
            FORCES,
            stand(),
            |p| {
                p.q.iter_mut().for_each(|q| q[2] -= 0.3);
                p.phases[0].contacts.retain(|c| c.a == "box_bottom");
            },
        ),
        case(
            "the box in the base",
            "collision_obj",
            &["contact_bounds", "cop", "collision_scene"],
            stand(),
            |p| {
                box_states(p)
                    .pose
                    .iter_mut()
                    .for_each(|pose| pose[0] = 0.05);
            },
        ),
        case(
            "a wall through the box",
            "collision_scene",
            &[],
            stand(),
            |p| {
                let at = p.object_states["box"].pose[0];
                static_box(p, [at[0], at[1] + 0.06, at[2]], [0.02; 3]);
            },
        ),
        case(
            "the arm folded into a leg",
            "collision_self",
            &[
                "centroidal_moment",
                "torque_file",
                "unactuated_moment",
                "contact_distance",
                "collision_env",
                "collision_obj",
                "joint_position",
            ],
            stand(),
            fold_hand_into_leg,
        ),
        case(
            "the stick deep in its shelf",
            "contact_overlap",
            &["interface_surface"],
            stand(),
            |p| {
                let shelf = p
                    .environment
                    .iter_mut()
                    .find(|e| e.name == "shelf")
                    .unwrap();
                shelf.geometry[0].pose[2] += 0.04;
            },
        ),
        case(
            "a patch above its body",
            "interface_surface",
            &[],
            stand(),
            |p| {
                let table = p
                    .environment
                    .iter_mut()
                    .find(|e| e.name == "table")
                    .unwrap();
                table.geometry[0].pose[2] -= 0.02;
            },
        ),
        case(
            "an interface far from its link",
            "interface_robot",
            &[],
            stand(),
            |p| interface(p, "palm").pose[0] += 0.3,
        ),
        case(
            "a mesh instead of a shape",
            "not_checked",
            &[],
            stand(),
            |p| {
                in_urdf(
                    p,
                    "<box size=\"0.16 0.2 0.3\"/>",
                    "<mesh filename=\"base.stl\"/>",
                );
            },
        ),
    ]
}

#[test]
fn bodies_that_run_into_each_other() {
    judge_all(cases());
}

#[test]
fn a_wall_that_is_only_crossed_between_two_nodes_is_found() {
    let mut plan = stand();
    plan.q[10..].iter_mut().for_each(|q| q[1] += 2.0);
    static_box(&mut plan, [0.0, 1.0, 0.6], [0.02; 3]);
    let mut options = Options::default();
    let report = check(&plan, &options);
    let row = report.row("collision_env").unwrap();
    assert_eq!(
        (row.status, row.location.node, row.location.share),
        (Status::Fail, Some(9), Some(0.5)),
        "{report}"
    );
    assert_eq!(row.location.what, "base / wall");
    options.substeps = 1;
    assert_eq!(
        check(&plan, &options).row("collision_env").unwrap().status,
        Status::Pass
    );
}

/// Makes the hand long and wide so that it reaches a leg.
fn fold_hand_into_leg(plan: &mut Plan) {
    in_urdf(
        plan,
        "<collision><origin xyz=\"0.08 0 0\"/><geometry><sphere radius=\"0.03\"/></geometry></collision>",
        "<collision><origin xyz=\"0.2 0 0\"/><geometry><box size=\"0.4 0.4 0.04\"/></geometry></collision>",
    );
    let (shoulder, wrist) = (column(plan, "shoulder"), column(plan, "wrist"));
    for q in &mut plan.q {
        q[7 + shoulder] = 0.9;
        q[7 + wrist] = 1.6;
    }
}
