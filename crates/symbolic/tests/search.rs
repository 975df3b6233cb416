//! Best-first search and rollouts: order, ends, limits, determinism.

use crate::fixtures::{id, one_box, standing};
use crate::problems::{NATURAL, best_first, pick_place, take, two_box, with_goal};
use symbolic::search::{AcceptAll, default_phases};
use symbolic::{
    BestFirst, Contact, ContactState, Costs, Ending, Goal, GraphOptions, Oracle, Policy, Rollouts,
    SearchLimits, Sequence, SkeletonGraph, Status, Verdict,
};

#[test]
fn plain_sequences_come_first_and_two_steps_with_the_box_among_the_first_twelve() {
    let sequences = take(&mut best_first(pick_place()), 40, &mut AcceptAll);
    assert_eq!(
        sequences[0].labels,
        ["start", NATURAL[1], NATURAL[2], NATURAL[7], NATURAL[8]]
    );
    assert_eq!(sequences[0].skeleton, sequences[0].labels[1..]);
    let rank = sequences
        .iter()
        .position(|sequence| sequence.labels == NATURAL)
        .expect("it is among the first");
    assert!(rank < 12, "{rank}");
    assert_eq!(sequences[rank].cost, 8.0, "eight phases after the first");
    assert!(sequences.is_sorted_by(|one, two| one.cost <= two.cost));
}

#[test]
fn swings_put_into_a_sequence_make_one_that_the_search_finds_too() {
    let graph = pick_place();
    let domain = graph.domain().clone();
    let sequences = take(&mut best_first(graph), 40, &mut AcceptAll);
    let found = sequences.iter().find(|s| s.labels == NATURAL);
    let found = found.expect("it is among the first");
    let lifted = 2;
    assert_eq!(sequences[0].labels[lifted], NATURAL[lifted]);
    let foot = |name| {
        let mut contacts = sequences[0].states[lifted].iter();
        contacts
            .find(|c| c.a == id(&domain, name))
            .expect("it stands")
    };
    let order = [foot("left_foot"), foot("right_foot")];
    let longer = sequences[0].with_swings(&domain, lifted, &order);
    assert_eq!(longer.labels, found.labels);
    assert_eq!(longer.states, found.states);
    assert_eq!(longer.skeleton, found.skeleton);
}

#[test]
fn a_foot_in_the_air_is_set_down_before_the_other_swings_and_leaves_again() {
    let graph = pick_place();
    let domain = graph.domain().clone();
    let sequences = take(&mut best_first(graph), 40, &mut AcceptAll);
    let found = sequences.iter().find(|s| s.labels == NATURAL);
    let natural = found.expect("it is among the first");
    let at = natural.labels.iter().position(|l| l.contains(" off "));
    let at = at.expect("a foot swings");
    let (stance, swing) = (&natural.states[at - 1], &natural.states[at]);
    let is_foot = |c: &Contact| {
        ["left_foot", "right_foot"]
            .map(|name| id(&domain, name))
            .contains(&c.a)
    };
    let feet: Vec<Contact> = stance.iter().filter(is_foot).collect();
    let stands = |c: &&Contact| swing.contains(c);
    let standing = *feet.iter().find(stands).expect("one stands");
    let other: ContactState = stance.iter().filter(|c| *c != standing).collect();
    let longer = natural.with_swings(&domain, at, &feet);
    let expected = [swing, stance, &other, stance, swing].map(Clone::clone);
    assert_eq!(longer.states[at..at + 5], expected);
    assert_eq!(longer.states[..at], natural.states[..at]);
    assert_eq!(longer.states[at + 4..], natural.states[at..]);
    assert_eq!(longer.labels[at + 4], natural.labels[at]);
    assert_eq!(longer.labels.len(), longer.states.len());
}

#[test]
fn an_impossible_start_ends_the_search_at_once() {
    struct Never;
    impl Oracle for Never {
        fn state(&mut self, _: &ContactState) -> Verdict {
            Verdict::Reject("nothing is possible".into())
        }
    }
    let mut search = best_first(pick_place());
    assert_eq!(search.next(&mut Never), None);
    assert_eq!(
        (search.status(), search.counts().judged),
        (Status::Exhausted, 1)
    );
    let mut rollouts = Rollouts::new(pick_place(), &SearchLimits::default(), Costs::default(), 0);
    assert_eq!(
        (rollouts.next(&mut Never), rollouts.status()),
        (None, Status::Exhausted)
    );
}

