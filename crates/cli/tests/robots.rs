//! `locotamp robot` from outside.

use crate::{locotamp, refused, stderr, stdout};
use std::fs;

/// The built-in robot's URDF as a file of a fresh folder.
fn with_urdf() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let urdf = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/g1.urdf");
    fs::copy(urdf, folder.path().join("my_g1.urdf")).unwrap();
    folder
}

#[test]
fn a_robot_file_is_written_told_of_and_usable_in_a_scene() {
    let folder = with_urdf();
    let output = locotamp(folder.path(), &["robot", "my_g1.urdf", "--name", "mine"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let told = stdout(&output);
    for part in [
        "feet: left_ankle_roll_link, right_ankle_roll_link",
        "hands: left_rubber_hand, right_rubber_hand",
        "forward: x",
        "wrote my_g1.toml",
        "check: ",
    ] {
        assert!(told.contains(part), "{told}");
    }
    let text = fs::read_to_string(folder.path().join("my_g1.toml")).unwrap();
    assert!(
        text.contains("name = \"mine\"\nurdf = \"my_g1.urdf\""),
        "{text}"
    );
    let scene = "name = \"s\"\nrobot = \"my_g1.toml\"\n[[static]]\nname = \"ground\"\nplane = true\n\
                 [objective]\nkind = \"base_height\"\n";
    fs::write(folder.path().join("s.toml"), scene).unwrap();
    let output = locotamp(folder.path(), &["symbols", "s.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

#[test]
fn nothing_is_written_over_without_force() {
    let folder = with_urdf();
    let mine = folder.path().join("mine.toml");
    fs::write(&mine, "by hand").unwrap();
    let arguments = ["robot", "my_g1.urdf", "--out", "mine.toml"];
    assert!(refused(folder.path(), &arguments).contains("--force"));
    assert_eq!(fs::read_to_string(&mine).unwrap(), "by hand");
    let forced = [&arguments[..], &["--force"]].concat();
    let output = locotamp(folder.path(), &forced);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(
        fs::read_to_string(&mine)
            .unwrap()
            .starts_with("# g1: drafted")
    );
}

#[test]
fn what_cannot_be_drafted_is_refused_with_the_remedy() {
    let folder = with_urdf();
    for (arguments, part) in [
        (&["gone.urdf"][..], "cannot read gone.urdf"),
        (
            &["my_g1.urdf", "--feet", "left_foot,right_foot"],
            "no link is called \"left_foot\"",
        ),
        (
            &["my_g1.urdf", "--feet", "left_ankle_roll_link"],
            "two links",
        ),
        (&["my_g1.urdf", "--forward", "y"], "expected x or -x"),
        (&["my_g1.urdf", "--meshes", "nowhere"], "no such folder"),
        (&["my_g1.urdf", "--out", "mine.json"], "ends in .toml"),
        (&["g1"], "ends in .urdf or .xml"),
    ] {
        let message = refused(folder.path(), &[&["robot"], arguments].concat());
        assert!(message.contains(part), "{message}");
    }
    assert!(!folder.path().join("my_g1.toml").exists());
}
