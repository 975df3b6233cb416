//! PDDL: the manipulation domain as a file, the problem from a scene, and their grounding to a [`crate::Task`].
//!
//! Source: paper, "Manipulation skeleton"; McDermott et al., *PDDL – The Planning Domain Definition Language*, 1998;
//! Fox and Long 2003 for the levels. Understood are `:strips`, `:typing`, `:equality`, negative, disjunctive and
//! quantified preconditions, quantified and conditional effects. `docs/symbolic.md`, section "PDDL", has the names that
//! a domain may use to speak of a scene, and which of its predicates stand for contacts.

mod expression;
mod formula;
mod ground;
mod labels;
mod parse;
mod problem;
mod source;
mod syntax;
mod vocabulary;

pub(crate) use ground::Ground;
pub(crate) use labels::labels;
pub use problem::Problem;
pub use source::PddlError;
pub(crate) use syntax::Atom;
pub use syntax::DomainFile;
pub(crate) use vocabulary::SceneProblem;
