//! Which interfaces can touch, by kind and size alone (paper, "Symbolic search pruning": self-pairs, mirrored pairs and
//! static–static pairs are removed).

use crate::{Interface, Owner, Role, Scene};
use symbolic::{ContactType, InterfaceId};

/// Sizes are compared with this much play [m].
const SIZE_PLAY: f64 = 1e-6;

/// Why one interface cannot land on another, in the order in which it is tested.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Obstacle {
    /// `a` belongs to something that does not land.
    NeverLands,
    /// Both belong to the same body.
    SameBody,
    /// `b` belongs to the robot.
    OntoRobot,
    /// `a` is a foot, and `b` bears none.
    NoFeet,
    /// One of them does not take part in contacts of this type.
    Type,
    /// The type needs patches where there are points.
    Shape,
    /// `a` is larger than `b`.
    Size,
}

/// Can `a` land on `b` with a contact of type `kind`?
pub(crate) fn check(a: &Interface, b: &Interface, kind: ContactType) -> Result<(), Obstacle> {
    if !a.lands {
        return Err(Obstacle::NeverLands);
    }
    match (a.owner, b.owner) {
        (_, Owner::Robot { .. }) => return Err(Obstacle::OntoRobot),
        (Owner::Object(i), Owner::Object(j)) if i == j => return Err(Obstacle::SameBody),
        _ => {}
    }
    if a.role == Role::Foot && !b.bears_feet {
        return Err(Obstacle::NoFeet);
    }
    if !(a.contact_types.contains(&kind) && b.contact_types.contains(&kind)) {
        return Err(Obstacle::Type);
    }
    // patches lie on patches, points on patches
    if !(a.patch == kind.is_patch() && b.patch) {
        return Err(Obstacle::Shape);
    }
    if kind.is_patch() && !fits(a, b) {
        return Err(Obstacle::Size);
    }
    Ok(())
}

/// Does the rectangle of `a` fit into that of `b`, in one of the two parallel orientations?
pub(crate) fn fits(a: &Interface, b: &Interface) -> bool {
    let Some(outer) = b.half_size else {
        return true;
    };
    if b.overhang {
        return true;
    }
    let Some(inner) = a.half_size else {
        return false;
    };
    let within = |x: f64, y: f64| x <= outer[0] + SIZE_PLAY && y <= outer[1] + SIZE_PLAY;
    within(inner[0], inner[1]) || within(inner[1], inner[0])
}

/// The types with which `a` can land on `b`, in the order in which `a` lists them.
pub(crate) fn possible_types(a: &Interface, b: &Interface) -> Vec<ContactType> {
    a.contact_types
        .iter()
        .copied()
        .filter(|kind| check(a, b, *kind).is_ok())
        .collect()
}

impl Scene {
    /// The interface of a name.
    pub fn interface_id(&self, name: &str) -> Option<InterfaceId> {
        self.interfaces
            .iter()
            .position(|interface| interface.name == name)
            .map(InterfaceId)
    }

    /// Can interface `a` land on interface `b` with a contact of type `kind`, judged by owners, contact types and sizes?
    ///
    /// Hands and feet land on surfaces of objects and static bodies; surfaces of objects that [`Interface::lands`] land on
    /// static bodies and other objects. Feet keep off what does not bear them ([`Interface::bears_feet`]).
    /// A patch must fit into a bounded patch unless that allows [`Interface::overhang`]. Poses and reach are not considered. False if an index is out of range.
    pub fn contact_possible(&self, a: InterfaceId, b: InterfaceId, kind: ContactType) -> bool {
        match (self.interfaces.get(a.0), self.interfaces.get(b.0)) {
            (Some(a), Some(b)) => check(a, b, kind).is_ok(),
            _ => false,
        }
    }
}
