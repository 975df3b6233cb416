//! Threads that optimise motions. Each job stands for itself, so that results do not depend on how many threads there are.

use super::growth::Costs;
use super::turns::Turns;
use crate::api::Event;
use crate::journal::{Coarse, PointEntry, Tried};
use crate::lapse::Lapse;
use crate::refine::{hold, on_finer_grid, on_which_it_holds};
use crate::{export, summary};
use ocp::{CostTerm, Motion, NEARLY_SOLVED, Phase, Planner, Point, Refinement, Relative, Settings};
use plan::Plan;
use solver::Iteration;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::{self, Scope};
use std::time::Instant;

/// A sequence whose keyframes exist.
pub(super) struct Job {
    pub number: usize,
    /// Where its clock starts ([`Turns`]).
    pub clock: u64,
    /// Work that is one unit of it.
    pub pace: u64,
    /// True if a motion on the finer grid is likely to become a plan: it has all threads.
    pub is_likely: bool,
    pub labels: Vec<String>,
    pub phases: Vec<Phase>,
    pub start: Start,
}

/// What the motion starts from.
pub(super) enum Start {
    /// Keyframes, or, if there is one, first the motion of a relative; and the most iterations.
    Keyframes(Vec<Vec<f64>>, Option<Arc<Relative>>, usize),
    /// Its motion on the coarse grid, and what that costs.
    Coarse(Point, f64),
    /// It is known, and whether it is feasible.
    Known(PointEntry, bool),
}

/// What became of a job.
pub(super) struct Evaluated {
    pub feasible: bool,
    /// It is a motion on the coarse grid that must hold on a finer one to be a plan.
    pub must_hold: bool,
    pub cost: f64,
    /// The part of it that is the scene's objective, mostly negative.
    pub objective: f64,
    pub violation: f64,
    pub iterations: usize,
    /// Elements of the problem, summed over the iterations.
    pub work: u64,
    pub seconds: f64,
    pub reason: Option<String>,
    /// Phase of the most violated row, from 0.
    pub worst_phase: Option<usize>,
    /// Phase that costs most, from 0.
    pub dearest_phase: Option<usize>,
    /// What it lacks between its nodes, if it must hold on a finer grid; on that, if so much that it is no motion.
    pub lapse: Lapse,
    pub point: Option<Point>,
    /// Its intervals per phase.
    pub steps: Vec<usize>,
    /// Of a feasible motion.
    pub plan: Option<Plan>,
    pub relative: Option<Arc<Relative>>,
}

impl Evaluated {
    /// What the journal says of a motion on the coarse grid.
    pub fn coarse(known: &Coarse) -> Self {
        Self {
            feasible: false,
            must_hold: true,
            cost: known.cost,
            objective: known.objective,
            violation: known.violation,
            iterations: known.iterations,
            work: known.work,
            seconds: known.seconds,
            reason: None,
            worst_phase: None,
            dearest_phase: known.dearest_phase,
            lapse: known.lapse,
            steps: known.point.steps.clone(),
            point: Some(known.point.clone().into()),
            plan: None,
            relative: None,
        }
    }

    /// Phase of the most violated row, or of the lapse, of a motion that is none; what is nearly one says nothing of what is possible.
    pub fn failed_phase(&self) -> Option<usize> {
        let is_far_off = self.violation > NEARLY_SOLVED || self.lapse.is_serious();
        self.worst_phase.filter(|_| is_far_off)
    }

    /// Its costs, where its keyframes promised this one.
    pub fn costs(&self, promise: f64) -> Costs {
        Costs {
            promise,
            cost: self.cost,
            effort: self.cost - self.objective,
            dearest_phase: self.dearest_phase,
            lapse: self.lapse,
        }
    }

    /// What it says of a sequence without a motion; no point.
    pub fn remembered(known: &Tried) -> Self {
        Self {
            feasible: false,
            must_hold: false,
            cost: known.cost.unwrap_or(f64::INFINITY),
            objective: 0.0,
            violation: known.violation.unwrap_or(f64::INFINITY),
            iterations: known.iterations,
            work: known.work,
            seconds: known.seconds,
            reason: known.reason.clone(),
            worst_phase: known.failed_phase,
            dearest_phase: known.dearest_phase,
            lapse: known.lapse,
            point: None,
            steps: vec![],
            plan: None,
            relative: None,
        }
    }
}

/// News from a worker.
pub(super) enum Message {
    /// Work done so far on a motion, and what happened.
    Worked(usize, u64, Event),
    Done(usize, Box<Evaluated>),
    /// A worker panicked.
    Lost,
}

