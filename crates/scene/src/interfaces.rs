//! Interfaces of objects, static bodies and the robot, from their tables.

use crate::file::{InterfaceEntry, KindEntry, RobotInterfaceEntry, RoleEntry, SideEntry};
use crate::source::{At, Source};
use crate::values::Orientation;
use crate::{Interface, Owner, Role, SceneError};
use nalgebra::{Matrix3, Vector3};
use spatial::Pose;
use symbolic::ContactType;

/// Sliding and torsional [m] friction coefficients.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Friction {
    pub mu: f64,
    pub mu_r: f64,
}

impl Friction {
    /// These coefficients, except where others are given.
    pub fn overridden(
        self,
        source: &Source,
        what: &str,
        mu: Option<&At<f64>>,
        mu_r: Option<&At<f64>>,
    ) -> Result<Self, SceneError> {
        Ok(Self {
            mu: match mu {
                Some(mu) => source.not_negative(&format!("mu of {what}"), "", mu)?,
                None => self.mu,
            },
            mu_r: match mu_r {
                Some(mu_r) => source.not_negative(&format!("mu_r of {what}"), "m", mu_r)?,
                None => self.mu_r,
            },
        })
    }
}

/// What the tables of a body's interfaces refer to.
pub(crate) struct BodySurface {
    pub owner: Owner,
    /// Half sizes of the box `size` [m].
    pub half_box: Option<Vector3<f64>>,
    /// True for the half-space of a plane: patches may be unbounded.
    pub unbounded: bool,
    /// From the frame that the file uses to the frame that the interface is to be given in.
    pub body_from_file: Pose,
    pub friction: Friction,
}

/// Axes of an interface on a side: z is the normal, x is the body's x, or the body's y on the two x sides.
fn side_rotation(side: SideEntry) -> Matrix3<f64> {
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let (first, normal) = match side {
        SideEntry::PlusX => (y, x),
        SideEntry::MinusX => (y, -x),
        SideEntry::PlusY => (x, y),
        SideEntry::MinusY => (x, -y),
        SideEntry::PlusZ => (x, z),
        SideEntry::MinusZ => (x, -z),
    };
    Matrix3::from_columns(&[first, normal.cross(&first), normal])
}

/// Pose in the file's body frame and half extents [m] of a whole side of a box.
fn whole_side(half_box: Vector3<f64>, side: SideEntry) -> (Pose, [f64; 2]) {
    let rotation = side_rotation(side);
    let extents = rotation.tr_mul(&half_box).abs();
    let centre = rotation.column(2) * extents.z;
    (Pose::from_parts(rotation, centre), [extents.x, extents.y])
}

impl BodySurface {
    /// The interface that a body has without being asked: a whole side of its box, or of a plane.
    pub fn automatic(&self, name: String, side: SideEntry, lands: bool) -> Interface {
        let (file_from_interface, half_size) = match self.half_box {
            Some(half_box) => {
                let (pose, half_size) = whole_side(half_box, side);
                (pose, Some(half_size))
            }
            None => (
                Pose::from_parts(side_rotation(side), Vector3::zeros()),
                None,
            ),
        };
        Interface {
            name,
            owner: self.owner,
            role: Role::Surface,
            body_from_interface: self.body_from_file * file_from_interface,
            patch: true,
            half_size,
            limb: -Vector3::z(),
            contact_types: default_contacts(true),
            max_force: f64::INFINITY,
            max_moment: f64::INFINITY,
            mu: self.friction.mu,
            mu_r: self.friction.mu_r,
            overhang: false,
            bears_feet: true,
            lands,
        }
    }

