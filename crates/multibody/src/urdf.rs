//! Reads the text of a URDF into links and joints, without judging the tree that they form.
//!
//! Source: the URDF specification (wiki.ros.org/urdf/XML). Visual geometry, materials, transmissions and simulator tags
//! are skipped. Every mistake is reported with its line and the link or joint that it belongs to.

use crate::rpy::rotation_from_rpy;
use crate::{ModelError, PlacedShape, Shape};
use nalgebra::{Matrix3, Vector3};
use roxmltree::{Document, Node};
use spatial::{Inertia, Pose};

/// A robot as the file states it.
pub(crate) struct Description {
    pub name: String,
    pub links: Vec<Link>,
    pub joints: Vec<Connection>,
    pub notes: Vec<String>,
}

pub(crate) struct Link {
    pub name: String,
    /// Massless if the file gives no inertia.
    pub inertia: Inertia,
    pub shapes: Vec<PlacedShape>,
}

/// A joint of the file, moving or fixed.
pub(crate) struct Connection {
    pub name: String,
    pub line: u32,
    pub kind: String,
    pub parent: String,
    pub child: String,
    pub parent_from_child: Pose,
    /// As written, not normalised.
    pub axis: Vector3<f64>,
    pub limit: Option<Limit>,
    pub mimic: Option<Mimic>,
    /// Torque per speed [N·m·s/rad or N·s/m]; 0 if the file says nothing.
    pub damping: f64,
    /// Torque whatever the speed [N·m or N]; 0 if the file says nothing.
    pub friction: f64,
}

pub(crate) struct Limit {
    pub lower: f64,
    pub upper: f64,
    pub effort: f64,
    pub velocity: f64,
}

pub(crate) struct Mimic {
    pub joint: String,
    pub offset: f64,
}

/// A node of the file with the name by which messages call it.
struct Item<'a, 'i> {
    node: Node<'a, 'i>,
    owner: String,
}

pub(crate) fn parse(text: &str) -> Result<Description, ModelError> {
    let document = Document::parse(text).map_err(|error| ModelError::Xml {
        message: error.to_string(),
    })?;
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        let found = root.tag_name().name().to_owned();
        return Err(ModelError::NotARobot {
            found,
            line: line_of(root),
        });
    }
    let name = root.attribute("name").unwrap_or("robot").to_owned();
    let mut description = Description {
        name,
        links: Vec::new(),
        joints: Vec::new(),
        notes: Vec::new(),
    };
    for node in root.children().filter(Node::is_element) {
        match node.tag_name().name() {
            "link" => {
                let link = parse_link(node, &mut description.notes)?;
                description.links.push(link);
            }
            "joint" => description.joints.push(parse_joint(node)?),
            _ => {}
        }
    }
    check_unique(
        "link",
        root,
        description.links.iter().map(|link| &link.name),
    )?;
    check_unique(
        "joint",
        root,
        description.joints.iter().map(|joint| &joint.name),
    )?;
    Ok(description)
}

fn check_unique<'s>(
    kind: &'static str,
    root: Node,
    names: impl Iterator<Item = &'s String>,
) -> Result<(), ModelError> {
    let mut sorted: Vec<&String> = names.collect();
    sorted.sort();
    let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) else {
        return Ok(());
    };
    let second = root
        .children()
        .filter(|node| node.has_tag_name(kind) && node.attribute("name") == Some(pair[0]))
        .nth(1);
    let line = second.map_or(0, line_of);
    Err(ModelError::Duplicate {
        kind,
        name: pair[0].clone(),
        line,
    })
}

fn parse_link(node: Node, notes: &mut Vec<String>) -> Result<Link, ModelError> {
    let (item, name) = named(node)?;
    let inertia = match item.child("inertial") {
        Some(inertial) => parse_inertial(&inertial, &name, notes)?,
        None => Inertia::zero(),
    };
    let mut shapes = Vec::new();
    for collision in item.children("collision") {
        let frame_from_shape = collision.origin()?;
        match parse_geometry(&collision.required("geometry", "<geometry>")?)? {
            Ok(shape) => shapes.push(PlacedShape {
                frame_from_shape,
                shape,
            }),
            Err(tag) => notes.push(format!(
                "link {name:?}: collision geometry <{tag}> is not known and was skipped"
            )),
        }
    }
    Ok(Link {
        name,
        inertia,
        shapes,
    })
}

