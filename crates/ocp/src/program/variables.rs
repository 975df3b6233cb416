//! Scales of rows and costs, and the variables: node increments, bounded by the joints' ranges.

use super::{Builder, Grid, Phase, Variables};
use multibody::JointKind;
use solver::{ElementStructure, Structure};

/// Time for which a force that counts as one makes a momentum that counts as one [s]: a typical interval.
const MOMENTUM_STEP: f64 = 0.1;

/// Play of a joint that is nearer to its limit at the start than its margin, as a share of that.
const PLAY: f64 = 0.1;

impl Builder<'_> {
    /// Scales of the equations of motion, weights and posture per velocity index.
    pub(super) fn scales(&mut self, phases: &[Phase]) {
        let loads: Vec<f64> = (0..self.scene.objects.len())
            .map(|o| self.heaviest(o, phases))
            .collect();
        let fine = self.program.is_fine();
        let p = &mut self.program;
        let (system, weights) = (&p.system, &p.settings.weights);
        let g = self.scene.gravity.norm();
        let weight = system.robot_mass * g.max(1.0);
        let impulse = if p.momentum { MOMENTUM_STEP } else { 1.0 };
        for (j, joint) in system.model.joints.iter().enumerate() {
            let object = j >= system.n_robot_joints;
            let i = joint.idx_v;
            if joint.kind == JointKind::FreeFlyer {
                let (force, arm) = if object {
                    (loads[j - system.n_robot_joints].max(1.0), 0.1)
                } else {
                    (weight / 3.0 * impulse, 0.3)
                };
                for k in 0..6 {
                    p.dynamics_scale[i + k] = if k < 3 { force } else { force * arm };
                    let [away, around] = if object {
                        [weights.object_acceleration; 2]
                    } else if fine && k < 3 {
                        [weights.base_acceleration, weights.landing_acceleration]
                    } else {
                        [weights.acceleration; 2]
                    };
                    let velocity = if object {
                        weights.object_velocity
                    } else {
                        weights.velocity
                    };
                    p.motion_weights[0][i + k] = (velocity, away);
                    p.motion_weights[1][i + k] = (velocity, around);
                }
            } else {
                p.dynamics_scale[i] = if joint.torque_limit.is_finite() {
                    joint.torque_limit.max(1e-3)
                } else {
                    50.0
                };
                for kind in &mut p.motion_weights {
                    kind[i] = (weights.velocity, weights.acceleration);
                }
                p.home[i] = self.scene.robot.home[i - system.model.joints[0].kind.nv()];
            }
        }
    }

    /// Phases of the intervals, and which velocities of each are free.
    pub(super) fn intervals(&mut self) {
        let p = &mut self.program;
        let n = p.intervals.len();
        let motion = p.grid == Grid::Motion;
        let steps = p.steps.iter().enumerate();
        let phases = steps.flat_map(|(k, &steps)| std::iter::repeat_n(k, steps));
        for (t, (i, phase)) in p.intervals.iter_mut().zip(phases).enumerate() {
            i.phase = phase;
            i.dynamics = motion;
            (i.v, i.v_next) = if motion {
                (t > 0 && t < n - 1, t + 2 < n)
            } else {
                (true, false)
            };
        }
        p.structure.elements = vec![ElementStructure::default(); n];
    }

    /// Increments of the free nodes with their bounds.
    pub(super) fn variables(&mut self) {
        let n = self.program.intervals.len();
        let motion = self.program.grid == Grid::Motion;
        let states = self.program.has_velocities();
        // With explicit Euler rest fixes node 1 too.
        let first_free = if motion && !states { 2 } else { 1 };
        let last_free = if motion { n - 1 } else { n };
        for t in first_free..=last_free {
            self.increments(t);
            if states && t < n - 1 {
                self.velocities(t);
            }
        }
        let p = &mut self.program;
        if motion {
            p.nodes[n].var = p.nodes[n - 1].var.clone();
        }
    }

    /// Increments of a node: of the robot within its joints' ranges, of objects where they can differ from a node before.
    fn increments(&mut self, t: usize) {
        let p = &mut self.program;
        let s = &mut p.structure;
        let robot = s.n_vars;
        for joint in &p.system.robot.joints {
            let range = joint.upper - joint.lower;
            let margin = p.settings.margins.joint_range.min(0.1 * range);
            if joint.kind == JointKind::FreeFlyer {
                s.lower.extend([f64::NEG_INFINITY; 6]);
                s.upper.extend([f64::INFINITY; 6]);
            } else {
                // What is nearer to its limit at the start may stay there, with some play.
                let start = self.scene.start[joint.idx_q];
                let (below, above) = (start - PLAY * margin, start + PLAY * margin);
                let lower = below.max(joint.lower);
                let upper = above.min(joint.upper);
                s.lower.push((joint.lower + margin).min(lower));
                s.upper.push((joint.upper - margin).max(upper));
            }
        }
        s.n_vars += p.system.robot_nv;
        let object_var = |o: usize| {
            let first = p.rests.since(o, t);
            if let Some(first) = first.filter(|&first| first < t) {
                let there = p.nodes[first].var.as_ref();
                return there.and_then(|there| there.objects[o]);
            }
            Some(new_variables(s, 6, f64::INFINITY))
        };
        let objects = (0..self.scene.objects.len()).map(object_var).collect();
        let numbered = self.numbered(robot, objects);
        self.program.nodes[t].var = Some(numbered);
    }

    /// Velocities of a node; none of objects at rest.
    fn velocities(&mut self, t: usize) {
        let p = &mut self.program;
        let s = &mut p.structure;
        let robot = s.n_vars;
        for joint in &p.system.robot.joints {
            let limit = joint.velocity_limit * p.settings.margins.velocity;
            new_variables(s, joint.kind.nv(), limit);
        }
        let object_var = |o: usize| {
            let moves = p.rests.since(o, t).is_none();
            moves.then(|| new_variables(s, 6, f64::INFINITY))
        };
        let objects = (0..self.scene.objects.len()).map(object_var).collect();
        let numbered = self.numbered(robot, objects);
        self.program.nodes[t].velocity_var = Some(numbered);
    }

    /// The variables of the robot and of objects, with the one for what is at rest where that is needed.
    fn numbered(&mut self, robot: usize, objects: Vec<Option<usize>>) -> Variables {
        let p = &mut self.program;
        if p.still_var.is_none() && objects.iter().any(Option::is_none) {
            p.still_var = Some(new_variables(&mut p.structure, 1, 0.0));
        }
        Variables {
            robot,
            n_robot: p.system.robot_nv,
            objects,
        }
    }
}

/// Appends variables with bounds ±`limit`; the first one.
fn new_variables(s: &mut Structure, count: usize, limit: f64) -> usize {
    s.lower.extend(std::iter::repeat_n(-limit, count));
    s.upper.extend(std::iter::repeat_n(limit, count));
    s.n_vars += count;
    s.n_vars - count
}
