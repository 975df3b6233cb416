//! The table of `locotamp bench` for people.

use crate::bench_command::Row;
use scene::Expectation;
use std::fmt::Write;
use std::time::Duration;

/// Longest reason that is shown.
const LONGEST_REASON: usize = 90;

/// One line per sequence and a last one with the counts. Times per iteration in milliseconds.
pub(crate) fn write(rows: &[Row]) -> String {
    let width = rows
        .iter()
        .map(|row| row.name.chars().count())
        .max()
        .unwrap_or(0);
    let mut text = format!(
        "  {:width$}  size    expected    outcome      it   ms/it  deriv  factor  subst  search   total s  violation     cost  MiB  \
         checker, reason\n",
        "sequence"
    );
    for row in rows {
        let mark = if row.as_expected() { ' ' } else { '!' };
        let (phases, intervals) = row.size;
        let size = format!("{phases}/{intervals}");
        let _ = write!(
            text,
            "{mark} {:width$}  {size:6}  {:10}  {:10}",
            row.name,
            expected(row),
            outcome(row)
        );
        text += &figures(row);
        let memory = row
            .memory
            .map_or_else(|| "?".into(), |memory| format!("{memory:.0}"));
        let _ = writeln!(text, "  {memory:>3}  {}", remarks(row));
    }
    text + &counts(rows)
}

fn expected(row: &Row) -> &'static str {
    match row.expect {
        Some(Expectation::Feasible) => "feasible",
        Some(Expectation::Infeasible { .. }) => "infeasible",
        None => "-",
    }
}

fn outcome(row: &Row) -> &'static str {
    let solved = &row.finished.solved;
    match (solved.feasible, solved.keyframes.possible) {
        (true, _) => "solved",
        (false, true) => "no motion",
        (false, false) => "no keyframes",
    }
}

/// Iterations, times, violation, cost.
fn figures(row: &Row) -> String {
    let solved = &row.finished.solved;
    let Some(motion) = &solved.motion else {
        let seconds = solved.seconds;
        return format!(
            "  {:>4}  {:>6}  {:>5}  {:>6}  {:>5}  {:>6}  {seconds:8.1}  {:>9}  {:>7}",
            "-", "-", "-", "-", "-", "-", "-", "-"
        );
    };
    let timing = &motion.timing;
    let each = |part: Duration| 1e3 * part.as_secs_f64() / motion.iterations.max(1) as f64;
    format!(
        "  {:4}  {:6.1}  {:5.1}  {:6.1}  {:5.1}  {:6.1}  {:8.1}  {:9.1e}  {:7.3}",
        motion.iterations,
        each(timing.total),
        each(timing.linearise),
        each(timing.factorise),
        each(timing.solve),
        each(timing.evaluate),
        solved.seconds,
        motion.violation,
        motion.cost,
    )
}

/// What the checker says about a plan, or why there is none.
fn remarks(row: &Row) -> String {
    let solved = &row.finished.solved;
    let reason = solved.reason.as_deref().unwrap_or_default();
    let reason: String = reason.chars().take(LONGEST_REASON).collect();
    match &row.finished.verdict {
        Some(verdict) if solved.feasible && verdict.ok() => "accepted".into(),
        Some(verdict) if solved.feasible => format!("rejected: {}", verdict.failed.join(", ")),
        _ => reason,
    }
}

fn counts(rows: &[Row]) -> String {
    let count = |test: &dyn Fn(&Row) -> bool| rows.iter().filter(|row| test(row)).count();
    let feasible = |row: &Row| row.expect == Some(Expectation::Feasible);
    let infeasible = |row: &Row| matches!(row.expect, Some(Expectation::Infeasible { .. }));
    let seconds: f64 = rows.iter().map(|row| row.finished.solved.seconds).sum();
    format!(
        "\n{} of {} feasible ones solved and accepted, {} of {} infeasible ones without a plan, {seconds:.0} s\n",
        count(&|row| feasible(row) && row.as_expected()),
        count(&feasible),
        count(&|row| infeasible(row) && row.as_expected()),
        count(&infeasible),
    )
}
