//! Shapes of bodies and the mass properties of uniform density.

use crate::file::ShapeEntry;
use crate::source::{At, Source};
use crate::values::Orientation;
use crate::{PlacedShape, SceneError, Shape};
use nalgebra::{Matrix3, Vector3};
use spatial::Pose;
use std::f64::consts::PI;

/// A shape of a file, in the frame that the file uses for the body.
pub(crate) fn placed_shape(
    source: &Source,
    body: &str,
    entry: &At<ShapeEntry>,
) -> Result<PlacedShape, SceneError> {
    let what = format!("shape of {body:?}");
    let given = [
        entry.cuboid.is_some(),
        entry.sphere.is_some(),
        entry.capsule.is_some(),
    ];
    if given.iter().filter(|g| **g).count() != 1 {
        return Err(source.bad_keys(
            entry.span(),
            &what,
            "expected exactly one of box, sphere, capsule",
        ));
    }
    let shape = if let Some(size) = &entry.cuboid {
        Shape::Box {
            half_size: Vector3::from(source.sizes(&format!("box of {body:?}"), size)?) / 2.0,
        }
    } else if let Some(radius) = &entry.sphere {
        Shape::Sphere {
            radius: source.positive(&format!("sphere radius of {body:?}"), "m", radius)?,
        }
    } else if let Some(capsule) = &entry.capsule {
        Shape::Capsule {
            radius: source.positive(
                &format!("capsule radius of {body:?}"),
                "m",
                &capsule.radius,
            )?,
            half_length: source.not_negative(
                &format!("capsule length of {body:?}"),
                "m",
                &capsule.length,
            )? / 2.0,
        }
    } else {
        return Err(source.bad_keys(entry.span(), &what, "expected box, sphere or capsule"));
    };
    let position = match &entry.position {
        Some(position) => source.point(&format!("position of a {what}"), position)?,
        None => Vector3::zeros(),
    };
    let orientation = Orientation {
        yaw: entry.yaw.as_ref(),
        quaternion: entry.quaternion.as_ref(),
    };
    Ok(PlacedShape {
        body_from_shape: source.pose(&what, position, &orientation)?,
        shape,
    })
}

/// Mass properties of shapes of the same uniform density; where they overlap both count.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MassProperties {
    /// Centre of mass in the body frame [m].
    pub centre: Vector3<f64>,
    /// Inertia about the centre of mass, body axes [kg·m²].
    pub inertia: Matrix3<f64>,
}

/// Mass properties of `mass` [kg] spread evenly over the shapes about their common or a given centre of mass.
///
/// `None` if the shapes enclose no volume.
pub(crate) fn uniform(
    mass: f64,
    shapes: &[PlacedShape],
    centre: Option<Vector3<f64>>,
) -> Option<MassProperties> {
    let volume: f64 = shapes.iter().map(|s| volume(&s.shape)).sum();
    let density = mass / volume;
    if !(density.is_finite() && volume > 0.0 && volume.is_finite()) {
        return None;
    }
    let mean = shapes
        .iter()
        .map(|s| s.body_from_shape.origin() * (self::volume(&s.shape) / volume))
        .sum();
    let centre = centre.unwrap_or(mean);
    let inertia = shapes
        .iter()
        .map(|s| inertia_about(&s.shape, density, &s.body_from_shape, centre))
        .sum();
    Some(MassProperties { centre, inertia })
}

/// Volume [m³].
fn volume(shape: &Shape) -> f64 {
    match *shape {
        Shape::Box { half_size } => 8.0 * half_size.product(),
        Shape::Sphere { radius } => 4.0 / 3.0 * PI * radius.powi(3),
        Shape::Capsule {
            radius,
            half_length,
        } => PI * radius * radius * (2.0 * half_length + 4.0 / 3.0 * radius),
        Shape::HalfSpace => f64::INFINITY,
    }
}

