//! The plan file, version 1: its types, reading, writing and validation.
//!
//! A plan is one self-contained JSON file; `docs/plan-format.md` is the contract and
//! `docs/plan.schema.json` the same as a JSON Schema, derived from the types of this crate.
//! SI units, right-handed frames, z up; every quaternion is `[qx, qy, qz, qw]`; arrays over time have
//! one row per node (states, `N + 1` rows) or per interval (accelerations, torques, wrenches, `N` rows).
//!
//! Keys that this version does not know are kept in `extra` and written back, so a writer may add its
//! own (`margins`, `summary`, `report`).

#![allow(
    rustdoc::broken_intra_doc_links,
    reason = "units stand in square brackets"
)]

mod error;
mod explanation;
mod file;
mod layout;
mod types;
mod validate;

pub use error::PlanError;
pub use explanation::{Explanation, FailedStage, Obstacle, Pull, Remedy};
pub use types::{
    Contact, ContactType, Costs, Dynamics, Extra, Geometry, GoalContact, GoalRegion, Integrator,
    Interface, InterfaceKind, Object, ObjectStates, Objective, Phase, Plan, Pose7, Robot, Row6,
    StaticBody, Status, TorqueSpeed,
};

/// The `format` string of the files that this crate reads and writes.
pub const FORMAT: &str = "locotamp.plan/1";

/// The JSON Schema of a plan file (draft 2020-12), derived from the types.
pub fn json_schema() -> serde_json::Value {
    schemars::schema_for!(Plan).to_value()
}
