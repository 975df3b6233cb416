//! Where motions fail: three contact states in a row at which the optimiser failed again and again, and never succeeded.
//!
//! Keyframes know no statics and no torques, so sequences that differ only before or after the step that the robot cannot do
//! all pass them. The place of a failure ([`super::places`]) is the phase of the most violated row with its two neighbours. This is
//! evidence and no proof: a sequence is left out only after [`MOST`] failures at the same place and without any motion through it.

use super::places::{Place, Places};
use std::collections::{BTreeMap, BTreeSet};
use symbolic::ContactState;

/// Failures at one place after which it is not tried again.
const MOST: usize = 3;

/// What is known of places.
#[derive(Debug, Default)]
pub(super) struct Failures {
    places: Places,
    numbers: BTreeMap<Place, Vec<usize>>,
    passed: BTreeSet<Place>,
}

impl Failures {
    /// Nothing is known.
    pub fn new(places: Places) -> Self {
        Self {
            places,
            ..Self::default()
        }
    }

    /// Takes note of sequence `number`, which failed in phase `phase` (from 0).
    pub fn failed(&mut self, number: usize, states: &[ContactState], phase: usize) {
        let place = self.places.at(states, phase);
        self.numbers.entry(place).or_default().push(number);
    }

    /// Takes note of a sequence that has a motion.
    pub fn succeeded(&mut self, states: &[ContactState]) {
        self.passed.extend(self.places.of(states));
    }

    /// The first phase (from 0) of a sequence that is known to fail, and the sequences that failed there.
    pub fn known(&self, states: &[ContactState]) -> Option<(usize, &[usize])> {
        (0..states.len()).find_map(|phase| {
            let place = self.places.at(states, phase);
            let numbers = self.numbers.get(&place)?;
            let hopeless = numbers.len() >= MOST && !self.passed.contains(&place);
            hopeless.then_some((phase, numbers.as_slice()))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::places::tests::sequence;
    use super::*;

    #[test]
    fn a_place_is_left_out_after_three_failures_unless_a_motion_passed_it() {
        let mut failures = Failures::default();
        for number in 1..=3 {
            assert_eq!(failures.known(&sequence(&[5, 1, 2, 3])), None);
            failures.failed(number, &sequence(&[number + 3, 1, 2, 3]), 2);
        }
        let expected = [1, 2, 3];
        let known = failures.known(&sequence(&[9, 9, 1, 2, 3]));
        assert_eq!(known, Some((3, expected.as_slice())));
        assert_eq!(failures.known(&sequence(&[1, 2, 4])), None);
        failures.succeeded(&sequence(&[1, 2, 3, 3]));
        assert_eq!(failures.known(&sequence(&[9, 9, 1, 2, 3])), None);
    }
}
