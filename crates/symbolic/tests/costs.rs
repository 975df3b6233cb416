//! The default order: what each penalty is charged for, one at a time.

use crate::fixtures::{bottom, handle, id, robot, state, surface};
use symbolic::{
    BestFirst, ContactState, Costs, Domain, Goal, GraphOptions, Oracle, Owner, Policy,
    SearchLimits, SkeletonGraph, Verdict,
};

/// A box that can rest on its bottom or its side, ground, two tables.
fn domain() -> Domain {
    let mut interfaces = robot();
    interfaces.push(bottom("box_bottom", 0));
    interfaces.push(bottom("box_side", 0));
    interfaces.push(handle("box_handle", 0));
    interfaces.push(surface("ground", Owner::Static(0)));
    interfaces.push(surface("table", Owner::Static(1)));
    interfaces.push(surface("shelf", Owner::Static(2)));
    Domain::new(interfaces, vec!["box".into()], vec![]).expect("the domain is valid")
}

/// Accepts the beginnings of one sequence only.
struct Only(Vec<ContactState>);

impl Oracle for Only {
    fn prefix(&mut self, states: &[&ContactState]) -> Verdict {
        let begins = states.len() <= self.0.len()
            && states.iter().zip(&self.0).all(|(one, two)| **one == *two);
        if begins {
            Verdict::Accept
        } else {
            Verdict::Reject("another sequence".into())
        }
    }
}

/// Cost of the sequence of these states; `goal` is where the box or a hand is in the last one.
fn cost(costs: Costs, states: &[&str], goal: (&str, &str)) -> f64 {
    let domain = domain();
    let states: Vec<ContactState> = states.iter().map(|text| state(&domain, text)).collect();
    let goal = Goal::of_pairs([(id(&domain, goal.0), id(&domain, goal.1))]);
    let options = GraphOptions {
        max_changes: 2,
        ..GraphOptions::default()
    };
    let graph =
        SkeletonGraph::new(domain, states[0].clone(), goal, options).expect("the problem is valid");
    let limits = SearchLimits {
        max_phases: Some(states.len()),
        ..SearchLimits::default()
    };
    let mut search = BestFirst::new(graph, &limits, costs);
    let sequence = search
        .next(&mut Only(states.clone()))
        .expect("the sequence is legal");
    assert_eq!(sequence.states, states);
    sequence.cost
}

/// How often a penalty is charged.
fn charged(field: fn(&mut Costs) -> &mut f64, states: &[&str], goal: (&str, &str)) -> f64 {
    let mut costs = Costs::phases_only();
    *field(&mut costs) = 1.0;
    cost(costs, states, goal) - cost(Costs::phases_only(), states, goal)
}

const FEET: &str = "left_foot on ground, right_foot on ground";

/// Joins the feet with other contacts.
fn with_feet(rest: &str) -> String {
    format!("{FEET}, {rest}")
}

#[test]
fn phases_after_the_first_count_one_each() {
    let (start, end) = (
        with_feet("box_bottom on table"),
        with_feet("box_bottom on table, left_hand on box_handle"),
    );
    assert_eq!(
        cost(
            Costs::phases_only(),
            &[&start, &end],
            ("left_hand", "box_handle")
        ),
        1.0
    );
}

#[test]
fn changes_at_once_are_charged_beyond_the_first() {
    let box_ = "box_bottom on table";
    let (start, end) = (with_feet(box_), format!("{box_}, left_hand on box_handle"));
    let states = [start.as_str(), &end];
    assert_eq!(
        charged(
            |c| &mut c.simultaneous,
            &states,
            ("left_hand", "box_handle")
        ),
        2.0,
        "a grasp and two feet"
    );
    assert_eq!(
        charged(|c| &mut c.flight, &states, ("left_hand", "box_handle")),
        1.0
    );
    assert_eq!(
        charged(
            |c| &mut c.end_in_swing,
            &states,
            ("left_hand", "box_handle")
        ),
        2.0
    );
    assert_eq!(
        charged(
            |c| &mut c.manipulate_in_swing,
            &states,
            ("left_hand", "box_handle")
        ),
        1.0
    );
    assert_eq!(
        charged(
            |c| &mut c.step_in_grasp,
            &states,
            ("left_hand", "box_handle")
        ),
        2.0
    );
}

#[test]
fn support_by_a_hand_is_charged_when_made_not_when_broken() {
    let states = [
        with_feet("box_bottom on table"),
        with_feet("box_bottom on table, right_hand on shelf"),
        with_feet("box_bottom on table"),
        with_feet("box_bottom on table, left_hand on box_handle"),
    ];
    let states: Vec<&str> = states.iter().map(String::as_str).collect();
    assert_eq!(
        charged(
            |c| &mut c.hand_support,
            &states,
            ("left_hand", "box_handle")
        ),
        1.0
    );
    assert_eq!(
        charged(|c| &mut c.flight, &states, ("left_hand", "box_handle")),
        0.0
    );
}

#[test]
fn the_same_foot_again_and_a_new_surface_are_charged() {
    let box_ = "box_bottom on table";
    let twice = [
        with_feet(box_),
        format!("right_foot on ground, {box_}"),
        with_feet(box_),
        format!("right_foot on ground, {box_}"),
        format!("right_foot on ground, left_foot on shelf, {box_}"),
    ];
    let twice: Vec<&str> = twice.iter().map(String::as_str).collect();
    let goal = ("left_foot", "shelf");
    assert_eq!(charged(|c| &mut c.same_foot, &twice, goal), 1.0);
    assert_eq!(
        charged(|c| &mut c.new_surface, &twice, goal),
        1.0,
        "the ground carries feet at the start"
    );
    assert_eq!(charged(|c| &mut c.end_in_swing, &twice, goal), 0.0);
    assert_eq!(charged(|c| &mut c.detour, &twice, goal), 0.0);
}

#[test]
fn detours_and_turned_boxes_are_charged() {
    let held = "left_hand on box_handle";
    let states = [
        with_feet("box_bottom on table"),
        with_feet(&format!("box_bottom on table, {held}")),
        with_feet(held),
        with_feet(&format!("box_side on ground, {held}")),
        with_feet("box_side on ground"),
        with_feet("box_side on ground, right_hand on box_handle"),
        with_feet("right_hand on box_handle"),
        with_feet("box_bottom on shelf, right_hand on box_handle"),
        with_feet("box_bottom on shelf"),
    ];
    let states: Vec<&str> = states.iter().map(String::as_str).collect();
    let goal = ("box_bottom", "shelf");
    assert_eq!(
        charged(|c| &mut c.turn, &states, goal),
        1.0,
        "placed on its side once"
    );
    assert_eq!(
        charged(|c| &mut c.detour, &states, goal),
        2.0,
        "placing on the ground and letting go there"
    );
    assert_eq!(charged(|c| &mut c.manipulate_in_swing, &states, goal), 0.0);
    assert_eq!(charged(|c| &mut c.step_in_grasp, &states, goal), 0.0);
}
