//! Primitive shapes: what collides.

use nalgebra::Vector3;
use spatial::Pose;
use urdf_rs::Geometry;

use crate::urdf::{UrdfError, pose};

/// Largest half size of a shape [m]; larger ones are cut to this, so that distances stay finite.
pub(crate) const LARGEST: f64 = 1e6;

/// A convex body centred at the origin of its frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Solid {
    /// All points within `radius` of the segment from −`half_length` to `half_length` along z; a ball if that is zero.
    Capsule { radius: f64, half_length: f64 },
    /// A box of the given half sizes.
    Cuboid(Vector3<f64>),
}

impl Solid {
    /// The solid with all sizes at most [`LARGEST`].
    pub fn bounded(self) -> Self {
        match self {
            Self::Capsule {
                radius,
                half_length,
            } => Self::Capsule {
                radius: radius.min(LARGEST),
                half_length: half_length.min(LARGEST),
            },
            Self::Cuboid(half) => Self::Cuboid(half.map(|x| x.min(LARGEST))),
        }
    }

    /// Radius of the smallest ball about the origin that holds the solid [m].
    pub fn reach(&self) -> f64 {
        match self {
            Self::Capsule {
                radius,
                half_length,
            } => radius + half_length,
            Self::Cuboid(half) => half.norm(),
        }
    }

    /// How far the solid reaches from its origin along the unit `direction`, given in its own axes [m].
    pub fn extent(&self, direction: &Vector3<f64>) -> f64 {
        match self {
            Self::Capsule {
                radius,
                half_length,
            } => radius + half_length * direction.z.abs(),
            Self::Cuboid(half) => half.dot(&direction.abs()),
        }
    }
}

/// A shape of a link.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LinkShape {
    pub link: usize,
    pub link_from_shape: Pose,
    pub solid: Solid,
}

/// The shapes of a link, and whether there are others that are not read.
pub(crate) struct LinkShapes {
    pub read: Vec<LinkShape>,
    pub some_unread: bool,
}

/// The shapes of a link: its collision elements, or the visual ones if there are none; both if all collision elements
/// are spheres (corner spheres are not a foot). Cylinders are read as capsules of the same total length.
pub(crate) fn of_link(urdf_link: &urdf_rs::Link, link: usize) -> Result<LinkShapes, UrdfError> {
    let collision = urdf_link
        .collision
        .iter()
        .map(|x| (&x.origin, &x.geometry))
        .collect::<Vec<_>>();
    let visual = urdf_link
        .visual
        .iter()
        .map(|x| (&x.origin, &x.geometry))
        .collect::<Vec<_>>();
    let only_spheres = collision
        .iter()
        .all(|(_, geometry)| matches!(geometry, Geometry::Sphere { .. }));
    let chosen = if only_spheres {
        [collision, visual].concat()
    } else {
        collision
    };
    let mut shapes = LinkShapes {
        read: Vec::new(),
        some_unread: false,
    };
    for (origin, geometry) in chosen {
        match solid(geometry) {
            None => shapes.some_unread = true,
            Some(solid) if solid.reach().is_finite() && solid.reach() > 0.0 => {
                let link_from_shape = pose(origin, &urdf_link.name)?;
                shapes.read.push(LinkShape {
                    link,
                    link_from_shape,
                    solid: solid.bounded(),
                });
            }
            Some(_) => {
                let name = &urdf_link.name;
                return Err(UrdfError::Number(format!(
                    "link {name:?} has a shape of size {geometry:?}"
                )));
            }
        }
    }
    Ok(shapes)
}

fn solid(geometry: &Geometry) -> Option<Solid> {
    match geometry {
        Geometry::Box { size } => Some(Solid::Cuboid(Vector3::from(size.0).abs() / 2.0)),
        Geometry::Sphere { radius } => Some(Solid::Capsule {
            radius: radius.abs(),
            half_length: 0.0,
        }),
        Geometry::Cylinder { radius, length } | Geometry::Capsule { radius, length } => {
            let radius = radius.abs();
            Some(Solid::Capsule {
                radius,
                half_length: (length.abs() / 2.0 - radius).max(0.0),
            })
        }
        Geometry::Mesh { .. } => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_capsule_and_a_box_reach_as_far_as_they_do() {
        let capsule = Solid::Capsule {
            radius: 0.1,
            half_length: 0.2,
        };
        assert!((capsule.reach() - 0.3).abs() < 1e-15);
        assert!((capsule.extent(&Vector3::z()) - 0.3).abs() < 1e-15);
        assert!((capsule.extent(&-Vector3::x()) - 0.1).abs() < 1e-15);
        let cuboid = Solid::Cuboid(Vector3::new(1.0, 2.0, 2.0));
        assert!((cuboid.reach() - 3.0).abs() < 1e-15);
        assert!((cuboid.extent(&-Vector3::y()) - 2.0).abs() < 1e-15);
    }
}
