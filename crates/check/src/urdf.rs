//! From URDF text to [`Robot`].
//!
//! The base is the root link, or the child of a floating joint at the root. Mimic joints count as joints of their
//! own: the plan lists them or they stay at zero.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};
use spatial::{Pose, exp_so3};
use urdf_rs::JointType;

use crate::robot::{JointLimits, JointMotion, Link, Robot};
use crate::shapes;

/// Why a URDF cannot be used.
#[derive(Debug, thiserror::Error)]
pub(crate) enum UrdfError {
    #[error("URDF: {0}")]
    Xml(String),
    #[error("URDF: elements nested {0} deep, expected at most {MAX_DEPTH}")]
    Depth(usize),
    #[error("URDF: the name {0:?} is used twice")]
    Duplicate(String),
    #[error("URDF: joint {joint:?} names link {link:?}, which is not there")]
    NoSuchLink { joint: String, link: String },
    #[error("URDF: link {0:?} has two parents: a loop, expected a tree")]
    TwoParents(String),
    #[error("URDF: {0} links have no parent, expected one root and no loop")]
    Roots(usize),
    #[error("URDF: links {0} hang in a loop, expected a tree")]
    Loop(String),
    #[error("URDF: joint {joint:?} is {kind}, expected fixed, revolute, continuous or prismatic")]
    JointKind { joint: String, kind: &'static str },
    #[error("URDF: {0}")]
    Number(String),
    #[error("robot.joints: {0:?} is not a movable joint of the URDF")]
    NoSuchJoint(String),
}

/// Deepest nesting of elements that is read; a URDF has about six.
const MAX_DEPTH: usize = 64;

/// Reads the robot of a plan whose joint vector has the entries `joints`.
///
/// # Errors
/// The text is not a URDF, the links do not form one tree, a number is absurd, or a joint is missing.
pub(crate) fn read(text: &str, joints: &[String]) -> Result<Robot, UrdfError> {
    check_depth(text)?;
    let text = without_nameless_textures(text);
    let urdf =
        urdf_rs::read_from_string(&text).map_err(|error| UrdfError::Xml(error.to_string()))?;
    for name in joints {
        if !urdf
            .joints
            .iter()
            .any(|joint| joint.name == *name && is_movable(joint))
        {
            return Err(UrdfError::NoSuchJoint(name.clone()));
        }
    }
    let tree = Tree::new(&urdf)?;
    let mut robot = Robot {
        links: Vec::new(),
        joints: joints.to_vec(),
        limits: joints
            .iter()
            .map(|name| limits(&urdf, name))
            .collect::<Result<_, _>>()?,
        world_from_origin: tree.world_from_origin,
        group_parent: vec![None],
        shapes: Vec::new(),
        unread: Vec::new(),
    };
    let mut index_of = BTreeMap::new();
    for (urdf_link, joint) in tree.parents_first()? {
        let parent = joint.and_then(|joint| index_of.get(joint.parent.link.as_str()).copied());
        index_of.insert(urdf_link.name.as_str(), robot.links.len());
        add_link(&mut robot, urdf_link, joint, parent)?;
    }
    if robot.mass() <= 0.0 {
        return Err(UrdfError::Number("the robot has no mass".to_owned()));
    }
    Ok(robot)
}

/// Refuses text whose nesting would exhaust the stack of a recursive XML reader.
fn check_depth(text: &str) -> Result<(), UrdfError> {
    let (mut depth, mut deepest) = (0usize, 0usize);
    for (at, _) in text.match_indices('<') {
        let rest = &text[at + 1..];
        match rest.as_bytes().first() {
            Some(b'/') => depth = depth.saturating_sub(1),
            Some(b'?' | b'!') | None => {}
            Some(_) => {
                let closed = rest.find('>').is_some_and(|end| rest[..end].ends_with('/'));
                depth += usize::from(!closed);
            }
        }
        deepest = deepest.max(depth);
    }
    if deepest > MAX_DEPTH {
        Err(UrdfError::Depth(deepest))
    } else {
        Ok(())
    }
}

/// The text without `<texture>` elements that name no file: they say nothing, and the XML reader refuses them.
fn without_nameless_textures(text: &str) -> String {
    let (mut kept, mut rest) = (String::new(), text);
    while let Some(start) = rest.find("<texture") {
        let (before, element) = rest.split_at(start);
        let end = element.find('>').map_or(element.len(), |end| end + 1);
        let (tag, mut after) = element.split_at(end);
        kept.push_str(before);
        if tag.contains("filename") {
            kept.push_str(tag);
        } else if !tag.ends_with("/>") {
            let close = after.find("</texture>").map(|at| at + "</texture>".len());
            after = close.map_or(after, |close| &after[close..]);
        }
        rest = after;
    }
    kept + rest
}

fn is_movable(joint: &urdf_rs::Joint) -> bool {
    matches!(
        joint.joint_type,
        JointType::Revolute | JointType::Continuous | JointType::Prismatic
    )
}

/// The links and the joint above each.
struct Tree<'a> {
    urdf: &'a urdf_rs::Robot,
    base: &'a str,
    world_from_origin: Pose,
    children: BTreeMap<&'a str, Vec<&'a urdf_rs::Joint>>,
}

