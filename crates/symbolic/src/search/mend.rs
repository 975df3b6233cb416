//! Steps where a sequence lacks them: a beginning that is impossible because the feet stand at the wrong place is tried again
//! with some swings before.
//!
//! Where the swings belong is asked of the oracle: in which state, if the feet were set anew there, would the beginning be
//! possible? If in none, no number of steps helps, and none is tried. The swings are contact changes like any others.

use crate::contact::Contact;
use crate::domain::Role;
use crate::graph::{StateId, Successor};
use crate::search::expansion::Ranked;
use crate::search::oracle::{Anew, Oracle};
use crate::search::sequence::states_along;
use crate::search::walk::{Walk, Walker};

/// Swings beyond the fewest possible that are tried.
const MORE_SWINGS: usize = 3;

impl Walker {
    /// A walk that takes the same steps with some swings before, if it is only the place of the feet that makes the last step
    /// impossible.
    pub(crate) fn mend(
        &mut self,
        walk: &Walk,
        next: &Ranked,
        oracle: &mut dyn Oracle,
    ) -> Option<Walk> {
        let mut path = states_along(&walk.edges);
        path.push(next.edge.node.state);
        if !self.verdicts.is_rejected_as_beginning(&path)
            || !self.tried_to_mend.insert(path.clone())
        {
            return None;
        }
        let stances = self.stances(walk);
        let graph = &self.expansion.graph;
        let states: Vec<_> = path.iter().map(|&id| graph.state(id)).collect();
        if stances.is_empty() {
            return None;
        }
        let (at, least) = match oracle.set_anew(&states, &stances)? {
            Anew::Possible { at, swings } => (at, swings),
            Anew::Near => {
                self.beyond.note_near(graph, &path);
                return None;
            }
            Anew::Far => {
                self.beyond.note_far(graph, &path);
                return None;
            }
        };
        let feet = self.feet(path[at]);
        for swings in least..=least + MORE_SWINGS {
            for first in 0..feet.len() {
                if oracle.stop() {
                    return None;
                }
                let order = (0..swings).map(|n| feet[(first + n) % feet.len()]);
                let mended = self.with_swings(walk, next, at, order);
                if let Some(mended) = mended.filter(|w| self.is_possible(w, oracle)) {
                    self.beyond.note_possible(&self.expansion.graph, &path);
                    return Some(mended);
                }
            }
        }
        self.beyond.note_near(&self.expansion.graph, &path);
        None
    }

    /// Positions of the states in which all feet stand that stand at the start: of several in a row at the same skeleton
    /// position and place the last.
    fn stances(&self, walk: &Walk) -> Vec<usize> {
        let path = states_along(&walk.edges);
        let all = self.feet(path[0]).len();
        if all == 0 {
            return vec![];
        }
        let key = |n: usize| {
            let position = if n == 0 {
                self.expansion.graph.root().position
            } else {
                walk.edges[n - 1].node.position
            };
            (position, self.feet(path[n]))
        };
        let stands = |&n: &usize| self.feet(path[n]).len() == all;
        let standing: Vec<usize> = (0..path.len()).filter(stands).collect();
        let last = |&n: &usize| {
            let next = standing.iter().find(|&&other| other > n);
            next.is_none_or(|&other| key(other) != key(n))
        };
        standing.iter().copied().filter(last).collect()
    }

    /// Contacts of feet in a state.
    fn feet(&self, state: StateId) -> Vec<Contact> {
        let graph = &self.expansion.graph;
        let of_foot = |c: &Contact| graph.domain().is_effector(c.a, Role::Foot);
        graph.state(state).iter().filter(of_foot).collect()
    }

    /// The walk with swings in state `at`, and the next step; `None` if that is too long or not in the graph.
    fn with_swings(
        &mut self,
        walk: &Walk,
        next: &Ranked,
        at: usize,
        order: impl Iterator<Item = Contact>,
    ) -> Option<Walk> {
        let mut longer = Walk::new(&self.expansion.graph);
        for edge in &walk.edges[..at] {
            self.follow(&mut longer, *edge)?;
        }
        let stance = longer.node;
        for foot in order {
            let mut lifted = self.expansion.graph.state(stance.state).clone();
            lifted.contacts.remove(&foot);
            let mut node = stance;
            node.state = self.expansion.graph.intern(&lifted);
            for node in [node, stance] {
                let operator = None;
                self.follow(&mut longer, Successor { node, operator })?;
            }
        }
        for edge in walk.edges[at..].iter().chain([&next.edge]) {
            self.follow(&mut longer, *edge)?;
        }
        longer.mended = longer.edges.len();
        Some(longer)
    }

    fn follow(&mut self, walk: &mut Walk, edge: Successor) -> Option<()> {
        let list = self.expansion.list(walk.node, walk.last_foot);
        let ranked = self.expansion.ranked(list).iter();
        let next = *ranked.into_iter().find(|next| next.edge == edge)?;
        let fits = self
            .expansion
            .may_follow(&edge, walk.n_phases(), &walk.visited);
        fits.then(|| walk.take(&next))
    }

    /// True if the oracle accepts the last state, the last transition and the whole. What is before was accepted without
    /// the swings; they only make more possible.
    fn is_possible(&mut self, walk: &Walk, oracle: &mut dyn Oracle) -> bool {
        let path = states_along(&walk.edges);
        self.created += 1;
        let graph = &self.expansion.graph;
        let steps = path.windows(2).all(|pair| {
            self.verdicts.accepts_state(graph, pair[1], oracle)
                && self
                    .verdicts
                    .accepts_transition(graph, pair[0], pair[1], oracle)
        });
        steps && self.verdicts.accepts_prefix(graph, &path, oracle)
    }
}
