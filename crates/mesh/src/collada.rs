//! Collada files (.dae): the triangles of the visual scene with their colours.
//!
//! As RViz does, the unit counts and `up_axis` does not: URDFs are written for that. Textures, skins and curves are left out.
//! Source: COLLADA 1.4.1, digital asset schema.

use nalgebra::{Matrix4, Rotation3, Unit, Vector3};
use roxmltree::{Document, Node};
use std::collections::BTreeMap;

/// Deeper nodes, or more parts, are taken for a scene that contains itself.
const DEEPEST: usize = 64;
const MOST: usize = 20_000;

/// Triangles of one material.
#[derive(Debug)]
pub struct Group {
    /// Places [m].
    pub places: Vec<Vector3<f64>>,
    /// Indices as the file has them, not checked.
    pub faces: Vec<[u32; 3]>,
    /// Red, green, blue, from 0 to 1.
    pub color: Option<[f64; 3]>,
}

/// All triangles of a file's scene.
///
/// # Errors
/// The text is no Collada file or contradicts itself: where.
pub(crate) fn groups(text: &str) -> Result<Vec<Group>, String> {
    let document = Document::parse(text).map_err(|error| error.to_string())?;
    let with_id = document.descendants();
    let ids = with_id.filter_map(|node| Some((node.attribute("id")?, node)));
    let mut reader = Reader {
        ids: ids.collect(),
        groups: Vec::new(),
    };
    let root = document.root_element();
    let unit = child(root, "asset").and_then(|asset| child(asset, "unit"));
    let meter = match unit.and_then(|unit| unit.attribute("meter")) {
        Some(text) => numbers(text)?.first().copied().unwrap_or(1.0),
        None => 1.0,
    };
    let scene = child(root, "scene").and_then(|scene| child(scene, "instance_visual_scene"));
    let scene = reader.referred(scene.ok_or("there is no visual scene")?, "url")?;
    reader.walk(scene, &Matrix4::new_scaling(meter), 0)?;
    Ok(reader.groups)
}

struct Reader<'a, 'i> {
    ids: BTreeMap<&'a str, Node<'a, 'i>>,
    groups: Vec<Group>,
}

impl<'a, 'i> Reader<'a, 'i> {
    /// What `#name` in an attribute stands for.
    fn referred(&self, node: Node, attribute: &str) -> Result<Node<'a, 'i>, String> {
        let name = node.attribute(attribute).unwrap_or("");
        let found = self.ids.get(name.trim_start_matches('#'));
        found.copied().ok_or_else(|| {
            let tag = node.tag_name().name();
            format!("<{tag}> refers to {name:?}, which is not there")
        })
    }

    /// Takes all geometries below a node.
    fn walk(
        &mut self,
        node: Node<'a, 'i>,
        above: &Matrix4<f64>,
        depth: usize,
    ) -> Result<(), String> {
        if depth > DEEPEST {
            return Err("its nodes contain themselves".into());
        }
        let here = above * transform(node)?;
        for part in node.children() {
            match part.tag_name().name() {
                "node" => self.walk(part, &here, depth + 1)?,
                "instance_node" => self.walk(self.referred(part, "url")?, &here, depth + 1)?,
                "instance_geometry" => self.geometry(part, &here)?,
                _ => (),
            }
        }
        Ok(())
    }

    fn geometry(&mut self, instance: Node<'a, 'i>, here: &Matrix4<f64>) -> Result<(), String> {
        let geometry = self.referred(instance, "url")?;
        let Some(mesh) = child(geometry, "mesh") else {
            return Ok(());
        };
        for part in mesh.children() {
            let corners = match part.tag_name().name() {
                "triangles" | "polylist" | "polygons" => part,
                _ => continue,
            };
            if self.groups.len() >= MOST {
                return Err("it has too many parts".into());
            }
            let (input, stride) = vertex_input(corners)?;
            let vertices = self.referred(input, "source")?;
            let position = semantic(vertices, "POSITION").ok_or("vertices have no POSITION")?;
            let places = places(self.referred(position, "source")?)?;
            let place = |x: Vector3<f64>| here.transform_point(&x.into()).coords;
            self.groups.push(Group {
                places: places.into_iter().map(place).collect(),
                faces: faces(corners, offset(input), stride)?,
                color: self.color(instance, part.attribute("material")),
            });
        }
        Ok(())
    }

    /// The diffuse colour that an instance binds to a material's symbol.
    fn color(&self, instance: Node, symbol: Option<&str>) -> Option<[f64; 3]> {
        let bound = instance.descendants().find(|node| {
            node.has_tag_name_anywhere("instance_material") && node.attribute("symbol") == symbol
        })?;
        let material = self.referred(bound, "target").ok()?;
        let effect = self
            .referred(child(material, "instance_effect")?, "url")
            .ok()?;
        let diffuse = effect
            .descendants()
            .find(|node| node.has_tag_name_anywhere("diffuse"))?;
        let rgba = numbers(child(diffuse, "color")?.text()?).ok()?;
        rgba.get(..3)?.try_into().ok()
    }
}

