//! Searches that look ahead, know what has not been moved, and put steps in.

use std::collections::{BTreeMap, BTreeSet};

use crate::fixtures::{bottom, contact, handle, id, one_box, robot, standing, surface, two_boxes};
use symbolic::search::AcceptAll;
use symbolic::{
    Anew, Contact, ContactState, Costs, Domain, Goal, GraphOptions, Interface, Oracle, Owner,
    Policy, SearchLimits, Sequence, SkeletonGraph, Status, TreeSearch, Verdict,
};

/// Robot, ground, a high platform and a box on whose top feet can stand.
fn climb() -> Domain {
    let mut interfaces: Vec<Interface> = robot();
    interfaces.push(bottom("box_bottom", 0));
    interfaces.push(handle("box_handle", 0));
    interfaces.push(surface("box_top", Owner::Object(0)));
    interfaces.push(surface("ground_top", Owner::Static(0)));
    interfaces.push(surface("platform_top", Owner::Static(1)));
    Domain::new(interfaces, vec!["box".to_owned()], vec![]).expect("the domain is valid")
}

fn search(domain: &Domain, seed: u64) -> TreeSearch {
    let pair = |foot| (id(domain, foot), id(domain, "platform_top"));
    let goal = Goal::of_pairs([pair("left_foot"), pair("right_foot")]);
    let options = GraphOptions {
        support_hands: false,
        ..GraphOptions::default()
    };
    let start = standing(domain, "box_bottom on ground_top");
    let graph = SkeletonGraph::new(domain.clone(), start, goal, options).expect("a problem");
    let limits = SearchLimits {
        max_phases: Some(24),
        ..SearchLimits::default()
    };
    TreeSearch::new(graph, &limits, Costs::default(), seed).with_outlook()
}

/// Legs are too short for the ground and the platform at once, and for the platform and the box where it is at first.
struct Legs {
    domain: Domain,
    asked_unmoved: usize,
}

impl Legs {
    fn has(&self, state: &ContactState, surface: &str) -> bool {
        let on = |foot| state.contains(&contact(&self.domain, foot, surface));
        on("left_foot") || on("right_foot")
    }
}

impl Oracle for Legs {
    fn state(&mut self, state: &ContactState) -> Verdict {
        if self.has(state, "ground_top") && self.has(state, "platform_top") {
            return Verdict::Reject("too high".into());
        }
        Verdict::Accept
    }

    fn transition(&mut self, from: &ContactState, to: &ContactState) -> Verdict {
        let both = from.iter().chain(to.iter()).collect();
        self.state(&both)
    }

    fn unmoved(&mut self, state: &ContactState, objects: &[usize]) -> Verdict {
        assert_eq!(objects, [0]);
        self.asked_unmoved += 1;
        if self.has(state, "box_top") && self.has(state, "platform_top") {
            return Verdict::Reject("too far".into());
        }
        Verdict::Accept
    }
}

fn position(sequence: &Sequence, of: impl Fn(&ContactState) -> bool) -> Option<usize> {
    sequence.states.iter().position(of)
}

#[test]
fn the_box_is_moved_before_it_is_climbed_and_the_first_sequence_has_no_detour() {
    let domain = climb();
    for seed in 1..=3 {
        let mut legs = Legs {
            domain: domain.clone(),
            asked_unmoved: 0,
        };
        let mut search = search(&domain, seed);
        let rests = contact(&domain, "box_bottom", "ground_top");
        let mut shortest = usize::MAX;
        for _ in 0..10 {
            let sequence = search.next(&mut legs).expect("there are many");
            let lifted = position(&sequence, |s| !s.contains(&rests)).expect("it is lifted");
            let jumps = |s: &ContactState| {
                !legs.has(s, "ground_top")
                    && !legs.has(s, "box_top")
                    && !legs.has(s, "platform_top")
            };
            let above = |s: &ContactState| legs.has(s, "platform_top");
            let up = position(&sequence, above).expect("it ends there");
            assert!(lifted < up, "{:?}", sequence.labels);
            assert!(
                position(&sequence, jumps).is_none(),
                "{:?}",
                sequence.labels
            );
            shortest = shortest.min(sequence.states.len());
            search.learn(&sequence.states, 0.3);
        }
        // Start, grasp, lift, place, release, two swings onto the box, two onto the platform; or one foot by way of the
        // box and the other past it, which no leg can do.
        assert!(shortest <= 13, "{shortest}");
        assert!(legs.asked_unmoved > 0);
    }
}

