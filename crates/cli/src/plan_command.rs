//! `locotamp plan`: from a scene to a plan file and its summary.

use crate::arguments::PlanOptions;
use crate::failure::Failure;
use crate::folder::Folder;
use crate::progress::Progress;
use crate::{Exit, interrupt, output, result_json, result_text, watch_command};
use locotamp::{Alternative, Event, Found, Outcome, Request, Stop};
use plan::{Plan, PlanError};
use scene::Scene;
use std::fmt;
use std::path::{Path, PathBuf};

/// A run with everything that is said about it.
pub(crate) struct Finished {
    /// Name of the scene.
    pub scene: String,
    pub outcome: Outcome,
    /// The plan file, if there is one.
    pub path: Option<PathBuf>,
    /// What the checker says about the file.
    pub verdict: Option<Verdict>,
    /// The best plans that differ in their loaded contacts.
    pub rows: Vec<Row>,
}

/// A plan in the table of alternatives.
pub(crate) struct Row {
    /// Number of its sequence, by which its file is called.
    pub number: usize,
    /// Duration [s].
    pub duration: f64,
    /// Cost of the optimiser.
    pub cost: f64,
    /// What the scene's objective gets, with its name, but for time: height of the base, reach [m].
    pub gets: Option<(String, f64)>,
    /// Share of the torque limits that is not used.
    pub torque_margin: f64,
    /// Largest slip of a contact [m].
    pub slip: f64,
    /// Phases with different loaded contacts.
    pub loaded: usize,
    /// Skeleton and swings in short.
    pub contacts: String,
    pub verdict: Verdict,
}

impl Row {
    fn of(alternative: &Alternative) -> Self {
        let plan = &alternative.plan;
        let report = check::check(plan, &check::Options::accept());
        let slip = report.row("slip_phase").and_then(|row| row.value);
        let limits = plan.robot.torque_limits.as_deref().unwrap_or_default();
        let ratio = |(torque, limit): (&f64, &Option<f64>)| limit.map_or(0.0, |l| torque.abs() / l);
        let ratios = plan
            .tau
            .iter()
            .flat_map(|row| row.iter().zip(limits).map(ratio));
        let objective = plan.objective.as_ref().filter(|o| o.name != "time");
        Self {
            gets: objective.map(|o| (o.name.clone(), o.value)),
            number: alternative.number,
            duration: alternative.duration,
            cost: alternative.cost,
            torque_margin: 1.0 - ratios.fold(0.0, f64::max),
            slip: 1e-3 * slip.unwrap_or(0.0), // the checker speaks of millimetres
            loaded: alternative.loaded.len(),
            contacts: story(&alternative.loaded),
            verdict: Verdict::from(&report),
        }
    }
}

