//! One given contact sequence: keyframes, then the trajectory optimiser. No search.

use std::time::Instant;

use crate::api::{Error, Event, Found, Request};
use crate::checks::Checks;
use crate::explain::{Case, Failed, explain};
use crate::journal::Journal;
use crate::{domain, export, refine, search, summary};
use ocp::{Keyframes, Motion, Phase, Planner, Settings};
use plan::Explanation;
use scene::{Scene, Sequence};
use solver::{Iteration, Status, Timing};
use symbolic::Action;

/// The number that events of [`solve`] carry: there is one sequence.
const NUMBER: usize = 1;
/// First barrier parameter of a second attempt.
const SECOND_BARRIER: f64 = 0.1;

/// What came of the keyframes.
#[derive(Debug, Clone)]
pub struct KeyframeReport {
    /// True if contacts, clearances and goal regions can be satisfied at all phase boundaries.
    pub possible: bool,
    /// Iterations of all rounds.
    pub iterations: usize,
    /// Wall time [s].
    pub seconds: f64,
}

/// What came of the motion.
#[derive(Debug, Clone)]
pub struct MotionReport {
    /// How the last round ended.
    pub status: Status,
    /// Iterations of all rounds.
    pub iterations: usize,
    /// Solver time of all rounds, part by part.
    pub timing: Timing,
    /// Cost at the end.
    pub cost: f64,
    /// Largest violation, each row in its own SI unit.
    pub violation: f64,
}

/// Result of [`solve`].
#[derive(Debug)]
pub struct Solved {
    /// The motion, feasible or not; `None` if there are no keyframes.
    pub best: Option<Found>,
    /// True if `best` satisfies everything.
    pub feasible: bool,
    /// What came of the keyframes.
    pub keyframes: KeyframeReport,
    /// What came of the motion; `None` if there are no keyframes.
    pub motion: Option<MotionReport>,
    /// Why there is no plan: constraint, contact or joint, amount and phase.
    pub reason: Option<String>,
    /// Why there is no plan and what would change that, if the request asks for it; also in the plan.
    pub explanation: Option<Explanation>,
    /// Wall time [s].
    pub seconds: f64,
}

/// Optimises one contact sequence.
///
/// Of the request, preset and time limit count. `observe` sees the sequence, its keyframes, the iterations and the end; it
/// stops the optimiser by returning false, and the last iterate is returned then.
///
/// # Errors
/// If the scene is no planning problem: no model, start in collision.
pub fn solve(
    scene: &Scene,
    sequence: &Sequence,
    request: &Request,
    observe: &mut dyn FnMut(&Event) -> bool,
) -> Result<Solved, Error> {
    let begin = Instant::now();
    let scene = &with_goal(scene, sequence);
    let planner = Planner::new(scene)?;
    crate::start::check_start(scene, &planner)?;
    let labels = labels(scene, sequence)?;
    let settings = search::settings_of_one(scene, request)?;
    let phases = phases(sequence);
    let mut stopped = !observe(&Event::Sequence {
        number: NUMBER,
        labels: labels.clone(),
    });
    let start = Instant::now();
    let of_the_sequence = known(&planner, &phases, &settings, &sequence.configurations);
    let are_given = of_the_sequence.is_some();
    let own = || keyframes(&planner, &phases, &settings, request);
    let others = || are_given.then(own).filter(|found| found.possible);
    let keyframes = of_the_sequence.unwrap_or_else(own);
    let mut solved = Solved {
        best: None,
        feasible: false,
        keyframes: KeyframeReport {
            possible: keyframes.possible,
            iterations: keyframes.iterations,
            seconds: start.elapsed().as_secs_f64(),
        },
        motion: None,
        reason: no_keyframes(scene, &keyframes),
        explanation: None,
        seconds: 0.0,
    };
    stopped |= !observe(&Event::Keyframes {
        number: NUMBER,
        possible: keyframes.possible,
        reason: solved.reason.clone(),
    });
    let case = |failed, falls_short| Case {
        scene,
        phases: &phases,
        labels: &labels,
        request,
        is_quick: false,
        falls_short,
        failed,
    };
    if keyframes.possible && !stopped {
        let mut late = false;
        let mut watch = |i: &Iteration| {
            stopped |= !observe(&Event::Iteration {
                number: NUMBER,
                iteration: i.number,
                violation: i.violation,
                objective: i.objective,
            });
            late = begin.elapsed().as_secs_f64() > request.time_limit;
            !stopped && !late
        };
        let asked = (&settings, request);
        let mut from = |nodes: &[Vec<f64>]| attempts(&planner, &phases, asked, nodes, &mut watch);
        let held = from(&keyframes.nodes).or_from(others, &mut from);
        let (motion, falls_short) = (held.motion, held.falls_short);
        let ended = match (stopped, late) {
            (true, _) => Some("stopped by the caller".to_owned()),
            (_, true) => Some(format!("time limit of {} s", request.time_limit)),
            _ => None,
        };
        let ended_early = ended.is_some();
        solved.reason = no_motion(scene, &motion, ended);
        if falls_short {
            solved.reason = solved.reason.as_deref().map(refine::on_finer_grid);
        }
        solved.take_motion(&motion);
        observe(&Event::Optimised {
            number: NUMBER,
            feasible: motion.feasible,
            cost: motion.report.objective,
            reason: solved.reason.clone(),
        });
        if request.explain && !motion.feasible && !ended_early {
            let case = case(Failed::Motion(&motion), falls_short);
            solved.explanation = Some(explain(&case, begin, observe));
        }
        let (mut motion, refined) = refine::refine(
            &planner,
            &phases,
            &settings,
            motion,
            (request, begin),
            observe,
        );
        let mut found = Found::of(scene, &labels, &mut motion, refined);
        found.plan.explanation.clone_from(&solved.explanation);
        solved.best = Some(found);
    } else if request.explain && !stopped {
        let case = case(Failed::Keyframes(&keyframes), false);
        solved.explanation = Some(explain(&case, begin, observe));
    }
    solved.seconds = begin.elapsed().as_secs_f64();
    Ok(solved)
}

