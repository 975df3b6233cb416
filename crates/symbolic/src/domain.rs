//! The domain: objects, interfaces 𝓘 and what they can touch; names and indices only, no pose.
//!
//! Source: paper, "Symbolic state and actions" and "Symbolic planning".

use std::collections::{BTreeMap, BTreeSet};

use crate::contact::{Contact, ContactType, InterfaceId};
use crate::contact_rules;
use crate::error::SymbolicError;

/// The body that carries an interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Owner {
    /// The robot.
    Robot,
    /// A movable object, by its index in [`Domain::objects`].
    Object(usize),
    /// A body that never moves, by any index of the caller's.
    Static(usize),
}

/// What an interface is used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// A foot of the robot.
    Foot,
    /// A hand of the robot: grasps objects and may support.
    Hand,
    /// Any other surface, of an object, the environment or the robot (a robot's surface may only support).
    Surface,
}

/// A surface or point that can be in contact, i ∈ 𝓘.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Interface {
    /// Unique name.
    pub name: String,
    /// The body that carries it.
    pub owner: Owner,
    /// What it is used for.
    pub role: Role,
    /// True for a patch, false for a point.
    pub patch: bool,
    /// Of an object's surface: can the object rest on it (a bottom), or does it only carry others (a top, a handle)?
    ///
    /// Interfaces of the robot always land, those of static bodies never do.
    pub lands: bool,
    /// May feet stand on it? Of interfaces of the robot it says nothing.
    pub bears_feet: bool,
    /// Contact types that it supports, on either side of a contact.
    pub contact_types: Vec<ContactType>,
}

/// All objects and interfaces of a scene, validated, with every contact that is possible between them.
#[derive(Debug, Clone)]
pub struct Domain {
    interfaces: Vec<Interface>,
    objects: Vec<String>,
    squeezes: Vec<(InterfaceId, InterfaceId)>,
    contacts: Vec<Contact>,
    by_landing: BTreeMap<InterfaceId, Vec<Contact>>,
}

impl Domain {
    /// Builds a domain.
    ///
    /// `objects` are the names of the movable bodies; `squeezes` are the pairs of opposite patches of an object
    /// between which two hands can hold it.
    ///
    /// # Errors
    /// Names used twice, missing contact types, points with patch types, feet or hands that are not the robot's,
    /// indices out of range, squeezes that are not two patches of one object.
    pub fn new(
        interfaces: Vec<Interface>,
        objects: Vec<String>,
        squeezes: Vec<(InterfaceId, InterfaceId)>,
    ) -> Result<Self, SymbolicError> {
        check_names(&interfaces, &objects)?;
        for interface in &interfaces {
            check_interface(interface, objects.len())?;
        }
        for &(a, b) in &squeezes {
            check_squeeze(&interfaces, a, b)?;
        }
        let contacts = contact_rules::possible(&interfaces);
        let mut by_landing: BTreeMap<InterfaceId, Vec<Contact>> = BTreeMap::new();
        for &contact in &contacts {
            by_landing.entry(contact.a).or_default().push(contact);
        }
        Ok(Self {
            interfaces,
            objects,
            squeezes,
            contacts,
            by_landing,
        })
    }

    /// Every possible contact (i, j, θ), ordered: `a` an end-effector or a landing surface of an object, `b` a patch
    /// of another body, θ supported by both; see [`contact_rules`].
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// The possible contacts in which interface `a` lands.
    pub fn landings(&self, a: InterfaceId) -> &[Contact] {
        self.by_landing.get(&a).map_or(&[], Vec::as_slice)
    }

    /// True if the contact is one of [`Domain::contacts`].
    pub fn allows(&self, contact: &Contact) -> bool {
        self.contacts.binary_search(contact).is_ok()
    }

    /// The interface of that index; panics if it is not one of this domain.
    pub fn interface(&self, id: InterfaceId) -> &Interface {
        &self.interfaces[id.0]
    }

    /// All interfaces in order.
    pub fn interfaces(&self) -> &[Interface] {
        &self.interfaces
    }

