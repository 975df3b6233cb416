//! Beginnings that steps do not help: what is out of reach wherever the feet stand is so after any number of steps.

use std::collections::BTreeMap;

use crate::contact::{Contact, ContactState};
use crate::domain::Role;
use crate::graph::{SkeletonGraph, StateId};
use crate::in_place::in_place;

/// Misses by far after which steps are no longer expected to help: one may be a local minimum. Near misses say nothing: on
/// `from-floor` a step helped after many.
const MISSES: usize = 2;

/// Beginnings with their misses, those of the same contacts but for steps counted together.
#[derive(Debug, Clone, Default)]
pub(crate) struct Beyond {
    misses: BTreeMap<Vec<ContactState>, usize>,
}

impl Beyond {
    /// Takes note of a beginning that is far from possible even with all feet set anew.
    pub(crate) fn note(&mut self, graph: &SkeletonGraph, path: &[StateId]) {
        let misses = self.misses.entry(without_steps(graph, path)).or_default();
        *misses += 1;
    }

    /// True if a beginning differs by steps only from one that they do not help.
    pub(crate) fn contains(&self, graph: &SkeletonGraph, path: &[StateId]) -> bool {
        let misses = self.misses.get(&without_steps(graph, path));
        misses.is_some_and(|&n| n >= MISSES)
    }
}

/// The states without those steps before the last that end where they began.
fn without_steps(graph: &SkeletonGraph, path: &[StateId]) -> Vec<ContactState> {
    let mut states: Vec<ContactState> = path.iter().map(|&id| graph.state(id).clone()).collect();
    let last = states.pop();
    let of_foot = |c: &Contact| graph.domain().is_effector(c.a, Role::Foot);
    let mut still = in_place(&states, true, of_foot).map_or(states, |still| still.states);
    still.extend(last);
    still
}
