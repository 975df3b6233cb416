//! A domain after reading: types, predicates, actions; names are resolved to indices.

use super::source::Source;
use std::ops::Range;

/// Index of a type; 0 is `object`.
pub(crate) type TypeId = usize;

/// Index of a predicate.
pub(crate) type PredicateId = usize;

/// Index of an object of a problem; the constants of the domain come first.
pub(crate) type ObjectId = usize;

/// A ground atom.
pub(crate) type Atom = (PredicateId, Vec<ObjectId>);

/// A PDDL domain: `:strips`, `:typing`, `:equality`, negative, disjunctive and quantified preconditions, quantified and
/// conditional effects.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DomainFile {
    pub(crate) source: Source,
    pub(crate) name: String,
    pub(crate) types: Types,
    pub(crate) constants: Vec<(String, TypeId)>,
    pub(crate) predicates: Vec<Predicate>,
    pub(crate) actions: Vec<ActionSchema>,
}

impl DomainFile {
    /// The text as it was read.
    pub fn text(&self) -> &str {
        &self.source.text
    }

    /// Name of the file as it was given.
    pub fn file(&self) -> &str {
        &self.source.name
    }

    /// Index of a predicate.
    pub(crate) fn predicate(&self, name: &str) -> Option<PredicateId> {
        self.predicates.iter().position(|p| p.name == name)
    }

    /// Does any action change it.
    pub(crate) fn is_fluent(&self, predicate: PredicateId) -> bool {
        self.effects()
            .any(|effect| effect.atom.predicate == predicate)
    }

    /// All effects of all actions.
    pub(crate) fn effects(&self) -> impl Iterator<Item = &Effect> {
        self.actions.iter().flat_map(|action| &action.effects)
    }
}

/// The tree of types.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Types {
    /// Names; the first is `object`.
    pub names: Vec<String>,
    /// Per type the one above it; `object` is its own.
    pub parents: Vec<TypeId>,
}

impl Types {
    pub fn find(&self, name: &str) -> Option<TypeId> {
        self.names.iter().position(|n| n == name)
    }

    /// Is the type `of`, or below it.
    pub fn is_a(&self, mut kind: TypeId, of: TypeId) -> bool {
        // as many steps as there are types: a ring ends too
        for _ in 0..self.names.len() {
            if kind == of {
                return true;
            }
            kind = self.parents[kind];
        }
        kind == of
    }
}

/// A declared predicate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Predicate {
    pub name: String,
    /// Types of the arguments.
    pub parameters: Vec<TypeId>,
    pub span: Range<usize>,
}

/// An action with parameters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ActionSchema {
    pub name: String,
    /// Types of the parameters.
    pub parameters: Vec<TypeId>,
    pub precondition: Formula,
    pub effects: Vec<Effect>,
}

/// A variable by its place among those in scope (parameters first), or an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Term {
    Variable(usize),
    Object(ObjectId),
}

/// A predicate with terms.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Literal {
    pub predicate: PredicateId,
    pub arguments: Vec<Term>,
    pub span: Range<usize>,
}

/// A condition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Formula {
    Atom(Literal),
    Equal(Term, Term),
    Not(Box<Formula>),
    And(Vec<Formula>),
    Or(Vec<Formula>),
    /// For all, or for some, objects of these types, which become the next variables in scope.
    ForAll(Vec<TypeId>, Box<Formula>),
    Exists(Vec<TypeId>, Box<Formula>),
}

impl Formula {
    /// Calls `visit` with every atom.
    pub fn atoms(&self, visit: &mut dyn FnMut(&Literal)) {
        match self {
            Self::Atom(literal) => visit(literal),
            Self::Equal(..) => {}
            Self::Not(body) | Self::ForAll(_, body) | Self::Exists(_, body) => body.atoms(visit),
            Self::And(parts) | Self::Or(parts) => parts.iter().for_each(|part| part.atoms(visit)),
        }
    }
}

/// One atom that an action makes true or false.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Effect {
    /// Types of the variables of all `forall` around it, outermost first.
    pub for_all: Vec<TypeId>,
    /// The conditions of all `when` around it, each with the number of variables in scope there.
    pub when: Vec<(usize, Formula)>,
    /// True: the atom becomes true.
    pub adds: bool,
    pub atom: Literal,
}
