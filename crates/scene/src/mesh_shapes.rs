//! Collision shapes of links that have meshes: boxes and capsules around them, written into the URDF text.
//!
//! The text itself is changed, so that whoever reads a plan sees what was planned with. A link's meshes are those of its collision
//! elements; if it has none, or only spheres (corner spheres are not a foot), those of its visual elements too.
//!
//! Cylinders that are flatter than they are wide become boxes: readers that take cylinders as capsules of the same length make a ball
//! of their radius of those.

use crate::fit::contains;
use crate::mesh_path::MeshFolders;
use crate::robot::CAPSULE_PLAY;
use crate::split::{Triangle, fit};
use crate::urdf_text::{Edits, child, children, vector};
use crate::{Interface, Owner, PlacedShape, Robot, Shape};
use multibody::{rotation_from_rpy, rpy_from_rotation};
use nalgebra::{Matrix3, Vector3};
use roxmltree::{Document, Node};
use spatial::Pose;
use std::ops::Range;

/// Half thickness of the box behind the patch of a foot or hand whose meshes are not there [m].
const PATCH_DEPTH: f64 = 0.005;

/// A robot's description with shapes instead of meshes.
#[derive(Debug, Default)]
pub(crate) struct MeshShapes {
    pub urdf: String,
    /// What was fitted and what is missing, as sentences.
    pub notes: Vec<String>,
    /// Links with meshes that could not be read.
    pub unread: Vec<String>,
    /// Triangles of the meshes that links collide with, by the name of the link, in its frame.
    pub meshes: Vec<(String, Vec<Triangle>)>,
}

/// A mesh of a link that was read.
struct Part {
    /// Where its collision element stands in the text; `None` for a visual one, which stays.
    element: Option<Range<usize>>,
    triangles: Vec<Triangle>,
    shapes: Vec<PlacedShape>,
}

/// Why the meshes of links were not read.
#[derive(Default)]
struct Missing {
    links: Vec<String>,
    not_found: Vec<String>,
    broken: Vec<String>,
}

/// Axes (columns, in the link's frame) along which shapes of a link are to be, by its name.
pub(crate) type Axes = (String, Matrix3<f64>);

/// The text of a URDF with boxes and capsules instead of the meshes that links collide with, as far as their files are found; along
/// `axes` of a link if it has any, so that a sole stays flat. A text that cannot be read is left as it is.
pub(crate) fn with_fitted_shapes(urdf: &str, folders: &MeshFolders, axes: &[Axes]) -> MeshShapes {
    let mut edits = Edits::default();
    let mut missing = Missing::default();
    let mut fitted_links = 0;
    let mut fitted = Vec::new();
    let mut discs = 0;
    let mut meshes = Vec::new();
    if let Ok(document) = Document::parse(urdf) {
        for link in children(document.root_element(), "link") {
            let mut parts = read_parts(link, (folders, axes), &mut missing);
            drop_contained(&mut parts);
            fitted_links += usize::from(!parts.is_empty());
            for part in parts {
                let elements = part.shapes.iter().map(element).collect();
                match part.element {
                    Some(range) => edits.replace(range, elements),
                    None => edits.append(link, urdf, elements),
                }
                fitted.extend(part.shapes);
                let link = link.attribute("name").unwrap_or_default();
                meshes.push((link.to_owned(), part.triangles));
            }
            for (disc, size) in flat_cylinders(link) {
                edits.replace(disc.range(), format!("<box size=\"{size}\"/>"));
                discs += 1;
            }
        }
    }
    let mut notes = Vec::new();
    if fitted_links > 0 {
        let round = |placed: &&PlacedShape| matches!(placed.shape, Shape::Capsule { .. });
        let capsules = fitted.iter().filter(round).count();
        notes.push(format!(
            "collision shapes are fitted around the meshes of {}: {}, {}",
            counted(fitted_links, "link", "links"),
            counted(fitted.len() - capsules, "box", "boxes"),
            counted(capsules, "capsule", "capsules"),
        ));
    }
    if discs > 0 {
        notes.push(format!(
            "{} flatter than wide: read as boxes around them",
            counted(discs, "cylinder is", "cylinders are")
        ));
    }
    notes.extend(missing.notes());
    MeshShapes {
        urdf: edits.apply(urdf),
        notes,
        unread: missing.links,
        meshes,
    }
}

fn counted(n: usize, one: &str, more: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { more })
}

