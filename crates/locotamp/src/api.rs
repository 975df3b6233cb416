//! What a caller asks for, sees on the way and gets.

use crate::export;
use crate::quality::{self, Quality};
use crate::refine::Refined;
use crate::summary::{self, Summary};
use ocp::{Integrator, Motion, Preset, Refinement, Sticking};
use plan::Plan;
use scene::Scene;
use std::num::NonZero;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use symbolic::SymbolicError;

/// How the search chooses the next contact sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Search {
    /// Monte-Carlo tree search, the paper's.
    #[default]
    Tree,
    /// All sequences in order of their symbolic cost.
    BestFirst,
    /// Random walks without memory.
    Random,
}

impl Search {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tree => "tree",
            Self::BestFirst => "best_first",
            Self::Random => "random",
        }
    }
}

/// A flag by which another thread or a signal handler ends a run; the best so far is returned.
#[derive(Debug, Clone, Default)]
pub struct Stop(pub Arc<AtomicBool>);

impl Stop {
    /// True once the run is to end.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}

impl PartialEq for Stop {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// Options of one planning run.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// Which trajectory problem.
    pub preset: Preset,
    /// How sequences are chosen.
    pub search: Search,
    /// Threads that optimise motions; 0: one per processor. The result does not depend on it.
    pub threads: usize,
    /// File of the search's answers, so that a run can be continued.
    pub journal: Option<PathBuf>,
    /// Continue the run whose journal that is.
    pub resume: bool,
    /// Ends the run when set.
    pub stop: Stop,
    /// Seed of every random choice; the same scene and seed give the same plan.
    pub seed: u64,
    /// Wall time after which the best plan so far is returned [s]; infinite by default.
    pub time_limit: f64,
    /// Number of plans with different loaded contacts after which the search ends, and of those that it returns.
    pub solutions: usize,
    /// Least sequences that are optimised before the search may end with enough plans. Once there is one plan, they are so on the
    /// coarse grid, and the best of them are tried on the finer one, so that the plans are the best of many. Half of a time
    /// limit at most is spent on it.
    pub min_optimised: usize,
    /// Most sequences that are optimised.
    pub max_optimised: usize,
    /// How states follow from one another before refinement; the preset `paper` has explicit Euler only.
    pub integrator: Integrator,
    /// How contacts stick on the coarse grid; by velocity with explicit Euler only.
    pub sticking: Sticking,
    /// The finer grid of the returned plan; `None` for the coarse one. The preset `paper` has none.
    pub refinement: Option<Refinement>,
    /// Explain why a given sequence has no motion, and what would give it one: takes many solves. A search that comes as far as no
    /// motion explains a simple sequence.
    pub explain: bool,
}

impl Request {
    /// How a motion is refined, if it is: the paper's problem has no finer grid.
    pub(crate) fn refines(&self) -> Option<Refinement> {
        self.refinement.filter(|_| self.preset == Preset::Default)
    }