/// The contacts that objects and hands gain, in order.
fn story(loaded: &[Vec<String>]) -> String {
    let mut gained = vec![];
    for pair in loaded.windows(2) {
        let new = pair[1].iter().filter(|c| !pair[0].contains(c));
        gained.extend(new.cloned());
    }
    gained.join(", ")
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
        Self::from(&check::check(plan, &check::Options::accept()))
    }

    fn from(report: &check::Report) -> Self {
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

/// Says what is unusual in a scene.
pub(crate) fn tell_notes(scene: &Scene, quiet: bool) -> Result<(), Failure> {
    if !quiet {
        for note in scene.notes().into_iter().chain(locotamp::home_note(scene)?) {
            output::error(&format!("note: {note}\n"));
        }
    }
    Ok(())
}

/// Plans, writes, checks and tells.
pub(crate) fn run(options: &PlanOptions) -> Result<Exit, Failure> {
    let mut scene = load(&options.scene)?;
    tell_notes(&scene, options.quiet)?;
    if options.problem.no_torque_limits {
        scene.optimiser.torque_limits = false;
    }
    let folder = Folder::open(options.out.as_deref(), &scene.name)?;
    let finished =
        search(options, &scene, &folder).and_then(|outcome| finish(&scene, outcome, &folder));
    folder.remove_if_unused();
    let finished = finished?;
    if options.json {
        output::result(&format!("{}\n", result_json::write(&finished)));
    } else {
        output::result(&result_text::write(&finished));
        output::result(&advice(options, &finished));
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

/// What tells why there is no plan.
fn advice(options: &PlanOptions, finished: &Finished) -> String {
    match &finished.path {
        Some(path) if !finished.outcome.feasible => format!(
            "\nThe plan file holds the sequence that came nearest to a motion. What would give it one (this can take minutes):\n    \
             locotamp solve {} --sequence {}\n",
            options.scene,
            path.display()
        ),
        _ => String::new(),
    }
}

fn search(options: &PlanOptions, scene: &Scene, folder: &Folder) -> Result<Outcome, Failure> {
    if options.search.resume && !options.quiet && !folder.journal().exists() {
        output::error(&format!(
            "note: nothing to resume, there is no {}: the search begins anew\n",
            folder.journal().display()
        ));
    }
    let interrupted = interrupt::flag();
    let request = Request {
        seed: options.seed,
        search: options.search.search.into(),
        solutions: options.search.solutions,
        min_optimised: options.search.min_sequences,
        max_optimised: options.search.max_sequences,
        journal: Some(folder.journal()),
        resume: options.search.resume,
        stop: Stop(interrupted),
        ..options.problem.request(options.time_limit)
    };
    let mut progress = Progress::new(options.quiet);
    let (mut failure, mut served) = (None, !options.live);
    let outcome = locotamp::plan(scene, &request, &mut |event| {
        progress.see(event);
        if !served {
            // The journal exists from the first event on.
            served = true;
            match watch_command::beside(folder.path()) {
                Ok(address) => output::error(&format!("the search as a page: {address}\n")),
                Err(error) => failure = Some(error),
            }
        }
        if let Event::Solution { number, best, plan } = event {
            failure = failure
                .take()
                .or(solution(folder, *number, *best, plan).err());
        }
        failure.is_none()
    });
    progress.finish();
    if let Some(failure) = failure {
        return Err(failure);
    }
    let outcome = outcome?;
    let page = view::Run::open(folder.path()).and_then(|run| run.page(false));
    let page = page.map_err(|error| Failure::new(Exit::BadInput, error))?;
    let path = folder.page();
    std::fs::write(&path, page).map_err(|error| Failure::path("write", &path, &error))?;
    Ok(outcome)
}

/// Writes a plan of the search as soon as it is there; the best one also as the plan of the run.
fn solution(folder: &Folder, number: usize, best: bool, plan: &Plan) -> Result<(), Failure> {
    let path = folder.solution(number);
    if let Some(parent) = path.parent() {
        std::fs::create_dir_all(parent)
            .map_err(|error| Failure::path("make the folder", parent, &error))?;
    }
    let targets = [Some(path), best.then(|| folder.plan())];
    for path in targets.into_iter().flatten() {
        plan.write(&path).map_err(|error| {
            Failure::new(
                Exit::BadInput,
                format_args!("cannot write the plan: {error}"),
            )
        })?;
    }
    Ok(())
}

/// Writes the best plan, reads it back and has it judged; judges its alternatives.
fn finish(scene: &Scene, outcome: Outcome, folder: &Folder) -> Result<Finished, Failure> {
    let rows = outcome.alternatives.iter().map(Row::of).collect();
    let path = folder.plan();
    let mut finished = Finished {
        scene: scene.name.clone(),
        outcome,
        path: None,
        verdict: None,
        rows,
    };
    if let Some(Found { plan, .. }) = &finished.outcome.best {
        finished.verdict = Some(judge(plan, &path)?);
        finished.path = Some(path);
    }
    Ok(finished)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result_text::kind;

    #[test]
    fn a_plan_that_the_checker_rejects_is_not_called_feasible() {
        let verdict = |failed: &[&'static str]| Verdict {
            failed: failed.to_vec(),
            judged: 40,
        };
        assert_eq!(kind(true, Some(&verdict(&[]))), "a feasible plan");
        let rejected = kind(true, Some(&verdict(&["torque"])));
        assert_eq!(rejected, "a plan that the checker rejects");
        assert!(kind(false, None).starts_with("no feasible plan"));
    }
}
