//! Best-first search and rollouts: order, filters, limits, determinism.

use std::collections::BTreeMap;

use crate::fixtures::{id, one_box, standing, state, two_boxes};
use symbolic::search::{AcceptAll, Rejected, default_phases};
use symbolic::{
    BestFirst, ContactState, Costs, Domain, Ending, Goal, GraphOptions, Oracle, Rollouts,
    SearchLimits, Sequence, SkeletonGraph, Status, Verdict,
};

fn pick_place() -> SkeletonGraph {
    let domain = one_box(2);
    let goal = Goal::of_pairs([(id(&domain, "red_box_bottom"), id(&domain, "table_b_top"))]);
    let start = standing(&domain, "red_box_bottom on table_a_top");
    SkeletonGraph::new(domain, start, goal, GraphOptions::default()).expect("the problem is valid")
}

fn two_box() -> SkeletonGraph {
    let domain = two_boxes(3);
    let goal = Goal::of_pairs(
        ["red_box_bottom", "green_box_bottom"]
            .map(|b| (id(&domain, b), id(&domain, "table_c_top"))),
    );
    let start = standing(
        &domain,
        "red_box_bottom on table_a_top, green_box_bottom on table_b_top",
    );
    SkeletonGraph::new(domain, start, goal, GraphOptions::default()).expect("the problem is valid")
}

fn with_goal(domain: Domain, goal: Goal) -> SkeletonGraph {
    let start = standing(&domain, "red_box_bottom on table_a_top");
    SkeletonGraph::new(domain, start, goal, GraphOptions::default()).expect("the problem is valid")
}

fn best_first(graph: SkeletonGraph) -> BestFirst {
    BestFirst::new(graph, &SearchLimits::default(), Costs::default())
}

fn take(search: &mut BestFirst, count: usize, oracle: &mut dyn Oracle) -> Vec<Sequence> {
    std::iter::from_fn(|| search.next(oracle))
        .take(count)
        .collect()
}

const NATURAL: [&str; 9] = [
    "start",
    "grasp red_box with left_hand",
    "lift red_box",
    "left_foot off ground_top",
    "left_foot on ground_top",
    "right_foot off ground_top",
    "right_foot on ground_top",
    "place red_box on table_b_top",
    "release red_box",
];

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

/// Table b is in reach only after both feet have been set down anew while the box was in the air.
struct FarTable {
    domain: Domain,
    asked: BTreeMap<Vec<ContactState>, usize>,
}

impl Oracle for FarTable {
    fn prefix(&mut self, states: &[&ContactState]) -> Verdict {
        *self
            .asked
            .entry(states.iter().map(|&state| state.clone()).collect())
            .or_default() += 1;
        let table = self.domain.find("table_b_top").expect("exists");
        let placed = states.last().is_some_and(|state| {
            state
                .landed_on(table)
                .any(|c| self.domain.object_of(c.a).is_some())
        });
        let in_air =
            |state: &ContactState| !state.iter().any(|c| self.domain.object_of(c.a).is_some());
        let swung = |foot: usize| {
            states
                .iter()
                .any(|state| in_air(state) && state.partner(symbolic::InterfaceId(foot)).is_none())
        };
        if placed && !(swung(0) && swung(1)) {
            Verdict::Reject("table b is out of reach".into())
        } else {
            Verdict::Accept
        }
    }
}

#[test]
fn beginnings_that_the_oracle_rejects_are_not_extended_and_asked_once() {
    let mut oracle = FarTable {
        domain: one_box(2),
        asked: BTreeMap::new(),
    };
    let mut search = best_first(pick_place());
    let first = search.next(&mut oracle).expect("there is a plan");
    assert_eq!(first.labels, NATURAL);
    assert!(oracle.asked.values().all(|&times| times == 1));
    assert!(oracle.asked.len() < 400, "{} questions", oracle.asked.len());
    let rejected = search.rejections();
    assert!(
        !rejected.is_empty()
            && rejected
                .iter()
                .all(|r| r.reason == "table b is out of reach")
    );
    for rejection in rejected {
        let Rejected::Prefix(states) = &rejection.what else {
            panic!("only beginnings were rejected")
        };
        let longer = |asked: &Vec<ContactState>| {
            asked.len() > states.len() && asked[..states.len()] == states[..]
        };
        assert!(!oracle.asked.keys().any(longer));
    }
}

/// Rejects states and transitions by name and counts questions.
#[derive(Default)]
struct Strict {
    no_left_hand: bool,
    no_foot_up_while_lifted: bool,
    states: BTreeMap<ContactState, usize>,
    transitions: BTreeMap<(ContactState, ContactState), usize>,
}

impl Oracle for Strict {
    fn state(&mut self, state: &ContactState) -> Verdict {
        *self.states.entry(state.clone()).or_default() += 1;
        let domain = one_box(2);
        let grasp = crate::fixtures::contact(&domain, "left_hand", "red_box_handle");
        if !self.no_left_hand || !state.contains(&grasp) {
            return Verdict::Accept;
        }
        let contacts = [grasp].into_iter().collect();
        Verdict::RejectContacts(contacts, "the left hand does not reach".into())
    }

