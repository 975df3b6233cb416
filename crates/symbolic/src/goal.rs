//! Goals s_g: contact pairs that the last state must hold (paper, "Symbolic planning").

use crate::contact::ContactType;
use crate::contact::{Contact, ContactState, InterfaceId};
use crate::contact_rules::RULES;
use crate::domain::Domain;
use crate::error::SymbolicError;

/// A pair that must touch at the end, in either order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct GoalPair {
    /// One side.
    pub a: InterfaceId,
    /// The other side.
    pub b: InterfaceId,
    /// The contact type; `None` accepts any.
    pub kind: Option<ContactType>,
}

impl GoalPair {
    /// A pair of any type.
    pub fn new(a: InterfaceId, b: InterfaceId) -> Self {
        Self { a, b, kind: None }
    }

    /// True if the contact is of this pair.
    pub fn matches(&self, contact: &Contact) -> bool {
        let same = (contact.a, contact.b) == (self.a, self.b)
            || (contact.a, contact.b) == (self.b, self.a);
        same && self.kind.is_none_or(|kind| kind == contact.kind)
    }

    /// True if the state holds the pair.
    pub fn holds(&self, state: &ContactState) -> bool {
        state.iter().any(|contact| self.matches(&contact))
    }
}

/// The symbolic goal; without pairs it is empty and every state satisfies it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Goal {
    /// Pairs that must all hold in the last state.
    pub pairs: Vec<GoalPair>,
}

impl Goal {
    /// The goal of holding all these pairs with any type.
    pub fn of_pairs(pairs: impl IntoIterator<Item = (InterfaceId, InterfaceId)>) -> Self {
        Self {
            pairs: pairs
                .into_iter()
                .map(|(a, b)| GoalPair::new(a, b))
                .collect(),
        }
    }

    /// The goal test s_g ⊆ s.
    pub fn holds(&self, state: &ContactState) -> bool {
        self.pairs.iter().all(|pair| pair.holds(state))
    }

    /// Refuses pairs that no state can hold.
    ///
    /// # Errors
    /// [`SymbolicError::UnknownInterface`], or [`SymbolicError::ImpossibleGoal`] with the rule that forbids the pair.
    pub fn check(&self, domain: &Domain) -> Result<(), SymbolicError> {
        let count = domain.interfaces().len();
        for pair in &self.pairs {
            if let Some(id) = [pair.a, pair.b].into_iter().find(|id| id.0 >= count) {
                return Err(SymbolicError::UnknownInterface { index: id.0, count });
            }
            if !domain
                .contacts()
                .iter()
                .any(|contact| pair.matches(contact))
            {
                let name = |id| domain.interface(id).name.clone();
                let reason = why_impossible(domain, pair).to_owned();
                return Err(SymbolicError::ImpossibleGoal {
                    a: name(pair.a),
                    b: name(pair.b),
                    reason,
                });
            }
        }
        Ok(())
    }
}

/// The name of the last rule that excludes a triple of the pair: the one that is closest to being met.
fn why_impossible(domain: &Domain, pair: &GoalPair) -> &'static str {
    let triples =
        crate::contact_rules::all_triples(domain.interfaces().len()).filter(|c| pair.matches(c));
    let broken = |c: Contact| {
        RULES
            .iter()
            .position(|(_, rule)| rule(domain.interfaces(), &c))
    };
    triples
        .filter_map(broken)
        .max()
        .map_or("no such pair", |n| RULES[n].0)
}
