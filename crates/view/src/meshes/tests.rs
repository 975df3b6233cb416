//! Files to surfaces: kinds, scales, what is missing or broken, what does not fit.

use super::surface::tests::cube;
use super::*;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// A cube of edge 2 as binary STL.
fn binary_stl() -> Vec<u8> {
    let (places, faces) = cube();
    let mut bytes = vec![b' '; 80];
    bytes.extend((faces.len() as u32).to_le_bytes());
    for face in faces {
        bytes.extend([0; 12]);
        for corner in face {
            for x in &places[corner as usize] {
                bytes.extend((*x as f32).to_le_bytes());
            }
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn text_stl() -> String {
    let (places, faces) = cube();
    let mut text = String::from("solid cube\n");
    for face in faces {
        text += "facet normal 0 0 0\nouter loop\n";
        for corner in face {
            let x = places[corner as usize];
            writeln!(text, "vertex {} {} {}", x.x, x.y, x.z).unwrap();
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid cube\n"
}

fn obj() -> String {
    let (places, faces) = cube();
    let mut text = String::new();
    for x in places {
        writeln!(text, "v {} {} {}", x.x, x.y, x.z).unwrap();
    }
    for [a, b, c] in faces {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    text
}

/// A red square in centimetres, turned by 90° about z, then moved 0.2 m up: `indices` of its corners.
fn dae(indices: &str) -> String {
    format!(
        r##"<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_effects><effect id="paint"><profile_COMMON><technique sid="common"><lambert><diffuse><color>1 0 0 1</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="red" name="red"><instance_effect url="#paint"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="12">0 0 0 100 0 0 100 50 0 0 50 0</float_array><technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="1" material="m"><input semantic="VERTEX" source="#v" offset="0"/><vcount>4</vcount><p>{indices}</p></polylist></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><matrix>1 0 0 0 0 1 0 0 0 0 1 20 0 0 0 1</matrix><node><rotate>0 0 1 90</rotate>
<instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="m" target="#red"/></technique_common></bind_material></instance_geometry></node></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"##
    )
}

/// A URDF of one link with these meshes: name and scale.
fn urdf(meshes: &[(&str, &str)]) -> String {
    let mut visuals = String::new();
    for (name, scale) in meshes {
        let scale = if scale.is_empty() {
            String::new()
        } else {
            format!(" scale=\"{scale}\"")
        };
        let geometry = format!("<geometry><mesh filename=\"{name}\"{scale}/></geometry>");
        write!(visuals, "<visual>{geometry}</visual>").unwrap();
    }
    format!("<robot name=\"r\"><link name=\"l\">{visuals}</link></robot>")
}

fn loaded(folder: &Path, urdf: &str) -> Meshes {
    Meshes::load([urdf], &[folder.to_owned()], Meshes::PAGE)
}

/// Extent of the only surface of a mesh.
fn extent(meshes: &Meshes, name: &str, scale: [f64; 3]) -> [Vector3<f64>; 2] {
    let [part] = meshes.parts(name, &scale.into()) else {
        panic!("{name}: {:?}", meshes.warnings())
    };
    let places = &meshes.surfaces[part.surface].places;
    let all = places.iter().fold(places[0], |low, x| low.inf(x));
    [all, places.iter().fold(all, |high, x| high.sup(x))]
}

#[test]
fn a_cube_is_the_same_from_every_kind_of_file() {
    let folder = tempfile::tempdir().unwrap();
    let names = ["binary.stl", "text.STL", "cube.obj"];
    fs::write(folder.path().join(names[0]), binary_stl()).unwrap();
    fs::write(folder.path().join(names[1]), text_stl()).unwrap();
    fs::write(folder.path().join(names[2]), obj()).unwrap();
    let meshes = loaded(folder.path(), &urdf(&names.map(|name| (name, ""))));
    assert_eq!(meshes.warnings(), [""; 0]);
    assert_eq!(meshes.state(), State::Drawn([36, 36]));
    assert_eq!(meshes.surfaces.len(), 3);
    assert!(meshes.surfaces.iter().all(|x| *x == meshes.surfaces[0]));
    assert_eq!(meshes.surfaces[0].places.len(), 8);
    let [low, high] = extent(&meshes, "text.STL", [1.0; 3]);
    assert_eq!((low, high), (Vector3::repeat(-1.0), Vector3::repeat(1.0)));
}

#[test]
fn scales_make_other_sizes_and_mirrored_parts_share_theirs() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("arm.stl"), binary_stl()).unwrap();
    let name = "package://robot/arm.stl";
    let scales = ["0.001 0.001 0.002", "0.001 -0.001 0.002", ""];
    let meshes = loaded(folder.path(), &urdf(&scales.map(|scale| (name, scale))));
    let [_, high] = extent(&meshes, name, [0.001, 0.001, 0.002]);
    assert!((high - Vector3::new(0.001, 0.001, 0.002)).norm() < 1e-15);
    let parts = |scale: [f64; 3]| meshes.parts(name, &scale.into());
    assert_eq!(parts([0.001, 0.001, 0.002]), parts([0.001, -0.001, 0.002]));
    assert_ne!(parts([0.001, 0.001, 0.002]), parts([1.0; 3]));
    assert_eq!(meshes.surfaces.len(), 2);
}

#[test]
fn collada_brings_its_unit_its_place_and_its_colour() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.dae"), dae("0 1 2 3")).unwrap();
    let meshes = loaded(folder.path(), &urdf(&[("a.dae", "")]));
    let [low, high] = extent(&meshes, "a.dae", [1.0; 3]);
    assert!((low - Vector3::new(-0.5, 0.0, 0.2)).norm() < 1e-6, "{low}");
    assert!((high - Vector3::new(0.0, 1.0, 0.2)).norm() < 1e-6, "{high}");
    let [part] = meshes.parts("a.dae", &Vector3::repeat(1.0)) else {
        panic!("one part")
    };
    assert_eq!(part.color, Some([1.0, 0.0, 0.0]));
}

#[test]
fn what_cannot_be_read_is_named_once_with_its_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    let (binary, text) = (binary_stl(), text_stl());
    write("short.stl", &binary[..binary.len() - 33]);
    write("cut.stl", &text.as_bytes()[..text.len() / 2]);
    write("empty.obj", b"# nothing\n");
    write("wrong.dae", dae("0 1 7 3").as_bytes());
    write("cut.dae", &dae("0 1 2 3").as_bytes()[..900]);
    write("nan.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write("far.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    write("it.fbx", b"");
    let names = [
        "short.stl",
        "cut.stl",
        "empty.obj",
        "wrong.dae",
        "cut.dae",
        "nan.obj",
        "far.obj",
        "it.fbx",
        "http://host/a.stl",
        "package://r/gone.stl",
        "package://r/lost.stl",
    ];
    let meshes = loaded(folder.path(), &urdf(&names.map(|name| (name, ""))));
    assert_eq!(meshes.surfaces, []);
    let warnings = meshes.warnings();
    assert_eq!(warnings.len(), 10, "{warnings:#?}");
    let all = warnings.join("\n");
    for name in &names[..9] {
        let mine = warnings.iter().filter(|x| x.contains(&format!("{name:?}")));
        assert_eq!(mine.count(), 1, "{name} in {all}");
    }
    for what in [
        "it.fbx: of a kind that is not read: .stl, .obj and .dae are",
        "a corner that is not there",
        "no number",
        "no triangle",
        "http:// is not read",
    ] {
        assert!(all.contains(what), "{what} in {all}");
    }
    let last = &warnings[9];
    assert!(
        last.starts_with("2 meshes (the first: \"package://r/gone.stl\") are not below "),
        "{last}"
    );
    assert!(
        last.ends_with("give the folder of the robot's package with --meshes; drawn without"),
        "{last}"
    );
}

#[test]
fn meshes_are_simplified_to_the_budget_or_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let ball = simplify::tests::ball(0.3, 60);
    let mut text = String::new();
    for x in &ball.places {
        writeln!(text, "v {} {} {}", x.x, x.y, x.z).unwrap();
    }
    for [a, b, c] in &ball.faces {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    fs::write(folder.path().join("ball.obj"), text).unwrap();
    let urdf = urdf(&[("ball.obj", "")]);
    let folders = [folder.path().to_owned()];
    let within = |budget| Meshes::load([urdf.as_str()], &folders, budget);
    let small = within(8000);
    let State::Drawn([all, left]) = small.state() else {
        panic!("{:?}", small.state())
    };
    assert_eq!(all, ball.faces.len());
    assert!(left > 500 && left < all, "{left}");
    let [data] = &small.data()[..] else {
        panic!("one surface")
    };
    let coded = data.places.len() + data.faces.len();
    assert!(coded <= 8000 && coded > 7800, "{coded}");
    let none = within(200);
    assert_eq!(none.state(), State::TooLarge(200));
    assert_eq!(none.parts("ball.obj", &Vector3::repeat(1.0)), []);
    assert!(
        none.warnings()[0].contains("do not fit"),
        "{:?}",
        none.warnings()
    );
}

#[test]
fn nobody_asked_nothing_said() {
    let none = Meshes::default();
    assert_eq!((none.state(), none.warnings().len()), (State::NotAsked, 0));
}
