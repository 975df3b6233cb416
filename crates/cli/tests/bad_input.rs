//! Bad input ends with exit code 2 and a message that names the thing; never with a panic.

use crate::{locotamp, stderr, stdout};
use std::fs;

const SCENE: &str = r#"name = "test"
robot = "g1"

[[static]]
name = "ground"
plane = true

[[static]]
name = "table"
size = [0.3, 0.6, 0.03]
position = [0.6, 0.0, 0.735]

[[object]]
name = "crate"
mass = 1.0
size = [0.1, 0.25, 0.2]
on = "table_top"

[goal]
contacts = [["crate_bottom", "ground_top"]]
"#;

/// A URDF of a trunk and what follows it.
fn urdf(rest: &str) -> String {
    let inertia = r#"<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/>"#;
    format!(
        r#"<robot name="r"><link name="trunk"><inertial><mass value="8"/>{inertia}</inertial></link>{rest}</robot>"#
    )
}

fn joint(name: &str, parent: &str, child: &str) -> String {
    format!(
        r#"<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/><axis xyz="0 1 0"/>
        <limit lower="-1" upper="1" effort="30" velocity="5"/></joint>"#
    )
}

/// Runs `locotamp plan` on a scene file; returns its message.
fn refused(scene: &str, robot: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    fs::write(folder.path().join("robot.urdf"), robot).unwrap();
    let output = locotamp(folder.path(), &["plan", "scene.toml", "--out", "out"]);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(!message.contains("panicked"), "{message}");
    assert_eq!(stdout(&output), "", "{message}");
    assert!(
        !folder.path().join("out").exists(),
        "an unused folder stays"
    );
    message
}

/// Runs `locotamp plan` on the scene with one text replaced by another; returns its message.
fn spoiled(from: &str, to: &str) -> String {
    assert!(SCENE.contains(from), "{from}");
    refused(&SCENE.replacen(from, to, 1), "")
}

/// Asserts that a message has all these parts.
fn assert_says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "{part:?} is missing in:\n{message}");
    }
}

#[test]
fn an_unknown_body_is_named_with_its_line_and_the_nearest_name() {
    let message = spoiled("on = \"table_top\"", "on = \"tabel_top\"");
    assert_says(
        &message,
        &["tabel_top", "did you mean \"table_top\"?", "scene.toml:17"],
    );
}

#[test]
fn a_negative_mass_is_refused() {
    assert_says(
        &spoiled("mass = 1.0", "mass = -1.0"),
        &["-1", "positive", "scene.toml:15"],
    );
}

#[test]
fn a_mass_that_is_not_a_number_is_refused() {
    assert_says(
        &spoiled("mass = 1.0", "mass = nan"),
        &["NaN", "positive", "scene.toml:15"],
    );
}

#[test]
fn a_goal_that_names_nothing_is_refused() {
    let message = spoiled("\"crate_bottom\"", "\"create_bottom\"");
    assert_says(
        &message,
        &["create_bottom", "did you mean \"crate_bottom\"?"],
    );
}

#[test]
fn an_empty_goal_is_refused() {
    let message = spoiled("contacts = [[\"crate_bottom\", \"ground_top\"]]", "");
    assert_says(&message, &["asks for nothing"]);
}

#[test]
fn malformed_toml_is_shown_in_its_place() {
    assert_says(
        &spoiled("mass = 1.0", "mass = = 1.0"),
        &["malformed TOML", "scene.toml:15"],
    );
}

#[test]
fn a_missing_file_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for scene in ["nowhere.toml", "folder/nowhere", "."] {
        let output = locotamp(folder.path(), &["plan", scene]);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert_says(&stderr(&output), &["error: cannot read", scene]);
    }
    assert!(!folder.path().join("runs").exists());
}

#[test]
fn a_built_in_scene_that_does_not_exist_suggests_one() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        ["plan", "pick-plac"],
        ["symbols", "pick-plac"],
        ["scenes", "pick-plac"],
    ] {
        let output = locotamp(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(2));
        assert_says(
            &stderr(&output),
            &["pick-plac", "did you mean \"pick-place\"?"],
        );
    }
}