/// Compares which objects states are asked about with which still stand where they did.
struct Places {
    domain: Domain,
    asked: BTreeSet<(ContactState, Vec<usize>)>,
    compared: BTreeSet<usize>,
}

impl Oracle for Places {
    fn unmoved(&mut self, state: &ContactState, objects: &[usize]) -> Verdict {
        self.asked.insert((state.clone(), objects.to_vec()));
        Verdict::Accept
    }

    fn prefix(&mut self, states: &[&ContactState]) -> Verdict {
        let at_first = ["red_box", "green_box"].map(|name| {
            let bottom = format!("{name}_bottom");
            contact(&self.domain, &bottom, "table_a_top")
        });
        let stays = |&o: &usize| states.iter().all(|state| state.contains(&at_first[o]));
        let unmoved: Vec<usize> = (0..2).filter(stays).collect();
        self.compared.insert(unmoved.len());
        let last = *states.last().expect("a start");
        assert!(unmoved.is_empty() || self.asked.contains(&(last.clone(), unmoved)));
        Verdict::Accept
    }
}

/// The red box may come back to where it stood, to be taken by the other hand: then it has been moved.
#[test]
fn states_are_asked_about_beside_what_has_not_left_its_place() {
    let domain = two_boxes(2);
    let pair = |bottom| (id(&domain, bottom), id(&domain, "table_b_top"));
    let goal = Goal::of_pairs([pair("red_box_bottom"), pair("green_box_bottom")]);
    let start = standing(
        &domain,
        "red_box_bottom on table_a_top, green_box_bottom on table_a_top",
    );
    let graph = SkeletonGraph::new(domain.clone(), start, goal, GraphOptions::default());
    let graph = graph.expect("a problem");
    let mut search = TreeSearch::new(graph, &SearchLimits::default(), Costs::default(), 1);
    let mut places = Places {
        domain,
        asked: BTreeSet::new(),
        compared: BTreeSet::new(),
    };
    for _ in 0..10 {
        let sequence = search.next(&mut places).expect("there are many");
        search.learn(&sequence.states, 0.3);
    }
    assert_eq!(places.compared, BTreeSet::from([0, 1, 2]));
}

/// The platform is near only after `needed` swings on the ground with the box in the air.
struct Far {
    domain: Domain,
    needed: usize,
    asked_anew: usize,
}

impl Far {
    /// Swings that end on the ground while the box is in the air.
    fn swings(&self, states: &[&ContactState]) -> usize {
        let rests = contact(&self.domain, "box_bottom", "ground_top");
        let feet = ["left_foot", "right_foot"].map(|f| contact(&self.domain, f, "ground_top"));
        let lands = |pair: &&[&ContactState]| {
            let lands = |c: &Contact| !pair[0].contains(c) && pair[1].contains(c);
            !pair[1].contains(&rests) && feet.iter().any(lands)
        };
        states.windows(2).filter(lands).count()
    }

    fn is_up(&self, state: &ContactState) -> bool {
        let on = |foot| state.contains(&contact(&self.domain, foot, "platform_top"));
        on("left_foot") || on("right_foot")
    }
}

impl Oracle for Far {
    fn prefix(&mut self, states: &[&ContactState]) -> Verdict {
        let up = states.iter().any(|s| self.is_up(s));
        if up && self.swings(states) < self.needed {
            return Verdict::Reject("too far".into());
        }
        Verdict::Accept
    }

    fn set_anew(&mut self, states: &[&ContactState], at: &[usize]) -> Option<Anew> {
        self.asked_anew += 1;
        let rests = contact(&self.domain, "box_bottom", "ground_top");
        let helps = |&k: &usize| !states[k].contains(&rests);
        let at = at.iter().copied().rfind(helps);
        Some(at.map_or(Anew::Far, |at| Anew::Possible { at, swings: 1 }))
    }
}

#[test]
fn steps_are_put_in_where_they_help() {
    let domain = climb();
    for seed in 1..=3 {
        let mut far = Far {
            domain: domain.clone(),
            needed: 3,
            asked_anew: 0,
        };
        let mut search = search(&domain, seed);
        let sequence = search.next(&mut far).expect("a sequence with steps");
        let states: Vec<&ContactState> = sequence.states.iter().collect();
        assert!(far.swings(&states) >= 3, "{:?}", sequence.labels);
        assert!(far.asked_anew > 0);
    }
}

