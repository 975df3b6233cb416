//! Searches for contact sequences s_1 … s_K: Monte-Carlo tree search, and best first and random rollouts as baselines.
//!
//! Each is a [`Policy`]: it lists sequences of the same [`crate::SkeletonGraph`] one by one and asks an [`Oracle`], lazily and
//! at most once per question, whether a contact state, a transition or a beginning is possible. All are deterministic.

mod best_first;
mod beyond;
mod costs;
mod expansion;
mod limits;
mod mend;
mod oracle;
mod outlook;
mod policy;
mod random;
mod rollouts;
mod sequence;
mod tree_search;
mod verdicts;
mod walk;

pub use best_first::BestFirst;
pub use costs::{Costs, EndCost, ExtraCost, Step};
pub use limits::{Ending, SearchLimits, Status, default_phases};
pub use oracle::{AcceptAll, Anew, Oracle, Verdict};
pub use policy::{Policy, Statistics};
pub use rollouts::Rollouts;
pub use sequence::Sequence;
pub use tree_search::TreeSearch;
pub use verdicts::{Counts, Rejected, Rejection};
