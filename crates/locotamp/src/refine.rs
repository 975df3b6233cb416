//! The motion that a robot executes: the optimiser's coarse solution again on finer grids.

use std::time::Instant;

use crate::api::{Event, Request};
use check::Status;
use ocp::{Motion, Phase, Planner, Preset, Refinement, Settings};
use plan::Plan;
use solver::Iteration;

/// Longest steps of the grids between the coarse and the finer one, in steps of the finer one: objects and hands move along different
/// curves between nodes, so a grid seven times as fine begins with collisions; the first of 80 ms because landings are shaped on those of
/// at most 65 ms, which doubles the cost of a motion.
const BETWEEN: [f64; 2] = [4.0, 3.0];

/// Longest step of the grid on which a motion must hold to be a plan [s]: with a few long steps per phase and explicit Euler a robot may
/// seem to do what no robot can. A grid twice as fine takes 1.7 times the work (benches/runs/2026-11-28-holds.md).
const HOLDS: f64 = 0.12;
/// Smallest barrier parameter on grids that a finer one follows: the last steps of a motion gain some per cent of its cost, and the finer
/// grid, which begins with a larger one, finds its own optimum.
const BARRIER: f64 = 1e-3;
/// Most iterations on a finer grid, and how many a motion gets beyond if it is nearly solved then: those that end well take 20 to 80,
/// a few up to twice the most.
const FINER_ITERATIONS: usize = 150;
const NEARLY_THERE: usize = 100;
/// In how many iterations the violation must have come to a new least one, and what share of the last that is at most: a motion of 30 s
/// went on for 120 s without any (benches/runs/2026-11-29-walks.md), others crept on by a tenth in 15 iterations or stood still for 150
/// where they were nearly solved; one that ended well came to none in 25. What is small beside the checker's tolerances is progress.
const PATIENCE: usize = 50;
const PROGRESS: f64 = 0.5;
const SMALL: f64 = 1e-5;
/// How many iterations before that count: violations rise now and then when the barrier falls.
const RECENT: usize = 10;

/// Share by which a grid may be longer than one between and still count as that: phases grow a little.
const NEARLY: f64 = 1.1;

/// What became of the finer grid.
#[derive(Debug, Clone, PartialEq)]
pub enum Refined {
    /// Not asked for, or there is no feasible coarse motion.
    No,
    /// The plan is the refined motion.
    Done {
        /// Intervals of the coarse motion.
        coarse_intervals: usize,
        /// Iterations on the finer grid.
        iterations: usize,
        /// Solver time on the finer grid [s].
        seconds: f64,
    },
    /// The plan is a coarser motion, for this reason.
    Failed(String),
}

/// The grid on which a motion must hold to be a plan.
pub(crate) fn on_which_it_holds(refinement: Refinement) -> Refinement {
    Refinement {
        max_step: HOLDS,
        ..refinement
    }
}

/// A coarse motion on the grid on which it must hold to be a plan; iterations and seconds are those of both.
pub(crate) fn hold(
    planner: &Planner<'_>,
    phases: &[Phase],
    settings: &Settings,
    (coarse, refinement): (&Motion, Refinement),
    watch: &mut dyn FnMut(&Iteration) -> bool,
) -> Motion {
    let grid = on_which_it_holds(refinement);
    let mut fine = on_the_way(planner, phases, settings, (coarse, grid), watch);
    fine.iterations += coarse.iterations;
    fine.seconds += coarse.seconds;
    fine
}

/// The same motion on a finer grid that another one follows.
fn on_the_way(
    planner: &Planner<'_>,
    phases: &[Phase],
    settings: &Settings,
    from: (&Motion, Refinement),
    watch: &mut dyn FnMut(&Iteration) -> bool,
) -> Motion {
    let settings = Settings {
        barrier: settings.barrier.max(BARRIER),
        ..settings.clone()
    };
    on_grid(planner, phases, &settings, from, watch)
}

