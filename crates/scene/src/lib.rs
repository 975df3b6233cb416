//! Scenes: the robot, movable objects, static bodies, interfaces, start and goal, read from one TOML file.
//! Contact sequences for a scene come from files of their own ([`SequenceFile`]).
//!
//! All poses are given in the frame that the field's documentation names; SI units; z up. The file format is described in
//! `docs/scene-format.md` and, derived from the types of this crate, in `docs/scene.schema.json`. Faults are reported with
//! the place in the file ([`SceneError`]).

mod bare_robot;
mod bodies;
mod builtin;
mod doubts;
mod draft;
mod error;
mod file;
mod fit;
mod for_readers;
mod goal;
mod interfaces;
mod load;
mod locked_joints;
mod mesh_path;
mod mesh_shapes;
mod nearest;
mod notes;
mod options;
mod overlap;
mod pace;
mod parse;
mod patch_notes;
mod perturb;
mod place;
mod robot;
mod rules;
mod sequence;
mod sequence_file;
mod shapes;
mod source;
mod split;
mod start;
mod tiny_masses;
mod torque_speed;
mod touch;
mod types;
mod urdf_text;
mod values;

pub use bare_robot::BareRobot;
pub use error::{Fault, SceneError};
pub use perturb::Perturbation;
pub use sequence::{Expectation, Sequence, SequenceFile, SequenceGoal, SequencePhase};
pub use source::Place;
pub use types::*;

/// The JSON Schema of a scene file (draft 2020-12), derived from the types.
pub fn json_schema() -> serde_json::Value {
    schemars::schema_for!(file::SceneFile).to_value()
}

/// The JSON Schema of a sequence file (draft 2020-12), derived from the types.
pub fn sequence_json_schema() -> serde_json::Value {
    schemars::schema_for!(sequence_file::SequenceEntry).to_value()
}
