//! Every kind of contact occurs in the graph: robot, objects and environment on each other, by any interface.

use std::collections::BTreeSet;

use crate::fixtures::{bottom, handle, interface, robot, standing, state, surface};
use symbolic::{
    Contact, ContactState, ContactType, Domain, Goal, GraphOptions, InterfaceId, Node, Owner, Role,
    SkeletonGraph,
};

const RESTS: &str = "low_bottom on ground_top, high_bottom on table_top";

/// A low box with a handle, a high one with a handle that two hands can squeeze too, both with tops; ground, table and a rail to hold.
fn domain() -> Domain {
    let mut interfaces = robot();
    interfaces.push(bottom("low_bottom", 0));
    interfaces.push(surface("low_top", Owner::Object(0)));
    interfaces.push(handle("low_handle", 0));
    interfaces.push(bottom("high_bottom", 1));
    interfaces.push(surface("high_top", Owner::Object(1)));
    interfaces.push(surface("high_left", Owner::Object(1)));
    interfaces.push(surface("high_right", Owner::Object(1)));
    interfaces.push(handle("high_grip", 1));
    interfaces.push(surface("ground_top", Owner::Static(0)));
    interfaces.push(surface("table_top", Owner::Static(1)));
    let holdable = [ContactType::BilateralPatch];
    interfaces.push(interface(
        "rail",
        Owner::Static(2),
        Role::Surface,
        &holdable,
    ));
    let squeezes = vec![(InterfaceId(9), InterfaceId(10))];
    Domain::new(interfaces, vec!["low".into(), "high".into()], squeezes)
        .expect("the domain is valid")
}

fn graph(max_changes: usize) -> SkeletonGraph {
    let domain = domain();
    let start = standing(&domain, RESTS);
    let options = GraphOptions {
        max_changes,
        max_actions: Some(6),
        ..GraphOptions::default()
    };
    SkeletonGraph::new(domain, start, Goal::default(), options).expect("the problem is valid")
}

/// The contacts that are made, and those that are broken, by actions from the first nodes breadth first.
fn changes(graph: &mut SkeletonGraph, nodes: usize) -> [BTreeSet<Contact>; 2] {
    let mut found = [BTreeSet::new(), BTreeSet::new()];
    let mut seen = BTreeSet::from([graph.root()]);
    let mut queue = vec![graph.root()];
    for n in 0..nodes {
        let Some(&node) = queue.get(n) else { break };
        for edge in graph.successors(node) {
            let (from, to) = (graph.state(node.state), graph.state(edge.node.state));
            found[0].extend(to.iter().filter(|c| !from.contains(c)));
            found[1].extend(from.iter().filter(|c| !to.contains(c)));
            if seen.insert(edge.node) {
                queue.push(edge.node);
            }
        }
    }
    found
}

#[test]
fn every_possible_contact_is_made_and_broken_by_some_action() {
    let mut graph = graph(1);
    let all: BTreeSet<Contact> = graph.domain().contacts().iter().copied().collect();
    let [made, broken] = changes(&mut graph, 30_000);
    let missing = |found: &BTreeSet<Contact>| -> Vec<String> {
        let names = all
            .difference(found)
            .map(|c| graph.domain().contact_name(c));
        names.collect()
    };
    // A box has one side to stand on, so nothing is put down on that side.
    let face_to_face = ["low_bottom on high_bottom", "high_bottom on low_bottom"];
    assert_eq!(missing(&made), face_to_face, "never made");
    assert_eq!(missing(&broken), face_to_face, "never broken");
    for pair in [
        "right_foot on low_top",  // a foot on a box
        "left_foot on high_left", // or on a side of it
        "left_hand on table_top", // a hand on the environment
        "right_hand on high_top", // and on an object
        "high_bottom on low_top", // box on box
        "low_bottom on high_top",
        "low_bottom on table_top", // box on the environment
        "left_hand on low_handle", // a grasp
        "right_hand on rail",      // holding on to the environment
    ] {
        let contact = state(graph.domain(), pair);
        assert!(contact.iter().all(|c| made.contains(&c)), "{pair}");
    }
}

/// The node behind the action that leads to the contacts.
fn go(graph: &mut SkeletonGraph, node: Node, contacts: &str) -> Node {
    let target: ContactState = state(graph.domain(), contacts);
    let edges = graph.successors(node);
    let edge = edges
        .iter()
        .find(|edge| *graph.state(edge.node.state) == target);
    edge.unwrap_or_else(|| panic!("no action leads to {contacts}"))
        .node
}

#[test]
fn a_climb_over_a_carried_box_is_a_path_of_the_graph() {
    let mut graph = graph(1);
    let feet = "left_foot on ground_top, right_foot on ground_top";
    let low = "low_bottom on ground_top";
    let squeezed = "left_hand on high_left, right_hand on high_right";
    let on_low = format!("{low}, high_bottom on low_top");
    let path = [
        format!("{feet}, {low}, high_bottom on table_top, {squeezed}"),
        format!("{feet}, {low}, {squeezed}"),
        format!("{feet}, {on_low}, {squeezed}"),
        format!("{feet}, {on_low}"),
        format!("{feet}, {on_low}, left_hand on table_top"),
        format!("right_foot on ground_top, {on_low}, left_hand on table_top"),
        format!(
            "left_foot on high_top, right_foot on ground_top, {on_low}, left_hand on table_top"
        ),
        format!("left_foot on high_top, {on_low}, left_hand on table_top"),
        format!("left_foot on high_top, right_foot on table_top, {on_low}, left_hand on table_top"),
        format!("right_foot on table_top, {on_low}, left_hand on table_top"),
        format!("right_foot on table_top, {on_low}"),
        format!("right_foot on table_top, left_foot on table_top, {on_low}"),
    ];
    let mut node = graph.root();
    for contacts in &path {
        node = go(&mut graph, node, contacts);
    }
    assert!(graph.is_goal(node), "an empty goal");
}

#[test]
fn a_jump_and_several_changes_at_once_are_actions() {
    let mut one_by_one = graph(1);
    let root = one_by_one.root();
    let lifted = go(
        &mut one_by_one,
        root,
        &format!("left_foot on ground_top, {RESTS}"),
    );
    let flight = go(&mut one_by_one, lifted, RESTS);
    go(
        &mut one_by_one,
        flight,
        &format!("right_foot on table_top, {RESTS}"),
    );

    let mut at_once = graph(3);
    let root = at_once.root();
    let flight = go(&mut at_once, root, RESTS);
    let landed = "left_foot on table_top, right_foot on low_top, right_hand on rail";
    go(&mut at_once, flight, &format!("{landed}, {RESTS}"));
    // a grasp together with a step and a support
    let grasp = "left_foot on ground_top, left_hand on low_handle, right_hand on table_top";
    go(&mut at_once, root, &format!("{grasp}, {RESTS}"));
}
