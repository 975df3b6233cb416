//! Values of the whole program for the solver; derivatives are in [`crate::derivatives`].
//!
//! Per node: kinematics and relative poses. Per interval: differences, inverse dynamics and wrenches. The chain rule
//! from (q, v, a) to the node variables is in [`crate::chain`].

use crate::chain::Motion;
use crate::difference::Difference;
use crate::evaluated::Evaluated;
use crate::objective::CostTerms;
use crate::passages::Passages;
use crate::point::Point;
use crate::program::{Grid, Node, Program, Variables};
use crate::worker::{NearestOfInterval, NodeState, Scratch, Worker};
use multibody::Kinematics;
use nalgebra::Vector6;
use solver::{ElementData, Problem, Structure, threads};

/// The program with its scratch memory, ready for the solver.
pub struct Trajectory {
    /// What it evaluates.
    pub program: Program,
    pub(crate) nodes: Vec<NodeState>,
    pub(crate) differences: Vec<Difference>,
    pub(crate) passages: Passages,
    /// Per interval.
    nearest: Vec<NearestOfInterval>,
    /// First row of each interval among those of all.
    first_row: Vec<usize>,
    /// One per thread.
    pub(crate) scratches: Vec<Scratch>,
    evaluated: Evaluated,
}

impl Trajectory {
    /// Allocates for a program.
    pub fn new(program: Program) -> Self {
        let model = &program.system.model;
        let node_state = |node: &Node| NodeState {
            kinematics: Kinematics::new(model),
            relatives: (node.frames.iter())
                .map(|&f| program.frames[f].relative())
                .collect(),
        };
        let difference = Difference::new(model.nv, &program.system.floating());
        let threads = match program.grid {
            Grid::Motion => program.settings.threads.max(1),
            _ => 1,
        };
        let elements = program.structure.elements.iter();
        let first_row = elements.scan(0, |next, element| {
            let first = *next;
            *next += element.n_rows();
            Some(first)
        });
        Self {
            first_row: first_row.collect(),
            evaluated: Evaluated::new(&program),
            nodes: program.nodes.iter().map(node_state).collect(),
            differences: vec![difference; program.n_intervals()],
            passages: Passages::new(&program),
            nearest: (0..program.n_intervals())
                .map(|t| NearestOfInterval::new(&program, t))
                .collect(),
            scratches: (0..threads).map(|_| Scratch::new(&program)).collect(),
            program,
        }
    }

    /// Does something with every interval, on all threads: its data and what is kept of it.
    fn each_interval(
        &mut self,
        out: &mut [ElementData],
        work: impl Fn(&mut Worker<'_>, usize, Kept<'_>) + Sync,
    ) {
        let (program, nodes) = (&self.program, &self.nodes[..]);
        let (differences, passages) = (&self.differences[..], &self.passages);
        let first_row = &self.first_row[..];
        let size = out.len().div_ceil(self.scratches.len()).max(1);
        let parts = (out.chunks_mut(size))
            .zip(self.nearest.chunks_mut(size))
            .zip(self.evaluated.values.chunks_mut(size));
        let parts = parts.zip(&mut self.scratches).enumerate();
        threads::each(parts, |(part, (((out, nearest), known), scratch))| {
            let mut worker = Worker {
                program,
                nodes,
                differences,
                passages,
                first_row,
                scratch,
            };
            let kept = out.iter_mut().zip(nearest).zip(known);
            for (t, ((data, nearest), known)) in (part * size..).zip(kept) {
                work(&mut worker, t, (data, nearest, known));
            }
        });
    }

