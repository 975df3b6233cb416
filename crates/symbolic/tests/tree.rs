//! Monte-Carlo tree search: the same every time, nothing twice, drawn to what pays, and nothing that is refused.

use std::collections::BTreeSet;

use crate::fixtures::{id, one_box};
use crate::problems::{best_first, pick_place, two_box, with_goal};
use symbolic::search::{AcceptAll, Rejected};
use symbolic::{
    Contact, ContactState, Costs, Ending, Goal, Oracle, Policy, Rollouts, SearchLimits, Sequence,
    Status, TreeSearch, Verdict,
};

fn tree(seed: u64) -> TreeSearch {
    TreeSearch::new(
        pick_place(),
        &SearchLimits::default(),
        Costs::default(),
        seed,
    )
}

/// Takes sequences and pays for each what `worth` says.
fn paid(search: &mut TreeSearch, count: usize, worth: impl Fn(&Sequence) -> f64) -> Vec<Sequence> {
    let mut found = Vec::new();
    for _ in 0..count {
        let Some(sequence) = search.next(&mut AcceptAll) else {
            break;
        };
        search.learn(&sequence.states, worth(&sequence));
        found.push(sequence);
    }
    found
}

#[test]
fn a_seed_decides_everything_and_nothing_comes_twice() {
    let one = paid(&mut tree(5), 200, |s| 1.0 / s.states.len() as f64);
    assert_eq!(one.len(), 200);
    assert_eq!(
        one,
        paid(&mut tree(5), 200, |s| 1.0 / s.states.len() as f64)
    );
    assert_ne!(
        one,
        paid(&mut tree(6), 200, |s| 1.0 / s.states.len() as f64)
    );
    let different: BTreeSet<_> = one.iter().map(|s| s.states.clone()).collect();
    assert_eq!(different.len(), 200);
}

#[test]
fn every_sequence_is_one_of_the_graph() {
    let mut known = best_first(pick_place());
    let mut all = BTreeSet::new();
    while let Some(sequence) = known.next(&mut AcceptAll) {
        if sequence.cost > 14.0 {
            break;
        }
        all.insert(sequence.states);
    }
    let cheap = paid(&mut tree(1), 300, |_| 0.5);
    let cheap: Vec<_> = cheap.iter().filter(|s| s.cost < 14.0).collect();
    assert!(cheap.len() > 50, "{}", cheap.len());
    assert!(cheap.iter().all(|s| all.contains(&s.states)));
}

#[test]
fn what_pays_is_tried_more_often() {
    let with_left = |s: &Sequence| s.skeleton.iter().any(|label| label.contains("left_hand"));
    let share = |worth: &dyn Fn(&Sequence) -> f64| {
        let found = paid(&mut tree(2), 400, worth);
        let tail = &found[100..];
        tail.iter().filter(|s| with_left(s)).count() as f64 / tail.len() as f64
    };
    let even = share(&|_| 0.5);
    let drawn = share(&|s| f64::from(u8::from(with_left(s))));
    assert!(
        drawn > even + 0.15,
        "{drawn} of the paid, {even} of the even"
    );
}

#[test]
fn statistics_are_the_visits_and_the_mean_rewards_of_every_beginning() {
    let mut search = tree(4);
    let told = paid(&mut search, 1, |_| 0.8);
    let all = search.statistics(&told[0].states);
    assert_eq!(all.len(), 1, "the tree is its root, the rest was a walk");
    assert_eq!((all[0].visits, all[0].value), (1, 0.8));
    let next = search.next(&mut AcceptAll).expect("another sequence");
    let open = search.statistics(&next.states);
    assert_eq!((open[0].visits, open[0].value), (2, 0.4), "not told yet");
    search.learn(&next.states, 0.4);
    let told = search.statistics(&next.states);
    assert_eq!(told.len(), 2);
    assert!((told[0].value - 0.6).abs() < 1e-12);
    assert_eq!((told[1].visits, told[1].value), (1, 0.4));

    let worth = |s: &Sequence| 1.0 / s.states.len() as f64;
    let mut found = vec![next];
    found.extend(paid(&mut search, 300, worth));
    let rewards = 0.8 + 0.4 + found[1..].iter().map(worth).sum::<f64>();
    let root = search.statistics(&found[0].states)[0];
    assert!(root.visits >= 302, "{root:?}");
    let sum = f64::from(root.visits) * root.value;
    assert!(sum > rewards - 1e-9, "{sum}, {rewards} were told");
    // Every descent but the first went on to a child, and from there on.
    let seconds: BTreeSet<_> = found.iter().map(|s| s.states[..2].to_vec()).collect();
    let of = |beginning: &Vec<ContactState>| search.statistics(beginning).get(1).copied();
    let children: Vec<_> = seconds.iter().filter_map(of).collect();
    assert!(children.len() > 3);
    let visits: u32 = children.iter().map(|x| x.visits).sum();
    assert_eq!(visits + 1, root.visits);
    let sums = children.iter().map(|x| f64::from(x.visits) * x.value);
    assert!((sums.sum::<f64>() + 0.8 - sum).abs() < 1e-9);
}

#[test]
fn searches_without_a_tree_have_no_statistics() {
    let mut search = best_first(pick_place());
    let sequence = search.next(&mut AcceptAll).expect("a sequence");
    assert!(search.statistics(&sequence.states).is_empty());
}

/// Refuses the right hand.
struct NoRight;

