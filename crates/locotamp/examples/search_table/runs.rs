//! Which runs the benchmark consists of.

use locotamp::{Refinement, Request, Search};
use scene::{Perturbation, Scene, SceneError};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The scenes of our own, beside the paper's two.
const SCENES: [&str; 10] = [
    "stairs",
    "handrail",
    "stack",
    "swap",
    "under-table",
    "high-shelf",
    "support",
    "stepping-stones",
    "behind",
    "three-boxes",
];
/// Sequences after whose optimisation a run ends in any case: what the paper evaluates, and the default.
pub const EVALUATED: usize = 200;
/// Time limits [s].
const TASK_LIMIT: f64 = 600.0;
const EVALUATED_LIMIT: f64 = 3600.0;
const SCENE_LIMIT: f64 = 300.0;
const POLICY_LIMIT: f64 = 180.0;
/// The search's seed for all perturbed scenes.
const PERTURBED_SEED: u64 = 1;

/// A part of the benchmark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Part {
    /// The paper's first task: until the first plan, and 200 sequences.
    TwoBox,
    /// The paper's second task.
    Climb,
    /// Other scenes, each until the first plan.
    Scenes,
    /// The three ways to choose sequences, on two-box.
    Policies,
    /// Random variants of the paper's tasks.
    Perturbed,
    /// How many different plans there are after ten minutes; of climb, its own part says it.
    Diverse,
}

impl Part {
    const ALL: [Self; 6] = [
        Self::TwoBox,
        Self::Climb,
        Self::Scenes,
        Self::Policies,
        Self::Perturbed,
        Self::Diverse,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::TwoBox => "two-box",
            Self::Climb => "climb",
            Self::Scenes => "scenes",
            Self::Policies => "policies",
            Self::Perturbed => "perturbed",
            Self::Diverse => "diverse",
        }
    }

    /// The part of a name.
    pub fn named(name: &str) -> Result<Self, String> {
        let part = Self::ALL.into_iter().find(|part| part.name() == name);
        let names = || Self::ALL.map(Self::name).join(", ");
        part.ok_or_else(|| format!("no part {name:?}, expected some of {}", names()))
    }
}

/// How sequences are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Policy {
    Tree,
    BestFirst,
    Random,
}

impl Policy {
    pub fn name(self) -> &'static str {
        match self {
            Self::Tree => "tree",
            Self::BestFirst => "best-first",
            Self::Random => "random",
        }
    }

    fn search(self) -> Search {
        match self {
            Self::Tree => Search::Tree,
            Self::BestFirst => Search::BestFirst,
            Self::Random => Search::Random,
        }
    }
}

/// What ends a run before its limits do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Until {
    /// The first plan.
    Plan,
    /// A plan with both feet on the platform, over the box.
    Climbed,
    /// Nothing.
    Limits,
}

impl Until {
    pub fn name(self) -> &'static str {
        match self {
            Self::Plan => "until a plan",
            Self::Climbed => "until over the box",
            Self::Limits => "all plans",
        }
    }
}

/// What several runs have in common.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Group {
    pub part: Part,
    pub scene: String,
    pub policy: Policy,
    pub until: Until,
    /// Wall time [s].
    pub time_limit: f64,
    /// Least and most sequences that are optimised.
    #[serde(default)]
    pub min_optimised: usize,
    pub max_optimised: usize,
    /// Plans with different loaded contacts after which a run without another end is over.
    #[serde(default)]
    pub wanted_plans: Option<usize>,
    /// True if the best plan is refined, within the time limit.
    pub refine: bool,
}

impl Group {
    fn new(part: Part, scene: &str, until: Until, time_limit: f64) -> Self {
        Self {
            part,
            scene: scene.to_owned(),
            policy: Policy::Tree,
            until,
            time_limit,
            min_optimised: 0,
            max_optimised: EVALUATED,
            wanted_plans: None,
            refine: false,
        }
    }

    /// The best five of as many sequences as may be optimised.
    fn best_of_all(self) -> Self {
        Self {
            min_optimised: self.max_optimised,
            wanted_plans: Some(5),
            ..self
        }
    }

    fn refined(self) -> Self {
        Self {
            refine: true,
            ..self
        }
    }

    fn by(self, policy: Policy) -> Self {
        Self { policy, ..self }
    }

    pub fn name(&self) -> String {
        let (part, scene, policy) = (self.part.name(), &self.scene, self.policy.name());
        let (until, limit) = (self.until.name(), self.time_limit);
        format!("{part}: {scene}, {policy}, {until}, {limit} s")
    }
}

/// One run; two that are equal are the same experiment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Run {
    #[serde(flatten)]
    pub group: Group,
    /// Of the search.
    pub seed: u64,
    /// Number of the perturbation; 0 is the scene itself.
    pub variant: u64,
}

