//! What every search offers, so that they can be exchanged.

use crate::contact::ContactState;
use crate::graph::SkeletonGraph;
use crate::search::limits::Status;
use crate::search::oracle::Oracle;
use crate::search::sequence::Sequence;
use crate::search::verdicts::{Counts, Rejected, Rejection};

/// How often a beginning was gone through, and what came of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Statistics {
    /// Descents through it; what is not told yet and dead ends count too.
    pub visits: u32,
    /// Mean reward of them, between 0 and 1: what the choice between beginnings goes by.
    pub value: f64,
}

/// A search for contact sequences: which to try next.
pub trait Policy {
    /// The next complete sequence, none twice; `None` if the search ends or stops, see [`Policy::status`].
    fn next(&mut self, oracle: &mut dyn Oracle) -> Option<Sequence>;

    /// Takes note of what a returned sequence turned out to be worth: 0 nothing, 1 as good as can be.
    fn learn(&mut self, _states: &[ContactState], _reward: f64) {}

    /// What is known of the beginnings of a sequence, the start first, as far as the search remembers them; none by default.
    fn statistics(&self, _states: &[ContactState]) -> Vec<Statistics> {
        Vec::new()
    }

    /// Takes back what cannot be: from now on no sequence that contains it is returned.
    fn reject(&mut self, what: Rejected, reason: String);

    /// How far the search is.
    fn status(&self) -> Status;

    /// All rejections with their reasons, in the order in which they were found.
    fn rejections(&self) -> &[Rejection];

    /// Counts so far.
    fn counts(&self) -> Counts;

    /// Largest number of phases K_max.
    fn max_phases(&self) -> usize;

    /// The graph.
    fn graph(&self) -> &SkeletonGraph;
}
