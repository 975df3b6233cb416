//! The resolved scene: everything validated, every name replaced by an index.

use multibody::Model;
use nalgebra::{Matrix3, Vector3};
use spatial::Pose;
use symbolic::pddl::DomainFile;
use symbolic::{Contact, ContactType, InterfaceId};

/// A convex primitive, centred at its own frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A cuboid.
    Box {
        /// Half sizes along the own axes [m].
        half_size: Vector3<f64>,
    },
    /// A segment along the own z axis, thickened.
    Capsule {
        /// Radius [m].
        radius: f64,
        /// The segment reaches from −`half_length` to `half_length` [m].
        half_length: f64,
    },
    /// A ball.
    Sphere {
        /// Radius [m].
        radius: f64,
    },
    /// The half-space below the own z = 0 plane (static bodies only).
    HalfSpace,
}

/// A shape placed on a body.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedShape {
    /// Pose of the shape in the body frame.
    pub body_from_shape: Pose,
    /// The shape.
    pub shape: Shape,
}

/// Which kind of body carries an interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Owner {
    /// A link of the robot.
    Robot {
        /// Index into `Model::frames` (one frame per URDF link).
        frame: usize,
    },
    /// A movable object: index into `Scene::objects`.
    Object(usize),
    /// A static body: index into `Scene::statics`.
    Static(usize),
}

/// What an end-effector is used for; guides defaults (who carries weight, who grasps), forbids nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// A foot: carries the robot at the start.
    Foot,
    /// A hand: grasps and supports.
    Hand,
    /// A surface of an object or of the environment.
    Surface,
}

/// A surface or point that can be in contact (paper: i ∈ 𝓘).
#[derive(Debug, Clone, PartialEq)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "each says something else of a surface"
)]
pub struct Interface {
    /// Unique name in the scene.
    pub name: String,
    /// The body that carries it.
    pub owner: Owner,
    /// What it is used for.
    pub role: Role,
    /// Pose in the frame of the link, object or (static bodies) the world; local z is the outward normal.
    pub body_from_interface: Pose,
    /// True for a patch, false for a point.
    pub patch: bool,
    /// Half extents along the own x and y [m]; `None` is unbounded.
    pub half_size: Option<[f64; 2]>,
    /// Unit direction from the contact into the limb, own axes.
    pub limb: Vector3<f64>,
    /// Contact types that it supports (as the landing side and as the side that is landed on).
    pub contact_types: Vec<ContactType>,
    /// Largest force through one contact of this interface [N]; +∞ if unlimited.
    pub max_force: f64,
    /// Largest moment through one contact of this interface [N·m]; +∞ if unlimited.
    pub max_moment: f64,
    /// Sliding friction coefficient of this surface; a contact uses the smaller of its two.
    pub mu: f64,
    /// Torsional friction coefficient [m]; a contact uses the smaller of its two.
    pub mu_r: f64,
    /// True if a patch larger than this one may rest on it, its centre inside.
    pub overhang: bool,
    /// May feet stand on it.
    pub bears_feet: bool,
    /// True if it can be the landing side `a` of a contact: hands, feet, bottoms of objects. Others are only landed on.
    pub lands: bool,
}

/// A movable rigid body; its frame has its origin at the centre of mass.
#[derive(Debug, Clone, PartialEq)]
pub struct Object {
    /// Unique name.
    pub name: String,
    /// Mass [kg].
    pub mass: f64,
    /// Inertia about the origin, body axes [kg·m²].
    pub inertia: Matrix3<f64>,
    /// Its shapes.
    pub shapes: Vec<PlacedShape>,
    /// Pose at the start.
    pub world_from_start: Pose,
}

/// A body that never moves; its shapes are placed in the world.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticBody {
    /// Unique name.
    pub name: String,
    /// Its shapes, `body_from_shape` is world-from-shape.
    pub shapes: Vec<PlacedShape>,
}

