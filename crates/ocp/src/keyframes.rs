//! Keyframes: are there configurations that satisfy the contacts? Three checks, each a relaxation of the next.
//!
//! - [`Planner::state`]: one configuration with the contacts of a state, wherever objects and contacts are.
//! - [`Planner::transition`]: one configuration with the contacts of two neighbouring states. At the boundary of two phases
//!   both hold, and what holds there holds before and after it: a transition is as possible as the union of its states.
//! - [`Planner::keyframes`]: one configuration per phase boundary of a sequence from the start, contact places and object
//!   poses tied across phases, goal regions at the end; [`Planner::keyframes_of_prefix`] without the goal.
//!
//! Only geometry, joint limits and clearances (those that a motion keeps) count, no statics, so that what a motion can do passes. A state's configuration
//! may be any of its phase, next to any other state: bodies that some contact of the scene could bring together need no
//! clearance in it.
//!
//! Source: formulation, section 5.

mod ask;

use crate::collision::Watched;
use crate::guess;
use crate::motion::Planner;
use crate::program::{Grid, Phase, goal_body};
use crate::relative::Body;
use crate::resistance::{Pull, Worst};
use crate::settings::{Arrangement, Settings};
use crate::state_guess;
use crate::ways::Ways;
pub(crate) use ask::Ask;
use ask::less_violated;
use multibody::Kinematics;
use nalgebra::Vector2;
use solver::Report;
use spatial::Pose;
use symbolic::ContactState;

/// Distance below which pairs get a row once one is violated [m].
const NEAR: f64 = 0.02;
/// Violation (m, rad) from which no other guess is tried: out of reach, not caught in a local minimum
/// (benches/runs/2026-11-21-tree-search.md).
const HOPELESS: f64 = 0.1;
/// How far parts of the robot are taken to reach from where they are in the start posture [m].
const REACH: f64 = 0.5;
/// How far above its place an object is out of the way [m].
const ELSEWHERE: f64 = 3.0;
/// Phases of a beginning up to which the slow attempts are made too.
const CAREFUL_PHASES: usize = 8;
/// Largest violation of a keyframe set that still counts as possible, in the rows' own units (m, rad).
pub(crate) const KEYFRAME_TOLERANCE: f64 = 1e-4;

/// Keyframes of a sequence.
#[derive(Debug, Clone)]
pub struct Keyframes {
    /// One configuration per phase boundary.
    pub nodes: Vec<Vec<f64>>,
    /// True if all rows hold.
    pub possible: bool,
    /// What is violated most.
    pub worst: Option<Worst>,
    /// If they are impossible: what is violated, the worst of every constraint.
    pub violated: Vec<Worst>,
    /// If they are impossible: what pulls.
    pub pulls: Vec<Pull>,
    /// The solver's report of the last round.
    pub report: Report,
    /// Iterations of all rounds.
    pub iterations: usize,
}

