//! The states of a task within an action limit, with their distances to the goal, and the plans through them.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use crate::error::SymbolicError;
use crate::task::{FactSet, Task};

/// Most states that are listed.
const STATE_LIMIT: usize = 1_000_000;

/// Actions beyond the shortest plan that the default limit allows: one more grasp, lift, place and release.
pub const DEFAULT_SLACK: usize = 4;

/// Index of a state in a [`TaskGraph`]; the start is 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TaskState(pub usize);

/// An edge of a [`TaskGraph`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TaskEdge {
    /// Index of the operator.
    pub operator: usize,
    /// Where it leads.
    pub to: TaskState,
}

/// All states that at most `max_actions` actions reach, and the edges between them.
#[derive(Debug, Clone)]
pub struct TaskGraph {
    states: Vec<FactSet>,
    depths: Vec<usize>,
    edges: Vec<Vec<TaskEdge>>,
    distances: Vec<Option<usize>>,
    max_actions: usize,
}

impl TaskGraph {
    /// Explores a task breadth first.
    ///
    /// `max_actions` is N; `None` takes the length of the shortest plan and four more, or lists everything within
    /// reach if no plan exists. Where several operators lead from one state to the same next state, the first counts.
    ///
    /// # Errors
    /// [`SymbolicError::TooManyStates`].
    pub fn explore(task: &Task, max_actions: Option<usize>) -> Result<Self, SymbolicError> {
        Self::explore_up_to(task, max_actions, STATE_LIMIT)
    }

    fn explore_up_to(
        task: &Task,
        max_actions: Option<usize>,
        limit: usize,
    ) -> Result<Self, SymbolicError> {
        let mut graph = Self {
            states: vec![task.start().clone()],
            depths: vec![0],
            edges: Vec::new(),
            distances: Vec::new(),
            max_actions: max_actions.unwrap_or(usize::MAX),
        };
        let mut index = BTreeMap::from([(task.start().clone(), TaskState(0))]);
        while graph.edges.len() < graph.states.len() {
            let n = graph.edges.len();
            if max_actions.is_none()
                && graph.max_actions == usize::MAX
                && task.goal().holds(&graph.states[n])
            {
                graph.max_actions = graph.depths[n] + DEFAULT_SLACK;
            }
            let edges = if graph.depths[n] < graph.max_actions {
                graph.expand(task, n, &mut index)
            } else {
                vec![]
            };
            graph.edges.push(edges);
            if graph.states.len() > limit {
                return Err(SymbolicError::TooManyStates { limit });
            }
        }
        if graph.max_actions == usize::MAX {
            graph.max_actions = 0; // no plan of any length
        }
        graph.measure_distances(task);
        Ok(graph)
    }

    fn expand(
        &mut self,
        task: &Task,
        n: usize,
        index: &mut BTreeMap<FactSet, TaskState>,
    ) -> Vec<TaskEdge> {
        let mut edges: Vec<TaskEdge> = Vec::new();
        for (operator, action) in task.operators().iter().enumerate() {
            let Some(next) = action.apply(&self.states[n]) else {
                continue;
            };
            let to = *index.entry(next).or_insert_with_key(|next| {
                self.states.push(next.clone());
                self.depths.push(self.depths[n] + 1);
                TaskState(self.states.len() - 1)
            });
            if !edges.iter().any(|edge| edge.to == to) {
                edges.push(TaskEdge { operator, to });
            }
        }
        edges
    }

    fn measure_distances(&mut self, task: &Task) {
        let mut sources: Vec<Vec<usize>> = vec![Vec::new(); self.states.len()];
        for (from, edges) in self.edges.iter().enumerate() {
            for edge in edges {
                sources[edge.to.0].push(from);
            }
        }
        self.distances = self
            .states
            .iter()
            .map(|state| task.goal().holds(state).then_some(0))
            .collect();
        let mut queue: VecDeque<usize> = (0..self.states.len())
            .filter(|&n| self.distances[n] == Some(0))
            .collect();
        while let Some(to) = queue.pop_front() {
            for &from in &sources[to] {
                if self.distances[from].is_none() {
                    self.distances[from] = self.distances[to].map(|d| d + 1);
                    queue.push_back(from);
                }
            }
        }
    }

    /// Takes edges out, given by their ends. States stay, also those that are out of reach then.
    pub(crate) fn remove(&mut self, task: &Task, edges: &BTreeSet<(TaskState, TaskState)>) {
        for (from, out) in self.edges.iter_mut().enumerate() {
            out.retain(|edge| !edges.contains(&(TaskState(from), edge.to)));
        }
        self.measure_distances(task);
    }