    /// Threads that are wanted.
    pub(crate) fn thread_count(&self) -> usize {
        if self.threads == 0 {
            thread::available_parallelism().map_or(1, NonZero::get)
        } else {
            self.threads
        }
    }
}

impl Default for Request {
    fn default() -> Self {
        Self {
            preset: Preset::Default,
            search: Search::Tree,
            threads: 0,
            journal: None,
            resume: false,
            stop: Stop::default(),
            seed: 0,
            time_limit: f64::INFINITY,
            solutions: 5,
            min_optimised: 0,
            max_optimised: 200,
            integrator: Integrator::Euler,
            sticking: Sticking::Displacement,
            refinement: Some(Refinement::default()),
            explain: false,
        }
    }
}

/// What happens during a run. The observer returns false to stop.
#[derive(Debug, Clone)]
pub enum Event {
    /// The search begins: sizes of the symbolic problem.
    Started {
        /// Number of interfaces.
        interfaces: usize,
        /// Number of possible contacts.
        contacts: usize,
        /// Largest number of phases K_max.
        max_phases: usize,
        /// Length of the shortest manipulation skeleton; 0 also if there is none whose lifts are possible.
        skeleton: usize,
    },
    /// A complete contact sequence is looked at.
    Sequence {
        /// Its number, from 1.
        number: usize,
        /// What changes on entering each phase.
        labels: Vec<String>,
    },
    /// Its keyframes were solved.
    Keyframes {
        /// Number of the sequence.
        number: usize,
        /// False: the sequence is geometrically impossible.
        possible: bool,
        /// Why it is not.
        reason: Option<String>,
    },
    /// One iteration of the trajectory optimiser.
    Iteration {
        /// Number of the sequence; 0 for the refinement of the best one.
        number: usize,
        /// Iteration.
        iteration: usize,
        /// Largest violation (scaled).
        violation: f64,
        /// Objective.
        objective: f64,
    },
    /// A feasible plan, as it is before refinement.
    Solution {
        /// Number of the sequence.
        number: usize,
        /// True if it is the best so far.
        best: bool,
        /// The plan.
        plan: Box<Plan>,
    },
    /// The best motion is optimised again on a finer grid.
    Refining {
        /// Longest interval [s].
        max_step: f64,
    },
    /// A changed scene is being solved, to explain why there is no motion.
    Explaining {
        /// What is being tried.
        doing: String,
        /// Number of solves so far.
        solves: usize,
        /// Iteration of the present one; 0 at its start.
        iteration: usize,
    },
    /// A motion was found on the coarse grid; it waits for its turn on the grid on which it must hold.
    Coarse {
        /// Number of the sequence.
        number: usize,
        /// Its cost.
        cost: f64,
    },
    /// A trajectory was optimised.
    Optimised {
        /// Number of the sequence.
        number: usize,
        /// Does it satisfy everything.
        feasible: bool,
        /// Its cost.
        cost: f64,
        /// What resists, if it does not.
        reason: Option<String>,
    },
    /// A sequence counts as tried: it is the next of [`Outcome::attempts`].
    Tried {
        /// Number of the sequence.
        number: usize,
        /// How far it got.
        reached: Reached,
    },
}

/// How far a sequence got.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reached {
    /// Its keyframes are impossible, or promise less than a plan that is there (objective "base height").
    Keyframes,
    /// It was left out, since others failed again and again at the same contacts, or another has become the same by more steps.
    Alike,
    /// It has a motion on the coarse grid, and the search ended before its turn on the grid on which it must hold.
    Coarse,
    /// It was optimised without success.
    Optimised,
    /// It is a feasible plan.
    Feasible,
}

/// A sequence that was tried.
#[derive(Debug, Clone)]
pub struct Attempt {
    /// Its number.
    pub number: usize,
    /// What changes on entering each phase.
    pub labels: Vec<String>,
    /// How far it got.
    pub reached: Reached,
    /// Why it got no further.
    pub reason: Option<String>,
    /// Cost if optimised.
    pub cost: Option<f64>,
    /// Solver iterations.
    pub iterations: usize,
    /// Time spent [s].
    pub seconds: f64,
}

/// A feasible plan among others.
#[derive(Debug, Clone)]
pub struct Alternative {
    /// Number of its sequence.
    pub number: usize,
    /// Cost of the optimiser.
    pub cost: f64,
    /// Sum of the durations [s].
    pub duration: f64,
    /// Contacts that bear load, phase by phase.
    pub loaded: Vec<Vec<String>>,
    /// The plan before refinement.
    pub plan: Plan,
}

/// What was refused before any sequence with it was looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Refusal {
    /// States that contain some contacts, and transitions that join them: no configuration satisfies these together.
    Contacts,
    /// Lifts by contacts that bear less than the object weighs.
    Lift,
    /// Beginnings of sequences without keyframes.
    Beginning,
}

/// Contacts that were refused, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Impossible {
    /// What was refused for them.
    pub what: Refusal,
    /// The contacts, "a on b"; of beginnings what resists, without the amount.
    pub contacts: Vec<String>,
    /// Why, in words.
    pub reason: String,
    /// Number of states, transitions, lifts or beginnings that were refused for it.
    pub refused: usize,
}

