//! Symbolic layer: interfaces, contact types, contact states, actions and the pruned graph of their transitions.
//!
//! Source: paper, sections "Symbolic state and actions" and "Symbolic search pruning". No pose and no number of
//! the scene's geometry appears here.
//!
//! A [`Domain`] says which interfaces there are and what can touch what. A [`SkeletonGraph`] adds start, goal and the
//! manipulation skeletons; its paths are contact sequences. [`search`] lists them, best first or at random, and lets
//! an [`Oracle`] that knows the geometry reject states, transitions and beginnings.

#[cfg(test)]
extern crate self as symbolic;

mod action;
mod contact;
pub mod contact_rules;
mod domain;
mod error;
mod goal;
mod graph;
pub mod manipulation;
pub mod search;
pub mod state_rules;
pub mod statistics;
mod successors;
mod task;
mod task_graph;
pub mod transition_rules;

pub use action::Action;
pub use contact::{Contact, ContactState, ContactType, InterfaceId};
pub use domain::{Domain, Interface, Owner, Role};
pub use error::SymbolicError;
pub use goal::{Goal, GoalPair};
pub use graph::{GraphOptions, Node, SkeletonGraph, StateId, Successor};
pub use manipulation::Manipulation;
pub use search::{
    BestFirst, Costs, Ending, Oracle, Rollouts, SearchLimits, Sequence, Status, Verdict,
};
pub use successors::successors;
pub use task::{Condition, Fact, FactSet, Operator, Task};
pub use task_graph::{TaskEdge, TaskGraph, TaskState};
