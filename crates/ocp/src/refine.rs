//! A motion again on a finer grid, from the coarse solution.
//!
//! The coarse motion is for search: explicit Euler with steps of a tenth of a second moves the joints by what a robot
//! cannot follow. The refined one has steps of at most [`Refinement::max_step`] and holds the acceleration within each.

use crate::collision::Crossings;
use crate::guess::Curve;
use crate::motion::{Motion, Planner, near};
use crate::point::Point;
use crate::program::{Grid, Phase};
use crate::rounds::First;
use crate::settings::{Ending, Integrator, Settings, Sticking, Weights};
use solver::Iteration;

/// What the finer grid is like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refinement {
    /// How states follow from one another.
    pub integrator: Integrator,
    /// Longest interval [s].
    pub max_step: f64,
}

impl Default for Refinement {
    fn default() -> Self {
        Self {
            integrator: Integrator::ConstantAcceleration,
            max_step: 0.02,
        }
    }
}

impl Refinement {
    /// The options of the finer grid, from those of the coarse motion.
    pub fn settings(&self, coarse: &Settings) -> Settings {
        Settings {
            integrator: self.integrator,
            sticking: Sticking::Displacement,
            max_step: self.max_step,
            between: true,
            ending: Ending::Good,
            weights: Weights {
                acceleration: SMOOTHER * coarse.weights.acceleration,
                ..coarse.weights.clone()
            },
            ..coarse.clone()
        }
    }
}

/// Factor by which a phase may grow on the finer grid, and the same for one that is as long as its intervals may be.
const ROOM: f64 = 1.1;
const MORE_ROOM: f64 = 1.7;
/// Share of what its intervals allow from which on a phase is kept short by them.
const KEPT_SHORT: f64 = 0.95;

/// Weight of the accelerations on the finer grid in that of the coarse one: coarse intervals spread every change of speed over a
/// tenth of a second or more, finer ones must be asked to. With the weight of the velocities as it is, speeds change within
/// √(10 · 10⁻³ / 0.05) = 0.45 s.
const SMOOTHER: f64 = 10.0;

impl Planner<'_> {
    /// The same contacts and nearly the same motion on a finer grid.
    ///
    /// `settings` are those of the coarse motion; the preset must be [`crate::Preset::Default`] unless the integrator is
    /// explicit Euler.
    pub fn refine(
        &self,
        phases: &[Phase],
        settings: &Settings,
        coarse: &Motion,
        refinement: Refinement,
        observe: &mut dyn FnMut(&Iteration) -> bool,
    ) -> Motion {
        let program = &coarse.trajectory.program;
        let durations = &coarse.point.durations;
        let finer: Vec<Phase> = phases
            .iter()
            .zip(
                durations
                    .iter()
                    .zip(program.steps.iter().zip(&program.longest)),
            )
            .map(|(phase, (&duration, (&steps, &allowed)))| {
                let short = duration > KEPT_SHORT * program.settings.max_step * steps as f64;
                let step = refinement.max_step.min(allowed / steps as f64);
                let room = if short { MORE_ROOM } else { ROOM };
                let longest = (room * duration).min(settings.max_duration.max(duration));
                Phase {
                    state: phase.state.clone(),
                    steps: steps.max((longest / step).ceil() as usize),
                }
            })
            .collect();
        let mut times = vec![0.0];
        for (duration, &steps) in durations.iter().zip(&program.steps) {
            let start = times[times.len() - 1];
            times.extend((1..=steps).map(|i| start + duration * i as f64 / steps as f64));
        }
        let point = &coarse.point;
        let curve = Curve::new(&self.system, &times, &point.nodes, &point.velocities);
        let (mut nodes, mut velocities) = (vec![], vec![]);
        let mut wrenches = vec![];
        let mut start = 0.0;
        for (phase, duration) in finer.iter().zip(durations) {
            for i in 0..phase.steps {
                let time = |i: f64| start + duration * i / phase.steps as f64;
                let (q, v) = curve.at(time(i as f64));
                nodes.push(q);
                velocities.push(v);
                let interval = times.partition_point(|&t| t <= time(i as f64 + 0.5)) - 1;
                wrenches.push(coarse.point.wrenches[interval].clone());
            }
            start += duration;
        }
        let rest = coarse.point.nodes[coarse.point.nodes.len() - 1].clone();
        let n = nodes.len();
        nodes[n - 1].copy_from_slice(&rest);
        nodes.push(rest);
        velocities.push(vec![]);
        for t in [0, n - 1, n] {
            velocities[t] = vec![0.0; self.system.model.nv];
        }
        let settings = refinement.settings(settings);
        let none = Crossings::new();
        let program = self.program(&finer, &settings, Grid::Motion, near(&nodes, &none));
        if !program.has_velocities() {
            let first = nodes[0].clone();
            nodes[1].copy_from_slice(&first);
            velocities.clear();
        }
        let point = Point {
            nodes,
            wrenches,
            velocities,
            durations: durations.clone(),
        };
        let first = if coarse.trajectory.program.has_velocities() {
            First::finest()
        } else {
            First::finer()
        };
        self.optimise(&finer, program, point, first, observe)
    }
}
