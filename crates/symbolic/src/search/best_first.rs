//! Best-first search: complete contact sequences in order of cost.
//!
//! A* over beginnings of sequences with the remaining skeleton actions as heuristic. Successors are taken one by one
//! (partial expansion): the queue holds one entry per beginning and its next successor, so that memory grows with the
//! number of steps of the search and not with the branching factor.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::contact::InterfaceId;
use crate::graph::{SkeletonGraph, StateId, Successor};
use crate::search::costs::{Costs, ExtraCost};
use crate::search::expansion::{Expansion, Units, phases};
use crate::search::limits::{SearchLimits, Status};
use crate::search::oracle::Oracle;
use crate::search::policy::Policy;
use crate::search::sequence::{Sequence, states_along};
use crate::search::verdicts::{Counts, Rejected, Rejection, Verdicts};
use crate::task_graph::TaskState;

/// A beginning of sequences: a node of the search tree.
#[derive(Debug, Clone, Copy)]
struct Beginning {
    parent: u32,
    edge: Successor,
    last_foot: Option<InterfaceId>,
    n_phases: u32,
    cost: Units,
    /// Revision of the verdicts that it has been checked against.
    checked: u32,
}

/// What is done next with a beginning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Turn {
    /// Ask the oracle.
    Judge,
    /// Return it as a complete sequence.
    Return,
    /// Extend it by the successor of that rank.
    Extend(u32),
}

/// Entry of the queue, ordered by bound, then longer beginnings first, then age.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    bound: Units,
    behind: u32,
    age: u64,
    beginning: u32,
    turn: Turn,
}

/// Best-first search over a [`SkeletonGraph`].
#[derive(Debug)]
pub struct BestFirst {
    expansion: Expansion,
    verdicts: Verdicts,
    tree: Vec<Beginning>,
    queue: BinaryHeap<Reverse<Entry>>,
    age: u64,
    status: Status,
}

impl BestFirst {
    /// A search that orders sequences by `costs`.
    pub fn new(graph: SkeletonGraph, limits: &SearchLimits, costs: Costs) -> Self {
        let bounds = limits.resolve(&graph);
        let mut search = Self {
            expansion: Expansion::new(graph, bounds, costs),
            verdicts: Verdicts::default(),
            tree: Vec::new(),
            queue: BinaryHeap::new(),
            age: 0,
            status: Status::Running,
        };
        if search.expansion.may_begin() {
            let edge = Successor {
                node: search.expansion.graph.root(),
                operator: None,
            };
            search.create(Beginning {
                parent: 0,
                edge,
                last_foot: None,
                n_phases: 1,
                cost: 0,
                checked: 0,
            });
        }
        search
    }

    /// Adds a cost of the caller's; to be called before the first sequence is asked for.
    #[must_use]
    pub fn with_extra_cost(mut self, extra: ExtraCost) -> Self {
        self.expansion.extra = Some(extra);
        self
    }

    fn create(&mut self, beginning: Beginning) {
        let bound = self
            .expansion
            .bound(beginning.edge.node, beginning.n_phases as usize);
        let Some(bound) = bound else { return };
        let index = self.tree.len() as u32;
        self.tree.push(beginning);
        self.push(index, beginning.cost + bound, Turn::Judge);
    }

    fn push(&mut self, beginning: u32, bound: Units, turn: Turn) {
        let behind = u32::MAX - self.tree[beginning as usize].n_phases;
        self.queue.push(Reverse(Entry {
            bound,
            behind,
            age: self.age,
            beginning,
            turn,
        }));
        self.age += 1;
    }

    fn judge(&mut self, index: u32, oracle: &mut dyn Oracle) {
        let path = states_along(&self.edges(index));
        let graph = &self.expansion.graph;
        if !self.verdicts.accepts(graph, &path, oracle) {
            return;
        }
        let Beginning {
            edge: Successor { node, .. },
            n_phases,
            cost,
            ..
        } = self.tree[index as usize];
        let complete = self.expansion.is_complete(node, n_phases as usize);
        if complete {
            let end = self.expansion.end_cost(node.state, n_phases as usize);
            self.push(index, cost + end, Turn::Return);
        }
        if self.expansion.goes_on(complete, n_phases as usize) {
            self.queue_extension(index, 0);
        }
    }