    /// All indices in order.
    pub fn ids(&self) -> impl Iterator<Item = InterfaceId> + '_ {
        (0..self.interfaces.len()).map(InterfaceId)
    }

    /// The robot's interfaces in order.
    pub fn effectors(&self) -> impl Iterator<Item = InterfaceId> + '_ {
        self.ids()
            .filter(|&i| self.interface(i).owner == Owner::Robot)
    }

    /// The interface of that name.
    pub fn find(&self, name: &str) -> Option<InterfaceId> {
        self.ids().find(|&i| self.interface(i).name == name)
    }

    /// Names of the objects.
    pub fn objects(&self) -> &[String] {
        &self.objects
    }

    /// Pairs of opposite patches between which two hands can hold an object.
    pub fn squeezes(&self) -> &[(InterfaceId, InterfaceId)] {
        &self.squeezes
    }

    /// The object that carries the interface.
    pub fn object_of(&self, id: InterfaceId) -> Option<usize> {
        match self.interface(id).owner {
            Owner::Object(object) => Some(object),
            Owner::Robot | Owner::Static(_) => None,
        }
    }

    /// True if the interface is the robot's and has that role.
    pub fn is_effector(&self, id: InterfaceId, role: Role) -> bool {
        let interface = self.interface(id);
        interface.owner == Owner::Robot && interface.role == role
    }

    /// The contact in words: `left_foot on ground_top`, `left_hand holds red_box_handle`.
    pub fn contact_name(&self, contact: &Contact) -> String {
        let verb = if contact.kind.is_unilateral() {
            "on"
        } else {
            "holds"
        };
        format!(
            "{} {verb} {}",
            self.interface(contact.a).name,
            self.interface(contact.b).name
        )
    }
}

fn check_names(interfaces: &[Interface], objects: &[String]) -> Result<(), SymbolicError> {
    let name = first_duplicate(interfaces.iter().map(|i| &i.name))
        .or_else(|| first_duplicate(objects.iter()));
    name.map_or(Ok(()), |name| {
        Err(SymbolicError::DuplicateName { name: name.clone() })
    })
}

fn first_duplicate<'a>(mut names: impl Iterator<Item = &'a String>) -> Option<&'a String> {
    let mut seen = BTreeSet::new();
    names.find(|name| !seen.insert(*name))
}

fn check_interface(interface: &Interface, n_objects: usize) -> Result<(), SymbolicError> {
    let name = || interface.name.clone();
    match interface.owner {
        Owner::Object(index) if index >= n_objects => {
            return Err(SymbolicError::UnknownObject {
                interface: name(),
                index,
                count: n_objects,
            });
        }
        Owner::Object(_) | Owner::Static(_) if interface.role != Role::Surface => {
            return Err(SymbolicError::EffectorWithoutRobot { interface: name() });
        }
        _ => {}
    }
    if interface.contact_types.is_empty() {
        return Err(SymbolicError::NoContactType { interface: name() });
    }
    let wrong = interface
        .contact_types
        .iter()
        .find(|kind| kind.is_patch() && !interface.patch);
    wrong.map_or(Ok(()), |kind| {
        Err(SymbolicError::PatchTypeOnPoint {
            interface: name(),
            kind: kind.name(),
        })
    })
}

fn check_squeeze(
    interfaces: &[Interface],
    a: InterfaceId,
    b: InterfaceId,
) -> Result<(), SymbolicError> {
    let count = interfaces.len();
    let get = |id: InterfaceId| {
        interfaces
            .get(id.0)
            .ok_or(SymbolicError::UnknownInterface { index: id.0, count })
    };
    let (one, other) = (get(a)?, get(b)?);
    let on_one_object = matches!(one.owner, Owner::Object(_)) && one.owner == other.owner;
    if a == b || !on_one_object || !one.patch || !other.patch {
        return Err(SymbolicError::BadSqueeze {
            a: one.name.clone(),
            b: other.name.clone(),
        });
    }
    Ok(())
}
