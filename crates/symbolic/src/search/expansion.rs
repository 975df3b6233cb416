//! Ranked successors: what both searches draw from.

use std::collections::BTreeMap;
use std::fmt;

use crate::action::Action;
use crate::contact::InterfaceId;
use crate::domain::Role;
use crate::graph::{Node, SkeletonGraph, StateId, Successor};
use crate::search::costs::{Costs, EndCost, ExtraCost, Step};
use crate::search::limits::{Bounds, Ending};
use crate::search::oracle::Oracle;
use crate::search::outlook::{Ahead, Outlook};
use crate::search::verdicts::Verdicts;
use crate::task_graph::TaskState;

/// Costs are ordered as whole multiples of 1e-6 phases, so that sums do not depend on their order.
const RESOLUTION: f64 = 1e-6;

/// A cost as an integer.
pub(crate) type Units = u64;

pub(crate) fn units(cost: f64) -> Units {
    (cost.max(0.0) / RESOLUTION).round() as Units
}

pub(crate) fn phases(units: Units) -> f64 {
    units as f64 * RESOLUTION
}

/// A successor with its cost and what the path must remember.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ranked {
    pub(crate) edge: Successor,
    pub(crate) last_foot: Option<InterfaceId>,
    pub(crate) cost: Units,
    /// Cost plus the lower bound behind the edge.
    pub(crate) rank: Units,
}

/// The graph with costs; lists of ranked successors are kept once made.
pub(crate) struct Expansion {
    pub(crate) graph: SkeletonGraph,
    pub(crate) costs: Costs,
    pub(crate) extra: Option<ExtraCost>,
    pub(crate) end: Option<EndCost>,
    pub(crate) outlook: Option<Outlook>,
    pub(crate) bounds: Bounds,
    lists: Vec<Vec<Ranked>>,
    index: BTreeMap<(Node, Option<InterfaceId>), usize>,
}

impl fmt::Debug for Expansion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Expansion")
            .field("bounds", &self.bounds)
            .field("lists", &self.lists.len())
            .finish_non_exhaustive()
    }
}

impl Expansion {
    pub(crate) fn new(graph: SkeletonGraph, bounds: Bounds, costs: Costs) -> Self {
        Self {
            graph,
            costs,
            extra: None,
            end: None,
            outlook: None,
            bounds,
            lists: Vec::new(),
            index: BTreeMap::new(),
        }
    }

    /// Number of the list of ranked successors of a node; the best first, equal ranks in the order of the graph.
    pub(crate) fn list(&mut self, node: Node, last_foot: Option<InterfaceId>) -> usize {
        if let Some(&list) = self.index.get(&(node, last_foot)) {
            return list;
        }
        let successors = self.graph.successors(node);
        let mut ranked: Vec<Ranked> = successors
            .into_iter()
            .filter_map(|edge| self.rank(node, edge, last_foot))
            .collect();
        ranked.sort_by_key(|one| one.rank);
        self.lists.push(ranked);
        self.index.insert((node, last_foot), self.lists.len() - 1);
        self.lists.len() - 1
    }

    pub(crate) fn ranked(&self, list: usize) -> &[Ranked] {
        &self.lists[list]
    }

    /// `None` if the goal is out of reach behind the edge.
    fn rank(
        &mut self,
        from: Node,
        edge: Successor,
        last_foot: Option<InterfaceId>,
    ) -> Option<Ranked> {
        let (cost, lifted) = self.cost(from, edge, last_foot);
        let behind = self.behind(edge.node)?;
        Some(Ranked {
            edge,
            last_foot: lifted.or(last_foot),
            cost,
            rank: cost + behind,
        })
    }

