//! Collision shapes of links that have meshes: boxes and capsules around them, written into the URDF text.
//!
//! The text itself is changed, so that whoever reads a plan sees what was planned with. A link's meshes are those of its collision
//! elements; if it has none, or only spheres (corner spheres are not a foot), those of its visual elements too.

use crate::fit::contains;
use crate::mesh_path::MeshFolders;
use crate::split::{Triangle, fit};
use crate::{Interface, Owner, PlacedShape, Robot, Shape};
use multibody::{rotation_from_rpy, rpy_from_rotation};
use nalgebra::Vector3;
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

/// The text of a URDF with boxes and capsules instead of the meshes that links collide with, as far as their files are found. A text
/// that cannot be read is left as it is.
pub(crate) fn with_fitted_shapes(urdf: &str, folders: &MeshFolders) -> MeshShapes {
    let mut edits = Edits::default();
    let mut missing = Missing::default();
    let mut fitted_links = 0;
    let mut fitted = Vec::new();
    if let Ok(document) = Document::parse(urdf) {
        for link in children(document.root_element(), "link") {
            let mut parts = read_parts(link, folders, &mut missing);
            drop_contained(&mut parts);
            fitted_links += usize::from(!parts.is_empty());
            for part in parts {
                let elements = part.shapes.iter().map(element).collect();
                match part.element {
                    Some(range) => edits.replace(range, elements),
                    None => edits.append(link, urdf, elements),
                }
                fitted.extend(part.shapes);
            }
        }
    }
    let mut notes = Vec::new();
    if fitted_links > 0 {
        let round = |placed: &&PlacedShape| matches!(placed.shape, Shape::Capsule { .. });
        let capsules = fitted.iter().filter(round).count();
        notes.push(format!(
            "{fitted_links} links have collision shapes fitted around their meshes: {} boxes, {capsules} capsules",
            fitted.len() - capsules
        ));
    }
    notes.extend(missing.notes());
    MeshShapes {
        urdf: edits.apply(urdf),
        notes,
        unread: missing.links,
    }
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
fn read_parts(link: Node, folders: &MeshFolders, missing: &mut Missing) -> Vec<Part> {
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
                shapes: fit(&triangles),
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

/// Changes of a text, each of a stretch of it.
#[derive(Default)]
struct Edits(Vec<(Range<usize>, String)>);

impl Edits {
    fn replace(&mut self, range: Range<usize>, text: String) {
        self.0.push((range, text));
    }

    /// Adds text to the end of an element of the document `whole`.
    fn append(&mut self, node: Node, whole: &str, text: String) {
        let (range, tag) = (node.range(), node.tag_name().name());
        match whole[range.clone()].strip_suffix("/>") {
            Some(open) if !node.has_children() => {
                let end = range.start + open.len();
                self.replace(end..range.end, format!(">{text}</{tag}>"));
            }
            _ => {
                let before_end = whole[range.clone()].rfind("</").unwrap_or(0);
                let end = range.start + before_end;
                self.replace(end..end, text);
            }
        }
    }

    fn apply(mut self, text: &str) -> String {
        self.0.sort_by_key(|(range, _)| (range.start, range.end));
        let (mut out, mut done) = (String::new(), 0);
        for (range, new) in self.0 {
            out += &text[done..range.start];
            out += &new;
            done = range.end;
        }
        out + &text[done..]
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

fn children<'a, 'i, 't>(
    node: Node<'a, 'i>,
    tag: &'t str,
) -> impl Iterator<Item = Node<'a, 'i>> + use<'a, 'i, 't> {
    node.children().filter(move |x| x.has_tag_name(tag))
}

fn child<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    children(node, tag).next()
}

/// Three finite numbers.
fn vector(node: Node, attribute: &str) -> Option<Vector3<f64>> {
    let words = node.attribute(attribute)?.split_whitespace();
    let numbers: Vec<f64> = words.map(|word| word.parse().ok()).collect::<Option<_>>()?;
    let vector = Vector3::from_row_slice(numbers.get(..3)?);
    (numbers.len() == 3 && vector.iter().all(|x| x.is_finite())).then_some(vector)
}

#[cfg(test)]
mod tests;
