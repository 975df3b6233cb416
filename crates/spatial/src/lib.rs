//! Poses, twists, wrenches and inertias; exponential and logarithm of SE(3) with their derivatives.
//!
//! Conventions: SI units, radians, linear part before angular part, tangents are body increments
//! (`pose.plus(xi)` is pose ⊕ ξ = pose · exp ξ), quaternions are `[x, y, z, w]`, poses are named `<to>_from_<of>`.
//! Source of the formulas: Murray, Li, Sastry, *A Mathematical Introduction to Robotic Manipulation*, ch. 2, and
//! Featherstone, *Rigid Body Dynamics Algorithms*, ch. 2 (with linear and angular parts exchanged).

mod bernoulli;
mod inertia;
mod log_hessian;
mod pose;
mod random;
mod se3;
mod so3;
mod twist;
mod wrench;

pub use inertia::Inertia;
pub use log_hessian::{Matrix12, log_hessian};
pub use pose::Pose;
pub use random::Random;
pub use se3::{ad, left_jacobian, left_jacobian_inverse, right_jacobian, right_jacobian_inverse};
pub use so3::{exp_so3, log_so3, skew};
pub use twist::Twist;
pub use wrench::Wrench;
