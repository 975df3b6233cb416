//! `locotamp bench`: solves all sequence files of a folder and prints one line for each.

use crate::arguments::BenchOptions;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::solve_command::{Finished, finish, observed, report};
use crate::{Exit, bench_table, interrupt, memory, output};
use locotamp::Request;
use scene::{Expectation, Perturbation, Scene, SequenceFile};
use serde_json::json;
use std::sync::atomic::Ordering;

/// A sequence of the set.
pub(crate) struct Entry {
    /// Path below the folder, without extension.
    pub name: String,
    pub scene: Scene,
    pub sequence: scene::Sequence,
    /// True for a random variant.
    pub is_variant: bool,
}

/// A sequence that was solved.
pub(crate) struct Row {
    /// Path below the folder, without extension.
    pub name: String,
    /// Number of phases and of intervals.
    pub size: (usize, usize),
    pub expect: Option<Expectation>,
    pub finished: Finished,
    /// Peak memory of the process during this sequence [MiB].
    pub memory: Option<f64>,
}

impl Row {
    /// True if the outcome is not the opposite of what is expected; a feasible one must also be accepted by the checker.
    pub fn as_expected(&self) -> bool {
        match &self.expect {
            Some(Expectation::Feasible) => self.finished.accepted(),
            Some(Expectation::Infeasible { .. }) => !self.finished.solved.feasible,
            None => true,
        }
    }
}

/// Solves the set and prints the table.
pub(crate) fn run(options: &BenchOptions) -> Result<Exit, Failure> {
    let entries = entries(options)?;
    let request = Request {
        preset: options.preset.into(),
        time_limit: options.time_limit.unwrap_or(f64::INFINITY),
        integrator: options.integrator.into(),
        sticking: options.sticking.into(),
        refinement: None,
        threads: 1,
        ..Request::default()
    };
    let interrupted = interrupt::flag();
    let mut rows = Vec::new();
    for (number, entry) in (1..).zip(&entries) {
        if interrupted.load(Ordering::SeqCst) {
            break;
        }
        if !options.quiet {
            output::error(&format!("{number}/{}: {}\n", entries.len(), entry.name));
        }
        let mut progress = Progress::of_one_sequence(options.quiet);
        memory::reset();
        let solved = observed(
            &entry.scene,
            &entry.sequence,
            &request,
            &mut progress,
            &interrupted,
        );
        progress.finish();
        let solved = match solved {
            Ok(solved) => solved,
            // A variant may start in collision: it is no problem then.
            Err(error) if entry.is_variant => {
                output::error(&format!("{}: left out, {}", entry.name, error.text()));
                continue;
            }
            Err(error) => return Err(error),
        };
        let finished = finish(&entry.scene, &entry.sequence, solved, None)?;
        let phases = &entry.sequence.phases;
        rows.push(Row {
            name: entry.name.clone(),
            size: (phases.len(), phases.iter().map(|p| p.steps).sum()),
            expect: entry.sequence.expect.clone(),
            finished,
            memory: memory::peak(),
        });
    }
    if options.json {
        output::result(&format!("{}\n", json(&rows)));
    } else {
        output::result(&bench_table::write(&rows));
    }
    let done = !interrupted.load(Ordering::SeqCst) && rows.iter().all(Row::as_expected);
    Ok(if done { Exit::Done } else { Exit::Rejected })
}

/// All sequences of the folder that the filter leaves, in the order of their names; every file is read before the first is
/// solved, so that a fault shows at once.
fn entries(options: &BenchOptions) -> Result<Vec<Entry>, Failure> {
    let folder = &options.folder;
    let paths =
        SequenceFile::find(folder).map_err(|error| Failure::path("read", folder, &error))?;
    let mut entries = Vec::new();
    for path in paths {
        let name = path.strip_prefix(folder).unwrap_or(&path);
        let name = name.with_extension("").display().to_string();
        if options.filter.as_ref().is_some_and(|f| !name.contains(f)) {
            continue;
        }
        let file = SequenceFile::load(&path)?;
        let mut scene = file.load_scene()?;
        if options.no_torque_limits {
            scene.optimiser.torque_limits = false;
        }
        let mut sequence = file.resolve(&scene)?;
        if let Some(steps) = options.steps {
            for phase in &mut sequence.phases {
                phase.steps = steps;
            }
        }
        let intervals: usize = sequence.phases.iter().map(|p| p.steps).sum();
        if options.max_intervals.is_some_and(|most| intervals > most) {
            continue;
        }
        for seed in 1..=options.variants {
            entries.push(Entry {
                name: format!("{name} #{seed}"),
                scene: scene.perturbed(&Perturbation::default(), seed as u64),
                sequence: sequence.clone(),
                is_variant: true,
            });
        }
        entries.push(Entry {
            name,
            scene,
            sequence,
            is_variant: false,
        });
    }
    if entries.is_empty() {
        let filter = options.filter.as_deref();
        let filter = filter.map_or(String::new(), |f| format!(" whose name contains {f:?}"));
        let message = format!(
            "no sequence file (.toml){filter} in {}; name the folder, e.g. scenes/sequences",
            folder.display()
        );
        return Err(Failure::new(Exit::BadInput, message));
    }
    Ok(entries)
}

fn json(rows: &[Row]) -> serde_json::Value {
    rows.iter()
        .map(|row| {
            let (expect, why) = match &row.expect {
                Some(Expectation::Feasible) => (Some("feasible"), None),
                Some(Expectation::Infeasible { why }) => (Some("infeasible"), Some(why)),
                None => (None, None),
            };
            json!({
                "name": row.name,
                "phases": row.size.0,
                "intervals": row.size.1,
                "expect": expect,
                "why": why,
                "as_expected": row.as_expected(),
                "peak_memory_mib": row.memory,
                "report": report(&row.finished),
            })
        })
        .collect()
}
