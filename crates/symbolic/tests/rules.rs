//! States, transitions and their rules, against all subsets of the possible contacts.

use std::collections::BTreeSet;

use crate::fixtures::{bottom, contact, interface, one_box, state, surface};
use symbolic::state_rules::{
    StateFault, both_sides, impossible_contact, state_fault, two_partners,
};
use symbolic::transition_rules::{
    TransitionFault, partner_change, repetition, side_swap, transition_fault,
};
use symbolic::{Action, ContactState, ContactType, Domain, Owner, Role, successors};

/// One foot, two boxes that can rest on each other, ground and table: 10 contacts, 1024 sets.
pub fn tiny() -> Domain {
    let interfaces = vec![
        interface(
            "foot",
            Owner::Robot,
            Role::Foot,
            &[ContactType::UnilateralPatch],
        ),
        bottom("one_bottom", 0),
        bottom("two_bottom", 1),
        surface("ground", Owner::Static(0)),
        surface("table", Owner::Static(1)),
    ];
    Domain::new(interfaces, vec!["one".into(), "two".into()], vec![]).expect("the domain is valid")
}

/// Every set of possible contacts.
pub fn all_sets(domain: &Domain) -> Vec<ContactState> {
    let contacts = domain.contacts();
    let chosen = |bits: usize| {
        (0..contacts.len())
            .filter(move |n| bits >> n & 1 == 1)
            .map(|n| contacts[n])
            .collect()
    };
    (0..1 << contacts.len()).map(chosen).collect()
}

/// The rules again, in the words of the documentation.
fn is_state(state: &ContactState) -> bool {
    state.iter().all(|one| {
        state
            .iter()
            .all(|two| (one == two || one.a != two.a) && one.b != two.a)
    })
}

fn is_transition(from: &ContactState, to: &ContactState) -> bool {
    let keeps = |one: &symbolic::Contact| {
        to.iter()
            .all(|two| two == *one || (two.a != one.a && (two.a, two.b) != (one.b, one.a)))
    };
    from != to && from.iter().all(|one| keeps(&one))
}

#[test]
fn legal_states_are_those_of_brute_force() {
    let domain = tiny();
    let legal = all_sets(&domain)
        .iter()
        .filter(|state| is_state(state))
        .count();
    let found = all_sets(&domain)
        .iter()
        .filter(|state| state_fault(&domain, state).is_none())
        .count();
    assert_eq!(found, legal);
    // Boxes: none rests (5 places for the foot), one on ground or table (2·2·4), both (4·3), one on the other (2·4).
    assert_eq!(legal, 5 + 16 + 12 + 8);
}

#[test]
fn successors_are_those_of_brute_force() {
    let domain = tiny();
    let states: Vec<ContactState> = all_sets(&domain).into_iter().filter(is_state).collect();
    for from in &states {
        let expected: BTreeSet<&ContactState> =
            states.iter().filter(|to| is_transition(from, to)).collect();
        let found = successors(&domain, from, 3);
        assert_eq!(
            found.len(),
            expected.len(),
            "none twice from {}",
            from.display(&domain)
        );
        assert_eq!(
            found.iter().map(|(_, to)| to).collect::<BTreeSet<_>>(),
            expected
        );
        assert!(found.iter().all(|(action, to)| from.after(action) == *to));
        let single = successors(&domain, from, 1);
        assert_eq!(single, found[..single.len()], "fewer changes come first");
        assert!(
            single
                .iter()
                .all(|(action, _)| action.changes().count() == 1)
        );
    }
}

