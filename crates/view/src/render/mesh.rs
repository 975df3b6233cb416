//! Primitive shapes as triangles with normals, in the shape's own frame.

use crate::meshes::{Corner, Triangle};
use multibody::Shape;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Parts around an axis.
const AROUND: usize = 28;

/// Parts from pole to pole.
const DOWN: usize = 14;

/// The triangles of a primitive shape; meshes, which are files, have none here.
pub(crate) fn triangles(shape: &Shape) -> Vec<Triangle> {
    match *shape {
        Shape::Box { half_size } => cuboid(&half_size),
        Shape::Sphere { radius } => ball(radius, 0.0),
        Shape::Capsule {
            radius,
            half_length,
        } => ball(radius, half_length),
        Shape::Cylinder {
            radius,
            half_length,
        } => cylinder(radius, half_length),
        Shape::Mesh { .. } => Vec::new(),
    }
}

fn cuboid(half_size: &Vector3<f64>) -> Vec<Triangle> {
    let mut faces = Vec::with_capacity(12);
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let normal = Vector3::ith(axis, sign);
            let [u, v] = [1, 2].map(|k| Vector3::ith((axis + k) % 3, half_size[(axis + k) % 3]));
            let middle = Vector3::ith(axis, sign * half_size[axis]);
            let corner = |x: f64, y: f64| (middle + u * x + v * y, normal);
            faces.extend(quad([
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ]));
        }
    }
    faces
}

fn quad([a, b, c, d]: [Corner; 4]) -> [Triangle; 2] {
    [[a, b, c], [a, c, d]]
}

/// A ball, or with a positive `half_length` a capsule along z: its halves are moved apart.
fn ball(radius: f64, half_length: f64) -> Vec<Triangle> {
    let corner = |i: usize, j: usize, upper: bool| {
        let (polar, azimuth) = (
            PI * i as f64 / DOWN as f64,
            2.0 * PI * j as f64 / AROUND as f64,
        );
        let normal = Vector3::new(
            polar.sin() * azimuth.cos(),
            polar.sin() * azimuth.sin(),
            polar.cos(),
        );
        let shift = if upper { half_length } else { -half_length };
        (normal * radius + Vector3::z() * shift, normal)
    };
    let mut faces = Vec::new();
    for j in 0..AROUND {
        for i in 0..DOWN {
            let upper = i < DOWN / 2;
            let at = |i, j| corner(i, j, upper);
            faces.extend(quad([
                at(i, j),
                at(i + 1, j),
                at(i + 1, j + 1),
                at(i, j + 1),
            ]));
        }
        if half_length > 0.0 {
            let (i, side) = (
                DOWN / 2,
                [(true, j), (false, j), (false, j + 1), (true, j + 1)],
            );
            faces.extend(quad(side.map(|(upper, j)| corner(i, j, upper))));
        }
    }
    faces
}

fn cylinder(radius: f64, half_length: f64) -> Vec<Triangle> {
    let direction = |j: usize| {
        let angle = 2.0 * PI * j as f64 / AROUND as f64;
        Vector3::new(angle.cos(), angle.sin(), 0.0)
    };
    let mut faces = Vec::new();
    for j in 0..AROUND {
        let [here, next] = [direction(j), direction(j + 1)];
        let side = [(here, -1.0), (next, -1.0), (next, 1.0), (here, 1.0)];
        faces.extend(quad(side.map(|(normal, end)| {
            (normal * radius + Vector3::z() * (end * half_length), normal)
        })));
        for end in [-1.0, 1.0] {
            let (normal, middle) = (Vector3::z() * end, Vector3::z() * (end * half_length));
            let rim = [Vector3::zeros(), here, next];
            faces.push(rim.map(|spoke| (middle + spoke * radius, normal)));
        }
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area of all triangles.
    fn area(faces: &[Triangle]) -> f64 {
        let one = |[a, b, c]: &Triangle| (b.0 - a.0).cross(&(c.0 - a.0)).norm() / 2.0;
        faces.iter().map(one).sum()
    }

    #[test]
    fn the_triangles_cover_the_surface() {
        let (r, l) = (0.3, 0.5);
        let half_size = Vector3::new(0.1, 0.2, 0.3);
        let cases = [
            (Shape::Box { half_size }, 8.0 * (0.02 + 0.03 + 0.06)),
            (Shape::Sphere { radius: r }, 4.0 * PI * r * r),
            (
                Shape::Cylinder {
                    radius: r,
                    half_length: l,
                },
                2.0 * PI * r * (2.0 * l + r),
            ),
            (
                Shape::Capsule {
                    radius: r,
                    half_length: l,
                },
                4.0 * PI * r * (r + l),
            ),
        ];
        for (shape, expected) in cases {
            let found = area(&triangles(&shape));
            assert!((found / expected - 1.0).abs() < 0.02, "{shape:?}: {found}");
        }
    }

    #[test]
    fn normals_are_unit_vectors_that_point_outwards() {
        for shape in [
            Shape::Sphere { radius: 0.2 },
            Shape::Box {
                half_size: Vector3::repeat(0.1),
            },
        ] {
            for (place, normal) in triangles(&shape).into_iter().flatten() {
                assert!((normal.norm() - 1.0).abs() < 1e-12 && place.dot(&normal) > 0.0);
            }
        }
    }
}
