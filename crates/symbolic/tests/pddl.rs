//! PDDL: the built-in domain, domains of the user's, grounding against counts of other planners, every error once.

use crate::fixtures::{one_box, standing, two_boxes};
use symbolic::pddl::{DomainFile, PddlError, Problem};
use symbolic::{
    ContactState, Domain, Goal, GraphOptions, Manipulation, SkeletonGraph, SymbolicError, TaskGraph,
};

const RESTS: &str = "red_box_bottom on table_a_top";

fn read(text: &str) -> DomainFile {
    DomainFile::parse("own.pddl", text).unwrap_or_else(|error| panic!("{error}"))
}

fn refuse(text: &str) -> PddlError {
    DomainFile::parse("own.pddl", text).expect_err("the text is faulty")
}

fn to_table_b(domain: &Domain) -> (ContactState, Goal) {
    let id = |name| domain.find(name).expect("exists");
    let goal = Goal::of_pairs([(id("red_box_bottom"), id("table_b_top"))]);
    (standing(domain, RESTS), goal)
}

/// The graph of one box that goes from table a to table b, with the actions of a domain.
fn graph(file: &DomainFile, max_actions: Option<usize>) -> Result<SkeletonGraph, SymbolicError> {
    let domain = one_box(2);
    let (start, goal) = to_table_b(&domain);
    let manipulation = Manipulation::of(file, &domain, &start, &goal, true)?;
    let options = GraphOptions {
        max_actions,
        ..GraphOptions::default()
    };
    SkeletonGraph::with_manipulation(domain, start, goal, options, manipulation)
}

fn skeletons(graph: &SkeletonGraph) -> Vec<Vec<String>> {
    let operators = graph.manipulation().task.operators();
    let label = |edge: &symbolic::TaskEdge| operators[edge.operator].label.clone();
    let plans = graph.skeletons().plans();
    plans.map(|plan| plan.iter().map(label).collect()).collect()
}

/// The usual pick-and-place exercise: a base that goes between tables, one hand per box.
const PICK_PLACE: &str = "
(define (domain pick-place)
  (:requirements :strips :typing :universal-preconditions :equality)
  (:types place box hand)
  (:predicates (at ?p - place) (on ?b - box ?p - place) (in ?b - box ?h - hand))
  (:action go :parameters (?p ?q - place) :precondition (and (at ?p) (not (= ?p ?q)))
    :effect (and (not (at ?p)) (at ?q)))
  (:action pick :parameters (?b - box ?p - place ?h - hand)
    :precondition (and (at ?p) (on ?b ?p) (forall (?c - box) (not (in ?c ?h))))
    :effect (and (not (on ?b ?p)) (in ?b ?h)))
  (:action place :parameters (?b - box ?p - place ?h - hand)
    :precondition (and (at ?p) (in ?b ?h))
    :effect (and (on ?b ?p) (not (in ?b ?h)))))";

const TWO_BOXES: &str = "
(define (problem two-boxes) (:domain pick-place)
  (:objects a b c - place red green - box left right - hand)
  (:init (at a) (on red a) (on green b))
  (:goal (and (on red c) (on green c))))";

#[test]
fn plans_of_a_written_domain_are_as_many_as_other_planners_count() {
    // Loop-free plans by length: plain enumeration, K* and SymK agree.
    let domain = read(PICK_PLACE);
    let problem = Problem::parse(&domain, "two-boxes.pddl", TWO_BOXES).expect("valid");
    let task = domain.task(&problem).expect("valid");
    let graph = TaskGraph::explore(&task, Some(10)).expect("few states");
    let lengths: Vec<usize> = graph.plans().map(|plan| plan.len()).collect();
    let up_to = |n| lengths.iter().filter(|&&length| length <= n).count();
    assert_eq!([6, 7, 8, 9, 10].map(up_to), [4, 20, 64, 148, 296]);
    assert_eq!(task.operators()[0].label, "go a b");
}

