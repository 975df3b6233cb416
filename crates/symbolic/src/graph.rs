//! The skeleton-constrained graph: contact states together with the position in the manipulation skeletons.
//!
//! Source: paper, "Manipulation skeleton" and its figure. A node is a contact state s and a position: the
//! manipulation state that the skeleton has reached. An action either stays at the position ("current") or takes one
//! skeleton action ("next"), so it may be repeated: *lift* lasts while the feet walk. The position imposes the
//! contacts of the objects and of the hands that hold them; all other interfaces of the robot are free ("?").
//!
//! All skeletons of at most N actions share this graph: a path of positions without repetition from which the goal
//! is still within N actions is the beginning of a skeleton, see [`SkeletonGraph::may_advance`].

use std::collections::{BTreeMap, BTreeSet};

use crate::action::Action;
use crate::carried::is_carried;
use crate::contact::{Contact, ContactState, InterfaceId};
use crate::domain::{Domain, Role};
use crate::error::SymbolicError;
use crate::goal::Goal;
use crate::manipulation::Manipulation;
use crate::state_rules::{both_sides, state_fault, two_partners};
use crate::successors::{Change, changes_of, combine};
use crate::task::{Fact, FactSet};
use crate::task_graph::{TaskGraph, TaskState};
use crate::transition_rules::transition_fault;

/// What the graph contains.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GraphOptions {
    /// Most contact changes per action of interfaces that the skeleton leaves free, beside the skeleton's own.
    pub max_changes: usize,
    /// May hands that hold nothing make supporting contacts.
    pub support_hands: bool,
    /// May the robot be in the air, carried by nothing ([`is_carried`]).
    pub flights: bool,
    /// Largest number of skeleton actions N; `None`: the shortest skeleton and four more.
    pub max_actions: Option<usize>,
    /// Must the objects of the goal be released at the end, except by grasps that the goal names.
    pub release_at_end: bool,
}

impl Default for GraphOptions {
    fn default() -> Self {
        Self {
            max_changes: 1,
            support_hands: true,
            flights: true,
            max_actions: None,
            release_at_end: true,
        }
    }
}

/// Index of a contact state that the graph has met; the start is 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct StateId(pub usize);

/// A node: a contact state at a skeleton position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Node {
    /// The contact state.
    pub state: StateId,
    /// The manipulation state that the skeleton has reached.
    pub position: TaskState,
}

/// An edge: where an action leads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Successor {
    /// The node behind the edge.
    pub node: Node,
    /// The skeleton action taken, by its index in [`crate::Task::operators`]; `None` if the position stays.
    pub operator: Option<usize>,
}

/// What a skeleton position imposes.
#[derive(Debug, Clone)]
struct Position {
    imposed: ContactState,
    /// Robot interfaces that hold objects.
    engaged: BTreeSet<InterfaceId>,
    /// Some object is held and rests at the same time.
    holds_resting: bool,
    /// Objects that have not left their places of the start, as far as the task remembers that.
    unmoved: Vec<usize>,
}

/// The graph of all contact sequences that follow a skeleton; nodes are found lazily.
#[derive(Debug, Clone)]
pub struct SkeletonGraph {
    domain: Domain,
    goal: Goal,
    options: GraphOptions,
    manipulation: Manipulation,
    skeletons: TaskGraph,
    positions: Vec<Position>,
    /// Per robot interface the contacts that it may make while it is free.
    free_landings: BTreeMap<InterfaceId, Vec<Contact>>,
    facts_of: BTreeMap<Contact, Vec<Fact>>,
    states: Vec<ContactState>,
    index: BTreeMap<ContactState, StateId>,
}

impl SkeletonGraph {
    /// Builds the graph with the built-in operators.
    ///
    /// # Errors
    /// An illegal start, an impossible goal, or too many manipulation states. A goal that no skeleton reaches is no
    /// error: [`SkeletonGraph::shortest_skeleton`] is then `None` and every search ends empty.
    pub fn new(
        domain: Domain,
        start: ContactState,
        goal: Goal,
        options: GraphOptions,
    ) -> Result<Self, SymbolicError> {
        check_start(&domain, &start)?;
        goal.check(&domain)?;
        let manipulation = Manipulation::builtin(&domain, &start, &goal, options.release_at_end)?;
        Self::with_manipulation(domain, start, goal, options, manipulation)
    }

