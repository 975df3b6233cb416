//! Counts of states and transitions per rule, against enumeration.

use crate::fixtures::{id, one_box, standing, two_boxes};
use crate::rules::{all_sets, tiny};
use symbolic::state_rules::state_fault;
use symbolic::statistics::{count_by_rule, count_skeleton_graph};
use symbolic::transition_rules::transition_fault;
use symbolic::{ContactState, Goal, GraphOptions, SkeletonGraph};

#[test]
fn counts_of_a_tiny_domain_are_those_of_enumeration() {
    let domain = tiny();
    let counts = count_by_rule(&domain);
    let states: Vec<ContactState> = all_sets(&domain)
        .into_iter()
        .filter(|state| state_fault(&domain, state).is_none())
        .collect();
    let transitions = states
        .iter()
        .flat_map(|from| {
            states
                .iter()
                .filter(move |to| transition_fault(from, to).is_none())
        })
        .count();
    let last = counts.last().expect("there are rules");
    assert_eq!(
        last.states.and_then(|n| n.exact),
        Some(states.len() as u128)
    );
    assert_eq!(
        last.transitions.and_then(|n| n.exact),
        Some(transitions as u128)
    );
    let pairs = counts[counts.len() - 2].transitions.and_then(|n| n.exact);
    assert_eq!(pairs, Some((states.len() * (states.len() - 1)) as u128));
}

#[test]
fn every_rule_of_a_tiny_domain_leaves_what_one_counts_by_hand() {
    let counts = count_by_rule(&tiny());
    let contacts: Vec<usize> = counts.iter().map(|count| count.contacts).collect();
    // 5·5 pairs of 4 types; less 5 self pairs; less 2 static pairs; no two interfaces share another body;
    // foot on 4, boxes on 3 each; nothing is forbidden to feet; of one type.
    assert_eq!(contacts, [100, 80, 72, 72, 40, 40, 10, 10, 10, 10, 10]);
    let states: Vec<String> = counts
        .iter()
        .map(|count| count.states.map_or("?".into(), |states| states.to_string()))
        .collect();
    // 5^25, 5^20, 5^18 (each ordered pair has one of four types or none), 5^10, 2^10, 5·4·4, the rest by enumeration.
    let expected = [
        "10^17.5", "10^14.0", "10^12.6", "10^12.6", "9765625", "9765625", "1024", "80", "41", "41",
        "41",
    ];
    assert_eq!(states, expected);
    let reduced = counts.windows(2).all(|pair| {
        let log = |n: usize| {
            pair[n]
                .transitions
                .map_or(f64::INFINITY, |count| count.log10)
        };
        log(1) <= log(0)
    });
    assert!(reduced, "no rule adds transitions");
}

#[test]
fn two_boxes_and_three_tables_can_be_counted() {
    let counts = count_by_rule(&two_boxes(3));
    assert_eq!(
        counts[0].states.and_then(|n| n.exact),
        None,
        "5^(13²) has 119 digits"
    );
    assert!((counts[0].states.expect("a product").log10 - 169.0 * 5_f64.log10()).abs() < 1e-9);
    let last = counts.last().expect("there are rules");
    assert!(
        last.states
            .and_then(|n| n.exact)
            .is_some_and(|n| n > 10_000 && n < 1_000_000)
    );
    assert!(last.transitions.is_some());
}

#[test]
fn skeletons_leave_a_graph_that_can_be_walked() {
    let domain = one_box(2);
    let goal = Goal::of_pairs([(id(&domain, "red_box_bottom"), id(&domain, "table_b_top"))]);
    let start = standing(&domain, "red_box_bottom on table_a_top");
    let options = GraphOptions {
        max_actions: Some(4),
        support_hands: false,
        ..GraphOptions::default()
    };
    let mut graph = SkeletonGraph::new(domain, start, goal, options).expect("the problem is valid");
    let count = count_skeleton_graph(&mut graph, 100_000).expect("it is small");
    // Start, and with either hand held on a, in the air, held on b; then released.
    assert_eq!(count.positions, 1 + 3 + 3 + 1);
    // The feet are free or on ground, table a, table b; while the box is in the air also on its bottom.
    assert_eq!(count.states, 16 * 6 + 25 * 2);
    assert_eq!(count_skeleton_graph(&mut graph, 10), None);
}
