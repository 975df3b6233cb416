//! A path between keyframes: configurations that keep clear of everything and approach contacts along their normals, no
//! dynamics. It decides on which side of an obstacle a hand passes, which a motion cannot change any more.

use crate::collision::Crossings;
use crate::guess;
use crate::keyframes::KEYFRAME_TOLERANCE;
use crate::motion::{NEW_TOLERANCE, Planner, near, violation_of};
use crate::problem::Trajectory;
use crate::program::{Grid, Phase};
use crate::settings::Settings;
use solver::{InteriorPoint, Options, Problem};

/// Configurations per phase.
const STEPS: usize = 4;
/// Rounds of solving with more collision pairs.
const REPAIRS: usize = 3;

impl Planner<'_> {
    /// Configurations for all nodes of a motion, through a path around obstacles, or through the least violated one if none
    /// is found.
    pub fn guide(
        &self,
        phases: &[Phase],
        settings: &Settings,
        keyframes: &[Vec<f64>],
    ) -> Vec<Vec<f64>> {
        let coarse: Vec<Phase> = phases
            .iter()
            .map(|p| Phase {
                state: p.state.clone(),
                steps: STEPS,
            })
            .collect();
        let nodes = guess::straight(&self.system, keyframes, STEPS);
        let path = self.path(&coarse, settings, nodes);
        let steps: Vec<usize> = phases.iter().map(|p| p.steps).collect();
        guess::interpolate(&self.system, &steps, &path, STEPS)
    }

    /// A path from straight lines between keyframes.
    fn path(&self, coarse: &[Phase], settings: &Settings, nodes: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        let none = Crossings::new();
        let mut program = self.program(coarse, settings, Grid::Path, near(&nodes, &none));
        let mut point = guess::point(&program, self.scene, nodes);
        let options = Options {
            max_iterations: 60,
            stall_iterations: 25, // cheap, and a worse path is expensive
            feasibility_tolerance: 1e-4,
            dual_tolerance: 1e-1,
            complementarity_tolerance: 1e-1,
            min_barrier: 1e-5,
            ..Options::default()
        };
        for _ in 0..=REPAIRS {
            let mut trajectory = Trajectory::new(program);
            let structure = trajectory.structure().clone();
            let report = InteriorPoint::new(&structure).solve(
                &mut trajectory,
                &mut point,
                &options,
                None,
                &mut |_| true,
            );
            program = self.program(coarse, settings, Grid::Path, near(&point.nodes, &none));
            if report.violation > KEYFRAME_TOLERANCE
                || violation_of(&program, &point) <= NEW_TOLERANCE
            {
                break;
            }
        }
        point.nodes
    }
}