    /// The thread at work where there is one only.
    fn worker(&mut self) -> Worker<'_> {
        Worker {
            program: &self.program,
            nodes: &self.nodes,
            differences: &self.differences,
            passages: &self.passages,
            first_row: &self.first_row,
            scratch: &mut self.scratches[0],
        }
    }

    /// Puts objects that are at rest where they are at the first node of their rest.
    pub(crate) fn settle(&self, x: &mut Point) {
        let (system, rests) = (&self.program.system, &self.program.rests);
        for object in 0..system.model.joints.len() - system.n_robot_joints {
            let (q, v) = (system.object_q(object), system.object_v(object));
            for t in 0..x.nodes.len() {
                let Some(first) = rests.since(object, t) else {
                    continue;
                };
                let (before, here) = x.nodes.split_at_mut(t);
                if let Some(there) = before.get(first) {
                    here[0][q..q + 7].copy_from_slice(&there[q..q + 7]);
                }
                if let Some(velocity) = x.velocities.get_mut(t) {
                    velocity[v..v + 6].fill(0.0);
                }
            }
        }
    }

    /// Kinematics, relative poses and differences at a point.
    pub(crate) fn update(&mut self, x: &Point) {
        if self.evaluated.is_at(x) {
            return;
        }
        let program = &self.program;
        let size = self.nodes.len().div_ceil(self.scratches.len()).max(1);
        threads::each(self.nodes.chunks_mut(size).enumerate(), |(part, states)| {
            for (t, state) in (part * size..).zip(states) {
                state.kinematics.update(&program.system.model, &x.nodes[t]);
                let frames = program.nodes[t].frames.iter();
                for (&frame, relative) in frames.zip(&mut state.relatives) {
                    program.frames[frame].update(&state.kinematics, relative);
                }
            }
        });
        for (t, difference) in self.differences.iter_mut().enumerate() {
            program
                .system
                .model
                .difference_into(&x.nodes[t], &x.nodes[t + 1], &mut difference.xi);
        }
        self.passages.update(program, x, &self.differences);
    }

    /// Interval length [s].
    pub fn dt(&self, x: &Point, t: usize) -> f64 {
        interval_length(&self.program, x, t)
    }

    /// Velocity and acceleration of interval `t` at a point, for export.
    pub fn velocity_and_acceleration(&mut self, x: &Point, t: usize) -> (Vec<f64>, Vec<f64>) {
        if t == 0 {
            self.update(x);
        }
        let mut worker = self.worker();
        worker.motion(x, t);
        let Motion { v, a, .. } = &worker.scratch.chain.motion;
        (v.clone(), a.clone())
    }

    /// Generalised forces of interval `t` at a point, for export: base and object rows zero at a solution.
    pub fn torques(&mut self, x: &Point, t: usize) -> Vec<f64> {
        if t == 0 {
            self.update(x);
        }
        let mut worker = self.worker();
        worker.motion(x, t);
        worker.generalised_forces(x, t);
        worker.scratch.tau.clone()
    }

    /// The objective of interval `t` at a point, term by term.
    pub fn cost_terms(&mut self, x: &Point, t: usize) -> CostTerms {
        self.update(x);
        let mut worker = self.worker();
        worker.motion(x, t);
        worker.costs(x, t)
    }
}

/// Of one interval: derivatives, what its values leave for them, objective and values of the last point.
type Kept<'a> = (
    &'a mut ElementData,
    &'a mut NearestOfInterval,
    &'a mut (f64, Vec<f64>),
);

/// Length of interval `t` [s].
pub(crate) fn interval_length(program: &Program, x: &Point, t: usize) -> f64 {
    let phase = program.phase_of(t);
    x.durations[phase] / program.steps[phase] as f64
}

/// Nodes whose terms belong to element `t`: its own, and for keyframes the last one too.
pub(crate) fn element_nodes(program: &Program, t: usize) -> impl Iterator<Item = usize> + use<> {
    let last = program.grid.is_keyframes() && t + 1 == program.n_intervals();
    let own = program.nodes[t].var.is_some();
    (own.then_some(t)).into_iter().chain(last.then_some(t + 1))
}

/// ½ w Σ (q − home)² over the robot's joints; calls `each(i, gradient, curvature)`.
pub(crate) fn posture_cost(
    program: &Program,
    node: usize,
    q: &[f64],
    mut each: impl FnMut(usize, f64, f64),
) -> f64 {
    let w = program.nodes[node].posture;
    let mut cost = 0.0;
    for joint in program.system.actuated() {
        let difference = q[joint.idx_q] - program.home[joint.idx_v];
        cost += 0.5 * w * difference * difference;
        each(joint.idx_v, w * difference, w);
    }
    cost
}

