//! Beginnings that steps do not help: what is out of reach wherever the feet stand is so after any number of steps. What is missed by
//! little says less, and is tried again, but ever more seldom.

use std::collections::BTreeMap;

use crate::contact::{Contact, ContactState};
use crate::domain::Role;
use crate::graph::{SkeletonGraph, StateId};
use crate::in_place::in_place;

/// Misses by far after which steps are no longer expected to help: one may be a local minimum.
const MISSES: usize = 2;
/// Misses by little after which half as many beginnings as were missed are passed over before the next one is tried: on `from-floor` a
/// step helped after many.
const NEAR_MISSES: usize = 8;

/// Misses by little.
#[derive(Debug, Clone, Copy, Default)]
struct Near {
    misses: usize,
    /// How many beginnings were passed over since the last one that was tried.
    passed_over: usize,
}

/// Beginnings with their misses.
#[derive(Debug, Clone, Default)]
pub(crate) struct Beyond {
    /// Of those of the same contacts but for steps that end where they began.
    far: BTreeMap<Vec<ContactState>, usize>,
    /// Of those that do the same but for the feet, and end in the same state.
    near: BTreeMap<Vec<ContactState>, Near>,
}

impl Beyond {
    /// Takes note of a beginning that is far from possible even with all feet set anew.
    pub(crate) fn note_far(&mut self, graph: &SkeletonGraph, path: &[StateId]) {
        *self.far.entry(without_steps(graph, path)).or_default() += 1;
    }

    /// Takes note of a beginning that is not possible with feet set anew as far as is known, but by little.
    pub(crate) fn note_near(&mut self, graph: &SkeletonGraph, path: &[StateId]) {
        let near = self.near.entry(without_feet(graph, path)).or_default();
        near.misses += 1;
    }

    /// Takes note of a beginning that is possible.
    pub(crate) fn note_possible(&mut self, graph: &SkeletonGraph, path: &[StateId]) {
        self.near.remove(&without_feet(graph, path));
    }

    /// True if a beginning differs by steps only from some that they do not help, and is to be passed over.
    pub(crate) fn passes_over(&mut self, graph: &SkeletonGraph, path: &[StateId]) -> bool {
        let far = self.far.get(&without_steps(graph, path));
        if far.is_some_and(|&misses| misses >= MISSES) {
            return true;
        }
        let near = self.near.get_mut(&without_feet(graph, path));
        let Some(near) = near.filter(|near| near.misses >= NEAR_MISSES) else {
            return false;
        };
        let passes = near.passed_over < near.misses / 2;
        near.passed_over = if passes { near.passed_over + 1 } else { 0 };
        passes
    }
}

/// The states without those steps before the last that end where they began.
fn without_steps(graph: &SkeletonGraph, path: &[StateId]) -> Vec<ContactState> {
    let mut states: Vec<ContactState> = path.iter().map(|&id| graph.state(id).clone()).collect();
    let last = states.pop();
    let mut still =
        in_place(&states, true, |c| is_of_foot(graph, c)).map_or(states, |still| still.states);
    still.extend(last);
    still
}

/// The states without contacts of feet, of several that are alike in a row one; and the last one with them.
fn without_feet(graph: &SkeletonGraph, path: &[StateId]) -> Vec<ContactState> {
    let hands = |id: &StateId| -> ContactState {
        let contacts = graph.state(*id).iter();
        contacts.filter(|c| !is_of_foot(graph, c)).collect()
    };
    let mut states: Vec<ContactState> = path.iter().map(hands).collect();
    states.dedup();
    states.extend(path.last().map(|&last| graph.state(last).clone()));
    states
}

fn is_of_foot(graph: &SkeletonGraph, contact: &Contact) -> bool {
    graph.domain().is_effector(contact.a, Role::Foot)
}
