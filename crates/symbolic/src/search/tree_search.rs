//! Monte-Carlo tree search over beginnings of contact sequences.
//!
//! A tree node is a beginning s_1 … s_k. From the root the child with the largest upper confidence bound is taken
//! until a node may get another child (progressive widening: as many children as the square root of its visits, the
//! cheapest first, and only those that the oracle accepts); from that child a random walk completes the sequence.
//! Whoever evaluates the sequence tells its reward, which counts for all nodes on the way. A sequence that is not told
//! yet counts as worth nothing (virtual loss), so that several can be under evaluation at once.
//!
//! Source: UCT, Kocsis and Szepesvári 2006; progressive widening, Coulom 2007, Couëtoux and others 2011; the paper, section
//! "Implementation Details".

use std::collections::{BTreeMap, BTreeSet};

use crate::contact::ContactState;
use crate::graph::{Node, SkeletonGraph, StateId};
use crate::search::costs::{Costs, EndCost, ExtraCost};
use crate::search::expansion::{Expansion, Ranked, phases};
use crate::search::limits::{SearchLimits, Status};
use crate::search::oracle::Oracle;
use crate::search::outlook::Outlook;
use crate::search::policy::{Policy, Statistics};
use crate::search::sequence::{Sequence, states_along};
use crate::search::verdicts::{Counts, Rejected, Rejection};
use crate::search::walk::{Walk, Walker};

/// Simulations without a new sequence after which the search gives up.
const MAX_FAILURES: usize = 10_000;
/// Weight of the uncertainty in the upper confidence bound; rewards lie between 0 and 1.
const EXPLORATION: f64 = 0.5;
/// A node with n visits may have n^WIDENING children.
const WIDENING: f64 = 0.5;
/// Temperature of the random walks [phases].
const TEMPERATURE: f64 = 0.5;
/// Reward of a walk that comes to a dead end just before the goal; less the farther from it.
const DEAD_END: f64 = 0.1;

/// A beginning of sequences.
#[derive(Debug)]
struct TreeNode {
    parent: usize,
    walk: Walk,
    /// Successors that have become children, or been rejected.
    tried: BTreeSet<Node>,
    children: Vec<usize>,
    visits: f64,
    /// Sum of the rewards.
    value: f64,
    /// The sequence that ends here has been returned, or there is none.
    ended: bool,
    /// Nothing new can come from here.
    closed: bool,
    /// Revision of the verdicts that it has been checked against.
    checked: u32,
}

/// Monte-Carlo tree search over a [`SkeletonGraph`]; the same seed, verdicts and rewards give the same sequences.
#[derive(Debug)]
pub struct TreeSearch {
    walker: Walker,
    tree: Vec<TreeNode>,
    /// Sequences returned, with the tree node from which each was completed.
    returned: BTreeMap<Vec<StateId>, usize>,
    status: Status,
}

impl TreeSearch {
    /// A search with a seed; `costs` order the children and weigh the steps of the random walks.
    pub fn new(graph: SkeletonGraph, limits: &SearchLimits, costs: Costs, seed: u64) -> Self {
        let bounds = limits.resolve(&graph);
        let walk = Walk::new(&graph);
        let mut search = Self {
            walker: Walker::new(Expansion::new(graph, bounds, costs), seed),
            tree: Vec::new(),
            returned: BTreeMap::new(),
            status: Status::Running,
        };
        search.walker.temperature = TEMPERATURE;
        search.add(0, walk);
        search
    }

    /// Adds costs of the caller's, of steps and of ends; to be called before the first sequence is asked for.
    #[must_use]
    pub fn with_own_costs(mut self, extra: ExtraCost, end: Option<EndCost>) -> Self {
        self.walker.expansion.extra = Some(extra);
        self.walker.expansion.end = end;
        self
    }

    /// Has the search look ahead (`Outlook`), if that part of the graph is not too large; after the costs are given.
    #[must_use]
    pub fn with_outlook(mut self) -> Self {
        let expansion = &mut self.walker.expansion;
        expansion.outlook = Outlook::explore(expansion);
        self
    }

    fn add(&mut self, parent: usize, walk: Walk) -> usize {
        let expansion = &self.walker.expansion;
        let ended = !expansion.is_complete(walk.node, walk.n_phases());
        self.tree.push(TreeNode {
            ended,
            parent,
            walk,
            tried: BTreeSet::new(),
            children: Vec::new(),
            visits: 0.0,
            value: 0.0,
            closed: false,
            checked: self.walker.verdicts.revision,
        });
        self.tree.len() - 1
    }

