//! A path between keyframes: configurations that keep clear of everything and approach contacts along their normals, no
//! dynamics. It decides on which side of an obstacle a hand passes, which a motion cannot change any more.

use crate::carried;
use crate::collision::{Clearances, Crossings, Watched};
use crate::guess;
use crate::keyframes::KEYFRAME_TOLERANCE;
use crate::motion::{NEW_TOLERANCE, Planner, near, report_at};
use crate::point::Point;
use crate::problem::Trajectory;
use crate::program::{Grid, Phase, Program};
use crate::resistance::violations;
use crate::settings::Settings;
use crate::stagnation::Stagnation;
use solver::{Convexification, InteriorPoint, Options, Problem, Report};
use std::collections::BTreeSet;

/// Configurations per phase.
const STEPS: usize = 4;
/// Violation from which a path is blocked (m, rad).
const BLOCKED: f64 = 2e-3;
/// Share of a path's violation from which a phase is blocked: an end that is not converged leaves a little everywhere.
const SERIOUS: f64 = 0.25;
/// Share of that violation that a path over obstacles may have left to be the better one.
const BETTER: f64 = 0.5;
/// Height to which objects are lifted where it is [m].
const HIGH: f64 = 0.3;
/// Rounds of solving with more collision pairs.
const REPAIRS: usize = 3;

/// A path.
struct Path {
    nodes: Vec<Vec<f64>>,
    /// What is left of its rows' violation.
    violation: f64,
    /// Phases in which something is in the way.
    blocked: BTreeSet<usize>,
}

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
        let mut nodes = guess::straight(&self.system, keyframes, STEPS);
        carried::follow(self.scene, &self.system, phases, &mut nodes);
        let path = self.clear_path(&coarse, settings, nodes);
        let steps: Vec<usize> = phases.iter().map(|p| p.steps).collect();
        guess::interpolate(&self.system, &steps, &path.nodes, STEPS)
    }

    /// A path from straight lines between keyframes; where it is blocked, from one that lifts objects high, if that leads to a better
    /// one. What is carried straight through something else is not led around it by clearances.
    fn clear_path(&self, coarse: &[Phase], settings: &Settings, nodes: Vec<Vec<f64>>) -> Path {
        let straight = self.path(coarse, settings, nodes.clone());
        if straight.violation <= BLOCKED || straight.blocked.is_empty() {
            return straight;
        }
        let mut over = self.over(coarse, settings, nodes);
        for (k, nodes) in over.chunks_mut(STEPS).enumerate() {
            // Between the boundaries of phases in which nothing is in the way.
            if !straight.blocked.contains(&k) {
                let known = &straight.nodes[STEPS * k..];
                nodes.clone_from_slice(&known[..nodes.len()]);
            }
        }
        let over = self.path(coarse, settings, over);
        if over.violation < BETTER * straight.violation {
            over
        } else {
            straight
        }
    }

    /// Configurations that lift objects high, whatever is in the way but for other objects where they are put down.
    fn over(&self, coarse: &[Phase], settings: &Settings, nodes: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        let settings = Settings {
            lift: HIGH,
            ..settings.clone()
        };
        let mut at_ends = Watched::new();
        let (scene, system) = (self.scene, &self.system);
        self.collisions
            .watch_objects(scene, system, coarse, &mut at_ends);
        let at_ends = at_ends.iter().map(|&(k, row)| (STEPS * k, row)).collect();
        let clearances = Clearances::Watched(&at_ends);
        let program = self.program(coarse, &settings, Grid::Path, clearances);
        let point = guess::point(&program, self.scene, nodes);
        solve(program, point).0.nodes
    }

    /// A path from a guess.
    fn path(&self, coarse: &[Phase], settings: &Settings, nodes: Vec<Vec<f64>>) -> Path {
        let none = Crossings::new();
        let near_to =
            |nodes: &[Vec<f64>]| self.program(coarse, settings, Grid::Path, near(nodes, &none));
        let mut program = near_to(&nodes);
        let mut point = guess::point(&program, self.scene, nodes);
        for round in 0.. {
            let (report, solved);
            (point, solved, report) = solve(program, point);
            let mut with_more = Trajectory::new(near_to(&point.nodes));
            let seen = report_at(&mut with_more, &point);
            program = with_more.program;
            let (violation, new) = (report.violation, seen.violation);
            if violation > KEYFRAME_TOLERANCE || new <= NEW_TOLERANCE || round == REPAIRS {
                let (judged, report) = if new > violation {
                    (&program, &seen)
                } else {
                    (&solved, &report)
                };
                let least = BLOCKED.max(SERIOUS * report.violation);
                return Path {
                    nodes: point.nodes,
                    violation: report.violation,
                    blocked: (violations(judged, report, least).iter())
                        .map(|w| w.phase)
                        .collect(),
                };
            }
        }
        unreachable!("the loop returns in its last round")
    }
}

/// Solves the problem of a path, until its violation stops falling: straight lines that are blocked mostly took all iterations there
/// are and came to nothing (benches/runs/2026-11-29-paths.md).
fn solve(program: Program, mut point: Point) -> (Point, Program, Report) {
    let options = Options {
        max_iterations: 60,
        feasibility_tolerance: 1e-4,
        dual_tolerance: 1e-1,
        complementarity_tolerance: 1e-1,
        min_barrier: 1e-5,
        convexification: Convexification::Shift,
        ..Options::default()
    };
    let mut trajectory = Trajectory::new(program);
    let structure = trajectory.structure().clone();
    let mut stagnation = Stagnation::default();
    let report = InteriorPoint::new(&structure).solve(
        &mut trajectory,
        &mut point,
        &options,
        None,
        &mut |i| stagnation.goes_on(i),
    );
    (point, trajectory.program, report)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::samples::Sequence;
    use crate::settings::{Arrangement, Preset};

    #[test]
    fn a_box_goes_over_another_that_stands_between_it_and_its_place() {
        let Sequence { scene, phases } = Sequence::with_steps("tasks/beyond.toml", STEPS);
        let planner = Planner::new(&scene).unwrap();
        let settings = Settings {
            arrangement: Arrangement::EarlierBeside,
            ..Settings::new(Preset::Default, &scene.optimiser)
        };
        // With room to spare the boxes would stand so that none need pass the other.
        let mut tight = settings.clone();
        (tight.margins.clearance, tight.margins.self_clearance) = (0.0, 0.0);
        let keyframes = planner.keyframes(&phases, &tight);
        assert!(keyframes.possible);
        let straight = guess::straight(&planner.system, &keyframes.nodes, STEPS);
        // Between keyframes under the table, through which no path leads back up.
        let z = planner.system.object_q(0) + 2;
        let mut under = straight;
        for (t, node) in under.iter_mut().enumerate() {
            if t % STEPS != 0 {
                node[z] -= 0.4;
            }
        }
        let through = planner.path(&phases, &settings, under.clone());
        assert!(
            through.violation > BLOCKED && !through.blocked.is_empty(),
            "{:.1e} {:?}",
            through.violation,
            through.blocked
        );
        let path = planner.clear_path(&phases, &settings, under);
        assert!(path.violation <= BLOCKED, "{:.1e}", path.violation);
        let highest = path.nodes.iter().map(|q| q[z]).fold(0.0, f64::max);
        // The red box is 15 cm high, the green one 20 cm.
        assert!(highest > keyframes.nodes[0][z] + 0.15, "{highest:.3} m");
    }
}
