//! The face of a body in a direction: its points near the plane that touches it from there.

use nalgebra::{Matrix3, Vector2, Vector3};
use std::f64::consts::TAU;

/// Points on a circle that stands for the cap of something round.
const CIRCLE: usize = 16;

/// How far points with something round about them reach along a direction [m]; −∞ without any.
pub(crate) fn reach(tips: &[(Vector3<f64>, f64)], normal: &Vector3<f64>) -> f64 {
    let along = tips.iter().map(|(p, radius)| p.dot(normal) + radius);
    along.fold(f64::NEG_INFINITY, f64::max)
}

/// The points within `depth` [m] of the plane that touches all from the side of the unit vector `normal`; of what is round the edge of the
/// cap that is.
pub(crate) fn near_face(
    tips: &[(Vector3<f64>, f64)],
    normal: &Vector3<f64>,
    depth: f64,
) -> Vec<Vector3<f64>> {
    let most = reach(tips, normal);
    let across = axes_of(normal, &any_across(normal));
    let mut face = Vec::new();
    for (p, radius) in tips {
        let below = most - p.dot(normal) - radius;
        if below > depth {
            continue;
        }
        if *radius == 0.0 {
            face.push(*p);
            continue;
        }
        let cap = (depth - below).min(*radius);
        let edge = (cap * (2.0 * radius - cap)).max(0.0).sqrt();
        for i in 0..CIRCLE {
            let (sin, cos) = (TAU * i as f64 / CIRCLE as f64).sin_cos();
            let around = across.column(0) * cos + across.column(1) * sin;
            face.push(p + normal * (radius - cap) + around * edge);
        }
    }
    face
}

/// Axes of a patch as columns: z along a unit normal, x along `ahead` as far as it is across the normal.
pub(crate) fn axes_of(normal: &Vector3<f64>, ahead: &Vector3<f64>) -> Matrix3<f64> {
    let across = ahead - normal * normal.dot(ahead);
    let x = across
        .try_normalize(1e-9)
        .unwrap_or_else(|| any_across(normal));
    Matrix3::from_columns(&[x, normal.cross(&x), *normal])
}

/// Points as a patch sees them from its own axes: x and y.
pub(crate) fn in_plane(points: &[Vector3<f64>], axes: &Matrix3<f64>) -> Vec<Vector2<f64>> {
    points.iter().map(|p| axes.tr_mul(p).xy()).collect()
}

fn any_across(normal: &Vector3<f64>) -> Vector3<f64> {
    let least = Vector3::ith(normal.iamin(), 1.0);
    (least - normal * normal.dot(&least)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_face_of_a_ball_is_the_edge_of_its_cap_and_of_a_point_itself() {
        let down = -Vector3::z();
        let tips = [
            (Vector3::new(0.0, 0.0, 0.01), 0.01),
            (Vector3::new(0.1, 0.0, 0.002), 0.0),
            (Vector3::new(0.2, 0.0, 0.02), 0.0),
        ];
        let face = near_face(&tips, &down, 0.003);
        assert_eq!(face.len(), CIRCLE + 1);
        assert!((reach(&tips, &down)).abs() < 1e-15);
        // 7 mm below the centre of a ball of 10 mm
        let radius = f64::sqrt(1e-4 - 4.9e-5);
        assert!(
            face[..CIRCLE]
                .iter()
                .all(|p| (p.xy().norm() - radius).abs() < 1e-12)
        );
        assert_eq!(face[CIRCLE], tips[1].0);
    }

    #[test]
    fn axes_are_right_handed_with_x_ahead() {
        let axes = axes_of(&-Vector3::z(), &Vector3::new(2.0, 0.0, 5.0));
        assert_eq!(axes.column(0), Vector3::x());
        assert!((axes.determinant() - 1.0).abs() < 1e-15);
    }
}
