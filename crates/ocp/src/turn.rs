//! Turns between directions.

use nalgebra::{Matrix3, Unit, UnitQuaternion, Vector3};
use std::f64::consts::PI;

/// The least turn of one direction onto another; where they are opposite, half a turn about some axis across.
pub(crate) fn turn_onto(from: &Vector3<f64>, to: &Vector3<f64>) -> Matrix3<f64> {
    let turn = UnitQuaternion::rotation_between(from, to).unwrap_or_else(|| {
        let across = from.cross(&Vector3::ith(from.iamin(), 1.0));
        UnitQuaternion::from_axis_angle(&Unit::new_normalize(across), PI)
    });
    *turn.to_rotation_matrix().matrix()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_direction_is_turned_onto_any_other_and_its_opposite() {
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let skew = Vector3::new(0.6, 0.0, -0.8);
        for from in [x, y, z, skew] {
            for to in [x, -x, y, -y, z, -z, skew, -skew] {
                let turn = turn_onto(&from, &to);
                assert!((turn * from - to).norm() < 1e-12, "{from} {to}");
                assert!((turn.determinant() - 1.0).abs() < 1e-12);
            }
        }
    }
}
