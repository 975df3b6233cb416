//! The types of the plan file, one struct per JSON object.
//!
//! Frames and units stand with each field; the contract in prose is `docs/plan-format.md`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::Explanation;

/// Keys that this version does not know, kept and written back.
pub type Extra = Map<String, Value>;

/// A pose `[x, y, z, qx, qy, qz, qw]` [m, unit quaternion with the scalar last].
pub type Pose7 = [f64; 7];

/// Six numbers, linear before angular (twist, acceleration, momentum) or force before moment (wrench).
pub type Row6 = [f64; 6];

/// One plan file. `K` phases, `N = Σ steps` intervals, `N + 1` nodes, `n` joints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Plan {
    /// Always [`crate::FORMAT`].
    #[schemars(extend("const" = "locotamp.plan/1"))]
    pub format: String,
    /// Program and version that wrote the file.
    #[serde(default)]
    pub generator: String,
    /// Name of the scene.
    #[serde(default)]
    pub task: String,
    /// Whether the writer holds the plan to satisfy all constraints.
    pub status: Status,
    /// What was minimised.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub objective: Option<Objective>,
    /// Largest constraint residual, SI units.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub violation: Option<f64>,
    /// Gravity in the world frame [m/s²].
    #[serde(default = "standard_gravity")]
    pub gravity: [f64; 3],
    /// How state `t + 1` follows from state `t`.
    pub integrator: Integrator,
    /// Which form of the robot's unactuated dynamics holds exactly.
    #[serde(default)]
    pub dynamics: Dynamics,
    /// The robot.
    pub robot: Robot,
    /// Movable rigid bodies.
    #[serde(default)]
    pub objects: Vec<Object>,
    /// Static bodies.
    #[serde(default)]
    pub environment: Vec<StaticBody>,
    /// Surfaces and points that can be in contact.
    pub interfaces: Vec<Interface>,
    /// Contacts that the last phase must hold.
    #[serde(default)]
    pub goal: Vec<GoalContact>,
    /// Boxes of the world in which bodies must be at the last node.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub goal_regions: Vec<GoalRegion>,
    /// The contact sequence with its wrenches, in order of time.
    pub phases: Vec<Phase>,
    /// Time of each node [s], `N + 1` values from zero.
    pub time: Vec<f64>,
    /// Configurations, `N + 1` rows of `7 + n`: base position [m], base quaternion, joints [rad or m].
    pub q: Vec<Vec<f64>>,
    /// Velocities, `N + 1` rows of `6 + n`: base linear, base angular (both in the base frame), joint rates.
    pub v: Vec<Vec<f64>>,
    /// Centroidal momentum, `N + 1` rows: linear [kg m/s], angular about the centre of mass [kg m²/s], world axes.
    pub h: Vec<Row6>,
    /// Time derivative of `v`, `N` rows of `6 + n`.
    pub a: Vec<Vec<f64>>,
    /// Joint torques by inverse dynamics, `N` rows of `n` [N m or N].
    pub tau: Vec<Vec<f64>>,
    /// Motion of the objects by name.
    #[serde(default)]
    pub object_states: BTreeMap<String, ObjectStates>,
    /// The cost by interval and term.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub costs: Option<Costs>,
    /// Why the motion is infeasible, if that was asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub explanation: Option<Explanation>,
    /// Unknown keys.
    #[serde(flatten)]
    pub extra: Extra,
}

fn standard_gravity() -> [f64; 3] {
    [0.0, 0.0, -9.81]
}

/// Verdict of the writer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// All constraints hold within the writer's tolerances.
    Feasible,
    /// Best effort: some constraint does not hold.
    Infeasible,
}

/// What was minimised.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Objective {
    /// Name, for people.
    pub name: String,
    /// Its value (seconds for `time`).
    pub value: f64,
    /// Full cost of the optimiser, regularisation included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost: Option<f64>,
    /// Unknown keys.
    #[serde(flatten)]
    pub extra: Extra,
}

/// How state `t + 1` follows from state `t` (⊕: exponential of the body-frame twist, addition for joints).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Integrator {
    /// `q[t+1] = q[t] ⊕ v[t]·dt`.
    Euler,
    /// `q[t+1] = q[t] ⊕ v[t+1]·dt`.
    SemiImplicitEuler,
    /// `q[t+1] = q[t] ⊕ (v[t]·dt + ½·a[t]·dt²)`.
    ConstantAcceleration,
}