fn parse_inertial(
    inertial: &Item,
    link: &str,
    notes: &mut Vec<String>,
) -> Result<Inertia, ModelError> {
    let mass_item = inertial.required("mass", "<mass>")?;
    let mass = mass_item.required_number("value", "value")?;
    let tensor_item = inertial.required("inertia", "<inertia>")?;
    let entry = |name: &'static str| tensor_item.number(name, 0.0);
    let (ixx, iyy, izz) = (entry("ixx")?, entry("iyy")?, entry("izz")?);
    let (ixy, ixz, iyz) = (entry("ixy")?, entry("ixz")?, entry("iyz")?);
    let tensor = Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz);
    if mass < 0.0 {
        return Err(ModelError::BadMass {
            link: link.to_owned(),
            mass,
        });
    }
    if mass == 0.0 {
        if tensor != Matrix3::zeros() {
            notes.push(format!(
                "link {link:?} has inertia but no mass; its <inertial> was ignored"
            ));
        }
        return Ok(Inertia::zero());
    }
    let link_from_inertial = inertial.origin()?;
    Ok(Inertia {
        mass,
        com: Vector3::zeros(),
        inertia: tensor,
    }
    .transformed(&link_from_inertial))
}

/// The shape, or the tag of one that is not known.
fn parse_geometry(geometry: &Item) -> Result<Result<Shape, String>, ModelError> {
    let Some(node) = geometry.node.children().find(Node::is_element) else {
        return Err(geometry.missing("a shape inside <geometry>"));
    };
    let item = Item {
        node,
        owner: geometry.owner.clone(),
    };
    let radius = || item.size("radius");
    Ok(Ok(match node.tag_name().name() {
        "box" => {
            let size = item.vector("size", None)?;
            if size.iter().any(|x| *x < 0.0) {
                return Err(item.bad_number("size", "three sizes that are not negative"));
            }
            Shape::Box {
                half_size: size * 0.5,
            }
        }
        "sphere" => Shape::Sphere { radius: radius()? },
        "cylinder" => Shape::Cylinder {
            radius: radius()?,
            half_length: 0.5 * item.size("length")?,
        },
        "capsule" => Shape::Capsule {
            radius: radius()?,
            half_length: 0.5 * item.size("length")?,
        },
        "mesh" => Shape::Mesh {
            filename: node
                .attribute("filename")
                .ok_or_else(|| item.missing("filename"))?
                .to_owned(),
            scale: item.vector("scale", Some(Vector3::repeat(1.0)))?,
        },
        tag => return Ok(Err(tag.to_owned())),
    }))
}

fn parse_joint(node: Node) -> Result<Connection, ModelError> {
    let (item, name) = named(node)?;
    let link_of = |tag: &str, missing| -> Result<String, ModelError> {
        let link = item
            .child(tag)
            .and_then(|end| end.node.attribute("link").map(str::to_owned));
        link.ok_or_else(|| item.missing(missing))
    };
    let axis = match item.child("axis") {
        Some(axis) => axis.vector("xyz", None)?,
        None => Vector3::x(),
    };
    let limit = match item.child("limit") {
        Some(limit) => Some(Limit {
            lower: limit.bound("lower", 0.0)?,
            upper: limit.bound("upper", 0.0)?,
            effort: limit.bound("effort", 0.0)?,
            velocity: limit.bound("velocity", 0.0)?,
        }),
        None => None,
    };
    let mimic = match item.child("mimic") {
        Some(mimic) => Some(Mimic {
            joint: mimic
                .node
                .attribute("joint")
                .ok_or_else(|| mimic.missing("joint"))?
                .to_owned(),
            offset: mimic.number("offset", 0.0)?,
        }),
        None => None,
    };
    // What is not used must not stop anyone: text that is no number counts as zero.
    let resistance = |attribute| {
        let element = item.child("dynamics");
        let value = element.map_or(Ok(0.0), |dynamics| dynamics.number(attribute, 0.0));
        value.unwrap_or(0.0)
    };
    Ok(Connection {
        line: line_of(node),
        kind: node
            .attribute("type")
            .ok_or_else(|| item.missing("type"))?
            .to_owned(),
        parent: link_of("parent", "<parent link=...>")?,
        child: link_of("child", "<child link=...>")?,
        parent_from_child: item.origin()?,
        name,
        axis,
        limit,
        mimic,
        damping: resistance("damping"),
        friction: resistance("friction"),
    })
}

