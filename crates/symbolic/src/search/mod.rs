//! Plain searches for contact sequences s_1 … s_K: best first and random rollouts.
//!
//! Both list sequences of the same [`crate::SkeletonGraph`] one by one and ask an [`Oracle`], lazily and at most once
//! per question, whether a contact state, a transition or a beginning is possible. Both are deterministic.

mod best_first;
mod costs;
mod expansion;
mod limits;
mod oracle;
mod random;
mod rollouts;
mod sequence;
mod verdicts;

pub use best_first::BestFirst;
pub use costs::{Costs, ExtraCost, Step};
pub use limits::{Ending, SearchLimits, Status, default_phases};
pub use oracle::{AcceptAll, Oracle, Verdict};
pub use rollouts::Rollouts;
pub use sequence::Sequence;
pub use verdicts::{Counts, Rejected, Rejection};