/// A motion on the grid on which it must hold.
struct Held {
    motion: Motion,
    /// True if only that grid has none.
    falls_short: bool,
    /// True if the caller ended it.
    stopped: bool,
}

/// The motion of a sequence from some keyframes; where a first attempt ends without one, the better of two, with the work of both.
fn attempts(
    planner: &Planner,
    phases: &[Phase],
    (settings, request): (&Settings, &Request),
    keyframes: &[Vec<f64>],
    watch: &mut dyn FnMut(&Iteration) -> bool,
) -> Held {
    let asked = (settings, request);
    let coarse = planner.motion(phases, settings, keyframes, watch);
    let first = held(coarse, planner, phases, asked, watch);
    if first.motion.feasible || first.stopped {
        return first;
    }
    let another = Settings {
        first_barrier: SECOND_BARRIER,
        ..settings.clone()
    };
    let coarse = planner.motion(phases, &another, keyframes, watch);
    first.or_better(held(coarse, planner, phases, asked, watch))
}

impl Held {
    /// The better of two attempts, with the work of both.
    fn or_better(self, other: Self) -> Self {
        let nearer = other.motion.report.violation < self.motion.report.violation;
        let (mut better, rest) = if other.motion.feasible || nearer {
            (other, self)
        } else {
            (self, other)
        };
        better.motion.add_work(&rest.motion);
        better.stopped |= rest.stopped;
        better
    }

    /// The better of this and what comes of other keyframes, if there are any, where it may be for want of those that there is no motion:
    /// configurations of a plan can be on the wrong side of what a foot has to pass between them.
    fn or_from(
        self,
        others: impl FnOnce() -> Option<Keyframes>,
        attempts: impl FnOnce(&[Vec<f64>]) -> Self,
    ) -> Self {
        match self.may_be_chance().then(others).flatten() {
            Some(others) => self.or_better(attempts(&others.nodes)),
            None => self,
        }
    }

    /// True if there is no motion, and that may be since something was to be passed on the wrong side, or if only the finer grid has none.
    fn may_be_chance(&self) -> bool {
        let worst = self.motion.worst.as_ref();
        let in_the_way = worst.is_some_and(|w| w.label.category.starts_with("clearance"));
        !self.motion.feasible && !self.stopped && (self.falls_short || in_the_way)
    }
}

/// The motion on the grid on which it must hold, if the request refines motions; the coarse one if that has no solution either,
/// or is interrupted.
fn held(
    coarse: Motion,
    planner: &Planner,
    phases: &[Phase],
    (settings, request): (&Settings, &Request),
    watch: &mut dyn FnMut(&Iteration) -> bool,
) -> Held {
    let Some(refinement) = request.refines().filter(|_| coarse.is_nearly_feasible()) else {
        return Held {
            stopped: coarse.report.status == Status::Interrupted,
            motion: coarse,
            falls_short: false,
        };
    };
    // That grid ends a motion by its own limit too.
    let mut stopped = false;
    let mut watch = |i: &Iteration| {
        stopped |= !watch(i);
        !stopped
    };
    let fine = refine::hold(planner, phases, settings, (&coarse, refinement), &mut watch);
    let was_solved = coarse.feasible || coarse.report.status == Status::Enough;
    let falls_short = was_solved && !fine.feasible && !stopped;
    let motion = if fine.feasible || falls_short {
        fine
    } else {
        coarse
    };
    Held {
        motion,
        falls_short,
        stopped,
    }
}

/// Keyframes at configurations that are known, or near them, if they have the size and the contacts.
fn known(
    planner: &Planner,
    phases: &[Phase],
    settings: &Settings,
    configurations: &[Vec<f64>],
) -> Option<Keyframes> {
    let n = planner.system.model.nq;
    let fits = configurations.len() == phases.len() + 1;
    let fits = fits && configurations.iter().all(|q| q.len() == n);
    fits.then(|| planner.keyframes_at(configurations, phases, settings))?
}