#[test]
fn a_written_problem_reads_back_as_it_was() {
    let domain = read(PICK_PLACE);
    let problem = Problem::parse(&domain, "two-boxes.pddl", TWO_BOXES).expect("valid");
    let again = Problem::parse(&domain, "again.pddl", &problem.text(&domain)).expect("valid");
    assert_eq!(again.text(&domain), problem.text(&domain));

    let file = DomainFile::builtin();
    let scene = one_box(2);
    let (start, goal) = to_table_b(&scene);
    let text = Problem::of_scene(&file, &scene, &start, &goal, true)
        .expect("valid")
        .text(&file);
    for part in [
        "left_hand - hand",
        "red_box_handle - surface",
        "red_box - movable",
        "(part-of red_box_handle red_box)",
        "(can-hold left_hand red_box_handle)",
        "(can-rest red_box_bottom table_b_top)",
        "(rests red_box_bottom table_a_top)",
        "(down red_box_bottom)",
        "(:goal (and (rests red_box_bottom table_b_top) (not (holds left_hand red_box_handle)) \
         (not (holds right_hand red_box_handle))))",
    ] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    let problem = Problem::parse(&file, "scene.pddl", &text).expect("valid");
    let task = file.task(&problem).expect("valid");
    let plans = TaskGraph::explore(&task, Some(4))
        .expect("few states")
        .plans()
        .count();
    assert_eq!(plans, 2, "either hand, as from the scene itself");
}

#[test]
fn the_start_is_told_with_all_that_follows_from_it() {
    let file = DomainFile::builtin();
    let domain = two_boxes(1);
    let start = standing(
        &domain,
        "left_hand on green_box_left, right_hand on green_box_right, red_box_bottom on table_a_top",
    );
    let problem = Problem::of_scene(&file, &domain, &start, &Goal::default(), true);
    let text = problem.expect("valid").text(&file);
    for part in [
        "(opposite green_box_left green_box_right)",
        "(squeezes left_hand right_hand green_box_left green_box_right)",
        "(busy left_hand)",
        "(gripped green_box_right)",
    ] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    assert!(!text.contains("(down green_box_bottom)"));
    // squeezed in the air, it can be put down
    let manipulation =
        Manipulation::of(&file, &domain, &start, &Goal::default(), true).expect("valid");
    let task = &manipulation.task;
    let possible = |label: &str| {
        let mut named = task.operators().iter().filter(|o| o.label == label);
        named.any(|operator| operator.apply(task.start()).is_some())
    };
    assert!(possible("place green_box on table_a_top") && !possible("release green_box"));
}

/// Pushing as the only way to move: the box slides from support to support while a hand pushes it.
const SLIDE: &str = "
(define (domain slide) ; upper and lower case are the same
  (:requirements :adl)
  (:types hand surface fixed - interface movable fixed2 - object interface - object)
  (:predicates (PART-OF ?s - surface ?o - movable) (can-rest ?s - surface ?t - interface)
               (rests ?s - surface ?t - interface) (moved ?o - movable))
  (:action slide
    :parameters (?h - hand ?o - movable ?from ?to - fixed)
    :precondition (exists (?s - surface) (and (not (= ?from ?to)) (part-of ?s ?o) (rests ?s ?from) (can-rest ?s ?to)))
    :effect (and
      (when (not (moved ?o)) (moved ?o))
      (forall (?s - surface) (when (rests ?s ?from) (and (not (rests ?s ?from)) (rests ?s ?to)))))))";

#[test]
fn a_domain_of_the_users_replaces_the_actions() {
    let graph = graph(&read(SLIDE), Some(2)).expect("valid");
    let all = skeletons(&graph);
    assert!(all.contains(&vec![
        "slide left_hand red_box table_a_top table_b_top".to_owned()
    ]));
    // Which hand pushes leaves no trace, so the first one stands for both; by way of the ground, two slides.
    assert_eq!(all.len(), 2, "{all:?}");
    assert_eq!(graph.shortest_skeleton(), Some(1));
}

#[test]
fn names_that_pddl_does_not_know_are_replaced_and_stay_apart() {
    let names = ["Box 1", "box_1", "1st", "größe"];
    let mut interfaces = crate::fixtures::robot();
    for (n, name) in names.iter().enumerate() {
        interfaces.push(crate::fixtures::handle(name, n));
    }
    let objects = ["a", "b", "c", "left_hand"].map(str::to_owned).to_vec();
    let domain = Domain::new(interfaces, objects, vec![]).expect("valid");
    let file = DomainFile::builtin();
    let problem = Problem::of_scene(
        &file,
        &domain,
        &ContactState::default(),
        &Goal::default(),
        true,
    );
    let text = problem.expect("valid").text(&file);
    for name in [
        "box_1 ",
        "box_1-2 ",
        "x1st ",
        "gr__e ",
        "left_hand ",
        "left_hand-2 ",
    ] {
        assert_eq!(
            text.matches(&format!("    {name}")).count(),
            1,
            "{name} in\n{text}"
        );
    }
    let task = Manipulation::builtin(&domain, &ContactState::default(), &Goal::default(), true);
    let labels: Vec<String> = task
        .expect("valid")
        .task
        .operators()
        .iter()
        .map(|o| o.label.clone())
        .collect();
    assert!(
        labels.contains(&"grasp a with left_hand".to_owned()),
        "{labels:?}"
    );
}

