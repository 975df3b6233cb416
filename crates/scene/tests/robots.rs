//! Robots from files: bare URDFs and robot files.

use scene::{Fault, Objective, Owner, Scene, Shape};
use std::path::{Path, PathBuf};
use symbolic::ContactType;

fn test_scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/scenes")
        .join(name)
}

#[test]
fn a_bare_urdf_gets_its_interfaces_from_the_scene() {
    let scene = Scene::load(test_scene("hopper.toml")).unwrap_or_else(|e| panic!("{}", e.render()));
    assert_eq!(scene.robot.name, "hopper");
    assert_eq!(scene.objective, Objective::BaseHeight);
    assert_eq!(scene.robot.model.gravity, scene.gravity);
    // on the block (0.2 m), the foot 0.4 m below the leg, which is 0.1 m below the trunk and drawn in by 0.1 m
    assert!((scene.start[2] - 0.6).abs() < 1e-12);
    assert_eq!(scene.start[7..], [0.1, 0.0]);
    assert_eq!(scene.robot.home, [0.1, 0.0]);
    let names: Vec<&str> = scene.interfaces.iter().map(|i| i.name.as_str()).collect();
    assert_eq!(names, ["foot", "finger", "ground_top", "block_top"]);
    let contact = scene.start_contacts[0];
    assert_eq!(
        (contact.a.0, contact.b.0, scene.start_contacts.len()),
        (0, 3, 1)
    );
}

#[test]
fn limits_and_friction_of_robot_interfaces_are_read() {
    let scene = Scene::load(test_scene("hopper.toml")).unwrap();
    let finger = &scene.interfaces[1];
    assert!(!finger.patch && finger.half_size.is_none());
    assert_eq!((finger.max_force, finger.mu), (20.0, 0.9));
    assert_eq!(finger.max_moment, f64::INFINITY);
    assert_eq!(scene.interfaces[0].mu, 0.5);
    assert_eq!(scene.interfaces[3].mu, 0.4);
    let id = |name: &str| scene.interface_id(name).unwrap();
    let point = ContactType::UnilateralPoint;
    assert!(scene.contact_possible(id("finger"), id("block_top"), point));
    assert!(!scene.contact_possible(id("foot"), id("block_top"), point));
    assert!(
        matches!(finger.owner, Owner::Robot { frame } if scene.robot.model.frames[frame].name == "arm")
    );
}

#[test]
fn capsules_are_put_together_cylinders_boxed_and_meshes_noted() {
    let scene = Scene::load(test_scene("hopper.toml")).unwrap();
    let model = &scene.robot.model;
    let shapes = |link: &str| {
        let frame = model.frames.iter().position(|f| f.name == link).unwrap();
        &scene.robot.shapes[frame]
    };
    let capsule = Shape::Capsule {
        radius: 0.03,
        half_length: 0.15,
    };
    assert_eq!(shapes("leg").len(), 1);
    assert_eq!(shapes("leg")[0].shape, capsule);
    let Shape::Box { half_size } = shapes("arm")[0].shape else {
        panic!("{:?}", shapes("arm"));
    };
    assert_eq!(half_size.as_slice(), [0.02, 0.02, 0.2]);
    assert!(
        model
            .notes
            .iter()
            .any(|note| note.contains("no other shape: pad;"))
    );
}

/// Writes files into a fresh folder and loads `scene.toml` from it.
fn load_from_folder(files: &[(&str, &str)]) -> Result<Scene, scene::SceneError> {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    Scene::load(folder.path().join("scene.toml"))
}

const SCENE: &str = "name = \"s\"\nrobot = \"robot.toml\"\n[[static]]\nname = \"ground\"\nplane = true\n[objective]\nkind = \"base_height\"\n";

const ROBOT: &str = "name = \"r\"\nurdf = \"robot.urdf\"\n[home]\nslide = 0.2\n[[interface]]\nname = \"foot\"\nlink = \"leg\"\nkind = \"patch\"\nrole = \"foot\"\npose = [0, 0, -0.4, 1, 0, 0, 0]\nhalf_size = [0.1, 0.05]\ncontacts = [\"unilateral_patch\"]\n";

