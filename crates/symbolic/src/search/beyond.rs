//! Beginnings that steps do not help: what is out of reach wherever the feet stand is so after any number of steps.

use std::collections::BTreeMap;

use crate::contact::{Contact, ContactState};
use crate::domain::Role;
use crate::graph::{SkeletonGraph, StateId};
use crate::in_place::in_place;

/// Near misses after which steps are no longer expected to help: after two of them they did on `two-box`.
const MISSES: usize = 3;

/// Beginnings with their near misses, those of the same contacts but for steps counted together.
#[derive(Debug, Clone, Default)]
pub(crate) struct Beyond {
    misses: BTreeMap<Vec<ContactState>, usize>,
}

impl Beyond {
    /// Takes note of a beginning that is impossible even with all feet set anew, `far` or by little.
    pub(crate) fn note(&mut self, graph: &SkeletonGraph, path: &[StateId], far: bool) {
        let misses = self.misses.entry(without_steps(graph, path)).or_default();
        *misses += if far { MISSES } else { 1 };
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
    let mut still = in_place(&states, of_foot).map_or(states, |still| still.states);
    still.extend(last);
    still
}
