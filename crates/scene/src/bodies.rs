//! Movable objects and static bodies with their interfaces, before anything is placed on anything.

use crate::file::{ObjectEntry, SideEntry, StaticEntry};
use crate::interfaces::{BodySurface, Friction};
use crate::shapes::{MassProperties, placed_shape, uniform};
use crate::source::{At, Source};
use crate::values::Orientation;
use crate::{Interface, Object, Owner, PlacedShape, SceneError, Shape, StaticBody};
use nalgebra::{Matrix3, Vector3};
use spatial::Pose;
use std::ops::Range;

/// Heavier objects are taken for mistakes [kg].
const LARGEST_MASS: f64 = 1e5;

/// Larger moments of inertia are taken for mistakes [kg·m²].
const LARGEST_INERTIA: f64 = 1e9;

/// Play in the tests of a given inertia, relative to its largest moment.
const INERTIA_PLAY: f64 = 1e-9;

/// An interface with the bytes that name it.
pub(crate) type NamedInterface = (Interface, Range<usize>);

/// A static body and its interfaces.
pub(crate) fn static_body(
    source: &Source,
    entry: &StaticEntry,
    index: usize,
    friction: Friction,
) -> Result<(StaticBody, Vec<NamedInterface>), SceneError> {
    let name = &*entry.name;
    let what = format!("static body {name:?}");
    let position = match &entry.position {
        Some(position) => source.point(&format!("position of {what}"), position)?,
        None => Vector3::zeros(),
    };
    let orientation = Orientation {
        yaw: entry.yaw.as_ref(),
        quaternion: entry.quaternion.as_ref(),
    };
    let world_from_body = source.pose(&what, position, &orientation)?;
    let half_box = half_box(source, &what, entry.size.as_ref())?;
    let mut shapes = Vec::new();
    let plane = entry.plane.as_ref().filter(|plane| ***plane);
    if let Some(plane) = plane {
        if half_box.is_some() || !entry.shape.is_empty() {
            let problem = "a plane has no size and no shape; make two bodies of them";
            return Err(source.bad_keys(plane.span(), &what, problem));
        }
        shapes.push(PlacedShape {
            body_from_shape: Pose::identity(),
            shape: Shape::HalfSpace,
        });
    }
    shapes.extend(own_shapes(source, name, half_box, &entry.shape)?);
    if shapes.is_empty() {
        let problem = "expected size = [x, y, z], plane = true or a [[static.shape]]";
        return Err(source.bad_keys(entry.name.span(), &what, problem));
    }
    let surface = BodySurface {
        owner: Owner::Static(index),
        half_box,
        unbounded: plane.is_some(),
        body_from_file: world_from_body,
        friction: friction.overridden(source, &what, entry.mu.as_ref(), entry.mu_r.as_ref())?,
    };
    let mut interfaces = own_interfaces(source, &surface, &entry.interface)?;
    let has_top = half_box.is_some() || plane.is_some();
    if has_top && entry.top.unwrap_or(true) {
        let top = surface.automatic(format!("{name}_top"), SideEntry::PlusZ, false);
        add_automatic(&mut interfaces, top, &entry.name);
    }
    let body = StaticBody {
        name: name.clone(),
        shapes: moved(shapes, &world_from_body),
    };
    Ok((body, interfaces))
}

/// A movable object whose frame is moved to its centre of mass; its start pose is not set yet.
pub(crate) struct UnplacedObject {
    pub object: Object,
    /// From the frame that the file uses to the frame at the centre of mass.
    pub body_from_file: Pose,
    pub interfaces: Vec<NamedInterface>,
}

/// A movable object and its interfaces.
pub(crate) fn object(
    source: &Source,
    entry: &ObjectEntry,
    index: usize,
    friction: Friction,
) -> Result<UnplacedObject, SceneError> {
    let name = &*entry.name;
    let what = format!("object {name:?}");
    let mass = source.positive(&format!("mass of {what}"), "kg", &entry.mass)?;
    if mass > LARGEST_MASS {
        let problem = format!("a mass of {mass} kg, expected at most {LARGEST_MASS} kg");
        return Err(source.bad_keys(entry.mass.span(), &what, &problem));
    }
    let half_box = half_box(source, &what, entry.size.as_ref())?;
    let shapes = own_shapes(source, name, half_box, &entry.shape)?;
    if shapes.is_empty() {
        let problem = "expected size = [x, y, z] or an [[object.shape]]";
        return Err(source.bad_keys(entry.name.span(), &what, problem));
    }
    let MassProperties { centre, inertia } = mass_properties(source, &what, entry, mass, &shapes)?;
    let body_from_file = Pose::from_translation(-centre.x, -centre.y, -centre.z);
    let surface = BodySurface {
        owner: Owner::Object(index),
        half_box,
        unbounded: false,
        body_from_file,
        friction: friction.overridden(source, &what, entry.mu.as_ref(), entry.mu_r.as_ref())?,
    };
    let mut interfaces = own_interfaces(source, &surface, &entry.interface)?;
    if half_box.is_some() && entry.bottom.unwrap_or(true) {
        let bottom = surface.automatic(format!("{name}_bottom"), SideEntry::MinusZ, true);
        add_automatic(&mut interfaces, bottom, &entry.name);
    }
    let object = Object {
        name: name.clone(),
        mass,
        inertia,
        shapes: moved(shapes, &body_from_file),
        world_from_start: Pose::identity(),
    };
    Ok(UnplacedObject {
        object,
        body_from_file,
        interfaces,
    })
}

