//! One run of the search, watched.

use crate::record::{Effort, Feet, Judged, Record, Returned, Solution, Verdict};
use crate::runs::{Run, Until};
use locotamp::{Error, Event, Outcome, Refined};
use plan::Plan;
use scene::{Role, Scene, SceneError};
use std::collections::{BTreeMap, BTreeSet};
use std::panic::{self, AssertUnwindSafe};
use std::thread;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// Interfaces of the scene "climb".
const PLATFORM: &str = "platform_top";
const BOX: &str = "box_top";
/// Units of processor time per second, as Linux shows it to programs.
const TICKS: f64 = 100.0;

/// Makes a run. That a scene cannot be planned is a result.
///
/// # Errors
/// If there is no such scene.
pub fn measure(run: &Run, threads: usize) -> Result<Record, SceneError> {
    let scene = run.scene()?;
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    let processors = || thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let mut record = Record {
        run: run.clone(),
        begun_at: since.map_or(0, |since| since.as_secs()),
        threads: if threads == 0 { processors() } else { threads },
        error: None,
        left_out: false,
        ended: String::new(),
        seconds: 0.0,
        search: Effort::default(),
        refinement_iterations: 0,
        returned: None,
        solutions: vec![],
    };
    let mut watch = Watch::new(&scene, run.group.until);
    let request = run.request(threads);
    let planned = panic::catch_unwind(AssertUnwindSafe(|| {
        locotamp::plan(&scene, &request, &mut |event| watch.see(event))
    }));
    record.seconds = watch.begin.elapsed().as_secs_f64();
    record.search = watch.search.unwrap_or_else(|| watch.now());
    record.refinement_iterations = watch.refinement_iterations;
    let mut different = BTreeSet::new();
    // Up to each result, in the order in which they were taken.
    let mut iterations = BTreeMap::new();
    match planned {
        Ok(Ok(outcome)) => {
            different.extend(outcome.alternatives.iter().map(|a| a.number));
            let mut sum = 0;
            for attempt in &outcome.attempts {
                sum += attempt.iterations;
                iterations.insert(attempt.number, sum);
            }
            record.search.iterations = sum;
            record.returned = returned(&scene, &outcome);
            record.ended = outcome.ended;
        }
        Ok(Err(error)) => {
            record.left_out = run.variant > 0 && matches!(error, Error::StartInCollision { .. });
            record.error = Some(error.to_string());
        }
        Err(_) => record.error = Some("a panic".to_owned()),
    }
    let solution = |(number, effort, plan): (usize, Effort, Box<Plan>)| Solution {
        number,
        effort: Effort {
            iterations: iterations.get(&number).copied().unwrap_or_default(),
            ..effort
        },
        different: different.contains(&number),
        judged: judge(&scene, &plan),
    };
    record.solutions = watch.plans.into_iter().map(solution).collect();
    Ok(record)
}

/// Counts what happens.
struct Watch<'a> {
    scene: &'a Scene,
    until: Until,
    begin: Instant,
    processor: f64,
    drawn: usize,
    begun: BTreeSet<usize>,
    /// Sequences with a result, be it one on the coarse grid alone.
    optimised: BTreeSet<usize>,
    seen: usize,
    refinement_iterations: usize,
    /// When the refinement began.
    search: Option<Effort>,
    plans: Vec<(usize, Effort, Box<Plan>)>,
}

impl<'a> Watch<'a> {
    fn new(scene: &'a Scene, until: Until) -> Self {
        Self {
            scene,
            until,
            begin: Instant::now(),
            processor: processor_seconds(),
            drawn: 0,
            begun: BTreeSet::new(),
            optimised: BTreeSet::new(),
            seen: 0,
            refinement_iterations: 0,
            search: None,
            plans: vec![],
        }
    }

    fn now(&self) -> Effort {
        Effort {
            seconds: self.begin.elapsed().as_secs_f64(),
            processor_seconds: processor_seconds() - self.processor,
            drawn: self.drawn,
            begun: self.begun.len(),
            optimised: self.optimised.len(),
            iterations: 0, // told when the run is over
            seen: self.seen,
        }
    }

