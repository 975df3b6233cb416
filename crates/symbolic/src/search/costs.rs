//! The order in which sequences come: one unit per phase, and penalties that put natural motions first.
//!
//! Penalties order, they forbid nothing: any legal sequence comes sooner or later. A foot swing takes two phases, so
//! with the default of 2.2 an oddity comes just after the plain sequences with one more swing.

use crate::action::Action;
use crate::carried::{is_carried, stands};
use crate::contact::{Contact, ContactState, InterfaceId};
use crate::domain::Role;
use crate::graph::{Node, SkeletonGraph, StateId};

/// One step of a sequence, for cost functions.
#[derive(Debug)]
pub struct Step<'g> {
    /// The graph, for names and states.
    pub graph: &'g SkeletonGraph,
    /// The node before.
    pub from: Node,
    /// The node after.
    pub to: Node,
    /// What breaks and what is made.
    pub action: Action,
    /// True if a skeleton action is taken.
    pub advances: bool,
    /// The foot that was lifted last before this step.
    pub last_foot: Option<InterfaceId>,
}

/// A cost beside [`Costs`]; negative values count as zero, so that no step costs less than a phase.
pub type ExtraCost = Box<dyn Fn(&Step<'_>) -> f64 + Send>;

/// A cost of the caller's for ending in a state; negative values count as zero.
pub type EndCost = Box<dyn Fn(&SkeletonGraph, &ContactState) -> f64 + Send>;

/// Costs of a sequence, in phases.
#[derive(Debug, Clone, PartialEq)]
pub struct Costs {
    /// Every phase after the first.
    pub phase: f64,
    /// Every change of a free interface that comes together with another change.
    pub simultaneous: f64,
    /// Every phase in which nothing carries the robot: no foot on what stands, no hand on a static body; and every landing of
    /// a foot on an object that is in the air itself.
    pub flight: f64,
    /// Every supporting contact that a free hand makes, or keeps when it lets go.
    pub hand_support: f64,
    /// Every landing of a foot on a surface that carries no foot at the start.
    pub new_surface: f64,
    /// Every skeleton action while a foot that stands at the start is in the air.
    pub manipulate_in_swing: f64,
    /// Every change of a foot while a held object rests: walking is done before the grasp or with the lifted object.
    pub step_in_grasp: f64,
    /// Lifting the foot that was lifted last.
    pub same_foot: f64,
    /// Every skeleton action that does not bring the goal nearer.
    pub detour: f64,
    /// Placing an object on a surface of its own on which it does not rest at the start.
    pub turn: f64,
    /// At the end, every foot in the air that stands at the start.
    pub end_in_swing: f64,
}

/// A little more than one foot swing [phases].
const ODDITY: f64 = 2.2;
/// As much as six foot swings [phases]: a jump is for where nothing else leads.
const FLIGHT: f64 = 12.0;

impl Default for Costs {
    fn default() -> Self {
        Self {
            phase: 1.0,
            simultaneous: ODDITY + 1.0, // it saves a phase
            flight: FLIGHT,
            hand_support: ODDITY + 1.0,
            new_surface: ODDITY,
            manipulate_in_swing: ODDITY,
            step_in_grasp: ODDITY / 2.0, // per change, so twice for a swing
            same_foot: ODDITY,
            detour: ODDITY / 2.0,
            turn: ODDITY,
            end_in_swing: 2.0 * ODDITY,
        }
    }
}

impl Costs {
    /// The number of phases and nothing else.
    pub fn phases_only() -> Self {
        Self {
            phase: 1.0,
            simultaneous: 0.0,
            flight: 0.0,
            hand_support: 0.0,
            new_surface: 0.0,
            manipulate_in_swing: 0.0,
            step_in_grasp: 0.0,
            same_foot: 0.0,
            detour: 0.0,
            turn: 0.0,
            end_in_swing: 0.0,
        }
    }

    /// Cost of one step, at least one phase.
    pub fn step(&self, step: &Step<'_>) -> f64 {
        let graph = step.graph;
        let (before, after) = (graph.state(step.from.state), graph.state(step.to.state));
        let free = free_changes(step);
        let feet: Vec<&Contact> = free
            .iter()
            .filter(|c| graph.domain().is_effector(c.a, Role::Foot))
            .collect();
        let count = |n: usize| n as f64;
        let mut cost = self.phase;
        cost +=
            self.simultaneous * count((free.len() + usize::from(step.advances)).saturating_sub(1));
        cost += if is_carried(graph.domain(), after) {
            0.0
        } else {
            self.flight
        };
        let on_loose = |c: &&&Contact| after.contains(c) && !stands(graph.domain(), after, c.b);
        cost += self.flight * count(feet.iter().filter(on_loose).count());
        let kept = graph.kept(step.from, step.to).count();
        cost +=
            self.hand_support * count(kept + free.len() - feet.len() - hand_breaks(step, &free));
        cost += self.new_surface
            * count(
                feet.iter()
                    .filter(|c| is_new_surface(graph, after, c))
                    .count(),
            );
        if graph.holds_resting(step.to.position) {
            cost += self.step_in_grasp * count(feet.len());
        }
        if step.advances {
            let in_swing = swinging(graph, before).max(swinging(graph, after));
            cost += if in_swing > 0 {
                self.manipulate_in_swing
            } else {
                0.0
            };
            cost += if is_detour(step) { self.detour } else { 0.0 };
            cost += self.turn
                * count(
                    step.action
                        .makes
                        .iter()
                        .filter(|c| is_turn(graph, c))
                        .count(),
                );
        }
        let lifted_again = feet
            .iter()
            .any(|c| before.contains(c) && step.last_foot == Some(c.a));
        cost + if lifted_again { self.same_foot } else { 0.0 }
    }

    /// Cost of ending in a state.
    pub fn end(&self, graph: &SkeletonGraph, state: StateId) -> f64 {
        self.end_in_swing * swinging(graph, graph.state(state)) as f64
    }
}

/// The changes of interfaces that the skeleton leaves free.
fn free_changes(step: &Step<'_>) -> Vec<Contact> {
    let now = step.graph.imposed(step.from.position);
    let next = step.graph.imposed(step.to.position);
    step.action
        .changes()
        .filter(|c| now.contains(c) == next.contains(c))
        .collect()
}

/// Free changes of hands that break contact.
fn hand_breaks(step: &Step<'_>, free: &[Contact]) -> usize {
    let is_hand_break = |c: &&Contact| {
        !step.graph.domain().is_effector(c.a, Role::Foot) && step.action.breaks.contains(c)
    };
    free.iter().filter(is_hand_break).count()
}

fn is_new_surface(graph: &SkeletonGraph, after: &ContactState, contact: &Contact) -> bool {
    let start = graph.state(graph.root().state);
    let familiar = start
        .landed_on(contact.b)
        .any(|c| graph.domain().is_effector(c.a, Role::Foot));
    after.contains(contact) && !familiar
}

/// Number of feet in the air that stand at the start.
fn swinging(graph: &SkeletonGraph, state: &ContactState) -> usize {
    let start = graph.state(graph.root().state);
    let feet = graph
        .domain()
        .effectors()
        .filter(|&i| graph.domain().is_effector(i, Role::Foot));
    feet.filter(|&foot| start.partner(foot).is_some() && state.partner(foot).is_none())
        .count()
}

fn is_detour(step: &Step<'_>) -> bool {
    let skeletons = step.graph.skeletons();
    let (before, after) = (
        skeletons.distance(step.from.position),
        skeletons.distance(step.to.position),
    );
    before.is_some_and(|d| d > 0) && after >= before
}

fn is_turn(graph: &SkeletonGraph, made: &Contact) -> bool {
    graph.domain().object_of(made.a).is_some()
        && graph.state(graph.root().state).partner(made.a).is_none()
}