/// The threads' end of the work, and when it ends.
pub(super) struct Workers {
    jobs: Sender<Job>,
    pub messages: Receiver<Message>,
    /// Who works when.
    pub turns: Arc<Turns>,
}

/// Phases with other numbers of intervals.
pub(super) fn with_steps(phases: &[Phase], steps: &[usize]) -> Vec<Phase> {
    let phase = |(phase, &steps): (&Phase, &usize)| Phase {
        state: phase.state.clone(),
        steps,
    };
    phases.iter().zip(steps).map(phase).collect()
}

/// What all threads share.
#[derive(Clone, Copy)]
pub(super) struct Shop<'a> {
    pub planner: &'a Planner<'a>,
    pub settings: &'a Settings,
    /// What motions are refined to, if they must hold on a finer grid ([`hold`]) to count.
    pub holds: Option<Refinement>,
    /// Set to make all motions end at their next iteration.
    pub stop: &'a AtomicBool,
    pub begin: Instant,
    pub time_limit: f64,
}

impl Workers {
    /// Starts threads, of which `places` work at the same time, that end when this value is dropped.
    pub fn start<'scope, 'a: 'scope>(
        scope: &'scope Scope<'scope, '_>,
        count: usize,
        places: usize,
        shop: Shop<'a>,
    ) -> Self {
        let (jobs, inbox) = channel::<Job>();
        let (sender, messages) = channel();
        let inbox = Arc::new(Mutex::new(inbox));
        let turns = Arc::new(Turns::new(places));
        for _ in 0..count {
            let (inbox, turns, sender) = (inbox.clone(), turns.clone(), sender.clone());
            scope.spawn(move || {
                let _alarm = Alarm(sender.clone());
                loop {
                    let job = inbox.lock().ok().and_then(|inbox| inbox.recv().ok());
                    let Some(job) = job else { return };
                    let number = job.number;
                    let done = shop.evaluate(job, &turns, &sender);
                    if sender.send(Message::Done(number, Box::new(done))).is_err() {
                        return;
                    }
                }
            });
        }
        Self {
            jobs,
            messages,
            turns,
        }
    }

    pub fn submit(&self, job: Job) {
        // The threads live as long as `self`.
        let _ = self.jobs.send(job);
    }
}

/// Says so if its thread panics, so that nobody waits for it.
struct Alarm(Sender<Message>);

impl Drop for Alarm {
    fn drop(&mut self) {
        if thread::panicking() {
            let _ = self.0.send(Message::Lost);
        }
    }
}

/// Iterations on the finer grid after which a motion that costs so many times what the coarse one does is given up: those that ended
/// well cost up to three times as much, most of those that did not five times and more (benches/runs/2026-11-24-endings.md).
const PATIENCE: usize = 50;
const DEAREST: f64 = 4.0;

/// Largest cost of a motion on the finer grid that is worth more iterations, where the coarse one costs `cost` with this part for
/// the scene's objective: only what is done for it counts.
fn most_cost(cost: f64, objective: f64) -> f64 {
    objective + DEAREST * (cost - objective)
}

/// The part of a motion's cost that is the scene's objective at its end, mostly negative.
fn objective(motion: &mut Motion) -> f64 {
    let last = motion.trajectory.program.n_intervals() - 1;
    let terms = motion.trajectory.cost_terms(&motion.point, last);
    terms.of(CostTerm::Goal)
}

/// The phase of a motion that costs most, from 0; what is for the scene's objective does not count.
fn dearest_phase(motion: &mut Motion) -> Option<usize> {
    let Motion {
        trajectory, point, ..
    } = motion;
    let mut costs = vec![0.0; trajectory.program.steps.len()];
    for t in 0..trajectory.program.n_intervals() {
        let terms = trajectory.cost_terms(point, t);
        let over_time = CostTerm::ALL.iter().filter(|term| !term.is_at_the_end());
        costs[trajectory.program.phase_of(t)] += over_time.map(|term| terms.of(*term)).sum::<f64>();
    }
    (0..costs.len()).max_by(|&a, &b| costs[a].total_cmp(&costs[b]))
}

