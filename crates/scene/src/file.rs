//! The scene file as written: one struct per TOML table.
//!
//! The doc comments here become the descriptions in `docs/scene.schema.json`.

use crate::source::At;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use symbolic::ContactType;

/// A scene: robot, start, movable objects, static bodies, goal or objective, options. SI units, radians, z up.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a scene")]
#[schemars(title = "locotamp scene")]
pub(crate) struct SceneFile {
    /// Name of the task, for people and plan files.
    pub name: At<String>,
    /// Name of a built-in robot ("g1"), or path of a robot file (.toml), a URDF or an MJCF (.urdf, .xml), relative to the scene file.
    pub robot: At<String>,
    /// Folder with the mesh files of the robot's URDF, relative to the scene file: links collide with shapes fitted around them.
    pub meshes: Option<At<String>>,
    /// Gravity in the world [m/s²]; default [0, 0, -9.81].
    pub gravity: Option<At<[f64; 3]>>,
    /// Friction of all surfaces that give none of their own.
    #[serde(default)]
    pub friction: FrictionEntry,
    /// Configuration and contacts at the start.
    #[serde(default)]
    pub start: StartEntry,
    /// Movable rigid bodies.
    #[serde(default)]
    pub object: Vec<ObjectEntry>,
    /// Bodies that never move.
    #[serde(default, rename = "static")]
    pub statics: Vec<StaticEntry>,
    /// Interfaces of the robot beside those of its robot file; needed if `robot` is a bare URDF or MJCF.
    #[serde(default)]
    pub robot_interface: Vec<RobotInterfaceEntry>,
    /// What must hold at the end.
    pub goal: Option<At<GoalEntry>>,
    /// What else is sought.
    pub objective: Option<ObjectiveEntry>,
    /// Options of the search for a contact sequence.
    #[serde(default)]
    pub search: SearchEntry,
    /// Options of the trajectory optimisation.
    #[serde(default)]
    pub optimiser: OptimiserEntry,
}

/// Friction coefficients; a contact uses the smaller of its two interfaces' values.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table with mu, mu_r")]
pub(crate) struct FrictionEntry {
    /// Sliding friction coefficient; default 0.7.
    pub mu: Option<At<f64>>,
    /// Torsional friction coefficient [m]; default 0.02.
    pub mu_r: Option<At<f64>>,
}

/// Configuration and contacts at the start.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table with position, yaw, …")]
pub(crate) struct StartEntry {
    /// Base position in the world [m], default [0, 0]; without the third number the feet are put on the surface below.
    pub position: Option<At<XyMaybeZ>>,
    /// Turn of the base about the world's z [rad]; default 0.
    pub yaw: Option<At<f64>>,
    /// Orientation of the base, unit quaternion [x, y, z, w]; instead of yaw.
    pub quaternion: Option<At<[f64; 4]>>,
    /// Joint positions that differ from the robot's home [rad or m].
    #[serde(default)]
    pub joints: BTreeMap<At<String>, At<f64>>,
    /// Contacts of the robot, as pairs or triples [interface, surface, type]; default: every foot on the surface below it.
    pub contacts: Option<Vec<At<ContactEntry>>>,
}

