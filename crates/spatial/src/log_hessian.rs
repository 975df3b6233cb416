//! Second derivatives of the logarithm by increments on both sides.
//!
//! Along α(t) = tα, β(t) = tβ the curve ξ(t) = log(exp(−tα) exp(ξ) exp(tβ)) obeys ξ̇ = Jr⁻¹(ξ)β − Jl⁻¹(ξ)α at all t, so
//! its second derivative is D[Jr⁻¹](ξ)[ξ̇] β − D[Jl⁻¹](ξ)[ξ̇] α. The derivatives of the inverse Jacobians are taken of
//! their closed form (`se3.rs`), so the result is exact wherever the logarithm is smooth.

use crate::bernoulli::bernoulli;
use crate::se3::{angular, linear};
use crate::so3::skew;
use crate::{left_jacobian_inverse, right_jacobian_inverse};
use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3, Vector6};

/// A 12×12 matrix: increments of two poses, six each.
pub type Matrix12 = SMatrix<f64, 12, 12>;

/// Exact Hessian of wᵀ log(exp(−α) exp(ξ) exp(β)) at α = β = 0, ordered `[α; β]`, symmetric.
///
/// It is the Hessian of wᵀ(b ⊖ a) by body increments α of a and β of b, with ξ = b ⊖ a. Valid for angles below 2π, so
/// for every ξ that a logarithm returns; the logarithm itself jumps at half turns.
pub fn log_hessian(xi: &Vector6<f64>, w: &Vector6<f64>) -> Matrix12 {
    let by_beta = right_row_gradient(xi, w);
    // Jl⁻¹ = Jr⁻¹ − ad, so the rows differ by wᵀ ad(ξ), which is linear in ξ
    let by_alpha = by_beta - bracket_row_gradient(w);
    let (left, right) = (left_jacobian_inverse(xi), right_jacobian_inverse(xi));

    let (left_t, right_t) = (left.transpose(), right.transpose());
    let alpha_alpha = left_t * by_alpha;
    let beta_beta = right_t * by_beta;
    let alpha_beta = (left_t * by_beta + (right_t * by_alpha).transpose()) * -0.5;
    let mut hessian = Matrix12::zeros();
    hessian
        .fixed_view_mut::<6, 6>(0, 0)
        .copy_from(&((alpha_alpha + alpha_alpha.transpose()) * 0.5));
    hessian.fixed_view_mut::<6, 6>(0, 6).copy_from(&alpha_beta);
    hessian
        .fixed_view_mut::<6, 6>(6, 0)
        .copy_from(&alpha_beta.transpose());
    hessian
        .fixed_view_mut::<6, 6>(6, 6)
        .copy_from(&((beta_beta + beta_beta.transpose()) * 0.5));
    hessian
}

/// ∂(wᵀ Jr⁻¹(ξ))_j / ∂ξ_i at (i, j).
///
/// With W = [ω]×, V = [v]×, s = ω·v and w = (f, n): the row is (fᵀA, fᵀB + nᵀA), A = I + ½W + dW²,
/// B = ½V + d(WV + VW) + d′sW². As row vectors: fᵀW = f × ω, and so on.
fn right_row_gradient(xi: &Vector6<f64>, w: &Vector6<f64>) -> Matrix6<f64> {
    let (v, omega) = (linear(xi), angular(xi));
    let (f, n) = (linear(w), angular(w));
    let (d, d1, d2) = bernoulli(omega.norm_squared());
    let s = omega.dot(&v);
    // fᵀW² = (f × ω) × ω and its gradient by ω
    let square = |row: &Vector3<f64>| row.cross(&omega).cross(&omega);
    let square_gradient = |row: &Vector3<f64>| double_cross_gradient(row, &omega);

    // by ω of fᵀA; equally by v of fᵀB
    let of_a = |row: &Vector3<f64>| {
        bracket_gradient(row) * 0.5
            + square_gradient(row) * d
            + omega * (square(row) * d1).transpose()
    };
    // by ω of fᵀB
    let mixed_gradient = double_cross_gradient(&f, &v);
    let mixed = f.cross(&omega).cross(&v) + f.cross(&v).cross(&omega);
    let of_b = mixed_gradient * d
        + omega * (mixed * d1).transpose()
        + (v * d1 + omega * (d2 * s)) * square(&f).transpose()
        + square_gradient(&f) * (d1 * s);

    let upper = of_a(&f);
    let mut gradient = Matrix6::zeros();
    gradient.fixed_view_mut::<3, 3>(0, 3).copy_from(&upper);
    gradient.fixed_view_mut::<3, 3>(3, 0).copy_from(&upper);
    gradient
        .fixed_view_mut::<3, 3>(3, 3)
        .copy_from(&(of_b + of_a(&n)));
    gradient
}