    /// Builds the graph with operators of the caller's.
    ///
    /// # Errors
    /// As [`SkeletonGraph::new`]; the start of the task must hold exactly the facts whose contacts the start holds.
    pub fn with_manipulation(
        domain: Domain,
        start: ContactState,
        goal: Goal,
        options: GraphOptions,
        manipulation: Manipulation,
    ) -> Result<Self, SymbolicError> {
        check_start(&domain, &start)?;
        goal.check(&domain)?;
        let skeletons = TaskGraph::explore(&manipulation.task, options.max_actions)?;
        let mut facts_of: BTreeMap<Contact, Vec<Fact>> = BTreeMap::new();
        for (n, contacts) in manipulation.meaning.iter().enumerate() {
            for &contact in contacts {
                facts_of.entry(contact).or_default().push(Fact(n));
            }
        }
        let positions = (0..skeletons.n_states())
            .map(|n| position(&domain, &manipulation, skeletons.facts(TaskState(n))))
            .collect();
        let free_landings = domain
            .effectors()
            .map(|i| {
                (
                    i,
                    free_landings(&domain, i, &options, &manipulation, &facts_of),
                )
            })
            .collect();
        let index = BTreeMap::from([(start.clone(), StateId(0))]);
        let states = vec![start];
        Ok(Self {
            domain,
            goal,
            options,
            manipulation,
            skeletons,
            positions,
            free_landings,
            facts_of,
            states,
            index,
        })
    }

    /// Takes skeleton actions out that the caller knows to be impossible, given by the positions that they join. To be called
    /// before a search begins.
    pub fn remove_actions(&mut self, between: &BTreeSet<(TaskState, TaskState)>) {
        self.skeletons.remove(&self.manipulation.task, between);
    }

    /// The node of the start state.
    pub fn root(&self) -> Node {
        Node {
            state: StateId(0),
            position: TaskState(0),
        }
    }

    /// The domain.
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    /// The goal.
    pub fn goal(&self) -> &Goal {
        &self.goal
    }

    /// The options.
    pub fn options(&self) -> &GraphOptions {
        &self.options
    }

    /// The manipulation task: facts and operators.
    pub fn manipulation(&self) -> &Manipulation {
        &self.manipulation
    }

    /// The manipulation states and the skeletons through them.
    pub fn skeletons(&self) -> &TaskGraph {
        &self.skeletons
    }

    /// The contact state of that index.
    pub fn state(&self, id: StateId) -> &ContactState {
        &self.states[id.0]
    }

    /// Index of a contact state, new if it has not been met.
    pub fn intern(&mut self, state: &ContactState) -> StateId {
        if let Some(&id) = self.index.get(state) {
            return id;
        }
        let id = StateId(self.states.len());
        self.index.insert(state.clone(), id);
        self.states.push(state.clone());
        id
    }

    /// Number of contact states met so far.
    pub fn n_states(&self) -> usize {
        self.states.len()
    }

    /// Length of the shortest skeleton that reaches the goal; `None` if there is none within N actions.
    pub fn shortest_skeleton(&self) -> Option<usize> {
        let start = TaskState(0);
        if self.skeletons.may_reach_goal(start, 0) {
            self.skeletons.distance(start)
        } else {
            None
        }
    }

    /// True if the node satisfies the goal: s_g ⊆ s, and the skeleton's own goal (objects released).
    pub fn is_goal(&self, node: Node) -> bool {
        let facts = self.skeletons.facts(node.position);
        self.manipulation.task.goal().holds(facts) && self.goal.holds(self.state(node.state))
    }

    /// A lower bound on the number of phases from the node to the goal; `None` if no skeleton leads there.
    pub fn remaining(&self, node: Node) -> Option<usize> {
        let distance = self.skeletons.distance(node.position)?;
        Some(distance.max(usize::from(!self.goal.holds(self.state(node.state)))))
    }