fn mass_properties(
    source: &Source,
    what: &str,
    entry: &ObjectEntry,
    mass: f64,
    shapes: &[PlacedShape],
) -> Result<MassProperties, SceneError> {
    let given_centre = match &entry.centre_of_mass {
        Some(centre) => Some(source.point(&format!("centre_of_mass of {what}"), centre)?),
        None => None,
    };
    let properties = uniform(mass, shapes, given_centre)
        .filter(|p| p.inertia.iter().all(|x| x.is_finite()) && p.inertia.trace() > 0.0)
        .ok_or_else(|| {
            let problem = "the shapes are too small or too large for a body with mass";
            source.bad_keys(entry.name.span(), what, problem)
        })?;
    let Some(given) = &entry.inertia else {
        return Ok(properties);
    };
    let [xx, yy, zz, xy, xz, yz] = **given;
    let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    if !is_physical(&inertia) {
        let problem = format!(
            "inertia {:?} kg·m² is that of no body, expected [ixx, iyy, izz, ixy, ixz, iyz] with positive principal \
             moments, none larger than the sum of the other two",
            **given
        );
        return Err(source.bad_keys(given.span(), what, &problem));
    }
    Ok(MassProperties {
        centre: properties.centre,
        inertia,
    })
}

/// Are the principal moments those of some body: positive, the largest at most the sum of the others?
fn is_physical(inertia: &Matrix3<f64>) -> bool {
    if !inertia.iter().all(|x| x.abs() < LARGEST_INERTIA) {
        return false;
    }
    let moments = inertia.symmetric_eigenvalues();
    let largest = moments.max();
    moments.min() > 0.0 && 2.0 * largest <= moments.sum() + INERTIA_PLAY * largest
}

fn half_box(
    source: &Source,
    what: &str,
    size: Option<&At<[f64; 3]>>,
) -> Result<Option<Vector3<f64>>, SceneError> {
    size.map(|size| Ok(Vector3::from(source.sizes(&format!("size of {what}"), size)?) / 2.0))
        .transpose()
}

/// The box `size` and the further shapes, in the frame that the file uses.
fn own_shapes(
    source: &Source,
    name: &str,
    half_box: Option<Vector3<f64>>,
    entries: &[At<crate::file::ShapeEntry>],
) -> Result<Vec<PlacedShape>, SceneError> {
    let main = half_box.map(|half_size| {
        Ok(PlacedShape {
            body_from_shape: Pose::identity(),
            shape: Shape::Box { half_size },
        })
    });
    let further = entries
        .iter()
        .map(|entry| placed_shape(source, name, entry));
    main.into_iter().chain(further).collect()
}

fn own_interfaces(
    source: &Source,
    surface: &BodySurface,
    entries: &[At<crate::file::InterfaceEntry>],
) -> Result<Vec<NamedInterface>, SceneError> {
    entries
        .iter()
        .map(|entry| Ok((surface.interface(source, entry)?, entry.name.span())))
        .collect()
}

/// Adds an interface that the file did not ask for, unless it gives one of that name itself.
fn add_automatic(interfaces: &mut Vec<NamedInterface>, automatic: Interface, body: &At<String>) {
    if interfaces.iter().all(|(own, _)| own.name != automatic.name) {
        interfaces.push((automatic, body.span()));
    }
}

fn moved(shapes: Vec<PlacedShape>, to_from_file: &Pose) -> Vec<PlacedShape> {
    shapes
        .into_iter()
        .map(|placed| PlacedShape {
            body_from_shape: *to_from_file * placed.body_from_shape,
            ..placed
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inertia_of_a_body_keeps_the_triangle_inequality() {
        let diagonal = |x, y, z| Matrix3::from_diagonal(&Vector3::new(x, y, z));
        assert!(is_physical(&diagonal(1.0, 1.0, 1.0)));
        assert!(is_physical(&diagonal(1.0, 1.0, 2.0)));
        assert!(!is_physical(&diagonal(1.0, 1.0, 2.1)));
        assert!(!is_physical(&diagonal(1.0, -0.5, 1.0)));
        assert!(!is_physical(&diagonal(f64::NAN, 1.0, 1.0)));
    }
}