impl Planner<'_> {
    /// One configuration that satisfies the contacts of a state. Its nodes: what the solver started from, and the result.
    pub fn state(&self, state: &ContactState, settings: &Settings) -> Keyframes {
        let phases = [Phase {
            state: state.clone(),
            steps: 1,
        }];
        let ask = Ask::new(self, &phases, settings, Grid::State);
        let solve = |from: &Vec<f64>| ask.solve(vec![from.clone(); 2], Watched::new()).0;
        let guesses = state_guess::states(self.scene, &self.system, state);
        let mut best = solve(&guesses[0]);
        for from in &guesses[1..] {
            if !best.possible {
                best = less_violated(best, solve(from));
            }
        }
        if best.possible {
            return best;
        }
        let before = state_guess::before_walls(self.scene, &self.system, state);
        let before = before.into_iter().map(|from| vec![from; 2]);
        ask.carefully(best, true, before.collect())
    }

    /// One configuration that satisfies the contacts of two neighbouring states.
    pub fn transition(
        &self,
        before: &ContactState,
        after: &ContactState,
        settings: &Settings,
    ) -> Keyframes {
        let both = before.iter().chain(after.iter()).collect();
        self.state(&both, settings)
    }

    /// One configuration per phase boundary that satisfies all contacts and clearances, no statics.
    ///
    /// With [`Planner::keyframes_of_prefix`] the goal regions, which bind the end only, are left out.
    pub fn keyframes(&self, phases: &[Phase], settings: &Settings) -> Keyframes {
        Ask::new(self, phases, settings, Grid::Keyframes).answer()
    }

    /// The same from a guess from the sequence alone, which is the only one that is tried.
    pub fn keyframes_at_once(&self, phases: &[Phase], settings: &Settings) -> Keyframes {
        let ask = Ask::new(self, phases, settings, Grid::Keyframes);
        let guess = ask.guess();
        ask.solve(guess, Watched::new()).0
    }

    /// Keyframes from those of the first phases, `known`: where the rest begins from the end of these. `open` leaves out the
    /// goal regions. Only this guess is tried.
    pub fn keyframes_after(
        &self,
        known: &[Vec<f64>],
        phases: &[Phase],
        settings: &Settings,
        open: bool,
    ) -> Keyframes {
        let mut guess = self.guess_after(known, phases, settings.arrangement);
        if !open {
            self.lead_to_goal(&mut guess, phases, known.len().saturating_sub(1));
        }
        self.keyframes_near(&guess, phases, settings, open)
    }

    /// A guess of all keyframes from those of the first phases, which may be none: the robot moves on from there as it would from the
    /// start, objects are where these have them unless they make room for what comes ([`Arrangement::LaterBeside`]).
    pub fn guess_after(
        &self,
        known: &[Vec<f64>],
        phases: &[Phase],
        arrangement: Arrangement,
    ) -> Vec<Vec<f64>> {
        let (system, model) = (&self.system, &self.system.model);
        let mut guess = guess::after(self.scene, system, phases, arrangement, known);
        let Some(last) = known.len().checked_sub(1) else {
            self.ways_of(phases).bend(&mut guess, 0);
            return guess;
        };
        let robot = 0..system.robot_nq;
        let before = guess[last].clone();
        let base = |q: &[f64]| q.first_chunk::<7>().map(Pose::from_xyzquat);
        for (k, q) in guess.iter_mut().enumerate() {
            let moved = model.difference(&before, q);
            let mut further = model.integrate(&known[last], &moved);
            // Whichever way the robot faces by then, where it goes is in the same direction.
            if let (Some(from), Some(before), Some(to)) =
                (base(&known[last]), base(&before), base(q))
            {
                let origin = from.origin() + (to.origin() - before.origin());
                let rotation = to.rotation() * before.rotation().transpose() * from.rotation();
                let there = Pose::from_parts(rotation, origin);
                further[..7].copy_from_slice(&there.to_xyzquat());
            }
            let now = known.get(k).unwrap_or(&further);
            q[robot.clone()].copy_from_slice(&now[robot.clone()]);
        }
        self.ways_of(phases).bend(&mut guess, last);
        guess
    }

    /// Ways for a sequence.
    pub fn ways_of(&self, phases: &[Phase]) -> Ways {
        self.ways.of(self.scene, phases)
    }

    /// Leads the base of a guess to where regions of the goal want it, or near enough to where they want other parts of the robot,
    /// evenly from configuration number `from` on.
    fn lead_to_goal(&self, guess: &mut [Vec<f64>], phases: &[Phase], from: usize) {
        let (scene, model) = (self.scene, &self.system.model);
        let last = guess.len() - 1;
        let mut kinematics = Kinematics::new(model);
        kinematics.update(model, &guess[last]);
        let mut more = Vector2::zeros();
        for region in &scene.goal_regions {
            let carrier = goal_body(scene, &self.system, &region.body);
            let Some((joint, frame)) = carrier.and_then(|c| match c.body {
                Body::Joint(joint) if joint < self.system.n_robot_joints => {
                    Some((joint, c.body_from_frame))
                }
                _ => None,
            }) else {
                continue;
            };
            let place = (kinematics.world_from_joint[joint] * frame).origin().xy() + more;
            let way = place.sup(&region.lower.xy()).inf(&region.upper.xy()) - place;
            let reach = if joint == 0 { 0.0 } else { REACH };
            more += way * (1.0 - reach / way.norm().max(reach + f64::MIN_POSITIVE)).max(0.0);
        }
        for k in from + 1..=last {
            let share = (k - from) as f64 / (last - from) as f64;
            for i in 0..2 {
                guess[k][i] += share * more[i];
            }
        }
        self.ways_of(phases).bend(guess, from);
    }

    /// Keyframes of phases whose last state the robot enters from the air, wherever it then is, and whatever objects are `elsewhere`,
    /// which nothing holds, with all clearances: the goal aside.
    pub fn keyframes_anywhere(
        &self,
        phases: &[Phase],
        settings: &Settings,
        elsewhere: &[usize],
    ) -> Keyframes {
        let (scene, system) = (self.scene, &self.system);
        let ask = Ask::new(self, phases, settings, Grid::OpenKeyframes);
        let start = system.start(scene);
        let guess = |from: Vec<f64>| {
            let mut there = start.clone();
            there[..system.robot_nq].copy_from_slice(&from[..system.robot_nq]);
            for &o in elsewhere {
                there[system.object_q(o) + 2] += ELSEWHERE;
            }
            let mut nodes = vec![start.clone(); phases.len() + 1];
            let n = nodes.len();
            nodes[n - 2..].fill(there);
            nodes
        };
        let state = &phases[phases.len() - 1].state;
        let guesses: Vec<_> = state_guess::states(scene, system, state)
            .into_iter()
            .map(guess)
            .collect();
        let solve = |nodes: &Vec<Vec<f64>>| ask.solve_apart(nodes.clone(), ask.near(nodes, NEAR));
        let mut best = solve(&guesses[0]);
        for nodes in &guesses[1..] {
            if !best.possible {
                best = less_violated(best, solve(nodes));
            }
        }
        best
    }

    /// Keyframes from a guess of all configurations; `open` leaves out the goal regions. Only this guess is tried.
    pub fn keyframes_near(
        &self,
        nodes: &[Vec<f64>],
        phases: &[Phase],
        settings: &Settings,
        open: bool,
    ) -> Keyframes {
        let grid = if open {
            Grid::OpenKeyframes
        } else {
            Grid::Keyframes
        };
        let ask = Ask::new(self, phases, settings, grid);
        let near = ask.near(nodes, NEAR);
        ask.further().solve(nodes.to_vec(), near).0
    }

    /// Keyframes of the whole sequence near or at configurations that satisfy its contacts; `None` if that fails.
    pub fn keyframes_at(
        &self,
        nodes: &[Vec<f64>],
        phases: &[Phase],
        settings: &Settings,
    ) -> Option<Keyframes> {
        Ask::new(self, phases, settings, Grid::Keyframes).answer_near(nodes.to_vec())
    }

    /// Keyframes of the beginning of a sequence: the goal need not be reached yet. Long ones without the last, slow attempts,
    /// since a search comes across beginnings by the hundred.
    pub fn keyframes_of_prefix(&self, phases: &[Phase], settings: &Settings) -> Keyframes {
        let ask = Ask::new(self, phases, settings, Grid::OpenKeyframes);
        if phases.len() <= CAREFUL_PHASES {
            ask.answer()
        } else {
            ask.attempts().0
        }
    }

    /// The same where keyframes of the first phases are known. `another` guess of all is asked for if what follows from these
    /// fails.
    pub fn keyframes_of_longer(
        &self,
        known: &[Vec<f64>],
        phases: &[Phase],
        settings: &Settings,
        another: &mut dyn FnMut() -> Option<Vec<Vec<f64>>>,
    ) -> Keyframes {
        Ask::new(self, phases, settings, Grid::OpenKeyframes).answer_after(known, another)
    }
}

impl Keyframes {
    /// True if a contact or a goal is far out of reach. A clearance that is far off may be a matter of the guess: something
    /// stands on the wrong side.
    pub fn is_hopeless(&self) -> bool {
        let in_the_way = |w: &Worst| w.label.category == "clearance";
        let worst = self.worst.as_ref().filter(|w| !in_the_way(w));
        worst.is_some() && self.report.violation > HOPELESS
    }
}
