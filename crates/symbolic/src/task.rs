//! Ground manipulation tasks: facts, operators with preconditions and effects, start and goal.
//!
//! What [`crate::pddl`] makes of a domain and a problem: STRIPS with arbitrary conditions and conditional effects.

use crate::error::SymbolicError;

/// Index of a fact in [`Task::facts`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Fact(pub usize);

/// A set of facts: one state of the task.
#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FactSet {
    /// Bit n of word w stands for fact 64 w + n; the last word is not zero.
    words: Vec<u64>,
}

impl FactSet {
    /// True if the fact holds.
    pub fn contains(&self, fact: Fact) -> bool {
        self.words
            .get(fact.0 / 64)
            .is_some_and(|word| word >> (fact.0 % 64) & 1 == 1)
    }

    /// Makes the fact true.
    pub fn insert(&mut self, fact: Fact) {
        let word = fact.0 / 64;
        if self.words.len() <= word {
            self.words.resize(word + 1, 0);
        }
        self.words[word] |= 1 << (fact.0 % 64);
    }

    /// Makes the fact false.
    pub fn remove(&mut self, fact: Fact) {
        if let Some(word) = self.words.get_mut(fact.0 / 64) {
            *word &= !(1 << (fact.0 % 64));
        }
        while self.words.last() == Some(&0) {
            self.words.pop();
        }
    }

    /// The facts that hold, in order.
    pub fn iter(&self) -> impl Iterator<Item = Fact> + '_ {
        (0..64 * self.words.len())
            .map(Fact)
            .filter(|&fact| self.contains(fact))
    }
}

impl FromIterator<Fact> for FactSet {
    fn from_iter<T: IntoIterator<Item = Fact>>(facts: T) -> Self {
        let mut set = Self::default();
        facts.into_iter().for_each(|fact| set.insert(fact));
        set
    }
}

/// What must hold of a state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Condition {
    /// The fact is true.
    Holds(Fact),
    /// The condition does not hold.
    Not(Box<Condition>),
    /// All of them hold; always true if there are none.
    All(Vec<Condition>),
    /// At least one of them holds; never true if there are none.
    Any(Vec<Condition>),
}

impl Default for Condition {
    fn default() -> Self {
        Self::always()
    }
}

impl Condition {
    /// The condition that every state satisfies.
    pub fn always() -> Self {
        Self::All(Vec::new())
    }

    /// The condition that no state satisfies.
    pub fn never() -> Self {
        Self::Any(Vec::new())
    }

    /// [`Condition::always`] or [`Condition::never`].
    pub fn constant(holds: bool) -> Self {
        if holds { Self::always() } else { Self::never() }
    }

    /// True if all hold; parts that always hold are left out, and what follows one that never holds is not looked at.
    pub fn all(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut kept = Vec::new();
        for part in parts {
            match part {
                Self::Any(none) if none.is_empty() => return Self::never(),
                Self::All(parts) => kept.extend(parts),
                other => kept.push(other),
            }
        }
        match kept.len() {
            1 => kept.swap_remove(0),
            _ => Self::All(kept),
        }
    }

    /// True if any holds; parts that never hold are left out, and what follows one that always holds is not looked at.
    pub fn any(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut kept = Vec::new();
        for part in parts {
            match part {
                Self::All(none) if none.is_empty() => return Self::always(),
                Self::Any(parts) => kept.extend(parts),
                other => kept.push(other),
            }
        }
        match kept.len() {
            1 => kept.swap_remove(0),
            _ => Self::Any(kept),
        }
    }

    /// The opposite.
    #[must_use]
    pub fn negated(self) -> Self {
        match self {
            Self::Not(body) => *body,
            Self::All(none) if none.is_empty() => Self::never(),
            Self::Any(none) if none.is_empty() => Self::always(),
            other => Self::Not(Box::new(other)),
        }
    }

