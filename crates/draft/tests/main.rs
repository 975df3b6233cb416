//! Drafts of whole robots: the built-in one, and bipeds of boxes.

mod biped;

use biped::Biped;
use draft::{Draft, DraftError, Forward, Wishes, draft, standing_scene};
use multibody::{CenterOfMass, Kinematics};
use nalgebra::Vector3;
use scene::{Owner, Scene};
use spatial::Pose;
use std::f64::consts::{FRAC_PI_2, PI};
use std::fs;
use std::path::Path;

/// The draft for a description, and the scene in which its robot stands, read from files.
fn drafted(urdf: &str, wishes: &Wishes) -> Result<(Draft, Scene), DraftError> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("robot.urdf");
    fs::write(&path, urdf).expect("a file");
    let draft = draft(&path, folder.path(), wishes)?;
    fs::write(folder.path().join("robot.toml"), &draft.text).expect("a file");
    let text = standing_scene("robot.toml");
    let scene = Scene::from_toml(&text, "standing", folder.path())
        .unwrap_or_else(|error| panic!("{}\n{}", error.render(), draft.text));
    Ok((draft, scene))
}

fn g1() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/g1.urdf");
    fs::read_to_string(path).expect("the built-in robot")
}

/// The link of an interface, and the interface in it with its half size.
fn interface(scene: &Scene, name: &str) -> (String, Pose, [f64; 2]) {
    let id = scene.interface_id(name).expect("an interface").0;
    let interface = &scene.interfaces[id];
    let Owner::Robot { frame } = interface.owner else {
        panic!("{name} is the robot's");
    };
    let link = scene.robot.model.frames[frame].name.clone();
    let half_size = interface.half_size.expect("a patch");
    (link, interface.body_from_interface, half_size)
}

/// Poses of interfaces in the world at the start, and the centre of mass.
fn standing(scene: &Scene, names: [&str; 2]) -> ([Pose; 2], Vector3<f64>) {
    let model = &scene.robot.model;
    let mut kinematics = Kinematics::new(model);
    kinematics.update(model, &scene.start);
    let pose = |name: &str| {
        let (link, pose, _) = interface(scene, name);
        kinematics.frame_pose(model, model.frame_id(&link).expect("a link")) * pose
    };
    let com = CenterOfMass::new(model).compute(model, &kinematics).0;
    (names.map(pose), com)
}

fn assert_stands(scene: &Scene) {
    let ([left, right], com) = standing(scene, ["left_foot", "right_foot"]);
    for sole in [&left, &right] {
        assert!(sole.rotation().column(2).xy().norm() < 1e-5, "level");
        assert!(sole.origin().z.abs() < 1e-5, "on the ground");
    }
    let middle = (left.origin() + right.origin()) / 2.0;
    let off = (com - middle).xy().norm();
    assert!(
        off < 1e-3,
        "the centre of mass is {off} m beside the middle of the soles"
    );
    assert_eq!(scene.start_contacts.len(), 2);
}