/// [`PICK_PLACE`] with one piece replaced, the line and column of the error, and a part of its text.
const FAULTS: &[(&str, &str, &str)] = &[
    (
        "(define (domain",
        "(define (problem",
        "own.pddl:2:1: this is no PDDL domain; begin with (define (domain name) …)",
    ),
    (
        "(:action go",
        "(:derived go",
        "own.pddl:6:3: the section \":derived\" is not supported",
    ),
    (
        ":universal-preconditions",
        ":fluents",
        "own.pddl:3:34: \":fluents\" is not supported; supported requirements",
    ),
    (
        "place box hand)",
        "place box hand place)",
        "own.pddl:4:26: the type \"place\" exists already",
    ),
    (
        "place box hand)",
        "place box - hand hand - box)",
        "own.pddl:4:3: the type \"place\" is below itself",
    ),
    (
        "(at ?p - place)",
        "(at ?p - plaice)",
        "own.pddl:5:25: no type is called \"plaice\"; declare it in (:types …); known: object, place, box, hand",
    ),
    (
        "(at ?p - place)",
        "(at ?p -)",
        "own.pddl:5:23: a dash stands between names and their type",
    ),
    (
        "(at ?p - place)",
        "(at p - place)",
        "own.pddl:5:20: expected a variable, found \"p\"",
    ),
    (
        "(at ?p - place)",
        "(on ?p - place)",
        "own.pddl:5:32: the predicate \"on\" exists already",
    ),
    (
        "(at ?p) (not (= ?p ?q))",
        "(at ?r)",
        "own.pddl:6:66: \"?r\" is neither a variable in scope nor a constant",
    ),
    (
        "(at ?p) (not (= ?p ?q))",
        "(near ?p)",
        "own.pddl:6:62: no predicate is called \"near\"",
    ),
    (
        "(at ?p) (not (= ?p ?q))",
        "(at ?p ?q)",
        "own.pddl:6:62: \"at\" has 2 arguments here, expected 1",
    ),
    (
        "(at ?p) (not (= ?p ?q))",
        "(on ?p ?q)",
        "own.pddl:6:66: \"?p\" is of type \"place\", but \"on\" expects \"box\" here",
    ),
    (
        "(at ?p) (not (= ?p ?q))",
        "(not)",
        "own.pddl:6:62: \"not\" is not used as it should be; write (not (…)) with one list inside",
    ),
    (
        "(at ?p) (not (= ?p ?q))",
        "at",
        "own.pddl:6:62: expected a condition, found \"at\"",
    ),
    (
        ":effect (and (not (at ?p)) (at ?q)))",
        ":effect ())",
        "own.pddl:6:3: the action \"go\" has no effect",
    ),
    (
        ":effect (and (not (at ?p)) (at ?q)))",
        ":effect (increase (at ?p)))",
        "own.pddl:7:13: no predicate is called \"increase\"",
    ),
    (
        ":effect (and (not (at ?p)) (at ?q)))",
        ":effect)",
        "own.pddl:7:5: nothing follows \":effect\"",
    ),
    (
        ":effect (and (not (at ?p)) (at ?q)))",
        ":cost (at ?q))",
        "own.pddl:7:5: unexpected \":cost\"",
    ),
    (
        "(:action pick",
        "(:action go",
        "own.pddl:8:3: the action \"go\" exists already",
    ),
    (
        "(not (in ?b ?h)))))",
        "(not (in ?b ?h))))",
        "own.pddl:2:1: \"(\" is never closed",
    ),
    (
        "(not (in ?b ?h)))))",
        "(not (in ?b ?h))))))",
        "own.pddl:13:48: \")\" after the end, expected nothing",
    ),
];

#[test]
fn every_fault_of_a_domain_is_reported_with_its_place() {
    for (piece, replacement, expected) in FAULTS {
        assert!(PICK_PLACE.contains(piece), "{piece}");
        let error = refuse(&PICK_PLACE.replacen(piece, replacement, 1)).to_string();
        assert!(error.starts_with(expected), "{error}\nexpected {expected}");
        assert!(error.contains("; "), "no remedy in {error}");
    }
    assert!(
        refuse("")
            .to_string()
            .starts_with("own.pddl:1:1: the text is empty")
    );
    assert!(
        refuse("; (define")
            .to_string()
            .contains("the text is empty")
    );
    assert!(
        refuse(")")
            .to_string()
            .starts_with("own.pddl:1:1: \")\" without \"(\"")
    );
    assert!(
        refuse(&"(".repeat(200))
            .to_string()
            .contains("more than 100 parentheses")
    );
    let nothing = "(define (domain d) (:predicates (p)))";
    assert!(
        refuse(nothing)
            .to_string()
            .contains("the domain \"d\" has no action")
    );
    let constants = nothing.replace("(:pred", "(:constants a b a) (:pred");
    assert!(
        refuse(&constants)
            .to_string()
            .contains("the constant \"a\" exists already")
    );
}