impl<'a> Tree<'a> {
    fn new(urdf: &'a urdf_rs::Robot) -> Result<Self, UrdfError> {
        let mut parent_joint: BTreeMap<&str, Option<&urdf_rs::Joint>> = BTreeMap::new();
        for link in &urdf.links {
            if parent_joint.insert(&link.name, None).is_some() {
                return Err(UrdfError::Duplicate(link.name.clone()));
            }
        }
        let mut children: BTreeMap<&str, Vec<&urdf_rs::Joint>> = BTreeMap::new();
        for (i, joint) in urdf.joints.iter().enumerate() {
            if urdf.joints[..i]
                .iter()
                .any(|other| other.name == joint.name)
            {
                return Err(UrdfError::Duplicate(joint.name.clone()));
            }
            for link in [&joint.parent.link, &joint.child.link] {
                if !parent_joint.contains_key(link.as_str()) {
                    return Err(UrdfError::NoSuchLink {
                        joint: joint.name.clone(),
                        link: link.clone(),
                    });
                }
            }
            if parent_joint
                .insert(&joint.child.link, Some(joint))
                .flatten()
                .is_some()
            {
                return Err(UrdfError::TwoParents(joint.child.link.clone()));
            }
            children.entry(&joint.parent.link).or_default().push(joint);
        }
        let roots: Vec<_> = parent_joint
            .iter()
            .filter(|(_, joint)| joint.is_none())
            .map(|(name, _)| *name)
            .collect();
        let [root] = roots[..] else {
            return Err(UrdfError::Roots(roots.len()));
        };
        let (base, world_from_origin) = match children.get(root).map(Vec::as_slice) {
            Some([only]) if only.joint_type == JointType::Floating => {
                (only.child.link.as_str(), pose(&only.origin, &only.name)?)
            }
            _ => (root, Pose::identity()),
        };
        Ok(Self {
            urdf,
            base,
            world_from_origin,
            children,
        })
    }

    /// Each link from the base on with the joint above it, in an order where parents come first.
    fn parents_first(
        &self,
    ) -> Result<Vec<(&'a urdf_rs::Link, Option<&'a urdf_rs::Joint>)>, UrdfError> {
        let mut links: BTreeMap<&str, &urdf_rs::Link> = self
            .urdf
            .links
            .iter()
            .map(|x| (x.name.as_str(), x))
            .collect();
        // The world link above a floating joint is no body of the robot.
        links.retain(|name, _| !self.is_above_base(name));
        let mut order = Vec::new();
        let mut open = vec![(self.base, None)];
        while let Some((name, joint)) = open.pop() {
            // Every link has at most one parent, so none comes twice.
            let Some(link) = links.remove(name) else {
                break;
            };
            order.push((link, joint));
            let below = self.children.get(name).into_iter().flatten();
            open.extend(
                below
                    .rev()
                    .map(|joint| (joint.child.link.as_str(), Some(*joint))),
            );
        }
        if links.is_empty() {
            Ok(order)
        } else {
            Err(UrdfError::Loop(
                links.keys().copied().collect::<Vec<_>>().join(", "),
            ))
        }
    }

    fn is_above_base(&self, name: &str) -> bool {
        let below = self.children.get(name).map(Vec::as_slice);
        matches!(below, Some([only]) if only.joint_type == JointType::Floating && only.child.link == self.base)
    }
}

fn add_link(
    robot: &mut Robot,
    urdf_link: &urdf_rs::Link,
    joint: Option<&urdf_rs::Joint>,
    parent: Option<usize>,
) -> Result<(), UrdfError> {
    let link_from_inertia = pose(&urdf_link.inertial.origin, &urdf_link.name)?;
    let rotation = link_from_inertia.rotation();
    let motion = match (joint, parent) {
        (Some(joint), Some(_)) => joint_motion(joint, &robot.joints)?,
        _ => JointMotion::Fixed,
    };
    let group = match (motion, parent) {
        (_, None) => 0,
        (JointMotion::Fixed, Some(parent)) => robot.links[parent].group,
        (_, Some(parent)) => {
            robot.group_parent.push(Some(robot.links[parent].group));
            robot.group_parent.len() - 1
        }
    };
    let parent_from_link = match (joint, parent) {
        (Some(joint), Some(_)) => pose(&joint.origin, &joint.name)?,
        _ => Pose::identity(),
    };
    let found = shapes::of_link(urdf_link, robot.links.len())?;
    robot.shapes.extend(found.read);
    if found.some_unread {
        robot.unread.push(urdf_link.name.clone());
    }
    robot.links.push(Link {
        name: urdf_link.name.clone(),
        parent,
        parent_from_link,
        motion,
        mass: mass(urdf_link)?,
        com_in_link: link_from_inertia.origin(),
        inertia_in_link: rotation * inertia(urdf_link)? * rotation.transpose(),
        group,
    });
    Ok(())
}