    /// The interface of a table.
    pub fn interface(
        &self,
        source: &Source,
        entry: &At<InterfaceEntry>,
    ) -> Result<Interface, SceneError> {
        let what = format!("interface {:?}", *entry.name);
        let patch = entry.kind == KindEntry::Patch;
        let friction =
            self.friction
                .overridden(source, &what, entry.mu.as_ref(), entry.mu_r.as_ref())?;
        if let (Some(lands), Owner::Static(_)) = (&entry.lands, self.owner)
            && **lands
        {
            return Err(source.bad_keys(
                lands.span(),
                &what,
                "a surface of a static body cannot land on anything; leave lands out",
            ));
        }
        Ok(Interface {
            name: (*entry.name).clone(),
            owner: self.owner,
            role: Role::Surface,
            body_from_interface: self.body_from_file * self.pose(source, &what, entry)?,
            patch,
            half_size: self.half_size(source, &what, entry)?,
            limb: -Vector3::z(),
            contact_types: match &entry.contacts {
                Some(contacts) => contact_types(source, &what, patch, contacts)?,
                None => default_contacts(patch),
            },
            max_force: source.limit(
                &format!("max_force of {what}"),
                "N",
                entry.max_force.as_ref(),
            )?,
            max_moment: source.limit(
                &format!("max_moment of {what}"),
                "N·m",
                entry.max_moment.as_ref(),
            )?,
            mu: friction.mu,
            mu_r: friction.mu_r,
            overhang: entry.overhang.unwrap_or(false),
            bears_feet: entry.feet.unwrap_or(true),
            lands: entry.lands.as_deref().copied().unwrap_or(false),
        })
    }

    /// Pose in the file's body frame.
    fn pose(
        &self,
        source: &Source,
        what: &str,
        entry: &At<InterfaceEntry>,
    ) -> Result<Pose, SceneError> {
        let rotation = match (&entry.side, &entry.quaternion) {
            (Some(side), None) => side_rotation(**side),
            (None, Some(_)) => {
                let orientation = Orientation {
                    yaw: None,
                    quaternion: entry.quaternion.as_ref(),
                };
                *source
                    .pose(what, Vector3::zeros(), &orientation)?
                    .rotation()
            }
            _ => {
                return Err(source.bad_keys(
                    entry.name.span(),
                    what,
                    "expected exactly one of side and quaternion, which say where it faces",
                ));
            }
        };
        let origin = match (&entry.position, &entry.side, self.half_box) {
            (Some(position), _, _) => source.point(&format!("position of {what}"), position)?,
            (None, Some(side), Some(half_box)) => whole_side(half_box, **side).0.origin(),
            _ => {
                return Err(source.bad_keys(
                    entry.name.span(),
                    what,
                    "expected a position; it can only be left out with side on a body that has a size",
                ));
            }
        };
        Ok(Pose::from_parts(rotation, origin))
    }

    /// Half extents [m] of a patch; `None` for points and unbounded patches.
    fn half_size(
        &self,
        source: &Source,
        what: &str,
        entry: &At<InterfaceEntry>,
    ) -> Result<Option<[f64; 2]>, SceneError> {
        match (entry.kind, &entry.half_size) {
            (KindEntry::Point, None) => Ok(None),
            (KindEntry::Point, Some(half_size)) => Err(source.bad_keys(
                half_size.span(),
                what,
                "a point has no half_size; leave it out or set kind = \"patch\"",
            )),
            (KindEntry::Patch, Some(half_size)) => source
                .sizes(&format!("half_size of {what}"), half_size)
                .map(Some),
            (KindEntry::Patch, None) => match (&entry.side, self.half_box) {
                (Some(side), Some(half_box)) if entry.position.is_none() => {
                    Ok(Some(whole_side(half_box, **side).1))
                }
                _ if self.unbounded => Ok(None),
                _ => Err(source.bad_keys(
                    entry.name.span(),
                    what,
                    "expected half_size = [x, y]; it can only be left out with side and without position on a body \
                     that has a size",
                )),
            },
        }
    }
}

/// The contact types of a surface that names none: it can be pushed.
fn default_contacts(patch: bool) -> Vec<ContactType> {
    if patch {
        vec![ContactType::UnilateralPatch, ContactType::UnilateralPoint]
    } else {
        vec![ContactType::UnilateralPoint]
    }
}