    /// Number of states within reach.
    pub fn n_states(&self) -> usize {
        self.states.len()
    }

    /// The facts of a state.
    pub fn facts(&self, state: TaskState) -> &FactSet {
        &self.states[state.0]
    }

    /// Edges out of a state, in the order of the operators, one per next state.
    pub fn edges(&self, state: TaskState) -> &[TaskEdge] {
        &self.edges[state.0]
    }

    /// Fewest actions from the start.
    pub fn depth(&self, state: TaskState) -> usize {
        self.depths[state.0]
    }

    /// Fewest actions to the goal; `None` if it is out of reach.
    pub fn distance(&self, state: TaskState) -> Option<usize> {
        self.distances[state.0]
    }

    /// Largest number of actions N of a plan.
    pub fn max_actions(&self) -> usize {
        self.max_actions
    }

    /// True if a plan may be in this state after `used` actions: the goal is within what remains of N.
    pub fn may_reach_goal(&self, state: TaskState, used: usize) -> bool {
        self.distance(state)
            .is_some_and(|distance| used + distance <= self.max_actions)
    }

    /// All plans of at most N actions, shortest first: no state twice, ending at the first goal state, none twice.
    pub fn plans(&self) -> Plans<'_> {
        Plans {
            graph: self,
            length: self.distance(TaskState(0)).unwrap_or(usize::MAX),
            path: Vec::new(),
        }
    }
}

/// Iterator over the plans of a [`TaskGraph`]: depth-first search with increasing length, bounded by the distances.
#[derive(Debug)]
pub struct Plans<'g> {
    graph: &'g TaskGraph,
    /// Length of the plans that are being listed.
    length: usize,
    /// Per action of the current plan: the state before it and the next edge to try there.
    path: Vec<(TaskState, usize)>,
}

impl Iterator for Plans<'_> {
    type Item = Vec<TaskEdge>;

    fn next(&mut self) -> Option<Self::Item> {
        while self.length <= self.graph.max_actions {
            if self.path.is_empty() {
                if self.length == 0 {
                    self.length = usize::MAX; // the start satisfies the goal: the empty plan is the only one
                    return Some(Vec::new());
                }
                self.path.push((TaskState(0), 0));
            }
            if let Some(plan) = self.advance() {
                return Some(plan);
            }
            self.length += 1;
        }
        None
    }
}

impl Plans<'_> {
    /// Goes on with the depth-first search until a plan of the current length is found or none is left.
    fn advance(&mut self) -> Option<Vec<TaskEdge>> {
        while let Some((state, edge)) = self.path.last_mut() {
            let Some(&TaskEdge { to, .. }) = self.graph.edges(*state).get(*edge) else {
                self.path.pop();
                continue;
            };
            *edge += 1;
            let remaining = self.length - self.path.len();
            let near = self
                .graph
                .distance(to)
                .is_some_and(|d| d <= remaining && (d == 0) == (remaining == 0));
            if !near || self.path.iter().any(|&(visited, _)| visited == to) {
                continue;
            }
            if remaining == 0 {
                return Some(
                    self.path
                        .iter()
                        .map(|&(state, next)| self.graph.edges(state)[next - 1])
                        .collect(),
                );
            }
            self.path.push((to, 0));
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::task::{Change, Condition, Fact, Operator};

    #[test]
    fn too_many_states_are_refused_with_the_limit() {
        let switch = |n: usize| Operator {
            label: format!("switch {n}"),
            requires: Condition::always(),
            changes: vec![Change {
                adds: vec![Fact(n)],
                ..Change::default()
            }],
        };
        let facts = (0..5).map(|n| format!("on {n}")).collect();
        let goal = Condition::all((0..5).map(|n| Condition::Holds(Fact(n))));
        let operators = (0..5).map(switch).collect();
        let task =
            Task::new(facts, operators, FactSet::default(), goal).expect("the task is valid");
        let error = TaskGraph::explore_up_to(&task, None, 31).expect_err("there are 32 states");
        assert_eq!(
            error.to_string(),
            "more than 31 manipulation states within reach; lower the largest number of skeleton actions"
        );
        let graph = TaskGraph::explore_up_to(&task, None, 32).expect("32 states fit");
        assert_eq!(graph.plans().count(), 120, "5! orders of five switches");
    }
}