/// Velocity that counts as one.
pub(crate) fn velocity_scale(limit: f64) -> f64 {
    if limit.is_finite() {
        limit.max(1e-3)
    } else {
        10.0
    }
}

/// Wrench in newtons and newton metres, axes of a.
pub fn physical_wrench(force: &crate::program::Force, scaled: &[f64]) -> Vector6<f64> {
    let mut wrench = Vector6::zeros();
    for i in 0..force.n {
        wrench[i] = scaled[force.first + i] * force.scale[i];
    }
    wrench
}

impl Problem for Trajectory {
    type Point = Point;

    fn structure(&self) -> &Structure {
        &self.program.structure
    }

    fn retract(&self, x: &Point, dx: &[f64], step: f64, out: &mut Point) {
        let model = &self.program.system.model;
        for (t, node) in self.program.nodes.iter().enumerate() {
            let change = |of: &Variables, i: usize| of.get(i).map_or(0.0, |v| step * dx[v]);
            match &node.var {
                None => out.nodes[t].copy_from_slice(&x.nodes[t]),
                Some(vars) => {
                    let dq = |i: usize| change(vars, i);
                    model.integrate_by_into(&x.nodes[t], dq, &mut out.nodes[t]);
                }
            }
            if let Some(vars) = &node.velocity_var {
                for i in 0..model.nv {
                    out.velocities[t][i] = x.velocities[t][i] + change(vars, i);
                }
            }
        }
        for (t, interval) in self.program.intervals.iter().enumerate() {
            for i in 0..interval.n_wrench {
                out.wrenches[t][i] = x.wrenches[t][i] + step * dx[interval.wrench_var + i];
            }
        }
        if self.program.grid == Grid::Motion {
            for k in 0..x.durations.len() {
                out.durations[k] = x.durations[k] + step * dx[self.program.duration_var + k];
            }
        }
    }

    fn coordinates(&self, x: &Point, out: &mut [f64]) {
        let model = &self.program.system.model;
        for (t, node) in self.program.nodes.iter().enumerate() {
            if let Some(vars) = &node.var {
                for joint in self.program.system.actuated() {
                    out[vars.robot + joint.idx_v] = x.nodes[t][joint.idx_q];
                }
            }
            if let Some(vars) = &node.velocity_var {
                for (i, v) in x.velocities[t].iter().enumerate() {
                    vars.get(i).into_iter().for_each(|at| out[at] = *v);
                }
            }
        }
        debug_assert_eq!(model.nq, x.nodes[0].len());
        for (t, interval) in self.program.intervals.iter().enumerate() {
            out[interval.wrench_var..interval.wrench_var + interval.n_wrench]
                .copy_from_slice(&x.wrenches[t]);
        }
        if self.program.grid == Grid::Motion {
            let first = self.program.duration_var;
            out[first..first + x.durations.len()].copy_from_slice(&x.durations);
        }
    }

    fn evaluate(&mut self, x: &Point, out: &mut [ElementData]) {
        self.update(x);
        let fresh = std::mem::replace(&mut self.evaluated.fresh, true);
        self.each_interval(out, |worker, t, (data, nearest, known)| {
            if fresh {
                data.objective = known.0;
                data.values.copy_from_slice(&known.1);
            } else {
                worker.values(x, t, nearest, data);
                known.0 = data.objective;
                known.1.copy_from_slice(&data.values);
            }
        });
    }

    fn linearise(&mut self, x: &Point, multipliers: &[f64], out: &mut [ElementData]) {
        self.evaluate(x, out);
        for difference in &mut self.differences {
            difference.linearise();
        }
        self.each_interval(out, |worker, t, (data, nearest, _)| {
            let first = worker.first_row[t];
            let y = &multipliers[first..first + data.values.len()];
            worker.derivatives(x, t, y, nearest, data);
        });
    }

    fn scale_row_curvature(&mut self, x: &Point, factor: f64, out: &mut [ElementData]) {
        self.each_interval(out, |worker, t, (data, _, _)| {
            worker.scale_row_curvature(x, t, factor, data);
        });
    }
}
