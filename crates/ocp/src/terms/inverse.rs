//! Rows of a term with the frames the other way round: of X⁻¹ = a_from_b in place of X = b_from_a.
//!
//! By an increment ξ of a, X⁻¹ becomes X⁻¹ exp(−Ad_X ξ): gradients are −Ad_Xᵀ g, Hessians Ad_Xᵀ H Ad_X.

use super::PoseTerm;
use super::distance::Nearest;
use nalgebra::{Matrix6, Vector6};
use spatial::Pose;

/// The term whose frame a is b here.
#[derive(Debug)]
pub struct Inverse<T>(pub T);

/// Turns gradients and a Hessian by increments of b into those of a.
fn turn(x: &Pose, gradients: &mut [Vector6<f64>], hessian: &Matrix6<f64>) -> Matrix6<f64> {
    let adjoint = x.adjoint();
    for gradient in gradients {
        *gradient = -adjoint.tr_mul(gradient);
    }
    adjoint.tr_mul(hessian) * adjoint
}

impl<T: PoseTerm> PoseTerm for Inverse<T> {
    fn name(&self) -> &'static str {
        self.0.name()
    }
    fn unit(&self) -> &'static str {
        self.0.unit()
    }
    fn bounds(&self) -> Vec<(f64, f64)> {
        self.0.bounds()
    }
    fn values(&self, b_from_a: &Pose, out: &mut [f64]) {
        self.0.values(&b_from_a.inverse(), out);
    }
    fn gradients(&self, b_from_a: &Pose, out: &mut [Vector6<f64>]) {
        self.0.gradients(&b_from_a.inverse(), out);
        turn(b_from_a, out, &Matrix6::zeros());
    }
    fn hessian(&self, b_from_a: &Pose, weights: &[f64]) -> Matrix6<f64> {
        let hessian = self.0.hessian(&b_from_a.inverse(), weights);
        turn(b_from_a, &mut [], &hessian)
    }
    fn derivatives(
        &self,
        b_from_a: &Pose,
        weights: &[f64],
        gradients: &mut [Vector6<f64>],
    ) -> Matrix6<f64> {
        let hessian = self.0.derivatives(&b_from_a.inverse(), weights, gradients);
        turn(b_from_a, gradients, &hessian)
    }
    fn n_pairs(&self) -> usize {
        self.0.n_pairs()
    }
    fn values_near(&self, b_from_a: &Pose, out: &mut [f64], nearest: &mut Nearest) {
        self.0.values_near(&b_from_a.inverse(), out, nearest);
    }
    fn derivatives_near(
        &self,
        b_from_a: &Pose,
        weights: &[f64],
        nearest: &Nearest,
        gradients: &mut [Vector6<f64>],
    ) -> Matrix6<f64> {
        let x = b_from_a.inverse();
        let hessian = self.0.derivatives_near(&x, weights, nearest, gradients);
        turn(b_from_a, gradients, &hessian)
    }
}
