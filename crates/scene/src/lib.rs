//! Scenes: the robot, movable objects, static bodies, interfaces, start and goal, read from one TOML file.
//!
//! All poses are given in the frame that the field's documentation names; SI units; z up.

mod types;

pub use types::*;