    /// Takes note of an event; false ends the run.
    fn see(&mut self, event: &Event) -> bool {
        match event {
            Event::Sequence { .. } => self.drawn += 1,
            Event::Iteration { number: 0, .. } => self.refinement_iterations += 1,
            Event::Iteration { number, .. } => {
                self.begun.insert(*number);
                self.seen += 1;
            }
            Event::Coarse { number, .. } | Event::Optimised { number, .. } => {
                self.optimised.insert(*number);
            }
            Event::Solution { number, plan, .. } => {
                self.plans.push((*number, self.now(), plan.clone()));
                let climbed = feet(self.scene, plan).is_some_and(Feet::climbed);
                return self.until != Until::Climbed || !climbed;
            }
            Event::Refining { .. } => {
                let now = self.now();
                self.search.get_or_insert(now);
            }
            Event::Started { .. }
            | Event::Keyframes { .. }
            | Event::Explaining { .. }
            | Event::Tried { .. } => {}
        }
        true
    }
}

fn returned(scene: &Scene, outcome: &Outcome) -> Option<Returned> {
    let found = outcome.best.as_ref()?;
    Some(Returned {
        feasible: outcome.feasible,
        refined: match &found.refined {
            Refined::Done { .. } => "yes".to_owned(),
            Refined::No => "no".to_owned(),
            Refined::Failed(reason) => reason.clone(),
        },
        judged: judge(scene, &found.plan),
    })
}

fn judge(scene: &Scene, plan: &Plan) -> Judged {
    let report = check::check(plan, &check::Options::accept());
    Judged {
        verdict: Verdict {
            accepted: report.ok(),
            failed: report.failed().map(str::to_owned).collect(),
        },
        feet: feet(scene, plan),
        cost: plan.objective.as_ref().and_then(|objective| objective.cost),
        duration: plan.duration(),
        height: plan.q.last().map_or(0.0, |q| q[2]),
        phases: plan.phases.len(),
    }
}

/// Where the feet get, if there is a platform.
fn feet(scene: &Scene, plan: &Plan) -> Option<Feet> {
    scene.interfaces.iter().find(|i| i.name == PLATFORM)?;
    let feet = scene.interfaces.iter().filter(|i| i.role == Role::Foot);
    let stands = |foot: &str, on: &str, phase: &plan::Phase| {
        phase.contacts.iter().any(|c| c.a == foot && c.b == on)
    };
    let last = plan.phases.last()?;
    Some(Feet {
        on_platform: feet.clone().all(|foot| stands(&foot.name, PLATFORM, last)),
        over_box: feet.clone().any(|foot| {
            let mut phases = plan.phases.iter();
            phases.any(|phase| stands(&foot.name, BOX, phase))
        }),
    })
}

/// Processor time of this process as Linux tells it [s]; zero elsewhere.
fn processor_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // Behind the name in parentheses: state, ten numbers, user time, system time.
    let times = text.rsplit(')').next().unwrap_or_default();
    let times = times.split_whitespace().skip(11).take(2);
    times.filter_map(|t| t.parse::<f64>().ok()).sum::<f64>() / TICKS
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::{Extent, Part, all};
    use std::hint::black_box;

    #[test]
    fn processor_time_goes_on() {
        let begin = processor_seconds();
        let clock = Instant::now();
        while clock.elapsed().as_secs_f64() < 0.1 {
            black_box((0..10_000).sum::<u64>());
        }
        if cfg!(target_os = "linux") {
            let passed = processor_seconds() - begin;
            assert!(passed > 0.0 && passed < 60.0, "{passed}");
        }
    }

    #[test]
    fn the_scene_has_the_surfaces_that_feet_are_looked_for_on() {
        let climb = all(&Extent {
            parts: vec![Part::Climb],
            ..Extent::default()
        });
        let scene = climb[0].scene().expect("the scene");
        for name in [PLATFORM, BOX] {
            assert!(scene.interfaces.iter().any(|i| i.name == name), "{name}");
        }
    }
}
