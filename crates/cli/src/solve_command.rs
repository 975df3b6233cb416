//! `locotamp solve`: one given contact sequence to a plan file and a report.

use crate::arguments::SolveOptions;
use crate::failure::Failure;
use crate::folder::Folder;
use crate::plan_command::{Verdict, judge, load, tell_notes};
use crate::progress::Progress;
use crate::{Exit, interrupt, output, plan_sequence, result_json, result_text};
use locotamp::{Request, Solved, Status, with_places_to_leave};
use scene::{Scene, Sequence};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// A solve with everything that is said about it.
pub(crate) struct Finished {
    /// Name of the scene.
    pub scene: String,
    /// Name of the sequence.
    pub sequence: String,
    pub solved: Solved,
    /// The plan file, if there is one.
    pub path: Option<PathBuf>,
    /// What the checker says about the motion.
    pub verdict: Option<Verdict>,
}

impl Finished {
    /// True if there is a plan and the checker accepts it.
    pub fn accepted(&self) -> bool {
        self.solved.feasible && self.verdict.as_ref().is_some_and(Verdict::ok)
    }
}

/// Solves, writes, checks and tells.
pub(crate) fn run(options: &SolveOptions) -> Result<Exit, Failure> {
    let mut scene = load(&options.scene)?;
    tell_notes(&scene, options.quiet)?;
    if options.problem.no_torque_limits {
        scene.optimiser.torque_limits = false;
    }
    if plan_sequence::is_plan(&options.sequence) {
        // The search names some surfaces twice.
        scene = with_places_to_leave(&scene).unwrap_or(scene);
    }
    let sequence = plan_sequence::load(&options.sequence, &scene)?;
    let folder = Folder::open(options.out.as_deref(), &scene.name)?;
    let finished = solve(options, &scene, &sequence, &folder);
    folder.remove_if_unused();
    let finished = finished?;
    if options.json {
        output::result(&format!("{}\n", report(&finished)));
    } else {
        output::result(&text(&finished, &folder.report()));
    }
    Ok(if finished.accepted() {
        Exit::Done
    } else {
        Exit::Rejected
    })
}

/// Solves and writes plan and report.
fn solve(
    options: &SolveOptions,
    scene: &Scene,
    sequence: &Sequence,
    folder: &Folder,
) -> Result<Finished, Failure> {
    let request = options.problem.request(options.time_limit);
    let mut progress = Progress::of_one_sequence(options.quiet);
    let solved = observed(scene, sequence, &request, &mut progress, &interrupt::flag());
    progress.finish();
    let finished = finish(scene, sequence, solved?, Some(&folder.plan()))?;
    let path = folder.report();
    let text = format!("{:#}\n", report(&finished));
    std::fs::write(&path, text).map_err(|error| Failure::path("write", &path, &error))?;
    if finished.path.is_none() && folder.plan().exists() {
        output::error(&format!(
            "note: {} is from an earlier run\n",
            folder.plan().display()
        ));
    }
    Ok(finished)
}

/// Solves with progress, until `interrupted`.
pub(crate) fn observed(
    scene: &Scene,
    sequence: &Sequence,
    request: &Request,
    progress: &mut Progress,
    interrupted: &AtomicBool,
) -> Result<Solved, Failure> {
    Ok(locotamp::solve(scene, sequence, request, &mut |event| {
        progress.see(event);
        !interrupted.load(Ordering::SeqCst)
    })?)
}

/// Writes the plan to `path`, if given, and has it judged.
pub(crate) fn finish(
    scene: &Scene,
    sequence: &Sequence,
    solved: Solved,
    path: Option<&Path>,
) -> Result<Finished, Failure> {
    let plan = solved.best.as_ref().map(|found| &found.plan);
    let verdict = match (plan, path) {
        (Some(plan), Some(path)) => Some(judge(plan, path)?),
        (Some(plan), None) => Some(Verdict::of(plan)),
        (None, _) => None,
    };
    Ok(Finished {
        scene: scene.name.clone(),
        sequence: sequence.name.clone(),
        path: path.filter(|_| plan.is_some()).map(Path::to_path_buf),
        verdict,
        solved,
    })
}