    /// Queues the first successor from `rank` on that the path allows.
    fn queue_extension(&mut self, index: u32, rank: usize) {
        let Beginning {
            edge,
            last_foot,
            n_phases,
            cost,
            ..
        } = self.tree[index as usize];
        let visited = self.visited(index);
        let list = self.expansion.list(edge.node, last_foot);
        let ranked = self.expansion.ranked(list);
        let allowed = |rank: &usize| {
            self.expansion
                .may_follow(&ranked[*rank].edge, n_phases as usize, &visited)
        };
        let Some(rank) = (rank..ranked.len()).find(allowed) else {
            return;
        };
        let next = &ranked[rank];
        let bound = self
            .expansion
            .bound(next.edge.node, n_phases as usize + 1)
            .unwrap_or(0);
        let bound = cost + next.cost + bound;
        self.push(index, bound, Turn::Extend(rank as u32));
    }

    fn extend(&mut self, index: u32, rank: usize) {
        let Beginning {
            edge,
            last_foot,
            n_phases,
            cost,
            checked,
            ..
        } = self.tree[index as usize];
        let list = self.expansion.list(edge.node, last_foot);
        let next = self.expansion.ranked(list)[rank];
        self.create(Beginning {
            parent: index,
            edge: next.edge,
            last_foot: next.last_foot,
            n_phases: n_phases + 1,
            cost: cost + next.cost,
            checked,
        });
        self.queue_extension(index, rank + 1);
    }

    /// The edges from the root to a beginning.
    fn edges(&self, mut index: u32) -> Vec<Successor> {
        let mut edges = Vec::new();
        while index != 0 {
            edges.push(self.tree[index as usize].edge);
            index = self.tree[index as usize].parent;
        }
        edges.reverse();
        edges
    }

    /// The skeleton positions of a beginning, each once, in order.
    fn visited(&self, index: u32) -> Vec<TaskState> {
        let mut visited = vec![self.expansion.graph.root().position];
        visited.extend(
            self.edges(index)
                .iter()
                .filter(|edge| edge.operator.is_some())
                .map(|e| e.node.position),
        );
        visited
    }

    fn is_alive(&mut self, index: u32) -> bool {
        if self.tree[index as usize].checked == self.verdicts.revision {
            return true;
        }
        let path: Vec<StateId> = states_along(&self.edges(index));
        let alive = self.verdicts.is_alive(&path);
        if alive {
            self.tree[index as usize].checked = self.verdicts.revision;
        }
        alive
    }
}

impl Policy for BestFirst {
    /// The next complete sequence, none twice and none cheaper than the one before; `None` if the search ends or
    /// stops, see [`BestFirst::status`].
    fn next(&mut self, oracle: &mut dyn Oracle) -> Option<Sequence> {
        loop {
            if oracle.stop() {
                self.status = Status::Stopped;
                return None;
            }
            if self.tree.len() >= self.expansion.bounds.max_nodes {
                self.status = Status::Full;
                return None;
            }
            if !self.verdicts.leaves_a_skeleton(&self.expansion.graph) {
                self.status = Status::NoSkeleton;
                return None;
            }
            let Some(Reverse(entry)) = self.queue.pop() else {
                self.status = Status::Exhausted;
                return None;
            };
            self.status = Status::Running;
            if !self.is_alive(entry.beginning) {
                continue;
            }
            match entry.turn {
                Turn::Judge => self.judge(entry.beginning, oracle),
                Turn::Extend(rank) => self.extend(entry.beginning, rank as usize),
                Turn::Return => {
                    self.verdicts.counts.returned += 1;
                    let edges = self.edges(entry.beginning);
                    return Some(Sequence::along(
                        &self.expansion.graph,
                        &edges,
                        phases(entry.bound),
                    ));
                }
            }
        }
    }

    fn reject(&mut self, what: Rejected, reason: String) {
        let rejection = Rejection { what, reason };
        self.verdicts.reject(&mut self.expansion.graph, rejection);
    }

    fn status(&self) -> Status {
        self.status
    }

    fn rejections(&self) -> &[Rejection] {
        self.verdicts.rejections()
    }

    fn counts(&self) -> Counts {
        Counts {
            created: self.tree.len(),
            ..self.verdicts.counts
        }
    }

    fn max_phases(&self) -> usize {
        self.expansion.bounds.max_phases
    }

    fn graph(&self) -> &SkeletonGraph {
        &self.expansion.graph
    }
}
