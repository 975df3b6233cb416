//! The result of a search: a contact sequence.

use crate::action::Action;
use crate::contact::{Contact, ContactState};
use crate::domain::Domain;
use crate::graph::{SkeletonGraph, StateId, Successor};

/// A contact sequence s_1 … s_K.
#[derive(Debug, Clone, PartialEq)]
pub struct Sequence {
    /// The state of every phase, the start first.
    pub states: Vec<ContactState>,
    /// Per phase what changed on entering it: `start`, `grasp red_box with left_hand`, `left_foot off ground_top`.
    pub labels: Vec<String>,
    /// The skeleton: labels of the manipulation actions, in order.
    pub skeleton: Vec<String>,
    /// Cost by which sequences are ordered.
    pub cost: f64,
}

impl Sequence {
    /// Puts the edges of a path from the root into words.
    pub(crate) fn along(graph: &SkeletonGraph, edges: &[Successor], cost: f64) -> Self {
        let mut node = graph.root();
        let mut sequence = Self {
            states: vec![graph.state(node.state).clone()],
            labels: vec!["start".to_owned()],
            skeleton: Vec::new(),
            cost,
        };
        for edge in edges {
            sequence.states.push(graph.state(edge.node.state).clone());
            sequence.labels.push(graph.label(node, edge));
            let operator = edge
                .operator
                .map(|n| graph.manipulation().task.operators()[n].label.clone());
            sequence.skeleton.extend(operator);
            node = edge.node;
        }
        sequence
    }
}

impl Sequence {
    /// The sequence with swings in phase `at`, one after the other: each foot leaves what it stands on, and is set down on it anew. Feet
    /// that are in the air in that phase are set down first, and leave again in the end: then the others swing.
    /// Legal where another foot stands. The cost stays that of the sequence without them.
    #[must_use]
    pub fn with_swings(&self, domain: &Domain, at: usize, feet: &[Contact]) -> Self {
        let here = &self.states[at];
        let stance: ContactState = here.iter().chain(feet.iter().copied()).collect();
        let mut more = vec![];
        if stance != *here {
            more.push(stance.clone());
        }
        for foot in feet.iter().filter(|foot| here.contains(foot)) {
            let lifted = stance.iter().filter(|c| c != foot).collect();
            more.extend([lifted, stance.clone()]);
        }
        if stance != *here {
            more.push(here.clone());
        }
        let before = std::iter::once(here).chain(&more);
        let labels: Vec<String> = before
            .zip(&more)
            .map(|(before, after)| Action::between(before, after).describe(domain))
            .collect();
        let mut longer = self.clone();
        let next = at + 1;
        longer.states.splice(next..next, more);
        longer.labels.splice(next..next, labels);
        longer
    }
}

/// The states of a path.
pub(crate) fn states_along(edges: &[Successor]) -> Vec<StateId> {
    std::iter::once(StateId(0))
        .chain(edges.iter().map(|edge| edge.node.state))
        .collect()
}
