//! The result of a run for people.

use crate::counts::Counts;
use crate::plan_command::{Finished, Verdict};
use crate::reasons;
use locotamp::{Found, Outcome, Quality, Refined, Summary};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Reasons that are listed when there is no plan.
const MOST_REASONS: usize = 5;

/// The short summary, ending with a line break.
pub(crate) fn write(finished: &Finished) -> String {
    let outcome = &finished.outcome;
    let mut text = String::new();
    if let Some(found) = &outcome.best {
        let kind = kind(outcome.feasible, finished.verdict.as_ref());
        text += &motion(&finished.scene, kind, found);
    } else {
        let _ = writeln!(text, "{}: no plan", finished.scene);
    }
    let tried: Counts = outcome.attempts.iter().map(|x| x.reached).collect();
    let _ = writeln!(
        text,
        "search             {tried} in {:.1} s; {}",
        outcome.seconds, outcome.ended
    );
    if let Some(first) = outcome.first_after {
        let _ = writeln!(text, "first plan         after {first:.1} s");
    }
    text += &alternatives(finished);
    if let Some(path) = &finished.path {
        let _ = writeln!(text, "plan file          {}", path.display());
        let page = path.with_file_name("search.html");
        let _ = writeln!(text, "search page        {}", page.display());
    }
    if let Some(verdict) = &finished.verdict {
        let _ = writeln!(text, "checker            {verdict}");
    }
    if !outcome.feasible {
        text += &explanation(outcome);
    }
    text
}

/// The plans that differ in their loaded contacts, before refinement.
fn alternatives(finished: &Finished) -> String {
    let mut text = String::new();
    if finished.rows.len() < 2 {
        return text;
    }
    let gets = finished.rows[0].gets.as_ref();
    let what = gets.map_or_else(String::new, |(name, _)| format!("  {name}"));
    let _ = writeln!(
        text,
        "\n  plan  duration     cost{what}  torque margin  slip       loaded phases  contacts made"
    );
    for row in &finished.rows {
        let gets = row.gets.as_ref();
        let gets = gets.map_or_else(String::new, |(name, value)| {
            format!("  {value:width$.2} m", width = name.len() - 2)
        });
        let _ = writeln!(
            text,
            "  {:04}  {:6.2} s {:8.3}{gets}  {:10.0} %  {:7.1e} m  {:13}  {}{}",
            row.number,
            row.duration,
            row.cost,
            100.0 * row.torque_margin,
            row.slip,
            row.loaded,
            row.contacts,
            if row.verdict.ok() {
                ""
            } else {
                " (rejected by the checker)"
            },
        );
    }
    text.push('\n');
    text
}

/// What a motion is, with what the checker says about it.
pub(crate) fn kind(feasible: bool, verdict: Option<&Verdict>) -> &'static str {
    match verdict {
        _ if !feasible => "no feasible plan; the best attempt",
        Some(verdict) if !verdict.ok() => "a plan that the checker rejects",
        _ => "a feasible plan",
    }
}

/// Heading, phases and figures of a motion of this [`kind`].
pub(crate) fn motion(title: &str, kind: &str, found: &Found) -> String {
    let summary = &found.summary;
    heading(title, kind, summary)
        + &phases(summary)
        + &figures(summary)
        + &refinement(&found.refined)
        + &quality(&found.quality)
}

/// What became of the finer grid, if one was asked for.
fn refinement(refined: &Refined) -> String {
    match refined {
        Refined::No => String::new(),
        Refined::Done {
            coarse_intervals,
            iterations,
            seconds,
        } => format!(
            "refinement         from {coarse_intervals} intervals, {iterations} iterations, {seconds:.1} s\n"
        ),
        Refined::Failed(reason) => {
            format!("refinement         failed, the plan is a coarser motion: {reason}\n")
        }
    }
}

/// Smoothness, residuals between the nodes and margins.
fn quality(quality: &Quality) -> String {
    let residuals = &quality.between_nodes;
    let mut text = format!(
        "smoothness         joint jerk {:.0} rad/s³ rms, torque rate at most {:.0} N m/s ({}), force rate {:.0} N/s ({})\n\
         between nodes      at most {:.1} N and {:.2} N m missing at the base, torque {:.0} % of the limit\n",
        quality.rms_joint_jerk,
        quality.torque_rate.value,
        quality.torque_rate.of,
        quality.force_rate.value,
        quality.force_rate.of,
        residuals.base_force,
        residuals.base_moment,
        100.0 * residuals.torque_share,
    );
    let margins: Vec<String> = quality
        .margins
        .iter()
        .filter_map(|margin| {
            let reached = margin.reached?;
            Some(match margin.unit {
                "1" => format!("{} {:.0} %", margin.name, 100.0 * reached),
                unit => format!("{} {reached:.3} {unit}", margin.name.replace('_', " ")),
            })
        })
        .collect();
    let _ = writeln!(text, "limits used        {}", margins.join(", "));
    text
}