/// The robot with everything that the planner needs beside its dynamics.
#[derive(Debug, Clone)]
pub struct Robot {
    /// Name for people and plan files.
    pub name: String,
    /// The URDF text, written into plans.
    pub urdf: String,
    /// Rigid-body model (floating base).
    pub model: Model,
    /// Nominal standing joint positions (length n), costs pull towards it [rad or m].
    pub home: Vec<f64>,
    /// Collision shapes per frame (link) of the model, `body_from_shape` is link-from-shape.
    pub shapes: Vec<Vec<PlacedShape>>,
}

/// A region that the origin of a body must reach at the end, and its orientation there.
#[derive(Debug, Clone, PartialEq)]
pub struct RegionGoal {
    /// Name of an object, of a robot link or interface, or "base".
    pub body: String,
    /// Lower corner in the world [m]; −∞ where free.
    pub lower: Vector3<f64>,
    /// Upper corner in the world [m]; +∞ where free.
    pub upper: Vector3<f64>,
    /// Smallest and largest heading of its x axis about the world's z [rad], less than a full turn apart; `None`: free.
    pub yaw: Option<[f64; 2]>,
    /// Largest angle between its z axis and the world's [rad], at most a right angle; `None`: free.
    pub tilt: Option<f64>,
}

/// What is sought beside the goal.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Objective {
    /// Least time and effort.
    #[default]
    Time,
    /// Highest base at the end.
    BaseHeight,
    /// A body as far as possible along a direction at the end.
    Reach {
        /// Name of an object, of a robot link or interface, or "base".
        body: String,
        /// Unit vector in the world.
        direction: Vector3<f64>,
    },
}

/// A contact pair demanded at the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GoalContact {
    /// One side.
    pub a: InterfaceId,
    /// The other side.
    pub b: InterfaceId,
}

/// Options of the search (`[search]` of a scene file).
#[derive(Debug, Clone, PartialEq)]
pub struct SearchOptions {
    /// Largest number of phases K_max; `None`: derived from the scene.
    pub max_phases: Option<usize>,
    /// Largest number of skeleton actions N_PDDL; `None`: derived from the scene.
    pub max_skeleton: Option<usize>,
    /// Most contact changes of free interfaces in one action.
    pub max_changes: usize,
    /// May free hands make supporting contacts.
    pub support_hands: bool,
    /// May the robot be in the air, carried by nothing.
    pub flights: bool,
    /// Intervals per phase during the search, before refinement.
    pub steps: usize,
    /// The actions that move objects; `None`: the built-in ones.
    pub domain: Option<DomainFile>,
}

/// Options of the optimiser (`[optimiser]` of a scene file).
#[derive(Debug, Clone, PartialEq)]
pub struct OptimiserOptions {
    /// Intervals per phase N_s.
    pub steps: usize,
    /// Shortest phase [s].
    pub min_duration: f64,
    /// Longest phase [s].
    pub max_duration: f64,
    /// Are the torque limits enforced.
    pub torque_limits: bool,
    /// Iteration limit of one solve.
    pub max_iterations: usize,
}

/// A validated scene.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Task name.
    pub name: String,
    /// Gravity in the world [m/s²].
    pub gravity: Vector3<f64>,
    /// The robot.
    pub robot: Robot,
    /// Start configuration: base position, base quaternion (x y z w), joints; length 7 + n.
    pub start: Vec<f64>,
    /// Movable objects.
    pub objects: Vec<Object>,
    /// Static bodies.
    pub statics: Vec<StaticBody>,
    /// All interfaces 𝓘: robot, objects, static bodies, in this order.
    pub interfaces: Vec<Interface>,
    /// Contacts at the start.
    pub start_contacts: Vec<Contact>,
    /// Contacts demanded at the end.
    pub goal_contacts: Vec<GoalContact>,
    /// Regions demanded at the end.
    pub goal_regions: Vec<RegionGoal>,
    /// Objective beside the goal.
    pub objective: Objective,
    /// Search options.
    pub search: SearchOptions,
    /// Optimiser options.
    pub optimiser: OptimiserOptions,
    /// Numbers of the file that look like mistakes, in words.
    pub doubts: Vec<String>,
}
