//! The rows of the table "Numbers to reach".

use crate::numbers::{numbers, percent, share, with_unit};
use crate::record::{Effort, Judged, Record};
use crate::runs::{EVALUATED, Until};
use crate::table::{Runs, row};
use std::fmt::Write;

/// Different plans of one task that are wanted.
const WANTED_PLANS: f64 = 5.0;

pub fn two_box(text: &mut String, runs: &Runs<'_>) {
    let (group, limit) = (runs.group, runs.limit());
    if group.until == Until::Plan {
        let first = |value: fn(Effort) -> f64| runs.each(|record| record.first().map(value));
        let optimised = first(|effort| effort.optimised as f64);
        let begun = first(|effort| effort.begun as f64);
        let what = format!("two-box: full optimisations until the first plan ({limit})");
        let here = format!("{}; begun: {}", numbers(&optimised), numbers(&begun));
        row(text, &[&what, "30", "≤ 10", &here]);
        let what = format!("two-box: time to the first plan ({limit})");
        let here = format!(
            "{}; accepted: {}",
            with_unit(&first(|effort| effort.seconds), "s"),
            share(runs.count(Record::accepted), runs.records.len())
        );
        row(text, &[&what, "about 26 min", "≤ 60 s, aim 20 s", &here]);
    } else {
        let all = |r: &Record| r.search.optimised >= EVALUATED;
        let time = runs.each(|r| all(r).then_some(r.search.seconds));
        let mut here = with_unit(&time, "s");
        for record in runs.records.iter().filter(|r| !all(r)) {
            let effort = &record.search;
            let (seed, optimised) = (record.run.seed, effort.optimised);
            let _ = write!(
                here,
                "; seed {seed}: {optimised} in {:.0} s",
                effort.seconds
            );
        }
        let what = format!("two-box: {EVALUATED} evaluated sequences ({limit})");
        row(text, &[&what, "2.9 h", "≤ 10 min", &here]);
    }
}

pub fn climb(text: &mut String, runs: &Runs<'_>) {
    let seconds = runs.each(|r| r.first_climbed().map(|effort| effort.seconds));
    let on_platform = |judged: &Judged| judged.feet.is_some_and(|feet| feet.on_platform);
    let direct = |record: &Record| record.solutions.iter().any(|s| on_platform(&s.judged));
    let returned = |record: &Record| {
        let climbed = record.returned.as_ref().is_some_and(|r| r.judged.climbed());
        climbed && record.accepted()
    };
    let all = runs.records.len();
    let here = format!(
        "{}; {}; returned, refined if possible and accepted: {}; onto the platform in any way: {}",
        share(seconds.iter().flatten().count(), all),
        with_unit(&seconds, "s"),
        share(runs.count(returned), all),
        share(runs.count(direct), all),
    );
    let what = format!(
        "climb: both feet on the platform, over the box ({})",
        runs.limit()
    );
    row(
        text,
        &[&what, "shown once", "≤ 10 min in ≥ 4 of 5 seeds", &here],
    );
}

pub fn different(text: &mut String, runs: &Runs<'_>) {
    let plans = runs.each(|r| Some(r.different().count() as f64));
    let good = |r: &Record| r.different().filter(|s| s.judged.verdict.accepted).count() as f64;
    let accepted = runs.each(|r| Some(good(r)));
    let here = format!(
        "{}; accepted before refinement: {}",
        numbers(&plans),
        numbers(&accepted)
    );
    let (scene, limit) = (&runs.group.scene, runs.limit());
    let what = format!("{scene}: plans with different contacts ({limit})");
    row(
        text,
        &[&what, "\"a variety\"", &format!("≥ {WANTED_PLANS}"), &here],
    );
}

/// How many scenes are solved, by most of their seeds.
pub fn scenes_in_short(text: &mut String, scenes: &[&Runs<'_>]) {
    let mut limits: Vec<f64> = scenes.iter().map(|runs| runs.group.time_limit).collect();
    limits.sort_by(f64::total_cmp);
    limits.dedup();
    for limit in limits {
        let of_limit = || scenes.iter().filter(|runs| runs.group.time_limit == limit);
        let most = |is: fn(&Record) -> bool| {
            let most = |runs: &&&Runs<'_>| 2 * runs.count(is) > runs.records.len();
            share(of_limit().filter(most).count(), of_limit().count())
        };
        let solved = most(|record| record.first().is_some());
        let here = format!(
            "{solved} by most seeds; accepted: {}",
            most(Record::accepted)
        );
        let what = format!("other scenes (limit {limit} s)");
        row(text, &[&what, "–", "≥ 8 of 8 in 5 min each", &here]);
    }
}

pub fn perturbed(text: &mut String, runs: &Runs<'_>) {
    let climbs = runs.group.until == Until::Climbed;
    let solved = |record: &Record| match runs.group.until {
        Until::Climbed => record.first_climbed().is_some(),
        Until::Plan | Until::Limits => record.first().is_some(),
    };
    let accepted = |record: &Record| {
        let mut solutions = record.solutions.iter();
        let climbed = |judged: &Judged| judged.climbed() && judged.verdict.accepted;
        if climbs {
            solutions.any(|s| climbed(&s.judged))
        } else {
            record.accepted()
        }
    };
    let time = |record: &Record| {
        let effort = if climbs {
            record.first_climbed()
        } else {
            record.first()
        };
        effort.map(|effort| effort.seconds)
    };
    let (scene, limit, all) = (&runs.group.scene, runs.limit(), runs.valid());
    let counts = |n: usize| format!("{} ({:.0} %)", share(n, all), percent(n, all));
    let valid: Vec<_> = runs.records.iter().filter(|r| !r.left_out).collect();
    let times: Vec<_> = valid.iter().map(|record| time(record)).collect();
    let before = if climbs { " before refinement" } else { "" };
    let mut here = format!(
        "{}; accepted{before}: {}; {}",
        counts(runs.count(solved)),
        counts(runs.count(accepted)),
        with_unit(&times, "s")
    );
    if all < runs.records.len() {
        let out = runs.records.len() - all;
        let _ = write!(here, "; {out} more start in collision");
    }
    let (what, aim) = if climbs {
        ("over the box", "≥ 70 %")
    } else {
        ("solved", "≥ 90 %")
    };
    let what = format!("{scene}, perturbed: {what} ({limit})");
    row(text, &[&what, "–", aim, &here]);
}
