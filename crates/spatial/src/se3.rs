//! The Lie algebra of SE(3): bracket, and the Jacobians of the exponential map.
//!
//! Frames: ξ = [linear; angular] is a body increment. Definitions: exp(ξ + δ) ≈ exp(ξ) exp(Jr(ξ) δ) and
//! exp(ξ + δ) ≈ exp(Jl(ξ) δ) exp(ξ); Jl(ξ) = Jr(−ξ).
//! All of them are series in ad(ξ) = [W V; 0 W] with W = [ω]×, V = [v]×: block upper triangular, with the SO(3) series
//! on the diagonal and above it the derivative of that series at ω in the direction v.

use crate::bernoulli::bernoulli;
use crate::so3::{sin_cos_quotients, skew};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// Below this squared angle series replace quotients that tend to 0/0.
const SERIES_BELOW: f64 = 0.25;

#[inline]
pub(crate) fn linear(xi: &Vector6<f64>) -> Vector3<f64> {
    Vector3::new(xi[0], xi[1], xi[2])
}

#[inline]
pub(crate) fn angular(xi: &Vector6<f64>) -> Vector3<f64> {
    Vector3::new(xi[3], xi[4], xi[5])
}

/// [A B; 0 A]
#[inline]
pub(crate) fn block_triangular(diagonal: &Matrix3<f64>, corner: &Matrix3<f64>) -> Matrix6<f64> {
    let mut matrix = Matrix6::zeros();
    matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(diagonal);
    matrix.fixed_view_mut::<3, 3>(0, 3).copy_from(corner);
    matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(diagonal);
    matrix
}

/// Matrix of the Lie bracket of twists: `ad(x) * y` = [x, y], 6×6, linear before angular.
///
/// It is the rate of a twist y that is carried along by the motion x.
#[inline]
pub fn ad(x: &Vector6<f64>) -> Matrix6<f64> {
    block_triangular(&skew(&angular(x)), &skew(&linear(x)))
}

/// (θ − sin θ)/θ³ and the θ-derivatives divided by θ of (1 − cos θ)/θ² and of itself; functions of u = θ².
fn higher_quotients(u: f64) -> (f64, f64, f64) {
    if u < SERIES_BELOW {
        // Σ (−u)^k / (2k+3)!, and 2 d/du of Σ (−u)^k / (2k+2)! and of itself
        let (mut c, mut b1, mut c1) = (0.0, 0.0, 0.0);
        let (mut power, mut factorial) = (1.0, 6.0);
        for k in 0..9 {
            let n = f64::from(2 * k + 3); // `factorial` is n!
            c += power / factorial;
            let slope = -2.0 * f64::from(k + 1) * power;
            b1 += slope / (factorial * (n + 1.0));
            c1 += slope / (factorial * (n + 1.0) * (n + 2.0));
            power *= -u;
            factorial *= (n + 1.0) * (n + 2.0);
        }
        return (c, b1, c1);
    }
    let (a, b) = sin_cos_quotients(u);
    let c = (1.0 - a) / u;
    (c, (a - 2.0 * b) / u, (b - 3.0 * c) / u)
}

/// Left Jacobian Jl(ξ) of exp, 6×6; regular everywhere.
pub fn left_jacobian(xi: &Vector6<f64>) -> Matrix6<f64> {
    let (linear, angular) = (linear(xi), angular(xi));
    let u = angular.norm_squared();
    let (_, b) = sin_cos_quotients(u);
    let (c, b1, c1) = higher_quotients(u);
    let (w, v) = (skew(&angular), skew(&linear));
    let (ww, wv) = (w * w, angular.dot(&linear));
    let diagonal = Matrix3::identity() + w * b + ww * c;
    let corner = v * b + w * (b1 * wv) + (w * v + v * w) * c + ww * (c1 * wv);
    block_triangular(&diagonal, &corner)
}

/// Right Jacobian Jr(ξ) of exp, 6×6; regular everywhere.
pub fn right_jacobian(xi: &Vector6<f64>) -> Matrix6<f64> {
    left_jacobian(&-xi)
}

