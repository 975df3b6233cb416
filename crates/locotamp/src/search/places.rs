//! Places in sequences: three contact states in a row, and what has been moved before. A step from a box is another one once the box
//! stands elsewhere.

use symbolic::{Contact, ContactState};

/// Three states, and the resting contacts of the start that have been broken by then.
pub(super) type Place = ([ContactState; 3], Vec<Contact>);

/// Where sequences are alike.
#[derive(Debug, Clone, Default)]
pub(super) struct Places {
    /// Contacts of the start by which objects rest.
    resting: Vec<Contact>,
}

impl Places {
    /// With the contacts of the start by which objects rest.
    pub fn new(resting: Vec<Contact>) -> Self {
        Self { resting }
    }

    /// A phase (from 0) with its two neighbours.
    pub fn at(&self, states: &[ContactState], phase: usize) -> Place {
        let last = states.len() - 1;
        let after = (phase + 1).min(last);
        let here = [phase.saturating_sub(1), phase, after].map(|k| states[k.min(last)].clone());
        let broken = |c: &&Contact| states[..=after].iter().any(|s| !s.contains(c));
        (here, self.resting.iter().filter(broken).copied().collect())
    }

    /// All of a sequence.
    pub fn of(&self, states: &[ContactState]) -> Vec<Place> {
        (0..states.len())
            .map(|phase| self.at(states, phase))
            .collect()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use symbolic::{Contact, ContactState, ContactType, InterfaceId};

    /// A sequence in which each state is one contact with the surface of that number.
    pub fn sequence(surfaces: &[usize]) -> Vec<ContactState> {
        let state = |&surface: &usize| {
            let contact = Contact {
                a: InterfaceId(0),
                b: InterfaceId(surface),
                kind: ContactType::UnilateralPatch,
            };
            std::iter::once(contact).collect()
        };
        surfaces.iter().map(state).collect()
    }
}
