//! MJCF files against what MuJoCo 3 makes of them.

#![allow(clippy::unreadable_literal, reason = "figures of another program")]

use mjcf::{Converted, MjcfError, to_urdf};
use multibody::{Crba, Kinematics, Model, Root};
use std::path::Path;

/// The robot of a file in `data`, and of its URDF.
fn robot() -> (Converted, Model) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/robot.xml");
    let converted = to_urdf(&path).expect("a robot");
    let model = Model::from_urdf(&converted.urdf, Root::Floating).expect("a URDF");
    (converted, model)
}

/// Of a text in a file of its own.
fn convert(text: &str) -> Result<Converted, MjcfError> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("robot.xml");
    std::fs::write(&path, text).expect("a file");
    to_urdf(&path)
}

/// The keyframe `stand` of the data, base first; joints in the order of the model.
fn stand(converted: &Converted, model: &Model) -> Vec<f64> {
    let mut q = vec![0.0; model.nq];
    (q[2], q[6]) = (1.0, 1.0);
    for (name, position) in &converted.home {
        let joint = model.joint_id(name).expect("a joint of the model");
        q[model.joints[joint].idx_q] = *position;
    }
    q
}

#[test]
fn links_are_where_mujoco_has_the_bodies() {
    let (converted, model) = robot();
    let mut kinematics = Kinematics::new(&model);
    kinematics.update(&model, &stand(&converted, &model));
    // xpos and the first row of xmat, of MuJoCo 3 at this keyframe.
    let expected = [
        (
            "thigh",
            [-7.8154321e-05, 0.101019946, 0.849992801],
            [0.996496897, -0.0707945218, 0.0445204393],
        ),
        (
            "shin",
            [-0.0121466932, 0.0922951705, 0.557380582],
            [0.693497761, -0.326294632, 0.642333767],
        ),
        (
            "toe",
            [-0.141408745, 0.0378640826, 0.249438089],
            [0.693497761, -0.326294632, 0.642333767],
        ),
        ("lamp", [0.1, 0.0, 1.1], [0.0, 0.0, 1.0]),
    ];
    for (name, place, row) in expected {
        let frame = model.frame_id(name).expect("a link");
        let pose = kinematics.frame_pose(&model, frame);
        for i in 0..3 {
            assert!((pose.origin()[i] - place[i]).abs() < 1e-8, "{name}");
            assert!((pose.rotation()[(0, i)] - row[i]).abs() < 1e-8, "{name}");
        }
    }
}

#[test]
fn masses_and_inertias_are_those_of_mujoco() {
    let (converted, model) = robot();
    assert!((model.total_mass() - 10.503702976).abs() < 1e-8);
    let mut kinematics = Kinematics::new(&model);
    kinematics.update(&model, &stand(&converted, &model));
    let mut crba = Crba::new(&model);
    let matrix = crba.compute(&model, &kinematics);
    // The joints' block of mj_fullM, armatures set to zero.
    let expected = [
        [0.46995782, -0.0197414659, 0.201436968, -0.154744846],
        [-0.0197414659, 0.372995875, -0.0490140558, 0.0386978001],
        [0.201436968, -0.0490140558, 0.120933768, -0.102],
        [-0.154744846, 0.0386978001, -0.102, 0.3],
    ];
    let names = ["hip_pitch", "hip_roll", "knee", "toe_slide"];
    let place = |name: &str| model.joints[model.joint_id(name).expect("a joint")].idx_v;
    for (name, row) in names.iter().zip(&expected) {
        for (other, value) in names.iter().zip(row) {
            let (i, j) = (place(name), place(other));
            let found = matrix[(i.max(j), i.min(j))];
            assert!((found - value).abs() < 1e-8, "{name}, {other}: {found}");
        }
    }
}

#[test]
fn torques_are_limited_by_actuators_and_by_joints() {
    let (_, model) = robot();
    let limits = |name: &str| {
        let joint = &model.joints[model.joint_id(name).expect("a joint")];
        (joint.torque_limit, joint.lower, joint.upper)
    };
    // 2 · 30 by the motor, but 40 the other way by the class of the joint.
    assert_eq!(limits("hip_pitch").0, 40.0);
    // A servo without a limit, 70 by the joint's own class.
    assert_eq!(limits("hip_roll").0, 70.0);
    assert_eq!(limits("knee").0, 25.0);
    let (force, lower, upper) = limits("toe_slide");
    assert_eq!((force, lower, upper), (8.0, -0.02, 0.03));
    assert!((limits("knee").2 - 120f64.to_radians()).abs() < 1e-12);
}

#[test]
fn what_is_left_out_is_said() {
    let (converted, _) = robot();
    let notes = converted.notes.join("\n");
    for word in ["armatures", "limits of speed", "crate"] {
        assert!(notes.contains(word), "{word} in:\n{notes}");
    }
    assert!(!notes.contains("without actuator"), "{notes}");
}

