//! Conditions and effects, read with the variables in scope.

use super::expression::Expression;
use super::source::PddlError;
use super::syntax::{DomainFile, Effect, Formula, Literal, Term, TypeId};

/// The variables that a condition or an effect may use.
pub(super) struct Scope<'d> {
    domain: &'d DomainFile,
    variables: Vec<(String, TypeId)>,
}

/// What stands around an effect.
#[derive(Clone, Default)]
struct Around {
    for_all: Vec<TypeId>,
    when: Vec<(usize, Formula)>,
}

impl<'d> Scope<'d> {
    pub fn new(domain: &'d DomainFile) -> Self {
        Self {
            domain,
            variables: Vec::new(),
        }
    }

    /// Adds variables; inner ones hide outer ones of the same name.
    pub fn enter(&mut self, list: &[Expression]) -> Result<Vec<TypeId>, PddlError> {
        let variables = self.domain.variables(list)?;
        let types = variables.iter().map(|(_, kind)| *kind).collect();
        self.variables.extend(variables);
        Ok(types)
    }

    /// Reads a condition.
    pub fn formula(&mut self, expression: &Expression) -> Result<Formula, PddlError> {
        if expression.list().is_some_and(<[Expression]>::is_empty) {
            return Ok(Formula::And(vec![]));
        }
        let Some((head, rest)) = expression.headed() else {
            let found = self.domain.excerpt(expression);
            let problem = format!("expected a condition, found {found}");
            return Err(self
                .domain
                .error(expression, &problem, "write (predicate ?a …)"));
        };
        let parts = |scope: &mut Self| -> Result<Vec<Formula>, PddlError> {
            rest.iter().map(|e| scope.formula(e)).collect()
        };
        match (head, rest) {
            ("and", _) => Ok(Formula::And(parts(self)?)),
            ("or", _) => Ok(Formula::Or(parts(self)?)),
            ("not", [body]) => Ok(Formula::Not(Box::new(self.formula(body)?))),
            ("imply", [from, to]) => Ok(Formula::Or(vec![
                Formula::Not(Box::new(self.formula(from)?)),
                self.formula(to)?,
            ])),
            ("=", [one, other]) => Ok(Formula::Equal(self.term(one)?, self.term(other)?)),
            ("forall" | "exists", [Expression::List(variables, _), body]) => {
                let outer = self.variables.len();
                let types = self.enter(variables)?;
                let body = Box::new(self.formula(body)?);
                self.variables.truncate(outer);
                Ok(match head {
                    "forall" => Formula::ForAll(types, body),
                    _ => Formula::Exists(types, body),
                })
            }
            ("not" | "imply" | "=" | "forall" | "exists", _) => Err(self.misused(expression, head)),
            _ => Ok(Formula::Atom(self.literal(expression, head, rest)?)),
        }
    }

    /// Reads an effect.
    pub fn effects(&mut self, expression: &Expression) -> Result<Vec<Effect>, PddlError> {
        let mut found = Vec::new();
        self.collect(expression, &Around::default(), &mut found)?;
        Ok(found)
    }

