//! Random rollouts: complete contact sequences drawn from the same graph.

use std::collections::BTreeSet;

use crate::graph::{SkeletonGraph, StateId, Successor};
use crate::search::costs::{Costs, ExtraCost};
use crate::search::expansion::{Expansion, Ranked, Units, phases};
use crate::search::limits::{SearchLimits, Status};
use crate::search::oracle::Oracle;
use crate::search::random::Random;
use crate::search::sequence::{Sequence, states_along};
use crate::search::verdicts::{Counts, Rejected, Rejection, Verdicts};

/// Rollouts without a new sequence after which a search gives up.
const MAX_FAILURES: usize = 10_000;

/// Random search: walks from the start, each step with probability ∝ exp(−cost / temperature).
#[derive(Debug)]
pub struct Rollouts {
    expansion: Expansion,
    verdicts: Verdicts,
    random: Random,
    temperature: f64,
    returned: BTreeSet<Vec<StateId>>,
    created: usize,
    status: Status,
}

/// What has been walked so far.
#[derive(Debug, Default)]
struct Walk {
    edges: Vec<Successor>,
    cost: Units,
}

impl Rollouts {
    /// A search with a seed; the same seed and verdicts give the same sequences.
    pub fn new(graph: SkeletonGraph, limits: &SearchLimits, costs: Costs, seed: u64) -> Self {
        let bounds = limits.resolve(&graph);
        Self {
            expansion: Expansion::new(graph, bounds, costs),
            verdicts: Verdicts::remembering_accepted(),
            random: Random::new(seed),
            temperature: 1.0,
            returned: BTreeSet::new(),
            created: 0,
            status: Status::Running,
        }
    }

    /// Sets the temperature in phases (default 1): near zero only best steps are taken, large values make all equal.
    #[must_use]
    pub fn with_temperature(mut self, temperature: f64) -> Self {
        self.temperature = temperature.max(1e-3);
        self
    }

    /// Adds a cost of the caller's; to be called before the first sequence is asked for.
    #[must_use]
    pub fn with_extra_cost(mut self, extra: ExtraCost) -> Self {
        self.expansion.extra = Some(extra);
        self
    }

    /// A complete sequence that has not been returned before; `None` if the oracle stops the search, or
    /// ([`Status::Exhausted`]) many rollouts in a row found nothing new, or the memory limit is reached.
    pub fn next(&mut self, oracle: &mut dyn Oracle) -> Option<Sequence> {
        for _ in 0..MAX_FAILURES {
            if oracle.stop() {
                self.status = Status::Stopped;
                return None;
            }
            if self.created >= self.expansion.bounds.max_nodes {
                self.status = Status::Full;
                return None;
            }
            self.status = Status::Running;
            let Some(walk) = self.roll(oracle) else {
                continue;
            };
            if self.returned.insert(states_along(&walk.edges)) {
                self.verdicts.counts.returned += 1;
                let last = walk
                    .edges
                    .last()
                    .map_or(self.expansion.graph.root(), |edge| edge.node);
                let cost = walk.cost + self.expansion.end_cost(last.state);
                return Some(Sequence::along(
                    &self.expansion.graph,
                    &walk.edges,
                    phases(cost),
                ));
            }
        }
        self.status = Status::Exhausted;
        None
    }

    /// One walk; `None` if it comes to a dead end.
    fn roll(&mut self, oracle: &mut dyn Oracle) -> Option<Walk> {
        let mut walk = Walk::default();
        let root = self.expansion.graph.root();
        if !self.expansion.may_begin()
            || !self
                .verdicts
                .accepts(&self.expansion.graph, &[root.state], oracle)
        {
            return None;
        }
        let (mut node, mut last_foot, mut visited) = (root, None, vec![root.position]);
        loop {
            let n_phases = walk.edges.len() + 1;
            let complete = self.expansion.is_complete(node, n_phases);
            if complete
                && (!self.expansion.goes_on(complete, n_phases) || self.random.uniform() < 0.5)
            {
                return Some(walk);
            }
            if !self.expansion.goes_on(complete, n_phases) {
                return None;
            }
            let list = self.expansion.list(node, last_foot);
            let follow = |next: &&Ranked| self.expansion.may_follow(&next.edge, n_phases, &visited);
            let choices: Vec<Ranked> = self
                .expansion
                .ranked(list)
                .iter()
                .filter(follow)
                .copied()
                .collect();
            let next = self.draw(&choices, &walk.edges, oracle)?;
            if next.edge.operator.is_some() {
                visited.push(next.edge.node.position);
            }
            (node, last_foot) = (next.edge.node, next.last_foot);
            walk.edges.push(next.edge);
            walk.cost += next.cost;
        }
    }

    /// Draws until a step is accepted; `None` if all are rejected.
    fn draw(
        &mut self,
        choices: &[Ranked],
        edges: &[Successor],
        oracle: &mut dyn Oracle,
    ) -> Option<Ranked> {
        let least = choices.iter().map(|next| next.rank).min()?;
        let weight = |next: &Ranked| (-phases(next.rank - least) / self.temperature).exp();
        let mut weights: Vec<f64> = choices.iter().map(weight).collect();
        let mut path = states_along(edges);
        while let Some(n) = self.random.choose(&weights) {
            path.push(choices[n].edge.node.state);
            self.created += 1;
            if self.verdicts.accepts(&self.expansion.graph, &path, oracle) {
                return Some(choices[n]);
            }
            path.pop();
            weights[n] = 0.0;
        }
        None
    }

    /// Takes back what cannot be: from now on no sequence that contains it is returned.
    pub fn reject(&mut self, what: Rejected, reason: impl Into<String>) {
        let rejection = Rejection {
            what,
            reason: reason.into(),
        };
        self.verdicts.reject(&mut self.expansion.graph, rejection);
    }

    /// How far the search is.
    pub fn status(&self) -> Status {
        self.status
    }

    /// All rejections with their reasons, in the order in which they were found.
    pub fn rejections(&self) -> &[Rejection] {
        self.verdicts.rejections()
    }

    /// Counts so far.
    pub fn counts(&self) -> Counts {
        Counts {
            created: self.created,
            ..self.verdicts.counts
        }
    }

    /// The graph.
    pub fn graph(&self) -> &SkeletonGraph {
        &self.expansion.graph
    }
}
