//! The skeleton-constrained graph: "the current or the next action", on the example of the paper's figure.

use crate::fixtures::{contact, id, one_box, standing, state, two_boxes};
use symbolic::{ContactState, Domain, Goal, GraphOptions, Node, SkeletonGraph};

fn figure(options: GraphOptions) -> SkeletonGraph {
    let domain = one_box(2);
    let goal = Goal::of_pairs([(id(&domain, "red_box_bottom"), id(&domain, "table_b_top"))]);
    SkeletonGraph::new(
        domain.clone(),
        standing(&domain, "red_box_bottom on table_a_top"),
        goal,
        options,
    )
    .expect("valid")
}

/// Goes to the contacts, which must be a successor.
fn go(graph: &mut SkeletonGraph, node: Node, contacts: &str) -> (Node, String) {
    let target = state(graph.domain(), contacts);
    let edges = graph.successors(node);
    let edge = edges
        .iter()
        .find(|edge| *graph.state(edge.node.state) == target);
    let edge = edge.unwrap_or_else(|| panic!("no action leads to {contacts}"));
    (edge.node, graph.label(node, edge))
}

/// True if one action leads to the contacts.
fn leads_to(graph: &mut SkeletonGraph, node: Node, contacts: &str) -> bool {
    let target = state(graph.domain(), contacts);
    graph
        .successors(node)
        .iter()
        .any(|edge| *graph.state(edge.node.state) == target)
}

const STAND: &str = "left_foot on ground_top, right_foot on ground_top";
const HELD: &str = "right_hand on red_box_handle";

#[test]
fn left_branch_of_the_figure_takes_one_skeleton_action_after_the_other() {
    let mut graph = figure(GraphOptions::default());
    let root = graph.root();
    let (grasped, label) = go(
        &mut graph,
        root,
        &format!("{STAND}, {HELD}, red_box_bottom on table_a_top"),
    );
    assert_eq!(label, "grasp red_box with right_hand");
    let (lifted, label) = go(&mut graph, grasped, &format!("{STAND}, {HELD}"));
    assert_eq!(label, "lift red_box");
    let (placed, label) = go(
        &mut graph,
        lifted,
        &format!("{STAND}, {HELD}, red_box_bottom on table_b_top"),
    );
    assert_eq!(label, "place red_box on table_b_top");
    assert!(!graph.is_goal(placed), "the box is still held");
    let (released, label) = go(
        &mut graph,
        placed,
        &format!("{STAND}, red_box_bottom on table_b_top"),
    );
    assert_eq!(label, "release red_box");
    assert!(graph.is_goal(released));
    assert_eq!(
        [root, grasped, lifted, placed, released].map(|node| graph.remaining(node)),
        [4, 3, 2, 1, 0].map(Some)
    );
}

#[test]
fn middle_branch_repeats_the_lift_while_the_feet_alternate() {
    let mut graph = figure(GraphOptions::default());
    let root = graph.root();
    let support = "left_hand on table_a_top";
    let (grasped, label) = go(
        &mut graph,
        root,
        &format!("{STAND}, {support}, {HELD}, red_box_bottom on table_a_top"),
    );
    assert_eq!(
        label, "grasp red_box with right_hand, left_hand on table_a_top",
        "a support contact comes along"
    );
    let (mut node, _) = go(&mut graph, grasped, &format!("{STAND}, {support}, {HELD}"));
    let lifted = node.position;
    for (feet, expected) in [
        ("right_foot on ground_top", "left_foot off ground_top"),
        (STAND, "left_foot on ground_top"),
        ("left_foot on ground_top", "right_foot off ground_top"),
        (STAND, "right_foot on ground_top"),
    ] {
        let (next, label) = go(&mut graph, node, &format!("{feet}, {support}, {HELD}"));
        assert_eq!(
            (next.position, label.as_str()),
            (lifted, expected),
            "the skeleton stays at lift"
        );
        node = next;
    }
    let (placed, _) = go(
        &mut graph,
        node,
        &format!("{STAND}, {support}, {HELD}, red_box_bottom on table_b_top"),
    );
    assert_ne!(placed.position, lifted);
}

