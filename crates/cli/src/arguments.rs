//! What can be written after `locotamp`.

use crate::export_command::ExportOptions;
use crate::report_command::ReportOptions;
use crate::robot_command::RobotOptions;
use crate::view_command::ViewOptions;
use crate::watch_command::WatchOptions;
use clap::{Args, Parser, Subcommand, ValueEnum};
use locotamp::{Refinement, Request};
use std::path::PathBuf;

/// Task and motion planning for humanoid loco-manipulation.
#[derive(Debug, Parser)]
#[command(name = "locotamp", version, after_help = EXIT_CODES)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_CODES: &str = "Exit codes: 0 done, 1 no plan or plan rejected, 2 bad usage or input.";

const BENCH_EXIT_CODES: &str =
    "Exit codes: 0 all outcomes are as expected, 1 some are not, 2 bad usage or input.";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Find contacts and motion for a scene, and write plan.json
    #[command(after_help = EXIT_CODES)]
    Plan(PlanOptions),
    /// Optimise one given contact sequence, and write plan.json and report.json
    #[command(after_help = EXIT_CODES)]
    Solve(SolveOptions),
    /// Solve all sequence files of a folder and compare with what they expect
    #[command(after_help = BENCH_EXIT_CODES)]
    Bench(BenchOptions),
    /// Judge a plan file: is every constraint satisfied
    #[command(after_help = EXIT_CODES)]
    Check(CheckOptions),
    /// Write one page that shows plans in a browser: motion, contacts, torques, the checker's verdict
    View(ViewOptions),
    /// Serve the page of a run on this machine while its search goes on
    Watch(WatchOptions),
    /// Draw the figures of a paper: contact sequence, torques, snapshots, animated picture
    Report(ReportOptions),
    /// Write a plan as NumPy arrays at a fixed rate, for controllers and motion trackers
    #[command(after_help = EXIT_CODES)]
    Export(ExportOptions),
    /// List the built-in scenes, or print one to start from
    Scenes {
        /// Print the text of this scene
        name: Option<String>,
    },
    /// Show interfaces, possible contacts, limits and skeletons of a scene, and what the pruning rules leave
    #[command(after_help = EXIT_CODES)]
    Symbols(SymbolsOptions),
    /// Draft a robot file from a URDF or MJCF: feet, hands, soles, palms and a nominal stance
    Robot(RobotOptions),
}

impl Command {
    /// True if standard output is to be JSON.
    pub(crate) fn for_machines(&self) -> bool {
        match self {
            Self::Plan(options) => options.json,
            Self::Solve(options) => options.json,
            Self::Bench(options) => options.json,
            Self::Check(options) => options.json,
            Self::Symbols(options) => options.json,
            Self::View(_)
            | Self::Watch(_)
            | Self::Report(_)
            | Self::Export(_)
            | Self::Robot(_)
            | Self::Scenes { .. } => false,
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct PlanOptions {
    /// Name of a built-in scene (see `locotamp scenes`), or path of a .toml file
    pub scene: String,
    /// Folder for plans, journal and the page of the search [default: a fresh one, runs/<date>-<time>-<scene>]
    #[arg(long, visible_alias = "report", value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Seed of random choices; the same scene and seed give the same plan
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// End after this many seconds with the best so far
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub time_limit: Option<f64>,
    #[command(flatten)]
    pub search: SearchOptions,
    /// Serve the page of the search on this machine while it runs
    #[arg(long)]
    pub live: bool,
    #[command(flatten)]
    pub problem: ProblemOptions,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
    /// No progress
    #[arg(long, short)]
    pub quiet: bool,
}

/// How `plan` searches.
#[derive(Debug, Args)]
pub(crate) struct SearchOptions {
    /// How the next contact sequence is chosen
    #[arg(long, value_enum, default_value_t = SearchName::Tree)]
    pub search: SearchName,
    /// End with so many plans that differ in what bears load
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = at_least_one)]
    pub solutions: usize,
    /// Optimise at least so many contact sequences, and end with the best of their plans
    ///
    /// The first plan is sought as without it. Half of a time limit at most is spent on more sequences.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub min_sequences: usize,
    /// Optimise at most so many contact sequences
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub max_sequences: usize,
    /// Continue the run whose journal is in --out, without asking again what it knows
    #[arg(long, requires = "out")]
    pub resume: bool,
}

/// Ways to search.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum SearchName {
    /// Monte-Carlo tree search
    Tree,
    /// In order of symbolic cost
    BestFirst,
    /// Random walks
    Random,
}