    fn transition(&mut self, from: &ContactState, to: &ContactState) -> Verdict {
        *self
            .transitions
            .entry((from.clone(), to.clone()))
            .or_default() += 1;
        let foot_up = from.len() == to.len() + 1 && from.iter().filter(|c| c.a.0 < 2).count() == 2;
        if self.no_foot_up_while_lifted && foot_up && from.len() == 3 {
            return Verdict::Reject("too heavy".into());
        }
        Verdict::Accept
    }
}

#[test]
fn contacts_that_cannot_be_together_are_asked_about_once_in_all() {
    let mut oracle = Strict {
        no_left_hand: true,
        ..Strict::default()
    };
    let mut search = best_first(pick_place());
    let found = take(&mut search, 100, &mut oracle);
    assert!(found.iter().all(|sequence| {
        sequence.labels[1..]
            .iter()
            .all(|label| !label.contains("with left_hand"))
    }));
    let grasp = crate::fixtures::contact(&one_box(2), "left_hand", "red_box_handle");
    assert_eq!(
        oracle
            .states
            .keys()
            .filter(|state| state.contains(&grasp))
            .count(),
        1
    );
    assert_eq!(search.rejections().len(), 1);
    assert!(
        search.counts().dropped_by_state > 1,
        "further states are dropped unasked"
    );
}

#[test]
fn rejected_transitions_do_not_occur_and_no_question_is_asked_twice() {
    let mut oracle = Strict {
        no_foot_up_while_lifted: true,
        ..Strict::default()
    };
    let mut search = best_first(pick_place());
    let found = take(&mut search, 200, &mut oracle);
    assert!(!found.iter().any(|sequence| sequence.labels == NATURAL));
    assert!(oracle.states.values().all(|&times| times == 1));
    assert!(oracle.transitions.values().all(|&times| times == 1));
    assert!(
        search
            .rejections()
            .iter()
            .any(|r| matches!(r.what, Rejected::Transition(..)) && r.reason == "too heavy")
    );
    let counts = search.counts();
    assert!(counts.dropped_by_transition > 0 && counts.returned == 200);
}

#[test]
fn what_is_taken_back_later_disappears_from_the_queue() {
    let mut search = best_first(pick_place());
    let first = search.next(&mut AcceptAll).expect("there is a plan");
    let beginning = first.states[..3].to_vec();
    search.reject(Rejected::Prefix(beginning.clone()), "lifting fails");
    let second = search.next(&mut AcceptAll).expect("the right hand is left");
    search.reject(Rejected::State(second.states[1].clone()), "grasping fails");
    let rest = take(&mut search, 300, &mut AcceptAll);
    assert!(
        rest.iter()
            .all(|sequence| sequence.states[..3] != beginning[..])
    );
    assert!(
        rest.iter()
            .all(|sequence| !sequence.states.contains(&second.states[1]))
    );
    let one_foot = state(
        &one_box(2),
        "right_foot on ground_top, red_box_bottom on table_a_top",
    );
    search.reject(
        Rejected::Transition(first.states[0].clone(), one_foot.clone()),
        "no",
    );
    search.reject(
        Rejected::Contacts(state(&one_box(2), "left_foot on table_b_top")),
        "too high",
    );
    let high = state(&one_box(2), "left_foot on table_b_top");
    for sequence in take(&mut search, 300, &mut AcceptAll) {
        assert!(
            sequence
                .states
                .windows(2)
                .all(|pair| pair != [first.states[0].clone(), one_foot.clone()])
        );
        assert!(sequence.states.iter().all(|state| !high.is_subset(state)));
    }
    let reasons: Vec<&str> = search
        .rejections()
        .iter()
        .map(|r| r.reason.as_str())
        .collect();
    assert_eq!(
        reasons,
        ["lifting fails", "grasping fails", "no", "too high"]
    );
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
fn rollouts_respect_oracle_and_limits() {
    let mut oracle = FarTable {
        domain: one_box(2),
        asked: BTreeMap::new(),
    };
    let mut rollouts = Rollouts::new(pick_place(), &SearchLimits::default(), Costs::default(), 1);
    let k_max = default_phases(&pick_place());
    for _ in 0..20 {
        let sequence = rollouts.next(&mut oracle).expect("there are many");
        assert!(sequence.states.len() <= k_max && sequence.states.len() >= 5);
        let refs: Vec<&ContactState> = sequence.states.iter().collect();
        assert!((1..=refs.len()).all(|n| oracle.prefix(&refs[..n]) == Verdict::Accept));
    }
    assert!(rollouts.rejections().len() > 1);
    let banned = rollouts.rejections().len();
    rollouts.reject(
        Rejected::Contacts(state(&one_box(2), "left_hand on red_box_handle")),
        "weak hand",
    );
    let later = rollouts.next(&mut oracle).expect("the right hand is left");
    assert!(
        later
            .labels
            .iter()
            .all(|label| !label.contains("with left_hand"))
    );
    assert_eq!(rollouts.rejections()[banned].reason, "weak hand");
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
        13,
        "a box can be moved: 1 + 4 + 8"
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
