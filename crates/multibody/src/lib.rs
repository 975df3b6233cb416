//! Rigid-body trees: models from URDF, kinematics, dynamics and their exact first and second derivatives.
//!
//! A robot is a [`Model`] (constants); [`Kinematics`] holds the poses and joint axes of one configuration, evaluated once
//! and passed to every algorithm. Each algorithm is a reusable workspace that allocates only when it is created.
//!
//! Legend: q configuration (base position, base quaternion x y z w, joints), v its velocity (base twist in the base frame,
//! joint rates), a = v̇, τ generalised forces, n_v = `nv`. Tangents are body increments, so ∂/∂q has n_v columns.

mod configuration;
mod error;
mod kinematics;
mod model;
mod random_tree;
mod urdf;
mod urdf_tree;

pub use error::ModelError;
pub use kinematics::Kinematics;
pub use model::{Frame, Joint, JointKind, Model, PlacedShape, Root, Shape};
