//! Filters: what an oracle rejects, and what is taken back later.

use std::collections::BTreeMap;

use crate::fixtures::{contact, one_box, state};
use crate::problems::{NATURAL, best_first, pick_place, take};
use symbolic::search::{AcceptAll, Rejected, default_phases};
use symbolic::{ContactState, Costs, Domain, Oracle, Policy, Rollouts, SearchLimits, Verdict};

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
        let grasp = contact(&domain, "left_hand", "red_box_handle");
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
    let grasp = contact(&one_box(2), "left_hand", "red_box_handle");
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
    search.reject(
        Rejected::Prefix(beginning.clone()),
        "lifting fails".to_owned(),
    );
    let second = search.next(&mut AcceptAll).expect("the right hand is left");
    search.reject(
        Rejected::State(second.states[1].clone()),
        "grasping fails".to_owned(),
    );
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
        "no".to_owned(),
    );
    search.reject(
        Rejected::Contacts(state(&one_box(2), "left_foot on table_b_top")),
        "too high".to_owned(),
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
        "weak hand".to_owned(),
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