#[test]
fn the_feet_hands_and_stance_of_the_built_in_robot_are_found() {
    let (draft, scene) = drafted(&g1(), &Wishes::default()).unwrap();
    assert_eq!(scene.notes(), Vec::<String>::new(), "{}", draft.text);
    assert_stands(&scene);
    let real = Scene::builtin("side-step").unwrap();
    for name in ["left_foot", "right_foot"] {
        let (link, pose, [x, y]) = interface(&scene, name);
        let (its_link, its_pose, [most_x, most_y]) = interface(&real, name);
        assert_eq!(link, its_link);
        // The flat of the mesh is 206 x 74 mm, the boxes around it a little larger.
        let off = pose.origin() - its_pose.origin();
        assert!(off.z.abs() < 0.002 && off.y.abs() < 0.003, "{off:?}");
        assert!(off.x.abs() + x < 0.103 + 0.004, "{off:?} {x}");
        assert!(off.y.abs() + y < 0.037 + 0.002, "{off:?} {y}");
        assert!(x > 0.9 * most_x && y > 0.8 * most_y, "{x} {y}");
    }
    for (name, link) in [
        ("left_hand", "left_rubber_hand"),
        ("right_hand", "right_rubber_hand"),
    ] {
        let (found, pose, half) = interface(&scene, name);
        assert_eq!(found, link);
        let (_, its_pose, _) = interface(&real, name);
        let cosine = pose
            .rotation()
            .column(2)
            .dot(&its_pose.rotation().column(2));
        assert!(cosine > 0.98, "the palm is {cosine} from that of the file");
        assert!(
            (pose.origin() - its_pose.origin()).norm() < 0.05,
            "{pose:?}"
        );
        assert!(half.iter().all(|x| (0.008..=0.03).contains(x)), "{half:?}");
    }
    let knee = scene
        .robot
        .model
        .joint_id("left_knee_joint")
        .expect("a joint");
    assert!((scene.robot.home[knee - 1] - 0.5).abs() < 0.1);
}

#[test]
fn left_and_right_are_mirror_images() {
    let (_, scene) = drafted(&g1(), &Wishes::default()).unwrap();
    for names in [["left_foot", "right_foot"], ["left_hand", "right_hand"]] {
        let ([left, right], _) = standing(&scene, names);
        let mirror = |v: Vector3<f64>| Vector3::new(v.x, -v.y, v.z);
        let (a, b) = (left.origin(), mirror(right.origin()));
        assert!((a - b).norm() < 0.002, "{names:?}: {a:?} {b:?}");
        let normal = |pose: &Pose| pose.rotation().column(2).into_owned();
        assert!((normal(&left) - mirror(normal(&right))).norm() < 0.01);
    }
}

/// The biped's URDF with `from` replaced by `to` in the line that begins so.
fn edited(edits: &[[&str; 3]]) -> String {
    let mut urdf = Biped::default().urdf();
    for [begin, from, to] in edits {
        let edit = |line: &str| {
            if line.starts_with(begin) {
                line.replace(from, to)
            } else {
                line.to_owned()
            }
        };
        let after: String = urdf.lines().map(|line| edit(line) + "\n").collect();
        assert_ne!(after, urdf, "{begin} {from}");
        urdf = after;
    }
    urdf
}

#[test]
fn a_robot_stands_on_soles_that_are_not_quite_mirror_images() {
    let urdf = edited(&[["<link name=\"right_foot\"", "-0.06\"", "-0.063\""]]);
    let (draft, scene) = drafted(&urdf, &Wishes::default()).unwrap();
    assert_stands(&scene);
    let knee = |name: &str| {
        let joint = scene.robot.model.joint_id(name).expect("a joint");
        scene.robot.home[joint - 1]
    };
    let apart = (knee("left_knee") - knee("right_knee")).abs();
    assert!(apart > 1e-3, "{}", draft.text);
}

#[test]
fn knees_are_bent_below_hips_with_inclined_axes() {
    let urdf = edited(&[
        ["<joint name=\"left_hip_pitch\"", "0 1 0", "0 0.71 0.7"],
        ["<joint name=\"right_hip_pitch\"", "0 1 0", "0 0.71 -0.7"],
    ]);
    let (draft, scene) = drafted(&urdf, &Wishes::default()).unwrap();
    assert_stands(&scene);
    let found = draft.found.join("\n");
    assert!(found.contains("Knees are bent"), "{found}");
}

#[test]
fn feet_below_ankles_whose_masses_differ_are_found() {
    let urdf = edited(&[[
        "<link name=\"left_ankle\"",
        "mass value=\"0.3\"",
        "mass value=\"0.22\"",
    ]]);
    let (draft, scene) = drafted(&urdf, &Wishes::default()).unwrap();
    assert_stands(&scene);
    assert_eq!(
        interface(&scene, "left_foot").0,
        "left_foot",
        "{}",
        draft.text
    );
}

