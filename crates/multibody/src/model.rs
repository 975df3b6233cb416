//! The constants of a robot: a tree of joints, each with the inertia of everything rigidly attached to it.
//!
//! Frames: the frame of a joint moves with its child link and coincides with the frame of that link.

use crate::ModelError;
use nalgebra::Vector3;
use spatial::{Inertia, Pose};

/// Gravity of a new model [m/s²].
const STANDARD_GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// Joints beyond this number are refused: the tables of ancestors grow with its square.
const MAX_JOINTS: usize = 512;

/// A principal moment of inertia may be below zero by this part of the trace: published files round and approximate.
const INERTIA_TOLERANCE: f64 = 1e-3;

/// Rounding of a moment of inertia that should be zero [kg·m²].
const INERTIA_ROUNDING: f64 = 1e-12;

/// Axes are unit vectors to this accuracy.
const UNIT_TOLERANCE: f64 = 1e-9;

/// How the root link is connected to the world.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Root {
    /// By six degrees of freedom.
    Floating,
    /// Not movable.
    Fixed,
}

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointKind {
    /// Six degrees of freedom; q is position and quaternion (x y z w), v the body twist, linear first.
    FreeFlyer,
    /// Turns, q in rad.
    Revolute {
        /// Unit vector in the joint frame.
        axis: Vector3<f64>,
    },
    /// Slides, q in m.
    Prismatic {
        /// Unit vector in the joint frame.
        axis: Vector3<f64>,
    },
}

impl JointKind {
    /// Number of entries in q.
    #[inline]
    pub fn nq(&self) -> usize {
        if matches!(self, Self::FreeFlyer) {
            7
        } else {
            1
        }
    }

    /// Number of entries in v.
    #[inline]
    pub fn nv(&self) -> usize {
        if matches!(self, Self::FreeFlyer) {
            6
        } else {
            1
        }
    }
}

/// A moving joint with the body behind it.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name, unique in the model.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// The joint that it hangs on; `None` for the world.
    pub parent: Option<usize>,
    /// Pose of the joint frame in the frame of the parent joint at q = 0.
    pub parent_from_joint: Pose,
    /// Inertia of everything rigidly attached, in the joint frame.
    pub inertia: Inertia,
    /// First entry in q.
    pub idx_q: usize,
    /// First entry in v.
    pub idx_v: usize,
    /// Smallest position [rad or m]; −∞ if unbounded.
    pub lower: f64,
    /// Largest position [rad or m]; +∞ if unbounded.
    pub upper: f64,
    /// Largest speed [rad/s or m/s]; +∞ if not given.
    pub velocity_limit: f64,
    /// Largest torque or force [N·m or N]; +∞ if not given.
    pub torque_limit: f64,
    /// How that falls with speed; `None` if it does not.
    pub torque_speed: Option<TorqueSpeed>,
}

/// What a motor that drives can give at speed: its largest torque up to a corner speed, from there linearly down to nothing.
/// A motor that brakes (torque against speed) gives its largest torque at every speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueSpeed {
    /// Speed up to which the largest torque is available [rad/s or m/s], above 0.
    pub corner: f64,
    /// Speed at which none is left [rad/s or m/s], above `corner`.
    pub no_load: f64,
}

impl TorqueSpeed {
    /// Share of the largest torque that is available at a speed, which is positive where the torque drives; negative beyond
    /// the speed at which none is left.
    pub fn available(&self, speed: f64) -> f64 {
        ((self.no_load - speed) / (self.no_load - self.corner)).min(1.0)
    }
}

/// Geometry of a link, centred at its own frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A cuboid.
    Box {
        /// Half sizes along the axes [m].
        half_size: Vector3<f64>,
    },
    /// A ball.
    Sphere {
        /// Radius [m].
        radius: f64,
    },
    /// A cylinder about the z axis.
    Cylinder {
        /// Radius [m].
        radius: f64,
        /// It reaches from −`half_length` to `half_length` [m].
        half_length: f64,
    },
    /// A segment along the z axis, thickened.
    Capsule {
        /// Radius [m].
        radius: f64,
        /// The segment reaches from −`half_length` to `half_length` [m].
        half_length: f64,
    },
    /// A file, which is not read here.
    Mesh {
        /// As the URDF names it.
        filename: String,
        /// Factors along the axes.
        scale: Vector3<f64>,
    },
}