impl Missing {
    fn notes(&self) -> Vec<String> {
        let mut notes = self.broken.clone();
        if let Some(first) = self.not_found.first() {
            notes.push(format!(
                "{} mesh files of {} links were not found (the first: {first:?}); name the folder of the robot's package as \
                 meshes = \"...\", or in ROS_PACKAGE_PATH",
                self.not_found.len(),
                self.links.len()
            ));
        }
        notes
    }
}

/// The meshes of a link that collide, with what was fitted around each.
fn read_parts(
    link: Node,
    (folders, axes): (&MeshFolders, &[Axes]),
    missing: &mut Missing,
) -> Vec<Part> {
    let named = |(of, _): &&Axes| link.attribute("name") == Some(of);
    let patch = axes.iter().find(named).map(|(_, axes)| axes);
    let geometry =
        |node: Node, tag: &str| child(node, "geometry").is_some_and(|g| child(g, tag).is_some());
    let spheres = children(link, "collision").all(|node| geometry(node, "sphere"));
    let visuals = children(link, "visual").filter(|_| spheres);
    let mut parts = Vec::new();
    for node in children(link, "collision").chain(visuals) {
        let mesh = child(node, "geometry").and_then(|g| child(g, "mesh"));
        let Some((mesh, name)) = mesh.and_then(|m| Some((m, m.attribute("filename")?))) else {
            continue;
        };
        let triangles = match folders.find(name) {
            Some(path) => triangles(node, mesh, &path),
            None => Err(None),
        };
        match triangles {
            Ok(triangles) => parts.push(Part {
                element: node.has_tag_name("collision").then(|| node.range()),
                shapes: fit(&triangles, patch),
                triangles,
            }),
            Err(what) => {
                let link = link.attribute("name").unwrap_or_default().to_owned();
                match what {
                    Some(what) => missing
                        .broken
                        .push(format!("link {link:?}: mesh {name:?} is {what}")),
                    None => missing.not_found.push(name.to_owned()),
                }
                if !missing.links.contains(&link) {
                    missing.links.push(link);
                }
            }
        }
    }
    parts
}

/// The cylinders of a link's collision elements that are flatter than they are wide, with the sides of the boxes around them. Not
/// those of the radius of a ball of the link, which may be a capsule's.
fn flat_cylinders<'a, 'i>(link: Node<'a, 'i>) -> Vec<(Node<'a, 'i>, String)> {
    let of_shape = |tag: &'static str| {
        let elements = children(link, "collision").filter_map(|node| child(node, "geometry"));
        elements.filter_map(move |geometry| child(geometry, tag))
    };
    let length = |node: Node, attribute: &str| -> Option<f64> {
        node.attribute(attribute)?.trim().parse().ok()
    };
    let balls: Vec<f64> = of_shape("sphere")
        .filter_map(|ball| length(ball, "radius"))
        .collect();
    let sides = |cylinder: Node| {
        let (radius, length) = (length(cylinder, "radius")?, length(cylinder, "length")?);
        let of_capsule = balls
            .iter()
            .any(|ball| (ball - radius).abs() < CAPSULE_PLAY);
        let flat = length > 0.0 && length < 2.0 * radius && radius.is_finite();
        let size = Vector3::new(2.0 * radius, 2.0 * radius, length);
        (flat && !of_capsule).then(|| numbers(&size, 6))
    };
    of_shape("cylinder")
        .filter_map(|cylinder| Some((cylinder, sides(cylinder)?)))
        .collect()
}

/// The triangles of an element's mesh in the link's frame, at least one.
///
/// # Errors
/// What is wrong with the file.
fn triangles(
    element: Node,
    mesh: Node,
    path: &std::path::Path,
) -> Result<Vec<Triangle>, Option<String>> {
    let scale = vector(mesh, "scale").unwrap_or(Vector3::repeat(1.0));
    let origin = child(element, "origin");
    let part = |attribute| origin.and_then(|node| vector(node, attribute));
    let rpy = part("rpy").unwrap_or_default();
    let link_from_mesh = Pose::from_parts(rotation_from_rpy(&rpy), part("xyz").unwrap_or_default());
    let mut triangles = Vec::new();
    for group in mesh::load(path, &scale).map_err(Some)? {
        let corner = |i: &u32| link_from_mesh.act(group.places[*i as usize]);
        let faces = group.faces.iter();
        triangles.extend(faces.map(|[a, b, c]| [corner(a), corner(b), corner(c)]));
    }
    if triangles.is_empty() {
        return Err(Some("empty: there is no triangle in it".into()));
    }
    Ok(triangles)
}