impl Shop<'_> {
    fn evaluate(self, job: Job, turns: &Turns, sender: &Sender<Message>) -> Evaluated {
        let turn = if job.is_likely {
            turns.enter_for_all(job.number, job.clock)
        } else {
            turns.enter(job.number, job.clock)
        };
        let mut work = 0;
        let mut watch = |i: &Iteration| {
            let before = work / job.pace;
            work += i.elements as u64;
            let event = Event::Iteration {
                number: job.number,
                iteration: i.number,
                violation: i.violation,
                objective: i.objective,
            };
            let news = Message::Worked(job.number, work, event);
            let heard = sender.send(news).is_ok();
            turn.worked(work / job.pace - before);
            let late = self.begin.elapsed().as_secs_f64() > self.time_limit;
            heard && !late && !self.stop.load(Ordering::SeqCst)
        };
        let (planner, settings, phases) = (self.planner, self.settings, &job.phases);
        let mut done = match job.start {
            Start::Known(point, feasible) => {
                let mut motion = self.restore(phases, point.into());
                motion.feasible = feasible;
                return self.report(&job.labels, &mut motion);
            }
            Start::Keyframes(nodes, relative, most) => {
                let mut watch = |i: &Iteration| watch(i) && i.number < most;
                let near =
                    relative.and_then(|r| planner.motion_from(phases, settings, &r, &mut watch));
                let mut motion =
                    near.unwrap_or_else(|| planner.motion(phases, settings, &nodes, &mut watch));
                let must_hold = self.holds.is_some() && motion.is_nearly_feasible();
                let good = motion.feasible || must_hold;
                let relative = good.then(|| Arc::new(motion.relative()));
                motion.feasible &= !must_hold;
                let lapse = must_hold.then(|| Lapse::of(&mut motion));
                Evaluated {
                    must_hold,
                    lapse: lapse.unwrap_or_default(),
                    relative,
                    ..self.report(&job.labels, &mut motion)
                }
            }
            Start::Coarse(point, cost) => {
                let mut coarse = planner.restore(phases, settings, point);
                let most = most_cost(cost, objective(&mut coarse));
                let mut watch =
                    |i: &Iteration| watch(i) && (i.number < PATIENCE || i.objective <= most);
                let grid = self.holds.unwrap_or_default();
                let settings = &Settings {
                    threads: if job.is_likely { turns.places() } else { 1 },
                    ..settings.clone()
                };
                let mut motion = hold(planner, phases, settings, (&coarse, grid), &mut watch);
                let lapse = motion.feasible.then(|| Lapse::of(&mut motion));
                let serious = lapse.filter(Lapse::is_serious);
                motion.feasible &= serious.is_none();
                let done = self.report(&job.labels, &mut motion);
                let reason = serious.map(|lapse| lapse.words()).or(done.reason);
                Evaluated {
                    reason: reason.as_deref().map(on_finer_grid),
                    worst_phase: serious.map(|lapse| lapse.phase).or(done.worst_phase),
                    lapse: serious.unwrap_or_default(),
                    ..done
                }
            }
        };
        done.work = work;
        done
    }

    /// A motion that is known ([`Planner::restore`]), on the grid on which it was found.
    pub fn restore(self, phases: &[Phase], point: Point) -> Motion {
        self.restored(phases, point, None)
    }

    /// The same with the coarse grid's longest interval: what is refined from it then gets little room to grow, which takes half the
    /// iterations (benches/runs/2026-11-25-perturbed.md).
    pub fn restore_to_refine(self, phases: &[Phase], point: Point) -> Motion {
        self.restored(phases, point, Some(self.settings.max_step))
    }

    fn restored(self, phases: &[Phase], point: Point, max_step: Option<f64>) -> Motion {
        let finer = self.holds.filter(|_| !point.velocities.is_empty());
        let settings = finer.map_or(self.settings.clone(), |refinement| {
            let on_grid = on_which_it_holds(refinement).settings(self.settings);
            Settings {
                max_step: max_step.unwrap_or(on_grid.max_step),
                ..on_grid
            }
        });
        self.planner.restore(phases, &settings, point)
    }

    fn report(self, labels: &[String], motion: &mut Motion) -> Evaluated {
        let scene = self.planner.scene;
        Evaluated {
            feasible: motion.feasible,
            must_hold: false,
            cost: motion.report.objective,
            objective: objective(motion),
            violation: motion.report.violation,
            iterations: motion.iterations,
            work: 0,
            seconds: motion.seconds,
            reason: summary::resistance(scene, motion),
            worst_phase: motion.worst.as_ref().map(|w| w.phase),
            dearest_phase: dearest_phase(motion),
            lapse: Lapse::default(),
            point: Some(motion.point.clone()),
            steps: motion.trajectory.program.steps.clone(),
            plan: motion.feasible.then(|| export::plan(scene, labels, motion)),
            relative: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_that_takes_five_times_as_much_is_given_up_whatever_it_reaches() {
        for objective in [0.0, -45.0] {
            let most = most_cost(5.0 + objective, objective);
            assert!(15.0 + objective <= most && 25.0 + objective > most);
        }
    }
}