    /// The cost of an edge, and the foot that is lifted.
    pub(crate) fn cost(
        &self,
        from: Node,
        edge: Successor,
        last_foot: Option<InterfaceId>,
    ) -> (Units, Option<InterfaceId>) {
        let graph = &self.graph;
        let action = Action::between(graph.state(from.state), graph.state(edge.node.state));
        let is_foot = |i: InterfaceId| graph.domain().is_effector(i, Role::Foot);
        let lifted = action.breaks.iter().map(|c| c.a).rfind(|&i| is_foot(i));
        let step = Step {
            graph,
            from,
            to: edge.node,
            action,
            advances: edge.operator.is_some(),
            last_foot,
        };
        let extra = self.extra.as_ref().map_or(0.0, |extra| extra(&step));
        let cost = units(self.costs.step(&step).max(self.costs.phase)) + units(extra);
        (cost, lifted)
    }

    /// What a node is expected to cost until the end: by the outlook, or the phases that are needed at least; `None` if the
    /// goal is out of reach.
    pub(crate) fn behind(&mut self, node: Node) -> Option<Units> {
        let outlook = self.outlook.as_ref();
        match outlook.map_or(Ahead::Unknown, |o| o.ahead(&mut self.graph, node)) {
            Ahead::Cost(cost) => Some(cost),
            Ahead::NoWay => None,
            Ahead::Unknown => {
                let behind = self.phases_behind(node)?;
                Some(units(self.costs.phase) * behind as Units)
            }
        }
    }

    /// Brings the outlook, if there is one, up to what is known.
    pub(crate) fn look_ahead(&mut self, verdicts: &mut Verdicts, oracle: &mut dyn Oracle) {
        let Some(mut outlook) = self.outlook.take() else {
            return;
        };
        if outlook.update(&self.graph, verdicts) {
            outlook.settle(&self.graph, verdicts, oracle);
            self.lists.clear();
            self.index.clear();
        }
        self.outlook = Some(outlook);
    }

    /// A lower bound on the phases after a node, as far as it does not depend on the path.
    fn phases_behind(&self, node: Node) -> Option<usize> {
        let remaining = self.graph.remaining(node)?;
        Some(if self.bounds.ending == Ending::First {
            remaining
        } else {
            0
        })
    }

    /// A lower bound on the cost from a node that is the `phases`-th to a complete sequence.
    pub(crate) fn bound(&self, node: Node, phases: usize) -> Option<Units> {
        let behind = match self.bounds.ending {
            Ending::Full => self.bounds.max_phases.saturating_sub(phases),
            Ending::First | Ending::Every => self.phases_behind(node)?,
        };
        Some(units(self.costs.phase) * behind as Units)
    }

    /// True if a sequence of `phases` phases with these positions may go on over the edge.
    pub(crate) fn may_follow(
        &self,
        edge: &Successor,
        phases: usize,
        visited: &[TaskState],
    ) -> bool {
        let fits = self
            .graph
            .remaining(edge.node)
            .is_some_and(|n| phases + 1 + n <= self.bounds.max_phases);
        fits && (edge.operator.is_none() || self.graph.may_advance(visited, edge.node.position))
    }

    /// True if the root can begin any sequence.
    pub(crate) fn may_begin(&self) -> bool {
        let root = self.graph.root();
        let fits = self
            .graph
            .remaining(root)
            .is_some_and(|n| n < self.bounds.max_phases);
        fits && self.graph.skeletons().may_reach_goal(root.position, 0)
    }

    /// True if a sequence of `phases` phases is complete at the node.
    pub(crate) fn is_complete(&self, node: Node, phases: usize) -> bool {
        self.graph.is_goal(node)
            && (self.bounds.ending != Ending::Full || phases == self.bounds.max_phases)
    }

    /// True if a sequence that is complete, or not, is also extended.
    pub(crate) fn goes_on(&self, complete: bool, phases: usize) -> bool {
        phases < self.bounds.max_phases && !(complete && self.bounds.ending == Ending::First)
    }

    /// What it costs to end in a state after so many phases.
    pub(crate) fn end_cost(&self, state: StateId, phases: usize) -> Units {
        let missing = self.bounds.likely_phases.saturating_sub(phases) as f64;
        let own = self.end.as_ref();
        let own = own.map_or(0.0, |end| end(&self.graph, self.graph.state(state)));
        let of_state = self.costs.end(&self.graph, state) + own.max(0.0);
        units(of_state + self.costs.phase * missing)
    }
}
