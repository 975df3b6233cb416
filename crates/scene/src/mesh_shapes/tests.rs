//! Meshes that are written for the test, and what becomes of the URDF that names them.

use super::*;
use crate::Scene;
use multibody::{Model, Root};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// An STL file of a block with one corner at the origin.
fn block_stl(size: [f64; 3]) -> String {
    let corner = |code: usize| -> [f64; 3] {
        std::array::from_fn(|k| if code >> k & 1 == 0 { 0.0 } else { size[k] })
    };
    let mut text = String::from("solid block\n");
    for [a, b, c, d] in [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ] {
        for triangle in [[a, b, c], [a, c, d]] {
            text += "facet normal 0 0 0\nouter loop\n";
            for [x, y, z] in triangle.map(corner) {
                writeln!(text, "vertex {x} {y} {z}").unwrap();
            }
            text += "endloop\nendfacet\n";
        }
    }
    text + "endsolid block\n"
}

const INERTIAL: &str =
    r#"<inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>"#;

fn mesh(tag: &str, name: &str, rest: &str) -> String {
    format!("<{tag}><geometry><mesh filename=\"{name}\" {rest}/></geometry></{tag}>")
}

fn robot(body: &str) -> String {
    format!("<robot name=\"r\"><link name=\"foot\">{INERTIAL}{body}</link></robot>")
}

/// What becomes of a URDF beside `block.stl`, 0.2 × 0.1 × 0.04, and `small.stl`, half of that.
fn fitted(urdf: &str) -> MeshShapes {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("block.stl"), block_stl([0.2, 0.1, 0.04])).unwrap();
    fs::write(
        folder.path().join("small.stl"),
        block_stl([0.1, 0.05, 0.02]),
    )
    .unwrap();
    fs::write(folder.path().join("broken.stl"), "solid").unwrap();
    let folders = MeshFolders {
        urdf: Some(folder.path().into()),
        ..MeshFolders::default()
    };
    with_fitted_shapes(urdf, &folders, &[])
}

/// Boxes of the only link: centre and half size.
fn boxes(urdf: &str) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let model = Model::from_urdf(urdf, Root::Floating).unwrap();
    let shapes = model.frames[0].shapes.iter();
    let sides = shapes.filter_map(|placed| match placed.shape {
        multibody::Shape::Box { half_size } => Some((placed.frame_from_shape.origin(), half_size)),
        _ => None,
    });
    sides.collect()
}

#[track_caller]
fn assert_near(found: &Vector3<f64>, wanted: [f64; 3]) {
    assert!((found - Vector3::from(wanted)).amax() < 1e-5, "{found}");
}

#[test]
fn the_mesh_of_a_collision_element_becomes_a_box_at_its_place_and_scale() {
    let origin = r#"<collision><origin xyz="0 0 1" rpy="0 0 1.5707963267948966"/>"#;
    let placed = mesh("collision", "block.stl", "scale=\"1 -1 1\"");
    let fitted = fitted(&robot(&placed.replace("<collision>", origin)));
    let [(centre, half_size)] = boxes(&fitted.urdf)[..] else {
        panic!("{}", fitted.urdf);
    };
    assert_near(&centre, [0.05, 0.1, 1.02]);
    assert_near(&half_size, [0.05, 0.1, 0.02]);
    assert!(!fitted.urdf.contains("<mesh"), "{}", fitted.urdf);
    assert!(fitted.unread.is_empty());
    assert!(fitted.notes[0].contains("the meshes of 1 link: "));
}

#[test]
fn a_visual_mesh_counts_where_nothing_but_spheres_collides_and_stays_in_the_text() {
    let visual = mesh("visual", "block.stl", "");
    let sphere = "<collision><geometry><sphere radius=\"0.01\"/></geometry></collision>".to_owned();
    let cuboid = "<collision><geometry><box size=\"1 1 1\"/></geometry></collision>".to_owned();
    for body in [visual.clone(), visual.clone() + &sphere] {
        let fitted = fitted(&robot(&body)).urdf;
        assert_eq!(boxes(&fitted).len(), 1, "{fitted}");
        assert!(fitted.contains(&visual), "{fitted}");
    }
    let given = robot(&(visual + &cuboid));
    assert_eq!(fitted(&given).urdf, given);
}

#[test]
fn a_mesh_inside_the_shape_of_another_one_adds_nothing() {
    let both = mesh("collision", "small.stl", "") + &mesh("collision", "block.stl", "");
    let fitted = fitted(&robot(&both));
    let [(_, half_size)] = boxes(&fitted.urdf)[..] else {
        panic!("{}", fitted.urdf);
    };
    assert_near(&half_size, [0.1, 0.05, 0.02]);
}

#[test]
fn what_is_fitted_survives_the_text_with_all_corners_inside() {
    for turn in 0..20 {
        let angles = [0.7, 1.3, 2.9].map(|x| x * f64::from(turn));
        let rotation = rotation_from_rpy(&Vector3::from(angles));
        let place = Pose::from_parts(rotation, Vector3::new(0.123_456_789, -0.3, 0.5));
        let block = block_stl([0.31, 0.17, 0.11]);
        let corners: Vec<_> = block
            .lines()
            .filter_map(|line| line.strip_prefix("vertex "))
            .map(|line| {
                let numbers: Vec<f64> = line.split(' ').map(|x| x.parse().unwrap()).collect();
                place.act(Vector3::from_row_slice(&numbers))
            })
            .collect();
        let text = robot(&element(&crate::fit::enclose(&corners, None)));
        let model = Model::from_urdf(&text, Root::Floating).unwrap();
        let read = &model.frames[0].shapes[0];
        let multibody::Shape::Box { half_size } = read.shape else {
            panic!("{text}");
        };
        let read = PlacedShape {
            body_from_shape: read.frame_from_shape,
            shape: Shape::Box { half_size },
        };
        assert!(
            corners.iter().all(|corner| contains(&read, corner)),
            "{text}"
        );
    }
}

