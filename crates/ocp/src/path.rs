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
use std::collections::{BTreeMap, BTreeSet};

/// Configurations per phase.
const STEPS: usize = 4;
/// Violation from which a path is blocked (m, rad).
const BLOCKED: f64 = 2e-3;
/// How deep bodies are in one another between nodes, beyond what they are there, from which on a path leads through something [m].
const TUNNEL: f64 = 0.03;
/// Share of a path's violation from which a phase is blocked: an end that is not converged leaves a little everywhere.
const SERIOUS: f64 = 0.25;
/// Share of that violation that a path over obstacles may have left to be the better one.
const BETTER: f64 = 0.5;
/// Distance below which the robot is kept out of static bodies at the ends of phases meanwhile [m].
const BESIDE: f64 = 0.2;
/// Rounds of solving with more collision pairs.
const REPAIRS: usize = 3;

/// A path.
struct Path {
    nodes: Vec<Vec<f64>>,
    /// What is left of the violation of its rows, and how deep it leads through something, added up.
    violation: f64,
    /// Phases in which something is in the way.
    blocked: BTreeSet<usize>,
}

impl Path {
    /// The phases in which something is in the way, with their ends.
    fn lifts(&self) -> BTreeMap<usize, [Vec<f64>; 2]> {
        let ends = |&k: &usize| [k, k + 1].map(|end| self.nodes[STEPS * end].clone());
        self.blocked.iter().map(|k| (*k, ends(k))).collect()
    }
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

    /// A path from straight lines between keyframes; where it is blocked, from one that lifts objects and feet high, if that leads to a
    /// better one. What is led straight through something else is not led around it by clearances.
    fn clear_path(&self, coarse: &[Phase], settings: &Settings, nodes: Vec<Vec<f64>>) -> Path {
        let straight = self.path(coarse, settings, nodes);
        if straight.violation <= BLOCKED || straight.blocked.is_empty() {
            return straight;
        }
        let settings = &Settings {
            lifts: straight.lifts(),
            ..settings.clone()
        };
        let mut over = self.over(coarse, settings, straight.nodes.clone());
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

    /// Configurations that lift objects and feet high, whatever is in the way but for what is near to where these are put down.
    fn over(&self, coarse: &[Phase], settings: &Settings, nodes: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        let mut at_ends = Watched::new();
        let (scene, collisions) = (self.scene, &self.collisions);
        collisions.watch_objects(scene, &self.system, coarse, &mut at_ends);
        at_ends = at_ends.iter().map(|&(k, row)| (STEPS * k, row)).collect();
        let is_end: Vec<bool> = (0..nodes.len()).map(|t| t % STEPS == 0).collect();
        let without = self.program(coarse, settings, Grid::Path, Clearances::Watched(&at_ends));
        let here = (&is_end[..], BESIDE);
        collisions.watch_static(&without, scene, coarse, &nodes, here, &mut at_ends);
        let program = self.program(coarse, settings, Grid::Path, Clearances::Watched(&at_ends));
        let point = guess::point(&program, self.scene, nodes);
        solve(program, point).0.nodes
    }

    /// Blocks a path where it leads through something between its nodes, which clearances at these do not see.
    fn look_for_tunnels(&self, program: &Program, coarse: &[Phase], path: &mut Path) {
        let mut crossings = Crossings::new();
        let collisions = &self.collisions;
        collisions.find_crossings(program, self.scene, coarse, &path.nodes, &mut crossings);
        for ((interval, ..), found) in &crossings.ways {
            let depth = found.iter().map(|c| c.depth).fold(0.0, f64::max);
            if depth > TUNNEL {
                path.violation += depth;
                path.blocked.insert(interval / STEPS);
            }
        }
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
                let blocked = violations(judged, report, least);
                let mut path = Path {
                    violation: report.violation,
                    blocked: blocked.iter().map(|w| w.phase).collect(),
                    nodes: point.nodes,
                };
                self.look_for_tunnels(&program, coarse, &mut path);
                return path;
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
    use crate::collision::samples::{self, Sequence};
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

    #[test]
    fn a_foot_goes_over_a_hurdle_that_no_node_is_in() {
        let scene = samples::scene(
            r#"
            [[static]]
            name = "hurdle"
            size = [0.06, 1.6, 0.2]
            position = [0.25, 0.0, 0.1]
            [[static]]
            name = "board"
            size = [0.6, 1.6, 0.02]
            position = [0.65, 0.0, 0.01]
            "#,
        );
        let stride = r#"
            steps = 4
            [[phase]]
            contacts = [["left_foot", "ground_top"], ["right_foot", "ground_top"]]
            [[phase]]
            contacts = [["left_foot", "ground_top"]]
            [[phase]]
            contacts = [["left_foot", "ground_top"], ["right_foot", "board_top"]]
            "#;
        let Sequence { scene, phases } = Sequence::in_scene(scene, stride);
        let planner = Planner::new(&scene).unwrap();
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let keyframes = planner.keyframes(&phases, &settings);
        assert!(keyframes.possible);
        let straight = guess::straight(&planner.system, &keyframes.nodes, STEPS);
        let through = planner.path(&phases, &settings, straight.clone());
        assert!(
            through.violation > TUNNEL && through.blocked == BTreeSet::from([1]),
            "{:.1e} {:?}",
            through.violation,
            through.blocked
        );
        let over = planner.clear_path(&phases, &settings, straight);
        assert!(over.violation <= BLOCKED, "{:.1e}", over.violation);
    }
}
