//! The verdict: one row per category.

use std::fmt;

use plan::{Integrator, Plan};
use serde::Serialize;

use crate::categories::{Level, SPECS};
use crate::margins::Margin;
use crate::measure::Measurements;
use crate::options::Options;

/// Where and when a residual occurs.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Location {
    /// Body, joint or contact; for counting categories the faults.
    pub what: String,
    /// Phase.
    pub phase: Option<usize>,
    /// Node, or the node that begins the interval.
    pub node: Option<usize>,
    /// Share of the interval passed since the node, for samples between nodes.
    pub share: Option<f64>,
    /// Time of the node [s].
    pub time: Option<f64>,
}

impl Location {
    /// A place without a time.
    pub(crate) fn of(what: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            ..Self::default()
        }
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)?;
        if let (Some(phase), Some(node), Some(time)) = (self.phase, self.node, self.time) {
            let comma = if self.what.is_empty() { "" } else { ", " };
            write!(f, "{comma}phase {phase}, node {node}, t = {time:.3} s")?;
        }
        match self.share {
            Some(share) => write!(f, " +{share:.2} dt"),
            None => Ok(()),
        }
    }
}

/// Verdict of one category.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Status {
    /// Within tolerance.
    #[serde(rename = "PASS")]
    Pass,
    /// A measurement beyond its tolerance.
    #[serde(rename = "WARN")]
    Warn,
    /// Beyond tolerance.
    #[serde(rename = "FAIL")]
    Fail,
    /// Nothing to judge.
    #[serde(rename = "n/a")]
    NotApplicable,
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Pass => "PASS",
            Self::Warn => "WARN",
            Self::Fail => "FAIL",
            Self::NotApplicable => "n/a",
        })
    }
}

/// One category.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Name of the category.
    pub category: &'static str,
    /// What it measures.
    pub what: &'static str,
    /// Unit of value and tolerance; empty for counts and ratios.
    pub unit: &'static str,
    /// Whether it can reject the plan.
    pub level: Level,
    /// Largest residual; `None`: nothing to judge. A residual that is not finite reads as the largest number.
    pub value: Option<f64>,
    /// Largest residual that passes.
    pub tolerance: f64,
    /// Verdict.
    pub status: Status,
    /// Where the largest residual is.
    pub location: Location,
}

/// Residuals of one category over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Index into the rows of the report.
    pub row: usize,
    /// Largest residual at each node and in the interval after it, in the unit of the row.
    pub values: Vec<f64>,
}

/// The verdict on a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// One line about the plan.
    pub title: String,
    /// All categories, in a fixed order.
    pub rows: Vec<Row>,
    /// How much of the limits on forces and torques the plan uses.
    pub margins_used: Vec<Margin>,
}

impl Report {
    /// True if no category fails.
    pub fn ok(&self) -> bool {
        self.failed().next().is_none()
    }

    /// Names of the categories that fail.
    pub fn failed(&self) -> impl Iterator<Item = &'static str> + '_ {
        self.rows
            .iter()
            .filter(|row| row.status == Status::Fail)
            .map(|row| row.category)
    }

    /// The row of a category.
    pub fn row(&self, category: &str) -> Option<&Row> {
        self.rows.iter().find(|row| row.category == category)
    }
}