/// How the optimiser ended, in words.
pub(crate) fn words(status: Status) -> &'static str {
    match status {
        Status::Solved => "solved",
        Status::Acceptable => "nearly solved",
        Status::Enough => "good enough",
        Status::Stalled => "stalled",
        Status::IterationLimit => "iteration limit",
        Status::Interrupted => "interrupted",
        Status::Failed => "failed",
        Status::Contradictory => "contradictory bounds",
    }
}

/// The report as one JSON object. Times in seconds; `status` is "feasible", "infeasible" (there is a motion, but it violates
/// something) or "none" (no keyframes).
pub(crate) fn report(finished: &Finished) -> Value {
    let solved = &finished.solved;
    let keyframes = &solved.keyframes;
    let status = match (&solved.best, solved.feasible) {
        (Some(_), true) => "feasible",
        (Some(_), false) => "infeasible",
        (None, _) => "none",
    };
    json!({
        "status": status,
        "scene": finished.scene,
        "sequence": finished.sequence,
        "plan": finished.path.as_ref().map(|path| path.display().to_string()),
        "reason": solved.reason,
        "explanation": solved.explanation,
        "seconds": solved.seconds,
        "keyframes": {
            "possible": keyframes.possible,
            "iterations": keyframes.iterations,
            "seconds": keyframes.seconds,
        },
        "optimiser": solved.motion.as_ref().map(|motion| json!({
            "status": words(motion.status),
            "iterations": motion.iterations,
            "cost": motion.cost,
            "violation": motion.violation,
            "seconds": {
                "derivatives": motion.timing.linearise.as_secs_f64(),
                "assembly_and_factorisation": motion.timing.factorise.as_secs_f64(),
                "substitution": motion.timing.solve.as_secs_f64(),
                "line_search": motion.timing.evaluate.as_secs_f64(),
                "total": motion.timing.total.as_secs_f64(),
            },
        })),
        "check": finished.verdict.as_ref().map(|v| json!({ "ok": v.ok(), "failed": v.failed })),
        "summary": solved.best.as_ref().map(|found| result_json::summary(&found.summary)),
        "refinement": solved.best.as_ref().map(|found| result_json::refinement(&found.refined)),
        "quality": solved.best.as_ref().map(|found| &found.quality),
    })
}

/// The result for people, ending with a line break.
fn text(finished: &Finished, report: &Path) -> String {
    let solved = &finished.solved;
    let title = format!("{}, {}", finished.scene, finished.sequence);
    let mut text = match &solved.best {
        Some(found) => {
            let kind = result_text::kind(solved.feasible, finished.verdict.as_ref());
            result_text::motion(&title, kind, found)
        }
        None => format!("{title}: no plan, there are no keyframes\n"),
    };
    if let Some(motion) = &solved.motion {
        let timing = &motion.timing;
        let share = |part: std::time::Duration| {
            100.0 * part.as_secs_f64() / timing.total.as_secs_f64().max(f64::MIN_POSITIVE)
        };
        let _ = writeln!(
            text,
            "                   {}; derivatives {:.0} %, factorisation {:.0} %, substitution {:.0} %, line search {:.0} %",
            words(motion.status),
            share(timing.linearise),
            share(timing.factorise),
            share(timing.solve),
            share(timing.evaluate),
        );
    }
    let keyframes = &solved.keyframes;
    let possible = if keyframes.possible { "found" } else { "none" };
    let _ = writeln!(
        text,
        "keyframes          {possible}, {:.1} s",
        keyframes.seconds
    );
    if let Some(path) = &finished.path {
        let _ = writeln!(text, "plan file          {}", path.display());
    }
    let _ = writeln!(text, "report             {}", report.display());
    if let Some(verdict) = &finished.verdict {
        let _ = writeln!(text, "checker            {verdict}");
    }
    if let Some(reason) = &solved.reason {
        let stage = if keyframes.possible {
            "motion"
        } else {
            "keyframes"
        };
        let _ = writeln!(text, "\nno {stage}: {reason}");
    }
    if let Some(explanation) = &solved.explanation {
        let _ = write!(text, "\n{}", explanation.text);
    }
    text
}