/// Inverse of the right Jacobian, 6×6: log(exp(ξ) exp(δ)) ≈ ξ + Jr⁻¹(ξ) δ. Its pole is at 2π, beyond every logarithm.
#[inline]
pub fn right_jacobian_inverse(xi: &Vector6<f64>) -> Matrix6<f64> {
    jacobian_inverse(xi, 0.5)
}

/// Inverse of the left Jacobian, 6×6: log(exp(δ) exp(ξ)) ≈ ξ + Jl⁻¹(ξ) δ. Its pole is at 2π, beyond every logarithm.
#[inline]
pub fn left_jacobian_inverse(xi: &Vector6<f64>) -> Matrix6<f64> {
    jacobian_inverse(xi, -0.5)
}

/// I + `half` ad + d ad² with its dual part, see the head of the file.
#[inline]
fn jacobian_inverse(xi: &Vector6<f64>, half: f64) -> Matrix6<f64> {
    let (linear, angular) = (linear(xi), angular(xi));
    let (d, d1, _) = bernoulli(angular.norm_squared());
    let (w, v) = (skew(&angular), skew(&linear));
    let (ww, wv) = (w * w, angular.dot(&linear));
    let diagonal = Matrix3::identity() + w * half + ww * d;
    let corner = v * half + (w * v + v * w) * d + ww * (d1 * wv);
    block_triangular(&diagonal, &corner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Pose, Random};
    use derivcheck::assert_jacobian;

    fn random_tangent(seed: u64, angle: f64) -> Vector6<f64> {
        let mut random = Random::new(seed);
        let mut xi = Vector6::from_fn(|_, _| random.uniform(-1.0, 1.0));
        let scale = angle / angular(&xi).norm();
        xi.fixed_rows_mut::<3>(3).scale_mut(scale);
        xi
    }

    #[test]
    fn bracket_obeys_jacobi_and_antisymmetry() {
        let [x, y, z] = [1, 2, 3].map(|seed| random_tangent(seed, 1.0));
        assert!((ad(&x) * y + ad(&y) * x).norm() < 1e-15);
        let cyclic = ad(&x) * (ad(&y) * z) + ad(&y) * (ad(&z) * x) + ad(&z) * (ad(&x) * y);
        assert!(cyclic.norm() < 1e-14);
    }

    #[test]
    fn jacobians_of_exp_match_finite_differences() {
        for (seed, angle) in [
            (1, 0.0),
            (2, 1e-5),
            (3, 0.3),
            (4, 0.499),
            (5, 0.6),
            (6, 2.0),
            (7, 3.1),
        ] {
            let xi = random_tangent(seed, angle);
            let increment = |x: &[f64]| Pose::exp(&Vector6::from_column_slice(x));
            let by_body = |x: &[f64]| increment(x).minus(&Pose::exp(&xi)).as_slice().to_vec();
            let by_world = |x: &[f64]| {
                (increment(x) * Pose::exp(&xi).inverse())
                    .log()
                    .as_slice()
                    .to_vec()
            };
            assert_jacobian(by_body, xi.as_slice(), right_jacobian(&xi).as_slice(), 1e-9);
            assert_jacobian(by_world, xi.as_slice(), left_jacobian(&xi).as_slice(), 1e-9);
        }
    }

    #[test]
    fn inverse_jacobians_are_inverse() {
        for (seed, angle) in [
            (1, 0.0),
            (2, 1e-5),
            (3, 0.4),
            (4, 0.6),
            (5, 1.2),
            (6, 1.3),
            (7, 3.1),
            (8, 5.0),
        ] {
            let xi = random_tangent(seed, angle);
            let right = right_jacobian_inverse(&xi) * right_jacobian(&xi);
            let left = left_jacobian_inverse(&xi) * left_jacobian(&xi);
            assert!(
                (right - Matrix6::identity()).norm() < 1e-12,
                "angle {angle}"
            );
            assert!((left - Matrix6::identity()).norm() < 1e-12, "angle {angle}");
        }
    }

    #[test]
    fn left_and_right_inverse_differ_by_the_bracket() {
        let xi = random_tangent(9, 1.5);
        let difference = right_jacobian_inverse(&xi) - left_jacobian_inverse(&xi) - ad(&xi);
        assert!(difference.norm() < 1e-14);
    }
}
