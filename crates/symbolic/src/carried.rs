//! Who is carried: surfaces that stand on the ground in the end, and robots that something carries.

use crate::contact::{Contact, ContactState, InterfaceId};
use crate::domain::{Domain, Owner, Role};

/// True if a foot on what stands, or a hand on a static body, carries the robot; it flies otherwise.
pub fn is_carried(domain: &Domain, state: &ContactState) -> bool {
    let carries = |c: &Contact| {
        domain.interface(c.a).owner == Owner::Robot
            && (domain.is_effector(c.a, Role::Foot) || domain.object_of(c.b).is_none())
            && stands(domain, state, c.b)
    };
    state.iter().any(|c| carries(&c))
}

/// True if the body of a surface is static, or an object that rests on one, be it on others in between.
pub(crate) fn stands(domain: &Domain, state: &ContactState, surface: InterfaceId) -> bool {
    let Some(object) = domain.object_of(surface) else {
        return true;
    };
    let mut grounded = vec![object];
    let mut next = 0;
    while let Some(&object) = grounded.get(next) {
        next += 1;
        for contact in state.iter() {
            match (
                domain.interface(contact.a).owner,
                domain.interface(contact.b).owner,
            ) {
                (Owner::Object(o), Owner::Static(_)) if o == object => return true,
                (Owner::Object(o), Owner::Object(under))
                    if o == object && !grounded.contains(&under) =>
                {
                    grounded.push(under);
                }
                _ => {}
            }
        }
    }
    false
}