/// Which form of the robot's unactuated dynamics holds exactly.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Dynamics {
    /// `h[t+1] − h[t] = dt · Σ wrenches`, with `h = A(q) v`.
    #[default]
    Momentum,
    /// The six unactuated rows of the equations of motion hold at node `t`.
    BaseRows,
}

/// The robot: a floating base and `n` joints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Robot {
    /// Name.
    #[serde(default)]
    pub name: String,
    /// The URDF text itself.
    pub urdf: String,
    /// Order of the joint entries of `q`, `v`, `a`, `tau`; movable joints not named stay at zero.
    pub joints: Vec<String>,
    /// Torque limits as enforced [N m], one per joint; `null`: not enforced for that joint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_limits: Option<Vec<Option<f64>>>,
    /// How torque falls with speed, as enforced, by joint; joints not named have their whole torque at every speed.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub torque_speed: BTreeMap<String, TorqueSpeed>,
    /// Unknown keys.
    #[serde(flatten)]
    pub extra: Extra,
}

/// Torque at speed: a joint that drives (torque and speed of the same sign) has its whole torque up to `corner` and from there
/// linearly less, down to none at `max`; one that brakes has all of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TorqueSpeed {
    /// Speed up to which the whole torque is available [rad/s or m/s].
    pub corner: f64,
    /// Speed at which none is left, above `corner` [rad/s or m/s].
    pub max: f64,
}

/// A movable rigid body; its frame has its origin at the centre of mass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Object {
    /// Name.
    pub name: String,
    /// Mass [kg].
    pub mass: f64,
    /// `[ixx, iyy, izz, ixy, ixz, iyz]` about the origin, body axes [kg m²].
    pub inertia: Row6,
    /// Shapes, in the body frame.
    #[serde(default)]
    pub geometry: Vec<Geometry>,
    /// Unknown keys.
    #[serde(flatten)]
    pub extra: Extra,
}

/// A static body; its frame is the world frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StaticBody {
    /// Name.
    pub name: String,
    /// Shapes, in the world frame.
    #[serde(default)]
    pub geometry: Vec<Geometry>,
    /// Unknown keys.
    #[serde(flatten)]
    pub extra: Extra,
}

/// One shape: a box (`box`) or a half-space below a plane (`plane`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Geometry {
    /// Half sizes of a box along its own axes [m].
    #[serde(rename = "box", default, skip_serializing_if = "Option::is_none")]
    pub half_size: Option<[f64; 3]>,
    /// True for the half-space z ≤ 0 of the shape's frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plane: Option<bool>,
    /// Pose of the shape in the body frame.
    pub pose: Pose7,
    /// Unknown keys.
    #[serde(flatten)]
    pub extra: Extra,
}

impl Geometry {
    /// A box of the given half sizes [m].
    pub fn cuboid(half_size: [f64; 3], pose: Pose7) -> Self {
        Self {
            half_size: Some(half_size),
            plane: None,
            pose,
            extra: Extra::new(),
        }
    }

    /// The half-space z ≤ 0 of `pose`.
    pub fn half_space(pose: Pose7) -> Self {
        Self {
            half_size: None,
            plane: Some(true),
            pose,
            extra: Extra::new(),
        }
    }

    /// True for the half-space below a plane.
    pub fn is_plane(&self) -> bool {
        self.plane == Some(true)
    }
}

/// A surface or point that can be in contact.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Interface {
    /// Name.
    pub name: String,
    /// Robot link, object or static body that carries it.
    pub body: String,
    /// Pose in the body frame; local z is the outward normal.
    pub pose: Pose7,
    /// Surface or point.
    pub kind: InterfaceKind,
    /// Half extents of a patch along its own x and y [m]; `null`: unbounded.
    #[serde(default)]
    pub half_size: Option<[Option<f64>; 2]>,
    /// Direction from the contact into the limb, own axes (default `[0, 0, -1]`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limb: Option<[f64; 3]>,
    /// Unknown keys.
    #[serde(flatten)]
    pub extra: Extra,
}

/// Kind of an interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum InterfaceKind {
    /// A flat rectangle (or plane).
    Patch,
    /// A point.
    Point,
}

/// A contact pair that the last phase must hold.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct GoalContact {
    /// Interface that touches.
    pub a: String,
    /// Interface that is touched.
    pub b: String,
    /// Unknown keys.
    #[serde(flatten)]
    pub extra: Extra,
}

