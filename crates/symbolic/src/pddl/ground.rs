//! Grounding: every action with every choice of objects that what never changes allows.
//!
//! Predicates that no effect names are decided at once; atoms that neither the start nor a possible action makes true
//! are false. What is left becomes facts and operators of a [`Task`].

use super::problem::Problem;
use super::syntax::{
    ActionSchema, Atom, DomainFile, Effect, Formula, Literal, ObjectId, Term, TypeId,
};
use crate::error::SymbolicError;
use crate::task::{Change, Condition, Fact, FactSet, Operator, Task};
use std::collections::{BTreeMap, BTreeSet};

/// An action with its objects.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct GroundAction {
    /// Index of the action.
    pub action: usize,
    pub arguments: Vec<ObjectId>,
}

/// The parts of a task, before its operators have labels.
#[derive(Debug)]
pub(crate) struct Ground {
    /// What each fact says.
    pub atoms: Vec<Atom>,
    /// The actions, in the order of the file, then of their parameters.
    pub actions: Vec<GroundAction>,
    /// Per action its condition and what it changes.
    operators: Vec<(Condition, Vec<Change>)>,
    start: FactSet,
    goal: Condition,
}

impl DomainFile {
    /// The ground task of a problem; labels are `name argument …`.
    ///
    /// # Errors
    /// Never for a problem of this domain; the error is that of [`Task::new`].
    pub fn task(&self, problem: &Problem) -> Result<Task, SymbolicError> {
        let ground = Ground::new(self, problem);
        let label = |ground: &GroundAction| {
            let names = ground
                .arguments
                .iter()
                .map(|&n| problem.objects[n].0.as_str());
            std::iter::once(self.actions[ground.action].name.as_str())
                .chain(names)
                .collect::<Vec<_>>()
                .join(" ")
        };
        let labels = ground.actions.iter().map(label).collect();
        ground.task(self, problem, labels)
    }
}

impl Ground {
    pub fn new(domain: &DomainFile, problem: &Problem) -> Self {
        let mut grounder = Grounder {
            domain,
            problem,
            fluent: (0..domain.predicates.len())
                .map(|p| domain.is_fluent(p))
                .collect(),
            possible: problem.init.clone(),
            facts: None,
        };
        let mut actions = Vec::new();
        for (action, schema) in domain.actions.iter().enumerate() {
            let with = |arguments| GroundAction { action, arguments };
            actions.extend(grounder.choices(schema).into_iter().map(with));
        }
        grounder.reach(&actions);
        let atoms: BTreeSet<Atom> = grounder.possible.clone();
        grounder.facts = Some(atoms.iter().cloned().zip((0..).map(Fact)).collect());
        let mut operators = Vec::new();
        actions.retain(|ground| {
            let operator = grounder.operator(ground);
            let possible = operator.is_some();
            operators.extend(operator);
            possible
        });
        let holds = |(atom, fact)| problem.init.contains(atom).then_some(Fact(fact));
        Self {
            start: atoms.iter().zip(0..).filter_map(holds).collect(),
            goal: grounder.condition(&problem.goal, &mut Vec::new()),
            atoms: atoms.into_iter().collect(),
            actions,
            operators,
        }
    }

    /// The task with these labels of its operators.
    pub fn task(
        self,
        domain: &DomainFile,
        problem: &Problem,
        labels: Vec<String>,
    ) -> Result<Task, SymbolicError> {
        let name = |(predicate, arguments): &Atom| {
            let names = arguments.iter().map(|&n| problem.objects[n].0.as_str());
            std::iter::once(domain.predicates[*predicate].name.as_str())
                .chain(names)
                .collect::<Vec<_>>()
                .join(" ")
        };
        let facts = self.atoms.iter().map(name).collect();
        let operators = labels.into_iter().zip(self.operators);
        let operators = operators.map(|(label, (requires, changes))| Operator {
            label,
            requires,
            changes,
        });
        Task::new(facts, operators.collect(), self.start, self.goal)
    }
}