#[test]
fn what_neither_the_current_nor_the_next_action_imposes_is_pruned() {
    let mut graph = figure(GraphOptions {
        max_changes: 4,
        ..GraphOptions::default()
    });
    let root = graph.root();
    for skipped in [
        "red_box_bottom on table_b_top", // nobody moved it
        "",                              // nobody lifted it
        "right_hand on red_box_handle",  // grasp and lift at once
        "right_hand on red_box_handle, red_box_bottom on table_b_top", // grasp, lift and place at once
    ] {
        assert!(
            !leads_to(&mut graph, root, &format!("{STAND}, {skipped}")),
            "{skipped}"
        );
    }
    let both_hands =
        "left_hand on red_box_handle, right_hand on red_box_handle, red_box_bottom on table_a_top";
    assert!(
        !leads_to(&mut graph, root, &format!("{STAND}, {both_hands}")),
        "the second hand is no part of the skeleton"
    );
    let (grasped, _) = go(
        &mut graph,
        root,
        &format!("{STAND}, {HELD}, red_box_bottom on table_a_top"),
    );
    let place = format!("{STAND}, {HELD}, red_box_bottom on table_b_top");
    assert!(
        !leads_to(&mut graph, grasped, &place),
        "the box changes its support only through the air"
    );
}

#[test]
fn a_hand_that_supports_must_come_free_before_it_grasps() {
    let mut graph = figure(GraphOptions {
        max_changes: 4,
        ..GraphOptions::default()
    });
    let root = graph.root();
    let (leaning, _) = go(
        &mut graph,
        root,
        &format!("{STAND}, right_hand on table_a_top, red_box_bottom on table_a_top"),
    );
    let grasp = format!("{STAND}, {HELD}, red_box_bottom on table_a_top");
    assert!(!leads_to(&mut graph, leaning, &grasp));
    let (free, label) = go(
        &mut graph,
        leaning,
        &format!("{STAND}, red_box_bottom on table_a_top"),
    );
    assert_eq!(label, "right_hand off table_a_top");
    assert!(leads_to(&mut graph, free, &grasp));
}

#[test]
fn options_bound_the_changes_of_free_interfaces() {
    let count = |max_changes, support_hands| {
        let mut graph = figure(GraphOptions {
            max_changes,
            support_hands,
            ..GraphOptions::default()
        });
        let root = graph.root();
        graph.successors(root).len()
    };
    // Without changes of free interfaces: grasp with either hand. With one: either foot up, also with a grasp.
    assert_eq!(count(0, false), 2);
    assert_eq!(count(1, false), 2 * 3 + 2);
    // With two: both feet up at once, a jump.
    assert_eq!(count(2, false), 2 * 4 + 3);
    // A free hand reaches ground, table a and table b; the box's bottom is covered.
    assert_eq!(count(1, true), 2 * (1 + 2 + 3) + 2 + 2 * 3);
}

#[test]
fn without_flights_one_foot_stays_where_it_is_carried() {
    let mut graph = figure(GraphOptions {
        max_changes: 2,
        support_hands: false,
        flights: false,
        ..GraphOptions::default()
    });
    let root = graph.root();
    let after = graph.successors(root);
    // As with flights, but for both feet up at once: alone, and with a grasp by either hand.
    assert_eq!(after.len(), 2 * 4 + 3 - 3);
    for next in &after {
        assert!(symbolic::is_carried(
            graph.domain(),
            graph.state(next.node.state)
        ));
    }
}