    /// True if a skeleton that has visited these positions, in order, may take an action that leads to `to`: no
    /// position twice, and the goal within what remains of the N actions.
    pub fn may_advance(&self, visited: &[TaskState], to: TaskState) -> bool {
        !visited.contains(&to) && self.skeletons.may_reach_goal(to, visited.len())
    }

    /// The contacts that a skeleton position imposes.
    pub fn imposed(&self, position: TaskState) -> &ContactState {
        &self.positions[position.0].imposed
    }

    /// True if at this position some object is held while it rests on a support.
    pub fn holds_resting(&self, position: TaskState) -> bool {
        self.positions[position.0].holds_resting
    }

    /// Objects that are still where they are at the start, as far as the task remembers that (`moved` of the PDDL domain).
    pub fn unmoved(&self, position: TaskState) -> &[usize] {
        &self.positions[position.0].unmoved
    }

    /// Robot interfaces that the position leaves free.
    pub fn free_interfaces(&self, position: TaskState) -> impl Iterator<Item = InterfaceId> + '_ {
        self.free_landings
            .keys()
            .copied()
            .filter(move |i| !self.positions[position.0].engaged.contains(i))
    }

    /// The contacts that free robot interfaces may make at a position.
    pub fn free_contacts(&self, position: TaskState) -> impl Iterator<Item = Contact> + '_ {
        self.free_interfaces(position)
            .flat_map(|i| self.free_landings[&i].iter().copied())
    }

    /// True if the state satisfies what the position imposes, and holds no other fact of the task: a second grasp
    /// cannot arise from support contacts.
    pub fn satisfies(&self, state: &ContactState, position: TaskState) -> bool {
        let facts = self.skeletons.facts(position);
        let complete = |fact: &Fact| {
            self.manipulation.meaning[fact.0]
                .iter()
                .all(|contact| state.contains(contact))
        };
        let mut touched = state
            .iter()
            .filter_map(|contact| self.facts_of.get(&contact))
            .flatten();
        self.imposed(position).is_subset(state)
            && !touched.any(|fact| !facts.contains(*fact) && complete(fact))
    }

    /// The legal actions from a node, those of the skeleton first, in the order of its operators.
    ///
    /// What depends on the path ([`SkeletonGraph::may_advance`], the number of phases) is left to the caller.
    pub fn successors(&mut self, node: Node) -> Vec<Successor> {
        let mut found = Vec::new();
        for edge in self.skeletons.edges(node.position) {
            self.collect(node, edge.to, Some(edge.operator), &mut found);
        }
        self.collect(node, node.position, None, &mut found);
        found
            .into_iter()
            .map(|(state, position, operator)| Successor {
                node: Node {
                    state: self.intern(&state),
                    position,
                },
                operator,
            })
            .collect()
    }

    fn collect(
        &self,
        node: Node,
        to: TaskState,
        operator: Option<usize>,
        found: &mut Vec<(ContactState, TaskState, Option<usize>)>,
    ) {
        let from = self.state(node.state);
        let (now, next) = (&self.positions[node.position.0], &self.positions[to.0]);
        let sides: Vec<Vec<Change>> = self
            .free_interfaces(node.position)
            .filter(|i| !next.engaged.contains(i))
            .map(|i| changes_of(from, i, &self.free_landings[&i]))
            .filter(|changes| !changes.is_empty())
            .collect();
        for kept in self.kept_on_release(now, next) {
            let stays = |c: &Contact| {
                !now.imposed.contains(c) || next.imposed.contains(c) || kept.contains(c)
            };
            let mut base: ContactState = from.iter().filter(stays).collect();
            base.contacts.extend(next.imposed.iter());
            if two_partners(&base).is_some() {
                return; // a hand that is to grasp still supports elsewhere
            }
            for count in 0..=self.options.max_changes.min(sides.len()) {
                combine(&base, &sides, count, &mut |state| {
                    let legal = both_sides(&state).is_none()
                        && transition_fault(from, &state).is_none()
                        && (self.options.flights || is_carried(&self.domain, &state));
                    if legal && self.satisfies(&state, to) {
                        found.push((state, to, operator));
                    }
                });
            }
        }
    }

    /// The sets of contacts that hands may keep as supports when a grasp of several hands ends; first the empty set.
    fn kept_on_release(&self, now: &Position, next: &Position) -> Vec<Vec<Contact>> {
        let keepable = |c: &Contact| {
            self.free_landings
                .get(&c.a)
                .is_some_and(|landings| landings.contains(c))
        };
        let released = now
            .imposed
            .iter()
            .filter(|c| !next.imposed.contains(c) && keepable(c));
        let mut sets = vec![Vec::new()];
        for contact in released {
            let more: Vec<Vec<Contact>> = sets
                .iter()
                .map(|set| [set.as_slice(), &[contact]].concat())
                .collect();
            sets.extend(more);
        }
        sets
    }

    /// The action of an edge, in words: the skeleton's action, then the changes of free interfaces.
    pub fn label(&self, from: Node, edge: &Successor) -> String {
        let mut action = Action::between(self.state(from.state), self.state(edge.node.state));
        let Some(operator) = edge.operator else {
            return action.describe(&self.domain);
        };
        let (now, next) = (
            self.imposed(from.position),
            self.imposed(edge.node.position),
        );
        let own = |contact: &Contact| now.contains(contact) != next.contains(contact);
        action.breaks.retain(|contact| !own(contact));
        action.makes.retain(|contact| !own(contact));
        let mut words = vec![self.manipulation.task.operators()[operator].label.clone()];
        words.extend(
            self.kept(from, edge.node)
                .map(|c| format!("{} stays", self.domain.contact_name(&c))),
        );
        words.extend((!action.is_empty()).then(|| action.describe(&self.domain)));
        words.join(", ")
    }

    /// Contacts of a grasp that ends between the nodes while a hand keeps its contact as a support.
    pub fn kept(&self, from: Node, to: Node) -> impl Iterator<Item = Contact> + '_ {
        let (next, after) = (self.imposed(to.position), self.state(to.state));
        self.imposed(from.position)
            .iter()
            .filter(|c| !next.contains(c) && after.contains(c))
    }
}