#[test]
fn every_fault_of_a_problem_is_reported_with_its_place() {
    let domain = read(PICK_PLACE);
    let refuse = |piece: &str, replacement: &str| {
        assert!(TWO_BOXES.contains(piece), "{piece}");
        let text = TWO_BOXES.replacen(piece, replacement, 1);
        Problem::parse(&domain, "p.pddl", &text)
            .expect_err("faulty")
            .to_string()
    };
    for (piece, replacement, expected) in [
        ("(problem", "(domain", "p.pddl:2:1: this is no PDDL problem"),
        (
            "(:domain pick-place)",
            "(:domain other)",
            "p.pddl:2:29: unexpected \"(:domain other)\"",
        ),
        ("(at a)", "(at d)", "p.pddl:4:14: \"d\" is neither"),
        ("(at a)", "(not (at a))", "p.pddl:4:10: expected an atom"),
        ("(:goal", "(:metric", "p.pddl:5:3: unexpected"),
    ] {
        let error = refuse(piece, replacement);
        assert!(error.starts_with(expected), "{error}");
    }
    let without = TWO_BOXES.replace("(:goal (and (on red c) (on green c)))", "");
    let error = Problem::parse(&domain, "p.pddl", &without).expect_err("faulty");
    assert!(error.to_string().contains("the problem has no goal"));
}

#[test]
fn a_domain_that_does_not_fit_the_scene_is_refused_at_the_place_in_its_file() {
    let own = |piece: &str, replacement: &str| {
        assert!(SLIDE.contains(piece), "{piece}");
        let text = SLIDE.replacen(piece, replacement, 1);
        graph(&read(&text), Some(2))
            .expect_err("it does not fit")
            .to_string()
    };
    let anywhere = SLIDE
        .replace(" (can-rest ?s ?to)", "")
        .replace("?to - fixed", "?to - interface");
    let error = graph(&read(&anywhere), Some(2))
        .expect_err("a box cannot rest on a foot")
        .to_string();
    let expected = "own.pddl:12:81: (rests red_box_bottom left_foot) can become true, but no such contact is \
                    possible in the scene; name what is possible in the precondition";
    assert!(error.starts_with(expected), "{error}");
    let error = own(
        "(moved ?o - movable))",
        "(moved ?o - movable) (smooth ?o - movable))",
    );
    assert!(error.contains("\"smooth\" is never true"), "{error}");
    let error = own(
        "(moved ?o - movable))",
        "(moved ?o - movable) (busy ?h ?s - hand))",
    );
    assert!(
        error.contains("\"busy\" has 2 arguments, expected 1"),
        "{error}"
    );
}

#[test]
fn a_goal_that_no_action_brings_about_is_refused() {
    let domain = "(define (domain wave) (:types hand movable) (:predicates (busy ?h - hand))
        (:action wave :parameters (?h - hand) :effect (busy ?h)))";
    let error = graph(&read(domain), Some(2))
        .expect_err("nothing moves the box")
        .to_string();
    let expected = "own.pddl:1:1: the goal asks for \"red_box_bottom\" on \"table_b_top\", but no action brings that \
                    about; add an action whose effect is (rests ?s ?t)";
    assert!(error.starts_with(expected), "{error}");
}

#[test]
fn no_damaged_text_makes_the_reader_panic() {
    for text in [DomainFile::builtin().text(), SLIDE] {
        let indices: Vec<usize> = text.char_indices().map(|(n, _)| n).collect();
        for (n, &index) in indices.iter().enumerate() {
            drop(DomainFile::parse("cut.pddl", &text[..index]));
            let other = ['(', ')', ' ', '-', '?', 'ß', ';', ':'][n % 8];
            let rest = text[index..].chars().skip(1).collect::<String>();
            let changed = format!("{}{other}{rest}", &text[..index]);
            if let (0, Ok(file)) = (n % 5, DomainFile::parse("changed.pddl", &changed)) {
                drop(graph(&file, Some(3)));
            }
        }
    }
}