/// Keyframes from the sequence alone or, if that fails, as the search finds them: beginning by beginning, walks flown first, steps added.
pub(crate) fn keyframes(
    planner: &Planner,
    phases: &[Phase],
    settings: &Settings,
    request: &Request,
) -> Keyframes {
    let found = planner.keyframes(phases, settings);
    if found.possible {
        return found;
    }
    let settings = &search::balanced(settings.clone());
    let steps = planner.scene.search.steps;
    let limits = (Instant::now(), request.time_limit, request.stop.clone());
    let mut checks = Checks::new(
        (planner, settings, steps),
        limits,
        (Journal::default(), vec![]),
    );
    checks.keyframes_by_walks(phases).unwrap_or(found)
}

impl Solved {
    fn take_motion(&mut self, motion: &Motion) {
        self.feasible = motion.feasible;
        self.motion = Some(MotionReport {
            status: motion.report.status,
            iterations: motion.iterations,
            timing: motion.timing,
            cost: motion.report.objective,
            violation: export::largest_violation(motion),
        });
    }
}

/// Contacts and intervals of the phases.
fn phases(sequence: &Sequence) -> Vec<Phase> {
    let phase = |phase: &scene::SequencePhase| Phase {
        state: phase.state.clone(),
        steps: phase.steps,
    };
    sequence.phases.iter().map(phase).collect()
}

/// The scene with the goal of the sequence, if that has one.
fn with_goal(scene: &Scene, sequence: &Sequence) -> Scene {
    let mut scene = scene.clone();
    if let Some(goal) = &sequence.goal {
        scene.goal_contacts.clone_from(&goal.contacts);
        scene.goal_regions.clone_from(&goal.regions);
    }
    scene
}

/// What changes on entering each phase, where the sequence does not say it.
fn labels(scene: &Scene, sequence: &Sequence) -> Result<Vec<String>, Error> {
    let domain = domain::domain(scene)?;
    let phases = &sequence.phases;
    let derived = (0..phases.len()).map(|k| {
        if k == 0 {
            return "start".to_owned();
        }
        let action = Action::between(&phases[k - 1].state, &phases[k].state);
        if action.is_empty() {
            "the same contacts".to_owned()
        } else {
            action.describe(&domain)
        }
    });
    let given = phases.iter().map(|phase| phase.label.clone());
    Ok(given.zip(derived).map(|(g, d)| g.unwrap_or(d)).collect())
}

fn no_keyframes(scene: &Scene, keyframes: &Keyframes) -> Option<String> {
    if keyframes.possible {
        return None;
    }
    let words = keyframes.worst.as_ref().map(|w| summary::words(scene, w));
    Some(words.unwrap_or_else(|| format!("the keyframes ended as {:?}", keyframes.report.status)))
}

fn no_motion(scene: &Scene, motion: &Motion, ended: Option<String>) -> Option<String> {
    if motion.feasible {
        return None;
    }
    let words = summary::resistance(scene, motion);
    let words =
        words.unwrap_or_else(|| format!("the optimiser ended as {:?}", motion.report.status));
    Some(match ended {
        Some(ended) => format!("{words} ({ended})"),
        None => words,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocp::Preset;
    use std::path::Path;

    const STAND: &str = "../../scenes/sequences/flat/stand.toml";

    #[test]
    fn other_keyframes_are_tried_where_the_finer_grid_alone_has_no_motion_and_not_where_forces_lack()
     {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(STAND);
        let file = scene::SequenceFile::load(&path).expect("a sequence file");
        let scene = file.load_scene().expect("its scene");
        let sequence = file.resolve(&scene).expect("a sequence of the scene");
        let planner = Planner::new(&scene).expect("a model");
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let phases = phases(&sequence);
        let found = planner.keyframes(&phases, &settings);
        let motion = |feasible| Motion {
            feasible,
            ..planner.motion(&phases, &settings, &found.nodes, &mut |_| true)
        };
        let held = |feasible, falls_short| Held {
            motion: motion(feasible),
            falls_short,
            stopped: false,
        };
        let work = held(true, false).motion.iterations;
        let retried = |first: Held| {
            let own = planner.keyframes(&phases, &settings);
            let attempts = |nodes: &[Vec<f64>]| {
                assert_eq!(nodes, own.nodes);
                held(true, false)
            };
            first.or_from(|| Some(planner.keyframes(&phases, &settings)), attempts)
        };
        let better = retried(held(false, true));
        assert!(better.motion.feasible && !better.falls_short);
        assert_eq!(better.motion.iterations, 2 * work);
        let same = retried(held(false, false));
        assert!(!same.motion.feasible);
        assert_eq!(same.motion.iterations, work);
        let stopped = Held {
            stopped: true,
            ..held(false, true)
        };
        assert!(!retried(stopped).motion.feasible);
    }
}
