//! From the text of a domain to a [`DomainFile`].

use super::expression::{Expression, read};
use super::formula::Scope;
use super::source::{PddlError, Source};
use super::syntax::{ActionSchema, DomainFile, Formula, Predicate, TypeId, Types};

/// Requirements whose features are understood.
const REQUIREMENTS: [&str; 10] = [
    ":strips",
    ":typing",
    ":equality",
    ":negative-preconditions",
    ":disjunctive-preconditions",
    ":existential-preconditions",
    ":universal-preconditions",
    ":quantified-preconditions",
    ":conditional-effects",
    ":adl",
];

/// A name, where it stands, and its type if one is given.
type Declared<'e> = (&'e str, &'e Expression, Option<&'e Expression>);

/// The domain that is used when a scene names none.
const BUILTIN: &str = include_str!("manipulation.pddl");

impl DomainFile {
    /// The built-in domain: grasp, squeeze, lift, place, attach, release, let-go.
    #[allow(
        clippy::missing_panics_doc,
        reason = "the text is part of the program and a test reads it"
    )]
    pub fn builtin() -> Self {
        Self::parse("manipulation.pddl", BUILTIN).expect("the built-in domain is valid")
    }

    /// True if the text is that of the built-in domain.
    pub fn is_builtin(&self) -> bool {
        self.text() == BUILTIN
    }

    /// Reads the text of a domain that people know as `name`.
    ///
    /// # Errors
    /// [`PddlError`] with file, line and column for everything that is not understood; no text makes it panic.
    pub fn parse(name: &str, text: &str) -> Result<Self, PddlError> {
        let source = Source::new(name, text);
        let whole = read(&source)?;
        let sections = define(&source, &whole, "domain")?;
        let mut domain = Self {
            name: sections.0.to_owned(),
            types: Types {
                names: vec!["object".to_owned()],
                parents: vec![0],
            },
            constants: Vec::new(),
            predicates: Vec::new(),
            actions: Vec::new(),
            source,
        };
        for section in sections.1 {
            domain.section(section)?;
        }
        if domain.actions.is_empty() {
            let problem = format!("the domain {:?} has no action", domain.name);
            let remedy = "add an (:action …)";
            return Err(domain.source.error(whole.span(), problem, remedy));
        }
        Ok(domain)
    }

    fn section(&mut self, section: &Expression) -> Result<(), PddlError> {
        let Some((head, rest)) = section.headed() else {
            let problem = "expected a section such as (:predicates …)";
            return Err(self.error(section, problem, "write (:section …)"));
        };
        match head {
            ":requirements" => self.requirements(rest),
            ":types" => self.declare_types(section, rest),
            ":constants" => {
                let constants = self.typed(rest)?;
                for (name, expression, kind) in constants {
                    if self.constants.iter().any(|(other, _)| *other == name) {
                        return Err(self.twice("constant", &name, expression));
                    }
                    self.constants.push((name, kind));
                }
                Ok(())
            }
            ":predicates" => rest.iter().try_for_each(|one| self.declare_predicate(one)),
            ":action" => {
                let action = self.action(section, rest)?;
                self.actions.push(action);
                Ok(())
            }
            _ => {
                let problem = format!("the section {head:?} is not supported");
                let remedy = "expected :requirements, :types, :constants, :predicates or :action";
                Err(self.error(section, &problem, remedy))
            }
        }
    }

    fn requirements(&self, rest: &[Expression]) -> Result<(), PddlError> {
        let unknown = |e: &&Expression| !e.symbol().is_some_and(|r| REQUIREMENTS.contains(&r));
        rest.iter().find(unknown).map_or(Ok(()), |expression| {
            let problem = format!("{} is not supported", self.excerpt(expression));
            let remedy = format!("supported requirements: {}", REQUIREMENTS.join(" "));
            Err(self.error(expression, &problem, &remedy))
        })
    }

    /// `a b - c`: types may be used above before they are declared.
    fn declare_types(
        &mut self,
        section: &Expression,
        rest: &[Expression],
    ) -> Result<(), PddlError> {
        let groups = self.groups(rest)?;
        for (name, expression, _) in &groups {
            if *name == "object" {
                continue; // everything is one already
            }
            if self.types.find(name).is_some() {
                return Err(self.twice("type", name, expression));
            }
            self.types.names.push((*name).to_owned());
            self.types.parents.push(0);
        }
        for (name, _, above) in groups {
            let (Some(kind), Some(above)) = (self.types.find(name), above) else {
                continue;
            };
            let parent = self.type_of(above)?;
            if kind != 0 {
                self.types.parents[kind] = parent;
            }
        }
        let ring = (1..self.types.names.len()).find(|&kind| !self.types.is_a(kind, 0));
        ring.map_or(Ok(()), |kind| {
            let problem = format!("the type {:?} is below itself", self.types.names[kind]);
            Err(self.error(
                section,
                &problem,
                "give it a type above that is not below it",
            ))
        })
    }

    fn declare_predicate(&mut self, declaration: &Expression) -> Result<(), PddlError> {
        let Some((name, rest)) = declaration.headed() else {
            let problem = "expected a predicate (name ?argument …)";
            return Err(self.error(declaration, problem, "write (name ?a ?b - type)"));
        };
        if name == "=" || self.predicate(name).is_some() {
            return Err(self.twice("predicate", name, declaration));
        }
        let parameters = self.variables(rest)?;
        self.predicates.push(Predicate {
            name: name.to_owned(),
            parameters: parameters.into_iter().map(|(_, kind)| kind).collect(),
            span: declaration.span(),
        });
        Ok(())
    }

    fn action(&self, section: &Expression, rest: &[Expression]) -> Result<ActionSchema, PddlError> {
        let Some((Some(name), rest)) = rest.split_first().map(|(n, rest)| (n.symbol(), rest))
        else {
            let problem = "expected the name of the action";
            return Err(self.error(section, problem, "write (:action name :parameters (…) …)"));
        };
        if self.actions.iter().any(|action| action.name == name) {
            return Err(self.twice("action", name, section));
        }
        let mut scope = Scope::new(self);
        let (mut parameters, mut precondition, mut effects) = (None, None, None);
        for pair in rest.chunks(2) {
            let [key, value] = pair else {
                let problem = format!("nothing follows {}", self.excerpt(&pair[0]));
                return Err(self.error(&pair[0], &problem, "give it a list in parentheses"));
            };
            match key.symbol() {
                Some(":parameters")
                    if (&parameters, &precondition, &effects) == (&None, &None, &None) =>
                {
                    let list = value.list().ok_or_else(|| {
                        let problem = "expected a list of parameters";
                        self.error(value, problem, "write :parameters (?a ?b - type)")
                    })?;
                    parameters = Some(scope.enter(list)?);
                }
                Some(":precondition") if precondition.is_none() => {
                    precondition = Some(scope.formula(value)?);
                }
                Some(":effect") if effects.is_none() => effects = Some(scope.effects(value)?),
                _ => {
                    let problem = format!("unexpected {}", self.excerpt(key));
                    let remedy = "expected :parameters (…), then :precondition (…) and :effect (…)";
                    return Err(self.error(key, &problem, remedy));
                }
            }
        }
        let effects = effects
            .filter(|effects| !effects.is_empty())
            .ok_or_else(|| {
                let problem = format!("the action {name:?} has no effect");
                self.error(section, &problem, "add :effect (…)")
            })?;
        Ok(ActionSchema {
            name: name.to_owned(),
            parameters: parameters.unwrap_or_default(),
            precondition: precondition.unwrap_or(Formula::And(vec![])),
            effects,
        })
    }

    /// The names of `a b - kind c`, each with what stands behind its dash.
    fn groups<'e>(&self, list: &'e [Expression]) -> Result<Vec<Declared<'e>>, PddlError> {
        let mut groups: Vec<Declared<'e>> = Vec::new();
        let mut first = 0;
        let mut elements = list.iter();
        while let Some(element) = elements.next() {
            match element.symbol() {
                Some("-") => {
                    let kind = elements
                        .next()
                        .filter(|_| first < groups.len())
                        .ok_or_else(|| {
                            let problem = "a dash stands between names and their type";
                            self.error(element, problem, "write a b - type")
                        })?;
                    groups[first..]
                        .iter_mut()
                        .for_each(|group| group.2 = Some(kind));
                    first = groups.len();
                }
                Some(name) => groups.push((name, element, None)),
                None => {
                    let problem = format!("expected a name, found {}", self.excerpt(element));
                    return Err(self.error(element, &problem, "write a b - type"));
                }
            }
        }
        Ok(groups)
    }

    /// Names with their types; `object` if none is given.
    pub(super) fn typed<'e>(
        &self,
        list: &'e [Expression],
    ) -> Result<Vec<(String, &'e Expression, TypeId)>, PddlError> {
        let with_type = |(name, expression, kind): Declared<'e>| {
            let kind = kind.map_or(Ok(0), |kind| self.type_of(kind))?;
            Ok((name.to_owned(), expression, kind))
        };
        self.groups(list)?.into_iter().map(with_type).collect()
    }

    /// Variables with their types, each once.
    pub(super) fn variables(
        &self,
        list: &[Expression],
    ) -> Result<Vec<(String, TypeId)>, PddlError> {
        let mut variables: Vec<(String, TypeId)> = Vec::new();
        for (name, expression, kind) in self.typed(list)? {
            if !name.starts_with('?') {
                let problem = format!("expected a variable, found {name:?}");
                return Err(self.error(
                    expression,
                    &problem,
                    "variables begin with a question mark",
                ));
            }
            if variables.iter().any(|(other, _)| *other == name) {
                return Err(self.twice("variable", &name, expression));
            }
            variables.push((name, kind));
        }
        Ok(variables)
    }

    fn type_of(&self, expression: &Expression) -> Result<TypeId, PddlError> {
        let found = expression.symbol().and_then(|name| self.types.find(name));
        found.ok_or_else(|| {
            let problem = format!("no type is called {}", self.excerpt(expression));
            let remedy = format!(
                "declare it in (:types …); known: {}",
                self.types.names.join(", ")
            );
            self.error(expression, &problem, &remedy)
        })
    }

    pub(super) fn error(&self, at: &Expression, problem: &str, remedy: &str) -> PddlError {
        self.source.error(at.span(), problem, remedy)
    }

    fn twice(&self, kind: &str, name: &str, at: &Expression) -> PddlError {
        let problem = format!("the {kind} {name:?} exists already");
        self.error(at, &problem, "give it another name")
    }

    /// What stands there, in quotes and not too long.
    pub(super) fn excerpt(&self, expression: &Expression) -> String {
        let text = &self.source.text[expression.span()];
        let short: String = text.chars().take(40).collect();
        if short.len() < text.len() {
            format!("\"{short}…\"")
        } else {
            format!("\"{short}\"")
        }
    }
}

/// Name and sections of `(define (kind name) …)`.
pub(super) fn define<'e>(
    source: &Source,
    whole: &'e Expression,
    kind: &str,
) -> Result<(&'e str, &'e [Expression]), PddlError> {
    let head = whole.headed().filter(|(head, _)| *head == "define");
    let parts = head.and_then(|(_, rest)| rest.split_first());
    let named = parts.and_then(|(title, sections)| match title.headed()? {
        (word, [name]) if word == kind => Some((name.symbol()?, sections)),
        _ => None,
    });
    named.ok_or_else(|| {
        let problem = format!("this is no PDDL {kind}");
        let remedy = format!("begin with (define ({kind} name) …)");
        source.error(whole.span(), problem, remedy)
    })
}