#[test]
fn hands_are_before_the_body_and_palms_face_each_other() {
    for urdf in [g1(), Biped::default().urdf()] {
        let (draft, scene) = drafted(&urdf, &Wishes::default()).unwrap();
        let ([left, right], com) = standing(&scene, ["left_hand", "right_hand"]);
        let apart = left.origin() - right.origin();
        assert!(left.origin().x > com.x + 0.1, "{}", draft.text);
        assert!(apart.y > 0.1 && apart.y < 0.8, "{apart:?}");
        let normals = [&left, &right].map(|palm| palm.rotation().column(2).y);
        assert!(
            normals[0] < -0.8 && normals[1] > 0.8,
            "{normals:?}\n{}",
            draft.text
        );
    }
}

#[test]
fn a_robot_that_looks_along_another_axis_is_turned_in_scenes() {
    for (forward, axis, yaw) in [
        ([-1.0, 0.0], Forward::MinusX, PI),
        ([0.0, -1.0], Forward::MinusY, FRAC_PI_2),
        ([0.0, 1.0], Forward::Y, -FRAC_PI_2),
    ] {
        let biped = Biped {
            forward,
            ..Biped::default()
        };
        let (draft, scene) = drafted(&biped.urdf(), &Wishes::default()).unwrap();
        assert_stands(&scene);
        assert!((axis.yaw_to_x() - yaw).abs() < 1e-12 || (yaw == PI && axis.yaw_to_x() == -PI));
        let told = format!("looks along {}", axis.name());
        assert!(draft.doubts[0].contains(&told), "{:?}", draft.doubts);
        assert!(
            draft
                .text
                .contains(&format!("start.yaw = {:.5}", axis.yaw_to_x()))
        );
        let (link, pose, [x, y]) = interface(&scene, "left_foot");
        assert_eq!(link, "left_foot");
        let ahead = Vector3::new(forward[0], forward[1], 0.0);
        assert!((pose.rotation().column(0) - ahead).norm() < 1e-9);
        // 220 x 80 mm, of which 93 %.
        assert!(
            (x - 0.1023).abs() < 1e-3 && (y - 0.0372).abs() < 1e-3,
            "{x} {y}"
        );
        assert!((pose.origin() - (ahead * 0.05 - Vector3::z() * 0.08)).norm() < 1e-3);
    }
}

#[test]
fn knees_tell_front_from_back_where_soles_do_not_and_the_user_where_nothing_does() {
    let even = Biped {
        sole: [0.1, 0.1],
        ..Biped::default()
    };
    let (draft, _) = drafted(&even.urdf(), &Wishes::default()).unwrap();
    assert!(
        draft
            .found
            .iter()
            .any(|line| line.contains("forward: x (the knees")),
        "{:?}",
        draft.found
    );
    let both = Biped {
        knee: [-2.0, 2.0],
        ..even
    };
    let error = drafted(&both.urdf(), &Wishes::default()).unwrap_err();
    assert!(matches!(error, DraftError::NoFront { .. }), "{error}");
    let given = |forward| Wishes {
        forward: Some(forward),
        ..Wishes::default()
    };
    assert!(drafted(&both.urdf(), &given(Forward::MinusX)).is_ok());
    let error = drafted(&both.urdf(), &given(Forward::Y)).unwrap_err();
    assert!(error.to_string().contains("expected x or -x"), "{error}");
}

#[test]
fn robots_without_arms_have_feet_only() {
    let biped = Biped {
        arms: false,
        ..Biped::default()
    };
    let (draft, scene) = drafted(&biped.urdf(), &Wishes::default()).unwrap();
    assert_stands(&scene);
    assert!(!draft.text.contains("role = \"hand\""));
    assert!(
        draft
            .found
            .iter()
            .any(|line| line.starts_with("hands: none"))
    );
}

