//! Bounds of a search, where sequences end, and how a search ends.

use crate::goal::GoalPair;
use crate::graph::SkeletonGraph;
use crate::task_graph::{DEFAULT_SLACK, TaskState};

/// Where a sequence is complete.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// In the first state that satisfies the goal.
    First,
    /// In every state that satisfies the goal; longer sequences go on from it.
    Every,
    /// After K_max phases, in a state that satisfies the goal: the paper's search with an empty goal.
    Full,
}

/// Bounds of a search; `None` is derived from the graph.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SearchLimits {
    /// Largest number of phases K_max, the start counted; default [`default_phases`].
    pub max_phases: Option<usize>,
    /// Phases below which the goal can hardly be reached, whatever the symbols say: to end with fewer costs what these lack.
    pub likely_phases: usize,
    /// Where sequences end; default [`Ending::Full`] for an empty goal, otherwise [`Ending::First`].
    pub ending: Option<Ending>,
    /// Most beginnings of sequences that are kept in memory (about 150 bytes each), then the search ends.
    pub max_nodes: usize,
}

impl Default for SearchLimits {
    fn default() -> Self {
        Self {
            max_phases: None,
            likely_phases: 1,
            ending: None,
            max_nodes: 2_000_000,
        }
    }
}

/// Limits with everything filled in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    pub(crate) max_phases: usize,
    pub(crate) likely_phases: usize,
    pub(crate) ending: Ending,
    pub(crate) max_nodes: usize,
}

impl SearchLimits {
    pub(crate) fn resolve(&self, graph: &SkeletonGraph) -> Bounds {
        let natural = if graph.goal().pairs.is_empty() {
            Ending::Full
        } else {
            Ending::First
        };
        Bounds {
            max_phases: self.max_phases.unwrap_or_else(|| default_phases(graph)),
            likely_phases: self.likely_phases,
            ending: self.ending.unwrap_or(natural),
            max_nodes: self.max_nodes,
        }
    }
}

/// The default of K_max: 1 + n + 8 ⌈n/4⌉ + 4 r.
///
/// n is the length of the shortest skeleton, 4 (one grasp, lift, place, release) if none is needed but an object can
/// be grasped; each four skeleton actions come with four foot swings (two steps to the object, two with it), of two
/// phases each. r is the number of goal pairs of the robot that the start does not hold: two swings each. An empty
/// goal gets r = 2.
pub fn default_phases(graph: &SkeletonGraph) -> usize {
    let domain = graph.domain();
    let start = graph.state(graph.root().state);
    let movable = !graph.skeletons().edges(TaskState(0)).is_empty();
    let n = match graph.shortest_skeleton() {
        Some(0) | None if movable => DEFAULT_SLACK,
        length => length.unwrap_or(0),
    };
    let of_robot = |pair: &&GoalPair| {
        let object_or_static = |id| !domain.effectors().any(|i| i == id);
        !object_or_static(pair.a) || !object_or_static(pair.b)
    };
    let open = graph
        .goal()
        .pairs
        .iter()
        .filter(of_robot)
        .filter(|pair| !pair.holds(start))
        .count();
    let r = if graph.goal().pairs.is_empty() {
        2
    } else {
        open
    };
    1 + n + 8 * n.div_ceil(4) + 4 * r
}

/// How far a search is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// More may come.
    Running,
    /// Every sequence within the limits has been returned or rejected, or left out by a tree search since steps did not help those like it.
    Exhausted,
    /// Every order of manipulation actions needs contacts that were rejected; steps of the feet do not change that.
    NoSkeleton,
    /// The limit on memory is reached.
    Full,
    /// The oracle asked to stop or pause; the next call resumes.
    Stopped,
}
