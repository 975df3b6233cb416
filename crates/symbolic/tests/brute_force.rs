//! All skeletons of at most N actions against an enumeration that knows only contacts: none missed, none twice.

use std::collections::BTreeSet;

use crate::fixtures::{
    bottom, contact, handle, interface, one_box, robot, state, surface, two_boxes,
};
use crate::skeletons::graph;
use symbolic::{
    Contact, ContactState, ContactType, Domain, Interface, InterfaceId, Owner, Role, SkeletonGraph,
    TaskState,
};

/// All skeletons by depth-first search over sets of contacts, without a look at facts, operators or distances.
struct BruteForce<'d> {
    domain: &'d Domain,
    goal: &'d dyn Fn(&ContactState) -> bool,
    max_actions: usize,
    /// Objects of which the goal says nothing: whether they have been lifted is part of a manipulation state.
    elsewhere: Vec<usize>,
    found: Vec<Vec<ContactState>>,
}

impl BruteForce<'_> {
    fn object(&self, contact: &Contact) -> Option<usize> {
        self.domain.object_of(contact.a)
    }

    fn hand_contacts(&self, state: &ContactState, object: usize) -> Vec<Contact> {
        state
            .iter()
            .filter(|c| self.object(c).is_none() && self.domain.object_of(c.b) == Some(object))
            .collect()
    }

    fn rests(&self, state: &ContactState, object: usize) -> Vec<Contact> {
        state
            .iter()
            .filter(|c| self.object(c) == Some(object))
            .collect()
    }

    /// The contacts that hold an object, split into separate holds.
    fn holds(&self, state: &ContactState, object: usize) -> usize {
        let contacts = self.hand_contacts(state, object);
        let single = contacts
            .iter()
            .filter(|c| c.kind == ContactType::BilateralPatch)
            .count();
        single + (contacts.len() - single) / 2
    }

    fn next(&self, state: &ContactState) -> Vec<ContactState> {
        let is_hand = |c: &&Contact| c.a.0 == 2 || c.a.0 == 3;
        let on_object: Vec<Contact> = self
            .domain
            .contacts()
            .iter()
            .filter(is_hand)
            .copied()
            .filter(|c| self.domain.object_of(c.b).is_some())
            .collect();
        let opposite = |x: &Contact, y: &Contact| {
            self.domain
                .squeezes()
                .iter()
                .any(|&pair| pair == (x.b, y.b) || pair == (y.b, x.b))
        };
        let mut options: Vec<Vec<Contact>> = Vec::new();
        for (n, &x) in on_object.iter().enumerate() {
            match x.kind {
                ContactType::BilateralPatch => options.push(vec![x]),
                _ => options.extend(
                    on_object[n..]
                        .iter()
                        .filter(|y| y.a != x.a && opposite(&x, y))
                        .map(|&y| vec![x, y]),
                ),
            }
        }
        let mut next = Vec::new();
        for option in &options {
            let clash = |c: &Contact| {
                option
                    .iter()
                    .any(|o| o.a == c.a || (o.b == c.b && self.object(c).is_none()) || o.b == c.a)
            };
            if !state.iter().any(|c| clash(&c)) {
                next.push(state.iter().chain(option.iter().copied()).collect());
            }
            let object = self.domain.object_of(option[0].b).expect("on an object");
            let stays = !self.rests(state, object).is_empty() || self.holds(state, object) > 1;
            if option.iter().all(|c| state.contains(c)) && stays {
                next.push(state.iter().filter(|c| !option.contains(c)).collect());
            }
        }
        for object in 0..self.domain.objects().len() {
            if self.holds(state, object) == 0 {
                continue;
            }
            let rests = self.rests(state, object);
            if !rests.is_empty() {
                next.push(state.iter().filter(|c| !rests.contains(c)).collect());
                continue;
            }
            for &place in self
                .domain
                .contacts()
                .iter()
                .filter(|c| self.object(c) == Some(object))
            {
                let under = self.domain.object_of(place.b);
                let rests_elsewhere = |o: usize| {
                    self.rests(state, o)
                        .iter()
                        .any(|c| self.domain.object_of(c.b) != Some(object))
                };
                let covered = state.iter().any(|c| c.b == place.a || c.a == place.b);
                if !covered && under.is_none_or(rests_elsewhere) {
                    next.push(state.iter().chain([place]).collect());
                }
            }
        }
        next
    }

    fn run(&mut self, path: &mut Vec<(ContactState, BTreeSet<usize>)>) {
        let (state, moved) = path.last().expect("the start is there").clone();
        if (self.goal)(&state) {
            self.found
                .push(path.iter().map(|(state, _)| state.clone()).collect());
            return;
        }
        if path.len() > self.max_actions {
            return;
        }
        for next in self.next(&state) {
            let lifted = self
                .elsewhere
                .iter()
                .filter(|&&o| !self.rests(&state, o).is_empty() && self.rests(&next, o).is_empty());
            let moved = moved.iter().chain(lifted).copied().collect();
            let step = (next, moved);
            if !path.contains(&step) {
                path.push(step);
                self.run(path);
                path.pop();
            }
        }
    }
}

