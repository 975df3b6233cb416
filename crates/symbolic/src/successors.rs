//! The graph without skeletons: every legal action from a state, as the paper defines actions.

use crate::action::Action;
use crate::contact::{Contact, ContactState, InterfaceId};
use crate::domain::Domain;
use crate::state_rules::state_fault;
use crate::transition_rules::transition_fault;

/// Every legal successor of a state in which at most `max_changes` landing sides make or break contact.
///
/// Objects' surfaces change like the robot's. Ordered by the number of changes, then by what changes; no action or
/// state twice. The number grows like (number of contacts)^`max_changes`.
pub fn successors(
    domain: &Domain,
    state: &ContactState,
    max_changes: usize,
) -> Vec<(Action, ContactState)> {
    let sides: Vec<Vec<Change>> = landing_sides(domain)
        .map(|a| changes_of(state, a, domain.landings(a)))
        .collect();
    let mut result = Vec::new();
    for count in 1..=max_changes.min(sides.len()) {
        combine(state, &sides, count, &mut |to| {
            if state_fault(domain, &to).is_none() && transition_fault(state, &to).is_none() {
                result.push((Action::between(state, &to), to));
            }
        });
    }
    result
}

/// One landing side makes or breaks one contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Change {
    Break(Contact),
    Make(Contact),
}

impl Change {
    pub(crate) fn apply(self, state: &mut ContactState) {
        match self {
            Self::Break(contact) => state.contacts.remove(&contact),
            Self::Make(contact) => state.contacts.insert(contact),
        };
    }
}

/// What one landing side can do: leave its partner if it has one, otherwise land on any.
pub(crate) fn changes_of(
    state: &ContactState,
    side: InterfaceId,
    landings: &[Contact],
) -> Vec<Change> {
    match state.landing(side) {
        Some(contact) => vec![Change::Break(contact)],
        None => landings
            .iter()
            .map(|&contact| Change::Make(contact))
            .collect(),
    }
}

/// Calls `found` with the state after every choice of `count` sides and one change of each.
pub(crate) fn combine(
    state: &ContactState,
    sides: &[Vec<Change>],
    count: usize,
    found: &mut dyn FnMut(ContactState),
) {
    if count == 0 {
        found(state.clone());
        return;
    }
    for (n, changes) in sides.iter().enumerate() {
        if sides.len() - n < count {
            break;
        }
        for change in changes {
            let mut next = state.clone();
            change.apply(&mut next);
            combine(&next, &sides[n + 1..], count - 1, found);
        }
    }
}

fn landing_sides(domain: &Domain) -> impl Iterator<Item = InterfaceId> + '_ {
    domain.ids().filter(|&a| !domain.landings(a).is_empty())
}