/// The same motion on a finer grid, unless it takes too long.
fn on_grid(
    planner: &Planner<'_>,
    phases: &[Phase],
    settings: &Settings,
    (coarse, grid): (&Motion, Refinement),
    watch: &mut dyn FnMut(&Iteration) -> bool,
) -> Motion {
    let most = settings.max_iterations.min(FINER_ITERATIONS);
    let settings = Settings {
        max_iterations: most + NEARLY_THERE,
        ..settings.clone()
    };
    let mut goes_on = nearly_there(most);
    let (mut is_stopped, mut is_given_up) = (false, false);
    let mut watch = |i: &Iteration| {
        is_stopped |= !watch(i);
        is_given_up |= !goes_on((i.number, i.violation));
        !is_stopped && !is_given_up
    };
    let mut fine = planner.refine(phases, &settings, coarse, grid, &mut watch);
    if is_given_up && !is_stopped {
        fine.report.status = if fine.iterations < most {
            solver::Status::Stalled
        } else {
            solver::Status::IterationLimit
        };
    }
    fine
}

/// Does a motion go on, told its violation after each iteration of a solve: as long as that falls now and then, and beyond `most` if it
/// was nearly solved in one of the last few by then, whatever the repair that follows begins with.
fn nearly_there(most: usize) -> impl FnMut((usize, f64)) -> bool {
    let (mut iterations, mut last) = (0, None);
    let (mut least, mut fell) = (f64::INFINITY, 0);
    let mut nearly = false;
    move |(number, violation)| {
        iterations += 1;
        if violation <= ocp::NEARLY_SOLVED {
            last = Some(iterations);
        }
        let is_new = number == 0;
        if is_new || violation < PROGRESS * least || violation <= SMALL {
            (least, fell) = (violation, iterations);
        }
        if iterations > fell + PATIENCE {
            return false;
        }
        nearly |= iterations == most && last.is_some_and(|last| last + RECENT > most);
        iterations < most || nearly
    }
}

/// Why the checker rejects a refined plan: between nodes, and on shapes as they are, it may find what the optimiser did not ask. Plans of
/// the paper's problem have no margins for that.
pub(crate) fn refusal(plan: &Plan, settings: &Settings) -> Option<String> {
    if settings.preset != Preset::Default {
        return None;
    }
    let report = check::check(plan, &check::Options::accept());
    let failed = report.rows.iter().find(|row| row.status == Status::Fail)?;
    let amount = failed.value.map_or(String::new(), |value| {
        let (tolerance, unit) = (failed.tolerance, failed.unit);
        format!(" {value:.3} {unit}, at most {tolerance} {unit} are allowed")
    });
    let (category, at) = (failed.category, &failed.location);
    let when = (at.time).map_or(String::new(), |time| format!(" at {time:.2} s"));
    Some(format!(
        "the checker rejects it: {category}{amount} ({}{when})",
        at.what
    ))
}

/// Why a motion does not hold on that grid.
pub(crate) fn on_finer_grid(reason: &str) -> String {
    format!("on a grid of {:.0} ms: {reason}", 1e3 * HOLDS)
}

/// Refines a feasible motion if the request wants it, within the time limit that began at `begin`; without success the finest
/// one that was found is returned.
pub(crate) fn refine(
    planner: &Planner<'_>,
    phases: &[Phase],
    settings: &Settings,
    coarse: Motion,
    (request, begin): (&Request, Instant),
    observe: &mut dyn FnMut(&Event) -> bool,
) -> (Motion, Refined) {
    let Some(refinement) = request.refines().filter(|_| coarse.feasible) else {
        return (coarse, Refined::No);
    };
    let coarse_intervals = coarse.trajectory.program.n_intervals();
    let mut stopped = !observe(&Event::Refining {
        max_step: refinement.max_step,
    });
    let mut late = false;
    let mut watch = |i: &Iteration| {
        stopped |= !observe(&Event::Iteration {
            number: 0,
            iteration: i.number,
            violation: i.violation,
            objective: i.objective,
        });
        stopped |= request.stop.is_set();
        late = begin.elapsed().as_secs_f64() > request.time_limit;
        !stopped && !late
    };
    let is_over = || request.stop.is_set() || begin.elapsed().as_secs_f64() > request.time_limit;
    let (mut iterations, mut seconds) = (0, 0.0);
    let mut from = coarse;
    for steps in BETWEEN {
        let grid = Refinement {
            max_step: steps * refinement.max_step,
            ..refinement
        };
        if !is_over() && longest_step(&from) > NEARLY * grid.max_step {
            let finer = on_the_way(planner, phases, settings, (&from, grid), &mut watch);
            (iterations, seconds) = (iterations + finer.iterations, seconds + finer.seconds);
            if finer.feasible {
                from = finer;
            }
        }
    }
    let mut fine = on_grid(planner, phases, settings, (&from, refinement), &mut watch);
    fine.iterations += iterations;
    fine.seconds += seconds;
    if fine.feasible {
        let done = Refined::Done {
            coarse_intervals,
            iterations: fine.iterations,
            seconds: fine.seconds,
        };
        return (fine, done);
    }
    let reason = match crate::summary::resistance(planner.scene, &fine) {
        _ if stopped => "stopped by the caller".to_owned(),
        _ if late => format!("time limit of {} s", request.time_limit),
        Some(words) => words,
        None => format!("the optimiser ended as {:?}", fine.report.status),
    };
    (from, Refined::Failed(reason))
}