#[test]
fn meshes_that_are_missing_or_broken_stay_and_are_told() {
    let text = robot(&mesh("collision", "package://p/gone.stl", ""));
    let gone = fitted(&text);
    assert_eq!((gone.urdf, gone.unread), (text, vec!["foot".to_owned()]));
    for words in ["package://p/gone.stl", "1 links", "meshes = "] {
        assert!(gone.notes[0].contains(words), "{:?}", gone.notes);
    }
    let broken = fitted(&robot(&mesh("collision", "broken.stl", "")));
    assert_eq!(broken.unread, ["foot"]);
    assert!(broken.notes[0].contains("broken.stl"), "{:?}", broken.notes);
}

/// A scene in a folder of its own, whose robot is a foot with a mesh; `key` is a line of the scene.
fn scene(key: &str, mesh_at: Option<&str>) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write(
        "robot.urdf",
        &robot(&mesh("collision", "package://p/block.stl", "")),
    );
    if let Some(place) = mesh_at {
        let file = folder.path().join(place);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, block_stl([0.2, 0.1, 0.04])).unwrap();
    }
    let text = format!(
        "name = \"s\"\nrobot = \"robot.urdf\"\n{key}\n[[robot_interface]]\nname = \"sole\"\nlink = \"foot\"\nkind = \"patch\"\n\
         role = \"foot\"\npose = [0.1, 0.05, 0, 1, 0, 0, 0]\nhalf_size = [0.08, 0.04]\ncontacts = [\"unilateral_patch\"]\n\
         [[static]]\nname = \"ground\"\nplane = true\n[objective]\nkind = \"base_height\"\n"
    );
    Scene::from_toml(&text, "scene.toml", folder.path()).unwrap()
}

#[test]
fn a_scene_has_the_fitted_shape_in_its_robot_and_in_the_text_for_the_plan() {
    for (key, place) in [
        ("", "p/block.stl"),
        ("meshes = \"there\"", "there/block.stl"),
    ] {
        let scene = scene(key, Some(place));
        let Shape::Box { half_size } = scene.robot.shapes[0][0].shape else {
            panic!("{:?}", scene.robot.shapes);
        };
        assert_near(&half_size, [0.1, 0.05, 0.02]);
        assert_eq!(boxes(&scene.robot.urdf).len(), 1);
    }
}

#[test]
fn a_foot_whose_mesh_is_missing_gets_a_thin_box_above_its_sole() {
    let scene = scene("", None);
    let Shape::Box { half_size } = scene.robot.shapes[0][0].shape else {
        panic!("{:?}", scene.robot.shapes);
    };
    assert_near(&half_size, [0.08, 0.04, 0.005]);
    let [(centre, in_text)] = boxes(&scene.robot.urdf)[..] else {
        panic!("{}", scene.robot.urdf);
    };
    // The normal points down: behind the patch is up.
    assert_near(&centre, [0.1, 0.05, 0.005]);
    assert_near(&in_text, half_size.into());
    let notes = scene.notes().join("\n");
    assert!(notes.contains("1 patches of feet and hands"), "{notes}");
}

#[test]
fn text_is_added_to_elements_with_and_without_an_end_tag() {
    for (before, after) in [
        ("<r><a x='1'/></r>", "<r><a x='1'>new</a></r>"),
        ("<r><a><b/></a></r>", "<r><a><b/>new</a></r>"),
        ("<r><a></a ></r>", "<r><a>new</a ></r>"),
    ] {
        let document = Document::parse(before).unwrap();
        let node = child(document.root_element(), "a").unwrap();
        let mut edits = Edits::default();
        edits.append(node, before, "new".into());
        assert_eq!(edits.apply(before), after);
    }
}

#[test]
fn a_folder_of_meshes_that_is_not_there_is_refused() {
    let text =
        "name = \"s\"\nrobot = \"g1\"\nmeshes = \"gone\"\n[objective]\nkind = \"base_height\"\n";
    let error = Scene::from_toml(text, "scene.toml", Path::new("")).unwrap_err();
    let message = error.to_string();
    assert!(
        message.contains("there is no folder gone"),
        "{message}, {error:?}"
    );
}

#[test]
fn flat_cylinders_become_boxes_and_those_of_capsules_stay() {
    let collision = |z: f64, geometry: &str| {
        format!("<collision><origin xyz=\"0 0 {z}\"/><geometry>{geometry}</geometry></collision>")
    };
    let cylinder = |length: f64| format!("<cylinder radius=\"0.1\" length=\"{length}\"/>");
    let disc = robot(&collision(0.5, &cylinder(0.04)));
    let shapes = fitted(&disc);
    let [(centre, half)] = boxes(&shapes.urdf)[..] else {
        panic!("{}", shapes.urdf);
    };
    assert!((centre - Vector3::new(0.0, 0.0, 0.5)).norm() < 1e-9);
    assert!((half - Vector3::new(0.1, 0.1, 0.02)).norm() < 1e-9);
    assert!(shapes.notes[0].contains("1 cylinder"), "{:?}", shapes.notes);
    let ball = "<sphere radius=\"0.1\"/>";
    let capsule = [
        collision(0.0, &cylinder(0.04)),
        collision(-0.02, ball),
        collision(0.02, ball),
    ];
    for unchanged in [
        robot(&collision(0.5, &cylinder(0.3))),
        robot(&capsule.concat()),
    ] {
        assert_eq!(fitted(&unchanged).urdf, unchanged);
    }
}