/// The skeletons of a graph as sequences of imposed contacts.
fn imposed_sequences(graph: &SkeletonGraph) -> Vec<Vec<ContactState>> {
    let imposed = |state| graph.imposed(state).clone();
    let sequence = |plan: Vec<symbolic::TaskEdge>| {
        std::iter::once(TaskState(0))
            .chain(plan.iter().map(|edge| edge.to))
            .map(imposed)
            .collect()
    };
    graph.skeletons().plans().map(sequence).collect()
}

fn compare(domain: &Domain, rests: &str, goal: &[(&str, &str)], max_actions: usize) -> usize {
    let graph = graph(domain, rests, goal, Some(max_actions));
    let pairs: Vec<Contact> = goal.iter().map(|(a, b)| contact(domain, a, b)).collect();
    let touch = |state: &ContactState, pair: &Contact| {
        let same = |c: Contact| (c.a, c.b) == (pair.a, pair.b);
        state.iter().any(same)
    };
    let holds = |state: &ContactState| {
        let objects: BTreeSet<_> = pairs
            .iter()
            .flat_map(|c| [c.a, c.b])
            .filter_map(|i| domain.object_of(i))
            .collect();
        let held = |c: &Contact| {
            domain.object_of(c.a).is_none()
                && domain.object_of(c.b).is_some_and(|o| objects.contains(&o))
        };
        pairs.iter().all(|pair| touch(state, pair)) && !state.iter().any(|c| held(&c))
    };
    let mut brute = BruteForce {
        domain,
        goal: &holds,
        max_actions,
        elsewhere: (0..domain.objects().len())
            .filter(|&o| {
                let ids = pairs.iter().flat_map(|c| [c.a, c.b]);
                ids.into_iter().all(|id| domain.object_of(id) != Some(o))
            })
            .collect(),
        found: Vec::new(),
    };
    brute.run(&mut vec![(state(domain, rests), BTreeSet::new())]);
    let mut found = imposed_sequences(&graph);
    assert!(found.is_sorted_by_key(Vec::len), "shortest first");
    let count = found.len();
    found.sort();
    found.dedup();
    assert_eq!(found.len(), count, "none twice");
    brute.found.sort();
    let missing = |all: &[Vec<ContactState>], of: &[Vec<ContactState>]| {
        let missing = all.iter().filter(|one| of.binary_search(one).is_err());
        let words = missing.map(|states| {
            states
                .iter()
                .map(|s| s.display(domain).to_string())
                .collect::<Vec<_>>()
        });
        words.take(1).collect::<Vec<_>>()
    };
    let (missed, extra) = (missing(&brute.found, &found), missing(&found, &brute.found));
    assert!(
        missed.is_empty() && extra.is_empty(),
        "missed {missed:#?}, too many {extra:#?}"
    );
    count
}

#[test]
fn skeletons_of_one_box_are_those_of_brute_force() {
    let count = compare(
        &one_box(3),
        "red_box_bottom on table_a_top",
        &[("red_box_bottom", "table_b_top")],
        8,
    );
    // Either hand; or one hand to the ground or table c and the other hand from there. The same hand twice would
    // hold the box in the air twice.
    assert_eq!(count, 2 + 2 * 2);
}

#[test]
fn skeletons_of_two_boxes_are_those_of_brute_force() {
    let goal = [
        ("red_box_bottom", "table_c_top"),
        ("green_box_bottom", "table_c_top"),
    ];
    let rests = "red_box_bottom on table_a_top, green_box_bottom on table_b_top";
    // Either box first, two ways to hold each.
    assert_eq!(compare(&two_boxes(3), rests, &goal, 8), 8);
    assert!(compare(&two_boxes(3), rests, &goal, 9) >= 8);
}

#[test]
fn boxes_with_handles_interleave_as_in_brute_force() {
    let mut interfaces = robot();
    for (n, name) in ["one", "two"].into_iter().enumerate() {
        interfaces.push(bottom(&format!("{name}_bottom"), n));
        interfaces.push(handle(&format!("{name}_handle"), n));
    }
    interfaces.push(surface("table_top", Owner::Static(0)));
    interfaces.push(surface("shelf_top", Owner::Static(1)));
    interfaces.push(surface("ground_top", Owner::Static(2)));
    let domain = Domain::new(interfaces, vec!["one".into(), "two".into()], vec![])
        .expect("the domain is valid");
    let goal = [("one_bottom", "shelf_top"), ("two_bottom", "shelf_top")];
    let count = compare(
        &domain,
        "one_bottom on table_top, two_bottom on table_top",
        &goal,
        8,
    );
    // Two chains of four actions: C(8, 4) = 70 interleavings for two different hands, 2 orders for the same hand.
    assert_eq!(count, 2 * 70 + 2 * 2);
}