/// Two or three coordinates [m].
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(transparent)]
pub(crate) struct XyMaybeZ(#[schemars(length(min = 2, max = 3))] pub Vec<f64>);

/// A contact: interface, surface and, if several are possible, the type.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(transparent)]
pub(crate) struct ContactEntry(#[schemars(length(min = 2, max = 3))] pub Vec<At<String>>);

/// A movable rigid body.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table of an object")]
pub(crate) struct ObjectEntry {
    /// Name, unique among all bodies.
    pub name: At<String>,
    /// Mass [kg].
    pub mass: At<f64>,
    /// Full sizes [m] of a box centred at the body frame; makes the interface "<name>_bottom".
    pub size: Option<At<[f64; 3]>>,
    /// Further shapes, in the body frame.
    #[serde(default)]
    pub shape: Vec<At<ShapeEntry>>,
    /// Centre of mass in the body frame [m]; default: of uniform density.
    pub centre_of_mass: Option<At<[f64; 3]>>,
    /// [ixx, iyy, izz, ixy, ixz, iyz] about the centre of mass, body axes [kg·m²]; default: of uniform density.
    pub inertia: Option<At<[f64; 6]>>,
    /// Where it is: in the world (3 numbers) [m], or with `on` in the plane of that interface from its centre (2 numbers,
    /// default [0, 0]).
    pub position: Option<At<XyMaybeZ>>,
    /// Turn about the world's z, or with `on` about the normal of that interface [rad]; default 0.
    pub yaw: Option<At<f64>>,
    /// Orientation in the world, unit quaternion [x, y, z, w]; instead of yaw, not with `on`.
    pub quaternion: Option<At<[f64; 4]>>,
    /// Interface that it stands on, such as "table_top".
    pub on: Option<At<String>>,
    /// Which of its interfaces stands on `on`; default "<name>_bottom".
    pub with: Option<At<String>>,
    /// False: no interface "<name>_bottom"; default true.
    pub bottom: Option<bool>,
    /// Sliding friction coefficient of its interfaces; default: of [friction].
    pub mu: Option<At<f64>>,
    /// Torsional friction coefficient of its interfaces [m]; default: of [friction].
    pub mu_r: Option<At<f64>>,
    /// Patches, handles and points that can be touched.
    #[serde(default)]
    pub interface: Vec<At<InterfaceEntry>>,
}

/// A body that never moves.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table of a static body")]
pub(crate) struct StaticEntry {
    /// Name, unique among all bodies.
    pub name: At<String>,
    /// Full sizes [m] of a box centred at the body frame; makes the interface "<name>_top".
    pub size: Option<At<[f64; 3]>>,
    /// True: everything below the plane z = 0 of the body frame; makes the interface "<name>_top".
    pub plane: Option<At<bool>>,
    /// Further shapes, in the body frame.
    #[serde(default)]
    pub shape: Vec<At<ShapeEntry>>,
    /// Body frame in the world [m]; default [0, 0, 0].
    pub position: Option<At<[f64; 3]>>,
    /// Turn about the world's z [rad]; default 0.
    pub yaw: Option<At<f64>>,
    /// Orientation in the world, unit quaternion [x, y, z, w]; instead of yaw.
    pub quaternion: Option<At<[f64; 4]>>,
    /// False: no interface "<name>_top"; default true.
    pub top: Option<bool>,
    /// Sliding friction coefficient of its interfaces; default: of [friction].
    pub mu: Option<At<f64>>,
    /// Torsional friction coefficient of its interfaces [m]; default: of [friction].
    pub mu_r: Option<At<f64>>,
    /// Further surfaces that can be touched.
    #[serde(default)]
    pub interface: Vec<At<InterfaceEntry>>,
}

/// One convex shape: exactly one of box, sphere, capsule.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table with box, sphere or capsule")]
pub(crate) struct ShapeEntry {
    /// Full sizes [m].
    #[serde(rename = "box")]
    pub cuboid: Option<At<[f64; 3]>>,
    /// Radius [m].
    pub sphere: Option<At<f64>>,
    /// A segment along the own z axis, thickened.
    pub capsule: Option<CapsuleEntry>,
    /// Centre in the body frame [m]; default [0, 0, 0].
    pub position: Option<At<[f64; 3]>>,
    /// Turn about the body's z [rad]; default 0.
    pub yaw: Option<At<f64>>,
    /// Orientation in the body frame, unit quaternion [x, y, z, w]; instead of yaw.
    pub quaternion: Option<At<[f64; 4]>>,
}

/// A segment along the own z axis, thickened.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table with radius, length")]
pub(crate) struct CapsuleEntry {
    /// Radius [m].
    pub radius: At<f64>,
    /// Length of the segment, without the round ends [m].
    pub length: At<f64>,
}

/// Patch or point.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum KindEntry {
    /// A flat rectangle.
    #[default]
    Patch,
    /// A point.
    Point,
}

/// A side of the box `size`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
pub(crate) enum SideEntry {
    /// The normal is the body's x.
    #[serde(rename = "+x")]
    PlusX,
    /// The normal is against the body's x.
    #[serde(rename = "-x")]
    MinusX,
    /// The normal is the body's y.
    #[serde(rename = "+y")]
    PlusY,
    /// The normal is against the body's y.
    #[serde(rename = "-y")]
    MinusY,
    /// The normal is the body's z.
    #[serde(rename = "+z")]
    PlusZ,
    /// The normal is against the body's z.
    #[serde(rename = "-z")]
    MinusZ,
}

/// How two interfaces touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ContactTypeEntry {
    /// A point pushes on a patch.
    UnilateralPoint,
    /// A point held by a patch, a ball joint.
    BilateralPoint,
    /// A patch pushes on a patch.
    UnilateralPatch,
    /// A full grasp.
    BilateralPatch,
}