fn check_start(domain: &Domain, start: &ContactState) -> Result<(), SymbolicError> {
    let count = domain.interfaces().len();
    if let Some(id) = start
        .iter()
        .flat_map(|c| [c.a, c.b])
        .find(|id| id.0 >= count)
    {
        return Err(SymbolicError::UnknownInterface { index: id.0, count });
    }
    let fault = state_fault(domain, start);
    fault.map_or(Ok(()), |fault| {
        Err(SymbolicError::IllegalStart {
            fault: fault.describe(domain),
        })
    })
}

fn position(domain: &Domain, manipulation: &Manipulation, facts: &FactSet) -> Position {
    let imposed = manipulation.imposed(facts);
    let engaged = imposed
        .iter()
        .map(|c| c.a)
        .filter(|&i| domain.object_of(i).is_none())
        .collect::<BTreeSet<_>>();
    let resting: BTreeSet<usize> = imposed
        .iter()
        .filter_map(|c| domain.object_of(c.a))
        .collect();
    let held = imposed
        .iter()
        .filter(|c| engaged.contains(&c.a))
        .filter_map(|c| domain.object_of(c.b));
    let holds_resting = held.into_iter().any(|object| resting.contains(&object));
    let moved = manipulation.moved.iter().enumerate();
    let unmoved = moved.filter(|(_, fact)| fact.is_some_and(|fact| !facts.contains(fact)));
    Position {
        unmoved: unmoved.map(|(object, _)| object).collect(),
        imposed,
        engaged,
        holds_resting,
    }
}

/// Feet land anywhere; other robot interfaces support, but a contact that alone is a fact belongs to the skeleton.
fn free_landings(
    domain: &Domain,
    interface: InterfaceId,
    options: &GraphOptions,
    manipulation: &Manipulation,
    facts_of: &BTreeMap<Contact, Vec<Fact>>,
) -> Vec<Contact> {
    if !domain.is_effector(interface, Role::Foot) && !options.support_hands {
        return Vec::new();
    }
    let alone = |contact: &Contact| {
        facts_of.get(contact).is_some_and(|facts| {
            facts
                .iter()
                .any(|fact| manipulation.meaning[fact.0].len() == 1)
        })
    };
    domain
        .landings(interface)
        .iter()
        .filter(|contact| !alone(contact))
        .copied()
        .collect()
}