#[test]
fn a_search_stops_when_told_and_resumes_where_it_was() {
    struct Patient(usize);
    impl Oracle for Patient {
        fn stop(&mut self) -> bool {
            self.0 = self.0.saturating_sub(1);
            self.0 == 0
        }
    }
    let whole = take(&mut best_first(pick_place()), 30, &mut AcceptAll);
    let mut search = best_first(pick_place());
    let mut pieces = take(&mut search, 30, &mut Patient(100));
    assert_eq!(search.status(), Status::Stopped);
    let missing = 30 - pieces.len();
    pieces.extend(take(&mut search, missing, &mut AcceptAll));
    assert_eq!(pieces, whole);
}

#[test]
fn the_limit_on_memory_ends_the_search() {
    let limits = SearchLimits {
        max_nodes: 500,
        ..SearchLimits::default()
    };
    let mut search = BestFirst::new(pick_place(), &limits, Costs::default());
    let found = take(&mut search, usize::MAX, &mut AcceptAll);
    assert!(found.len() > 10);
    assert_eq!(search.status(), Status::Full);
    assert!(search.counts().created <= 501);
}

#[test]
fn the_same_search_twice_is_the_same() {
    let list = || take(&mut best_first(two_box()), 300, &mut AcceptAll);
    assert_eq!(list(), list());
    let roll = |seed| {
        let mut rollouts =
            Rollouts::new(two_box(), &SearchLimits::default(), Costs::default(), seed);
        std::iter::from_fn(|| rollouts.next(&mut AcceptAll))
            .take(50)
            .collect::<Vec<_>>()
    };
    assert_eq!(roll(4), roll(4));
    assert_ne!(roll(4), roll(5));
}

#[test]
fn bounds_derive_from_the_problem() {
    assert_eq!(default_phases(&pick_place()), 13, "1 + 4 + 8");
    assert_eq!(default_phases(&two_box()), 25, "1 + 8 + 16");
    assert_eq!(pick_place().skeletons().max_actions(), 8, "4 + 4");
    let domain = one_box(2);
    let feet = Goal::of_pairs(
        ["left_foot", "right_foot"].map(|foot| (id(&domain, foot), id(&domain, "table_a_top"))),
    );
    assert_eq!(
        default_phases(&with_goal(domain.clone(), feet)),
        21,
        "1 + 4 + 8 + 2 · 4"
    );
    assert_eq!(
        default_phases(&with_goal(domain.clone(), Goal::default())),
        21,
        "a box can be moved, feet may go up: 1 + 4 + 8 + 2 · 4"
    );
    let options = GraphOptions {
        max_actions: Some(0),
        ..GraphOptions::default()
    };
    let start = standing(&domain, "red_box_bottom on table_a_top");
    let walk =
        SkeletonGraph::new(domain, start, Goal::default(), options).expect("the problem is valid");
    assert_eq!(default_phases(&walk), 9, "1 + 2 · 4");
}

#[test]
fn a_goal_of_feet_is_a_walk() {
    let domain = one_box(2);
    let goal = Goal::of_pairs(
        ["left_foot", "right_foot"].map(|foot| (id(&domain, foot), id(&domain, "table_a_top"))),
    );
    let first = best_first(with_goal(domain, goal))
        .next(&mut AcceptAll)
        .expect("there is a walk");
    let expected = [
        "start",
        "left_foot off ground_top",
        "left_foot on table_a_top",
        "right_foot off ground_top",
        "right_foot on table_a_top",
    ];
    assert_eq!(first.labels, expected);
}

#[test]
fn an_empty_goal_gives_sequences_of_full_length() {
    let graph = || with_goal(one_box(1), Goal::default());
    let limits = SearchLimits {
        max_phases: Some(7),
        ..SearchLimits::default()
    };
    let mut search = BestFirst::new(graph(), &limits, Costs::default());
    let found = take(&mut search, 500, &mut AcceptAll);
    assert_eq!(found.len(), 500);
    assert!(found.iter().all(|sequence| sequence.states.len() == 7));
    let moved = |sequence: &Sequence| {
        sequence
            .labels
            .iter()
            .any(|label| label.starts_with("place"))
    };
    assert!(
        found.iter().any(moved),
        "boxes may be moved although no goal asks for it"
    );

    let every = SearchLimits {
        ending: Some(Ending::Every),
        ..limits
    };
    let mut search = BestFirst::new(graph(), &every, Costs::default());
    let lengths: Vec<usize> = take(&mut search, 50, &mut AcceptAll)
        .iter()
        .map(|s| s.states.len())
        .collect();
    assert_eq!(lengths[0], 1, "the start alone satisfies it");
    assert!(
        [2, 3, 5].iter().all(|n| lengths.contains(n)),
        "longer ones go on from shorter ones: {lengths:?}"
    );
}

