//! Ground manipulation tasks: facts, operators with preconditions and effects, start and goal.
//!
//! A small planning task in the manner of STRIPS with disjunctive preconditions. The built-in operators are in
//! [`crate::manipulation`]; a domain read from PDDL replaces them by filling the same types.

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

/// What must hold: at least one fact of every clause of `any_of`, none of `none_of`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Condition {
    /// Clauses; an empty clause can never hold.
    pub any_of: Vec<Vec<Fact>>,
    /// Facts that must be false.
    pub none_of: Vec<Fact>,
}

impl Condition {
    /// True if the state satisfies the condition.
    pub fn holds(&self, state: &FactSet) -> bool {
        self.any_of
            .iter()
            .all(|clause| clause.iter().any(|&fact| state.contains(fact)))
            && !self.none_of.iter().any(|&fact| state.contains(fact))
    }

    fn facts(&self) -> impl Iterator<Item = Fact> + '_ {
        self.any_of.iter().flatten().chain(&self.none_of).copied()
    }
}

/// A ground action of the task.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Operator {
    /// The action in words: `grasp red_box with left_hand`.
    pub label: String,
    /// Precondition.
    pub requires: Condition,
    /// Facts that become false.
    pub deletes: Vec<Fact>,
    /// Facts that become true, after the deletions.
    pub adds: Vec<Fact>,
}

impl Operator {
    /// The state after the action; `None` if its precondition fails or it changes nothing.
    pub fn apply(&self, state: &FactSet) -> Option<FactSet> {
        if !self.requires.holds(state) {
            return None;
        }
        let mut next = state.clone();
        self.deletes.iter().for_each(|&fact| next.remove(fact));
        self.adds.iter().for_each(|&fact| next.insert(fact));
        (next != *state).then_some(next)
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
        for operator in &operators {
            let effects = operator.adds.iter().chain(&operator.deletes).copied();
            check_facts(
                &operator.label,
                operator.requires.facts().chain(effects),
                count,
            )?;
        }
        check_facts("start", start.iter(), count)?;
        check_facts("goal", goal.facts(), count)?;
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

fn check_facts(
    place: &str,
    mut facts: impl Iterator<Item = Fact>,
    count: usize,
) -> Result<(), SymbolicError> {
    let unknown = facts.find(|fact| fact.0 >= count);
    unknown.map_or(Ok(()), |fact| {
        Err(SymbolicError::UnknownFact {
            place: place.to_owned(),
            fact: fact.0,
            count,
        })
    })
}
