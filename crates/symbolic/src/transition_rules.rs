//! Which pairs of states no action connects: the paper's "Infeasible transitions".

use crate::contact::{Contact, ContactState, InterfaceId};
use crate::domain::Domain;

/// Why two states do not follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TransitionFault {
    /// Nothing changes.
    Repetition,
    /// The landing side goes from one partner, or type, to another without a state in which it is free.
    PartnerChange(InterfaceId),
    /// (i, j) becomes (j, i) at once; the contact is the new one.
    SideSwap(Contact),
}

impl TransitionFault {
    /// The fault in words.
    pub fn describe(&self, domain: &Domain) -> String {
        match self {
            Self::Repetition => "nothing changes".to_owned(),
            Self::PartnerChange(i) => {
                format!(
                    "{:?} changes its partner or contact type without being free",
                    domain.interface(*i).name
                )
            }
            Self::SideSwap(c) => format!(
                "{:?} and {:?} exchange sides without coming apart",
                domain.interface(c.a).name,
                domain.interface(c.b).name
            ),
        }
    }
}

/// s′ = s: "we also exclude action repetition that would result in the same contact state".
pub fn repetition(from: &ContactState, to: &ContactState) -> Option<TransitionFault> {
    (from == to).then_some(TransitionFault::Repetition)
}

/// A landing side in contact before and after keeps its contact: partner and type.
pub fn partner_change(from: &ContactState, to: &ContactState) -> Option<TransitionFault> {
    from.iter()
        .find(|before| to.iter().any(|after| after.a == before.a) && !to.contains(before))
        .map(|before| TransitionFault::PartnerChange(before.a))
}

/// A pair exchanges landing side and landed-on side only through a state without it.
pub fn side_swap(from: &ContactState, to: &ContactState) -> Option<TransitionFault> {
    to.iter()
        .find(|after| {
            from.iter()
                .any(|before| before.a == after.b && before.b == after.a)
        })
        .map(TransitionFault::SideSwap)
}

/// The first rule that the transition breaks; both states are legal by themselves.
pub fn transition_fault(from: &ContactState, to: &ContactState) -> Option<TransitionFault> {
    repetition(from, to)
        .or_else(|| partner_change(from, to))
        .or_else(|| side_swap(from, to))
}