impl From<ContactTypeEntry> for ContactType {
    fn from(entry: ContactTypeEntry) -> Self {
        match entry {
            ContactTypeEntry::UnilateralPoint => Self::UnilateralPoint,
            ContactTypeEntry::BilateralPoint => Self::BilateralPoint,
            ContactTypeEntry::UnilateralPatch => Self::UnilateralPatch,
            ContactTypeEntry::BilateralPatch => Self::BilateralPatch,
        }
    }
}

/// A surface or point of an object or static body.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table of an interface")]
pub(crate) struct InterfaceEntry {
    /// Name, unique among all interfaces.
    pub name: At<String>,
    /// "patch" (default) or "point".
    #[serde(default)]
    pub kind: KindEntry,
    /// Direction of the outward normal by a side of the body: "+x", "-x", "+y", "-y", "+z", "-z".
    pub side: Option<At<SideEntry>>,
    /// Origin in the body frame [m]; default with `side` and `size`: the centre of that side.
    pub position: Option<At<[f64; 3]>>,
    /// Orientation in the body frame, unit quaternion [x, y, z, w], local z outward; instead of side.
    pub quaternion: Option<At<[f64; 4]>>,
    /// Half extents of a patch along its own x and y [m]; default with `side` and without `position`: the whole side.
    pub half_size: Option<At<[f64; 2]>>,
    /// Contact types that it takes part in; default: the unilateral ones.
    pub contacts: Option<At<Vec<ContactTypeEntry>>>,
    /// True if this surface of an object may be set down on others, like a bottom; default false.
    pub lands: Option<At<bool>>,
    /// True if a patch larger than this one may rest on it, its centre inside; default false.
    pub overhang: Option<bool>,
    /// False if no foot may stand on it; default true.
    pub feet: Option<bool>,
    /// Largest force through one contact [N]; default unlimited.
    pub max_force: Option<At<f64>>,
    /// Largest moment through one contact [N·m]; default unlimited.
    pub max_moment: Option<At<f64>>,
    /// Sliding friction coefficient; default: of the body.
    pub mu: Option<At<f64>>,
    /// Torsional friction coefficient [m]; default: of the body.
    pub mu_r: Option<At<f64>>,
}

/// What an end-effector of the robot is used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum RoleEntry {
    /// It carries the robot at the start.
    Foot,
    /// It grasps and supports.
    Hand,
}

/// An end-effector surface or point of the robot.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table of a robot interface")]
pub(crate) struct RobotInterfaceEntry {
    /// Name, unique among all interfaces.
    pub name: At<String>,
    /// Link of the URDF that carries it.
    pub link: At<String>,
    /// "patch" or "point".
    pub kind: KindEntry,
    /// "foot" or "hand".
    pub role: RoleEntry,
    /// [x, y, z, qx, qy, qz, qw] in the link frame [m, unit quaternion]; local z is the outward normal.
    pub pose: At<[f64; 7]>,
    /// Half extents of a patch along its own x and y [m].
    pub half_size: Option<At<[f64; 2]>>,
    /// Direction from the contact into the limb, own axes; default [0, 0, -1].
    pub limb: Option<At<[f64; 3]>>,
    /// Contact types that it can make.
    pub contacts: At<Vec<ContactTypeEntry>>,
    /// Largest force through one contact [N]; default unlimited.
    pub max_force: Option<At<f64>>,
    /// Largest moment through one contact [N·m]; default unlimited.
    pub max_moment: Option<At<f64>>,
    /// Sliding friction coefficient; default: of [friction].
    pub mu: Option<At<f64>>,
    /// Torsional friction coefficient [m]; default: of [friction].
    pub mu_r: Option<At<f64>>,
}

