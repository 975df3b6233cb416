//! What the robot looks like: its tree of joints and the shapes on them.
//!
//! Shapes are the URDF's visual primitives with their colours; of a link without any, its collision primitives. Meshes are
//! files outside the plan, so a link that has nothing else is drawn as rods from its joint to the joints behind it.

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
    /// Pose in the frame of the link, and shape.
    pub placed: PlacedShape,
    /// Red, green, blue, from 0 to 1.
    pub color: [f64; 3],
}

/// Shapes of a robot, and what was replaced, as sentences.
pub(crate) fn looks(model: &Model, urdf: &str) -> (Vec<Look>, Vec<String>) {
    let visuals = visuals(urdf);
    let (mut looks, mut rods) = (Vec::new(), 0);
    for (frame, link) in model.frames.iter().enumerate() {
        let found = visuals.get(&link.name).cloned().unwrap_or_default();
        let had_mesh =
            found.iter().any(|(placed, _)| is_mesh(placed)) || link.shapes.iter().any(is_mesh);
        let mut shapes: Vec<_> = found.into_iter().filter(|(x, _)| !is_mesh(x)).collect();
        if shapes.is_empty() {
            let collision = link.shapes.iter().filter(|x| !is_mesh(x));
            shapes = collision.map(|x| (x.clone(), PLAIN)).collect();
        }
        if shapes.is_empty() && had_mesh {
            shapes = skeleton(model, frame, link);
            rods += 1;
        }
        looks.extend(shapes.into_iter().map(|(placed, color)| Look {
            frame,
            placed,
            color,
        }));
    }
    let note =
        format!("{rods} links have only meshes, which are not in the plan file: drawn as rods");
    (looks, if rods > 0 { vec![note] } else { Vec::new() })
}

fn is_mesh(placed: &PlacedShape) -> bool {
    matches!(placed.shape, Shape::Mesh { .. })
}

/// Rods from a link to all joints that hang on it, a ball if there are none.
fn skeleton(model: &Model, index: usize, link: &Frame) -> Vec<(PlacedShape, [f64; 3])> {
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
    rods.into_iter().map(|x| (x, PLAIN)).collect()
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

type Visuals = BTreeMap<String, Vec<(PlacedShape, [f64; 3])>>;

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

fn visual(node: Node, materials: &BTreeMap<&str, [f64; 3]>) -> Option<(PlacedShape, [f64; 3])> {
    let geometry = children(node, "geometry").next()?;
    let shape = shape(geometry.children().find(Node::is_element)?)?;
    let material = children(node, "material").next();
    let named = || materials.get(material?.attribute("name")?).copied();
    let color = material.and_then(color).or_else(named).unwrap_or(PLAIN);
    let frame_from_shape = children(node, "origin")
        .next()
        .map_or_else(Pose::identity, origin);
    Some((
        PlacedShape {
            frame_from_shape,
            shape,
        },
        color,
    ))
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
            scale: Vector3::repeat(1.0),
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
