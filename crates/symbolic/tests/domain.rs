//! Domains: possible contacts, goals, and every error message.

use crate::fixtures::{
    bottom, handle, id, interface, one_box, robot, standing, state, surface, two_boxes,
};
use symbolic::{
    Contact, ContactType, Domain, Goal, GoalPair, GraphOptions, Interface, InterfaceId, Owner,
    Role, SkeletonGraph, SymbolicError,
};

/// `a on b` for all possible contacts.
fn names(domain: &Domain) -> Vec<String> {
    domain
        .contacts()
        .iter()
        .map(|contact| domain.contact_name(contact))
        .collect()
}

#[test]
fn one_box_and_one_table_have_the_contacts_that_one_lists_by_hand() {
    let expected = [
        "left_foot on red_box_bottom",
        "left_foot on ground_top",
        "left_foot on table_a_top",
        "right_foot on red_box_bottom",
        "right_foot on ground_top",
        "right_foot on table_a_top",
        "left_hand on red_box_bottom",
        "left_hand holds red_box_handle",
        "left_hand on ground_top",
        "left_hand on table_a_top",
        "right_hand on red_box_bottom",
        "right_hand holds red_box_handle",
        "right_hand on ground_top",
        "right_hand on table_a_top",
        "red_box_bottom on ground_top",
        "red_box_bottom on table_a_top",
    ];
    assert_eq!(names(&one_box(1)), expected);
}

#[test]
fn a_point_touches_patches_by_point_types_only() {
    let point = [ContactType::UnilateralPoint];
    let both = [ContactType::UnilateralPoint, ContactType::UnilateralPatch];
    let interfaces = vec![
        interface("toe", Owner::Robot, Role::Foot, &point),
        interface("sole", Owner::Robot, Role::Foot, &both),
        interface("ground", Owner::Static(0), Role::Surface, &both),
        interface("nail", Owner::Static(1), Role::Surface, &point),
    ];
    let domain = Domain::new(interfaces, vec![], vec![]).expect("the domain is valid");
    assert_eq!(
        names(&domain),
        ["toe on ground", "sole on ground"],
        "a patch as a point, or a point below, is none"
    );
    assert_eq!(domain.contacts()[0].kind, ContactType::UnilateralPoint);
    assert_eq!(domain.contacts()[1].kind, ContactType::UnilateralPatch);
}

#[test]
fn two_bottoms_may_meet_either_way_a_top_never_lands() {
    let interfaces = vec![
        bottom("low_bottom", 0),
        surface("low_top", Owner::Object(0)),
        bottom("high_bottom", 1),
        surface("high_top", Owner::Object(1)),
    ];
    let domain = Domain::new(interfaces, vec!["low".into(), "high".into()], vec![])
        .expect("the domain is valid");
    let expected = [
        "low_bottom on high_bottom",
        "low_bottom on high_top",
        "high_bottom on low_bottom",
        "high_bottom on low_top",
    ];
    assert_eq!(names(&domain), expected);
}

#[test]
fn a_goal_holds_in_either_order_and_with_the_type_if_one_is_given() {
    let domain = one_box(1);
    let there = standing(&domain, "red_box_bottom on table_a_top");
    let (box_, table) = (id(&domain, "red_box_bottom"), id(&domain, "table_a_top"));
    assert!(
        Goal::of_pairs([(box_, table)]).holds(&there)
            && Goal::of_pairs([(table, box_)]).holds(&there)
    );
    let typed = |kind| Goal {
        pairs: vec![GoalPair {
            kind: Some(kind),
            ..GoalPair::new(table, box_)
        }],
    };
    assert!(typed(ContactType::UnilateralPatch).holds(&there));
    assert!(!typed(ContactType::BilateralPatch).holds(&there));
    assert!(!Goal::of_pairs([(box_, id(&domain, "ground_top"))]).holds(&there));
    assert!(Goal::default().holds(&there), "the empty goal always holds");
}

#[test]
fn states_read_as_a_person_would_say_them() {
    let domain = one_box(1);
    let held = state(
        &domain,
        "left_foot on ground_top, left_hand on red_box_handle",
    );
    assert_eq!(
        held.display(&domain).to_string(),
        "left_foot on ground_top, left_hand holds red_box_handle"
    );
    assert_eq!(
        state(&domain, "").display(&domain).to_string(),
        "no contact"
    );
}

#[test]
fn feet_keep_off_a_surface_that_bears_none_and_hands_do_not() {
    let kind = ContactType::UnilateralPatch;
    let table = Interface {
        bears_feet: false,
        ..surface("table", Owner::Static(0))
    };
    let interfaces = vec![
        interface("foot", Owner::Robot, Role::Foot, &[kind]),
        interface("hand", Owner::Robot, Role::Hand, &[kind]),
        table,
        surface("ground", Owner::Static(1)),
    ];
    let domain = Domain::new(interfaces, vec![], vec![]).expect("a domain");
    let lands = |a: usize, b: usize| {
        let (a, b) = (InterfaceId(a), InterfaceId(b));
        domain.allows(&Contact { a, b, kind })
    };
    assert_eq!([lands(0, 2), lands(1, 2), lands(0, 3)], [false, true, true]);
}