/// The box cannot be grasped, wherever the feet stand.
struct Ungraspable {
    far: Far,
    /// Grasps that were asked about where nothing but the ground had carried a foot, with how often.
    asked: BTreeMap<ContactState, usize>,
    anew: Anew,
}

impl Ungraspable {
    fn new(domain: &Domain, anew: Anew) -> Self {
        let far = Far {
            domain: domain.clone(),
            needed: 0,
            asked_anew: 0,
        };
        Self {
            far,
            asked: BTreeMap::new(),
            anew,
        }
    }
}

impl Oracle for Ungraspable {
    fn prefix(&mut self, states: &[&ContactState]) -> Verdict {
        let holds = |hand| contact(&self.far.domain, hand, "box_handle");
        let holds = ["left_hand", "right_hand"].map(holds);
        let Some((last, before)) = states.split_last() else {
            return Verdict::Accept;
        };
        if !holds.iter().any(|hold| last.contains(hold)) {
            return Verdict::Accept;
        }
        let feet = ["left_foot", "right_foot"];
        let ground = feet.map(|f| contact(&self.far.domain, f, "ground_top"));
        let elsewhere = |c: &Contact| {
            feet.iter().any(|f| c.a == id(&self.far.domain, f)) && !ground.contains(c)
        };
        if !before.iter().any(|s| s.iter().any(|c| elsewhere(&c))) {
            *self.asked.entry((*last).clone()).or_default() += 1;
        }
        Verdict::Reject("out of reach".into())
    }

    fn set_anew(&mut self, _states: &[&ContactState], _at: &[usize]) -> Option<Anew> {
        Some(self.anew)
    }
}

#[test]
fn what_no_step_helps_is_not_asked_again_after_every_step() {
    let domain = climb();
    let mut ungraspable = Ungraspable::new(&domain, Anew::Far);
    let mut search = search(&domain, 1);
    draw(&mut search, 30, &mut ungraspable);
    let most = ungraspable.asked.values().max();
    assert_eq!(most, Some(&2), "{:?}", ungraspable.asked);
}

#[test]
fn what_is_missed_by_little_is_asked_ever_more_seldom() {
    let domain = climb();
    let mut ungraspable = Ungraspable::new(&domain, Anew::Near);
    let mut search = search(&domain, 1);
    let mut asked = [0; 2];
    for asked in &mut asked {
        let before: usize = ungraspable.asked.values().sum();
        draw(&mut search, 100, &mut ungraspable);
        *asked = ungraspable.asked.values().sum::<usize>() - before;
    }
    let [first, then] = asked;
    assert!(0 < then && then < first, "{asked:?}");
}

/// So many sequences, of which all are told to be poor.
fn draw(search: &mut TreeSearch, sequences: usize, ungraspable: &mut Ungraspable) {
    for _ in 0..sequences {
        let sequence = search
            .next(ungraspable)
            .expect("there are many without the box");
        search.learn(&sequence.states, 0.3);
    }
}

/// Nothing leads up.
struct Never(Far);

impl Oracle for Never {
    fn state(&mut self, state: &ContactState) -> Verdict {
        if self.0.is_up(state) {
            return Verdict::Reject("out of reach".into());
        }
        Verdict::Accept
    }
}

#[test]
fn a_goal_that_nothing_leads_to_ends_the_search_at_once() {
    let domain = climb();
    let mut never = Never(Far {
        domain: domain.clone(),
        needed: 0,
        asked_anew: 0,
    });
    let mut search = search(&domain, 1);
    assert_eq!(search.next(&mut never), None);
    assert_eq!(search.status(), Status::Exhausted);
    assert!(search.counts().created < 10, "{:?}", search.counts());
}

#[test]
fn a_hand_that_the_goal_wants_on_something_fixed_is_a_way_to_the_end() {
    let domain = one_box(1);
    let goal = Goal::of_pairs([(id(&domain, "left_hand"), id(&domain, "table_a_top"))]);
    let options = GraphOptions {
        support_hands: true,
        ..GraphOptions::default()
    };
    let start = standing(&domain, "red_box_bottom on table_a_top");
    let wanted = contact(&domain, "left_hand", "table_a_top");
    let graph = SkeletonGraph::new(domain, start, goal, options).expect("a problem");
    let limits = SearchLimits::default();
    let mut search = TreeSearch::new(graph, &limits, Costs::default(), 0).with_outlook();
    let sequence = search.next(&mut AcceptAll).expect("a sequence");
    assert!(sequence.states.last().is_some_and(|s| s.contains(&wanted)));
}
