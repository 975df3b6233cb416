//! The tables in Markdown, from the record alone.

use crate::numbers::{median, number, numbers, share};
use crate::record::{Effort, Record};
use crate::rows::{climb, different, perturbed, scenes_in_short, two_box};
use crate::runs::{Group, Part};
use std::fmt::Write;

/// The runs of one group, in the order of their seeds and variants.
pub struct Runs<'a> {
    pub group: &'a Group,
    pub records: Vec<&'a Record>,
}

impl Runs<'_> {
    /// A number of each run in turn.
    pub fn each(&self, value: impl Fn(&Record) -> Option<f64>) -> Vec<Option<f64>> {
        self.records.iter().map(|record| value(record)).collect()
    }

    pub fn count(&self, is: impl Fn(&Record) -> bool) -> usize {
        self.records.iter().filter(|record| is(record)).count()
    }

    /// Runs of a scene that was a problem at all.
    pub fn valid(&self) -> usize {
        self.count(|record| !record.left_out)
    }

    pub fn limit(&self) -> String {
        format!("limit {} s", self.group.time_limit)
    }
}

/// One line about a run that ended.
pub fn line(record: &Record) -> String {
    let effort = &record.search;
    let first = number(record.first().map(|first| first.seconds));
    let verdict = match &record.returned {
        _ if record.accepted() => "accepted".to_owned(),
        Some(returned) if returned.feasible => {
            format!("rejected: {}", returned.judged.verdict.failed.join(", "))
        }
        _ => "no plan".to_owned(),
    };
    let ended = record.error.as_ref().unwrap_or(&record.ended);
    format!(
        "{:.0} s: {ended}; {} drawn, {} optimised, {} iterations; {} plans, the first after {first} s; {verdict}",
        record.seconds,
        effort.drawn,
        effort.optimised,
        effort.iterations,
        record.solutions.len()
    )
}

/// All tables.
pub fn write(records: &[Record]) -> String {
    let groups = groups(records);
    let of = |part| groups.iter().filter(move |runs| runs.group.part == part);
    let mut text = String::from(
        "## Numbers to reach\n\nMedian of the seeds, then each in turn; – is none within the limit.\n\n\
         | | paper | to reach | here |\n|---|---|---|---|\n",
    );
    of(Part::TwoBox).for_each(|runs| two_box(&mut text, runs));
    of(Part::Climb).for_each(|runs| climb(&mut text, runs));
    of(Part::Diverse).for_each(|runs| different(&mut text, runs));
    of(Part::Climb).for_each(|runs| different(&mut text, runs));
    scenes_in_short(&mut text, &of(Part::Scenes).collect::<Vec<_>>());
    of(Part::Perturbed).for_each(|runs| perturbed(&mut text, runs));
    section(
        &mut text,
        "Scenes, each until the first plan",
        "scene | solved | accepted | first plan [s] | optimised until then | else",
        of(Part::Scenes),
        scene,
    );
    section(
        &mut text,
        "Ways to choose sequences",
        " | plans | different | first plan [s] | optimised until then | optimised",
        of(Part::Policies),
        policy,
    );
    section(
        &mut text,
        "Effort",
        "medians until the search ends, without refinement | runs | threads | time [s] | processor [s] | drawn | optimised | \
         iterations for these | all iterations | processor per iteration [ms]",
        groups.iter(),
        effort,
    );
    text
}

/// A table with a row for each group, unless there is none.
fn section<'a>(
    text: &mut String,
    title: &str,
    head: &str,
    groups: impl Iterator<Item = &'a Runs<'a>>,
    write_row: fn(&mut String, &Runs<'_>),
) {
    let mut groups = groups.peekable();
    if groups.peek().is_some() {
        let line = "---|".repeat(head.split(" | ").count());
        let _ = write!(text, "\n## {title}\n\n| {head} |\n|{line}\n");
    }
    for runs in groups {
        write_row(text, runs);
    }
}