/// A shape placed on a link.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedShape {
    /// Pose of the shape in the frame of the link.
    pub frame_from_shape: Pose,
    /// The shape.
    pub shape: Shape,
}

/// The frame of a link, rigidly attached to a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Name of the link, unique in the model.
    pub name: String,
    /// The joint that moves it; `None` for the world.
    pub joint: Option<usize>,
    /// Pose in the frame of that joint (or in the world).
    pub joint_from_frame: Pose,
    /// Collision shapes.
    pub shapes: Vec<PlacedShape>,
}

/// How the columns of a joint are made, sorted out once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Motion {
    Free,
    /// Turns about the own axis 0, 1 or 2.
    TurnAbout(usize),
    Turn(Vector3<f64>),
    Slide(Vector3<f64>),
}

/// A robot: joints in depth-first order (parents before children), frames, sizes.
#[derive(Debug, Clone)]
pub struct Model {
    /// Name for people.
    pub name: String,
    /// Moving joints; joint 0 is the free flyer of a floating base.
    pub joints: Vec<Joint>,
    /// One per link, in the order of the tree.
    pub frames: Vec<Frame>,
    /// Length of q.
    pub nq: usize,
    /// Length of v.
    pub nv: usize,
    /// Gravity in the world [m/s²].
    pub gravity: Vector3<f64>,
    /// What was read in a way that its author may not expect (locked joints, skipped geometry), as sentences.
    pub notes: Vec<String>,
    /// Joints of the description that cannot move on their own, by name, and where they are locked [rad or m].
    pub locked: Vec<(String, f64)>,
    pub(crate) motions: Vec<Motion>,
    pub(crate) supports: Vec<Vec<usize>>,
}

impl Model {
    /// A robot from its joints, parents before children; `idx_q` and `idx_v` are assigned here.
    ///
    /// # Errors
    /// [`ModelError::BadTree`] for a wrong order, parent or frame, or a free flyer with a parent (several free bodies are
    /// legal: a forest), [`ModelError::BadAxis`] for an
    /// axis that is no unit vector, [`ModelError::BadLimits`], [`ModelError::BadInertia`], [`ModelError::MissingInertia`] if
    /// a joint moves no mass.
    pub fn new(name: &str, mut joints: Vec<Joint>, frames: Vec<Frame>) -> Result<Self, ModelError> {
        if joints.len() > MAX_JOINTS {
            return Err(ModelError::TooManyJoints { limit: MAX_JOINTS });
        }
        check_tree(&joints)?;
        check_masses(&joints)?;
        for frame in &frames {
            if frame.joint.is_some_and(|joint| joint >= joints.len()) {
                let problem = "a frame is attached to a joint that does not exist";
                return Err(ModelError::BadTree {
                    joint: frame.name.clone(),
                    index: joints.len(),
                    problem,
                });
            }
        }
        let (mut nq, mut nv) = (0, 0);
        let mut supports: Vec<Vec<usize>> = Vec::with_capacity(joints.len());
        for joint in &mut joints {
            (joint.idx_q, joint.idx_v) = (nq, nv);
            (nq, nv) = (nq + joint.kind.nq(), nv + joint.kind.nv());
            let mut support = joint
                .parent
                .map_or_else(Vec::new, |parent| supports[parent].clone());
            support.extend(joint.idx_v..nv);
            supports.push(support);
        }
        let motions = joints.iter().map(|joint| motion(&joint.kind)).collect();
        let (name, gravity) = (name.to_owned(), STANDARD_GRAVITY);
        Ok(Self {
            name,
            joints,
            frames,
            nq,
            nv,
            gravity,
            notes: Vec::new(),
            locked: Vec::new(),
            motions,
            supports,
        })
    }