/// A box of the world in which the origin of a body must be at the last node, and how the body must be turned there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GoalRegion {
    /// Object, robot link or interface.
    pub body: String,
    /// Least x, y, z [m]; `null`: unbounded.
    pub lower: [Option<f64>; 3],
    /// Greatest x, y, z [m]; `null`: unbounded.
    pub upper: [Option<f64>; 3],
    /// Least and greatest heading of its x axis about the world's z [rad].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw: Option<[f64; 2]>,
    /// Greatest angle between its z axis and the world's [rad].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tilt: Option<f64>,
    /// Unknown keys.
    #[serde(flatten)]
    pub extra: Extra,
}

/// A time span with constant contacts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Phase {
    /// Duration [s].
    pub duration: f64,
    /// Number of intervals, of `duration / steps` each.
    #[schemars(range(min = 1))]
    pub steps: usize,
    /// What changed on entering this phase, for people.
    #[serde(default)]
    pub action: String,
    /// Every pair of interfaces that carries load.
    pub contacts: Vec<Contact>,
    /// Unknown keys.
    #[serde(flatten)]
    pub extra: Extra,
}

/// A contact of a phase: `a` touches `b`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Contact {
    /// Interface that touches (foot, hand, object bottom).
    pub a: String,
    /// Interface that is touched.
    pub b: String,
    /// Type.
    #[serde(rename = "type")]
    pub kind: ContactType,
    /// Sliding friction coefficient.
    #[serde(default)]
    pub mu: f64,
    /// Torsional friction coefficient [m].
    #[serde(default)]
    pub mu_r: f64,
    /// True: only the origin of `a`, not its rectangle, must stay inside the extent of `b`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub overhang: bool,
    /// What `b` exerts on `a`, one row per interval: force [N], moment [N m], world axes, about the origin of `a`.
    pub wrench: Vec<Row6>,
    /// Unknown keys.
    #[serde(flatten)]
    pub extra: Extra,
}

/// Type of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ContactType {
    /// Pushes, transmits no moment.
    UnilateralPoint,
    /// Pushes and pulls, transmits no moment (a ball joint).
    BilateralPoint,
    /// Pushes; moment within the centre-of-pressure and torsion limits.
    UnilateralPatch,
    /// A full grasp.
    BilateralPatch,
}

impl ContactType {
    /// True if the contact can only push.
    pub fn is_unilateral(self) -> bool {
        matches!(self, Self::UnilateralPoint | Self::UnilateralPatch)
    }

    /// True if `a` is a patch lying on `b`.
    pub fn is_patch(self) -> bool {
        matches!(self, Self::UnilateralPatch | Self::BilateralPatch)
    }
}

/// Motion of one object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ObjectStates {
    /// Poses in the world frame, `N + 1` rows.
    pub pose: Vec<Pose7>,
    /// Twists in the object frame, `N + 1` rows.
    pub twist: Vec<Row6>,
    /// Time derivative of `twist`, `N` rows.
    pub accel: Vec<Row6>,
    /// Unknown keys.
    #[serde(flatten)]
    pub extra: Extra,
}

/// The cost by interval and term: all of `per_interval` and `end` add up to the cost of the objective, but for rounding.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Costs {
    /// Names of the terms, the columns of `per_interval`.
    pub terms: Vec<String>,
    /// What each interval costs, `N` rows.
    pub per_interval: Vec<Vec<f64>>,
    /// What counts once, at the last node; negative what is rewarded.
    #[serde(default)]
    pub end: BTreeMap<String, f64>,
    /// Unknown keys.
    #[serde(flatten)]
    pub extra: Extra,
}

impl Plan {
    /// Number of joints `n`.
    pub fn n_joints(&self) -> usize {
        self.robot.joints.len()
    }

    /// Number of intervals `N` (saturating, so that a hostile file cannot overflow it).
    pub fn n_intervals(&self) -> usize {
        self.phases
            .iter()
            .fold(0, |n, phase| n.saturating_add(phase.steps))
    }

    /// First node of each phase, then the last node of the plan: `K + 1` values.
    pub fn phase_starts(&self) -> Vec<usize> {
        let ends = self.phases.iter().scan(0usize, |n, phase| {
            *n = n.saturating_add(phase.steps);
            Some(*n)
        });
        std::iter::once(0).chain(ends).collect()
    }

    /// Total time [s]: the sum of the phases' durations.
    pub fn duration(&self) -> f64 {
        self.phases.iter().map(|phase| phase.duration).sum()
    }
}
