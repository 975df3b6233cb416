//! Scales of rows and costs, and the variables: node increments, bounded by the joints' ranges.

use super::{Builder, Grid, Phase};
use multibody::JointKind;
use solver::ElementStructure;

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

    /// Increments of the free nodes with their bounds, and which velocities of every interval are free.
    pub(super) fn variables(&mut self) {
        let p = &mut self.program;
        let (n, nv) = (p.intervals.len(), p.system.model.nv);
        let motion = p.grid == Grid::Motion;
        let states = p.has_velocities();
        let mut phase_of = Vec::new();
        for (k, &steps) in p.steps.iter().enumerate() {
            phase_of.extend(std::iter::repeat_n(k, steps));
        }
        let s = &mut p.structure;
        // With explicit Euler rest fixes node 1 too.
        let first_free = if motion && !states { 2 } else { 1 };
        let last_free = if motion { n - 1 } else { n };
        for t in first_free..=last_free {
            p.nodes[t].var = Some(s.n_vars);
            for joint in &p.system.model.joints {
                let margin = p
                    .settings
                    .margins
                    .joint_range
                    .min(0.1 * (joint.upper - joint.lower));
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
            s.n_vars += nv;
            if states && t < n - 1 {
                p.nodes[t].velocity_var = Some(s.n_vars);
                for joint in &p.system.model.joints {
                    let limit = joint.velocity_limit * p.settings.margins.velocity;
                    for _ in 0..joint.kind.nv() {
                        s.lower.push(-limit);
                        s.upper.push(limit);
                    }
                }
                s.n_vars += nv;
            }
        }
        if motion {
            p.nodes[n].var = p.nodes[n - 1].var;
        }
        for t in 0..n {
            let i = &mut p.intervals[t];
            i.phase = phase_of[t];
            i.dynamics = motion;
            (i.v, i.v_next) = if motion {
                (t > 0 && t < n - 1, t + 2 < n)
            } else {
                (true, false)
            };
        }
        s.elements = vec![ElementStructure::default(); n];
    }
}