/// Tags without regard to the namespace.
trait TagName {
    fn has_tag_name_anywhere(&self, tag: &str) -> bool;
}

impl TagName for Node<'_, '_> {
    fn has_tag_name_anywhere(&self, tag: &str) -> bool {
        self.tag_name().name() == tag
    }
}

fn child<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|x| x.has_tag_name_anywhere(tag))
}

fn semantic<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    node.children()
        .find(|x| x.has_tag_name_anywhere("input") && x.attribute("semantic") == Some(name))
}

/// The input with the places, and how many indices there are per corner.
fn vertex_input<'a, 'i>(corners: Node<'a, 'i>) -> Result<(Node<'a, 'i>, usize), String> {
    let inputs = corners
        .children()
        .filter(|x| x.has_tag_name_anywhere("input"));
    let stride = inputs.map(offset).max().map_or(1, |x| x.saturating_add(1));
    let vertex = semantic(corners, "VERTEX").ok_or("triangles have no VERTEX")?;
    Ok((vertex, stride))
}

fn offset(input: Node) -> usize {
    let text = input.attribute("offset");
    text.and_then(|x| x.trim().parse().ok()).unwrap_or(0)
}

/// The pose of a node in that above it: the product of what it lists.
fn transform(node: Node) -> Result<Matrix4<f64>, String> {
    let mut product = Matrix4::identity();
    for step in node.children() {
        let tag = step.tag_name().name();
        if !["matrix", "translate", "rotate", "scale"].contains(&tag) {
            continue;
        }
        let values = numbers(step.text().unwrap_or(""))?;
        product *= match (tag, values.as_slice()) {
            ("matrix", rows @ [_, _, _, _, _, _, _, _, _, _, _, _, _, _, _, _]) => {
                Matrix4::from_row_slice(rows)
            }
            ("translate", [x, y, z]) => Matrix4::new_translation(&Vector3::new(*x, *y, *z)),
            ("scale", [x, y, z]) => Matrix4::new_nonuniform_scaling(&Vector3::new(*x, *y, *z)),
            ("rotate", [x, y, z, degrees]) => {
                let axis = Unit::try_new(Vector3::new(*x, *y, *z), 0.0);
                let axis = axis.ok_or("<rotate> has no axis")?;
                Rotation3::from_axis_angle(&axis, degrees.to_radians()).to_homogeneous()
            }
            _ => return Err(format!("<{tag}> has {} numbers", values.len())),
        };
    }
    Ok(product)
}

fn places(source: Node) -> Result<Vec<Vector3<f64>>, String> {
    let array = child(source, "float_array").and_then(|x| x.text());
    let values = numbers(array.unwrap_or(""))?;
    let mut parts = source.descendants();
    let accessor = parts.find(|x| x.has_tag_name_anywhere("accessor"));
    let stride = accessor.and_then(|x| x.attribute("stride"));
    let stride: usize = stride.and_then(|x| x.parse().ok()).unwrap_or(3);
    if stride < 3 {
        return Err(format!("places have {stride} coordinates"));
    }
    let rows = values.chunks_exact(stride);
    Ok(rows.map(|x| Vector3::new(x[0], x[1], x[2])).collect())
}

/// Polygons cut into triangles around their first corners.
fn faces(corners: Node, offset: usize, stride: usize) -> Result<Vec<[u32; 3]>, String> {
    let mut faces = Vec::new();
    let tag = corners.tag_name().name();
    let sizes = child(corners, "vcount").and_then(|x| x.text());
    let mut sizes: std::vec::IntoIter<u32> = whole_numbers(sizes.unwrap_or(""))?.into_iter();
    let lists = corners.children().filter(|x| x.has_tag_name_anywhere("p"));
    for list in lists {
        let indices = whole_numbers(list.text().unwrap_or(""))?;
        let all: Vec<u32> = indices
            .chunks(stride)
            .filter_map(|x| x.get(offset).copied())
            .collect();
        let mut rest = all.as_slice();
        while !rest.is_empty() {
            let size = match tag {
                "triangles" => 3,
                "polygons" => rest.len(),
                _ => sizes.next().unwrap_or(0) as usize,
            };
            if size < 1 || size > rest.len() {
                return Err(format!("<{tag}> has no whole number of polygons"));
            }
            let (polygon, after) = rest.split_at(size);
            let fan = polygon.windows(2).skip(1);
            faces.extend(fan.map(|side| [polygon[0], side[0], side[1]]));
            rest = after;
        }
    }
    Ok(faces)
}

fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let number = |word: &str| word.parse().map_err(|_| format!("{word:?} is no number"));
    text.split_whitespace().map(number).collect()
}

fn whole_numbers(text: &str) -> Result<Vec<u32>, String> {
    let number = |word: &str| word.parse().map_err(|_| format!("{word:?} is no index"));
    text.split_whitespace().map(number).collect()
}