    /// One descent: a new node (or the root while it is new), or a node that is complete and where the sequence is to end;
    /// `None` if the way there is closed.
    fn select(&mut self, oracle: &mut dyn Oracle) -> Option<(usize, bool)> {
        let mut at = 0;
        if self.tree[0].visits == 0.0 {
            return Some((0, false));
        }
        loop {
            if !self.tree[at].ended && self.walker.ends_here(&self.tree[at].walk) {
                return Some((at, true));
            }
            if let Some(child) = self.widen(at, oracle) {
                return Some((child, false));
            }
            let Some(child) = self.best_child(at) else {
                if !self.tree[at].ended && !oracle.stop() {
                    return Some((at, true));
                }
                self.tree[at].closed = self.is_exhausted(at);
                return None;
            };
            at = child;
        }
    }

    /// Adds the next child of a node if its visits allow one and the oracle accepts it.
    fn widen(&mut self, at: usize, oracle: &mut dyn Oracle) -> Option<usize> {
        let node = &self.tree[at];
        let open = |&&child: &&usize| !self.tree[child].closed;
        let room = node.visits.max(1.0).powf(WIDENING).ceil() as usize;
        if node.children.iter().filter(open).count() >= room || self.is_leaf(at) {
            return None;
        }
        let walk = node.walk.clone();
        while let Some(next) = self.next_successor(at) {
            if oracle.stop() {
                return None;
            }
            if self.walker.accepts(&walk, &next, oracle) {
                return Some(self.extend(at, &next));
            }
            self.tree[at].tried.insert(next.edge.node);
            if let Some(mended) = self.walker.mend(&walk, &next, oracle) {
                return Some(self.graft(&mended));
            }
        }
        None
    }

    /// The cheapest successor of a node that has not been tried.
    fn next_successor(&mut self, at: usize) -> Option<Ranked> {
        let Self { walker, tree, .. } = self;
        let TreeNode { walk, tried, .. } = &tree[at];
        let expansion = &mut walker.expansion;
        let list = expansion.list(walk.node, walk.last_foot);
        let new = |next: &&Ranked| {
            !tried.contains(&next.edge.node)
                && expansion.may_follow(&next.edge, walk.n_phases(), &walk.visited)
        };
        expansion.ranked(list).iter().find(new).copied()
    }

    /// The child of a node behind a successor, new if there is none.
    fn extend(&mut self, at: usize, next: &Ranked) -> usize {
        let edge = next.edge;
        let is_same = |&&child: &&usize| self.tree[child].walk.edges.last() == Some(&edge);
        if let Some(&child) = self.tree[at].children.iter().find(is_same) {
            return child;
        }
        let mut longer = self.tree[at].walk.clone();
        longer.take(next);
        let child = self.add(at, longer);
        self.tree[at].tried.insert(edge.node);
        self.tree[at].children.push(child);
        child
    }

    /// The tree node at the end of a walk to which steps were added; it and those on the way become part of the tree.
    fn graft(&mut self, walk: &Walk) -> usize {
        let mut at = 0;
        for edge in &walk.edges[..walk.mended] {
            let TreeNode { walk, .. } = &self.tree[at];
            let expansion = &mut self.walker.expansion;
            let list = expansion.list(walk.node, walk.last_foot);
            let ranked = expansion.ranked(list).iter();
            let Some(next) = ranked.into_iter().find(|next| next.edge == *edge).copied() else {
                break; // ruled out since
            };
            at = self.extend(at, &next);
        }
        at
    }

    /// True if sequences end at the node.
    fn is_leaf(&self, at: usize) -> bool {
        let walk = &self.tree[at].walk;
        let expansion = &self.walker.expansion;
        let complete = expansion.is_complete(walk.node, walk.n_phases());
        !expansion.goes_on(complete, walk.n_phases())
    }

    /// True if every successor has been tried and no child is open.
    fn is_exhausted(&mut self, at: usize) -> bool {
        let open = |&child: &usize| !self.tree[child].closed;
        let ended = self.tree[at].ended;
        let children = self.tree[at].children.iter().any(open);
        ended && (self.is_leaf(at) || !children && self.next_successor(at).is_none())
    }