impl From<SearchName> for locotamp::Search {
    fn from(name: SearchName) -> Self {
        match name {
            SearchName::Tree => Self::Tree,
            SearchName::BestFirst => Self::BestFirst,
            SearchName::Random => Self::Random,
        }
    }
}

/// What `plan` and `solve` optimise.
#[derive(Debug, Args)]
pub(crate) struct ProblemOptions {
    /// Which trajectory problem is solved
    #[arg(long, value_enum, default_value_t = PresetName::Default)]
    pub preset: PresetName,
    /// How states follow from one another before the refinement
    #[arg(long, value_enum, default_value_t = IntegratorName::Euler)]
    pub integrator: IntegratorName,
    /// How contacts stick on the coarse grid
    #[arg(long, value_enum, default_value_t = StickingName::Displacement)]
    pub sticking: StickingName,
    /// Longest step of the refined motion that is written
    #[arg(long, value_name = "S", value_parser = refine_step, default_value_t = 0.02)]
    pub refine_step: f64,
    /// Write the optimiser's coarse motion as it is
    #[arg(long)]
    pub no_refine: bool,
    /// Leave the joint torque limits out, torque at speed too (to see what they change)
    #[arg(long)]
    pub no_torque_limits: bool,
    /// If there is no motion, do not look for what would give one (which takes many solves)
    #[arg(long)]
    pub no_explain: bool,
    /// Threads that optimise motions; 0: one per processor. The result does not depend on it
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

impl ProblemOptions {
    /// The request for the library.
    pub(crate) fn request(&self, time_limit: Option<f64>) -> Request {
        let refinement = (!self.no_refine).then(|| Refinement {
            max_step: self.refine_step,
            ..Refinement::default()
        });
        Request {
            preset: self.preset.into(),
            integrator: self.integrator.into(),
            sticking: self.sticking.into(),
            time_limit: time_limit.unwrap_or(f64::INFINITY),
            refinement,
            threads: self.threads,
            explain: !self.no_explain,
            ..Request::default()
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct SolveOptions {
    /// Name of a built-in scene (see `locotamp scenes`), or path of a .toml file
    pub scene: String,
    /// The sequence file (docs/sequence-format.md), or a plan file whose sequence it is
    #[arg(long, value_name = "FILE")]
    pub sequence: PathBuf,
    /// Folder for plan.json and report.json [default: a fresh one, runs/<date>-<time>-<scene>]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// End after this many seconds with the last iterate
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub time_limit: Option<f64>,
    #[command(flatten)]
    pub problem: ProblemOptions,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
    /// No progress
    #[arg(long, short)]
    pub quiet: bool,
}

#[derive(Debug, Args)]
pub(crate) struct BenchOptions {
    /// Folder with sequence files, searched with its subfolders
    #[arg(value_name = "DIR", default_value = "scenes/sequences")]
    pub folder: PathBuf,
    /// Only sequences whose path below the folder contains this text
    #[arg(long, value_name = "TEXT")]
    pub filter: Option<String>,
    /// Solve this many random variants of every scene too: objects ±5 cm, masses × 0.5 to 2, tables ±3 cm, friction ±20 %
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub variants: usize,
    /// Largest number of intervals of the sequences taken
    #[arg(long, value_name = "N")]
    pub max_intervals: Option<usize>,
    /// End each sequence after this many seconds
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub time_limit: Option<f64>,
    /// So many intervals in every phase, in place of the file's (to see what longer problems cost)
    #[arg(long, value_name = "N", value_parser = count)]
    pub steps: Option<usize>,
    /// Which trajectory problem is solved
    #[arg(long, value_enum, default_value_t = PresetName::Default)]
    pub preset: PresetName,
    /// How states follow from one another before the refinement
    #[arg(long, value_enum, default_value_t = IntegratorName::Euler)]
    pub integrator: IntegratorName,
    /// How contacts stick on the coarse grid
    #[arg(long, value_enum, default_value_t = StickingName::Displacement)]
    pub sticking: StickingName,
    /// Leave the joint torque limits out, torque at speed too (to see what they change)
    #[arg(long)]
    pub no_torque_limits: bool,
    /// One JSON list on standard output
    #[arg(long)]
    pub json: bool,
    /// No progress
    #[arg(long, short)]
    pub quiet: bool,
}

#[derive(Debug, Args)]
pub(crate) struct SymbolsOptions {
    /// Name of a built-in scene, or path of a .toml file
    pub scene: String,
    /// Write a graph to this file, for Graphviz
    #[arg(long, value_name = "FILE")]
    pub dot: Option<PathBuf>,
    /// Write a graph to this file, as JSON
    #[arg(long, value_name = "FILE")]
    pub graph_json: Option<PathBuf>,
    /// Which graph is written
    #[arg(long, value_enum, default_value_t = GraphName::Skeletons)]
    pub graph: GraphName,
    /// Most nodes of the graph of contact states that is written
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = nodes)]
    pub nodes: usize,
    /// Write domain.pddl and problem.pddl into this folder, for other planners
    #[arg(long, value_name = "DIR")]
    pub pddl: Option<PathBuf>,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// The graphs by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum GraphName {
    /// Manipulation states and the actions of skeletons
    Skeletons,
    /// Contact states along skeletons, breadth first from the start
    Contacts,
}

/// The presets by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PresetName {
    /// What a robot should execute: no slip, distances as constraints, margins
    Default,
    /// The paper's problem, for comparisons; to the letter with `--sticking velocity`
    Paper,
}

impl From<PresetName> for locotamp::Preset {
    fn from(name: PresetName) -> Self {
        match name {
            PresetName::Default => Self::Default,
            PresetName::Paper => Self::Paper,
        }
    }
}

/// The integrators by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum IntegratorName {
    /// Explicit Euler, as in the paper
    Euler,
    /// Semi-implicit Euler
    SemiImplicitEuler,
    /// Acceleration held over each interval
    ConstantAcceleration,
}

