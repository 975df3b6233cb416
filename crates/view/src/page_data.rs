//! What the page gets: the plan with everything that the browser should not have to compute, rounded to what can be seen.
//!
//! The names are those of `viewer/src/data.ts`.

use crate::compact::Table;
use serde::Serialize;

/// One plan.
#[derive(Debug, Serialize)]
pub(crate) struct PlanData {
    /// How the reader calls it: a tab's title.
    pub name: String,
    pub task: String,
    pub feasible: bool,
    pub generator: String,
    pub objective: Option<(String, f64)>,
    pub cost: Option<f64>,
    pub costs: Option<CostsData>,
    pub integrator: &'static str,
    /// Azimuth and elevation from which to look [rad].
    pub view: [f64; 2],
    pub robot: RobotData,
    pub objects: Vec<ObjectData>,
    pub environment: Vec<StaticData>,
    pub interfaces: Vec<InterfaceData>,
    /// Pairs of interfaces.
    pub goal: Vec<[usize; 2]>,
    pub goal_regions: Vec<RegionData>,
    pub phases: Vec<PhaseData>,
    /// Seconds, per node.
    pub time: Table,
    /// Base pose and joints in the order of `robot.joints`, per node.
    pub q: Table,
    /// Joint rates, per node.
    pub rates: Table,
    /// Joint torques, per interval.
    pub tau: Table,
    /// Joint torques over what the joint can give, per interval.
    pub torque_share: Table,
    /// Centre of mass of the robot, per node.
    pub com: Table,
    pub check: CheckData,
    /// The plan's own account of its quality, and why it is infeasible.
    pub quality: Option<serde_json::Value>,
    pub explanation: Option<String>,
}

/// The cost by term.
#[derive(Debug, Serialize)]
pub(crate) struct CostsData {
    /// Names of the terms with their sums.
    pub terms: Vec<(String, f64)>,
    /// What each term costs per second, per interval; a column per term.
    pub rates: Table,
    /// What counts once, at the end.
    pub end: Vec<(String, f64)>,
}

#[derive(Debug, Serialize)]
pub(crate) struct RobotData {
    pub name: String,
    /// Kilograms.
    pub mass: f64,
    /// Moving joints, parents first.
    pub tree: Vec<JointData>,
    pub shapes: Vec<ShapeData>,
    /// The joints of `q`, `rates` and `tau`.
    pub joints: Vec<AxisData>,
    pub notes: Vec<String>,
}

#[derive(Debug, Serialize)]
pub(crate) struct JointData {
    pub parent: Option<usize>,
    /// Pose at zero in the frame of the parent.
    pub pose: [f64; 7],
    pub kind: &'static str,
    pub axis: [f64; 3],
    /// Its column in `q`.
    pub q: Option<usize>,
}

/// A joint as charts know it: name and limits.
#[derive(Debug, Serialize)]
pub(crate) struct AxisData {
    pub name: String,
    /// Largest torque.
    pub torque: Option<f64>,
    /// Whether the plan enforces it.
    pub enforced: bool,
    pub speed: Option<f64>,
    pub lower: Option<f64>,
    pub upper: Option<f64>,
}

#[derive(Debug, Serialize)]
pub(crate) struct ShapeData {
    /// Joint of the tree that carries it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint: Option<usize>,
    pub pose: [f64; 7],
    #[serde(flatten)]
    pub form: FormData,
    /// −1 for the axes along which a mesh is mirrored.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mirror: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<String>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum FormData {
    /// Half sizes.
    Box([f64; 3]),
    /// Radius.
    Sphere(f64),
    /// Radius and half length.
    Cylinder([f64; 2]),
    /// Radius and half length without the caps.
    Capsule([f64; 2]),
    /// A half-space below z = 0.
    Plane(bool),
    /// Index into the page's meshes.
    Mesh(usize),
}

#[derive(Debug, Serialize)]
pub(crate) struct ObjectData {
    pub name: String,
    pub mass: f64,
    pub shapes: Vec<ShapeData>,
    /// Pose per node.
    pub pose: Table,
}

#[derive(Debug, Serialize)]
pub(crate) struct StaticData {
    pub name: String,
    pub shapes: Vec<ShapeData>,
}

#[derive(Debug, Serialize)]
pub(crate) struct InterfaceData {
    pub name: String,
    pub body: String,
    /// `joint`, `object` or `static`.
    pub on: &'static str,
    /// Index of that; `None`: a link that is fixed to the world.
    pub index: Option<usize>,
    /// Pose in the frame of that.
    pub pose: [f64; 7],
    pub point: bool,
    pub half_size: Option<[Option<f64>; 2]>,
}

#[derive(Debug, Serialize)]
pub(crate) struct RegionData {
    pub body: String,
    pub lower: [Option<f64>; 3],
    pub upper: [Option<f64>; 3],
}

#[derive(Debug, Serialize)]
pub(crate) struct PhaseData {
    pub duration: f64,
    pub steps: usize,
    pub action: String,
    pub contacts: Vec<ContactData>,
}

#[derive(Debug, Serialize)]
pub(crate) struct ContactData {
    pub a: usize,
    pub b: usize,
    pub kind: &'static str,
    pub mu: f64,
    pub mu_r: f64,
    /// Per interval: force and moment on `a`, world axes, about the origin of `a`.
    pub wrench: Table,
    /// Per interval: normal force [kN], share of friction used, centre of pressure on `a` [m].
    pub load: Table,
}

#[derive(Debug, Serialize)]
pub(crate) struct CheckData {
    pub ok: bool,
    pub rows: Vec<RowData>,
    pub margins: Vec<MarginData>,
}

/// One category of the checker.
#[derive(Debug, Serialize)]
pub(crate) struct RowData {
    pub category: &'static str,
    pub what: &'static str,
    pub unit: &'static str,
    pub value: Option<f64>,
    pub tolerance: f64,
    pub status: String,
    pub place: String,
    pub node: Option<usize>,
    /// Residual over tolerance, in thousandths, per node; kept where it ever reaches a hundredth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub over_time: Option<Table>,
}

#[derive(Debug, Serialize)]
pub(crate) struct MarginData {
    pub limit: &'static str,
    pub largest: f64,
    pub what: String,
    pub node: Option<usize>,
}
