//! Actions a: which contacts break and which are made; all others are kept (paper, "Symbolic state and actions").

use crate::contact::{Contact, ContactState};
use crate::domain::Domain;

/// A symbolic action; every contact that it does not name is kept.
#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Action {
    /// Contacts that end, ordered.
    pub breaks: Vec<Contact>,
    /// Contacts that begin, ordered.
    pub makes: Vec<Contact>,
}

impl Action {
    /// The action that leads from one state to the other.
    pub fn between(from: &ContactState, to: &ContactState) -> Self {
        Self {
            breaks: from.contacts.difference(&to.contacts).copied().collect(),
            makes: to.contacts.difference(&from.contacts).copied().collect(),
        }
    }

    /// True if nothing changes.
    pub fn is_empty(&self) -> bool {
        self.breaks.is_empty() && self.makes.is_empty()
    }

    /// All contacts that change: first those that break, then those that are made.
    pub fn changes(&self) -> impl Iterator<Item = Contact> + '_ {
        self.breaks.iter().chain(&self.makes).copied()
    }

    /// In words, contact by contact: `left_foot off ground_top, left_hand on table_a_top`.
    pub fn describe(&self, domain: &Domain) -> String {
        let name = |c: &Contact, verb: &str| {
            format!(
                "{} {verb} {}",
                domain.interface(c.a).name,
                domain.interface(c.b).name
            )
        };
        let mut words: Vec<String> = self.breaks.iter().map(|c| name(c, "off")).collect();
        words.extend(self.makes.iter().map(|c| name(c, "on")));
        words.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{ContactType, InterfaceId};

    #[test]
    fn the_action_between_two_states_leads_from_one_to_the_other() {
        let contact = |a, b| Contact {
            a: InterfaceId(a),
            b: InterfaceId(b),
            kind: ContactType::UnilateralPatch,
        };
        let from: ContactState = [contact(0, 5), contact(1, 5)].into_iter().collect();
        let to: ContactState = [contact(1, 5), contact(2, 6)].into_iter().collect();
        let action = Action::between(&from, &to);
        assert_eq!(action.breaks, [contact(0, 5)]);
        assert_eq!(action.makes, [contact(2, 6)]);
        assert_eq!(from.after(&action), to);
        assert!(Action::between(&to, &to).is_empty());
    }
}