    /// The open child with the largest upper confidence bound; of equal ones the first.
    fn best_child(&mut self, at: usize) -> Option<usize> {
        let children = self.tree[at].children.clone();
        for &child in &children {
            self.check(child);
        }
        let log = self.tree[at].visits.max(1.0).ln();
        let bound = |child: usize| {
            let node = &self.tree[child];
            let visits = node.visits.max(1.0);
            node.value / visits + EXPLORATION * (log / visits).sqrt()
        };
        let mut best: Option<(f64, usize)> = None;
        for child in children.into_iter().filter(|&c| !self.tree[c].closed) {
            let bound = bound(child);
            if best.is_none_or(|(most, _)| bound > most) {
                best = Some((bound, child));
            }
        }
        best.map(|(_, child)| child)
    }

    /// Closes a node that contains what has been rejected meanwhile.
    fn check(&mut self, at: usize) {
        let revision = self.walker.verdicts.revision;
        let node = &mut self.tree[at];
        if node.checked != revision {
            node.checked = revision;
            let path = states_along(&node.walk.edges);
            node.closed |= !self.walker.verdicts.is_alive(&path);
        }
    }

    /// Counts a visit of a node and of all before it.
    fn visit(&mut self, at: usize) {
        self.along(at, |node| node.visits += 1.0);
    }

    fn pay(&mut self, at: usize, reward: f64) {
        self.along(at, |node| node.value += reward);
    }

    fn along(&mut self, mut at: usize, change: impl Fn(&mut TreeNode)) {
        loop {
            change(&mut self.tree[at]);
            if at == 0 {
                return;
            }
            at = self.tree[at].parent;
        }
    }

    /// What a walk that ended before the goal is worth.
    fn dead_end(&mut self, walk: &Walk) -> f64 {
        let expansion = &mut self.walker.expansion;
        let root = expansion.graph.root();
        let mut behind = |node| expansion.behind(node).map_or(f64::INFINITY, phases);
        let (here, all) = (behind(walk.node), behind(root));
        DEAD_END * (1.0 - here / all.max(1.0)).max(0.0)
    }
}

impl Policy for TreeSearch {
    /// [`Status::Exhausted`] also if many simulations in a row found nothing new.
    fn next(&mut self, oracle: &mut dyn Oracle) -> Option<Sequence> {
        for n in 0..MAX_FAILURES {
            if n > 0 && oracle.pause() {
                self.status = Status::Stopped;
                return None;
            }
            if let Some(status) = self.walker.end(self.tree.len(), oracle) {
                self.status = status;
                return None;
            }
            self.status = Status::Running;
            if self.tree[0].closed || !self.walker.may_begin(oracle) {
                break;
            }
            let Walker {
                expansion,
                verdicts,
                ..
            } = &mut self.walker;
            expansion.look_ahead(verdicts, oracle);
            let Some((at, ends)) = self.select(oracle) else {
                continue;
            };
            let mut walk = self.tree[at].walk.clone();
            let complete = ends || self.walker.finish(&mut walk, oracle);
            if complete && walk.n_phases() == self.tree[at].walk.n_phases() {
                self.tree[at].ended = true;
            }
            if !complete && oracle.stop() {
                continue; // it might have gone on
            }
            let at = if walk.mended > self.tree[at].walk.edges.len() {
                self.graft(&walk)
            } else {
                at
            };
            self.visit(at);
            let path = states_along(&walk.edges);
            if complete && !self.returned.contains_key(&path) {
                self.returned.insert(path, at);
                return Some(self.walker.sequence(&walk));
            }
            let reward = self.dead_end(&walk);
            self.pay(at, if complete { 0.0 } else { reward });
        }
        self.status = Status::Exhausted;
        None
    }

    fn learn(&mut self, states: &[ContactState], reward: f64) {
        let graph = &mut self.walker.expansion.graph;
        let path: Vec<StateId> = states.iter().map(|state| graph.intern(state)).collect();
        if let Some(&at) = self.returned.get(&path) {
            self.pay(at, reward);
        }
    }

    /// Nodes of the same contact states, reached by different actions, count together.
    fn statistics(&self, states: &[ContactState]) -> Vec<Statistics> {
        let graph = &self.walker.expansion.graph;
        let mut out = Vec::new();
        let mut here = vec![0];
        for k in 0..states.len() {
            here.retain(|&at| *graph.state(self.tree[at].walk.node.state) == states[k]);
            let sum = |of: fn(&TreeNode) -> f64| here.iter().map(|&at| of(&self.tree[at])).sum();
            let (visits, value): (f64, f64) = (sum(|n| n.visits), sum(|n| n.value));
            if visits == 0.0 {
                break;
            }
            out.push(Statistics {
                visits: visits as u32,
                value: value / visits,
            });
            let children = here.iter().flat_map(|&at| &self.tree[at].children);
            here = children.copied().collect();
        }
        out
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
            created: self.tree.len(),
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