#[test]
fn four_legs_are_ambiguous_and_links_can_be_named() {
    let biped = Biped {
        more_legs: Some(0.5),
        ..Biped::default()
    };
    let error = drafted(&biped.urdf(), &Wishes::default()).unwrap_err();
    let message = error.to_string();
    for part in ["left_foot", "hind_right_foot", "--feet"] {
        assert!(message.contains(part), "{message}");
    }
    let feet = |a: &str, b: &str| Wishes {
        feet: Some([a.into(), b.into()]),
        ..Wishes::default()
    };
    let error = drafted(&Biped::default().urdf(), &feet("left_foot", "right_fot")).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("no link is called \"right_fot\""),
        "{error}"
    );
    let error = drafted(&Biped::default().urdf(), &feet("left_foot", "left_shin")).unwrap_err();
    assert!(matches!(error, DraftError::OneLimb { .. }), "{error}");
    let error = drafted(&Biped::default().urdf(), &feet("left_foot", "pelvis")).unwrap_err();
    assert!(matches!(error, DraftError::NotMoved { .. }), "{error}");
    let (draft, _) = drafted(&Biped::default().urdf(), &feet("right_foot", "left_foot")).unwrap();
    assert!(
        draft.found[1].starts_with("feet: left_foot, right_foot (as given)"),
        "{:?}",
        draft.found
    );
}

#[test]
fn a_robot_without_legs_and_a_foot_without_shape_are_refused() {
    let arm = "<robot name=\"arm\"><link name=\"a\"/><link name=\"b\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" \
               izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link><joint name=\"j\" type=\"continuous\"><parent link=\"a\"/>\
               <child link=\"b\"/><axis xyz=\"0 0 1\"/></joint></robot>";
    let error = drafted(arm, &Wishes::default()).unwrap_err();
    assert!(
        error.to_string().contains("found no feet") && error.to_string().contains("--feet"),
        "{error}"
    );
    let mut bare = Biped::default().urdf();
    for side in ["left", "right"] {
        let start = bare
            .find(&format!("<link name=\"{side}_foot\">"))
            .expect("the link");
        let from = start + bare[start..].find("<collision>").expect("its shape");
        let to = from + bare[from..].find("</collision>").expect("its end") + "</collision>".len();
        bare.replace_range(from..to, "");
    }
    let feet = Wishes {
        feet: Some(["left_foot".into(), "right_foot".into()]),
        forward: Some(Forward::X),
        ..Wishes::default()
    };
    let error = drafted(&bare, &feet).unwrap_err();
    assert!(
        error.to_string().contains("has no collision shape"),
        "{error}"
    );
    let broken = drafted("<robot", &Wishes::default()).unwrap_err();
    assert!(matches!(broken, DraftError::Scene(_)), "{broken}");
}

#[test]
fn legs_that_cannot_stand_level_are_told() {
    // Feet that are turned up and cannot be turned back.
    let stiff = Biped::default().urdf().replace(
        "<joint name=\"left_ankle_pitch\" type=\"revolute\"><parent link=\"left_shin\"/><child link=\"left_ankle\"/><origin xyz=\"",
        "<joint name=\"left_ankle_pitch\" type=\"revolute\"><parent link=\"left_shin\"/><child link=\"left_ankle\"/><origin rpy=\"0.3 0 0\" xyz=\"",
    );
    let locked = stiff.replace(
        "lower=\"-1.5\" upper=\"1.5\"",
        "lower=\"-0.01\" upper=\"0.01\"",
    );
    let error = drafted(
        &locked,
        &Wishes {
            feet: Some(["left_foot".into(), "right_foot".into()]),
            forward: Some(Forward::X),
            ..Wishes::default()
        },
    )
    .unwrap_err();
    let told = error.to_string();
    assert!(
        matches!(error, DraftError::NoStand { .. }) && told.contains("rad from level"),
        "{told}"
    );
}