#[test]
fn a_urdf_with_a_loop_is_refused() {
    let link = |name| urdf_link(name);
    let rest = [
        link("a"),
        link("b"),
        joint("one", "trunk", "a"),
        joint("two", "trunk", "b"),
        joint("three", "a", "b"),
    ];
    let message = refused(
        &SCENE.replace("\"g1\"", "\"robot.urdf\""),
        &urdf(&rest.concat()),
    );
    assert_says(&message, &["robot.urdf", "\"b\""]);
}

#[test]
fn a_urdf_without_inertia_is_refused() {
    let rest = r#"<link name="a"/>"#.to_owned() + &joint("one", "trunk", "a");
    let message = refused(&SCENE.replace("\"g1\"", "\"robot.urdf\""), &urdf(&rest));
    assert_says(&message, &["robot.urdf", "\"a\""]);
}

fn urdf_link(name: &str) -> String {
    format!(
        r#"<link name="{name}"><inertial><mass value="1"/>
        <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>"#
    )
}

#[test]
fn bad_usage_ends_with_two() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [&[&str]; 6] = [
        &[],
        &["paln", "pick-place"],
        &["plan", "pick-place", "--time-limit", "-3"],
        &["plan", "pick-place", "--preset", "fast"],
        &["check", "plan.json", "--substeps", "0"],
        &["plan", "pick-place", "--solutions", "0"],
    ];
    for arguments in cases {
        let output = locotamp(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(
            stderr(&output).contains("Usage") || stderr(&output).contains("--help"),
            "{arguments:?}"
        );
    }
}

#[test]
fn no_solutions_at_all_cannot_be_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let output = locotamp(folder.path(), &["plan", "pick-place", "--solutions", "0"]);
    assert_eq!(output.status.code(), Some(2));
    assert_says(
        &stderr(&output),
        &["--solutions", "expected a whole number of at least 1"],
    );
}

#[test]
fn what_is_too_heavy_is_told_at_once_and_so_is_a_journal_that_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let handle = "mass = 60\ninterface = [{ name = \"handle\", side = \"+y\", position = [0, 0.125, 0], half_size = [0.03, 0.03], \
                  contacts = [\"bilateral_patch\"] }]";
    let scene = SCENE.replacen("mass = 1.0", handle, 1);
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let arguments = ["plan", "scene.toml", "--out", "out", "--resume"];
    let output = locotamp(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert_says(
        &stderr(&output),
        &["note: nothing to resume", "journal.jsonl", "begins anew"],
    );
    assert_says(
        &stdout(&output),
        &[
            "0 sequences tried",
            "every order of grasps and places needs contacts that are impossible",
            "too heavy: crate weighs 588.6 N (60 kg), left_hand holding handle bears at most 60.0 N",
            "at most 6.11 kg",
        ],
    );
    let output = locotamp(folder.path(), &arguments);
    assert!(!stderr(&output).contains("resume"), "{}", stderr(&output));
}

#[test]
fn an_effort_limit_below_zero_is_refused_with_joint_and_value() {
    let rest =
        urdf_link("a") + &joint("one", "trunk", "a").replace("effort=\"30\"", "effort=\"-30\"");
    let message = refused(&SCENE.replace("\"g1\"", "\"robot.urdf\""), &urdf(&rest));
    assert_says(
        &message,
        &[
            "robot.urdf",
            "joint \"one\"",
            "-30",
            "expected a positive number",
        ],
    );
}

#[test]
fn a_plan_file_that_cannot_be_read_ends_with_two() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("broken.json"), "{").unwrap();
    fs::write(
        folder.path().join("other.json"),
        "{\"format\": \"locotamp.plan/9\"}",
    )
    .unwrap();
    let cases = [
        ("missing.json", "No such file"),
        ("broken.json", "EOF"),
        ("other.json", "locotamp.plan/9"),
    ];
    for (file, part) in cases {
        let output = locotamp(folder.path(), &["check", file]);
        assert_eq!(output.status.code(), Some(2), "{file}");
        assert_says(&stderr(&output), &["error: ", file, part]);
    }
}

#[test]
fn machines_get_the_error_as_an_object() {
    let folder = tempfile::tempdir().unwrap();
    let output = locotamp(folder.path(), &["plan", "nowhere.toml", "--json"]);
    let value: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(value["status"], "error");
    assert!(value["reason"].as_str().unwrap().contains("nowhere.toml"));
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    let output = locotamp(folder.path(), &["plan", "pick-place", "--out", "file/out"]);
    assert_eq!(output.status.code(), Some(2));
    assert_says(&stderr(&output), &["file/out"]);
}
