//! More intervals for phases in which keyframes lie far apart.
//!
//! A coarse motion has the same number of intervals in every phase, and none may be longer than
//! [`Settings::max_step`]. That is enough for a step or for a hand that reaches out, not for a squat down to the floor: such a
//! phase gets intervals for the time that its distance takes.

use crate::motion::Planner;
use crate::program::{Phase, flight};
use crate::settings::Settings;

/// Times the duration T at which, at constant speed v, time costs as much as speed: T = ∫ w v² dt = w Δ²/T. A motion that
/// begins and ends at rest is faster half-way, and has accelerations to pay for.
const UNHURRIED: f64 = 2.0;
/// Time for a push or a landing [s].
const PUSH: f64 = 0.6;
/// Most intervals of a phase, in those that it has anyway.
const MOST: usize = 2;

impl Planner<'_> {
    /// The phases with as many intervals as the distances between their keyframes, `nodes[k]` and `nodes[k + 1]` of phase k,
    /// ask for, and no fewer than they have.
    pub fn paced(&self, phases: &[Phase], settings: &Settings, nodes: &[Vec<f64>]) -> Vec<Phase> {
        let beside_flights = flight::beside(&flight::flies(self.scene, phases));
        let pairs = phases.iter().zip(nodes.windows(2));
        let paced = pairs.zip(beside_flights).map(|((phase, ends), hurried)| {
            let seconds = UNHURRIED * self.distance(settings, &ends[0], &ends[1]).sqrt();
            let intervals = (seconds.min(settings.max_duration) / settings.max_step).ceil();
            let push = (PUSH / settings.push_step).ceil();
            let intervals = if hurried {
                intervals.max(push)
            } else {
                intervals
            };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::samples::Sequence;
    use crate::settings::Preset;

    #[test]
    fn far_apart_keyframes_get_more_intervals_and_at_most_twice_as_many() {
        let Sequence { scene, mut phases } = Sequence::with_steps("flat/stand.toml", 8);
        let planner = Planner::new(&scene).expect("a model");
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let phase = phases.swap_remove(0);
        let start = planner.system.start(&scene);
        let steps = |settings: &Settings, sink: f64| {
            let mut end = start.clone();
            end[2] -= sink; // height of the base
            let nodes = [start.clone(), end];
            planner.paced(std::slice::from_ref(&phase), settings, &nodes)[0].steps
        };
        // 2 √(0.05 Δ²) s in intervals of 0.15 s: 8 of them last for 2.68 m.
        assert_eq!(steps(&settings, 0.0), 8);
        assert_eq!(steps(&settings, 2.6), 8);
        assert_eq!(steps(&settings, 4.0), 12);
        // No more than the longest phase takes, 2 s.
        assert_eq!(steps(&settings, 100.0), 14);
        let patient = Settings {
            max_duration: 60.0,
            ..settings
        };
        assert_eq!(steps(&patient, 100.0), 16);
        let paper = Settings::new(Preset::Paper, &scene.optimiser);
        assert_eq!(
            steps(&paper, 100.0),
            8,
            "intervals may be as long as phases"
        );
    }

    #[test]
    fn pushes_and_landings_get_intervals_for_what_they_take() {
        let Sequence { scene, phases } = Sequence::with_steps("flat/jump.toml", 6);
        let planner = Planner::new(&scene).expect("a model");
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let nodes = vec![planner.system.start(&scene); 4];
        let paced = planner.paced(&phases, &settings, &nodes);
        // 0.6 s in intervals of 0.05 s.
        assert!(paced.iter().all(|phase| phase.steps == 12));
    }
}
