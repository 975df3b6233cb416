//! The plan search: sequences best first, states, transitions and keyframes as filters, the trajectory optimiser as the judge.

use std::time::Instant;

use crate::api::{Attempt, Error, Event, Found, Outcome, Reached, Request};
use crate::checks::Checks;
use crate::{domain, refine, summary};
use ocp::{Integrator, Keyframes, Motion, Phase, Planner, Preset, Relative, Settings};
use scene::Scene;
use solver::Iteration;
use symbolic::search::Rejected;
use symbolic::{BestFirst, Costs, Sequence};

/// Overlap of bodies at the start that is tolerated [m]: less than the collision model's own accuracy.
const START_OVERLAP: f64 = 0.005;

/// Phases at the end in which a sequence may differ from another whose motion it starts from.
const DIFFERENT_AT_END: usize = 2;

/// Finds contacts and motion for a scene.
///
/// `observe` sees everything that happens and ends the search by returning false; the best so far is returned then.
///
/// # Errors
/// If the scene is no planning problem: start in collision, goal out of reach of every manipulation.
pub fn plan(
    scene: &Scene,
    request: &Request,
    observe: &mut dyn FnMut(&Event) -> bool,
) -> Result<Outcome, Error> {
    let begin = Instant::now();
    let planner = Planner::new(scene)?;
    check_start(scene, &planner)?;
    let (graph, limits) = domain::graph(scene)?;
    let Some(skeleton) = graph.shortest_skeleton() else {
        let goal = goal_text(scene);
        return Err(Error::Unreachable(format!(
            "no sequence of grasp, lift, place and release leads to the goal {goal}; does a hand accept the object's \
             handle or two opposite patches, and the goal surface its bottom?"
        )));
    };
    let contacts = graph.domain().contacts().len();
    let search = BestFirst::new(graph, &limits, Costs::default());
    let started = Event::Started {
        interfaces: scene.interfaces.len(),
        contacts,
        max_phases: search.max_phases(),
        skeleton,
    };
    let settings = settings(scene, request)?;
    let mut run = Run {
        scene,
        request,
        settings: &settings,
        planner: &planner,
        checks: Checks::new(&planner, &settings, begin, request.time_limit),
        begin,
        stopped: !observe(&started),
        observe,
        attempts: vec![],
        best: None,
        relatives: vec![],
    };
    let ended = run.search(search);
    let best = run.best.take().map(|(motion, sequence)| {
        let phases = run.phases(&sequence);
        let (mut motion, refined) = refine::refine(
            run.planner,
            &phases,
            run.settings,
            motion,
            (request, begin),
            run.observe,
        );
        let found = Found::of(scene, &sequence.labels, &mut motion, refined);
        (found, motion.feasible)
    });
    Ok(Outcome {
        feasible: best.as_ref().is_some_and(|b| b.1),
        best: best.map(|b| b.0),
        attempts: run.attempts,
        impossible: run.checks.impossible(),
        ended,
        seconds: begin.elapsed().as_secs_f64(),
    })
}

/// The problem's options for a request.
pub(crate) fn settings(scene: &Scene, request: &Request) -> Result<Settings, Error> {
    if request.preset == Preset::Paper && request.integrator != Integrator::Euler {
        return Err(Error::PaperIntegrator);
    }
    Ok(Settings {
        integrator: request.integrator,
        ..Settings::new(request.preset, &scene.optimiser)
    })
}

struct Run<'a> {
    scene: &'a Scene,
    request: &'a Request,
    settings: &'a Settings,
    planner: &'a Planner<'a>,
    checks: Checks<'a>,
    begin: Instant,
    stopped: bool,
    observe: &'a mut dyn FnMut(&Event) -> bool,
    attempts: Vec<Attempt>,
    best: Option<(Motion, Sequence)>,
    /// What the motions found so far leave to others.
    relatives: Vec<Relative>,
}

