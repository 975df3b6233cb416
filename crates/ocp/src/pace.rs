//! More intervals for phases in which keyframes lie far apart.
//!
//! A coarse motion has the same number of intervals in every phase, and none may be longer than
//! [`Settings::max_step`]. That is enough for a step or for a hand that reaches out, not for a squat down to the floor: such a
//! phase gets intervals for the time that its distance takes.

use crate::motion::Planner;
use crate::program::Phase;
use crate::settings::Settings;

/// Times the duration T at which, at constant speed v, time costs as much as speed: T = ∫ w v² dt = w Δ²/T. A motion that
/// begins and ends at rest is faster half-way, and has accelerations to pay for.
const UNHURRIED: f64 = 2.0;
/// Most intervals of a phase, in those that it has anyway.
const MOST: usize = 2;

impl Planner<'_> {
    /// The phases with as many intervals as the distances between their keyframes, `nodes[k]` and `nodes[k + 1]` of phase k,
    /// ask for, and no fewer than they have.
    pub fn paced(&self, phases: &[Phase], settings: &Settings, nodes: &[Vec<f64>]) -> Vec<Phase> {
        let pairs = phases.iter().zip(nodes.windows(2));
        let paced = pairs.map(|(phase, ends)| {
            let seconds = UNHURRIED * self.distance(settings, &ends[0], &ends[1]).sqrt();
            let intervals = (seconds.min(settings.max_duration) / settings.max_step).ceil();
            Phase {
                state: phase.state.clone(),
                steps: (intervals as usize).clamp(phase.steps, MOST * phase.steps),
            }
        });
        paced.collect()
    }

    /// Σ w Δ² of the robot's velocities between two configurations [s²].
    fn distance(&self, settings: &Settings, from: &[f64], to: &[f64]) -> f64 {
        let moved = self.system.model.difference(from, to);
        let of_robot = moved[..self.system.robot_nv].iter();
        settings.weights.velocity * of_robot.map(|d| d * d).sum::<f64>()
    }
}