impl Serialize for Report {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Flat<'a> {
            title: &'a str,
            ok: bool,
            failed: Vec<&'static str>,
            rows: &'a [Row],
            margins_used: &'a [Margin],
        }
        let failed = self.failed().collect();
        let Self {
            title,
            rows,
            margins_used,
            ..
        } = self;
        Flat {
            title,
            ok: self.ok(),
            failed,
            rows,
            margins_used,
        }
        .serialize(serializer)
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.title)?;
        writeln!(
            f,
            "{:4}  {:18} {:>11} {:>10}  {:9}  where",
            "", "category", "largest", "tolerance", "unit"
        )?;
        for row in &self.rows {
            let value = row.value.map_or("-".to_owned(), short);
            let (status, category, unit) = (row.status, row.category, row.unit);
            let tolerance = short(row.tolerance);
            writeln!(
                f,
                "{status:4}  {category:18} {value:>11} {tolerance:>10}  {unit:9}  {}",
                row.location
            )?;
        }
        if !self.margins_used.is_empty() {
            let margins: Vec<_> = self.margins_used.iter().map(ToString::to_string).collect();
            writeln!(
                f,
                "limits used, largest (share of samples above 95 %): {}",
                margins.join(", ")
            )?;
        }
        if self.ok() {
            f.write_str("PASS")
        } else {
            write!(f, "FAIL: {}", self.failed().collect::<Vec<_>>().join(", "))
        }
    }
}

/// Three significant digits.
fn short(value: f64) -> String {
    if value == f64::MAX {
        "inf".to_owned()
    } else if value == 0.0 {
        "0".to_owned()
    } else if (1e-4..1e5).contains(&value.abs()) {
        let decimals = (2 - value.abs().log10().floor() as i32).max(0) as usize;
        let text = format!("{value:.decimals$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    } else {
        format!("{value:.2e}")
    }
}

/// Judges the measurements by the options' tolerances.
pub(crate) fn assemble(
    plan: &Plan,
    options: &Options,
    found: &Measurements,
    margins_used: Vec<Margin>,
) -> Report {
    let row = |spec: &crate::categories::Spec| {
        let tolerance = options.tolerance(plan.dynamics, spec.category);
        let level = options.level(plan.dynamics, spec.category);
        let (value, location) = match found.get(spec.category) {
            Some((value, location)) => (Some(*value), location.clone()),
            None => (None, Location::default()),
        };
        let status = match value {
            None => Status::NotApplicable,
            Some(value) if value <= tolerance => Status::Pass,
            Some(_) if level == Level::Warn && !options.strict => Status::Warn,
            Some(_) => Status::Fail,
        };
        Row {
            category: spec.name,
            what: spec.what,
            unit: spec.unit,
            level,
            value,
            tolerance,
            status,
            location,
        }
    };
    Report {
        title: title(plan),
        rows: SPECS.iter().map(row).collect(),
        margins_used,
    }
}

/// The residuals over time of all rows that have some, at `n` nodes.
pub(crate) fn series(report: &Report, found: &Measurements, n: usize) -> Vec<Series> {
    let values = |row: usize| {
        let values = found.over_time(SPECS[row].category, n)?;
        Some(Series { row, values })
    };
    (0..report.rows.len()).filter_map(values).collect()
}

fn title(plan: &Plan) -> String {
    let status = match plan.status {
        plan::Status::Feasible => "feasible",
        plan::Status::Infeasible => "infeasible",
    };
    let integrator = match plan.integrator {
        Integrator::Euler => "euler",
        Integrator::SemiImplicitEuler => "semi_implicit_euler",
        Integrator::ConstantAcceleration => "constant_acceleration",
    };
    let (phases, intervals, duration) = (plan.phases.len(), plan.n_intervals(), plan.duration());
    let task = &plan.task;
    format!(
        "{task}: {status}, {phases} phases, {intervals} intervals, {duration:.2} s, integrator {integrator}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_shortened_to_three_digits() {
        let cases = [
            (0.0, "0"),
            (1234.5, "1234"),
            (0.012_345, "0.0123"),
            (40.0, "40"),
            (1e-5, "1.00e-5"),
            (f64::MAX, "inf"),
        ];
        for (value, text) in cases {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn a_location_reads_like_a_sentence() {
        let place = Location {
            what: "knee".into(),
            phase: Some(1),
            node: Some(12),
            share: Some(0.5),
            time: Some(0.81),
        };
        assert_eq!(
            place.to_string(),
            "knee, phase 1, node 12, t = 0.810 s +0.50 dt"
        );
        assert_eq!(Location::of("").to_string(), "");
    }
}