impl Run<'_> {
    /// Tries sequences until enough plans are found; says why it ended.
    fn search(&mut self, mut search: BestFirst) -> String {
        let (mut feasible, mut optimised) = (0, 0);
        for number in 1.. {
            if self.stopped {
                return "stopped by the caller".into();
            }
            if feasible >= self.request.solutions {
                return format!("{feasible} plan(s) found, as asked for");
            }
            if optimised >= self.request.max_optimised {
                return format!("{optimised} sequences optimised, the limit");
            }
            let Some(sequence) = search.next(&mut self.checks) else {
                return match search.status() {
                    symbolic::Status::Stopped => {
                        format!("time limit of {} s", self.request.time_limit)
                    }
                    symbolic::Status::Full => "memory limit of the sequence search".into(),
                    _ => format!(
                        "all contact sequences of at most {} phases were tried",
                        search.max_phases()
                    ),
                };
            };
            let attempt = self.attempt(number, &sequence, &mut search);
            feasible += usize::from(attempt.reached == Reached::Feasible);
            optimised += usize::from(attempt.reached != Reached::Keyframes);
            self.attempts.push(attempt);
            if self.begin.elapsed().as_secs_f64() > self.request.time_limit {
                return format!("time limit of {} s", self.request.time_limit);
            }
        }
        unreachable!("the loop has no end of its own")
    }

    fn attempt(&mut self, number: usize, sequence: &Sequence, search: &mut BestFirst) -> Attempt {
        let start = Instant::now();
        let labels = sequence.labels.clone();
        self.tell(&Event::Sequence {
            number,
            labels: labels.clone(),
        });
        let phases = self.phases(sequence);
        let keyframes = self.planner.keyframes(&phases, self.settings);
        let mut attempt = Attempt {
            number,
            labels,
            reached: Reached::Keyframes,
            reason: keyframes
                .worst
                .as_ref()
                .filter(|_| !keyframes.possible)
                .map(|w| summary::words(self.scene, w)),
            cost: None,
            iterations: 0,
            seconds: 0.0,
        };
        let (possible, reason) = (keyframes.possible, attempt.reason.clone());
        self.tell(&Event::Keyframes {
            number,
            possible,
            reason,
        });
        if !keyframes.possible {
            self.reject_prefix(sequence, &phases, search);
        } else if !self.stopped {
            self.optimise(number, sequence, &phases, &keyframes, &mut attempt);
        }
        attempt.seconds = start.elapsed().as_secs_f64();
        attempt
    }

    fn optimise(
        &mut self,
        number: usize,
        sequence: &Sequence,
        phases: &[Phase],
        keyframes: &Keyframes,
        attempt: &mut Attempt,
    ) {
        let (time_limit, begin) = (self.request.time_limit, self.begin);
        let (observe, stopped) = (&mut self.observe, &mut self.stopped);
        let mut watch = |i: &Iteration| {
            let event = Event::Iteration {
                number,
                iteration: i.number,
                violation: i.violation,
                objective: i.objective,
            };
            *stopped |= !observe(&event);
            !*stopped && begin.elapsed().as_secs_f64() <= time_limit
        };
        let (planner, settings) = (self.planner, self.settings);
        let relative = nearest(&self.relatives, phases);
        let warm = relative.and_then(|r| planner.motion_from(phases, settings, r, &mut watch));
        let motion =
            warm.unwrap_or_else(|| planner.motion(phases, settings, &keyframes.nodes, &mut watch));
        if motion.feasible {
            self.relatives.push(motion.relative());
        }
        attempt.reached = if motion.feasible {
            Reached::Feasible
        } else {
            Reached::Optimised
        };
        attempt.cost = Some(motion.report.objective);
        attempt.iterations = motion.iterations;
        attempt.reason = summary::resistance(self.scene, &motion);
        let (feasible, cost, reason) = (
            motion.feasible,
            motion.report.objective,
            attempt.reason.clone(),
        );
        self.tell(&Event::Optimised {
            number,
            feasible,
            cost,
            reason,
        });
        if self
            .best
            .as_ref()
            .is_none_or(|(best, _)| better(&motion, best))
        {
            self.best = Some((motion, sequence.clone()));
        }
    }

    /// Finds the shortest impossible beginning, so that nothing that starts with it is tried again. If the contacts
    /// alone are possible, only the goal is out of reach, and longer sequences may still get there.
    fn reject_prefix(&mut self, sequence: &Sequence, phases: &[Phase], search: &mut BestFirst) {
        if self.checks.prefix_possible(phases) {
            return;
        }
        let (mut possible, mut impossible) = (0, phases.len());
        while impossible - possible > 1 {
            let middle = usize::midpoint(possible, impossible);
            if self.checks.prefix_possible(&phases[..middle]) {
                possible = middle;
            } else {
                impossible = middle;
            }
        }
        let prefix = sequence.states[..impossible].to_vec();
        search.reject(
            Rejected::Prefix(prefix),
            "no keyframes satisfy these contacts",
        );
    }

    fn phases(&self, sequence: &Sequence) -> Vec<Phase> {
        let steps = self.scene.optimiser.steps;
        sequence
            .states
            .iter()
            .map(|state| Phase {
                state: state.clone(),
                steps,
            })
            .collect()
    }

    fn tell(&mut self, event: &Event) {
        self.stopped |= !(self.observe)(event);
    }
}

/// The relative that shares most phases, the first of these, if it differs in the last few only: a start that shares less
/// saved nothing (benches/runs/2026-11-21-keyframes.md).
fn nearest<'a>(relatives: &'a [Relative], phases: &[Phase]) -> Option<&'a Relative> {
    let shared = |r: &Relative| r.shared_phases(phases);
    let most = relatives.iter().map(shared).max()?;
    let near = relatives.iter().find(|r| shared(r) == most);
    near.filter(|_| most + DIFFERENT_AT_END >= phases.len())
}

/// Feasible before infeasible; then by cost, or by violation.
fn better(a: &Motion, b: &Motion) -> bool {
    match (a.feasible, b.feasible) {
        (true, true) => a.report.objective < b.report.objective,
        (false, false) => a.report.violation < b.report.violation,
        (a, _) => a,
    }
}

fn goal_text(scene: &Scene) -> String {
    let pairs: Vec<_> = scene
        .goal_contacts
        .iter()
        .map(|g| {
            format!(
                "{} on {}",
                scene.interfaces[g.a.0].name, scene.interfaces[g.b.0].name
            )
        })
        .collect();
    pairs.join(", ")
}

/// Refuses a start in which bodies that do not touch overlap.
pub(crate) fn check_start(scene: &Scene, planner: &Planner<'_>) -> Result<(), Error> {
    let model = &planner.system.model;
    let mut kinematics = multibody::Kinematics::new(model);
    kinematics.update(model, &planner.system.start(scene));
    let touches = ocp::collision::CollisionModel::start_touches(scene, &planner.system);
    let deepest = planner
        .collisions
        .deepest(&kinematics, &|a, b| touches.contains(&(a, b)));
    match deepest {
        Some((depth, a, b)) if depth > START_OVERLAP => Err(Error::StartInCollision {
            a: summary::body_name(scene, &planner.system, Ok(a)),
            b: summary::body_name(scene, &planner.system, b),
            depth_mm: depth * 1e3,
        }),
        _ => Ok(()),
    }
}