impl Run {
    pub fn name(&self) -> String {
        let (group, seed) = (self.group.name(), self.seed);
        match self.variant {
            0 => format!("{group}, seed {seed}"),
            variant => format!("{group}, seed {seed}, variant {variant}"),
        }
    }

    /// The scene, perturbed if that is meant.
    pub fn scene(&self) -> Result<Scene, SceneError> {
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes"));
        let path = folder.join(&self.group.scene).with_extension("toml");
        let scene = Scene::load(&path)?;
        Ok(match self.variant {
            0 => scene,
            variant => scene.perturbed(&Perturbation::default(), variant),
        })
    }

    /// What the library is asked for; every different plan is kept unless the first is enough.
    pub fn request(&self, threads: usize) -> Request {
        let group = &self.group;
        Request {
            search: group.policy.search(),
            threads,
            seed: self.seed,
            time_limit: group.time_limit,
            solutions: match group.until {
                Until::Plan => 1,
                Until::Climbed | Until::Limits => group.wanted_plans.unwrap_or(usize::MAX),
            },
            min_optimised: group.min_optimised,
            max_optimised: group.max_optimised,
            refinement: group.refine.then(Refinement::default),
            ..Request::default()
        }
    }
}

/// How much of the benchmark is wanted.
#[derive(Debug, Clone, PartialEq)]
pub struct Extent {
    pub parts: Vec<Part>,
    /// Seeds are 1 to this.
    pub seeds: u64,
    /// Perturbations are 1 to this.
    pub variants: u64,
    /// Instead of each run's own [s].
    pub time_limit: Option<f64>,
}

impl Default for Extent {
    fn default() -> Self {
        Self {
            parts: Part::ALL.to_vec(),
            seeds: 5,
            variants: 20,
            time_limit: None,
        }
    }
}

/// All runs, part by part; within a part all groups with the first seed come first.
pub fn all(extent: &Extent) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for &part in &extent.parts {
        let of_part = if part == Part::Perturbed {
            of_groups(part, (PERTURBED_SEED, PERTURBED_SEED), (1, extent.variants))
        } else {
            of_groups(part, (1, extent.seeds), (0, 0))
        };
        for mut run in of_part {
            let limit = &mut run.group.time_limit;
            *limit = extent.time_limit.unwrap_or(*limit);
            if !runs.contains(&run) {
                runs.push(run);
            }
        }
    }
    runs
}

fn of_groups(part: Part, seeds: (u64, u64), variants: (u64, u64)) -> Vec<Run> {
    let groups = groups(part);
    let mut runs = Vec::new();
    for seed in seeds.0..=seeds.1 {
        for variant in variants.0..=variants.1 {
            runs.extend(groups.iter().map(|group| Run {
                group: group.clone(),
                seed,
                variant,
            }));
        }
    }
    runs
}

fn groups(part: Part) -> Vec<Group> {
    let climb = || Group::new(Part::Climb, "climb", Until::Limits, TASK_LIMIT).refined();
    match part {
        Part::TwoBox => vec![
            Group::new(part, "two-box", Until::Plan, TASK_LIMIT).refined(),
            Group::new(part, "two-box", Until::Limits, EVALUATED_LIMIT)
                .best_of_all()
                .refined(),
        ],
        Part::Climb => vec![climb()],
        Part::Scenes => SCENES
            .map(|scene| Group::new(part, scene, Until::Plan, SCENE_LIMIT).refined())
            .to_vec(),
        Part::Policies => [Policy::Tree, Policy::BestFirst, Policy::Random]
            .map(|policy| Group::new(part, "two-box", Until::Limits, POLICY_LIMIT).by(policy))
            .to_vec(),
        Part::Perturbed => vec![
            Group::new(part, "two-box", Until::Plan, SCENE_LIMIT).refined(),
            Group::new(part, "climb", Until::Climbed, TASK_LIMIT),
        ],
        Part::Diverse => vec![
            Group::new(part, "two-box", Until::Limits, TASK_LIMIT),
            climb(),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_that_two_parts_need_is_made_once() {
        let of = |parts: &[Part]| {
            let parts = parts.to_vec();
            all(&Extent {
                parts,
                ..Extent::default()
            })
            .len()
        };
        assert_eq!((of(&[Part::Climb]), of(&[Part::Diverse])), (5, 10));
        assert_eq!(of(&[Part::Climb, Part::Diverse]), 10);
        assert_eq!(of(&Part::ALL), 10 + 5 + 50 + 15 + 40 + 5);
    }

    #[test]
    fn every_scene_can_be_loaded_and_a_variant_is_another_one() {
        for run in all(&Extent {
            seeds: 1,
            variants: 1,
            ..Extent::default()
        }) {
            let scene = run.scene().expect("a scene");
            let plain = Run { variant: 0, ..run }.scene().expect("a scene");
            let mass = |scene: &Scene| scene.objects.iter().map(|o| o.mass).sum::<f64>();
            assert_eq!(mass(&scene) == mass(&plain), run.variant == 0);
        }
    }
}
