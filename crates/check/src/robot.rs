//! The robot as the checker needs it: a tree of links, each with its own mass, moved by the plan's joints.
//!
//! Links that are fixed to each other stay separate bodies; they share a *group* for questions of collision.

use nalgebra::{Matrix3, Vector3};
use spatial::Pose;

use crate::shapes::LinkShape;

/// How a link moves relative to its parent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum JointMotion {
    /// Not at all (fixed joints, joints that the plan does not list, the base).
    Fixed,
    /// Turns about the unit `axis` (axes of the link) by entry `column` of the joint vector.
    Turns { axis: Vector3<f64>, column: usize },
    /// Slides along the unit `axis` (axes of the link) by entry `column` of the joint vector.
    Slides { axis: Vector3<f64>, column: usize },
}

/// One link.
#[derive(Debug, Clone)]
pub(crate) struct Link {
    pub name: String,
    /// Index of the parent, which stands before this link in the list; `None` for the base.
    pub parent: Option<usize>,
    /// Pose of the link at joint position zero; unused for the base.
    pub parent_from_link: Pose,
    pub motion: JointMotion,
    /// [kg]
    pub mass: f64,
    /// [m]
    pub com_in_link: Vector3<f64>,
    /// About the centre of mass, axes of the link [kg m²].
    pub inertia_in_link: Matrix3<f64>,
    /// Links with the same group never move relative to each other; 0 is the base's.
    pub group: usize,
}

/// Limits of one joint; infinite where there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct JointLimits {
    /// [rad or m]
    pub lower: f64,
    /// [rad or m]
    pub upper: f64,
    /// [rad/s or m/s]
    pub velocity: f64,
    /// [N m or N]
    pub effort: f64,
}

/// A floating base and its links, parents first.
#[derive(Debug, Clone)]
pub(crate) struct Robot {
    pub links: Vec<Link>,
    /// Names of the plan's joints, in its order.
    pub joints: Vec<String>,
    /// Limits of the plan's joints, in its order.
    pub limits: Vec<JointLimits>,
    /// Pose in the world of the frame that the base pose of `q` refers to (identity unless the URDF has a floating joint
    /// with an origin of its own).
    pub world_from_origin: Pose,
    /// Parent of each group; `None` for the base's.
    pub group_parent: Vec<Option<usize>>,
    /// Primitive shapes of the links.
    pub shapes: Vec<LinkShape>,
    /// Links with shapes that are not read (meshes).
    pub unread: Vec<String>,
}

impl Robot {
    /// Index of the link called `name`.
    pub fn link(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|link| link.name == name)
    }

    /// Total mass [kg].
    pub fn mass(&self) -> f64 {
        self.links.iter().map(|link| link.mass).sum()
    }

    /// Number of joints between two groups along the tree.
    pub fn joints_between(&self, a: usize, b: usize) -> usize {
        let (path_a, path_b) = (self.path_to_base(a), self.path_to_base(b));
        // Both paths end at the base; what they share at the end does not count.
        let shared = path_a
            .iter()
            .rev()
            .zip(path_b.iter().rev())
            .take_while(|(x, y)| x == y)
            .count();
        path_a.len() + path_b.len() - 2 * shared
    }

    fn path_to_base(&self, group: usize) -> Vec<usize> {
        std::iter::successors(Some(group), |g| self.group_parent[*g]).collect()
    }
}
