//! Ground tasks and their plans, on the two-handed pick-and-place domain with a base that goes between tables.

use symbolic::{
    Change, Condition, Fact, FactSet, Operator, SymbolicError, Task, TaskGraph, TaskState,
};

const TABLES: usize = 3;
const BOXES: usize = 2;
const HANDS: usize = 2;

fn at(table: usize) -> Fact {
    Fact(table)
}

fn on(box_: usize, table: usize) -> Fact {
    Fact(TABLES + box_ * TABLES + table)
}

fn held(box_: usize, hand: usize) -> Fact {
    Fact(TABLES + BOXES * TABLES + box_ * HANDS + hand)
}

fn action(
    label: String,
    all_of: &[Fact],
    none_of: Vec<Fact>,
    deletes: &[Fact],
    adds: &[Fact],
) -> Operator {
    let holds = all_of.iter().map(|&fact| Condition::Holds(fact));
    let fails = none_of
        .into_iter()
        .map(|fact| Condition::Holds(fact).negated());
    Operator {
        label,
        requires: Condition::all(holds.chain(fails)),
        changes: vec![Change {
            deletes: deletes.to_vec(),
            adds: adds.to_vec(),
            ..Change::default()
        }],
    }
}

/// go(a, b); pick(box, table, hand) and place(box, table, hand) where the base is.
fn pick_place() -> Task {
    let mut operators = Vec::new();
    for table in 0..TABLES {
        for other in (0..TABLES).filter(|&other| other != table) {
            operators.push(action(
                format!("go {table} {other}"),
                &[at(table)],
                vec![],
                &[at(table)],
                &[at(other)],
            ));
        }
        for box_ in 0..BOXES {
            for hand in 0..HANDS {
                let (there, here) = (on(box_, table), held(box_, hand));
                let busy = (0..BOXES).map(|other| held(other, hand)).collect();
                operators.push(action(
                    format!("pick {box_} {table} {hand}"),
                    &[at(table), there],
                    busy,
                    &[there],
                    &[here],
                ));
                operators.push(action(
                    format!("place {box_} {table} {hand}"),
                    &[at(table), here],
                    vec![],
                    &[here],
                    &[there],
                ));
            }
        }
    }
    let facts = (0..TABLES + BOXES * (TABLES + HANDS))
        .map(|n| format!("fact {n}"))
        .collect();
    let start = [at(0), on(0, 0), on(1, 1)].into_iter().collect();
    let goal = Condition::all([on(0, 2), on(1, 2)].map(Condition::Holds));
    Task::new(facts, operators, start, goal).expect("the task is valid")
}

#[test]
fn plans_of_the_reference_domain_are_as_many_as_other_planners_count() {
    // Loop-free plans by length: plain enumeration, K* and SymK agree on the domain.
    let graph = TaskGraph::explore(&pick_place(), Some(10)).expect("few states");
    let plans: Vec<_> = graph.plans().collect();
    let up_to = |length| plans.iter().filter(|plan| plan.len() <= length).count();
    assert_eq!([6, 7, 8, 9, 10].map(up_to), [4, 20, 64, 148, 296]);
    assert!(plans.is_sorted_by_key(Vec::len));
}

#[test]
fn no_plan_comes_twice_and_none_visits_a_state_twice() {
    let task = pick_place();
    let graph = TaskGraph::explore(&task, Some(9)).expect("few states");
    let mut plans: Vec<Vec<usize>> = Vec::new();
    for plan in graph.plans() {
        let mut states: Vec<TaskState> = plan.iter().map(|edge| edge.to).collect();
        let goal = states
            .iter()
            .map(|&state| task.goal().holds(graph.facts(state)))
            .collect::<Vec<_>>();
        assert!(goal.ends_with(&[true]) && goal.iter().filter(|&&holds| holds).count() == 1);
        states.push(TaskState(0));
        states.sort_unstable();
        states.dedup();
        assert_eq!(states.len(), plan.len() + 1);
        plans.push(plan.iter().map(|edge| edge.operator).collect());
    }
    let count = plans.len();
    plans.sort_unstable();
    plans.dedup();
    assert_eq!(plans.len(), count);
}

#[test]
fn the_default_bound_is_the_shortest_plan_and_four_more() {
    let graph = TaskGraph::explore(&pick_place(), None).expect("few states");
    assert_eq!(graph.distance(TaskState(0)), Some(6));
    assert_eq!(graph.max_actions(), 10);
}

#[test]
fn a_goal_that_holds_at_the_start_has_the_empty_plan_and_no_other() {
    let mut operators = pick_place().operators().to_vec();
    operators.truncate(3);
    let start: FactSet = [at(0)].into_iter().collect();
    let facts = pick_place().facts().to_vec();
    let task = Task::new(facts, operators, start, Condition::default()).expect("the task is valid");
    let graph = TaskGraph::explore(&task, Some(5)).expect("few states");
    assert_eq!(graph.plans().collect::<Vec<_>>(), [vec![]]);
}

#[test]
fn an_unreachable_goal_has_no_plan() {
    let (facts, operators) = (
        pick_place().facts().to_vec(),
        pick_place().operators().to_vec(),
    );
    let start = pick_place().start().clone();
    let task = Task::new(facts, operators, start, Condition::never()).expect("the task is valid");
    for bound in [None, Some(4)] {
        let graph = TaskGraph::explore(&task, bound).expect("few states");
        assert_eq!(graph.distance(TaskState(0)), None);
        assert_eq!(graph.plans().count(), 0);
    }
}

#[test]
fn an_undeclared_fact_is_refused_by_place() {
    let stray = action("teleport".into(), &[], vec![], &[], &[Fact(13)]);
    let error = Task::new(
        pick_place().facts().to_vec(),
        vec![stray],
        FactSet::default(),
        Condition::default(),
    );
    let expected = SymbolicError::UnknownFact {
        place: "teleport".into(),
        fact: 13,
        count: 13,
    };
    assert_eq!(error.expect_err("fact 13 is not declared"), expected);
    let error = Task::new(
        vec![],
        vec![],
        [Fact(0)].into_iter().collect(),
        Condition::default(),
    );
    assert_eq!(
        error.expect_err("no fact is declared").to_string(),
        "start: fact number 0, but only 0 facts are declared"
    );
}

#[test]
fn sets_of_facts_compare_by_content() {
    let mut set: FactSet = [Fact(3), Fact(70)].into_iter().collect();
    assert!(set.contains(Fact(70)) && !set.contains(Fact(6)) && !set.contains(Fact(700)));
    set.remove(Fact(70));
    set.remove(Fact(900));
    assert_eq!(
        set,
        [Fact(3)].into_iter().collect::<FactSet>(),
        "no trace of the larger fact is left"
    );
    assert_eq!(set.iter().collect::<Vec<_>>(), [Fact(3)]);
}
