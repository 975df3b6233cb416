//! Symbolic layer: interfaces, contact types, contact states, actions and the pruned graph of their transitions.
//!
//! Source: paper, sections "Symbolic state and actions" and "Symbolic search pruning". No pose and no number of
//! the scene's geometry appears here.

mod contact;

pub use contact::{Contact, ContactState, ContactType, InterfaceId};