struct Grounder<'d> {
    domain: &'d DomainFile,
    problem: &'d Problem,
    /// Per predicate: does any action change it.
    fluent: Vec<bool>,
    /// Atoms that are found to be possible.
    possible: BTreeSet<Atom>,
    /// The same as facts, once they are all known.
    facts: Option<BTreeMap<Atom, Fact>>,
}

impl Grounder<'_> {
    fn objects_of(&self, kind: TypeId) -> impl Iterator<Item = ObjectId> + '_ {
        let of_kind = move |&n: &ObjectId| self.domain.types.is_a(self.problem.objects[n].1, kind);
        (0..self.problem.objects.len()).filter(of_kind)
    }

    /// All choices of objects for the parameters for which nothing that never changes is violated.
    fn choices(&self, schema: &ActionSchema) -> Vec<Vec<ObjectId>> {
        let parts = match &schema.precondition {
            Formula::And(parts) => parts.as_slice(),
            other => std::slice::from_ref(other),
        };
        let rigid = |part: &&Formula| {
            let mut rigid = true;
            part.atoms(&mut |atom| rigid &= !self.fluent[atom.predicate]);
            rigid
        };
        // per parameter what can be decided as soon as it is chosen
        let mut decided: Vec<Vec<&Formula>> = vec![Vec::new(); schema.parameters.len() + 1];
        for part in parts.iter().filter(rigid) {
            decided[variables_used(part, schema.parameters.len())].push(part);
        }
        let mut found = Vec::new();
        let mut chosen = vec![0; schema.parameters.len()];
        self.choose(schema, &decided, 0, &mut chosen, &mut found);
        found
    }

    fn choose(
        &self,
        schema: &ActionSchema,
        decided: &[Vec<&Formula>],
        depth: usize,
        chosen: &mut Vec<ObjectId>,
        found: &mut Vec<Vec<ObjectId>>,
    ) {
        let holds =
            |part: &&Formula| self.condition(part, &mut chosen.clone()) != Condition::never();
        if !decided[depth].iter().all(holds) {
            return;
        }
        let Some(&kind) = schema.parameters.get(depth) else {
            found.push(chosen.clone());
            return;
        };
        for object in self.objects_of(kind) {
            chosen[depth] = object;
            self.choose(schema, decided, depth + 1, chosen, found);
        }
    }

    /// Finds the possible atoms: what holds at the start or is added by an action that may happen, as far as it changes
    /// at all. Deletions are not looked at, so it may be too many.
    fn reach(&mut self, actions: &[GroundAction]) {
        self.possible
            .retain(|(predicate, _)| self.fluent[*predicate]);
        loop {
            let mut more = Vec::new();
            for ground in actions {
                let schema = &self.domain.actions[ground.action];
                let values = &mut ground.arguments.clone();
                if self.condition(&schema.precondition, values) == Condition::never() {
                    continue;
                }
                for effect in schema.effects.iter().filter(|effect| effect.adds) {
                    self.instances(effect, values, &mut |_, atom| more.push(atom));
                }
            }
            let before = self.possible.len();
            self.possible.extend(more);
            if self.possible.len() == before {
                return;
            }
        }
    }

    /// Calls `found` with every atom of an effect and the condition for it, unless that can never hold.
    fn instances(
        &self,
        effect: &Effect,
        values: &mut Vec<ObjectId>,
        found: &mut dyn FnMut(Condition, Atom),
    ) {
        self.for_each(&effect.for_all, values, &mut |values| {
            let conditions = effect.when.iter().map(|(in_scope, condition)| {
                self.condition(condition, &mut values[..*in_scope].to_vec())
            });
            let condition = Condition::all(conditions);
            if condition != Condition::never() {
                found(condition, atom(&effect.atom, values));
            }
            true
        });
    }

    /// Calls `visit` with the values extended by every choice of objects of these types, until it returns false.
    fn for_each(
        &self,
        types: &[TypeId],
        values: &mut Vec<ObjectId>,
        visit: &mut dyn FnMut(&mut Vec<ObjectId>) -> bool,
    ) -> bool {
        let Some((&kind, rest)) = types.split_first() else {
            return visit(values);
        };
        self.objects_of(kind).all(|object| {
            values.push(object);
            let go_on = self.for_each(rest, values, visit);
            values.pop();
            go_on
        })
    }

    /// The condition on facts; before these are known, every atom that is possible so far stands for fact 0.
    fn condition(&self, formula: &Formula, values: &mut Vec<ObjectId>) -> Condition {
        match formula {
            Formula::Atom(literal) => {
                let atom = atom(literal, values);
                match &self.facts {
                    _ if !self.fluent[literal.predicate] => {
                        Condition::constant(self.problem.init.contains(&atom))
                    }
                    Some(facts) => {
                        let fact = facts.get(&atom);
                        fact.map_or_else(Condition::never, |&fact| Condition::Holds(fact))
                    }
                    None if self.possible.contains(&atom) => Condition::Holds(Fact(0)),
                    None => Condition::never(),
                }
            }
            Formula::Equal(one, other) => {
                Condition::constant(value(*one, values) == value(*other, values))
            }
            Formula::Not(body) => self.condition(body, values).negated(),
            Formula::And(parts) => {
                Condition::all(parts.iter().map(|part| self.condition(part, values)))
            }
            Formula::Or(parts) => {
                Condition::any(parts.iter().map(|part| self.condition(part, values)))
            }
            Formula::ForAll(types, body) => {
                let mut parts = Vec::new();
                self.for_each(types, values, &mut |values| {
                    parts.push(self.condition(body, values));
                    parts.last() != Some(&Condition::never())
                });
                Condition::all(parts)
            }
            Formula::Exists(types, body) => {
                let mut parts = Vec::new();
                self.for_each(types, values, &mut |values| {
                    parts.push(self.condition(body, values));
                    parts.last() != Some(&Condition::always())
                });
                Condition::any(parts)
            }
        }
    }

    /// Condition and changes of a ground action; `None` if it can never happen.
    fn operator(&self, ground: &GroundAction) -> Option<(Condition, Vec<Change>)> {
        let schema = &self.domain.actions[ground.action];
        let values = &mut ground.arguments.clone();
        let requires = self.condition(&schema.precondition, values);
        if requires == Condition::never() {
            return None;
        }
        let mut changes: Vec<Change> = Vec::new();
        for effect in &schema.effects {
            self.instances(effect, values, &mut |when, atom| {
                let fact = self.facts.as_ref().and_then(|facts| facts.get(&atom));
                let Some(&fact) = fact else {
                    return; // it is never true, so nothing has to make it false
                };
                if !changes.iter().any(|change| change.when == when) {
                    changes.push(Change {
                        when: when.clone(),
                        ..Change::default()
                    });
                }
                let change = changes.iter_mut().find(|change| change.when == when);
                if let Some(change) = change {
                    let list = if effect.adds {
                        &mut change.adds
                    } else {
                        &mut change.deletes
                    };
                    if !list.contains(&fact) {
                        list.push(fact);
                    }
                }
            });
        }
        Some((requires, changes))
    }
}

fn atom(literal: &Literal, values: &[ObjectId]) -> Atom {
    let arguments = literal.arguments.iter().map(|&term| value(term, values));
    (literal.predicate, arguments.collect())
}

fn value(term: Term, values: &[ObjectId]) -> ObjectId {
    match term {
        Term::Variable(n) => values[n],
        Term::Object(n) => n,
    }
}

/// One more than the largest parameter that a formula uses.
fn variables_used(formula: &Formula, n_parameters: usize) -> usize {
    let of_term = |term: &Term| match term {
        Term::Variable(n) if *n < n_parameters => n + 1,
        _ => 0,
    };
    match formula {
        Formula::Atom(literal) => literal.arguments.iter().map(of_term).max().unwrap_or(0),
        Formula::Equal(one, other) => of_term(one).max(of_term(other)),
        Formula::Not(body) | Formula::ForAll(_, body) | Formula::Exists(_, body) => {
            variables_used(body, n_parameters)
        }
        Formula::And(parts) | Formula::Or(parts) => {
            let used = parts.iter().map(|part| variables_used(part, n_parameters));
            used.max().unwrap_or(0)
        }
    }
}
