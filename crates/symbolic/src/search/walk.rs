//! Random walks through the graph: each step with probability ∝ exp(−rank / temperature) among those that are accepted.

use std::collections::BTreeSet;

use crate::contact::InterfaceId;
use crate::graph::{Node, SkeletonGraph, StateId, Successor};
use crate::search::beyond::Beyond;
use crate::search::expansion::{Expansion, Ranked, Units, phases};
use crate::search::limits::Status;
use crate::search::oracle::Oracle;
use crate::search::random::Random;
use crate::search::sequence::{Sequence, states_along};
use crate::search::verdicts::{Rejected, Rejection, Verdicts};
use crate::task_graph::TaskState;

/// A beginning of a sequence.
#[derive(Debug, Clone)]
pub(crate) struct Walk {
    pub(crate) edges: Vec<Successor>,
    pub(crate) node: Node,
    pub(crate) last_foot: Option<InterfaceId>,
    /// The skeleton positions visited, each once, in order.
    pub(crate) visited: Vec<TaskState>,
    pub(crate) cost: Units,
    /// Number of edges, if steps were put in before the last of them; 0 if none were.
    pub(crate) mended: usize,
}

impl Walk {
    /// The start alone.
    pub(crate) fn new(graph: &SkeletonGraph) -> Self {
        let node = graph.root();
        Self {
            edges: Vec::new(),
            node,
            last_foot: None,
            visited: vec![node.position],
            cost: 0,
            mended: 0,
        }
    }

    pub(crate) fn n_phases(&self) -> usize {
        self.edges.len() + 1
    }

    pub(crate) fn take(&mut self, next: &Ranked) {
        if next.edge.operator.is_some() {
            self.visited.push(next.edge.node.position);
        }
        (self.node, self.last_foot) = (next.edge.node, next.last_foot);
        self.edges.push(next.edge);
        self.cost += next.cost;
    }
}

/// How a walk goes on.
enum Drawn {
    /// One step further.
    Step(Ranked),
    /// That step after some more before it.
    Mended(Walk),
}

/// What walks need: graph, costs, verdicts and chance.
#[derive(Debug)]
pub(crate) struct Walker {
    pub(crate) expansion: Expansion,
    pub(crate) verdicts: Verdicts,
    pub(crate) random: Random,
    /// In phases.
    pub(crate) temperature: f64,
    /// Steps that were judged.
    pub(crate) created: usize,
    /// Beginnings for which steps that help have been looked for.
    pub(crate) tried_to_mend: BTreeSet<Vec<StateId>>,
    /// Beginnings that steps do not help.
    pub(crate) beyond: Beyond,
}

impl Walker {
    pub(crate) fn new(expansion: Expansion, seed: u64) -> Self {
        Self {
            expansion,
            verdicts: Verdicts::remembering_accepted(),
            random: Random::new(seed),
            temperature: 1.0,
            created: 0,
            tried_to_mend: BTreeSet::new(),
            beyond: Beyond::default(),
        }
    }

    /// How a search that has made `created` steps must end, if it must.
    pub(crate) fn end(&mut self, created: usize, oracle: &mut dyn Oracle) -> Option<Status> {
        if oracle.stop() {
            return Some(Status::Stopped);
        }
        if !self.verdicts.leaves_a_skeleton(&self.expansion.graph) {
            return Some(Status::NoSkeleton);
        }
        (created >= self.expansion.bounds.max_nodes).then_some(Status::Full)
    }

    /// True if the start alone is accepted.
    pub(crate) fn may_begin(&mut self, oracle: &mut dyn Oracle) -> bool {
        let root = self.expansion.graph.root().state;
        self.expansion.may_begin()
            && self
                .verdicts
                .accepts(&self.expansion.graph, &[root], oracle)
    }

