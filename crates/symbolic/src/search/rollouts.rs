//! Random rollouts: complete contact sequences drawn from the graph without memory of what they were worth.

use std::collections::BTreeSet;

use crate::graph::{SkeletonGraph, StateId};
use crate::search::costs::{Costs, ExtraCost};
use crate::search::expansion::Expansion;
use crate::search::limits::{SearchLimits, Status};
use crate::search::oracle::Oracle;
use crate::search::policy::Policy;
use crate::search::sequence::{Sequence, states_along};
use crate::search::verdicts::{Counts, Rejected, Rejection};
use crate::search::walk::{Walk, Walker};

/// Rollouts without a new sequence after which a search gives up.
const MAX_FAILURES: usize = 10_000;

/// Random search: walks from the start, each step with probability ∝ exp(−cost / temperature).
#[derive(Debug)]
pub struct Rollouts {
    walker: Walker,
    returned: BTreeSet<Vec<StateId>>,
    status: Status,
}

impl Rollouts {
    /// A search with a seed; the same seed and verdicts give the same sequences.
    pub fn new(graph: SkeletonGraph, limits: &SearchLimits, costs: Costs, seed: u64) -> Self {
        let bounds = limits.resolve(&graph);
        Self {
            walker: Walker::new(Expansion::new(graph, bounds, costs), seed),
            returned: BTreeSet::new(),
            status: Status::Running,
        }
    }

    /// Sets the temperature in phases (default 1): near zero only best steps are taken, large values make all equal.
    #[must_use]
    pub fn with_temperature(mut self, temperature: f64) -> Self {
        self.walker.temperature = temperature.max(1e-3);
        self
    }

    /// Adds a cost of the caller's; to be called before the first sequence is asked for.
    #[must_use]
    pub fn with_extra_cost(mut self, extra: ExtraCost) -> Self {
        self.walker.expansion.extra = Some(extra);
        self
    }
}

impl Policy for Rollouts {
    /// [`Status::Exhausted`] also if many rollouts in a row found nothing new.
    fn next(&mut self, oracle: &mut dyn Oracle) -> Option<Sequence> {
        for n in 0..MAX_FAILURES {
            if n > 0 && oracle.pause() {
                self.status = Status::Stopped;
                return None;
            }
            if let Some(status) = self.walker.end(self.walker.created, oracle) {
                self.status = status;
                return None;
            }
            self.status = Status::Running;
            if !self.walker.may_begin(oracle) {
                break;
            }
            let mut walk = Walk::new(&self.walker.expansion.graph);
            if self.walker.finish(&mut walk, oracle)
                && self.returned.insert(states_along(&walk.edges))
            {
                return Some(self.walker.sequence(&walk));
            }
        }
        self.status = Status::Exhausted;
        None
    }

    fn reject(&mut self, what: Rejected, reason: String) {
        self.walker.reject(what, reason);
    }

    fn status(&self) -> Status {
        self.status
    }

    fn rejections(&self) -> &[Rejection] {
        self.walker.verdicts.rejections()
    }

    fn counts(&self) -> Counts {
        Counts {
            created: self.walker.created,
            ..self.walker.verdicts.counts
        }
    }

    fn max_phases(&self) -> usize {
        self.walker.expansion.bounds.max_phases
    }

    fn graph(&self) -> &SkeletonGraph {
        &self.walker.expansion.graph
    }
}