fn urdf() -> String {
    std::fs::read_to_string(test_scene("hopper.urdf")).unwrap()
}

#[test]
fn a_robot_file_gives_home_and_interfaces() {
    let files = [
        ("scene.toml", SCENE),
        ("robot.toml", ROBOT),
        ("robot.urdf", &urdf()),
    ];
    let scene = load_from_folder(&files).unwrap();
    assert_eq!(scene.robot.name, "r");
    assert_eq!(scene.start[7..], [0.2, 0.0]);
    assert!((scene.start[2] - 0.3).abs() < 1e-12);
}

/// The robot file with torque at speed for some joints.
fn with_torque_speed(table: &str) -> String {
    ROBOT.replacen(
        "[[interface]]",
        &format!("[[torque_speed]]\n{table}\n[[interface]]"),
        1,
    )
}

#[test]
fn torque_at_speed_is_given_to_the_joints_that_fit() {
    let robot = with_torque_speed("joints = [\"sl*\"]\ncorner = 0.5\nno_load = 4");
    let files = [
        ("scene.toml", SCENE),
        ("robot.toml", robot.as_str()),
        ("robot.urdf", &urdf()),
    ];
    let scene = load_from_folder(&files).unwrap();
    let found = scene.robot.model.joints.iter().map(|joint| {
        let line = joint.torque_speed.as_ref();
        (
            joint.name.as_str(),
            line.map(|line| [line.corner, line.no_load]),
        )
    });
    let found: Vec<_> = found.filter(|(_, line)| line.is_some()).collect();
    assert_eq!(found, [("slide", Some([0.5, 4.0]))]);
}

