//! Options of the search and the optimiser, with their defaults.

use crate::file::{OptimiserEntry, SearchEntry};
use crate::robot::read;
use crate::source::{At, Source};
use crate::{Fault, OptimiserOptions, SceneError, SearchOptions};
use std::path::Path;
use symbolic::pddl::DomainFile;

/// Largest counts of phases, actions and changes that make sense.
const LARGEST_COUNT: usize = 1000;

/// Largest number of intervals per phase.
const LARGEST_STEPS: usize = 200;

/// Largest number of iterations.
const LARGEST_ITERATIONS: usize = 100_000;

impl Default for SearchOptions {
    fn default() -> Self {
        Self {
            max_phases: None,
            max_skeleton: None,
            max_changes: 1,
            support_hands: false,
            flights: true,
            steps: 6,
            domain: None,
        }
    }
}

impl Default for OptimiserOptions {
    fn default() -> Self {
        Self {
            steps: 16,
            min_duration: 0.25,
            max_duration: 2.0,
            torque_limits: true,
            max_iterations: 200,
        }
    }
}

/// `[search]`; the path of a domain starts at `base_dir`.
pub(crate) fn search(
    source: &Source,
    entry: &SearchEntry,
    base_dir: &Path,
) -> Result<SearchOptions, SceneError> {
    let default = SearchOptions::default();
    let count = |what: &str, value: Option<&At<usize>>| {
        value
            .map(|value| source.count(what, value, 1..=LARGEST_COUNT))
            .transpose()
    };
    Ok(SearchOptions {
        max_phases: count("max_phases", entry.max_phases.as_ref())?,
        max_skeleton: count("max_skeleton", entry.max_skeleton.as_ref())?,
        max_changes: count("max_changes", entry.max_changes.as_ref())?
            .unwrap_or(default.max_changes),
        support_hands: entry.support_hands.unwrap_or(default.support_hands),
        flights: entry.flights.unwrap_or(default.flights),
        steps: entry
            .steps
            .as_ref()
            .map(|value| source.count("steps", value, 1..=LARGEST_STEPS))
            .transpose()?
            .unwrap_or(default.steps),
        domain: (entry.domain.as_ref())
            .map(|path| domain(source, path, base_dir))
            .transpose()?,
    })
}

/// Reads the PDDL domain that the scene names.
fn domain(source: &Source, path: &At<String>, base_dir: &Path) -> Result<DomainFile, SceneError> {
    let file = base_dir.join(&**path);
    let shown = file.display().to_string();
    let text = read(&file, &source.place(path.span()))?;
    DomainFile::parse(&shown, &text).map_err(|error| {
        let place = Source::new(&shown, &text).place(error.span);
        let (problem, remedy) = (error.problem, error.remedy);
        SceneError::at(place, Fault::Pddl { problem, remedy })
    })
}

/// `[optimiser]`; `durations` are the shortest and longest phase [s] of a scene that gives none.
pub(crate) fn optimiser(
    source: &Source,
    entry: &OptimiserEntry,
    durations: (f64, f64),
) -> Result<OptimiserOptions, SceneError> {
    let default = OptimiserOptions::default();
    let duration = |what: &str, value: Option<&At<f64>>, otherwise: f64| match value {
        Some(value) => source.positive(what, "s", value),
        None => Ok(otherwise),
    };
    let min_duration = duration("min_duration", entry.min_duration.as_ref(), durations.0)?;
    let max_duration = duration(
        "max_duration",
        entry.max_duration.as_ref(),
        durations.1.max(min_duration),
    )?;
    if let (true, Some(given)) = (max_duration < min_duration, &entry.max_duration) {
        let problem = format!(
            "{max_duration} s is less than min_duration, {min_duration} s; raise it or lower min_duration"
        );
        return Err(source.bad_keys(given.span(), "max_duration", &problem));
    }
    let count = |what: &str, value: Option<&At<usize>>, largest: usize, otherwise: usize| {
        value.map_or(Ok(otherwise), |value| {
            source.count(what, value, 1..=largest)
        })
    };
    Ok(OptimiserOptions {
        steps: (entry.steps.as_ref()).map_or(Ok(default.steps), |value| steps(source, value))?,
        min_duration,
        max_duration,
        torque_limits: entry.torque_limits.unwrap_or(default.torque_limits),
        max_iterations: count(
            "max_iterations",
            entry.max_iterations.as_ref(),
            LARGEST_ITERATIONS,
            default.max_iterations,
        )?,
    })
}

/// A number of intervals per phase.
pub(crate) fn steps(source: &Source, value: &At<usize>) -> Result<usize, SceneError> {
    source.count("steps", value, 1..=LARGEST_STEPS)
}
