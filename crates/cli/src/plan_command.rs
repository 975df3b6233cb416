//! `locotamp plan`: from a scene to a plan file and its summary.

use crate::arguments::PlanOptions;
use crate::failure::Failure;
use crate::folder::Folder;
use crate::progress::Progress;
use crate::{Exit, interrupt, output, result_json, result_text};
use locotamp::{Found, Outcome, Request};
use plan::{Plan, PlanError};
use scene::Scene;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

/// A run with everything that is said about it.
pub(crate) struct Finished {
    /// Name of the scene.
    pub scene: String,
    pub outcome: Outcome,
    /// The plan file, if there is one.
    pub path: Option<PathBuf>,
    /// What the checker says about the file.
    pub verdict: Option<Verdict>,
}

/// What the checker says about a plan, in one line.
pub(crate) struct Verdict {
    /// Categories that fail.
    pub failed: Vec<&'static str>,
    /// Categories that were judged.
    judged: usize,
}

impl Verdict {
    /// Judges a plan.
    pub fn of(plan: &Plan) -> Self {
        let report = check::check(plan, &check::Options::accept());
        let judged = report
            .rows
            .iter()
            .filter(|row| row.status != check::Status::NotApplicable)
            .count();
        Self {
            failed: report.failed().collect(),
            judged,
        }
    }

    /// True if nothing fails.
    pub fn ok(&self) -> bool {
        self.failed.is_empty()
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.ok() {
            write!(f, "accepted, {} categories within tolerance", self.judged)
        } else {
            write!(
                f,
                "rejected: {} (locotamp check --profile accept shows where)",
                self.failed.join(", ")
            )
        }
    }
}

/// A scene by built-in name or by path.
pub(crate) fn load(name: &str) -> Result<Scene, Failure> {
    let path = Path::new(name);
    let is_path = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"))
        || path.components().count() != 1
        || path.exists();
    let built_in = Scene::builtin_text(name).is_some();
    Ok(if is_path && !built_in {
        Scene::load(path)?
    } else {
        Scene::builtin(name)?
    })
}

/// Plans, writes, checks and tells.
pub(crate) fn run(options: &PlanOptions) -> Result<Exit, Failure> {
    let mut scene = load(&options.scene)?;
    if options.problem.no_torque_limits {
        scene.optimiser.torque_limits = false;
    }
    let folder = Folder::open(options.out.as_deref(), &scene.name)?;
    let finished =
        search(options, &scene).and_then(|outcome| finish(&scene, outcome, &folder.plan()));
    folder.remove_if_unused();
    let finished = finished?;
    if options.json {
        output::result(&format!("{}\n", result_json::write(&finished)));
    } else {
        output::result(&result_text::write(&finished));
    }
    if finished.path.is_none() && folder.plan().exists() {
        output::error(&format!(
            "note: {} is from an earlier run\n",
            folder.plan().display()
        ));
    }
    let accepted =
        finished.outcome.feasible && finished.verdict.is_some_and(|verdict| verdict.ok());
    Ok(if accepted { Exit::Done } else { Exit::Rejected })
}

fn search(options: &PlanOptions, scene: &Scene) -> Result<Outcome, Failure> {
    let request = Request {
        seed: options.seed,
        ..options.problem.request(options.time_limit)
    };
    let interrupted = interrupt::flag();
    let mut progress = Progress::new(options.quiet);
    let outcome = locotamp::plan(scene, &request, &mut |event| {
        progress.see(event);
        !interrupted.load(Ordering::SeqCst)
    });
    progress.finish();
    Ok(outcome?)
}

/// Writes the best plan, reads it back and has it judged.
fn finish(scene: &Scene, outcome: Outcome, path: &Path) -> Result<Finished, Failure> {
    let scene = scene.name.clone();
    let Some(Found { plan, .. }) = &outcome.best else {
        return Ok(Finished {
            scene,
            outcome,
            path: None,
            verdict: None,
        });
    };
    let verdict = judge(plan, path)?;
    Ok(Finished {
        scene,
        outcome,
        path: Some(path.into()),
        verdict: Some(verdict),
    })
}

/// Writes a plan, reads it back and has it judged.
pub(crate) fn judge(plan: &Plan, path: &Path) -> Result<Verdict, Failure> {
    let written =
        plan.write(path)
            .and_then(|()| Plan::read(path))
            .map_err(|error| match error {
                PlanError::Io { .. } => Failure::new(
                    Exit::BadInput,
                    format_args!("cannot write the plan: {error}"),
                ),
                _ => Failure::new(
                    Exit::Rejected,
                    format_args!("no plan: the motion found is no valid plan file: {error}"),
                ),
            })?;
    Ok(Verdict::of(&written))
}
