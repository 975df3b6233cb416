//! What lies ahead: the least cost from every node of a small part of the graph to an end, as far as is known.
//!
//! The part has no supporting hands but those of the goal: its nodes are the skeleton positions with all places of the feet. Its costs are those of
//! the search. States and transitions that the oracle rejected are left out, and before the first sequence the oracle is
//! asked about the states along the best way until all of them are accepted. So a search for a high place does not come
//! back again and again to a step that no leg can do, and finds out that a box must be moved before it helps.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use crate::contact::ContactState;
use crate::domain::Role;
use crate::graph::{Node, SkeletonGraph};
use crate::search::expansion::{Expansion, Units};
use crate::search::oracle::Oracle;
use crate::search::verdicts::Verdicts;

/// Most nodes; a larger part is not explored.
const MOST_NODES: usize = 20_000;

/// What lies ahead of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ahead {
    /// Not in the part that was explored.
    Unknown,
    /// No way to an end is left.
    NoWay,
    /// The least cost to an end.
    Cost(Units),
}

/// Least costs to an end.
#[derive(Debug, Clone)]
pub(crate) struct Outlook {
    nodes: Vec<Node>,
    index: BTreeMap<Node, usize>,
    /// Per node where edges lead, and their costs.
    edges: Vec<Vec<(usize, Units)>>,
    /// Per node the cost of ending there; `None` where a sequence cannot end.
    ends: Vec<Option<Units>>,
    /// Least cost to an end, `None` where no way is left.
    to_go: Vec<Option<Units>>,
    /// Number of rejections that it knows.
    rejections: usize,
}

impl Outlook {
    /// Explores; `None` if the part is too large.
    pub(crate) fn explore(expansion: &mut Expansion) -> Option<Self> {
        let root = expansion.graph.root();
        let mut outlook = Self {
            nodes: vec![root],
            index: BTreeMap::from([(root, 0)]),
            edges: vec![],
            ends: vec![],
            to_go: vec![],
            rejections: 0,
        };
        while outlook.edges.len() < outlook.nodes.len() {
            let node = outlook.nodes[outlook.edges.len()];
            let mut edges = vec![];
            for edge in expansion.graph.successors(node) {
                if !is_plain(&expansion.graph, edge.node) {
                    continue;
                }
                let (cost, _) = expansion.cost(node, edge, None);
                let new = outlook.nodes.len();
                let to = *outlook.index.entry(edge.node).or_insert(new);
                if to == new {
                    outlook.nodes.push(edge.node);
                }
                edges.push((to, cost));
            }
            outlook.edges.push(edges);
            let end = expansion.graph.is_goal(node);
            outlook
                .ends
                .push(end.then(|| expansion.end_cost(node.state, usize::MAX)));
            if outlook.nodes.len() > MOST_NODES {
                return None;
            }
        }
        Some(outlook)
    }

    /// Measures the costs again if more has been rejected since; true if so.
    pub(crate) fn update(&mut self, graph: &SkeletonGraph, verdicts: &Verdicts) -> bool {
        if self.rejections == verdicts.rejections().len() && !self.to_go.is_empty() {
            return false;
        }
        self.rejections = verdicts.rejections().len();
        let open: Vec<bool> = self
            .nodes
            .iter()
            .map(|&node| verdicts.is_open(graph, node))
            .collect();
        let mut sources: Vec<Vec<(usize, Units)>> = vec![vec![]; self.nodes.len()];
        for (from, edges) in self.edges.iter().enumerate().filter(|&(n, _)| open[n]) {
            for &(to, cost) in edges.iter().filter(|&&(to, _)| open[to]) {
                let (one, two) = (self.nodes[from].state, self.nodes[to].state);
                if !verdicts.is_barred(one, two) {
                    sources[to].push((from, cost));
                }
            }
        }
        self.to_go = vec![None; self.nodes.len()];
        let ends = (0..self.nodes.len()).filter(|&n| open[n]);
        let mut queue: BinaryHeap<Reverse<(Units, usize)>> = ends
            .filter_map(|n| self.ends[n].map(|cost| Reverse((cost, n))))
            .collect();
        while let Some(Reverse((cost, n))) = queue.pop() {
            if self.to_go[n].is_some() {
                continue;
            }
            self.to_go[n] = Some(cost);
            for &(from, step) in &sources[n] {
                if self.to_go[from].is_none() {
                    queue.push(Reverse((cost + step, from)));
                }
            }
        }
        true
    }

    /// Has the oracle judge the best way, then the best of what is left, until it accepts one.
    pub(crate) fn settle(
        &mut self,
        graph: &SkeletonGraph,
        verdicts: &mut Verdicts,
        oracle: &mut dyn Oracle,
    ) {
        while !oracle.stop() {
            self.update(graph, verdicts);
            let way = self.best_way();
            let accepted = way.iter().zip(&way[1..]).all(|(&one, &two)| {
                verdicts.accepts_step(graph, self.nodes[one], self.nodes[two], oracle)
            });
            if accepted {
                return;
            }
        }
    }

    /// The nodes of the cheapest way from the root to an end.
    fn best_way(&self) -> Vec<usize> {
        let mut way = vec![0];
        let mut at = 0;
        while let Some(left) = self.to_go[at] {
            if self.ends[at] == Some(left) || way.len() > self.nodes.len() {
                break;
            }
            let leads = |&&(to, cost): &&(usize, Units)| {
                self.to_go[to].is_some_and(|further| further + cost == left)
            };
            let Some(&(to, _)) = self.edges[at].iter().find(leads) else {
                break;
            };
            way.push(to);
            at = to;
        }
        way
    }

    /// What it knows of a node, supporting hands aside.
    pub(crate) fn ahead(&self, graph: &mut SkeletonGraph, node: Node) -> Ahead {
        let state = plain(graph, node);
        let node = Node {
            state: graph.intern(&state),
            ..node
        };
        let known = self.index.get(&node).and_then(|&n| self.to_go.get(n));
        match known {
            None => Ahead::Unknown,
            Some(None) => Ahead::NoWay,
            Some(&Some(cost)) => Ahead::Cost(cost),
        }
    }
}

/// The contacts of a node without those of supporting hands that are not of the goal.
fn plain(graph: &SkeletonGraph, node: Node) -> ContactState {
    let imposed = graph.imposed(node.position);
    let domain = graph.domain();
    let counts = |c: &crate::contact::Contact| {
        let mut goals = graph.goal().pairs.iter();
        imposed.contains(c)
            || goals.any(|pair| (pair.a, pair.b) == (c.a, c.b) || (pair.b, pair.a) == (c.a, c.b))
            || domain.is_effector(c.a, Role::Foot)
            || domain.object_of(c.a).is_some()
    };
    graph.state(node.state).iter().filter(counts).collect()
}

fn is_plain(graph: &SkeletonGraph, node: Node) -> bool {
    plain(graph, node) == *graph.state(node.state)
}
