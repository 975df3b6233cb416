//! Rotations: cross-product matrix, exponential and logarithm of SO(3).
//!
//! Frames: a rotation vector ω is a body increment, in the axes that it turns (both axes agree on it).

use nalgebra::{Matrix3, Vector3};

/// Below this squared angle the series replace quotients that tend to 0/0 (their first neglected term is then < 1e-17).
const SERIES_BELOW: f64 = 1e-4;

/// Matrix of the cross product: `skew(a) * b` = a × b.
#[inline]
#[rustfmt::skip]
pub fn skew(a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(
         0.0, -a.z,  a.y,
         a.z,  0.0, -a.x,
        -a.y,  a.x,  0.0,
    )
}

/// sin θ / θ and (1 − cos θ) / θ² as functions of u = θ²; regular at zero.
#[inline]
pub(crate) fn sin_cos_quotients(u: f64) -> (f64, f64) {
    if u < SERIES_BELOW {
        let a = 1.0 - u / 6.0 * (1.0 - u / 20.0 * (1.0 - u / 42.0));
        let b = 0.5 - u / 24.0 * (1.0 - u / 30.0 * (1.0 - u / 56.0));
        (a, b)
    } else {
        let theta = u.sqrt();
        let half_sine = (0.5 * theta).sin();
        (theta.sin() / theta, 2.0 * half_sine * half_sine / u)
    }
}

/// Rotation by the vector ω (axis times angle [rad]); regular everywhere.
///
/// R = I + (sin θ/θ) [ω]× + ((1 − cos θ)/θ²) [ω]×² (Rodrigues).
#[inline]
pub fn exp_so3(omega: &Vector3<f64>) -> Matrix3<f64> {
    let u = omega.norm_squared();
    let (a, b) = sin_cos_quotients(u);
    let w = skew(omega);
    // [ω]×² = ω ωᵀ − θ² I
    Matrix3::identity() * (1.0 - b * u) + w * a + omega * omega.transpose() * b
}

/// Rotation vector ω of a rotation matrix, |ω| ≤ π [rad].
///
/// Regular at the identity. At a half turn both signs are right; one of them is returned, and the result jumps there.
#[inline]
pub fn log_so3(rotation: &Matrix3<f64>) -> Vector3<f64> {
    let [x, y, z, w] = quaternion(rotation);
    let vector = Vector3::new(x, y, z);
    let u = vector.norm_squared();
    if u < SERIES_BELOW {
        // 2 asin(s)/s with s = sin(θ/2); w > 0 and near one here
        let quotient = 2.0
            * (1.0
                + u / 6.0
                    * (1.0 + u * 9.0 / 20.0 * (1.0 + u * 25.0 / 42.0 * (1.0 + u * 49.0 / 72.0))));
        return vector * quotient;
    }
    let s = u.sqrt();
    vector * (2.0 * s.atan2(w) / s)
}

/// Unit quaternion `[x, y, z, w]` of a rotation matrix, w ≥ 0; divides by its largest component, so regular everywhere.
#[inline]
pub(crate) fn quaternion(r: &Matrix3<f64>) -> [f64; 4] {
    let trace = r.trace();
    let largest = [r[(0, 0)], r[(1, 1)], r[(2, 2)], trace];
    let pick = (0..4).fold(
        3,
        |best, i| if largest[i] > largest[best] { i } else { best },
    );
    let mut quat = [0.0; 4];
    if pick == 3 {
        quat[3] = 1.0 + trace;
        for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            quat[i] = r[(k, j)] - r[(j, k)];
        }
    } else {
        let (i, j, k) = [(0, 1, 2), (1, 2, 0), (2, 0, 1)][pick];
        quat[i] = 1.0 + 2.0 * r[(i, i)] - trace;
        quat[j] = r[(j, i)] + r[(i, j)];
        quat[k] = r[(k, i)] + r[(i, k)];
        quat[3] = r[(k, j)] - r[(j, k)];
    }
    let norm = quat.iter().map(|x| x * x).sum::<f64>().sqrt();
    let scale = if quat[3] < 0.0 {
        -1.0 / norm
    } else {
        1.0 / norm
    };
    quat.map(|x| x * scale)
}

/// Rotation matrix of a unit quaternion `[x, y, z, w]`.
#[inline]
#[rustfmt::skip]
pub(crate) fn rotation_of(quat: [f64; 4]) -> Matrix3<f64> {
    let [x, y, z, w] = quat;
    Matrix3::new(
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z),       2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),       1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),       2.0 * (y * z + w * x),       1.0 - 2.0 * (x * x + y * y),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;
    use std::f64::consts::PI;

    fn random_axis(random: &mut Random) -> Vector3<f64> {
        let [x, y, z, _] = random.unit_quaternion();
        Vector3::new(x, y, z).normalize()
    }

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y() {
        let turned = exp_so3(&Vector3::new(0.0, 0.0, PI / 2.0)) * Vector3::x();
        assert!((turned - Vector3::y()).norm() < 1e-15);
    }

    #[test]
    fn log_undoes_exp_at_all_angles_below_a_half_turn() {
        let mut random = Random::new(1);
        for angle in [
            0.0,
            1e-12,
            1e-6,
            9e-3,
            0.011,
            0.019,
            0.021,
            0.5,
            1.0,
            2.0,
            3.0,
            PI - 1e-6,
            PI - 1e-12,
        ] {
            for _ in 0..20 {
                let omega = random_axis(&mut random) * angle;
                let again = log_so3(&exp_so3(&omega));
                assert!(
                    (again - omega).norm() < 2e-15 * (1.0 + angle),
                    "angle {angle}: {again} for {omega}"
                );
            }
        }
    }

    #[test]
    fn log_of_a_half_turn_is_one_of_its_two_vectors() {
        for axis in [
            Vector3::x(),
            Vector3::y(),
            Vector3::z(),
            Vector3::new(1.0, -2.0, 0.5).normalize(),
        ] {
            let half_turn = axis * axis.transpose() * 2.0 - Matrix3::identity();
            let omega = log_so3(&half_turn);
            assert!((omega.norm() - PI).abs() < 1e-14);
            assert!(omega.cross(&axis).norm() < 1e-14);
        }
    }

    #[test]
    fn series_and_closed_form_agree_where_they_meet() {
        let (below, above) = (
            sin_cos_quotients(SERIES_BELOW * (1.0 - 1e-12)),
            sin_cos_quotients(SERIES_BELOW),
        );
        assert!((below.0 - above.0).abs() < 1e-15 && (below.1 - above.1).abs() < 1e-15);
    }

    #[test]
    fn quaternion_and_matrix_undo_each_other() {
        let mut random = Random::new(2);
        for _ in 0..100 {
            let mut quat = random.unit_quaternion();
            if quat[3] < 0.0 {
                quat = quat.map(|x| -x);
            }
            let again = quaternion(&rotation_of(quat));
            assert!(quat.iter().zip(again).all(|(a, b)| (a - b).abs() < 1e-14));
        }
    }
}