/// The records by group: parts in their order, and what belongs together beside each other.
fn groups(records: &[Record]) -> Vec<Runs<'_>> {
    let mut groups: Vec<Runs<'_>> = Vec::new();
    for record in records {
        let group = &record.run.group;
        match groups.iter_mut().find(|runs| runs.group == group) {
            Some(runs) => runs.records.push(record),
            None => groups.push(Runs {
                group,
                records: vec![record],
            }),
        }
    }
    for runs in &mut groups {
        let order = |record: &&Record| (record.run.seed, record.run.variant);
        runs.records.sort_by_key(order);
    }
    groups.sort_by_key(|runs| (runs.group.part, runs.group.policy)); // stable
    groups
}

/// A row of a table.
pub fn row(text: &mut String, cells: &[&str]) {
    let _ = writeln!(text, "| {} |", cells.join(" | "));
}

fn scene(text: &mut String, runs: &Runs<'_>) {
    let all = runs.records.len();
    let first = |value: fn(Effort) -> f64| runs.each(|r| r.first().map(value));
    let mut other: Vec<String> = Vec::new();
    for record in runs.records.iter().filter(|r| !r.accepted()) {
        let failed = record
            .returned
            .as_ref()
            .filter(|returned| returned.feasible)
            .map(|returned| returned.judged.verdict.failed.join(", "));
        let why = failed.or_else(|| record.error.clone());
        let why = why.unwrap_or_else(|| record.ended.clone());
        if !other.contains(&why) {
            other.push(why);
        }
    }
    row(
        text,
        &[
            &format!("{} ({})", runs.group.scene, runs.limit()),
            &share(runs.count(|r| r.first().is_some()), all),
            &share(runs.count(Record::accepted), all),
            &numbers(&first(|effort| effort.seconds)),
            &numbers(&first(|effort| effort.optimised as f64)),
            &other.join("; ").replace('|', "/"),
        ],
    );
}

fn policy(text: &mut String, runs: &Runs<'_>) {
    let group = runs.group;
    let first = |value: fn(Effort) -> f64| runs.each(|r| r.first().map(value));
    row(
        text,
        &[
            &format!(
                "{}, {} ({})",
                group.scene,
                group.policy.name(),
                runs.limit()
            ),
            &numbers(&runs.each(|r| Some(r.solutions.len() as f64))),
            &numbers(&runs.each(|r| Some(r.different().count() as f64))),
            &numbers(&first(|effort| effort.seconds)),
            &numbers(&first(|effort| effort.optimised as f64)),
            &numbers(&runs.each(|r| Some(r.search.optimised as f64))),
        ],
    );
}