#[test]
fn faults_of_torque_at_speed_say_what_is_wrong() {
    let cases = [
        (
            "joints = [\"slid\"]\ncorner = 1",
            "robot.toml:6: torque_speed: no moving joint is called \"slid\"; did you mean \"slide\"?",
        ),
        (
            "joints = [\"slide\"]\ncorner = 0",
            "robot.toml:7: corner of torque_speed is 0 rad/s, expected a positive number",
        ),
        (
            "joints = [\"slide\", \"s*\"]\ncorner = 0.5\nno_load = 4",
            "robot.toml:6: torque_speed of joint \"slide\": given twice; leave one out",
        ),
        (
            "joints = [\"slide\"]\ncorner = 5\nno_load = 4",
            "robot.toml:7: torque_speed of joint \"slide\": corner is 5 rad/s, expected less than 4 rad/s",
        ),
        (
            "joints = [\"slide\"]\nspeed = 5",
            "robot.toml:7: unknown key \"speed\"",
        ),
    ];
    for (table, expected) in cases {
        let robot = with_torque_speed(table);
        let files = [
            ("scene.toml", SCENE),
            ("robot.toml", robot.as_str()),
            ("robot.urdf", &urdf()),
        ];
        let message = load_from_folder(&files).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn faults_of_a_robot_file_name_the_robot_file() {
    let cases = [
        (
            "slide = 0.2",
            "slide = 0.9",
            "robot.toml:4: joint \"slide\" starts at 0.9",
        ),
        (
            "slide = 0.2",
            "slid = 0.2",
            "robot.toml:4: robot: no moving joint is called \"slid\"; did you mean \"slide\"?",
        ),
        (
            "link = \"leg\"",
            "link = \"legs\"",
            "robot.toml:7: interface \"foot\": no link is called \"legs\"; did you mean \"leg\"?",
        ),
        (
            "urdf = \"robot.urdf\"",
            "urdf = \"missing.urdf\"",
            "robot.toml:2: cannot read",
        ),
        (
            "half_size = [0.1, 0.05]\n",
            "",
            "robot.toml:6: interface \"foot\": expected half_size",
        ),
        (
            "\"patch\"",
            "\"point\"",
            "robot.toml:11: interface \"foot\": a point has no half_size",
        ),
        (
            "1, 0, 0, 0]",
            "1, 1, 0, 0]",
            "robot.toml:10: quaternion [x, y, z, w] of interface \"foot\" is [1.0, 1.0, 0.0, 0.0] of length 1.4142",
        ),
        (
            "half_size",
            "limb = [0, 0, 0]\nhalf_size",
            "robot.toml:11: interface \"foot\": limb has no length",
        ),
        (
            "[home]",
            "[hom]",
            "robot.toml:3: unknown key \"hom\"; did you mean \"home\"?",
        ),
    ];
    for (piece, replacement, expected) in cases {
        assert!(ROBOT.contains(piece));
        let robot = ROBOT.replacen(piece, replacement, 1);
        let files = [
            ("scene.toml", SCENE),
            ("robot.toml", robot.as_str()),
            ("robot.urdf", &urdf()),
        ];
        let message = load_from_folder(&files).unwrap_err().to_string();
        assert!(
            message.contains(expected),
            "{message}\nexpected: {expected}"
        );
    }
}

#[test]
fn bad_urdfs_are_refused_with_the_reason_at_the_line_that_names_them() {
    let good = urdf();
    let cases = [
        (good.replace("</robot>", ""), "malformed XML"),
        (good.replace("link=\"leg\"", "link=\"lag\""), "no link \"lag\""),
        (good.replacen("<mass value=\"8\"/>", "<mass value=\"-8\"/>", 1), "mass is -8 kg"),
        (
            good.replace("</robot>", "<joint name=\"loop\" type=\"fixed\"><parent link=\"leg\"/><child link=\"arm\"/></joint></robot>"),
            "cut the loop",
        ),
        (good.replacen("<limit lower=\"0.05\" upper=\"0.3\" effort=\"500\" velocity=\"3\"/>", "", 1), "needs <limit"),
    ];
    for (text, expected) in cases {
        let files = [
            ("scene.toml", SCENE),
            ("robot.toml", ROBOT),
            ("robot.urdf", text.as_str()),
        ];
        let error = load_from_folder(&files).unwrap_err();
        assert!(matches!(error.fault(), Fault::Robot { .. }), "{error}");
        let message = error.to_string();
        assert!(
            message.contains("robot.toml:2: robot \"robot.toml\": "),
            "{message}"
        );
        assert!(
            message.contains(expected),
            "{message}\nexpected: {expected}"
        );
    }
}

#[test]
fn a_urdf_without_inertia_is_refused() {
    let text = urdf().replace("<mass value=\"0.5\"/>", "<mass value=\"0\"/>");
    let files = [
        ("scene.toml", SCENE),
        ("robot.toml", ROBOT),
        ("robot.urdf", text.as_str()),
    ];
    let message = load_from_folder(&files).unwrap_err().to_string();
    assert!(message.contains("mass"), "{message}");
}

#[test]
fn a_robot_without_interfaces_is_refused() {
    let scene = SCENE.replace("robot.toml", "robot.urdf");
    let files = [("scene.toml", scene.as_str()), ("robot.urdf", &urdf())];
    let message = load_from_folder(&files).unwrap_err().to_string();
    assert!(
        message.contains("scene.toml:2: robot: it has no interfaces"),
        "{message}"
    );
}

#[test]
fn a_robot_without_feet_is_told_that_it_has_none() {
    let robot = ROBOT.replace("role = \"foot\"", "role = \"hand\"");
    let urdf = urdf();
    let files = [
        ("scene.toml", SCENE),
        ("robot.toml", robot.as_str()),
        ("robot.urdf", urdf.as_str()),
    ];
    let message = load_from_folder(&files).unwrap_err().to_string();
    assert!(message.contains("no interface with role"), "{message}");
}

#[test]
fn a_posture_that_names_a_locked_joint_is_told_that_it_is_locked() {
    let still = r#"<limit lower="0.2" upper="0.2" effort="30" velocity="5"/>"#;
    let urdf = urdf().replace(
        r#"<limit lower="-1" upper="1" effort="30" velocity="5"/>"#,
        still,
    );
    assert!(urdf.contains(still));
    let robot = ROBOT.replace("slide = 0.2", "shoulder = 0.1");
    let files = [
        ("scene.toml", SCENE),
        ("robot.toml", robot.as_str()),
        ("robot.urdf", urdf.as_str()),
    ];
    let message = load_from_folder(&files).unwrap_err().to_string();
    assert!(
        message.contains("\"shoulder\" cannot move and is locked at 0.2"),
        "{message}"
    );
}

#[test]
fn missing_files_are_named() {
    let message = Scene::load("no/such/scene.toml").unwrap_err().to_string();
    assert!(
        message.starts_with("cannot read no/such/scene.toml: "),
        "{message}"
    );
    let message = load_from_folder(&[("scene.toml", SCENE)])
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("scene.toml:2: cannot read") && message.contains("robot.toml"),
        "{message}"
    );
}

#[test]
fn scenes_beside_the_builtin_ones_are_the_files_of_the_repository() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    for name in Scene::builtin_names() {
        let scene = Scene::load(folder.join(format!("{name}.toml"))).unwrap();
        assert_eq!(scene.start, Scene::builtin(name).unwrap().start);
    }
}