/// Boxes in order, each with its bottom and what else is named by its end: `top`, `handle` or any other patch.
fn boxes(list: &[(&str, &[&str])], supports: &[&str], squeezes: &[(&str, &str)]) -> Domain {
    let mut interfaces = robot();
    for (n, (name, parts)) in list.iter().enumerate() {
        interfaces.push(bottom(&format!("{name}_bottom"), n));
        for part in *parts {
            let full = format!("{name}_{part}");
            interfaces.push(match *part {
                "handle" | "grip" => handle(&full, n),
                "side" => bottom(&full, n),
                _ => surface(&full, Owner::Object(n)),
            });
        }
    }
    let supports = supports.iter().enumerate();
    interfaces.extend(supports.map(|(n, name)| surface(name, Owner::Static(n))));
    domain_of(interfaces, list.iter().map(|(name, _)| *name), squeezes)
}

fn domain_of<'a>(
    interfaces: Vec<Interface>,
    objects: impl Iterator<Item = &'a str>,
    squeezes: &[(&str, &str)],
) -> Domain {
    let find = |name: &str| {
        interfaces
            .iter()
            .position(|i| i.name == name)
            .expect("exists")
    };
    let pairs = squeezes
        .iter()
        .map(|(a, b)| (InterfaceId(find(a)), InterfaceId(find(b))));
    let pairs = pairs.collect();
    Domain::new(interfaces, objects.map(str::to_owned).collect(), pairs)
        .expect("the domain is valid")
}

#[test]
fn three_boxes_are_stacked_as_in_brute_force() {
    let parts: &[&str] = &["top", "handle"];
    let list = [("one", parts), ("two", parts), ("three", parts)];
    let domain = boxes(&list, &["ground_top", "table_top"], &[]);
    let rests = "one_bottom on ground_top, two_bottom on ground_top, three_bottom on table_top";
    // Box one onto box two, with at most two actions beside grasp, lift, place, release by either hand.
    assert!(compare(&domain, rests, &[("one_bottom", "two_top")], 6) > 2);
}

#[test]
fn a_stack_that_is_taken_apart_with_squeezes_is_that_of_brute_force() {
    let parts: &[&str] = &["top", "left", "right"];
    let list = [("low", parts), ("high", parts)];
    let squeezes = [("low_left", "low_right"), ("high_left", "high_right")];
    let domain = boxes(&list, &["ground_top", "table_top"], &squeezes);
    let rests = "low_bottom on ground_top, high_bottom on low_top";
    // The upper box may come along with the lower one.
    assert!(compare(&domain, rests, &[("low_bottom", "table_top")], 8) > 2);
    let goal = [("high_bottom", "table_top"), ("low_bottom", "high_top")];
    // One after the other, each squeezed in two ways.
    assert_eq!(compare(&domain, rests, &goal, 8), 4);
}

#[test]
fn handing_over_and_holding_with_both_hands_are_those_of_brute_force() {
    let domain = boxes(
        &[("bar", &["handle", "grip"])],
        &["table_top", "shelf_top", "ground_top"],
        &[],
    );
    for max_actions in 4..9 {
        let goal = [("bar_bottom", "shelf_top")];
        let count = compare(&domain, "bar_bottom on table_top", &goal, max_actions);
        assert_eq!(
            count == 4,
            max_actions < 6,
            "{max_actions}: two hands, two places"
        );
    }
}

#[test]
fn a_box_that_is_turned_onto_its_side_is_that_of_brute_force() {
    let domain = boxes(
        &[("box", &["side", "handle"])],
        &["table_top", "ground_top"],
        &[],
    );
    let rests = "box_bottom on table_top";
    assert_eq!(compare(&domain, rests, &[("box_side", "table_top")], 4), 2);
    // Also by way of the ground, on either face, with the other hand from there.
    assert_eq!(
        compare(&domain, rests, &[("box_side", "table_top")], 8),
        2 + 2 * 2
    );
}

#[test]
fn swapping_two_boxes_is_that_of_brute_force() {
    let list: [(&str, &[&str]); 2] = [("one", &["handle"]), ("two", &["left", "right"])];
    let domain = boxes(
        &list,
        &["table_top", "shelf_top", "ground_top"],
        &[("two_left", "two_right")],
    );
    let goal = [("one_bottom", "shelf_top"), ("two_bottom", "table_top")];
    // Either box first, two ways to hold each.
    assert_eq!(
        compare(
            &domain,
            "one_bottom on table_top, two_bottom on shelf_top",
            &goal,
            8
        ),
        8
    );
}

#[test]
fn surfaces_that_hold_what_is_put_on_them_are_those_of_brute_force() {
    let sticky = [ContactType::UnilateralPatch, ContactType::BilateralPatch];
    let mut interfaces = robot();
    interfaces.push(Interface {
        lands: true,
        bears_feet: true,
        ..interface("plug_bottom", Owner::Object(0), Role::Surface, &sticky)
    });
    interfaces.push(handle("plug_handle", 0));
    interfaces.push(surface("ground_top", Owner::Static(0)));
    interfaces.push(interface(
        "socket",
        Owner::Static(1),
        Role::Surface,
        &sticky,
    ));
    let domain = domain_of(interfaces, ["plug"].into_iter(), &[]);
    // Two hands; it lies on the socket or is held by it.
    assert_eq!(
        compare(
            &domain,
            "plug_bottom on ground_top",
            &[("plug_bottom", "socket")],
            4
        ),
        4
    );
}