/// A plan with its summary.
#[derive(Debug, Clone)]
pub struct Found {
    /// The plan file's content.
    pub plan: plan::Plan,
    /// The short summary for people.
    pub summary: Summary,
    /// What became of the finer grid.
    pub refined: Refined,
    /// Smoothness, residuals between the nodes, margins.
    pub quality: Quality,
}

impl Found {
    /// True if the plan is the motion on the finer grid.
    pub(crate) fn is_refined(&self) -> bool {
        matches!(self.refined, Refined::Done { .. })
    }

    /// Everything that is written about a motion.
    pub(crate) fn of(
        scene: &Scene,
        labels: &[String],
        motion: &mut Motion,
        refined: Refined,
    ) -> Self {
        let quality = quality::measure(scene, motion);
        let mut plan = export::plan(scene, labels, motion);
        if let Ok(value) = serde_json::to_value(&quality) {
            plan.extra.insert("quality".into(), value);
        }
        Self {
            plan,
            summary: summary::summarise(scene, labels, motion),
            refined,
            quality,
        }
    }
}

/// Why a contact sequence has no motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Explained {
    /// What changes on entering each phase.
    pub labels: Vec<String>,
    /// What resists, and what would change that.
    pub explanation: plan::Explanation,
}

/// What would make contacts possible that exclude one another.
#[derive(Debug, Clone, PartialEq)]
pub struct Possible {
    /// The contacts, "a on b".
    pub contacts: Vec<String>,
    /// The number to change.
    pub remedy: plan::Remedy,
}

/// Result of a run.
#[derive(Debug)]
pub struct Outcome {
    /// The best feasible plan, else the least violated motion (its `status` says which).
    pub best: Option<Found>,
    /// True if `best` satisfies everything.
    pub feasible: bool,
    /// The best feasible plans that differ in their loaded contacts, the best first: the cheapest of those that get about the most for
    /// the scene's objective, then the others.
    pub alternatives: Vec<Alternative>,
    /// Wall time until the first feasible plan [s].
    pub first_after: Option<f64>,
    /// All sequences tried, in order.
    pub attempts: Vec<Attempt>,
    /// Contacts that were refused: since they exclude one another, cannot bear what they lift, or end beginnings.
    pub impossible: Vec<Impossible>,
    /// What would make refused contacts possible, where that is known, there is no plan and the request asks for it.
    pub possible: Vec<Possible>,
    /// Why a simple sequence that lifts what the goal speaks of has no keyframes, if moreover nothing came as far as a motion.
    pub explained: Option<Explained>,
    /// Why the search ended, in words.
    pub ended: String,
    /// Wall time [s].
    pub seconds: f64,
}

/// Why a scene cannot be planned at all.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The robot and the objects do not make a multibody model.
    #[error("{0}")]
    Model(#[from] multibody::ModelError),
    /// The symbolic problem is ill-posed.
    #[error("{0}")]
    Symbolic(#[from] SymbolicError),
    /// The start pose is in collision.
    #[error(
        "the start pose is in collision: {a} is {depth_mm:.0} mm inside {b}; move one of them, or change the start joints"
    )]
    StartInCollision {
        /// One body.
        a: String,
        /// The other body.
        b: String,
        /// Overlap [mm].
        depth_mm: f64,
    },
    /// The preset and the integrator do not go together.
    #[error(
        "the preset `paper` has explicit Euler only (its momentum rows are defined with it); drop the integrator or the preset"
    )]
    PaperIntegrator,
    /// Sticking and integrator do not go together.
    #[error(
        "contacts that stick by velocity drift, and do so with explicit Euler only (the paper's); drop the integrator, or let them \
         stick by displacement"
    )]
    VelocitySticking,
    /// The journal cannot be used.
    #[error("journal {path}: {reason}")]
    Journal {
        /// Where it is.
        path: String,
        /// Why.
        reason: String,
    },
    /// The goal cannot be reached by any sequence of manipulation actions.
    #[error("{0}")]
    Unreachable(String),
}
