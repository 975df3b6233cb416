//! Which pairs of interfaces can never touch: the paper's "Infeasible states", rule by rule.
//!
//! A rule is a predicate on a triple (i, j, θ) that is true if the triple is impossible. Their order is that of
//! [`RULES`]; the statistics count the triples and states that remain after each.

use crate::contact::{Contact, ContactType, InterfaceId};
use crate::domain::{Interface, Owner, Role};

/// True if the triple is impossible.
pub type Rule = fn(&[Interface], &Contact) -> bool;

/// The rules in order, with their names.
pub const RULES: [(&str, Rule); 6] = [
    ("no interface touches itself", is_self_pair),
    ("static bodies do not touch each other", is_static_pair),
    ("a body does not touch itself", is_same_body),
    (
        "one of two mirrored pairs: the landing side comes first",
        is_not_landing,
    ),
    ("feet keep off what is not for them", is_forbidden_to_feet),
    (
        "points and patches match, both support the type",
        is_type_mismatch,
    ),
];

/// θ_{i,i} ≠ ∅ is false.
pub fn is_self_pair(_: &[Interface], contact: &Contact) -> bool {
    contact.a == contact.b
}

/// Two interfaces of static bodies.
pub fn is_static_pair(interfaces: &[Interface], contact: &Contact) -> bool {
    let is_static = |id: InterfaceId| matches!(interfaces[id.0].owner, Owner::Static(_));
    is_static(contact.a) && is_static(contact.b)
}

/// Two interfaces of the same object or of the robot.
pub fn is_same_body(interfaces: &[Interface], contact: &Contact) -> bool {
    interfaces[contact.a.0].owner == interfaces[contact.b.0].owner
}

/// `a` is not the robot's nor a surface on which an object can rest, or `b` is the robot's.
///
/// Of (i, j) and (j, i) this leaves one, except between two objects' surfaces that can both rest: there the order
/// says which object lies on which, and no state holds both (see [`crate::state_rules`]).
pub fn is_not_landing(interfaces: &[Interface], contact: &Contact) -> bool {
    let (a, b) = (&interfaces[contact.a.0], &interfaces[contact.b.0]);
    let lands = match a.owner {
        Owner::Robot => true,
        Owner::Object(_) => a.lands,
        Owner::Static(_) => false,
    };
    !lands || b.owner == Owner::Robot
}

/// `a` is a foot, and `b` a surface that bears none.
pub fn is_forbidden_to_feet(interfaces: &[Interface], contact: &Contact) -> bool {
    let (a, b) = (&interfaces[contact.a.0], &interfaces[contact.b.0]);
    a.role == Role::Foot && !b.bears_feet
}

/// θ is not supported by both, or is a patch type without two patches, or a point type without a point on a patch.
pub fn is_type_mismatch(interfaces: &[Interface], contact: &Contact) -> bool {
    let (a, b) = (&interfaces[contact.a.0], &interfaces[contact.b.0]);
    let supported =
        a.contact_types.contains(&contact.kind) && b.contact_types.contains(&contact.kind);
    !supported || !b.patch || a.patch != contact.kind.is_patch()
}

/// All triples (i, j, θ) ∈ 𝓘 × 𝓘 × 𝒯 with θ ≠ ∅, ordered.
pub fn all_triples(n_interfaces: usize) -> impl Iterator<Item = Contact> {
    let ids = move || (0..n_interfaces).map(InterfaceId);
    ids().flat_map(move |a| {
        ids().flat_map(move |b| ContactType::ALL.map(|kind| Contact { a, b, kind }))
    })
}

/// The triples that no rule excludes, ordered.
pub fn possible(interfaces: &[Interface]) -> Vec<Contact> {
    all_triples(interfaces.len())
        .filter(|contact| RULES.iter().all(|(_, rule)| !rule(interfaces, contact)))
        .collect()
}
