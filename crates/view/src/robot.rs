//! What the robot looks like: its tree of joints and the shapes on them.
//!
//! Shapes are the URDF's visual primitives and meshes with their colours; of a link without any, its collision primitives.
//! Meshes are files outside the plan. Where they were not read, a link that has nothing else is drawn as rods from its joint
//! to the joints behind it.

use crate::meshes::{Meshes, State};
use multibody::{Frame, Model, PlacedShape, Shape};
use nalgebra::{Matrix3, Vector3};
use roxmltree::{Document, Node};
use spatial::Pose;
use std::collections::BTreeMap;

/// Colour of shapes without a material, red, green, blue.
const PLAIN: [f64; 3] = [0.72, 0.74, 0.78];

/// Radius of the rods of links without primitive shapes [m].
const ROD: f64 = 0.025;

/// A shape on a link of the robot.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Look {
    /// Index into the model's frames.
    pub frame: usize,
    pub frame_from_shape: Pose,
    pub form: Form,
    /// Red, green, blue, from 0 to 1.
    pub color: [f64; 3],
}

/// What is drawn.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Form {
    /// A primitive shape.
    Primitive(Shape),
    /// A surface of [`Meshes`] by index, its axes mirrored where these are −1.
    Surface { index: usize, mirror: [f64; 3] },
}

/// Shapes of a robot, and what was replaced, as sentences.
pub(crate) fn looks(model: &Model, urdf: &str, meshes: &Meshes) -> (Vec<Look>, Vec<String>) {
    let visuals = visuals(urdf);
    let (mut looks, mut rods) = (Vec::new(), 0);
    for (frame, link) in model.frames.iter().enumerate() {
        let found = visuals.get(&link.name).map_or(&[][..], Vec::as_slice);
        let had_mesh = found.iter().any(|x| is_mesh(&x.placed)) || link.shapes.iter().any(is_mesh);
        let mut shapes: Vec<_> = found
            .iter()
            .flat_map(|x| drawn(&x.placed, x.color, frame, meshes))
            .collect();
        if shapes.is_empty() {
            let none = Meshes::default();
            let collision = link.shapes.iter();
            shapes.extend(collision.flat_map(|x| drawn(x, None, frame, &none)));
        }
        if shapes.is_empty() && had_mesh {
            let rod = skeleton(model, frame, link);
            shapes.extend(rod.iter().flat_map(|x| drawn(x, None, frame, meshes)));
            rods += 1;
        }
        looks.extend(shapes);
    }
    (looks, notes(rods, meshes.state()))
}

/// A shape as it is drawn: a primitive as itself, a mesh as its surfaces, as nothing where it was not read.
fn drawn(
    placed: &PlacedShape,
    color: Option<[f64; 3]>,
    frame: usize,
    meshes: &Meshes,
) -> Vec<Look> {
    let look = |form, color: Option<_>| Look {
        frame,
        frame_from_shape: placed.frame_from_shape,
        form,
        color: color.unwrap_or(PLAIN),
    };
    let Shape::Mesh { filename, scale } = &placed.shape else {
        return vec![look(Form::Primitive(placed.shape.clone()), color)];
    };
    let mirror = [0, 1, 2].map(|k| scale[k].signum());
    let parts = meshes.parts(filename, scale).iter();
    let surface = |index| Form::Surface { index, mirror };
    parts
        .map(|part| look(surface(part.surface), color.or(part.color)))
        .collect()
}

fn notes(rods: usize, state: State) -> Vec<String> {
    let links = if rods == 1 { "link has" } else { "links have" };
    let rods = (rods > 0).then(|| match state {
        State::NotAsked => format!(
            "{rods} {links} only meshes, which are not in the plan file: drawn as rods; `locotamp view --meshes DIR` draws them"
        ),
        State::Drawn(_) => {
            format!("{rods} {links} only meshes that were not found or not read: drawn as rods")
        }
        State::TooLarge(_) => format!("{rods} {links} only meshes: drawn as rods"),
    });
    let whole = match state {
        State::TooLarge(size) => Some(format!(
            "The robot's meshes do not fit into {:.1} MB, so they are not drawn",
            size as f64 / 1e6
        )),
        State::Drawn([all, left]) if left < all => Some(format!(
            "The robot's meshes are simplified, {left} of {all} triangles"
        )),
        _ => None,
    };
    rods.into_iter().chain(whole).collect()
}

fn is_mesh(placed: &PlacedShape) -> bool {
    matches!(placed.shape, Shape::Mesh { .. })
}

/// Rods from a link to all joints that hang on it, a ball if there are none.
fn skeleton(model: &Model, index: usize, link: &Frame) -> Vec<PlacedShape> {
    let frame_from_joint = link.joint_from_frame.inverse();
    let is_main = model.frames.iter().position(|x| x.joint == link.joint) == Some(index);
    let behind = model
        .joints
        .iter()
        .filter(|x| x.parent == link.joint && is_main);
    let ends = behind.map(|x| frame_from_joint.act(x.parent_from_joint.origin()));
    let mut rods: Vec<_> = ends.filter(|end| end.norm() > 1e-6).map(rod).collect();
    if rods.is_empty() {
        rods.push(PlacedShape {
            frame_from_shape: Pose::identity(),
            shape: Shape::Sphere { radius: 1.4 * ROD },
        });
    }
    rods
}