impl From<IntegratorName> for locotamp::Integrator {
    fn from(name: IntegratorName) -> Self {
        match name {
            IntegratorName::Euler => Self::Euler,
            IntegratorName::SemiImplicitEuler => Self::SemiImplicitEuler,
            IntegratorName::ConstantAcceleration => Self::ConstantAcceleration,
        }
    }
}

/// The ways to stick by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum StickingName {
    /// The place of a contact is the same from one node to the next
    Displacement,
    /// Its velocity along the surface is zero, as in the paper, which drifts by millimetres and more; explicit Euler only
    Velocity,
}

impl From<StickingName> for locotamp::Sticking {
    fn from(name: StickingName) -> Self {
        match name {
            StickingName::Displacement => Self::Displacement,
            StickingName::Velocity => Self::Velocity,
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct CheckOptions {
    /// The plan file
    pub plan: PathBuf,
    /// Which tolerances
    #[arg(long, value_enum, default_value_t = ProfileName::Default)]
    pub profile: ProfileName,
    /// Measurements (WARN) beyond their tolerance reject too
    #[arg(long)]
    pub strict: bool,
    /// Collision samples per interval
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = count)]
    pub substeps: usize,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

/// The sets of tolerances by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProfileName {
    /// For plans from anywhere
    Default,
    /// What a plan must reach to be reported as feasible
    Accept,
}

/// A step of the refined motion [s]: shorter ones fill the memory, longer ones refine nothing.
fn refine_step(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.002..=0.1).contains(&value) => Ok(value),
        _ => Err("expected a number of seconds from 0.002 to 0.1".into()),
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 => Ok(value),
        _ => Err("expected a positive number of seconds".into()),
    }
}

fn nodes(text: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(value @ 1..=1_000_000) => Ok(value),
        _ => Err("expected a whole number from 1 to 1000000".into()),
    }
}

fn at_least_one(text: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(value @ 1..) => Ok(value),
        _ => Err("expected a whole number of at least 1".into()),
    }
}

fn count(text: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(value @ 1..=1000) => Ok(value),
        _ => Err("expected a whole number from 1 to 1000".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn the_folder_of_a_run_goes_by_two_names() {
        for name in ["--out", "--report"] {
            let given = ["locotamp", "plan", "pick-place", name, "here"];
            let Command::Plan(options) = Arguments::parse_from(given).command else {
                panic!("another command");
            };
            assert_eq!(options.out.as_deref(), Some("here".as_ref()));
        }
    }

    #[test]
    fn a_time_limit_is_a_positive_number() {
        assert_eq!(seconds("2.5"), Ok(2.5));
        for bad in ["0", "-1", "nan", "soon"] {
            assert!(seconds(bad).is_err(), "{bad}");
        }
        assert_eq!(refine_step("0.01"), Ok(0.01));
        for bad in ["0", "1e-9", "1", "nan"] {
            assert!(refine_step(bad).is_err(), "{bad}");
        }
    }
}
