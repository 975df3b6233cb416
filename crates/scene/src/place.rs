//! Start poses of the objects: in the world, or on an interface of something else.

use crate::bodies::UnplacedObject;
use crate::draft::Draft;
use crate::file::ObjectEntry;
use crate::source::Source;
use crate::touch::Touch;
use crate::values::Orientation;
use crate::{Fault, Owner, SceneError};
use nalgebra::{Matrix3, Vector3};
use spatial::Pose;
use symbolic::{Contact, ContactType, InterfaceId};

/// Pose of a face in the frame of the surface that it lies on: normals opposite, x axes parallel, then turned by yaw.
fn surface_from_resting(x: f64, y: f64, yaw: f64) -> Pose {
    let (sin, cos) = (yaw / 2.0).sin_cos();
    let turned = Pose::from_xyzquat(&[x, y, 0.0, 0.0, 0.0, sin, cos]);
    let flip = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0));
    turned * Pose::from_parts(flip, Vector3::zeros())
}

/// Pose of the frame at the centre of mass of an object that the file places in the world.
pub(crate) fn world_pose(
    source: &Source,
    entry: &ObjectEntry,
    unplaced: &UnplacedObject,
) -> Result<Pose, SceneError> {
    let what = format!("object {:?}", *entry.name);
    let position = match &entry.position {
        Some(position) if position.0.len() == 3 => {
            source.coordinates(&format!("position of {what}"), position.span(), &position.0)?;
            Vector3::from_column_slice(&position.0)
        }
        Some(position) => {
            let problem = "expected position = [x, y, z], or two numbers together with on";
            return Err(source.bad_keys(position.span(), &what, problem));
        }
        None => {
            let problem = "expected position = [x, y, z] or on = \"<interface>\"";
            return Err(source.bad_keys(entry.name.span(), &what, problem));
        }
    };
    if let Some(with) = &entry.with {
        let problem = "`with` names what stands on `on`, which is missing";
        return Err(source.bad_keys(with.span(), &what, problem));
    }
    let orientation = Orientation {
        yaw: entry.yaw.as_ref(),
        quaternion: entry.quaternion.as_ref(),
    };
    let world_from_file = source.pose(&what, position, &orientation)?;
    Ok(world_from_file * unplaced.body_from_file.inverse())
}

/// Places every object that stands on something, supports first; returns their contacts.
///
/// The others have their start poses already.
pub(crate) fn place_supported(
    draft: &mut Draft,
    entries: &[ObjectEntry],
) -> Result<Vec<Contact>, SceneError> {
    let mut contacts = Vec::new();
    let mut open: Vec<usize> = (0..entries.len())
        .filter(|i| entries[*i].on.is_some())
        .collect();
    while !open.is_empty() {
        let before = open.len();
        let mut waiting = Vec::new();
        for &index in &open {
            let (resting, on) = supported_pair(draft, &entries[index], index)?;
            match draft.interfaces[on.0].owner {
                Owner::Object(support) if open.contains(&support) => waiting.push(index),
                _ => contacts.push(place_one(draft, &entries[index], index, resting, on)?),
            }
        }
        if waiting.len() == before {
            return Err(support_ring(draft.source, entries, &waiting));
        }
        open = waiting;
    }
    Ok(contacts)
}

fn support_ring(source: &Source, entries: &[ObjectEntry], ring: &[usize]) -> SceneError {
    let names: Vec<String> = ring
        .iter()
        .map(|i| format!("{:?}", *entries[*i].name))
        .collect();
    let first = &entries[ring[0]];
    let span = first
        .on
        .as_ref()
        .map_or(first.name.span(), super::source::At::span);
    let fault = Fault::SupportRing {
        objects: names.join(", "),
    };
    source.fault(span, fault)
}