fn contact_types(
    source: &Source,
    what: &str,
    patch: bool,
    entry: &At<Vec<crate::file::ContactTypeEntry>>,
) -> Result<Vec<ContactType>, SceneError> {
    let mut types: Vec<ContactType> = Vec::new();
    for kind in entry.iter().map(|kind| ContactType::from(*kind)) {
        if !types.contains(&kind) {
            types.push(kind);
        }
    }
    if types.is_empty() {
        return Err(source.bad_keys(
            entry.span(),
            what,
            "contacts is empty, expected at least one contact type",
        ));
    }
    if let Some(kind) = types.iter().find(|kind| kind.is_patch() && !patch) {
        let problem = format!(
            "a point cannot take part in {}, expected unilateral_point or bilateral_point",
            kind.name()
        );
        return Err(source.bad_keys(entry.span(), what, &problem));
    }
    Ok(types)
}

/// An end-effector of the robot on the link with index `frame`.
pub(crate) fn robot_interface(
    source: &Source,
    entry: &RobotInterfaceEntry,
    frame: usize,
    friction: Friction,
) -> Result<Interface, SceneError> {
    let what = format!("interface {:?}", *entry.name);
    let friction = friction.overridden(source, &what, entry.mu.as_ref(), entry.mu_r.as_ref())?;
    let half_size = match (entry.kind, &entry.half_size) {
        (KindEntry::Patch, Some(half_size)) => {
            Some(source.sizes(&format!("half_size of {what}"), half_size)?)
        }
        (KindEntry::Point, None) => None,
        (KindEntry::Patch, None) => {
            return Err(source.bad_keys(
                entry.name.span(),
                &what,
                "expected half_size = [x, y] for a patch",
            ));
        }
        (KindEntry::Point, Some(half_size)) => {
            return Err(source.bad_keys(
                half_size.span(),
                &what,
                "a point has no half_size; leave it out or set kind = \"patch\"",
            ));
        }
    };
    let limb = match &entry.limb {
        None => -Vector3::z(),
        Some(limb) => {
            let vector = source.point(&format!("limb of {what}"), limb)?;
            vector.try_normalize(1e-9).ok_or_else(|| {
                source.bad_keys(
                    limb.span(),
                    &what,
                    "limb has no length, expected a direction such as [0, 0, -1]",
                )
            })?
        }
    };
    Ok(Interface {
        name: (*entry.name).clone(),
        owner: Owner::Robot { frame },
        role: match entry.role {
            RoleEntry::Foot => Role::Foot,
            RoleEntry::Hand => Role::Hand,
        },
        body_from_interface: source.pose7(&what, &entry.pose)?,
        patch: entry.kind == KindEntry::Patch,
        half_size,
        limb,
        contact_types: contact_types(
            source,
            &what,
            entry.kind == KindEntry::Patch,
            &entry.contacts,
        )?,
        max_force: source.limit(
            &format!("max_force of {what}"),
            "N",
            entry.max_force.as_ref(),
        )?,
        max_moment: source.limit(
            &format!("max_moment of {what}"),
            "N·m",
            entry.max_moment.as_ref(),
        )?,
        mu: friction.mu,
        mu_r: friction.mu_r,
        overhang: false,
        bears_feet: true,
        lands: true,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_sides_lie_on_the_box_and_face_outward() {
        let half_box = Vector3::new(0.1, 0.2, 0.3);
        let (pose, half_size) = whole_side(half_box, SideEntry::MinusY);
        assert_eq!(pose.origin(), Vector3::new(0.0, -0.2, 0.0));
        assert_eq!(pose.rotate(Vector3::z()), -Vector3::y());
        assert_eq!(half_size, [0.1, 0.3]);
        let (pose, half_size) = whole_side(half_box, SideEntry::PlusX);
        assert_eq!(pose.origin(), Vector3::new(0.1, 0.0, 0.0));
        assert_eq!(pose.rotate(Vector3::x()), Vector3::y());
        assert_eq!(half_size, [0.2, 0.3]);
    }

    #[test]
    fn side_frames_are_right_handed() {
        use SideEntry::{MinusX, MinusY, MinusZ, PlusX, PlusY, PlusZ};
        for side in [PlusX, MinusX, PlusY, MinusY, PlusZ, MinusZ] {
            let r = side_rotation(side);
            assert!((r.determinant() - 1.0).abs() < 1e-15, "{side:?}");
        }
    }
}