#[test]
fn a_goal_that_holds_is_a_sequence_of_one_state() {
    let domain = one_box(2);
    let goal = Goal::of_pairs([(id(&domain, "red_box_bottom"), id(&domain, "table_a_top"))]);
    let mut search = best_first(with_goal(domain, goal));
    let found = search.next(&mut AcceptAll).expect("the start is a plan");
    assert_eq!(
        (found.labels.as_slice(), found.cost),
        (["start".to_owned()].as_slice(), 0.0)
    );
    assert_eq!(
        (search.next(&mut AcceptAll), search.status()),
        (None, Status::Exhausted)
    );
}

#[test]
fn an_unreachable_goal_or_too_few_phases_exhaust_at_once() {
    let domain = one_box(2);
    let goal = Goal::of_pairs([(id(&domain, "red_box_bottom"), id(&domain, "table_b_top"))]);
    let options = GraphOptions {
        max_actions: Some(3),
        ..GraphOptions::default()
    };
    let start = standing(&domain, "red_box_bottom on table_a_top");
    let short = SkeletonGraph::new(domain, start, goal, options).expect("the problem is valid");
    assert_eq!(short.shortest_skeleton(), None, "four actions are needed");
    let limits = |n| SearchLimits {
        max_phases: Some(n),
        ..SearchLimits::default()
    };
    for (graph, limits) in [(short, limits(13)), (pick_place(), limits(4))] {
        let mut search = BestFirst::new(graph, &limits, Costs::default());
        assert_eq!(
            (search.next(&mut AcceptAll), search.status()),
            (None, Status::Exhausted)
        );
    }
    assert!(
        BestFirst::new(pick_place(), &limits(5), Costs::default())
            .next(&mut AcceptAll)
            .is_some()
    );
}

#[test]
fn an_extra_cost_reorders_but_loses_nothing() {
    let limits = SearchLimits {
        max_phases: Some(5),
        ..SearchLimits::default()
    };
    let all = |search: &mut BestFirst| take(search, usize::MAX, &mut AcceptAll);
    let plain = all(&mut BestFirst::new(pick_place(), &limits, Costs::default()));
    let right_first = Box::new(|step: &symbolic::search::Step<'_>| {
        let left = step
            .action
            .makes
            .iter()
            .any(|c| c.a.0 == 2 && step.graph.domain().object_of(c.b).is_some());
        if left { 0.25 } else { -1.0 }
    });
    let mut other =
        all(&mut BestFirst::new(pick_place(), &limits, Costs::default())
            .with_extra_cost(right_first));
    assert_eq!(other[0].labels[1], "grasp red_box with right_hand");
    assert_eq!(other[0].cost, 4.0, "negative costs count as zero");
    let mut states: Vec<_> = plain.into_iter().map(|sequence| sequence.states).collect();
    let mut others: Vec<_> = other.drain(..).map(|sequence| sequence.states).collect();
    states.sort();
    others.sort();
    assert_eq!(states, others);
}

#[test]
fn thirteen_phases_with_two_boxes_stay_small() {
    let limits = SearchLimits {
        max_phases: Some(13),
        ..SearchLimits::default()
    };
    let mut search = BestFirst::new(two_box(), &limits, Costs::default());
    let found = take(&mut search, 2000, &mut AcceptAll);
    assert_eq!(found.len(), 2000);
    let (counts, states) = (search.counts(), search.graph().n_states());
    assert!(counts.created < 40_000, "{counts:?}");
    assert!(states < 20_000, "{states} states");
    let mut orders: Vec<&str> = found
        .iter()
        .map(|sequence| sequence.skeleton[0].as_str())
        .collect();
    orders.sort_unstable();
    orders.dedup();
    assert!(orders.len() >= 4, "{orders:?}");
}