/// Principal moments about the own centre of a shape of the given density [kg·m²].
fn own_moments(shape: &Shape, density: f64) -> Vector3<f64> {
    match *shape {
        Shape::Box { half_size } => {
            let s = half_size.component_mul(&half_size);
            Vector3::new(s.y + s.z, s.x + s.z, s.x + s.y) * (density * volume(shape) / 3.0)
        }
        Shape::Sphere { radius } => {
            Vector3::repeat(0.4 * radius * radius * density * volume(shape))
        }
        Shape::Capsule {
            radius: r,
            half_length: h,
        } => {
            // a cylinder and two half balls, whose own centres are 3/8 r beyond the ends of the segment
            let (cylinder, balls) = (
                density * PI * r * r * 2.0 * h,
                density * 4.0 / 3.0 * PI * r.powi(3),
            );
            let axial = cylinder * r * r / 2.0 + balls * 0.4 * r * r;
            let across = cylinder * (r * r / 4.0 + h * h / 3.0)
                + balls * (0.4 * r * r + h * h + 0.75 * h * r);
            Vector3::new(across, across, axial)
        }
        Shape::HalfSpace => Vector3::repeat(f64::INFINITY),
    }
}

/// Inertia about the point `centre` of the body frame, body axes (parallel axes theorem).
fn inertia_about(
    shape: &Shape,
    density: f64,
    body_from_shape: &Pose,
    centre: Vector3<f64>,
) -> Matrix3<f64> {
    let r = body_from_shape.rotation();
    let d = body_from_shape.origin() - centre;
    let own = r * Matrix3::from_diagonal(&own_moments(shape, density)) * r.transpose();
    own + (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * (density * volume(shape))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placed(shape: Shape, x: f64) -> PlacedShape {
        PlacedShape {
            body_from_shape: Pose::from_translation(x, 0.0, 0.0),
            shape,
        }
    }

    #[test]
    fn a_box_has_the_textbook_inertia() {
        let half_size = Vector3::new(0.1, 0.2, 0.3);
        let m = uniform(12.0, &[placed(Shape::Box { half_size }, 0.5)], None).unwrap();
        assert!((m.centre - Vector3::new(0.5, 0.0, 0.0)).norm() < 1e-15);
        // m/12 (b² + c²) with full sizes 0.2, 0.4, 0.6
        let expected = Matrix3::from_diagonal(&Vector3::new(0.52, 0.40, 0.20));
        assert!((m.inertia - expected).norm() < 1e-14);
    }

    #[test]
    fn two_half_boxes_weigh_like_the_whole() {
        let half = Shape::Box {
            half_size: Vector3::new(0.1, 0.2, 0.3),
        };
        let whole = Shape::Box {
            half_size: Vector3::new(0.2, 0.2, 0.3),
        };
        let parts = uniform(3.0, &[placed(half.clone(), -0.1), placed(half, 0.1)], None).unwrap();
        let one = uniform(3.0, &[placed(whole, 0.0)], None).unwrap();
        assert!((parts.inertia - one.inertia).norm() < 1e-15);
        assert!(parts.centre.norm() < 1e-15);
    }

    #[test]
    fn a_capsule_without_length_is_a_ball_and_a_sampled_one_agrees() {
        let ball = uniform(2.0, &[placed(Shape::Sphere { radius: 0.3 }, 0.0)], None).unwrap();
        let short = Shape::Capsule {
            radius: 0.3,
            half_length: 0.0,
        };
        let capsule = uniform(2.0, &[placed(short, 0.0)], None).unwrap();
        assert!((ball.inertia - capsule.inertia).norm() < 1e-15);

        // midpoint sums over slices: m = ∫ π s², I_z = ∫ π s⁴/2, I_x = ∫ π s² (s²/4 + z²)
        let (r, h) = (0.2, 0.35);
        let slices = 200_000;
        let (mut volume, mut axial, mut across) = (0.0, 0.0, 0.0);
        let dz = 2.0 * (r + h) / f64::from(slices);
        for i in 0..slices {
            let z = -(r + h) + (f64::from(i) + 0.5) * dz;
            let beyond = (z.abs() - h).max(0.0);
            let s2 = r * r - beyond * beyond;
            volume += PI * s2 * dz;
            axial += PI * s2 * s2 / 2.0 * dz;
            across += PI * s2 * (s2 / 4.0 + z * z) * dz;
        }
        let long = Shape::Capsule {
            radius: r,
            half_length: h,
        };
        let m = uniform(1.0, &[placed(long, 0.0)], None).unwrap();
        assert!((m.inertia[(2, 2)] - axial / volume).abs() < 1e-9);
        assert!((m.inertia[(0, 0)] - across / volume).abs() < 1e-9);
    }

    #[test]
    fn shapes_without_volume_have_no_mass_properties() {
        assert_eq!(uniform(1.0, &[], None), None);
        assert_eq!(uniform(1.0, &[placed(Shape::HalfSpace, 0.0)], None), None);
    }
}
