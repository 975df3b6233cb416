//! Roll, pitch and yaw, as URDFs have them: turns about the fixed x, y and z axes, in this order.
//!
//! Source: the URDF specification (wiki.ros.org/urdf/XML/joint), R = Rz(yaw) Ry(pitch) Rx(roll).

use nalgebra::{Matrix3, Vector3};

/// Below this cosine of the pitch, roll and yaw are one turn, and yaw is taken as 0.
const UPRIGHT: f64 = 1e-7;

/// The rotation of roll, pitch and yaw [rad].
#[rustfmt::skip]
pub fn rotation_from_rpy(rpy: &Vector3<f64>) -> Matrix3<f64> {
    let (sr, cr) = rpy.x.sin_cos();
    let (sp, cp) = rpy.y.sin_cos();
    let (sy, cy) = rpy.z.sin_cos();
    Matrix3::new(
        cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,
        sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,
        -sp,     cp * sr,                cp * cr,
    )
}

/// Roll, pitch and yaw [rad] of a rotation; pitch within ±π/2, and yaw 0 where pitch is at either end.
pub fn rpy_from_rotation(rotation: &Matrix3<f64>) -> Vector3<f64> {
    let r = |i: usize, j: usize| rotation[(i, j)];
    let cos_pitch = r(0, 0).hypot(r(1, 0));
    let pitch = (-r(2, 0)).atan2(cos_pitch);
    if cos_pitch < UPRIGHT {
        return Vector3::new((-r(1, 2)).atan2(r(1, 1)), pitch, 0.0);
    }
    let (roll, yaw) = (r(2, 1).atan2(r(2, 2)), r(1, 0).atan2(r(0, 0)));
    Vector3::new(roll, pitch, yaw)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn roll_pitch_yaw_turn_about_fixed_axes_in_this_order() {
        let turned = rotation_from_rpy(&Vector3::new(FRAC_PI_2, 0.0, FRAC_PI_2)) * Vector3::y();
        // roll takes y to z, yaw leaves z
        assert!((turned - Vector3::z()).norm() < 1e-15);
        let pitched = rotation_from_rpy(&Vector3::new(0.0, FRAC_PI_2, 0.0)) * Vector3::x();
        assert!((pitched + Vector3::z()).norm() < 1e-15);
    }

    #[test]
    fn angles_of_a_rotation_give_it_back_upright_too() {
        for pitch in [-FRAC_PI_2, -1.0, 0.0, FRAC_PI_2 - 1e-6, FRAC_PI_2] {
            for (roll, yaw) in [(0.0, 0.0), (0.4, -2.0), (3.0, 1.5), (-2.5, 3.1)] {
                let rotation = rotation_from_rpy(&Vector3::new(roll, pitch, yaw));
                let back = rotation_from_rpy(&rpy_from_rotation(&rotation));
                assert!((back - rotation).amax() < 1e-9, "{roll} {pitch} {yaw}");
            }
        }
    }
}
