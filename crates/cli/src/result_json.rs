//! The result of a run for machines.

use crate::plan_command::Finished;
use crate::reasons;
use locotamp::{Attempt, Reached, Refined, Summary};
use serde_json::{Value, json};

/// One JSON object. Times in seconds; `status` is "feasible", "infeasible" (there is a best attempt) or "none".
pub(crate) fn write(finished: &Finished) -> Value {
    let outcome = &finished.outcome;
    let status = match (&outcome.best, outcome.feasible) {
        (Some(_), true) => "feasible",
        (Some(_), false) => "infeasible",
        (None, _) => "none",
    };
    let reasons = reasons::most_frequent(&outcome.attempts, &outcome.impossible);
    json!({
        "status": status,
        "scene": finished.scene,
        "plan": finished.path.as_ref().map(|path| path.display().to_string()),
        "ended": outcome.ended,
        "seconds": outcome.seconds,
        "summary": outcome.best.as_ref().map(|found| summary(&found.summary)),
        "refinement": outcome.best.as_ref().map(|found| refinement(&found.refined)),
        "quality": outcome.best.as_ref().map(|found| &found.quality),
        "check": finished.verdict.as_ref().map(|v| json!({ "ok": v.ok(), "failed": v.failed })),
        "first_plan_after": outcome.first_after,
        "alternatives": finished.rows.iter().map(|row| json!({
            "plan": row.number, "duration": row.duration, "cost": row.cost, "torque_margin": row.torque_margin,
            "slip": row.slip, "loaded_phases": row.loaded, "contacts": row.contacts, "accepted": row.verdict.ok(),
            "objective": row.gets.as_ref().map(|(_, value)| value),
        })).collect::<Vec<_>>(),
        "reasons": reasons.iter().map(|r| json!({
            "count": r.count, "stage": r.stage, "what": r.what, "example": r.example,
        })).collect::<Vec<_>>(),
        "remedy": reasons::remedy(&outcome.attempts, &outcome.impossible),
        "possible": outcome.possible.iter().map(|p| json!({
            "contacts": p.contacts, "remedy": p.remedy,
        })).collect::<Vec<_>>(),
        "explained": outcome.explained.as_ref().map(|e| json!({
            "labels": e.labels, "explanation": e.explanation,
        })),
        "attempts": outcome.attempts.iter().map(attempt).collect::<Vec<_>>(),
    })
}

/// A motion in figures.
pub(crate) fn summary(summary: &Summary) -> Value {
    let (ratio, joint, time) = &summary.torque;
    json!({
        "phases": summary.phases.iter().map(|phase| json!({
            "action": phase.action, "duration": phase.duration, "contacts": phase.contacts,
        })).collect::<Vec<_>>(),
        "duration": summary.duration,
        "intervals": summary.intervals,
        "cost": summary.cost,
        "iterations": summary.iterations,
        "optimiser_seconds": summary.seconds,
        "largest_violation": summary.violation,
        "largest_torque": { "ratio": ratio, "joint": joint, "time": time },
    })
}

/// What became of the finer grid; null if none was asked for.
pub(crate) fn refinement(refined: &Refined) -> Value {
    match refined {
        Refined::No => Value::Null,
        Refined::Done {
            coarse_intervals,
            iterations,
            seconds,
        } => json!({
            "done": true, "coarse_intervals": coarse_intervals, "iterations": iterations, "seconds": seconds,
        }),
        Refined::Failed(reason) => json!({ "done": false, "reason": reason }),
    }
}

fn attempt(attempt: &Attempt) -> Value {
    let reached = match attempt.reached {
        Reached::Keyframes => "keyframes",
        Reached::Alike => "alike",
        Reached::Coarse => "coarse",
        Reached::Optimised => "optimised",
        Reached::Feasible => "feasible",
    };
    json!({
        "number": attempt.number,
        "labels": attempt.labels,
        "reached": reached,
        "reason": attempt.reason,
        "cost": attempt.cost,
        "iterations": attempt.iterations,
        "seconds": attempt.seconds,
    })
}
