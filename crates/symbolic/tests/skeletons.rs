//! Manipulation skeletons of the built-in domain on examples worked by hand.

use std::collections::BTreeSet;

use crate::fixtures::{bottom, handle, id, one_box, robot, standing, surface, two_boxes};
use symbolic::{Contact, Domain, Goal, GraphOptions, Owner, SkeletonGraph};

pub fn graph(
    domain: &Domain,
    rests: &str,
    goal: &[(&str, &str)],
    max_actions: Option<usize>,
) -> SkeletonGraph {
    let goal = Goal::of_pairs(goal.iter().map(|(a, b)| (id(domain, a), id(domain, b))));
    let options = GraphOptions {
        max_actions,
        ..GraphOptions::default()
    };
    SkeletonGraph::new(domain.clone(), standing(domain, rests), goal, options)
        .expect("the problem is valid")
}

/// Labels of all skeletons, in the order of the enumeration.
fn skeletons(graph: &SkeletonGraph) -> Vec<Vec<String>> {
    let label = |operator: usize| {
        graph.manipulation().task.operators()[operator]
            .label
            .clone()
    };
    graph
        .skeletons()
        .plans()
        .map(|plan| plan.iter().map(|edge| label(edge.operator)).collect())
        .collect()
}

#[test]
fn one_box_with_a_handle_is_moved_by_either_hand() {
    let domain = one_box(2);
    let graph = graph(
        &domain,
        "red_box_bottom on table_a_top",
        &[("red_box_bottom", "table_b_top")],
        Some(4),
    );
    let of = |hand: &str| {
        let grasp = format!("grasp red_box with {hand}");
        vec![
            grasp,
            "lift red_box".into(),
            "place red_box on table_b_top".into(),
            "release red_box".into(),
        ]
    };
    assert_eq!(skeletons(&graph), [of("left_hand"), of("right_hand")]);
    assert_eq!(graph.shortest_skeleton(), Some(4));
}

#[test]
fn a_squeeze_takes_two_different_hands_on_opposite_patches() {
    let domain = two_boxes(1);
    let rests = "red_box_bottom on ground_top, green_box_bottom on ground_top";
    let graph = graph(&domain, rests, &[], Some(1));
    let manipulation = graph.manipulation();
    let name = |contacts: &Vec<Contact>| {
        let names: Vec<String> = contacts.iter().map(|c| domain.contact_name(c)).collect();
        names.join(", ")
    };
    let of_hands =
        |contacts: &&Vec<Contact>| contacts.iter().any(|c| domain.object_of(c.a).is_none());
    let grasps = manipulation.meaning.iter().filter(of_hands);
    let mut names: Vec<String> = grasps.map(name).collect();
    names.sort();
    let expected = [
        "left_hand holds red_box_handle",
        "left_hand on green_box_left, right_hand on green_box_right",
        "right_hand holds red_box_handle",
        "right_hand on green_box_left, left_hand on green_box_right",
    ];
    assert_eq!(names, expected);
}

#[test]
fn a_handover_needs_a_second_handle() {
    let with_handles = |names: &[&str]| {
        let mut interfaces = robot();
        interfaces.push(bottom("bar_bottom", 0));
        interfaces.extend(names.iter().map(|name| handle(name, 0)));
        interfaces.push(surface("table_top", Owner::Static(0)));
        interfaces.push(surface("shelf_top", Owner::Static(1)));
        interfaces.push(surface("ground_top", Owner::Static(2)));
        Domain::new(interfaces, vec!["bar".into()], vec![]).expect("the domain is valid")
    };
    let in_the_air = |domain: &Domain| {
        let graph = graph(
            domain,
            "bar_bottom on table_top",
            &[("bar_bottom", "shelf_top")],
            Some(6),
        );
        let handed = |labels: &&Vec<String>| {
            let mut grasps = labels
                .iter()
                .enumerate()
                .filter(|(_, label)| label.starts_with("grasp"));
            grasps.next_back().is_some_and(|(n, _)| n > 1)
                && !labels[..4].iter().any(|label| label.starts_with("place"))
        };
        skeletons(&graph).iter().filter(handed).count()
    };
    assert_eq!(in_the_air(&with_handles(&["left_end"])), 0);
    assert!(in_the_air(&with_handles(&["left_end", "right_end"])) > 0);
}

#[test]
fn the_end_releases_what_the_goal_names_unless_it_asks_for_the_grasp() {
    let domain = one_box(2);
    let rests = "red_box_bottom on table_a_top";
    let held = graph(&domain, rests, &[("left_hand", "red_box_handle")], Some(4));
    assert_eq!(skeletons(&held), [["grasp red_box with left_hand"]]);
    let both = [
        ("red_box_bottom", "table_b_top"),
        ("right_hand", "red_box_handle"),
    ];
    let placed = skeletons(&graph(&domain, rests, &both, Some(4)));
    assert_eq!(
        placed
            .iter()
            .map(|s| s.last().map(String::as_str))
            .collect::<BTreeSet<_>>(),
        BTreeSet::from([Some("place red_box on table_b_top")])
    );

    let options = GraphOptions {
        release_at_end: false,
        ..GraphOptions::default()
    };
    let goal = Goal::of_pairs([(id(&domain, "red_box_bottom"), id(&domain, "table_b_top"))]);
    let graph =
        SkeletonGraph::new(domain.clone(), standing(&domain, rests), goal, options).expect("valid");
    assert_eq!(
        graph.shortest_skeleton(),
        Some(3),
        "without that rule the goal holds as soon as the box is placed"
    );
}

#[test]
fn boxes_stack_only_on_boxes_that_rest() {
    let mut interfaces = robot();
    for (n, name) in ["low", "high"].into_iter().enumerate() {
        interfaces.push(bottom(&format!("{name}_bottom"), n));
        interfaces.push(surface(&format!("{name}_top"), Owner::Object(n)));
        interfaces.push(handle(&format!("{name}_handle"), n));
    }
    interfaces.push(surface("ground_top", Owner::Static(0)));
    interfaces.push(surface("table_top", Owner::Static(1)));
    let domain = Domain::new(interfaces, vec!["low".into(), "high".into()], vec![])
        .expect("the domain is valid");
    let rests = "low_bottom on ground_top, high_bottom on ground_top";
    let goal = [("low_bottom", "table_top"), ("high_bottom", "low_top")];
    let graph = graph(&domain, rests, &goal, Some(8));
    let all = skeletons(&graph);
    let one = |skeleton: &[&str]| all.iter().any(|labels| labels == skeleton);
    assert!(one(&[
        "grasp low with left_hand",
        "lift low",
        "place low on table_top",
        "release low",
        "grasp high with right_hand",
        "lift high",
        "place high on low_top",
        "release high",
    ]));
    assert!(
        one(&[
            "grasp high with right_hand",
            "lift high",
            "place high on low_top",
            "release high",
            "grasp low with left_hand",
            "lift low",
            "place low on table_top",
            "release low",
        ]),
        "what lies on a box comes along"
    );
    let lands_on_lifted = |labels: &Vec<String>| {
        let position = |label: &str| labels.iter().position(|one| one == label);
        let (lift, place) = (position("lift low"), position("place low on table_top"));
        let stack = position("place high on low_top");
        stack > lift && stack < place
    };
    assert!(!all.iter().any(lands_on_lifted));
}