    fn collect(
        &mut self,
        expression: &Expression,
        around: &Around,
        found: &mut Vec<Effect>,
    ) -> Result<(), PddlError> {
        if expression.list().is_some_and(<[Expression]>::is_empty) {
            return Ok(());
        }
        let Some((head, rest)) = expression.headed() else {
            let problem = format!(
                "expected an effect, found {}",
                self.domain.excerpt(expression)
            );
            let remedy = "write (predicate ?a …) or (not (predicate ?a …))";
            return Err(self.domain.error(expression, &problem, remedy));
        };
        let mut around = around.clone();
        match (head, rest) {
            ("and", _) => rest
                .iter()
                .try_for_each(|e| self.collect(e, &around, found)),
            ("forall", [Expression::List(variables, _), body]) => {
                let outer = self.variables.len();
                let types = self.enter(variables)?;
                around.for_all.extend(types);
                self.collect(body, &around, found)?;
                self.variables.truncate(outer);
                Ok(())
            }
            ("when", [condition, body]) => {
                let condition = self.formula(condition)?;
                around.when.push((self.variables.len(), condition));
                self.collect(body, &around, found)
            }
            ("not", [atom]) => match atom.headed() {
                Some((head, rest)) => {
                    let atom = self.literal(atom, head, rest)?;
                    found.push(effect(around, false, atom));
                    Ok(())
                }
                None => Err(self.misused(expression, "not")),
            },
            ("forall" | "when" | "not", _) => Err(self.misused(expression, head)),
            _ => {
                let atom = self.literal(expression, head, rest)?;
                found.push(effect(around, true, atom));
                Ok(())
            }
        }
    }

    fn literal(
        &self,
        expression: &Expression,
        head: &str,
        rest: &[Expression],
    ) -> Result<Literal, PddlError> {
        let domain = self.domain;
        let Some(predicate) = domain.predicate(head) else {
            let known: Vec<&str> = domain.predicates.iter().map(|p| p.name.as_str()).collect();
            let problem = format!("no predicate is called {head:?}");
            let remedy = format!(
                "declare it in (:predicates …), which stands before the actions; known: {}",
                known.join(", ")
            );
            return Err(domain.error(expression, &problem, &remedy));
        };
        let expected = &domain.predicates[predicate].parameters;
        if rest.len() != expected.len() {
            let (n, found) = (expected.len(), rest.len());
            let problem = format!("{head:?} has {found} arguments here, expected {n}");
            let remedy = "give as many as in (:predicates …)";
            return Err(domain.error(expression, &problem, remedy));
        }
        let mut arguments = Vec::new();
        for (argument, &kind) in rest.iter().zip(expected) {
            let term = self.term(argument)?;
            let own = match term {
                Term::Variable(n) => self.variables[n].1,
                Term::Object(n) => domain.constants[n].1,
            };
            if !domain.types.is_a(own, kind) && !domain.types.is_a(kind, own) {
                let name = |kind: TypeId| &domain.types.names[kind];
                let problem = format!(
                    "{} is of type {:?}, but {head:?} expects {:?} here",
                    domain.excerpt(argument),
                    name(own),
                    name(kind)
                );
                return Err(domain.error(argument, &problem, "change one of the two types"));
            }
            arguments.push(term);
        }
        Ok(Literal {
            predicate,
            arguments,
            span: expression.span(),
        })
    }

    fn term(&self, expression: &Expression) -> Result<Term, PddlError> {
        let name = expression.symbol().unwrap_or_default();
        let variable = self.variables.iter().rposition(|(n, _)| n == name);
        let constant = || self.domain.constants.iter().position(|(n, _)| n == name);
        let found = variable
            .map(Term::Variable)
            .or_else(|| constant().map(Term::Object));
        found.ok_or_else(|| {
            let problem = format!(
                "{} is neither a variable in scope nor a constant",
                self.domain.excerpt(expression)
            );
            let remedy = "declare it in :parameters, in a forall or exists, or in (:constants …)";
            self.domain.error(expression, &problem, remedy)
        })
    }

    fn misused(&self, expression: &Expression, head: &str) -> PddlError {
        let remedy = match head {
            "=" => "write (= ?a ?b)",
            "imply" => "write (imply (condition) (condition))",
            "when" => "write (when (condition) (effect))",
            "not" => "write (not (…)) with one list inside",
            _ => "write (forall (?a - type) (…)), exists likewise",
        };
        let problem = format!("{head:?} is not used as it should be");
        self.domain.error(expression, &problem, remedy)
    }
}

fn effect(around: Around, adds: bool, atom: Literal) -> Effect {
    Effect {
        for_all: around.for_all,
        when: around.when,
        adds,
        atom,
    }
}