fn refuse(interfaces: Vec<Interface>, objects: &[&str], squeezes: &[(usize, usize)]) -> String {
    let squeezes = squeezes
        .iter()
        .map(|&(a, b)| (InterfaceId(a), InterfaceId(b)))
        .collect();
    let objects = objects.iter().map(|&name| name.to_owned()).collect();
    Domain::new(interfaces, objects, squeezes)
        .expect_err("the domain is wrong")
        .to_string()
}

#[test]
fn a_wrong_domain_is_refused_by_name() {
    let ground = || surface("ground", Owner::Static(0));
    assert!(refuse(vec![ground(), ground()], &[], &[]).contains("\"ground\" is used twice"));
    assert!(refuse(vec![], &["box", "box"], &[]).contains("\"box\" is used twice"));
    let mute = Interface {
        contact_types: vec![],
        ..ground()
    };
    assert!(refuse(vec![mute], &[], &[]).starts_with("interface \"ground\": no contact type"));
    let point = Interface {
        patch: false,
        ..ground()
    };
    assert!(
        refuse(vec![point], &[], &[])
            .contains("\"ground\": it is a point, so it cannot support \"unilateral_patch\"")
    );
    let lost = refuse(vec![bottom("box_bottom", 1)], &["box"], &[]);
    assert_eq!(
        lost,
        "interface \"box_bottom\": object number 1, but there are only 1"
    );
    let hoof = Interface {
        role: Role::Foot,
        ..ground()
    };
    assert!(refuse(vec![hoof], &[], &[]).contains("only the robot has feet and hands"));
    let two = || {
        vec![
            bottom("bottom", 0),
            surface("top", Owner::Object(0)),
            ground(),
        ]
    };
    for squeeze in [(0, 0), (0, 2)] {
        assert!(
            refuse(two(), &["box"], &[squeeze])
                .contains("expected two different patches of one object")
        );
    }
    assert_eq!(
        refuse(two(), &["box"], &[(0, 3)]),
        "interface number 3, but there are only 3"
    );
}

fn refuse_problem(domain: Domain, start: &str, goal: Goal) -> SymbolicError {
    let start = state(&domain, start);
    SkeletonGraph::new(domain, start, goal, GraphOptions::default())
        .expect_err("the problem is wrong")
}

#[test]
fn a_wrong_start_is_refused_with_the_rule() {
    let error = refuse_problem(
        one_box(2),
        "red_box_bottom on table_a_top, red_box_bottom on table_b_top",
        Goal::default(),
    );
    assert_eq!(
        error.to_string(),
        "start contacts: \"red_box_bottom\" lands on more than one surface"
    );
    let error = refuse_problem(
        one_box(1),
        "left_hand on red_box_bottom, red_box_bottom on ground_top",
        Goal::default(),
    );
    assert!(
        error
            .to_string()
            .contains("\"red_box_bottom\" rests on something and is touched on the same side")
    );
    let domain = one_box(1);
    let mut start = standing(&domain, "red_box_bottom on table_a_top");
    let reversed = crate::fixtures::contact(&domain, "left_hand", "table_a_top");
    start.contacts.insert(symbolic::Contact {
        a: reversed.b,
        b: reversed.a,
        ..reversed
    });
    let error = SkeletonGraph::new(domain, start, Goal::default(), GraphOptions::default())
        .expect_err("reversed");
    assert!(
        error
            .to_string()
            .contains("\"table_a_top\" and \"left_hand\" can never touch as unilateral_patch")
    );
}

#[test]
fn an_impossible_goal_is_refused_with_the_rule() {
    let goal = |a: &str, b: &str| {
        let domain = two_boxes(2);
        Goal::of_pairs([(id(&domain, a), id(&domain, b))])
    };
    let message = |a, b| refuse_problem(two_boxes(2), "", goal(a, b)).to_string();
    assert!(
        message("table_a_top", "table_b_top").contains("static bodies do not touch each other")
    );
    assert!(message("left_hand", "left_foot").contains("a body does not touch itself"));
    assert!(message("left_foot", "left_foot").contains("no interface touches itself"));
    assert!(message("red_box_handle", "table_a_top").contains("the landing side comes first"));
    assert!(message("left_foot", "red_box_handle").contains("points and patches match"));
    let beyond = Goal::of_pairs([(InterfaceId(0), InterfaceId(99))]);
    assert_eq!(
        refuse_problem(one_box(1), "", beyond).to_string(),
        "interface number 99, but there are only 8"
    );
}

#[test]
fn a_domain_without_robot_or_handle_is_valid_but_leads_nowhere() {
    let mut interfaces = robot();
    interfaces.push(bottom("box_bottom", 0));
    interfaces.push(surface("ground_top", Owner::Static(0)));
    interfaces.push(surface("table_top", Owner::Static(1)));
    let domain = Domain::new(interfaces, vec!["box".into()], vec![]).expect("the domain is valid");
    let goal = Goal::of_pairs([(id(&domain, "box_bottom"), id(&domain, "table_top"))]);
    let start = state(&domain, "box_bottom on ground_top");
    let graph = SkeletonGraph::new(domain, start, goal, GraphOptions::default())
        .expect("the problem is valid");
    assert_eq!(graph.shortest_skeleton(), None, "nobody can grasp the box");
    assert!(!handle("handle", 0).lands);
}
