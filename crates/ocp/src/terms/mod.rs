//! The terms of the problem, one equation per file.
//!
//! A [`PoseTerm`] is a set of rows of the relative pose X = b_from_a of two frames; a [`ForceTerm`] also depends on the
//! wrench of their contact. Derivatives are by body increments ξ of a (linear first) and by the wrench.

pub mod alignment;
pub mod approach;
pub mod bounds;
pub mod distance;
pub mod friction;
pub mod grasp;
pub mod half_space;
pub mod heading;
pub mod height;
pub mod inverse;
pub mod obstacle;
pub mod place;
pub mod point_friction;
pub mod pose_functions;
pub mod pressure;
pub mod region;
pub mod registry;
pub mod sigmoid;
pub mod slip_velocity;
pub mod support_pressure;
pub mod tilt;
pub mod tilt_limit;
pub mod torsion;

use distance::Nearest;
use nalgebra::{Matrix6, Vector6};
use spatial::Pose;

/// Rows of a relative pose.
pub trait PoseTerm: std::fmt::Debug + Send + Sync {
    /// Name for people and reports.
    fn name(&self) -> &'static str;
    /// Unit of the rows.
    fn unit(&self) -> &'static str;
    /// Lower and upper bound per row; equal for an equality.
    fn bounds(&self) -> Vec<(f64, f64)>;
    /// Row values.
    fn values(&self, b_from_a: &Pose, out: &mut [f64]);
    /// Row gradients by increments of a.
    fn gradients(&self, b_from_a: &Pose, out: &mut [Vector6<f64>]);
    /// Hessian of Σ weight · row by increments of a (exponential chart).
    fn hessian(&self, b_from_a: &Pose, weights: &[f64]) -> Matrix6<f64>;
    /// Gradients and Hessian at once, for terms that save work by it.
    fn derivatives(
        &self,
        b_from_a: &Pose,
        weights: &[f64],
        gradients: &mut [Vector6<f64>],
    ) -> Matrix6<f64> {
        self.gradients(b_from_a, gradients);
        self.hessian(b_from_a, weights)
    }
    /// Pairs of which [`PoseTerm::values_near`] may find every one near; none for most terms.
    fn n_pairs(&self) -> usize {
        0
    }
    /// Row values; what is found on the way is kept for [`PoseTerm::derivatives_near`] by terms that save work by it.
    fn values_near(&self, b_from_a: &Pose, out: &mut [f64], _nearest: &mut Nearest) {
        self.values(b_from_a, out);
    }
    /// Gradients and Hessian at the pose at which `nearest` was found last.
    fn derivatives_near(
        &self,
        b_from_a: &Pose,
        weights: &[f64],
        _nearest: &Nearest,
        gradients: &mut [Vector6<f64>],
    ) -> Matrix6<f64> {
        self.derivatives(b_from_a, weights, gradients)
    }
}

/// Second derivatives of a function of pose increments ξ and a wrench w.
#[derive(Debug, Clone, Copy)]
pub struct ForceHessian {
    /// By ξ and ξ.
    pub pose: Matrix6<f64>,
    /// By ξ (rows) and w (columns).
    pub mixed: Matrix6<f64>,
    /// By w and w.
    pub wrench: Matrix6<f64>,
}

impl ForceHessian {
    /// All zero.
    pub fn zero() -> Self {
        Self {
            pose: Matrix6::zeros(),
            mixed: Matrix6::zeros(),
            wrench: Matrix6::zeros(),
        }
    }
}

/// Rows of a contact's wrench: force and moment of b on a, in axes of a, about a's origin [N, N·m].
pub trait ForceTerm: std::fmt::Debug + Send + Sync {
    /// Name for people and reports.
    fn name(&self) -> &'static str;
    /// True if the rows depend on the relative pose too.
    fn uses_pose(&self) -> bool {
        false
    }
    /// Lower and upper bound per row.
    fn bounds(&self) -> Vec<(f64, f64)>;
    /// Row values.
    fn values(&self, b_from_a: &Pose, wrench: &Vector6<f64>, out: &mut [f64]);
    /// Row gradients by (ξ, w).
    fn gradients(
        &self,
        b_from_a: &Pose,
        wrench: &Vector6<f64>,
        out: &mut [(Vector6<f64>, Vector6<f64>)],
    );
    /// Hessian of Σ weight · row.
    fn hessian(&self, b_from_a: &Pose, wrench: &Vector6<f64>, weights: &[f64]) -> ForceHessian;
}
