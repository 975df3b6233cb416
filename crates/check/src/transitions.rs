//! Legal contact sequences: an interface that lands has one partner at a time, and changes partner, a pair its type or
//! its direction, only through a phase in which it is free.
//!
//! A ground, table or box top (the `b` of its contacts) holds any number of partners.
//! Source: paper, symbolic state and actions.

use crate::categories::Category;
use crate::measure::Measurements;
use crate::motion::{Contact, Motion, Phase};

/// Judges every phase and every change of phase.
pub(crate) fn judge(motion: &Motion, found: &mut Measurements) {
    found.looked_at(Category::Transitions);
    let name = |i: usize| motion.interfaces[i].name;
    for (k, phase) in motion.phases.iter().enumerate() {
        for (i, contact) in phase.contacts.iter().enumerate() {
            let (a, b) = (name(contact.a), name(contact.b));
            for other in &phase.contacts[..i] {
                if other.a == contact.a {
                    found.count(
                        Category::Transitions,
                        &format!("phase {k}: {a} touches {} and {b}", name(other.b)),
                    );
                } else if (other.a, other.b) == (contact.b, contact.a) {
                    found.count(
                        Category::Transitions,
                        &format!("phase {k}: {a}/{b} listed both ways"),
                    );
                }
            }
            let Some(before) = k.checked_sub(1).map(|k| &motion.phases[k]) else {
                continue;
            };
            if let Some(fault) = change(before, contact) {
                found.count(
                    Category::Transitions,
                    &format!("phase {k}: {a}/{b} {fault}"),
                );
            }
        }
    }
}

/// What is wrong with entering `contact` from the phase `before`.
fn change(before: &Phase, contact: &Contact) -> Option<&'static str> {
    let mut earlier = before.contacts.iter();
    earlier.find_map(|old| match ((old.a, old.b), old.kind) {
        (pair, kind) if pair == (contact.a, contact.b) => {
            (kind != contact.kind).then_some("changes its type")
        }
        ((a, _), _) if a == contact.a => Some("changes its partner"),
        (pair, _) if pair == (contact.b, contact.a) => Some("changes its direction"),
        _ => None,
    })
}