impl Oracle for NoRight {
    fn state(&mut self, state: &ContactState) -> Verdict {
        let hand = id(&one_box(3), "right_hand");
        if state.partner(hand).is_some() {
            return Verdict::Reject("the right hand is hurt".into());
        }
        Verdict::Accept
    }
}
#[test]
fn what_the_oracle_refuses_and_what_is_taken_back_never_comes() {
    let hand = id(&one_box(3), "right_hand");
    let mut search = tree(3);
    let mut taken_back: Option<Vec<ContactState>> = None;
    for n in 0..100 {
        let sequence = search.next(&mut NoRight).expect("the left hand does it");
        assert!(sequence.states.iter().all(|s| s.partner(hand).is_none()));
        if let Some(prefix) = &taken_back {
            assert!(
                !sequence.states.starts_with(prefix),
                "{:?}",
                sequence.labels
            );
        }
        if n == 20 {
            let prefix = sequence.states[..2].to_vec();
            search.reject(Rejected::Prefix(prefix.clone()), "too far".to_owned());
            taken_back = Some(prefix);
        }
    }
}

/// Refuses all contacts of hands, and nothing else.
struct NoHands;

impl Oracle for NoHands {
    fn state(&mut self, state: &ContactState) -> Verdict {
        let domain = one_box(3);
        let hands = ["left_hand", "right_hand"].map(|hand| id(&domain, hand));
        let of_hand = |c: &Contact| hands.contains(&c.a);
        match state.iter().find(of_hand) {
            Some(contact) => Verdict::RejectContacts(
                std::iter::once(contact).collect(),
                "no hand fits".to_owned(),
            ),
            None => Verdict::Accept,
        }
    }
}

#[test]
fn where_no_skeleton_is_left_all_policies_say_so_at_once() {
    let limits = SearchLimits::default();
    let mut policies: [Box<dyn Policy>; 3] = [
        Box::new(tree(0)),
        Box::new(best_first(pick_place())),
        Box::new(Rollouts::new(pick_place(), &limits, Costs::default(), 0)),
    ];
    for policy in &mut policies {
        assert!(policy.next(&mut NoHands).is_none());
        assert_eq!(policy.status(), Status::NoSkeleton);
    }
}

#[test]
fn a_small_problem_is_exhausted() {
    let limits = SearchLimits {
        max_phases: Some(7),
        ..SearchLimits::default()
    };
    let mut known = symbolic::BestFirst::new(pick_place(), &limits, Costs::default());
    let all = std::iter::from_fn(|| known.next(&mut AcceptAll)).count();
    let mut search = TreeSearch::new(pick_place(), &limits, Costs::default(), 0);
    let found = paid(&mut search, usize::MAX, |_| 0.0);
    assert_eq!((found.len(), search.status()), (all, Status::Exhausted));
}

#[test]
fn two_boxes_come_in_both_orders() {
    let mut search = TreeSearch::new(two_box(), &SearchLimits::default(), Costs::default(), 0);
    let found = paid(&mut search, 100, |_| 0.5);
    let first: BTreeSet<_> = found.iter().map(|s| s.skeleton[0].clone()).collect();
    assert!(first.len() >= 2, "{first:?}");
}

#[test]
fn where_any_state_may_be_the_last_the_start_alone_comes_too_and_all_else() {
    let limits = SearchLimits {
        max_phases: Some(4),
        ending: Some(Ending::Every),
        ..SearchLimits::default()
    };
    let graph = || with_goal(one_box(2), Goal::default());
    let mut known = symbolic::BestFirst::new(graph(), &limits, Costs::default());
    let all: BTreeSet<_> = std::iter::from_fn(|| known.next(&mut AcceptAll))
        .map(|s| s.states)
        .collect();
    let mut search = TreeSearch::new(graph(), &limits, Costs::default(), 0);
    let found = paid(&mut search, usize::MAX, |_| 0.5);
    assert_eq!(search.status(), Status::Exhausted);
    let found: BTreeSet<_> = found.into_iter().map(|s| s.states).collect();
    assert!(found.iter().any(|states| states.len() == 1));
    assert_eq!(found.len(), all.len());
    assert_eq!(found, all);
}

#[test]
fn sequences_that_are_hardly_long_enough_come_later() {
    let long = |likely_phases: usize| {
        let limits = SearchLimits {
            max_phases: Some(13),
            likely_phases,
            ending: Some(Ending::Every),
            ..SearchLimits::default()
        };
        let graph = with_goal(one_box(2), Goal::default());
        let mut search = TreeSearch::new(graph, &limits, Costs::default(), 0);
        let found = paid(&mut search, 40, |_| 0.5);
        found.iter().filter(|s| s.states.len() >= 9).count()
    };
    assert!(long(1) < 10, "{}", long(1));
    assert!(long(9) > 30, "{}", long(9));
}

/// Refuses to have the right hand in contact from the fourth state on; pauses wherever it can, or never.
struct Hesitant {
    pauses: bool,
}

impl Oracle for Hesitant {
    fn prefix(&mut self, states: &[&ContactState]) -> Verdict {
        let domain = one_box(3);
        let held = |s: &ContactState| s.partner(id(&domain, "right_hand")).is_some();
        if states.len() > 3 && states.last().is_some_and(|s| held(s)) {
            return Verdict::Reject("too late for the right hand".to_owned());
        }
        Verdict::Accept
    }

    fn pause(&mut self) -> bool {
        self.pauses
    }
}

#[test]
fn a_search_that_pauses_comes_to_the_same_sequences() {
    let drawn = |pauses: bool| {
        let (mut search, mut oracle) = (tree(3), Hesitant { pauses });
        let (mut found, mut breaks) = (vec![], 0);
        while found.len() < 60 {
            if let Some(sequence) = search.next(&mut oracle) {
                search.learn(&sequence.states, 0.3);
                found.push(sequence.states);
            } else {
                assert_eq!(search.status(), Status::Stopped);
                breaks += 1;
            }
        }
        (found, breaks)
    };
    let (found, breaks) = drawn(true);
    assert!(breaks > 0);
    assert_eq!((found, 0), drawn(false));
}