/// The interfaces that `with` and `on` of an object name.
fn supported_pair(
    draft: &Draft,
    entry: &ObjectEntry,
    index: usize,
) -> Result<(InterfaceId, InterfaceId), SceneError> {
    let (source, what) = (draft.source, format!("object {:?}", *entry.name));
    let Some(on) = &entry.on else {
        return Err(source.bad_keys(entry.name.span(), &what, "expected on"));
    };
    let on_id = draft.interface(on, &what)?;
    let resting = if let Some(with) = &entry.with {
        let resting = draft.interface(with, &what)?;
        if draft.interfaces[resting.0].owner != Owner::Object(index) {
            let problem = "`with` names an interface of something else, expected one of its own";
            return Err(source.bad_keys(with.span(), &what, problem));
        }
        resting
    } else {
        let bottom = format!("{}_bottom", *entry.name);
        let own = draft
            .interfaces
            .iter()
            .position(|i| i.name == bottom && i.owner == Owner::Object(index));
        own.map(InterfaceId).ok_or_else(|| {
            let problem =
                format!("it has no interface {bottom:?} to stand on; name one with = \"…\"");
            source.bad_keys(on.span(), &what, &problem)
        })?
    };
    Ok((resting, on_id))
}

/// Places one object on a surface whose pose is known.
fn place_one(
    draft: &mut Draft,
    entry: &ObjectEntry,
    index: usize,
    resting: InterfaceId,
    on: InterfaceId,
) -> Result<Contact, SceneError> {
    let (source, what) = (draft.source, format!("object {:?}", *entry.name));
    let span = entry
        .on
        .as_ref()
        .map_or(entry.name.span(), super::source::At::span);
    let kind = ContactType::UnilateralPatch;
    let (a, b, _) = draft.landing_pair(span.clone(), (resting, on), Some(kind))?;
    let Some(world_from_on) = draft.world_from_surface(on).filter(|_| a == resting) else {
        let problem = format!(
            "{:?} cannot stand on {:?}; the other way round it can",
            draft.interfaces[resting.0].name, draft.interfaces[on.0].name
        );
        return Err(source.bad_keys(span, &what, &problem));
    };
    if let Some(quaternion) = &entry.quaternion {
        let problem = "a quaternion cannot be given together with on; use yaw and with";
        return Err(source.bad_keys(quaternion.span(), &what, problem));
    }
    let (x, y) = match entry.position.as_ref().map(|p| (p, p.0.as_slice())) {
        None => (0.0, 0.0),
        Some((position, &[x, y])) => {
            source.coordinates(&format!("position of {what}"), position.span(), &[x, y])?;
            (x, y)
        }
        Some((position, _)) => {
            let problem =
                "expected position = [x, y] in the plane of the interface that it stands on";
            return Err(source.bad_keys(position.span(), &what, problem));
        }
    };
    let yaw = match &entry.yaw {
        Some(yaw) => source.finite(&format!("yaw of {what}"), yaw)?,
        None => 0.0,
    };
    let world_from_resting = world_from_on * surface_from_resting(x, y, yaw);
    let resting_from_body = draft.interfaces[resting.0].body_from_interface.inverse();
    draft.objects[index].world_from_start = world_from_resting * resting_from_body;
    let (face, surface) = (&draft.interfaces[a.0], &draft.interfaces[b.0]);
    let touch = Touch::measure(kind, (face, &world_from_resting), (surface, &world_from_on));
    if let Some(gap) = touch.gap() {
        let fault = Fault::Broken {
            a: face.name.clone(),
            b: surface.name.clone(),
            gap,
        };
        let span = entry
            .position
            .as_ref()
            .map_or(span, super::source::At::span);
        return Err(source.fault(span, fault));
    }
    Ok(Contact { a, b, kind })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bottom_on_a_table_leaves_the_body_upright_and_turned_by_yaw() {
        let body_from_bottom = Pose::from_parts(
            Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)),
            Vector3::new(0.0, 0.0, -0.1),
        );
        let table_from_body = surface_from_resting(0.3, 0.2, 0.5) * body_from_bottom.inverse();
        assert!((table_from_body.origin() - Vector3::new(0.3, 0.2, 0.1)).norm() < 1e-15);
        let x_axis = table_from_body.rotate(Vector3::x());
        assert!((x_axis - Vector3::new(0.5f64.cos(), 0.5f64.sin(), 0.0)).norm() < 1e-15);
        assert!((table_from_body.rotate(Vector3::z()) - Vector3::z()).norm() < 1e-15);
    }
}