fn effort(text: &mut String, runs: &Runs<'_>) {
    let middle = |value: fn(&Record) -> f64| {
        let valid = runs.records.iter().filter(|record| !record.left_out);
        let values: Vec<_> = valid.map(|record| Some(value(record))).collect();
        number(median(&values))
    };
    let mut threads: Vec<_> = runs.records.iter().map(|r| r.threads).collect();
    threads.sort_unstable();
    threads.dedup();
    let threads: Vec<String> = threads.iter().map(ToString::to_string).collect();
    row(
        text,
        &[
            &runs.group.name(),
            &runs.valid().to_string(),
            &threads.join(", "),
            &middle(|r| r.search.seconds),
            &middle(|r| r.search.processor_seconds),
            &middle(|r| r.search.drawn as f64),
            &middle(|r| r.search.optimised as f64),
            &middle(|r| r.search.iterations as f64),
            &middle(|r| r.search.seen as f64),
            &middle(|r| 1e3 * r.search.processor_seconds / r.search.seen as f64),
        ],
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::{EVALUATED, Until};
    use crate::samples::{of, record};

    /// The row that begins so, without its last separator.
    fn row_of(table: &str, begin: &str) -> String {
        let line = table.lines().find(|line| line.starts_with(begin));
        line.unwrap_or_else(|| panic!("no row {begin:?} in\n{table}"))
            .to_owned()
    }

    #[test]
    fn the_first_plan_of_two_box_has_its_two_rows() {
        // Not in the order of the seeds, as a record may be.
        let records = [
            record(3, None),
            record(1, Some(20.5)),
            record(2, Some(18.25)),
        ];
        let table = write(&records);
        let optimised = row_of(&table, "| two-box: full optimisations");
        assert!(
            optimised.ends_with("| **2** (1, 2, –); begun: **4** (4, 4, –) |"),
            "{optimised}"
        );
        let time = row_of(&table, "| two-box: time to the first");
        assert!(
            time.ends_with("| **20.5** s (20.5, 18.2, –); accepted: 1 of 3 |"),
            "{time}"
        );
        let effort = row_of(&table, "| two-box: two-box, tree");
        assert!(
            effort.ends_with("| 3 | 2 | 10 | 20 | 8 | 2 | 100 | 200 | 100 |"),
            "{effort}"
        );
    }

    #[test]
    fn what_was_not_evaluated_in_full_is_said() {
        let mut whole = of(Part::TwoBox, Until::Limits, 1, Some(1.0));
        whole.search.optimised = EVALUATED;
        let table = write(&[whole, of(Part::TwoBox, Until::Limits, 2, None)]);
        let row = row_of(&table, "| two-box: 200 evaluated");
        assert!(
            row.ends_with("| **–** s (10, –); seed 2: 2 in 10 s |"),
            "{row}"
        );
    }

    #[test]
    fn a_climb_counts_only_over_the_box() {
        let records: Vec<Record> = [Some(5.0), Some(6.0), Some(7.0)]
            .into_iter()
            .zip(1..)
            .map(|(first, seed)| of(Part::Climb, Until::Limits, seed, first))
            .collect();
        let table = write(&records);
        let row = row_of(&table, "| climb: both feet");
        assert!(
            row.contains("| 2 of 3; **7** s (–, 6, 7); returned, refined if possible and accepted: 1 of 3; onto the platform in any way: 3 of 3 |"),
            "{row}"
        );
        let row = row_of(&table, "| climb: plans with different");
        assert!(
            row.contains("**1** (1, 1, 1); accepted before refinement: **0** (0, 0, 0)"),
            "{row}"
        );
    }

    #[test]
    fn a_variant_that_starts_in_collision_counts_neither_way() {
        let mut out = of(Part::Perturbed, Until::Plan, 1, None);
        out.left_out = true;
        out.run.variant = 7;
        let good = of(Part::Perturbed, Until::Plan, 1, Some(4.0));
        let table = write(&[good, out]);
        let row = row_of(&table, "| two-box, perturbed");
        assert!(
            row.ends_with(
                "| 1 of 1 (100 %); accepted: 1 of 1 (100 %); **4** s (4); 1 more start in collision |"
            ),
            "{row}"
        );
    }

    #[test]
    fn scenes_and_policies_have_a_row_each() {
        let table = write(&[
            of(Part::Scenes, Until::Plan, 1, Some(9.0)),
            of(Part::Scenes, Until::Plan, 2, Some(9.0)),
            of(Part::Scenes, Until::Plan, 3, None),
            of(Part::Policies, Until::Limits, 1, Some(3.0)),
        ]);
        let row = row_of(&table, "| other scenes (limit 300 s)");
        assert!(
            row.ends_with("| 1 of 1 by most seeds; accepted: 0 of 1 |"),
            "{row}"
        );
        let row = row_of(&table, "| stairs (limit 300 s)");
        assert!(
            row.ends_with("| 2 of 3 | 1 of 3 | **9** (9, 9, –) | **2** (1, 2, –) | cop; the end |"),
            "{row}"
        );
        let row = row_of(&table, "| two-box, tree");
        assert!(
            row.ends_with("| **1** (1) | **1** (1) | **3** (3) | **1** (1) | **1** (1) |"),
            "{row}"
        );
    }
}