fn named<'a, 'i>(node: Node<'a, 'i>) -> Result<(Item<'a, 'i>, String), ModelError> {
    let tag = node.tag_name().name();
    let Some(name) = node.attribute("name") else {
        return Err(Item {
            node,
            owner: format!("<{tag}>"),
        }
        .missing("name"));
    };
    Ok((
        Item {
            node,
            owner: format!("{tag} {name:?}"),
        },
        name.to_owned(),
    ))
}

fn line_of(node: Node) -> u32 {
    node.document().text_pos_at(node.range().start).row
}

impl<'a, 'i> Item<'a, 'i> {
    fn child(&self, tag: &str) -> Option<Item<'a, 'i>> {
        let node = self.node.children().find(|child| child.has_tag_name(tag))?;
        Some(Item {
            node,
            owner: self.owner.clone(),
        })
    }

    fn children<'t>(&self, tag: &'t str) -> impl Iterator<Item = Item<'a, 'i>> + use<'a, 'i, 't> {
        let owner = self.owner.clone();
        let nodes = self
            .node
            .children()
            .filter(move |child| child.has_tag_name(tag));
        nodes.map(move |node| Item {
            node,
            owner: owner.clone(),
        })
    }

    fn required(&self, tag: &str, missing: &'static str) -> Result<Item<'a, 'i>, ModelError> {
        self.child(tag).ok_or_else(|| self.missing(missing))
    }

    fn missing(&self, missing: &'static str) -> ModelError {
        ModelError::Missing {
            owner: self.owner.clone(),
            missing,
            line: line_of(self.node),
        }
    }

    fn bad_number(&self, attribute: &'static str, expected: &'static str) -> ModelError {
        let text = self
            .node
            .attribute(attribute)
            .unwrap_or_default()
            .to_owned();
        ModelError::BadNumber {
            owner: self.owner.clone(),
            attribute,
            text,
            expected,
            line: line_of(self.node),
        }
    }

    /// A finite number; `default` if the attribute is absent.
    fn number(&self, attribute: &'static str, default: f64) -> Result<f64, ModelError> {
        let value = self.bound(attribute, default)?;
        if value.is_finite() {
            Ok(value)
        } else {
            Err(self.bad_number(attribute, "a finite number"))
        }
    }

    /// A number that may be infinite; `default` if the attribute is absent.
    fn bound(&self, attribute: &'static str, default: f64) -> Result<f64, ModelError> {
        let Some(text) = self.node.attribute(attribute) else {
            return Ok(default);
        };
        let value = text
            .trim()
            .parse::<f64>()
            .ok()
            .filter(|value| !value.is_nan());
        value.ok_or_else(|| self.bad_number(attribute, "a number"))
    }

    fn required_number(
        &self,
        attribute: &'static str,
        missing: &'static str,
    ) -> Result<f64, ModelError> {
        if self.node.has_attribute(attribute) {
            self.number(attribute, 0.0)
        } else {
            Err(self.missing(missing))
        }
    }

    fn size(&self, attribute: &'static str) -> Result<f64, ModelError> {
        let value = self.required_number(attribute, attribute)?;
        if value >= 0.0 {
            Ok(value)
        } else {
            Err(self.bad_number(attribute, "a size that is not negative"))
        }
    }

    /// Three finite numbers; without a default the attribute must be there.
    fn vector(
        &self,
        attribute: &'static str,
        default: Option<Vector3<f64>>,
    ) -> Result<Vector3<f64>, ModelError> {
        let Some(text) = self.node.attribute(attribute) else {
            return default.ok_or_else(|| self.missing(attribute));
        };
        let parsed: Option<Vec<f64>> = text
            .split_whitespace()
            .map(|word| word.parse().ok())
            .collect();
        match parsed.as_deref() {
            Some([x, y, z]) if x.is_finite() && y.is_finite() && z.is_finite() => {
                Ok(Vector3::new(*x, *y, *z))
            }
            _ => Err(self.bad_number(attribute, "three finite numbers")),
        }
    }

    /// Pose of the child element `<origin xyz rpy>`; the identity if it is absent.
    fn origin(&self) -> Result<Pose, ModelError> {
        let Some(origin) = self.child("origin") else {
            return Ok(Pose::identity());
        };
        let xyz = origin.vector("xyz", Some(Vector3::zeros()))?;
        let rpy = origin.vector("rpy", Some(Vector3::zeros()))?;
        Ok(Pose::from_parts(rotation_from_rpy(&rpy), xyz))
    }
}
