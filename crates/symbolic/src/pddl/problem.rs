//! A PDDL problem: objects, the atoms that hold at the start, the goal; and its text.

use super::expression::{Expression, read};
use super::formula::Scope;
use super::parse::define;
use super::source::{PddlError, Source};
use super::syntax::{Atom, DomainFile, Formula, Literal, Term, TypeId};
use super::vocabulary::{SceneProblem, pddl_name};
use crate::contact::ContactState;
use crate::domain::Domain;
use crate::goal::Goal;
use std::collections::BTreeSet;
use std::fmt::Write;

/// What a domain is to be grounded on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Name of the problem.
    pub name: String,
    /// Names and types; the constants of the domain come first.
    pub(crate) objects: Vec<(String, TypeId)>,
    /// What holds at the start.
    pub(crate) init: BTreeSet<Atom>,
    pub(crate) goal: Formula,
}

impl Problem {
    /// The problem of a scene in the words of a domain: what there is, how it is at the start, what is asked for.
    ///
    /// # Errors
    /// [`PddlError`] if the domain uses predicates that no scene and no action makes true.
    pub fn of_scene(
        file: &DomainFile,
        domain: &Domain,
        start: &ContactState,
        goal: &Goal,
        release_at_end: bool,
    ) -> Result<Self, PddlError> {
        Ok(SceneProblem::new(file, domain, start, goal, release_at_end)?.problem)
    }

    /// The same under another name, in letters that PDDL allows.
    #[must_use]
    pub fn named(self, name: &str) -> Self {
        Self {
            name: pddl_name(name),
            ..self
        }
    }

    /// Reads the text of a problem of `domain` that people know as `name`.
    ///
    /// # Errors
    /// [`PddlError`] with file, line and column.
    pub fn parse(domain: &DomainFile, name: &str, text: &str) -> Result<Self, PddlError> {
        let source = Source::new(name, text);
        let whole = read(&source)?;
        let (title, sections) = define(&source, &whole, "problem")?;
        // the objects are constants for everything that is read after them
        let mut with_objects = DomainFile {
            source: source.clone(),
            ..domain.clone()
        };
        let mut init = BTreeSet::new();
        let mut goal = None;
        for section in sections {
            match section.headed() {
                Some((":domain", [name])) if name.symbol() == Some(&domain.name) => {}
                Some((":objects", rest)) => {
                    let objects = with_objects.typed(rest)?;
                    let objects = objects.into_iter().map(|(name, _, kind)| (name, kind));
                    with_objects.constants.extend(objects);
                }
                Some((":init", rest)) => {
                    for atom in rest {
                        init.insert(ground_atom(&with_objects, atom)?);
                    }
                }
                Some((":goal", [formula])) => {
                    goal = Some(Scope::new(&with_objects).formula(formula)?);
                }
                _ => {
                    let problem = format!("unexpected {}", with_objects.excerpt(section));
                    let remedy = format!(
                        "expected (:domain {}), (:objects …), (:init …), (:goal …)",
                        domain.name
                    );
                    return Err(source.error(section.span(), problem, remedy));
                }
            }
        }
        let goal = goal.ok_or_else(|| {
            source.error(
                whole.span(),
                "the problem has no goal",
                "add (:goal (and …))",
            )
        })?;
        Ok(Self {
            name: title.to_owned(),
            objects: with_objects.constants,
            init,
            goal,
        })
    }

    /// The problem as other planners read it.
    pub fn text(&self, domain: &DomainFile) -> String {
        let mut text = format!(
            "(define (problem {})\n  (:domain {})\n  (:objects\n",
            self.name, domain.name
        );
        for (name, kind) in &self.objects[domain.constants.len()..] {
            let _ = writeln!(text, "    {name} - {}", domain.types.names[*kind]);
        }
        text.push_str("  )\n  (:init\n");
        for (predicate, arguments) in &self.init {
            let _ = write!(text, "    ({}", domain.predicates[*predicate].name);
            for &argument in arguments {
                let _ = write!(text, " {}", self.objects[argument].0);
            }
            text.push_str(")\n");
        }
        text.push_str("  )\n  (:goal ");
        self.write(domain, &self.goal, &mut text);
        text.push_str("))\n");
        text
    }

    /// Writes a goal of this crate's making: atoms of objects, and, or, not.
    fn write(&self, domain: &DomainFile, formula: &Formula, text: &mut String) {
        let list = |head: &str, parts: &[Formula], text: &mut String| {
            let _ = write!(text, "({head}");
            for part in parts {
                text.push(' ');
                self.write(domain, part, text);
            }
            text.push(')');
        };
        let name = |term: &Term| match term {
            Term::Object(n) => self.objects[*n].0.clone(),
            Term::Variable(n) => format!("?v{n}"),
        };
        match formula {
            Formula::Atom(Literal {
                predicate,
                arguments,
                ..
            }) => {
                let _ = write!(text, "({}", domain.predicates[*predicate].name);
                for term in arguments {
                    let _ = write!(text, " {}", name(term));
                }
                text.push(')');
            }
            Formula::Equal(one, other) => {
                let _ = write!(text, "(= {} {})", name(one), name(other));
            }
            Formula::Not(body) => list("not", std::slice::from_ref(body), text),
            Formula::And(parts) => list("and", parts, text),
            Formula::Or(parts) => list("or", parts, text),
            Formula::ForAll(_, body) | Formula::Exists(_, body) => self.write(domain, body, text),
        }
    }
}

fn ground_atom(domain: &DomainFile, expression: &Expression) -> Result<Atom, PddlError> {
    let objects = |literal: Literal| -> Option<Atom> {
        let object = |term: Term| match term {
            Term::Object(n) => Some(n),
            Term::Variable(_) => None,
        };
        let arguments = literal.arguments.into_iter().map(object);
        Some((literal.predicate, arguments.collect::<Option<_>>()?))
    };
    let atom = match Scope::new(domain).formula(expression)? {
        Formula::Atom(literal) => objects(literal),
        _ => None,
    };
    atom.ok_or_else(|| {
        let problem = format!("expected an atom, found {}", domain.excerpt(expression));
        domain.error(
            expression,
            &problem,
            "list only what holds; all else does not",
        )
    })
}
