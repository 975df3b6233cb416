//! What was refused: contacts that exclude one another, and beside them, counted by reason, lifts and beginnings.

use super::{Checks, Core};
use crate::api::{Impossible, Refusal};
use std::collections::BTreeMap;
use symbolic::ContactState;

/// Refusals by what was refused.
#[derive(Debug, Default)]
pub(super) struct Refusals {
    /// Contacts that are impossible before an object is moved.
    pub before_moved: Vec<Impossible>,
    /// Lifts of what is too heavy.
    pub too_heavy: Vec<Impossible>,
    /// Beginnings by what resists, without the amount.
    pub beginnings: BTreeMap<String, Impossible>,
}

impl Refusals {
    /// Takes note of a lift of what is too heavy.
    pub fn note_lift(&mut self, found: Impossible) {
        let same = |known: &&mut Impossible| known.reason == found.reason;
        match self.too_heavy.iter_mut().find(same) {
            Some(known) => known.refused += 1,
            None => self.too_heavy.push(Impossible {
                refused: 1,
                ..found
            }),
        }
    }

    /// Takes note of a beginning without keyframes; `reason` is what resists, a colon, and by how much.
    pub fn note_beginning(&mut self, reason: &str) {
        let what = reason.split(':').next().unwrap_or(reason);
        let known = self.beginnings.entry(what.into());
        let known = known.or_insert_with(|| Impossible {
            what: Refusal::Beginning,
            contacts: vec![what.into()],
            reason: reason.into(),
            refused: 0,
        });
        known.refused += 1;
    }

    /// All of them, in the order of the fields.
    pub fn all(&self) -> impl Iterator<Item = &Impossible> {
        let contacts = self.before_moved.iter().chain(&self.too_heavy);
        contacts.chain(self.beginnings.values())
    }
}

impl Checks<'_> {
    /// Sets of contacts that exclude one another, none of which can be left out, in the order in which they were found.
    pub fn cores(&self) -> impl Iterator<Item = &ContactState> {
        self.impossible.iter().map(|core| &core.contacts)
    }

    /// Contacts that were found to exclude one another, in the order in which they were found; those that do so before an
    /// object is moved; lifts of what is too heavy; beginnings.
    pub fn impossible(&self) -> Vec<Impossible> {
        let one = |core: &Core| Impossible {
            what: Refusal::Contacts,
            contacts: self.names(&core.contacts),
            reason: core.reason.clone(),
            refused: core.refused,
        };
        let cores = self.impossible.iter().map(one);
        cores.chain(self.refusals.all().cloned()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beginnings_that_fail_at_the_same_by_different_amounts_are_counted_together() {
        let mut refusals = Refusals::default();
        for reason in [
            "reach of hand: 0.2 m off",
            "tilt of cup: 1 rad off",
            "reach of hand: 0.3 m off",
        ] {
            refusals.note_beginning(reason);
        }
        let found: Vec<_> = refusals
            .all()
            .map(|x| (x.refused, x.reason.as_str()))
            .collect();
        assert_eq!(
            found,
            [
                (2, "reach of hand: 0.2 m off"),
                (1, "tilt of cup: 1 rad off")
            ]
        );
    }
}