/// ∂(wᵀ ad(ξ))_j / ∂ξ_i at (i, j): wᵀad(ξ) = (f × ω, f × v + n × ω).
fn bracket_row_gradient(w: &Vector6<f64>) -> Matrix6<f64> {
    let (f, n) = (bracket_gradient(&linear(w)), bracket_gradient(&angular(w)));
    let mut gradient = Matrix6::zeros();
    gradient.fixed_view_mut::<3, 3>(0, 3).copy_from(&f);
    gradient.fixed_view_mut::<3, 3>(3, 0).copy_from(&f);
    gradient.fixed_view_mut::<3, 3>(3, 3).copy_from(&n);
    gradient
}

/// ∂(f × x)_j / ∂x_i at (i, j).
fn bracket_gradient(f: &Vector3<f64>) -> Matrix3<f64> {
    skew(f).transpose()
}

/// ∂((f × x) × x)_j / ∂x_i at (i, j): (f × x) × x = x (f·x) − f (x·x).
fn double_cross_gradient(f: &Vector3<f64>, x: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * f.dot(x) + f * x.transpose() - x * f.transpose() * 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Pose, Random};
    use derivcheck::{assert_gradient, assert_hessian_of_value};

    fn case(seed: u64, angle: f64) -> (Vector6<f64>, Vector6<f64>) {
        let mut random = Random::new(seed);
        let mut xi = Vector6::from_fn(|_, _| random.uniform(-1.0, 1.0));
        let scale = angle / angular(&xi).norm();
        xi.fixed_rows_mut::<3>(3).scale_mut(scale);
        (xi, Vector6::from_fn(|_, _| random.uniform(-1.0, 1.0)))
    }

    fn log_between(x: &[f64], xi: &Vector6<f64>) -> Vector6<f64> {
        let alpha = Vector6::from_column_slice(&x[..6]);
        let beta = Vector6::from_column_slice(&x[6..]);
        (Pose::exp(&-alpha) * Pose::exp(xi) * Pose::exp(&beta)).log()
    }

    #[test]
    fn hessian_matches_finite_differences_at_all_angles() {
        for (seed, angle) in [
            (1, 0.0),
            (2, 1e-4),
            (3, 0.1),
            (4, 0.5),
            (5, 1.2),
            (6, 1.3),
            (7, 2.5),
            (8, 3.0),
        ] {
            let (xi, w) = case(seed, angle);
            // second differences of the value, free of the Jacobians of `se3.rs`
            let value = |x: &[f64]| w.dot(&log_between(x, &xi));
            assert_hessian_of_value(value, &[0.0; 12], log_hessian(&xi, &w).as_slice(), 1e-8);
        }
    }

    #[test]
    fn first_derivatives_are_the_inverse_jacobians() {
        let (xi, w) = case(11, 1.0);
        let mut gradient = [0.0; 12];
        gradient[..6].copy_from_slice((-left_jacobian_inverse(&xi).transpose() * w).as_slice());
        gradient[6..].copy_from_slice((right_jacobian_inverse(&xi).transpose() * w).as_slice());
        assert_gradient(|x| w.dot(&log_between(x, &xi)), &[0.0; 12], &gradient, 1e-9);
    }

    #[test]
    fn moving_both_poses_together_by_a_common_left_factor_changes_nothing() {
        // b ⊖ a is invariant when β = Ad(exp(−ξ)) α to first order; checked on the first-order kernel of the Hessian's
        // quadratic form: curves α = t a, β = t Ad(exp −ξ) a keep ξ exactly.
        let (xi, w) = case(12, 0.8);
        let a = Vector6::new(0.1, -0.2, 0.3, 0.5, 0.4, -0.6);
        let b = Pose::exp(&-xi).adjoint() * a;
        let mut direction = SMatrix::<f64, 12, 1>::zeros();
        direction.fixed_rows_mut::<6>(0).copy_from(&a);
        direction.fixed_rows_mut::<6>(6).copy_from(&b);
        let curvature = (direction.transpose() * log_hessian(&xi, &w) * direction)[0];
        assert!(curvature.abs() < 1e-13, "{curvature}");
    }
}
