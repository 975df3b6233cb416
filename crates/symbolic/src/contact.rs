//! Contacts (i, j, θ) and contact states s, as in the paper, "Symbolic state and actions".

use std::collections::BTreeSet;
use std::fmt;

use crate::action::Action;
use crate::domain::Domain;

/// Index of an interface in the scene's list 𝓘.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct InterfaceId(pub usize);

/// Contact type θ ∈ 𝒯; the absence of a contact ∅ is the absence of the pair from the state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ContactType {
    /// A point pushes on a patch: friction cone, no moment.
    UnilateralPoint,
    /// A point held by a patch (ball joint): any force up to a limit, no moment.
    BilateralPoint,
    /// A patch pushes on a patch: friction cone, centre of pressure and torsion limits.
    UnilateralPatch,
    /// A full grasp: any wrench up to a limit, no relative motion.
    BilateralPatch,
}

impl ContactType {
    /// All types but ∅, in order.
    pub const ALL: [Self; 4] = [
        Self::UnilateralPoint,
        Self::BilateralPoint,
        Self::UnilateralPatch,
        Self::BilateralPatch,
    ];

    /// The name used in scene and plan files.
    pub fn name(self) -> &'static str {
        match self {
            Self::UnilateralPoint => "unilateral_point",
            Self::BilateralPoint => "bilateral_point",
            Self::UnilateralPatch => "unilateral_patch",
            Self::BilateralPatch => "bilateral_patch",
        }
    }

    /// True if the contact can only push.
    pub fn is_unilateral(self) -> bool {
        matches!(self, Self::UnilateralPoint | Self::UnilateralPatch)
    }

    /// True if both interfaces are patches, so that their normals align.
    pub fn is_patch(self) -> bool {
        matches!(self, Self::UnilateralPatch | Self::BilateralPatch)
    }
}

/// One contact (i, j, θ): interface `a` lands on interface `b`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Contact {
    /// The foot, hand or object surface that touches.
    pub a: InterfaceId,
    /// The surface that is touched.
    pub b: InterfaceId,
    /// How they touch.
    pub kind: ContactType,
}

/// A symbolic state s: the set of all contacts of the scene.
///
/// Ordered by its contacts, so that sorting states does not depend on how they were found.
#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ContactState {
    /// The contacts, ordered.
    pub contacts: BTreeSet<Contact>,
}

impl ContactState {
    /// True if the contact is part of the state.
    pub fn contains(&self, contact: &Contact) -> bool {
        self.contacts.contains(contact)
    }

    /// The contacts in order.
    pub fn iter(&self) -> impl Iterator<Item = Contact> + '_ {
        self.contacts.iter().copied()
    }

    /// Number of contacts.
    pub fn len(&self) -> usize {
        self.contacts.len()
    }

    /// True if nothing touches anything.
    pub fn is_empty(&self) -> bool {
        self.contacts.is_empty()
    }

    /// True if every contact of `self` is in `other` (s ⊆ s′).
    pub fn is_subset(&self, other: &Self) -> bool {
        self.contacts.is_subset(&other.contacts)
    }

    /// The contact in which interface `i` lands; the first one if the state is illegal and has several.
    pub fn landing(&self, i: InterfaceId) -> Option<Contact> {
        let least = Contact {
            a: i,
            b: InterfaceId(0),
            kind: ContactType::UnilateralPoint,
        };
        self.contacts
            .range(least..)
            .next()
            .copied()
            .filter(|c| c.a == i)
    }

    /// The interface on which `i` has landed; `None` if `i` is free or only landed on.
    pub fn partner(&self, i: InterfaceId) -> Option<InterfaceId> {
        self.landing(i).map(|c| c.b)
    }

    /// The contacts whose landed-on side is interface `j`.
    pub fn landed_on(&self, j: InterfaceId) -> impl Iterator<Item = Contact> + '_ {
        self.iter().filter(move |c| c.b == j)
    }

    /// True if interface `i` takes part in any contact, on either side.
    pub fn is_touching(&self, i: InterfaceId) -> bool {
        self.iter().any(|c| c.a == i || c.b == i)
    }

    /// The successor state Γ(s, a) = (s \ breaks) ∪ makes.
    #[must_use]
    pub fn after(&self, action: &Action) -> Self {
        let mut contacts = self.contacts.clone();
        for contact in &action.breaks {
            contacts.remove(contact);
        }
        contacts.extend(action.makes.iter().copied());
        Self { contacts }
    }

    /// The pairs (a, b) in order, without their types.
    pub fn pairs(&self) -> Vec<(InterfaceId, InterfaceId)> {
        self.iter().map(|c| (c.a, c.b)).collect()
    }

    /// Text with the names of the domain: `left_foot on ground_top, left_hand holds red_box_handle`.
    pub fn display<'a>(&'a self, domain: &'a Domain) -> impl fmt::Display + 'a {
        Named {
            state: self,
            domain,
        }
    }
}

struct Named<'a> {
    state: &'a ContactState,
    domain: &'a Domain,
}

impl fmt::Display for Named<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.state.is_empty() {
            return f.write_str("no contact");
        }
        for (n, contact) in self.state.iter().enumerate() {
            let separator = if n > 0 { ", " } else { "" };
            write!(f, "{separator}{}", self.domain.contact_name(&contact))?;
        }
        Ok(())
    }
}

impl FromIterator<Contact> for ContactState {
    fn from_iter<T: IntoIterator<Item = Contact>>(contacts: T) -> Self {
        Self {
            contacts: contacts.into_iter().collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn contact(a: usize, b: usize) -> Contact {
        Contact {
            a: InterfaceId(a),
            b: InterfaceId(b),
            kind: ContactType::UnilateralPatch,
        }
    }

    #[test]
    fn partner_is_the_surface_under_the_landing_side_only() {
        let state: ContactState = [contact(1, 7), contact(3, 2)].into_iter().collect();
        assert_eq!(state.partner(InterfaceId(1)), Some(InterfaceId(7)));
        assert_eq!(state.partner(InterfaceId(2)), None, "2 is landed on");
        assert_eq!(
            state.partner(InterfaceId(0)),
            None,
            "0 is free although 1 is not"
        );
        assert_eq!(state.landed_on(InterfaceId(2)).count(), 1);
        assert!(state.is_touching(InterfaceId(7)) && !state.is_touching(InterfaceId(4)));
    }

    #[test]
    fn states_compare_by_content_not_by_order_of_insertion() {
        let one: ContactState = [contact(1, 7), contact(3, 2)].into_iter().collect();
        let other: ContactState = [contact(3, 2), contact(1, 7)].into_iter().collect();
        assert_eq!(one, other);
        assert_eq!(
            one.pairs(),
            [
                (InterfaceId(1), InterfaceId(7)),
                (InterfaceId(3), InterfaceId(2))
            ]
        );
        let less: ContactState = [contact(1, 7)].into_iter().collect();
        assert!(less.is_subset(&one) && !one.is_subset(&less) && less < one);
    }
}