    /// True if the state satisfies the condition.
    pub fn holds(&self, state: &FactSet) -> bool {
        match self {
            Self::Holds(fact) => state.contains(*fact),
            Self::Not(body) => !body.holds(state),
            Self::All(parts) => parts.iter().all(|part| part.holds(state)),
            Self::Any(parts) => parts.iter().any(|part| part.holds(state)),
        }
    }

    /// The first fact it names that is not below `count`.
    fn undeclared(&self, count: usize) -> Option<Fact> {
        match self {
            Self::Holds(fact) => (fact.0 >= count).then_some(*fact),
            Self::Not(body) => body.undeclared(count),
            Self::All(parts) | Self::Any(parts) => {
                parts.iter().find_map(|part| part.undeclared(count))
            }
        }
    }
}

/// What an action changes where a condition holds.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Change {
    /// Judged in the state before the action.
    pub when: Condition,
    /// Facts that become false.
    pub deletes: Vec<Fact>,
    /// Facts that become true, after all deletions of the action.
    pub adds: Vec<Fact>,
}

/// A ground action of the task.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Operator {
    /// The action in words: `grasp red_box with left_hand`.
    pub label: String,
    /// Precondition.
    pub requires: Condition,
    /// What becomes of the facts.
    pub changes: Vec<Change>,
}

impl Operator {
    /// The state after the action; `None` if its precondition fails or it changes nothing.
    pub fn apply(&self, state: &FactSet) -> Option<FactSet> {
        if !self.requires.holds(state) {
            return None;
        }
        let takes_place = |change: &&Change| change.when.holds(state);
        let mut next = state.clone();
        for change in self.changes.iter().filter(takes_place) {
            change.deletes.iter().for_each(|&fact| next.remove(fact));
        }
        for change in self.changes.iter().filter(takes_place) {
            change.adds.iter().for_each(|&fact| next.insert(fact));
        }
        (next != *state).then_some(next)
    }

    /// The first fact it names that is not below `count`.
    fn undeclared(&self, count: usize) -> Option<Fact> {
        let of_change = |change: &Change| {
            let facts = change.deletes.iter().chain(&change.adds);
            let listed = facts.copied().find(|fact| fact.0 >= count);
            listed.or_else(|| change.when.undeclared(count))
        };
        let listed = self.changes.iter().find_map(of_change);
        listed.or_else(|| self.requires.undeclared(count))
    }
}

/// A ground planning task.
#[derive(Debug, Clone)]
pub struct Task {
    facts: Vec<String>,
    operators: Vec<Operator>,
    start: FactSet,
    goal: Condition,
}

impl Task {
    /// Puts a task together.
    ///
    /// # Errors
    /// [`SymbolicError::UnknownFact`] if an index is not one of `facts`.
    pub fn new(
        facts: Vec<String>,
        operators: Vec<Operator>,
        start: FactSet,
        goal: Condition,
    ) -> Result<Self, SymbolicError> {
        let count = facts.len();
        let refuse = |place: &str, fact: Option<Fact>| match fact {
            None => Ok(()),
            Some(fact) => Err(SymbolicError::UnknownFact {
                place: place.to_owned(),
                fact: fact.0,
                count,
            }),
        };
        for operator in &operators {
            refuse(&operator.label, operator.undeclared(count))?;
        }
        refuse("start", start.iter().find(|fact| fact.0 >= count))?;
        refuse("goal", goal.undeclared(count))?;
        Ok(Self {
            facts,
            operators,
            start,
            goal,
        })
    }

    /// Names of the facts.
    pub fn facts(&self) -> &[String] {
        &self.facts
    }

    /// The ground actions.
    pub fn operators(&self) -> &[Operator] {
        &self.operators
    }

    /// The state at the start.
    pub fn start(&self) -> &FactSet {
        &self.start
    }

    /// The goal.
    pub fn goal(&self) -> &Condition {
        &self.goal
    }
}
