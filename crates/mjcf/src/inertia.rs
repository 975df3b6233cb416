//! Inertias of bodies: given, or those of their geoms.

use crate::error::MjcfError;
use crate::pose::{between, pose};
use crate::shapes::size;
use mjcf_rs::Model;
use mjcf_rs::body::{Body, Geom, GeomType, InertiaSpec};
use mjcf_rs::compiler::InertiaFromGeom;
use nalgebra::{Matrix3, Vector3};
use spatial::{Inertia, Pose};
use std::f64::consts::PI;

/// The inertia of a body in its frame.
pub fn of_body(model: &Model, body: &Body, name: &str) -> Result<Inertia, MjcfError> {
    let compiler = &model.compiler;
    match (&body.inertial, compiler.inertia_from_geom) {
        (Some(given), InertiaFromGeom::Auto | InertiaFromGeom::False) => {
            let tensor = match given.inertia {
                InertiaSpec::Diagonal(d) => Matrix3::from_diagonal(&Vector3::from(d)),
                InertiaSpec::Full([xx, yy, zz, xy, xz, yz]) => {
                    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
                }
            };
            Ok(about_centre(given.mass, tensor).transformed(&pose(&given.pose)))
        }
        (None, InertiaFromGeom::False) => Ok(Inertia::zero()),
        _ => {
            let mut sum = Inertia::zero();
            for geom in &body.geoms {
                let body_name = || name.to_owned();
                let own = of_geom(geom, compiler.inertia_density)
                    .ok_or_else(|| MjcfError::MeshInertia { body: body_name() })?;
                if own.mass != 0.0 {
                    sum = sum + own;
                }
            }
            Ok(sum)
        }
    }
}

fn about_centre(mass: f64, inertia: Matrix3<f64>) -> Inertia {
    Inertia {
        mass,
        com: Vector3::zeros(),
        inertia,
    }
}

/// The inertia of a geom in the frame of its body; `None` if that is up to a mesh.
fn of_geom(geom: &Geom, density: f64) -> Option<Inertia> {
    let density = geom.density.unwrap_or(density);
    if geom.mass == Some(0.0) || (geom.mass.is_none() && density == 0.0) {
        return Some(Inertia::zero());
    }
    let [a, b, c] = size(geom);
    let half = b; // of a cylinder or capsule
    // Volume, and second moments of a unit mass about the three axes.
    let (volume, moments) = match geom.type_ {
        GeomType::Sphere => (4.0 / 3.0 * PI * a.powi(3), Vector3::repeat(0.4 * a * a)),
        GeomType::Box => {
            let (x, y, z) = (a * a, b * b, c * c);
            (8.0 * a * b * c, Vector3::new(y + z, x + z, x + y) / 3.0)
        }
        GeomType::Ellipsoid => {
            let (x, y, z) = (a * a, b * b, c * c);
            let volume = 4.0 / 3.0 * PI * a * b * c;
            (volume, Vector3::new(y + z, x + z, x + y) / 5.0)
        }
        GeomType::Cylinder => {
            let across = a * a / 4.0 + half * half / 3.0;
            let volume = 2.0 * PI * a * a * half;
            (volume, Vector3::new(across, across, a * a / 2.0))
        }
        GeomType::Capsule => {
            let (tube, ball) = (2.0 * PI * a * a * half, 4.0 / 3.0 * PI * a.powi(3));
            let (tube_share, ball_share) = (tube / (tube + ball), ball / (tube + ball));
            let of_tube = a * a / 4.0 + half * half / 3.0;
            // Half balls, their centres at 3/8 of the radius beyond the ends.
            let of_ball = 0.4 * a * a + half * half + 0.75 * half * a;
            let across = tube_share * of_tube + ball_share * of_ball;
            let along = tube_share * a * a / 2.0 + ball_share * 0.4 * a * a;
            (tube + ball, Vector3::new(across, across, along))
        }
        GeomType::Mesh | GeomType::Sdf => return None,
        GeomType::Plane | GeomType::Hfield => return Some(Inertia::zero()),
    };
    let mass = geom.mass.unwrap_or(density * volume);
    let own = about_centre(mass, Matrix3::from_diagonal(&(moments * mass)));
    Some(own.transformed(&body_from_geom(geom)))
}

/// Pose of a geom in its body.
pub fn body_from_geom(geom: &Geom) -> Pose {
    geom.fromto
        .map_or_else(|| pose(&geom.pose), |ends| between(ends).0)
}
