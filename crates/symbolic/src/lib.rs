//! Symbolic layer: interfaces, contact types, contact states, actions and the pruned graph of their transitions.
//!
//! Source: paper, sections "Symbolic state and actions" and "Symbolic search pruning". No pose and no number of
//! the scene's geometry appears here.
//!
//! A [`Domain`] says which interfaces there are and what can touch what. A [`SkeletonGraph`] adds start, goal and the
//! manipulation skeletons; its paths are contact sequences. [`search`] lists them, best first or at random, and lets
//! an [`Oracle`] that knows the geometry reject states, transitions and beginnings. `docs/symbolic.md` has the rules,
//! the operators and the derived limits in one place.
//!
//! ```
//! use symbolic::search::AcceptAll;
//! use symbolic::{BestFirst, Contact, ContactState, ContactType, Costs, Domain, Goal, GraphOptions, Interface};
//! use symbolic::{InterfaceId, Owner, Policy, Role, SearchLimits, SkeletonGraph};
//!
//! let interface = |name: &str, owner, role, lands, kind| Interface {
//!     name: name.to_owned(), owner, role, patch: true, lands, bears_feet: true, contact_types: vec![kind],
//! };
//! let (push, hold) = (ContactType::UnilateralPatch, ContactType::BilateralPatch);
//! let interfaces = vec![
//!     interface("hand", Owner::Robot, Role::Hand, false, hold),
//!     interface("box_bottom", Owner::Object(0), Role::Surface, true, push),
//!     interface("box_handle", Owner::Object(0), Role::Surface, false, hold),
//!     interface("table_top", Owner::Static(0), Role::Surface, false, push),
//!     interface("shelf_top", Owner::Static(1), Role::Surface, false, push),
//! ];
//! let domain = Domain::new(interfaces, vec!["box".to_owned()], vec![])?;
//! let start: ContactState = [Contact { a: InterfaceId(1), b: InterfaceId(3), kind: push }].into_iter().collect();
//! let goal = Goal::of_pairs([(InterfaceId(1), InterfaceId(4))]);
//! let graph = SkeletonGraph::new(domain, start, goal, GraphOptions::default())?;
//! let mut search = BestFirst::new(graph, &SearchLimits::default(), Costs::default());
//! let plan = search.next(&mut AcceptAll).expect("a plan exists");
//! assert_eq!(plan.labels, ["start", "grasp box with hand", "lift box", "place box on shelf_top", "release box"]);
//! # Ok::<(), symbolic::SymbolicError>(())
//! ```

#[cfg(test)]
extern crate self as symbolic;

mod action;
mod carried;
mod contact;
pub mod contact_rules;
mod domain;
mod error;
mod goal;
mod graph;
mod in_place;
mod manipulation;
pub mod pddl;
pub mod search;
pub mod state_rules;
pub mod statistics;
mod successors;
mod task;
mod task_graph;
pub mod transition_rules;

pub use action::Action;
pub use carried::is_carried;
pub use contact::{Contact, ContactState, ContactType, InterfaceId};
pub use domain::{Domain, Interface, Owner, Role};
pub use error::SymbolicError;
pub use goal::{Goal, GoalPair};
pub use graph::{GraphOptions, Node, SkeletonGraph, StateId, Successor};
pub use in_place::{InPlace, in_place};
pub use manipulation::Manipulation;
pub use search::{
    Anew, BestFirst, Costs, Ending, Oracle, Policy, Rollouts, SearchLimits, Sequence, Statistics,
    Status, TreeSearch, Verdict,
};
pub use successors::successors;
pub use task::{Change, Condition, Fact, FactSet, Operator, Task};
pub use task_graph::{TaskEdge, TaskGraph, TaskState};