/// Longest interval of a motion [s].
fn longest_step(motion: &Motion) -> f64 {
    let steps = motion.trajectory.program.steps.iter();
    let step = |(duration, &steps): (&f64, &usize)| duration / steps as f64;
    let durations = motion.point.durations.iter();
    durations.zip(steps).map(step).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Iterations of a motion with these violations, one after the other, the last one for ever, in one solve.
    fn iterations(violations: &[f64], most: usize) -> usize {
        in_solves(&[violations], most)
    }

    /// The same in several solves.
    fn in_solves(solves: &[&[f64]], most: usize) -> usize {
        let mut goes_on = nearly_there(most);
        let numbered = |solve: &[f64]| -> Vec<_> { solve.iter().copied().enumerate().collect() };
        let all: Vec<(usize, f64)> = solves.iter().flat_map(|solve| numbered(solve)).collect();
        let last = all[all.len() - 1];
        let for_ever = std::iter::repeat((last.0 + 1, last.1));
        let all = all.into_iter().chain(for_ever);
        1 + all.take(2 * most).take_while(|&i| goes_on(i)).count()
    }

    #[test]
    fn a_motion_that_was_nearly_solved_just_now_goes_on_through_its_repair() {
        let near = ocp::NEARLY_SOLVED / 2.0;
        let most = 2 * RECENT;
        let before = vec![1.0; most - 2];
        let with = |more: &[f64]| iterations(&[&before[..], more].concat(), most);
        assert_eq!(with(&[1.0]), most);
        assert!(with(&[near, 1.0]) > most);
        assert!(with(&[1.0, near, 1.0]) > most);
        assert_eq!(iterations(&[near, 1.0], most), most, "long ago");
    }

    #[test]
    fn a_motion_whose_violation_falls_no_more_is_given_up_but_for_a_repair_that_begins_higher() {
        let near = ocp::NEARLY_SOLVED / 2.0;
        let (most, patience) = (4 * PATIENCE, PATIENCE);
        assert_eq!(iterations(&[1.0], most), patience + 2);
        assert_eq!(iterations(&[1.0, 0.6], most), patience + 2, "hardly");
        assert_eq!(iterations(&[1.0, 0.4], most), patience + 3);
        assert_eq!(iterations(&[1.0, near], most), patience + 3, "stands still");
        assert!(iterations(&[1.0, 0.9 * SMALL], most) > most, "is solved");
        let solved = vec![near; patience];
        let repaired = in_solves(&[&solved, &[1.0, 0.4]], most);
        assert_eq!(repaired, patience + patience + 3);
    }

    #[test]
    fn a_refined_plan_is_refused_where_the_checker_rejects_it_but_in_the_problem_of_the_paper() {
        let path = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../scenes/sequences/flat/stand.toml"
        );
        let file = scene::SequenceFile::load(std::path::Path::new(path)).expect("a sequence file");
        let scene = file.load_scene().expect("its scene");
        let sequence = file.resolve(&scene).expect("a sequence of the scene");
        let request = Request::default();
        let solved = crate::solve(&scene, &sequence, &request, &mut |_| true).expect("a problem");
        let mut found = solved.best.expect("a motion");
        assert!(found.is_refined());
        let settings = |preset| Settings::new(preset, &scene.optimiser);
        assert_eq!(refusal(&found.plan, &settings(Preset::Default)), None);
        found.plan.tau[3][0] += 1.0;
        let refused = refusal(&found.plan, &settings(Preset::Default)).expect("1 N m too much");
        assert!(refused.starts_with("the checker rejects it: "), "{refused}");
        assert!(
            refused.contains("N m") && refused.contains(" at 0.0"),
            "{refused}"
        );
        assert_eq!(refusal(&found.plan, &settings(Preset::Paper)), None);
    }
}