/// What must hold at the end.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table with contacts or region")]
pub(crate) struct GoalEntry {
    /// Pairs of interfaces that must touch.
    #[serde(default)]
    pub contacts: Vec<At<GoalContactEntry>>,
    /// Boxes of the world in which bodies must be.
    #[serde(default)]
    pub region: Vec<At<RegionEntry>>,
}

/// Two interfaces that must touch at the end.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(transparent)]
pub(crate) struct GoalContactEntry(#[schemars(length(min = 2, max = 2))] pub Vec<At<String>>);

/// An axis-parallel box of the world that the origin of a body must reach, and its orientation there; what is not given is
/// free.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "a table with body, x, y, z, yaw, tilt"
)]
pub(crate) struct RegionEntry {
    /// An object, a robot link, an interface of the robot or of an object, or "base".
    pub body: At<String>,
    /// Smallest and largest x [m]; inf is allowed.
    pub x: Option<At<[f64; 2]>>,
    /// Smallest and largest y [m].
    pub y: Option<At<[f64; 2]>>,
    /// Smallest and largest z [m].
    pub z: Option<At<[f64; 2]>>,
    /// Smallest and largest heading of the body's x axis about the world's z, from the world's x [rad].
    pub yaw: Option<At<[f64; 2]>>,
    /// Largest angle between the body's z axis and the world's [rad].
    pub tilt: Option<At<f64>>,
}

/// What is sought beside the goal.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table with kind, body, direction")]
pub(crate) struct ObjectiveEntry {
    /// "time" (least time and effort, the default with a goal), "base_height" (highest base at the end) or "reach" (a body as
    /// far as possible along a direction at the end).
    pub kind: At<ObjectiveKindEntry>,
    /// With "reach": an object, a robot link, an interface of the robot or of an object, or "base".
    pub body: Option<At<String>>,
    /// With "reach": direction in the world, of any length.
    pub direction: Option<At<[f64; 3]>>,
}

/// Kinds of objectives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ObjectiveKindEntry {
    /// Least time and effort.
    Time,
    /// Highest base at the end.
    BaseHeight,
    /// Farthest body along a direction at the end.
    Reach,
}

/// Options of the search for a contact sequence.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table of search options")]
pub(crate) struct SearchEntry {
    /// Largest number of phases; default: derived from the scene.
    pub max_phases: Option<At<usize>>,
    /// Largest number of actions of a manipulation skeleton; default: derived from the scene.
    pub max_skeleton: Option<At<usize>>,
    /// Most contact changes of feet and free hands in one action; default 1.
    pub max_changes: Option<At<usize>>,
    /// May free hands make supporting contacts; default false.
    pub support_hands: Option<bool>,
    /// May the robot be in the air, carried by nothing; default true.
    pub flights: Option<bool>,
    /// Intervals per phase during the search, before refinement; default 8.
    pub steps: Option<At<usize>>,
    /// Path of a PDDL domain (.pddl) whose actions move the objects, relative to the scene file; default: the built-in
    /// one (grasp, lift, place, release).
    pub domain: Option<At<String>>,
}

/// Options of the trajectory optimisation.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table of optimiser options")]
pub(crate) struct OptimiserEntry {
    /// Intervals per phase; default 16.
    pub steps: Option<At<usize>>,
    /// Shortest phase [s]; default 0.25.
    pub min_duration: Option<At<f64>>,
    /// Longest phase [s]; default 1.5.
    pub max_duration: Option<At<f64>>,
    /// Are the torque limits enforced; default true.
    pub torque_limits: Option<bool>,
    /// Iteration limit of one solve; default 200.
    pub max_iterations: Option<At<usize>>,
}
