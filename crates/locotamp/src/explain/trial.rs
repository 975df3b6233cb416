//! Solves of changed scenes, exactly as a user would solve them.

use super::Case;
use crate::api::{Event, Request};
use crate::refine;
use crate::search;
use crate::solve::keyframes;
use crate::start::check_start;
use ocp::{Ending, Keyframes, Motion, Phase, Planner};
use scene::Scene;
use solver::Iteration;
use std::time::Instant;

/// Most intervals per phase of a trial that only guides the search for a value.
const COARSE_STEPS: usize = 6;
/// Most iterations of such a trial: those that succeed take 20 to 140, rounds of repair included.
const COARSE_ITERATIONS: usize = 200;

/// Most trials where only the finer grid has no motion: each takes as long as solving anew.
const MOST_HELD: usize = 16;

/// Runs trials and counts them.
pub(super) struct Trials<'a> {
    phases: &'a [Phase],
    request: &'a Request,
    is_quick: bool,
    /// Only the grid on which a motion must hold has none: every trial of a motion is of full effort.
    must_hold: bool,
    begin: Instant,
    observe: &'a mut dyn FnMut(&Event) -> bool,
    /// What is being tried, for the observer.
    pub doing: String,
    /// Number of trials so far.
    pub solves: usize,
    /// True once the observer or the time limit has ended it.
    pub stopped: bool,
}

/// How much a trial solves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Effort {
    /// Keyframes only.
    Keyframes,
    /// Keyframes and a motion with few intervals per phase.
    Coarse,
    /// Keyframes and motion as the sequence says, on the grid on which it must hold if it is to be refined.
    Full,
}

/// What a trial that succeeded found: a motion, if it was asked for more than keyframes.
pub(super) struct Success(pub Option<Box<Motion>>);

impl<'a> Trials<'a> {
    pub fn new(
        case: &Case<'a>,
        begin: Instant,
        observe: &'a mut dyn FnMut(&Event) -> bool,
    ) -> Self {
        Self {
            phases: case.phases,
            request: case.request,
            is_quick: case.is_quick,
            must_hold: case.falls_short,
            begin,
            observe,
            doing: String::new(),
            solves: 0,
            stopped: false,
        }
    }

    /// True if there are few trials, so that none may be wasted.
    pub fn are_few(&self) -> bool {
        self.must_hold
    }

    /// Is the sequence feasible in this scene.
    pub fn succeeds(&mut self, scene: &Scene, effort: Effort) -> bool {
        self.solve(scene, effort, None).is_some()
    }

    /// Solves the sequence in this scene; `None` if it is infeasible. Coarse solves may start near a motion that is known from
    /// a scene that differs in numbers.
    pub fn solve(
        &mut self,
        scene: &Scene,
        effort: Effort,
        near: Option<&Motion>,
    ) -> Option<Success> {
        let phases = self.phases;
        self.solve_phases(scene, phases, effort, near)
    }

    /// Is the beginning of `count` phases feasible, whatever the goal.
    pub fn prefix_succeeds(&mut self, scene: &Scene, count: usize, effort: Effort) -> bool {
        let phases = &self.phases[..count];
        let mut open = scene.clone();
        open.goal_regions.clear();
        self.solve_phases(&open, phases, effort, None).is_some()
    }

    fn solve_phases(
        &mut self,
        scene: &Scene,
        phases: &[Phase],
        effort: Effort,
        near: Option<&Motion>,
    ) -> Option<Success> {
        self.stopped |= self.must_hold && self.solves == MOST_HELD;
        if !self.go_on(0) {
            return None;
        }
        self.solves += 1;
        let (effort, near) = match effort {
            Effort::Coarse if self.must_hold => (Effort::Full, None),
            _ => (effort, near),
        };
        let planner = Planner::new(scene).ok()?;
        check_start(scene, &planner).ok()?;
        let mut settings = search::settings_of_one(scene, self.request).ok()?;
        settings.ending = Ending::Exact;
        settings.hurries = true;
        let mut phases = phases.to_vec();
        if effort == Effort::Coarse {
            settings.max_iterations = settings.max_iterations.min(COARSE_ITERATIONS);
            // Longer intervals where there are fewer, so that phases may last as long as those of the sequence.
            let most = phases.iter().map(|phase| phase.steps.max(COARSE_STEPS));
            let longer = most.max().unwrap_or(1) as f64 / COARSE_STEPS as f64;
            settings.max_step *= longer;
            settings.push_step *= longer;
            for phase in &mut phases {
                phase.steps = phase.steps.min(COARSE_STEPS);
            }
        }
        let request = self.request;
        let grid = request.refines().filter(|_| effort == Effort::Full);
        let is_quick = self.is_quick;
        let mut go_on = |i: &Iteration| self.go_on(i.number);
        if let Some(near) = near {
            let motion = planner.motion_near(&phases, &settings, near, &mut go_on);
            return motion.feasible.then(|| Success(Some(Box::new(motion))));
        }
        let Keyframes {
            nodes, possible, ..
        } = if is_quick {
            planner.keyframes(&phases, &settings)
        } else {
            keyframes(&planner, &phases, &settings, request)
        };
        if !possible || effort == Effort::Keyframes {
            return possible.then_some(Success(None));
        }
        let mut motion = planner.motion(&phases, &settings, &nodes, &mut go_on);
        if let Some(grid) = grid.filter(|_| motion.feasible) {
            motion = refine::hold(&planner, &phases, &settings, (&motion, grid), &mut go_on);
        }
        motion.feasible.then(|| Success(Some(Box::new(motion))))
    }

    fn go_on(&mut self, iteration: usize) -> bool {
        let event = Event::Explaining {
            doing: self.doing.clone(),
            solves: self.solves,
            iteration,
        };
        self.stopped |= !(self.observe)(&event);
        self.stopped |= self.begin.elapsed().as_secs_f64() > self.request.time_limit;
        !self.stopped
    }
}