/// A leg that slides in a trunk, standing in its keyframe, and what stands for its foot.
const MJCF: &str = r#"<mujoco model="pogo"><worldbody><body name="trunk" pos="0 0 1"><freejoint/>
  <geom type="box" size="0.1 0.1 0.05" mass="4"/>
  <body name="leg"><joint name="reach" type="slide" axis="0 0 -1" range="0 0.2"/>
    <geom type="capsule" size="0.03" fromto="0 0 -0.1 0 0 -0.4" mass="1"/>
    <site name="sole" pos="0 0 -0.43" euler="180 0 0"/></body></body></worldbody>
  <actuator><motor joint="reach" gear="100" ctrlrange="-1 1"/></actuator>
  <keyframe><key name="home" qpos="0 0 1 1 0 0 0 0.1"/></keyframe></mujoco>"#;

fn mjcf_scene(robot: &str) -> Result<Scene, scene::SceneError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("pogo.xml"), robot).unwrap();
    let text = r#"
        name = "s"
        robot = "pogo.xml"
        [[robot_interface]]
        name = "foot"
        link = "sole"
        kind = "patch"
        role = "foot"
        pose = [0, 0, 0, 0, 0, 0, 1]
        half_size = [0.05, 0.05]
        contacts = ["unilateral_patch"]
        [[static]]
        name = "ground"
        plane = true
        [objective]
        kind = "base_height"
    "#;
    Scene::from_toml(text, "s.toml", folder.path())
}

#[test]
fn an_mjcf_stands_on_its_sites_as_in_its_keyframe() {
    let scene = mjcf_scene(MJCF).unwrap_or_else(|e| panic!("{}", e.render()));
    assert_eq!(scene.robot.name, "pogo");
    assert!((scene.start[2] - 0.53).abs() < 1e-9, "{:?}", scene.start);
    assert_eq!(scene.start[7..], [0.1]);
    let joint = &scene.robot.model.joints[1];
    assert_eq!((joint.torque_limit, joint.upper), (100.0, 0.2));
    let notes = scene.robot.model.notes.join("\n");
    assert!(notes.contains("no limits of speed"), "{notes}");
    assert!(scene.robot.urdf.starts_with("<robot name=\"pogo\""));
    let leg = scene.robot.model.frame_id("leg").unwrap();
    let [capsule] = &scene.robot.shapes[leg][..] else {
        panic!("{:?}", scene.robot.shapes[leg]);
    };
    let Shape::Capsule { half_length, .. } = capsule.shape else {
        panic!("{capsule:?}");
    };
    assert!((half_length - 0.15).abs() < 1e-9);
}

#[test]
fn a_mistake_in_an_mjcf_is_told_with_its_file() {
    let ball = MJCF.replace("type=\"slide\" axis=\"0 0 -1\"", "type=\"ball\"");
    let error = mjcf_scene(&ball).unwrap_err();
    assert!(matches!(error.fault(), Fault::Mjcf { .. }), "{error}");
    let text = error.render();
    assert!(
        text.contains("pogo.xml") && text.contains("no body with joints"),
        "{text}"
    );
    let negative = mjcf_scene(&MJCF.replace("mass=\"4\"", "mass=\"-4\"")).unwrap_err();
    let text = negative.to_string();
    assert!(
        text.contains("as a URDF") && text.contains("\"trunk\""),
        "{text}"
    );
}
