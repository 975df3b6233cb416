//! Rigid-body trees: models from URDF, kinematics, dynamics and their exact first and second derivatives.
//!
//! A robot is a [`Model`] (constants); [`Kinematics`] holds the poses and joint axes of one configuration, evaluated once
//! and passed to every algorithm. Each algorithm is a reusable workspace that allocates only when it is created.
//!
//! Legend: q configuration (base position, base quaternion x y z w, joints), v its velocity (base twist in the base frame,
//! joint rates), a = v̇, τ generalised forces, n_v = `nv`. Tangents are body increments, so ∂/∂q has n_v columns.

mod center_of_mass;
mod centroidal;
mod centroidal_derivatives;
mod configuration;
mod crba;
mod error;
mod joint_order;
mod kinematics;
mod model;
mod path;
mod random_tree;
mod rnea;
mod rnea_derivatives;
mod rnea_hessian;
mod rpy;
#[cfg(test)]
mod samples;
mod subtree;
mod symmetric3;
mod urdf;
mod urdf_tree;
mod world_inertia;

pub use center_of_mass::{CenterOfMass, WeightedPoint};
pub use centroidal::Centroidal;
pub use centroidal_derivatives::CentroidalDerivatives;
pub use crba::Crba;
pub use error::ModelError;
pub use joint_order::JointOrder;
pub use kinematics::Kinematics;
pub use model::{Frame, Joint, JointKind, Model, PlacedShape, Root, Shape, TorqueSpeed};
pub use rnea::Rnea;
pub use rnea_derivatives::RneaDerivatives;
pub use rnea_hessian::RneaHessian;
pub use rpy::{rotation_from_rpy, rpy_from_rotation};
