//! Mesh files: STL (binary and text), OBJ, Collada.

use crate::collada::{self, Group};
use mesh_loader::Loader;
use nalgebra::Vector3;
use std::borrow::Cow;
use std::path::Path;
use std::{fs, io};

/// Larger files are not read [bytes].
const LARGEST: u64 = 100_000_000;

/// Before the number of triangles of a binary STL [bytes].
const BINARY_STL_HEADER: usize = 80;
/// No corner is further away than that [m].
const FARTHEST: f64 = 1e6;

/// The parts of a file, their numbers multiplied with `scale`.
///
/// # Errors
/// The file is too large, of another kind, or broken: what is wrong.
pub fn load(path: &Path, scale: &Vector3<f64>) -> Result<Vec<Group>, String> {
    let bytes = read(path).map_err(|error| error.to_string())?;
    let groups = parse(path, &bytes).map_err(|what| match what {
        Fault::Kind => "of a kind that is not read: .stl, .obj and .dae are".to_owned(),
        Fault::Broken(what) => format!("broken: {what}"),
    })?;
    let scaled = groups.into_iter().map(|group| scaled(group, scale));
    scaled
        .collect::<Result<_, _>>()
        .map_err(|what| format!("broken: {what}"))
}

fn read(path: &Path) -> io::Result<Vec<u8>> {
    let about = fs::metadata(path)?;
    if !about.is_file() {
        return Err(io::Error::other("not a file"));
    }
    if about.len() > LARGEST {
        let [size, largest] = [about.len(), LARGEST].map(|x| x / 1_000_000);
        return Err(io::Error::other(format!(
            "{size} MB, more than the {largest} MB that are read; simplify it"
        )));
    }
    fs::read(path)
}

enum Fault {
    Kind,
    Broken(String),
}

fn parse(path: &Path, bytes: &[u8]) -> Result<Vec<Group>, Fault> {
    let loader = Loader::default();
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    let scene = match ending.to_lowercase().as_str() {
        "stl" => loader.load_stl_from_slice(&unlike_text(bytes), path),
        "obj" => loader.load_obj_from_slice_with_reader(bytes, path, read),
        "dae" => {
            return collada::groups(&String::from_utf8_lossy(bytes)).map_err(Fault::Broken);
        }
        _ => return Err(Fault::Kind),
    };
    let scene = scene.map_err(|error| Fault::Broken(error.to_string()))?;
    let colors = scene.materials.iter().map(|x| x.color.diffuse);
    let colors = colors.chain(std::iter::repeat(None));
    let groups = scene.meshes.into_iter().zip(colors).map(|(mesh, color)| {
        let places = mesh.vertices.iter().map(|x| x.map(f64::from).into());
        Group {
            places: places.collect(),
            faces: mesh.faces,
            color: color.map(|[r, g, b, _]| [r, g, b].map(f64::from)),
        }
    });
    Ok(groups.collect())
}

/// A binary STL with an empty header: some programs begin it with `solid`, which readers take for text. Text has no bytes that are
/// zero; the last byte of the number of triangles is.
fn unlike_text(stl: &[u8]) -> Cow<'_, [u8]> {
    if stl.starts_with(b"solid") && stl.get(BINARY_STL_HEADER + 3) == Some(&0) {
        let mut binary = stl.to_vec();
        binary[..BINARY_STL_HEADER].fill(0);
        return binary.into();
    }
    stl.into()
}

/// The group in metres; corners are finite, and those of triangles are there.
fn scaled(mut group: Group, scale: &Vector3<f64>) -> Result<Group, String> {
    for place in &mut group.places {
        // Adding 0 makes −0 and 0 equal.
        *place = place.component_mul(scale).add_scalar(0.0);
    }
    if !group.places.iter().flatten().all(|x| x.abs() < FARTHEST) {
        return Err("a corner is no number, or a thousand kilometres away".into());
    }
    let known = |corner: &u32| (*corner as usize) < group.places.len();
    if !group.faces.iter().flatten().all(known) {
        return Err("a triangle has a corner that is not there".into());
    }
    Ok(group)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_stl_is_binary_though_its_header_says_solid_and_text_where_it_is() {
        let triangle = [[0.0_f32; 3], [0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        let mut binary = b"solid foot".to_vec();
        binary.resize(80, b' ');
        binary.extend(1_u32.to_le_bytes());
        binary.extend(triangle.iter().flatten().flat_map(|x| x.to_le_bytes()));
        binary.extend([0, 0]);
        let text = "solid foot\n facet normal 0 0 0\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   \
                    vertex 0 2 0\n  endloop\n endfacet\nendsolid foot\n";
        for bytes in [&binary[..], text.as_bytes()] {
            let groups = parse(Path::new("foot.stl"), bytes);
            let groups = groups.unwrap_or_else(|_| panic!("it is read"));
            assert_eq!(groups[0].faces.len(), 1);
            assert!(groups[0].places.contains(&Vector3::new(0.0, 2.0, 0.0)));
        }
    }
}
