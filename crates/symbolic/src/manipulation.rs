//! Manipulation tasks of a scene: the actions of a PDDL domain, grounded, and the contacts that their facts stand for.
//!
//! Source: paper, "Manipulation skeleton". The built-in domain is `pddl/manipulation.pddl`: grasp (one hand on a handle,
//! two hands on opposite patches), lift, place, release.

use crate::contact::{Contact, ContactState};
use crate::domain::Domain;
use crate::error::SymbolicError;
use crate::goal::Goal;
use crate::pddl::{Atom, DomainFile, Ground, SceneProblem, labels};
use crate::task::{Fact, FactSet, Task};

/// A ground task together with the contacts that its facts stand for.
#[derive(Debug, Clone)]
pub struct Manipulation {
    /// Facts, operators, start and goal.
    pub task: Task,
    /// Per fact the contacts that hold while it is true; empty for a fact that is none about contacts.
    pub meaning: Vec<Vec<Contact>>,
    /// Per object the fact that it has left its place of the start; `None` where the task does not remember that.
    pub moved: Vec<Option<Fact>>,
}

impl Manipulation {
    /// The actions of the built-in domain for a start and a goal.
    ///
    /// # Errors
    /// Never for a valid domain; see [`Manipulation::of`].
    pub fn builtin(
        domain: &Domain,
        start: &ContactState,
        goal: &Goal,
        release_at_end: bool,
    ) -> Result<Self, SymbolicError> {
        Self::of(&DomainFile::builtin(), domain, start, goal, release_at_end)
    }

    /// The actions of a PDDL domain for a start and a goal.
    ///
    /// The task's goal is the part of `goal` that facts decide: objects on supports and grasps. With
    /// `release_at_end` the objects of the goal are let go as well, except by grasps that the goal names.
    ///
    /// # Errors
    /// [`SymbolicError::Pddl`] if the domain does not fit the scene: a predicate that nothing makes true, an effect that
    /// stands for an impossible contact, a goal that no action brings about.
    pub fn of(
        file: &DomainFile,
        domain: &Domain,
        start: &ContactState,
        goal: &Goal,
        release_at_end: bool,
    ) -> Result<Self, SymbolicError> {
        let scene = SceneProblem::new(file, domain, start, goal, release_at_end)?;
        let ground = Ground::new(file, &scene.problem);
        let meaning = ground.atoms.iter().map(|atom| scene.meaning(atom));
        let meaning = meaning.collect::<Result<_, _>>()?;
        let names = &scene.problem.objects;
        let labels = labels(file, domain, names, &scene.parts, &ground.actions);
        let fact = |atom: Atom| ground.atoms.iter().position(|a| *a == atom).map(Fact);
        let objects = 0..domain.objects().len();
        let moved = objects.map(|o| scene.moved(o).and_then(fact)).collect();
        let task = ground.task(file, &scene.problem, labels)?;
        Ok(Self {
            task,
            meaning,
            moved,
        })
    }

    /// The contacts that a state of the task imposes.
    pub fn imposed(&self, facts: &FactSet) -> ContactState {
        facts
            .iter()
            .flat_map(|fact| self.meaning[fact.0].iter().copied())
            .collect()
    }
}
