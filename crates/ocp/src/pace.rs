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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Preset;
    use scene::Scene;
    use symbolic::ContactState;

    #[test]
    fn far_apart_keyframes_get_more_intervals_and_at_most_twice_as_many() {
        let scene = Scene::builtin("pick-place").expect("a built-in scene");
        let planner = Planner::new(&scene).expect("a model");
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let phase = Phase {
            state: ContactState::default(),
            steps: 8,
        };
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
}