fn heading(scene: &str, kind: &str, summary: &Summary) -> String {
    let (phases, intervals) = (summary.phases.len(), summary.intervals);
    let plural = if phases == 1 { "" } else { "s" };
    format!(
        "{scene}: {kind}, {phases} phase{plural}, {intervals} intervals, {:.2} s\n\n",
        summary.duration
    )
}

/// One line per phase: duration, what changes on entering it, the contacts gained and lost.
fn phases(summary: &Summary) -> String {
    let mut text = "  phase  duration  on entering\n".to_owned();
    let width = summary
        .phases
        .iter()
        .map(|phase| phase.action.chars().count())
        .max()
        .unwrap_or(0);
    let mut before: Option<BTreeSet<&str>> = None;
    for (number, phase) in (1..).zip(&summary.phases) {
        let contacts: BTreeSet<&str> = phase.contacts.iter().map(String::as_str).collect();
        let changes = match &before {
            None => contacts.iter().copied().collect::<Vec<_>>().join(", "),
            Some(before) => changes(before, &contacts),
        };
        let line = format!(
            "  {number:5}  {:6.2} s  {:width$}  {changes}",
            phase.duration, phase.action
        );
        let _ = writeln!(text, "{}", line.trim_end());
        before = Some(contacts);
    }
    text + "\n"
}

/// Contacts gained (+) and lost (-).
fn changes(before: &BTreeSet<&str>, after: &BTreeSet<&str>) -> String {
    let gained = after
        .difference(before)
        .map(|contact| format!("+ {contact}"));
    let lost = before
        .difference(after)
        .map(|contact| format!("- {contact}"));
    gained.chain(lost).collect::<Vec<_>>().join(", ")
}

fn figures(summary: &Summary) -> String {
    let (ratio, joint, time) = &summary.torque;
    let Summary {
        violation,
        cost,
        iterations,
        seconds,
        ..
    } = summary;
    let torque = if joint.is_empty() {
        "no joint has a limit that counts".to_owned()
    } else {
        format!(
            "{:.0} % of the limit, {joint} at {time:.2} s",
            ratio * 100.0
        )
    };
    format!(
        "largest violation  {violation}\nlargest torque     {torque}\noptimiser          {iterations} iterations, {seconds:.1} s, cost \
         {cost:.3}\n"
    )
}

/// Why there is no plan.
fn explanation(outcome: &Outcome) -> String {
    let reasons = reasons::most_frequent(&outcome.attempts, &outcome.impossible);
    let mut text = String::new();
    if reasons.is_empty() {
        return text;
    }
    text += "\nmost frequent reasons\n";
    for reason in reasons.iter().take(MOST_REASONS) {
        let _ = writeln!(
            text,
            "{:6} × {}: {}",
            reason.count, reason.stage, reason.example
        );
    }
    if reasons.len() > MOST_REASONS {
        let _ = writeln!(
            text,
            "         and {} more (--json lists all)",
            reasons.len() - MOST_REASONS
        );
    }
    if let Some(remedy) = reasons::remedy(&outcome.attempts, &outcome.impossible) {
        let _ = writeln!(text, "{remedy}");
    }
    for possible in &outcome.possible {
        let (contacts, remedy) = (possible.contacts.join(" with "), &possible.remedy);
        let _ = writeln!(
            text,
            "\nno configuration has {contacts}\nwould do     {} [{}]",
            remedy.text, remedy.key
        );
    }
    if let Some(explained) = &outcome.explained {
        let actions = explained.labels[1..].join(" | ");
        let _ = writeln!(
            text,
            "\nfor example: {actions}\n{}",
            explained.explanation.text.trim_end()
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use locotamp::PhaseSummary;

    fn summary() -> Summary {
        let phase = |action: &str, contacts: &[&str]| PhaseSummary {
            action: action.into(),
            duration: 0.5,
            contacts: contacts.iter().map(|&c| c.to_owned()).collect(),
        };
        Summary {
            phases: vec![
                phase("start", &["left_foot on ground_top"]),
                phase("step", &["right_foot on ground_top"]),
            ],
            duration: 1.0,
            intervals: 20,
            cost: 2.0,
            iterations: 30,
            seconds: 1.5,
            violation: "none".into(),
            torque: (0.834, "left_knee_joint".into(), 0.4),
        }
    }

    #[test]
    fn phases_show_the_contacts_that_change() {
        let text = phases(&summary());
        assert!(
            text.contains("1    0.50 s  start  left_foot on ground_top"),
            "{text}"
        );
        assert!(
            text.contains(
                "2    0.50 s  step   + right_foot on ground_top, - left_foot on ground_top"
            ),
            "{text}"
        );
    }

    #[test]
    fn the_largest_torque_is_a_share_of_its_limit() {
        let text = figures(&summary());
        assert!(
            text.contains("83 % of the limit, left_knee_joint at 0.40 s"),
            "{text}"
        );
    }
}
