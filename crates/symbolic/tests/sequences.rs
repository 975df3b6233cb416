//! Complete sequences of small problems against brute force over the graph without skeletons.

use std::collections::BTreeSet;

use crate::fixtures::{bottom, handle, id, interface, state, surface};
use symbolic::search::AcceptAll;
use symbolic::{
    BestFirst, ContactState, ContactType, Costs, Domain, Goal, GraphOptions, Owner, Policy, Role,
    Rollouts, SearchLimits, SkeletonGraph, TaskState, successors,
};

/// One foot, one or two hands, one box with a handle or two opposite sides, ground and table.
fn small(squeezed: bool) -> Domain {
    let hand = |name| {
        let kinds = [ContactType::UnilateralPatch, ContactType::BilateralPatch];
        interface(name, Owner::Robot, Role::Hand, &kinds)
    };
    let mut interfaces = vec![
        interface(
            "foot",
            Owner::Robot,
            Role::Foot,
            &[ContactType::UnilateralPatch],
        ),
        hand("hand"),
    ];
    if squeezed {
        interfaces.push(hand("other_hand"));
    }
    interfaces.push(bottom("box_bottom", 0));
    let first = symbolic::InterfaceId(interfaces.len());
    let squeezes = if squeezed {
        interfaces.push(surface("box_left", Owner::Object(0)));
        interfaces.push(surface("box_right", Owner::Object(0)));
        vec![(first, symbolic::InterfaceId(first.0 + 1))]
    } else {
        interfaces.push(handle("box_handle", 0));
        vec![]
    };
    interfaces.push(surface("ground", Owner::Static(0)));
    interfaces.push(surface("table", Owner::Static(1)));
    Domain::new(interfaces, vec!["box".into()], squeezes).expect("the domain is valid")
}

/// The contacts that a skeleton decides: those of the box, handles held, and opposite sides held by two hands.
fn decided(domain: &Domain, state: &ContactState) -> ContactState {
    let object = |id| domain.object_of(id).is_some();
    let squeezed = |c: &symbolic::Contact| {
        let opposite = |pair: &(symbolic::InterfaceId, symbolic::InterfaceId)| {
            let other = if pair.0 == c.b {
                Some(pair.1)
            } else if pair.1 == c.b {
                Some(pair.0)
            } else {
                None
            };
            other.is_some_and(|other| {
                state
                    .iter()
                    .any(|d| d.b == other && domain.is_effector(d.a, Role::Hand) && d.a != c.a)
            })
        };
        domain.is_effector(c.a, Role::Hand) && domain.squeezes().iter().any(opposite)
    };
    state
        .iter()
        .filter(|c| object(c.a) || (object(c.b) && !c.kind.is_unilateral()) || squeezed(c))
        .collect()
}

/// Every sequence of at most `max_phases` states that follows one of the skeletons, by the paper's words: each state
/// satisfies the contact pairs of the current or the next action; at most `max_changes` free interfaces change.
fn brute_force(graph: &SkeletonGraph, max_phases: usize) -> BTreeSet<Vec<ContactState>> {
    let domain = graph.domain();
    let imposed = |state: TaskState| graph.imposed(state).clone();
    let mut found = BTreeSet::new();
    for plan in graph.skeletons().plans() {
        let mut skeleton = vec![imposed(TaskState(0))];
        skeleton.extend(plan.iter().map(|edge| imposed(edge.to)));
        let start = graph.state(graph.root().state).clone();
        let mut stack = vec![(vec![start], 0)];
        while let Some((path, position)) = stack.pop() {
            let from = path.last().expect("the start is there");
            if position + 1 == skeleton.len() && graph.goal().holds(from) {
                found.insert(path);
                continue;
            }
            if path.len() == max_phases {
                continue;
            }
            for (action, to) in successors(domain, from, 8) {
                let Some(next) = (position..=position + 1).find(|&n| {
                    skeleton
                        .get(n)
                        .is_some_and(|imposed| *imposed == decided(domain, &to))
                }) else {
                    continue;
                };
                let own = |c: &symbolic::Contact| {
                    skeleton[position].contains(c) != skeleton[next].contains(c)
                };
                let free = action.changes().filter(|c| !own(c)).count();
                let hands = |c: &symbolic::Contact| {
                    graph.options().support_hands || domain.is_effector(c.a, Role::Foot)
                };
                let mut lost = skeleton[position]
                    .iter()
                    .filter(|c| !skeleton[next].contains(c));
                let supports = action.makes.iter().all(|c| hands(c) || own(c))
                    && lost.all(|c| hands(&c) || !to.contains(&c));
                if free <= graph.options().max_changes && supports {
                    let mut longer = path.clone();
                    longer.push(to);
                    stack.push((longer, next));
                }
            }
        }
    }
    found
}

fn graph(squeezed: bool, max_changes: usize, support_hands: bool) -> SkeletonGraph {
    let domain = small(squeezed);
    let start = state(&domain, "foot on ground, box_bottom on ground");
    let goal = Goal::of_pairs([(id(&domain, "table"), id(&domain, "box_bottom"))]);
    let options = GraphOptions {
        max_changes,
        support_hands,
        max_actions: Some(4),
        ..GraphOptions::default()
    };
    SkeletonGraph::new(domain, start, goal, options).expect("the problem is valid")
}

fn compare(squeezed: bool, max_changes: usize, support_hands: bool, max_phases: usize) {
    let expected = brute_force(&graph(squeezed, max_changes, support_hands), max_phases);
    let limits = SearchLimits {
        max_phases: Some(max_phases),
        ..SearchLimits::default()
    };
    for costs in [Costs::default(), Costs::phases_only()] {
        let mut search =
            BestFirst::new(graph(squeezed, max_changes, support_hands), &limits, costs);
        let mut found = Vec::new();
        let mut last = 0.0;
        while let Some(sequence) = search.next(&mut AcceptAll) {
            assert!(sequence.cost >= last, "in order of cost");
            assert_eq!(sequence.labels.len(), sequence.states.len());
            last = sequence.cost;
            found.push(sequence.states);
        }
        let count = found.len();
        let found: BTreeSet<_> = found.into_iter().collect();
        assert_eq!(found.len(), count, "none twice");
        let missed = expected.difference(&found).next();
        assert!(missed.is_none(), "missed {missed:?}");
        assert_eq!(found.len(), expected.len(), "none too many");
    }
    assert!(expected.len() > 3, "{} sequences", expected.len());
}

#[test]
fn sequences_with_a_handle_are_those_of_brute_force() {
    compare(false, 1, true, 7);
    compare(false, 2, true, 6);
}

#[test]
fn sequences_without_support_hands_are_those_of_brute_force() {
    compare(false, 1, false, 8);
    compare(true, 1, false, 7);
}

#[test]
fn sequences_with_a_squeeze_are_those_of_brute_force() {
    compare(true, 1, true, 6);
    compare(true, 2, true, 5);
}

#[test]
fn rollouts_find_every_sequence_of_a_small_problem_in_the_end() {
    let expected = brute_force(&graph(false, 1, false), 7);
    let limits = SearchLimits {
        max_phases: Some(7),
        ..SearchLimits::default()
    };
    let mut rollouts = Rollouts::new(graph(false, 1, false), &limits, Costs::phases_only(), 3)
        .with_temperature(3.0);
    let mut found = BTreeSet::new();
    while let Some(sequence) = rollouts.next(&mut AcceptAll) {
        assert!(found.insert(sequence.states), "none twice");
    }
    assert_eq!(found, expected);
}