fn joint_motion(joint: &urdf_rs::Joint, joints: &[String]) -> Result<JointMotion, UrdfError> {
    let name = &joint.name;
    let unsupported = |kind| {
        Err(UrdfError::JointKind {
            joint: name.clone(),
            kind,
        })
    };
    match joint.joint_type {
        JointType::Fixed => return Ok(JointMotion::Fixed),
        JointType::Floating => return unsupported("floating below the root"),
        JointType::Planar => return unsupported("planar"),
        JointType::Spherical => return unsupported("spherical"),
        JointType::Revolute | JointType::Continuous | JointType::Prismatic => {}
    }
    let axis = finite_vector(&joint.axis.xyz, name)?;
    let Some(axis) = axis.try_normalize(1e-9) else {
        return Err(UrdfError::Number(format!(
            "joint {name:?} has an axis of length zero"
        )));
    };
    Ok(match joints.iter().position(|listed| listed == name) {
        None => JointMotion::Fixed,
        Some(column) if joint.joint_type == JointType::Prismatic => {
            JointMotion::Slides { axis, column }
        }
        Some(column) => JointMotion::Turns { axis, column },
    })
}

/// Limits as the URDF says; a joint whose limit element is missing has none, a continuous one none on its position.
fn limits(urdf: &urdf_rs::Robot, name: &str) -> Result<JointLimits, UrdfError> {
    let infinity = f64::INFINITY;
    let none = JointLimits {
        lower: -infinity,
        upper: infinity,
        velocity: infinity,
        effort: infinity,
    };
    let Some(joint) = urdf.joints.iter().find(|joint| joint.name == name) else {
        return Ok(none);
    };
    let limit = &joint.limit;
    let all = [limit.lower, limit.upper, limit.velocity, limit.effort];
    if all == [0.0; 4] {
        return Ok(none);
    }
    if all.iter().any(|x| x.is_nan()) {
        return Err(UrdfError::Number(format!(
            "joint {name:?} has limits {all:?}, expected numbers"
        )));
    }
    let turns_freely = joint.joint_type == JointType::Continuous;
    Ok(JointLimits {
        lower: if turns_freely { -infinity } else { limit.lower },
        upper: if turns_freely { infinity } else { limit.upper },
        velocity: limit.velocity,
        effort: limit.effort,
    })
}

fn mass(link: &urdf_rs::Link) -> Result<f64, UrdfError> {
    let mass = link.inertial.mass.value;
    if mass.is_finite() && mass >= 0.0 {
        Ok(mass)
    } else {
        Err(UrdfError::Number(format!(
            "link {:?} has a mass of {mass} kg, expected a number of at least 0",
            link.name
        )))
    }
}

/// A moment of inertia may be below zero by this part of their sum and this much [kg·m²]: published files are rounded.
const BELOW_ZERO: (f64, f64) = (1e-3, 1e-12);

fn inertia(link: &urdf_rs::Link) -> Result<Matrix3<f64>, UrdfError> {
    let i = &link.inertial.inertia;
    #[rustfmt::skip]
    let matrix = Matrix3::new(
        i.ixx, i.ixy, i.ixz,
        i.ixy, i.iyy, i.iyz,
        i.ixz, i.iyz, i.izz,
    );
    let moments = [i.ixx, i.iyy, i.izz];
    let least = -BELOW_ZERO.0 * matrix.trace().abs() - BELOW_ZERO.1;
    if matrix.iter().all(|x| x.is_finite()) && moments.iter().all(|x| *x >= least) {
        Ok(matrix)
    } else {
        Err(UrdfError::Number(format!(
            "link {:?} has moments of inertia {moments:?}, expected at least 0",
            link.name
        )))
    }
}

/// Pose of a URDF origin: rotations by roll, pitch, yaw about the fixed x, y, z axes, in that order.
pub(crate) fn pose(origin: &urdf_rs::Pose, of: &str) -> Result<Pose, UrdfError> {
    let rpy = finite_vector(&origin.rpy, of)?;
    let turn = |axis: Vector3<f64>, angle: f64| exp_so3(&(axis * angle));
    let rotation =
        turn(Vector3::z(), rpy.z) * turn(Vector3::y(), rpy.y) * turn(Vector3::x(), rpy.x);
    Ok(Pose::from_parts(rotation, finite_vector(&origin.xyz, of)?))
}

fn finite_vector(xyz: &[f64; 3], of: &str) -> Result<Vector3<f64>, UrdfError> {
    if xyz.iter().all(|x| x.is_finite()) {
        Ok(Vector3::from(*xyz))
    } else {
        Err(UrdfError::Number(format!(
            "{of:?} has {xyz:?}, expected finite numbers"
        )))
    }
}

#[cfg(test)]
mod tests;