    /// Velocity indices that move a joint, from the root to its own, ascending.
    #[inline]
    pub fn joint_support(&self, joint: usize) -> &[usize] {
        &self.supports[joint]
    }

    /// Velocity indices that move a frame, from the root to the tip, ascending; empty for a frame of the world.
    #[inline]
    pub fn frame_support(&self, frame: usize) -> &[usize] {
        self.frames[frame]
            .joint
            .map_or(&[], |joint| &self.supports[joint])
    }

    /// Index of the frame of the link `name`.
    pub fn frame_id(&self, name: &str) -> Option<usize> {
        self.frames.iter().position(|frame| frame.name == name)
    }

    /// Index of the joint `name`.
    pub fn joint_id(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }

    /// Mass of everything that moves [kg].
    pub fn total_mass(&self) -> f64 {
        self.joints.iter().map(|joint| joint.inertia.mass).sum()
    }
}

fn motion(kind: &JointKind) -> Motion {
    match kind {
        JointKind::FreeFlyer => Motion::Free,
        JointKind::Prismatic { axis } => Motion::Slide(*axis),
        JointKind::Revolute { axis } => {
            let units = [Vector3::x(), Vector3::y(), Vector3::z()];
            units
                .iter()
                .position(|unit| unit == axis)
                .map_or(Motion::Turn(*axis), Motion::TurnAbout)
        }
    }
}

fn check_tree(joints: &[Joint]) -> Result<(), ModelError> {
    for (index, joint) in joints.iter().enumerate() {
        let bad = |problem| {
            Err(ModelError::BadTree {
                joint: joint.name.clone(),
                index,
                problem,
            })
        };
        if joint.parent.is_some_and(|parent| parent >= index) {
            return bad("its parent comes after it, expected parents before children");
        }
        // Depth-first: the parent is the previous joint or one of its ancestors.
        let mut open = index.checked_sub(1);
        while open != joint.parent {
            match open {
                Some(previous) => open = joints[previous].parent,
                None => {
                    return bad(
                        "it is out of order, expected each subtree in one piece (depth first)",
                    );
                }
            }
        }
        match joint.kind {
            JointKind::FreeFlyer if joint.parent.is_some() => {
                return bad("a free flyer has no parent");
            }
            JointKind::FreeFlyer => {}
            JointKind::Revolute { axis } | JointKind::Prismatic { axis } => {
                let length = axis.norm();
                if length.is_nan() || (length - 1.0).abs() > UNIT_TOLERANCE {
                    return Err(ModelError::BadAxis {
                        joint: joint.name.clone(),
                        length,
                    });
                }
            }
        }
        let (lower, upper) = (joint.lower, joint.upper);
        if lower.is_nan() || upper.is_nan() || lower > upper {
            return Err(ModelError::BadLimits {
                joint: joint.name.clone(),
                lower,
                upper,
            });
        }
    }
    Ok(())
}

/// Every joint must move some mass, else the mass matrix is singular, and no body may have negative moments of inertia.
fn check_masses(joints: &[Joint]) -> Result<(), ModelError> {
    let mut moved: Vec<f64> = joints.iter().map(|joint| joint.inertia.mass).collect();
    for (index, joint) in joints.iter().enumerate().rev() {
        if moved[index].is_nan() || moved[index] <= 0.0 {
            let joint = joint.name.clone();
            return Err(ModelError::MissingInertia {
                link: format!("behind {joint}"),
                joint,
            });
        }
        if let Some(parent) = joint.parent {
            moved[parent] += moved[index];
        }
        let tensor = &joint.inertia.inertia;
        let finite = tensor
            .iter()
            .chain(&joint.inertia.com)
            .all(|x| x.is_finite());
        let eigenvalue = if finite {
            tensor.symmetric_eigenvalues().min()
        } else {
            f64::NAN
        };
        if eigenvalue.is_nan()
            || eigenvalue < -INERTIA_TOLERANCE * tensor.trace().abs() - INERTIA_ROUNDING
        {
            return Err(ModelError::BadInertia {
                joint: joint.name.clone(),
                eigenvalue,
            });
        }
    }
    Ok(())
}