#[test]
fn meshes_are_named_from_the_folder_of_the_file() {
    let text = r#"<mujoco><compiler meshdir="parts"/>
        <asset><mesh name="hand" file="hand.stl" scale="0.001 0.001 0.001"/></asset>
        <worldbody><body name="a"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
        <body name="b"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="j"/>
        <geom type="mesh" mesh="hand"/></body></body></worldbody></mujoco>"#;
    let converted = convert(text).expect("a robot");
    let mesh = r#"<mesh filename="parts/hand.stl" scale="0.001 0.001 0.001"/>"#;
    assert!(converted.urdf.contains(mesh), "{}", converted.urdf);
    let notes = converted.notes.join("\n");
    assert!(notes.contains("no actuators: 1000 N·m"), "{notes}");
    assert!(notes.contains("joints without range"), "{notes}");
    assert!(converted.home.is_empty());
}

#[test]
fn joints_that_nothing_drives_stay_where_the_keyframe_has_them() {
    let body = |name: &str, child: &str| {
        format!(
            r#"<body name="{name}"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="of_{name}" range="-60 60"/>{child}</body>"#
        )
    };
    let with = |keyframe: &str| {
        let chain = body("a", &body("b", &body("c", "")));
        let text = format!(
            r#"<mujoco><worldbody><body name="base"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>{chain}</body>
            </worldbody><actuator><motor joint="of_a" ctrlrange="-5 5"/></actuator>{keyframe}</mujoco>"#
        );
        convert(&text).expect("a robot")
    };
    let locked = |converted: &Converted| {
        let model = Model::from_urdf(&converted.urdf, Root::Floating).expect("a URDF");
        assert_eq!(model.joints.len(), 2, "the base and what is driven");
        assert_eq!(model.joints[1].torque_limit, 5.0);
        model.locked
    };
    let at = |b: f64, c: f64| vec![("of_b".to_owned(), b), ("of_c".to_owned(), c)];
    let plain = with("");
    assert_eq!(locked(&plain), at(0.0, 0.0));
    let notes = plain.notes.join("\n");
    assert!(notes.contains("nothing moves here: of_b, of_c"), "{notes}");
    let bent = r#"<keyframe><key name="home" qpos="0 0 1 1 0 0 0 0.1 0.2 -0.3"/></keyframe>"#;
    assert_eq!(locked(&with(bent)), at(0.2, -0.3));
}

#[test]
fn where_no_geom_has_a_contact_type_those_of_the_group_for_collisions_collide() {
    let text = |foot: &str| {
        format!(
            r#"<mujoco><worldbody><geom type="plane" size="1 1 1"/><body name="a"><freejoint/>
            <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
            <body name="b"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="j"/>
            <geom type="sphere" size="0.5" contype="0" conaffinity="0"/>
            <geom type="box" size="0.1 0.05 0.01" contype="0" conaffinity="0" group="3"/>{foot}
            </body></body></worldbody></mujoco>"#
        )
    };
    let told = |converted: &Converted| converted.notes.join("\n").contains("those of group 3");
    let by_group = convert(&text("")).expect("a robot");
    assert!(by_group.urdf.contains(r#"<box size="0.2 0.1 0.02"/>"#));
    assert!(!by_group.urdf.contains("sphere") && told(&by_group));
    let by_type = convert(&text(r#"<geom type="sphere" size="0.3"/>"#)).expect("a robot");
    assert!(by_type.urdf.contains(r#"<sphere radius="0.3"/>"#));
    assert!(!by_type.urdf.contains("<box") && !told(&by_type));
}

#[test]
fn files_that_are_no_robot_say_what_is_wrong() {
    let body = |inside: &str| {
        format!(
            "<mujoco><worldbody><body name=\"a\"><freejoint/>{inside}</body></worldbody></mujoco>"
        )
    };
    let error = |text: &str| convert(text).expect_err("an error").to_string();
    let hinge = "<joint name=\"j\" type=\"hinge\"/><geom size=\"0.1\"/>";
    let ball = "<joint name=\"wrist\" type=\"ball\"/><geom size=\"0.1\"/>";
    let nothing = error(&body("<geom size=\"0.1\"/>"));
    assert!(nothing.contains("no body with joints"), "{nothing}");
    let with_ball = body(&format!(
        "<geom size=\"0.1\"/><body name=\"b\">{hinge}<body name=\"c\">{ball}</body></body>"
    ));
    let with_ball = error(&with_ball);
    assert!(with_ball.contains("\"wrist\" of body \"c\""), "{with_ball}");
    let mesh = body(&format!(
        "<geom type=\"mesh\" mesh=\"m\"/><body name=\"b\">{hinge}</body>"
    ));
    let mesh = error(&mesh);
    assert!(mesh.contains("\"a\" has no <inertial>"), "{mesh}");
    let broken = error("<mujoco><worldbody>");
    assert!(!broken.is_empty());
    let missing = error("<mujoco><include file=\"nowhere.xml\"/></mujoco>");
    assert!(missing.contains("nowhere.xml"), "{missing}");
}