    /// Walks on to a complete sequence; false if that comes to a dead end, the walk then ends there.
    pub(crate) fn finish(&mut self, walk: &mut Walk, oracle: &mut dyn Oracle) -> bool {
        loop {
            let complete = self.expansion.is_complete(walk.node, walk.n_phases());
            let goes_on = self.expansion.goes_on(complete, walk.n_phases());
            if complete && (!goes_on || self.ends_here(walk)) {
                return true;
            }
            if !goes_on {
                return false;
            }
            match self.draw(walk, oracle) {
                Some(Drawn::Step(next)) => walk.take(&next),
                Some(Drawn::Mended(mended)) => *walk = mended,
                None => return false,
            }
        }
    }

    /// Draws whether a walk ends in a complete state although it could go on. With an outlook the end is weighed against the
    /// best step as steps are against each other; without, half of the walks end, less where ending costs.
    pub(crate) fn ends_here(&mut self, walk: &Walk) -> bool {
        let here = phases(self.expansion.end_cost(walk.node.state, walk.n_phases()));
        let share = if self.expansion.outlook.is_some() {
            let list = self.expansion.list(walk.node, walk.last_foot);
            let follows = |next: &&Ranked| {
                self.expansion
                    .may_follow(&next.edge, walk.n_phases(), &walk.visited)
            };
            let best = self.expansion.ranked(list).iter().find(follows);
            let on = best.map_or(f64::INFINITY, |next| phases(next.rank));
            1.0 / (1.0 + ((here - on) / self.temperature).exp())
        } else {
            0.5 * (-here / self.temperature).exp()
        };
        self.random.uniform() < share
    }

    /// Draws until a step is accepted, or can be made possible by steps before; `None` if all are rejected, or if the oracle
    /// stops.
    fn draw(&mut self, walk: &Walk, oracle: &mut dyn Oracle) -> Option<Drawn> {
        let list = self.expansion.list(walk.node, walk.last_foot);
        let follow = |next: &&Ranked| {
            self.expansion
                .may_follow(&next.edge, walk.n_phases(), &walk.visited)
        };
        let ranked = self.expansion.ranked(list).iter();
        let choices: Vec<Ranked> = ranked.filter(follow).copied().collect();
        let least = choices.iter().map(|next| next.rank).min()?;
        let weight = |next: &Ranked| (-phases(next.rank - least) / self.temperature).exp();
        let mut weights: Vec<f64> = choices.iter().map(weight).collect();
        while let Some(n) = self.random.choose(&weights) {
            if oracle.stop() {
                return None;
            }
            if self.accepts(walk, &choices[n], oracle) {
                return Some(Drawn::Step(choices[n]));
            }
            if let Some(mended) = self.mend(walk, &choices[n], oracle) {
                return Some(Drawn::Mended(mended));
            }
            weights[n] = 0.0;
        }
        None
    }

    /// True if nothing speaks against the step.
    pub(crate) fn accepts(&mut self, walk: &Walk, next: &Ranked, oracle: &mut dyn Oracle) -> bool {
        self.created += 1;
        let mut path = states_along(&walk.edges);
        path.push(next.edge.node.state);
        let graph = &self.expansion.graph;
        if self.beyond.passes_over(graph, &path) {
            self.verdicts.counts.dropped_by_prefix += 1;
            return false;
        }
        let accepts = self.verdicts.accepts(graph, &path, oracle);
        if accepts {
            self.beyond.note_possible(graph, &path);
        }
        accepts
    }

    /// The walk as a complete sequence.
    pub(crate) fn sequence(&mut self, walk: &Walk) -> Sequence {
        self.verdicts.counts.returned += 1;
        let cost = walk.cost + self.expansion.end_cost(walk.node.state, walk.n_phases());
        Sequence::along(&self.expansion.graph, &walk.edges, phases(cost))
    }

    pub(crate) fn reject(&mut self, what: Rejected, reason: String) {
        let rejection = Rejection { what, reason };
        self.verdicts.reject(&mut self.expansion.graph, rejection);
    }
}
