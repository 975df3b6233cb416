//! A beginning of a sequence in which nobody takes a step, for one with steps.
//!
//! Whoever may lift a foot and set it down again may as well leave it where it is. So configurations that satisfy the sequence
//! without such steps satisfy the one with them, one in the middle of a state standing for all boundaries that steps add to it;
//! and beginnings that are the same without steps are those that steps make of one another.

use crate::contact::{Contact, ContactState};

/// A sequence of states without the steps of another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InPlace {
    /// Different from one to the next.
    pub states: Vec<ContactState>,
    /// Of each state of the other sequence, which of these it has become.
    of_state: Vec<usize>,
}

/// The sequence in which contacts that `may_stay` says so of last until they are made again, where nothing else is touched in
/// between, and if `to_the_end` those that are not made again too; `None` if that is the same sequence.
pub fn in_place(
    states: &[ContactState],
    to_the_end: bool,
    may_stay: impl Fn(&Contact) -> bool,
) -> Option<InPlace> {
    let mut still = states.to_vec();
    for (k, state) in states.iter().enumerate() {
        for contact in state.iter().filter(&may_stay) {
            let touches = |s: &ContactState| s.iter().any(|c| c.a == contact.a);
            let away = states[k + 1..].iter().take_while(|s| !touches(s)).count();
            let next = states.get(k + 1 + away);
            if next.map_or(to_the_end, |s| s.contains(&contact)) {
                for state in &mut still[k + 1..k + 1 + away] {
                    state.contacts.insert(contact);
                }
            }
        }
    }
    if still == states {
        return None;
    }
    let mut merged: Vec<ContactState> = vec![];
    let mut of_state = vec![];
    for state in still {
        if merged.last() != Some(&state) {
            merged.push(state);
        }
        of_state.push(merged.len() - 1);
    }
    Some(InPlace {
        states: merged,
        of_state,
    })
}

impl InPlace {
    /// How often each state is there with its middle: twice if it stands for several, else once.
    fn times(&self) -> Vec<usize> {
        let of = |n: usize| self.of_state.iter().filter(|&&state| state == n).count();
        (0..self.states.len()).map(|n| of(n).min(2)).collect()
    }

    /// The states, with those twice that stand for several: between the two nothing is made or broken, as at a boundary that
    /// steps add.
    pub fn with_middles(&self) -> Vec<ContactState> {
        let states = self.states.iter().zip(self.times());
        states
            .flat_map(|(state, times)| vec![state.clone(); times])
            .collect()
    }

    /// What the boundaries of [`InPlace::with_middles`] may have, from what those of [`InPlace::states`] have: `between` makes a
    /// middle of what a state begins and ends with.
    pub fn middles_between<T: Clone>(&self, nodes: &[T], between: impl Fn(&T, &T) -> T) -> Vec<T> {
        let mut out = vec![];
        for (ends, times) in nodes.windows(2).zip(self.times()) {
            out.push(ends[0].clone());
            if times > 1 {
                out.push(between(&ends[0], &ends[1]));
            }
        }
        out.extend(nodes.last().cloned());
        out
    }

    /// What the boundaries of the sequence with steps have, from what those of [`InPlace::with_middles`] have: `nodes`, one more
    /// than there are states.
    pub fn with_steps<T: Clone>(&self, nodes: &[T]) -> Vec<T> {
        let times = self.times();
        let first = |state: usize| times[..state].iter().sum::<usize>();
        let before = (0..self.of_state.len()).map(|k| {
            let state = self.of_state[k];
            let is_first = k == 0 || self.of_state[k - 1] != state;
            nodes[first(state) + usize::from(!is_first)].clone()
        });
        before.chain(nodes.last().cloned()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{ContactType, InterfaceId};

    const LEFT: usize = 0;
    const RIGHT: usize = 1;
    const HAND: usize = 2;
    const GROUND: usize = 3;
    const BOX: usize = 4;

    fn state(pairs: &[(usize, usize)]) -> ContactState {
        let contact = |&(a, b): &(usize, usize)| Contact {
            a: InterfaceId(a),
            b: InterfaceId(b),
            kind: ContactType::UnilateralPatch,
        };
        pairs.iter().map(contact).collect()
    }

    fn of_foot(contact: &Contact) -> bool {
        contact.a.0 < HAND
    }

    #[test]
    fn steps_in_place_are_left_out_and_their_boundaries_keep_the_configuration() {
        let (left, right, held) = ((LEFT, GROUND), (RIGHT, GROUND), (HAND, BOX));
        let states = [
            state(&[left, right]),
            state(&[right]),
            state(&[left, right]),
            state(&[left, right, held]),
            state(&[left, held]),
        ];
        let all = in_place(&states, true, of_foot).expect("there are steps");
        assert_eq!(all.states, [states[0].clone(), states[3].clone()]);
        // What is in the air at the end is not where it was.
        let still = in_place(&states, false, of_foot).expect("there are steps");
        let [stands, _, _, holds, lifts] = states;
        assert_eq!(still.states, [stands.clone(), holds.clone(), lifts.clone()]);
        assert_eq!(still.with_middles(), [stands.clone(), stands, holds, lifts]);
        let between = still.middles_between(&[0, 10, 20, 30], |a, b| (a + b) / 2);
        assert_eq!(between, [0, 5, 10, 20, 30]);
        let expected = [0, 1, 1, 2, 3, 4];
        assert_eq!(still.with_steps(&[0, 1, 2, 3, 4]), expected);
    }

    #[test]
    fn a_step_to_something_else_stays() {
        let states = [
            state(&[(LEFT, GROUND), (RIGHT, GROUND)]),
            state(&[(RIGHT, GROUND)]),
            state(&[(LEFT, BOX), (RIGHT, GROUND)]),
        ];
        assert!(in_place(&states, true, of_foot).is_none());
    }
}