/// Takes the shapes away from parts that lie wholly inside one shape of another part.
fn drop_contained(parts: &mut [Part]) {
    for i in 0..parts.len() {
        let inside = |shape: &PlacedShape| {
            let mut corners = parts[i].triangles.iter().flatten();
            corners.all(|corner| contains(shape, corner))
        };
        let others = (0..parts.len()).filter(|j| *j != i);
        if others.flat_map(|j| &parts[j].shapes).any(inside) {
            parts[i].shapes.clear();
        }
    }
}

/// Gives the feet and hands of links whose meshes are missing, and that nothing else stands for, a thin box behind their patches.
pub(crate) fn give_patches_shapes<'a>(
    robot: &mut Robot,
    interfaces: impl Iterator<Item = &'a Interface>,
    unread: &[String],
) {
    let frames = &robot.model.frames;
    let carries = |joint: Option<usize>, has: &dyn Fn(usize) -> bool| {
        (0..frames.len()).any(|f| frames[f].joint == joint && has(f))
    };
    let mut boxes = Vec::new();
    for interface in interfaces {
        let (Owner::Robot { frame }, Some([x, y])) = (interface.owner, interface.half_size) else {
            continue;
        };
        let joint = frames[frame].joint;
        if carries(joint, &|f| !robot.shapes[f].is_empty())
            || !carries(joint, &|f| unread.contains(&frames[f].name))
        {
            continue;
        }
        let behind = Pose::from_translation(0.0, 0.0, -PATCH_DEPTH);
        boxes.push((
            frame,
            PlacedShape {
                body_from_shape: interface.body_from_interface * behind,
                shape: Shape::Box {
                    half_size: Vector3::new(x, y, PATCH_DEPTH),
                },
            },
        ));
    }
    if !boxes.is_empty() {
        robot.model.notes.push(format!(
            "{} patches of feet and hands without meshes have a box of {} mm behind them",
            boxes.len(),
            2e3 * PATCH_DEPTH
        ));
    }
    for (frame, placed) in boxes {
        let name = &robot.model.frames[frame].name;
        let mut edits = Edits::default();
        if let Ok(document) = Document::parse(&robot.urdf) {
            let mut links = children(document.root_element(), "link");
            if let Some(link) = links.find(|link| link.attribute("name") == Some(name)) {
                edits.append(link, &robot.urdf, element(&placed));
            }
        }
        robot.urdf = edits.apply(&robot.urdf);
        robot.shapes[frame].push(placed);
    }
}

/// The collision elements of a shape: URDF has no capsule, so that is a cylinder with a sphere at either end.
fn element(placed: &PlacedShape) -> String {
    let pose = &placed.body_from_shape;
    let at = |z: f64, geometry: &str| {
        let xyz = numbers(&pose.act(Vector3::new(0.0, 0.0, z)), 6);
        let rpy = numbers(&rpy_from_rotation(pose.rotation()), 9);
        format!(
            "<collision><origin xyz=\"{xyz}\" rpy=\"{rpy}\"/><geometry>{geometry}</geometry></collision>"
        )
    };
    match &placed.shape {
        Shape::Box { half_size } => {
            let size = numbers(&(half_size * 2.0), 6);
            at(0.0, &format!("<box size=\"{size}\"/>"))
        }
        Shape::Capsule {
            radius,
            half_length,
        } => {
            let (r, length) = (number(*radius, 6), number(2.0 * half_length, 6));
            let ball = format!("<sphere radius=\"{r}\"/>");
            [
                at(
                    0.0,
                    &format!("<cylinder radius=\"{r}\" length=\"{length}\"/>"),
                ),
                at(-half_length, &ball),
                at(*half_length, &ball),
            ]
            .concat()
        }
        Shape::Sphere { radius } => {
            at(0.0, &format!("<sphere radius=\"{}\"/>", number(*radius, 6)))
        }
        Shape::HalfSpace => String::new(),
    }
}

fn numbers(vector: &Vector3<f64>, decimals: i32) -> String {
    let words: Vec<_> = vector.iter().map(|x| number(*x, decimals)).collect();
    words.join(" ")
}

/// The number with so many decimals at most.
fn number(x: f64, decimals: i32) -> String {
    let unit = 10f64.powi(decimals);
    // Adding 0 makes −0 and 0 equal.
    ((x * unit).round() / unit + 0.0).to_string()
}

#[cfg(test)]
mod tests;