#[test]
fn one_hand_may_touch_before_a_squeeze_but_two_hands_are_a_grasp() {
    let domain = two_boxes(1);
    let rests = "red_box_bottom on ground_top, green_box_bottom on table_a_top";
    let goal = Goal::of_pairs([(id(&domain, "green_box_bottom"), id(&domain, "ground_top"))]);
    let options = GraphOptions {
        max_changes: 2,
        ..GraphOptions::default()
    };
    let mut graph =
        SkeletonGraph::new(domain.clone(), standing(&domain, rests), goal, options).expect("valid");
    let root = graph.root();
    let left = format!("{STAND}, {rests}, left_hand on green_box_left");
    let both = format!("{left}, right_hand on green_box_right");
    let (touching, label) = go(&mut graph, root, &left);
    assert_eq!(
        (touching.position, label.as_str()),
        (root.position, "left_hand on green_box_left")
    );
    let ways: Vec<_> = {
        let target = state(&domain, &both);
        graph
            .successors(touching)
            .into_iter()
            .filter(|edge| *graph.state(edge.node.state) == target)
            .collect()
    };
    assert_eq!(
        ways.len(),
        1,
        "two hands on opposite patches are the grasp, not two supports"
    );
    assert!(ways[0].operator.is_some());
    assert!(leads_to(&mut graph, root, &both), "or both at once");
    let crossed =
        format!("{STAND}, {rests}, left_hand on green_box_left, right_hand on green_box_left");
    assert!(
        leads_to(&mut graph, touching, &crossed),
        "two hands on the same patch hold nothing"
    );
}

#[test]
fn a_skeleton_visits_no_position_twice_and_stays_within_its_actions() {
    let mut graph = figure(GraphOptions {
        max_actions: Some(4),
        ..GraphOptions::default()
    });
    let root = graph.root();
    let (grasped, _) = go(
        &mut graph,
        root,
        &format!("{STAND}, {HELD}, red_box_bottom on table_a_top"),
    );
    assert!(graph.may_advance(&[root.position], grasped.position));
    assert!(
        !graph.may_advance(&[root.position, grasped.position], root.position),
        "back to the start"
    );
    let (lifted, _) = go(&mut graph, grasped, &format!("{STAND}, {HELD}"));
    let (grounded, _) = go(
        &mut graph,
        lifted,
        &format!("{STAND}, {HELD}, red_box_bottom on ground_top"),
    );
    let visited = [root.position, grasped.position, lifted.position];
    assert!(
        !graph.may_advance(&visited, grounded.position),
        "from the ground the goal is beyond four actions"
    );
}

#[test]
fn a_start_with_a_held_box_begins_in_the_middle_of_a_skeleton() {
    let domain = one_box(2);
    let start = standing(&domain, "left_hand on red_box_handle");
    let goal = Goal::of_pairs([(id(&domain, "red_box_bottom"), id(&domain, "table_b_top"))]);
    let graph = SkeletonGraph::new(domain, start, goal, GraphOptions::default())
        .expect("the problem is valid");
    assert_eq!(graph.shortest_skeleton(), Some(2));
    let free: Vec<usize> = graph
        .free_interfaces(graph.root().position)
        .map(|i| i.0)
        .collect();
    assert_eq!(free, [0, 1, 3], "feet and right hand");
}

#[test]
fn every_successor_satisfies_the_rules_of_states_and_transitions() {
    let mut graph = figure(GraphOptions {
        max_changes: 2,
        ..GraphOptions::default()
    });
    let mut queue = vec![graph.root()];
    for n in 0..200 {
        let Some(&node) = queue.get(n) else { break };
        for edge in graph.successors(node) {
            let (from, to) = (graph.state(node.state), graph.state(edge.node.state));
            assert_eq!(symbolic::state_rules::state_fault(graph.domain(), to), None);
            assert_eq!(symbolic::transition_rules::transition_fault(from, to), None);
            assert!(graph.satisfies(to, edge.node.position));
            if !queue.contains(&edge.node) {
                queue.push(edge.node);
            }
        }
    }
    assert!(queue.len() > 200);
}

#[test]
fn states_are_found_again_by_content() {
    let mut graph = figure(GraphOptions::default());
    let start = standing(&one_box(2), "red_box_bottom on table_a_top");
    assert_eq!(graph.intern(&start), graph.root().state);
    let domain: Domain = graph.domain().clone();
    let flying: ContactState = [contact(&domain, "red_box_bottom", "table_a_top")]
        .into_iter()
        .collect();
    let id = graph.intern(&flying);
    assert_eq!(graph.intern(&flying), id);
    assert_eq!(graph.n_states(), 2);
}