fn rod(end: Vector3<f64>) -> PlacedShape {
    let z = end.normalize();
    let away = if z.x.abs() < 0.9 {
        Vector3::x()
    } else {
        Vector3::y()
    };
    let x = away.cross(&z).normalize();
    PlacedShape {
        frame_from_shape: Pose::from_parts(Matrix3::from_columns(&[x, z.cross(&x), z]), end / 2.0),
        shape: Shape::Capsule {
            radius: ROD,
            half_length: end.norm() / 2.0,
        },
    }
}

/// A visual shape of a link.
#[derive(Debug, Clone)]
struct Visual {
    placed: PlacedShape,
    /// Red, green, blue; `None`: the URDF gives none.
    color: Option<[f64; 3]>,
}

type Visuals = BTreeMap<String, Vec<Visual>>;

/// The mesh files that the visual shapes of a URDF name, with their scales.
pub(crate) fn mesh_names(urdf: &str) -> Vec<(String, Vector3<f64>)> {
    let visuals = visuals(urdf);
    let shapes = visuals.into_values().flatten().map(|x| x.placed.shape);
    let mesh = |shape| match shape {
        Shape::Mesh { filename, scale } => Some((filename, scale)),
        _ => None,
    };
    shapes.filter_map(mesh).collect()
}

/// Visual shapes by link. The text has been read as a URDF before, so what cannot be read here is left out.
fn visuals(urdf: &str) -> Visuals {
    let Ok(document) = Document::parse(urdf) else {
        return Visuals::new();
    };
    let root = document.root_element();
    let materials: BTreeMap<&str, [f64; 3]> = children(root, "material")
        .filter_map(|node| Some((node.attribute("name")?, color(node)?)))
        .collect();
    let mut visuals = Visuals::new();
    for link in children(root, "link") {
        let shapes = children(link, "visual").filter_map(|node| visual(node, &materials));
        visuals.insert(
            link.attribute("name").unwrap_or("").to_owned(),
            shapes.collect(),
        );
    }
    visuals
}

fn children<'a, 'i: 'a>(
    node: Node<'a, 'i>,
    tag: &'static str,
) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.has_tag_name(tag))
}

fn visual(node: Node, materials: &BTreeMap<&str, [f64; 3]>) -> Option<Visual> {
    let geometry = children(node, "geometry").next()?;
    let shape = shape(geometry.children().find(Node::is_element)?)?;
    let material = children(node, "material").next();
    let named = || materials.get(material?.attribute("name")?).copied();
    let color = material.and_then(color).or_else(named);
    let frame_from_shape = children(node, "origin")
        .next()
        .map_or_else(Pose::identity, origin);
    let placed = PlacedShape {
        frame_from_shape,
        shape,
    };
    Some(Visual { placed, color })
}

fn shape(node: Node) -> Option<Shape> {
    let number = |name| {
        node.attribute(name)
            .and_then(|x| x.trim().parse::<f64>().ok())
    };
    let (radius, half_length) = (number("radius"), number("length").map(|x| x / 2.0));
    Some(match node.tag_name().name() {
        "box" => Shape::Box {
            half_size: numbers(node.attribute("size"))? / 2.0,
        },
        "sphere" => Shape::Sphere { radius: radius? },
        "cylinder" => Shape::Cylinder {
            radius: radius?,
            half_length: half_length?,
        },
        "capsule" => Shape::Capsule {
            radius: radius?,
            half_length: half_length?,
        },
        "mesh" => Shape::Mesh {
            filename: node.attribute("filename")?.to_owned(),
            scale: numbers(node.attribute("scale")).unwrap_or(Vector3::repeat(1.0)),
        },
        _ => return None,
    })
}

/// Fixed axes: roll about x, then pitch about y, then yaw about z.
fn origin(node: Node) -> Pose {
    let xyz = numbers(node.attribute("xyz")).unwrap_or_default();
    let rpy = numbers(node.attribute("rpy")).unwrap_or_default();
    let turn = |axis: Vector3<f64>, angle: f64| spatial::exp_so3(&(axis * angle));
    let rotation =
        turn(Vector3::z(), rpy.z) * turn(Vector3::y(), rpy.y) * turn(Vector3::x(), rpy.x);
    Pose::from_parts(rotation, xyz)
}

fn color(material: Node) -> Option<[f64; 3]> {
    let rgba = children(material, "color").next()?.attribute("rgba")?;
    let rgb: Vec<f64> = rgba
        .split_whitespace()
        .filter_map(|x| x.parse().ok())
        .collect();
    rgb.get(..3)?.try_into().ok()
}

fn numbers(text: Option<&str>) -> Option<Vector3<f64>> {
    let values: Vec<f64> = text?
        .split_whitespace()
        .filter_map(|x| x.parse().ok())
        .collect();
    let three: [f64; 3] = values.try_into().ok()?;
    Some(three.into())
}