#[test]
fn each_state_rule_names_what_breaks_it() {
    let domain = one_box(2);
    let legal = state(
        &domain,
        "left_foot on ground_top, right_foot on ground_top, red_box_bottom on table_a_top",
    );
    assert_eq!(
        state_fault(&domain, &legal),
        None,
        "a ground holds any number of partners"
    );
    assert_eq!(
        state_fault(&domain, &ContactState::default()),
        None,
        "flight, and a box in the air, are legal"
    );

    let mut two = legal.clone();
    two.contacts
        .insert(contact(&domain, "left_foot", "table_a_top"));
    assert_eq!(
        two_partners(&two),
        Some(StateFault::TwoPartners(
            domain.find("left_foot").expect("exists")
        ))
    );

    let mut under = legal.clone();
    under
        .contacts
        .insert(contact(&domain, "left_hand", "red_box_bottom"));
    assert_eq!(
        both_sides(&under),
        Some(StateFault::BothSides(
            domain.find("red_box_bottom").expect("exists")
        ))
    );

    let foot = contact(&domain, "left_foot", "ground_top");
    let bilateral = symbolic::Contact {
        kind: ContactType::BilateralPatch,
        ..foot
    };
    let stuck: ContactState = [bilateral].into_iter().collect();
    assert_eq!(
        impossible_contact(&domain, &stuck),
        Some(StateFault::Impossible(bilateral))
    );
}

#[test]
fn a_mirrored_pair_is_no_state() {
    let domain = tiny();
    let mirrored = state(
        &domain,
        "one_bottom on two_bottom, two_bottom on one_bottom",
    );
    assert!(matches!(
        state_fault(&domain, &mirrored),
        Some(StateFault::BothSides(_))
    ));
}

#[test]
fn a_foot_changes_surface_only_through_the_air() {
    let domain = one_box(2);
    let (ground, table, air) = (
        state(&domain, "left_foot on ground_top"),
        state(&domain, "left_foot on table_a_top"),
        state(&domain, ""),
    );
    let foot = domain.find("left_foot").expect("exists");
    assert_eq!(
        partner_change(&ground, &table),
        Some(TransitionFault::PartnerChange(foot))
    );
    assert_eq!(transition_fault(&ground, &air), None);
    assert_eq!(transition_fault(&air, &table), None);
    assert_eq!(repetition(&air, &air), Some(TransitionFault::Repetition));
    assert!(
        TransitionFault::PartnerChange(foot)
            .describe(&domain)
            .contains("\"left_foot\" changes its partner")
    );
    assert_eq!(
        TransitionFault::Repetition.describe(&domain),
        "nothing changes"
    );
    let none = successors(&domain, &ground, 4)
        .iter()
        .any(|(_, to)| to.contains(&table.iter().next().expect("one")));
    assert!(
        !none,
        "no action leads from one surface to the other at once"
    );
}

#[test]
fn a_contact_changes_its_type_only_through_a_free_state() {
    let kinds = [ContactType::UnilateralPatch, ContactType::BilateralPatch];
    let interfaces = vec![
        interface("hand", Owner::Robot, Role::Hand, &kinds),
        interface("rail", Owner::Static(0), Role::Surface, &kinds),
    ];
    let domain = Domain::new(interfaces, vec![], vec![]).expect("the domain is valid");
    let [push, hold]: [ContactState; 2] =
        [0, 1].map(|n| [domain.contacts()[n]].into_iter().collect());
    assert!(matches!(
        transition_fault(&push, &hold),
        Some(TransitionFault::PartnerChange(_))
    ));
    assert_eq!(
        successors(&domain, &push, 2),
        [(
            Action::between(&push, &ContactState::default()),
            ContactState::default()
        )]
    );
}

#[test]
fn two_surfaces_exchange_sides_only_by_coming_apart() {
    let domain = tiny();
    let (one, two) = (
        state(&domain, "one_bottom on two_bottom"),
        state(&domain, "two_bottom on one_bottom"),
    );
    let fault = side_swap(&one, &two).expect("the sides are exchanged");
    assert!(
        fault
            .describe(&domain)
            .contains("exchange sides without coming apart")
    );
    assert!(transition_fault(&one, &two).is_some());
    assert_eq!(side_swap(&one, &ContactState::default()), None);
}
