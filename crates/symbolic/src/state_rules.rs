//! Which sets of possible contacts are no state: the paper's "Infeasible states", continued.
//!
//! Flight of the robot and a phase in which an object touches nothing are legal (formulation notes, 11 and 12): the
//! dynamics judge them.

use std::collections::BTreeSet;

use crate::contact::{Contact, ContactState, InterfaceId};
use crate::domain::Domain;

/// Why a set of contacts is not a state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StateFault {
    /// The contact is not one of [`Domain::contacts`].
    Impossible(Contact),
    /// The interface lands on two surfaces, or on one in two ways.
    TwoPartners(InterfaceId),
    /// The interface lands and is landed on at the same time; (i, j) together with (j, i) is the smallest case.
    BothSides(InterfaceId),
}

impl StateFault {
    /// The fault in words.
    pub fn describe(&self, domain: &Domain) -> String {
        let name = |id: &InterfaceId| &domain.interface(*id).name;
        match self {
            Self::Impossible(c) => {
                format!(
                    "{:?} and {:?} can never touch as {}",
                    name(&c.a),
                    name(&c.b),
                    c.kind.name()
                )
            }
            Self::TwoPartners(i) => format!("{:?} lands on more than one surface", name(i)),
            Self::BothSides(i) => format!(
                "{:?} rests on something and is touched on the same side",
                name(i)
            ),
        }
    }
}

/// A contact that the domain does not allow.
pub fn impossible_contact(domain: &Domain, state: &ContactState) -> Option<StateFault> {
    state
        .iter()
        .find(|contact| !domain.allows(contact))
        .map(StateFault::Impossible)
}

/// A landing side has one partner and one type; the surface landed on may have any number.
pub fn two_partners(state: &ContactState) -> Option<StateFault> {
    let contacts: Vec<Contact> = state.iter().collect();
    contacts
        .windows(2)
        .find(|pair| pair[0].a == pair[1].a)
        .map(|pair| StateFault::TwoPartners(pair[0].a))
}

/// A surface that lies face to face on another is covered: nothing touches it in the same state.
///
/// Contains the paper's θ_{i,j} ≠ ∅ ∧ θ_{j,i} ≠ ∅ = false. A surface that overhangs its support and may be touched
/// from below is modelled as two interfaces.
pub fn both_sides(state: &ContactState) -> Option<StateFault> {
    let landing: BTreeSet<InterfaceId> = state.iter().map(|c| c.a).collect();
    state
        .iter()
        .find(|c| landing.contains(&c.b))
        .map(|c| StateFault::BothSides(c.b))
}

/// The first rule that the state breaks.
pub fn state_fault(domain: &Domain, state: &ContactState) -> Option<StateFault> {
    impossible_contact(domain, state)
        .or_else(|| two_partners(state))
        .or_else(|| both_sides(state))
}
