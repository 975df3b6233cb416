//! Pose terms on the way between two nodes, at q_s = A ⊕ s (B ⊖ A) with 0 < s < 1.
//!
//! Increments of q_s are D_A δA + D_B δB. Joints have D_A = 1 − s and D_B = s; floating bodies, with ξ = B ⊖ A, the X of
//! [`Difference`] and the Jacobians of the exponential,
//!
//! ```text
//! D_A = (1 − s) J_l((1 − s) ξ) X_A,   D_B = s J_r(s ξ) X_B
//! ```
//!
//! since q_s is B ⊕ (1 − s)(A ⊖ B) too. The Hessian leaves out the curvature of q_s itself, which vanishes with ξ.

use crate::difference::{Difference, End};
use crate::point::Point;
use crate::program::{Interval, Passage, Program};
use crate::relative::{Relative, RelativeFrame};
use crate::terms::distance::Nearest;
use crate::worker::NodeState;
use multibody::Kinematics;
use nalgebra::{DMatrix, Matrix6, Vector6};
use solver::ElementData;
use spatial::{left_jacobian, right_jacobian};

/// Configurations on the way.
pub struct Passages {
    /// Per interval, per passage.
    states: Vec<Vec<NodeState>>,
    q: Vec<f64>,
}

/// Derivatives by increments of q_s, and what takes them to the two nodes.
pub(crate) struct WayScratch {
    row: Vec<f64>,
    by_end: Vec<f64>,
    hessian: DMatrix<f64>,
    chained: DMatrix<f64>,
    ends: [EndMap; 2],
}

/// How increments of one node move the configuration on the way.
struct EndMap {
    /// Of joints.
    share: f64,
    /// First increment and block of each floating body.
    blocks: Vec<(usize, Matrix6<f64>)>,
}

impl EndMap {
    fn update(&mut self, difference: &Difference, end: End, s: f64) {
        self.share = if end == End::A { 1.0 - s } else { s };
        for (i, (first, block)) in self.blocks.iter_mut().enumerate() {
            *first = difference.floating[i];
            let xi = Vector6::from_row_slice(&difference.xi[*first..*first + 6]) * self.share;
            *block = self.share
                * match end {
                    End::A => left_jacobian(&xi) * difference.by_a[i],
                    End::B => right_jacobian(&xi) * difference.by_b[i],
                };
        }
    }

    /// `Dᵀ x` in place, for a column of increments.
    fn pull_back(&self, x: &mut [f64]) {
        let mut next = 0;
        for (first, block) in &self.blocks {
            x[next..*first].iter_mut().for_each(|x| *x *= self.share);
            next = first + 6;
            let chained = block.tr_mul(&Vector6::from_row_slice(&x[*first..next]));
            x[*first..next].copy_from_slice(chained.as_slice());
        }
        x[next..].iter_mut().for_each(|x| *x *= self.share);
    }
}

impl Passages {
    /// Buffers for a program.
    pub fn new(program: &Program) -> Self {
        let model = &program.system.model;
        let state = |passage: &Passage| NodeState {
            kinematics: Kinematics::new(model),
            relatives: (passage.frames.iter())
                .map(|&f| program.frames[f].relative())
                .collect(),
        };
        let of_interval = |i: &Interval| i.passages.iter().map(state).collect();
        Self {
            states: program.intervals.iter().map(of_interval).collect(),
            q: vec![f64::NAN; model.nq],
        }
    }

    /// Kinematics and relative poses at a point.
    pub fn update(&mut self, program: &Program, x: &Point, differences: &[Difference]) {
        let model = &program.system.model;
        for (t, states) in self.states.iter_mut().enumerate() {
            for (passage, state) in program.intervals[t].passages.iter().zip(states) {
                let (from, way) = (&x.nodes[t], &differences[t].xi);
                model.integrate_scaled_into(from, way, passage.share, &mut self.q);
                state.kinematics.update(model, &self.q);
                for (&frame, relative) in passage.frames.iter().zip(&mut state.relatives) {
                    program.frames[frame].update(&state.kinematics, relative);
                }
            }
        }
    }

    /// Row values of interval `t`, and what they leave for their derivatives.
    pub fn values(
        &self,
        interval: &Interval,
        t: usize,
        nearest: &mut [Vec<Nearest>],
        values: &mut [f64],
    ) {
        let passages = interval.passages.iter().zip(&self.states[t]);
        for ((passage, state), nearest) in passages.zip(nearest) {
            for (term, nearest) in passage.terms.iter().zip(nearest) {
                let values = &mut values[term.first_row..term.first_row + term.n_rows];
                let pose = &state.relatives[term.slot].b_from_a;
                term.term.values_near(pose, values, nearest);
            }
        }
    }

    /// Jacobians of interval `t`, and the Hessian for the multipliers `y` of the element's rows.
    pub(crate) fn derivatives(
        &self,
        program: &Program,
        (t, difference, nearest): (usize, &Difference, &[Vec<Nearest>]),
        y: &[f64],
        (scratch, gradients): (&mut WayScratch, &mut [Vector6<f64>]),
        out: &mut ElementData,
    ) {
        let interval = &program.intervals[t];
        let firsts = [interval.a, interval.b];
        let passages = interval.passages.iter().zip(&self.states[t]);
        for ((passage, state), nearest) in passages.zip(nearest) {
            for (end, map) in [End::A, End::B].into_iter().zip(&mut scratch.ends) {
                map.update(difference, end, passage.share);
            }
            scratch.hessian.fill(0.0);
            let mut curved = false;
            for (term, nearest) in passage.terms.iter().zip(nearest) {
                let frame = &program.frames[passage.frames[term.slot]];
                let relative = &state.relatives[term.slot];
                let weights = &y[term.first_row..term.first_row + term.n_rows];
                let gradients = &mut gradients[..term.n_rows];
                let hessian =
                    term.term
                        .derivatives_near(&relative.b_from_a, weights, nearest, gradients);
                let jacobian = &mut out.jacobians[term.block];
                scratch.write_rows((frame, relative), gradients, firsts, jacobian);
                let gradient = gradients.iter().zip(weights).map(|(g, w)| g * *w).sum();
                scratch.add_curvature((frame, relative), &gradient, &hessian);
                curved |= gradient != Vector6::zeros();
            }
            if curved {
                scratch.add_hessian(firsts, out);
            }
        }
    }
}

impl WayScratch {
    /// For a program.
    pub(crate) fn new(program: &Program) -> Self {
        let nv = program.system.model.nv;
        let square = || DMatrix::zeros(nv, nv);
        let end = || EndMap {
            share: f64::NAN,
            blocks: vec![(0, Matrix6::zeros()); program.system.floating().len()],
        };
        Self {
            row: vec![f64::NAN; nv],
            by_end: vec![f64::NAN; nv],
            hessian: square(),
            chained: square(),
            ends: [end(), end()],
        }
    }

    /// The Jacobian of rows with these gradients by the relative pose.
    fn write_rows(
        &mut self,
        (frame, relative): (&RelativeFrame, &Relative),
        gradients: &[Vector6<f64>],
        firsts: [Option<usize>; 2],
        jacobian: &mut [f64],
    ) {
        for (r, gradient) in gradients.iter().enumerate() {
            self.row.fill(0.0);
            for (&col, j) in frame.cols.iter().zip(&relative.columns) {
                self.row[col] = gradient.dot(j);
            }
            let mut column = 0;
            let free = firsts.iter().zip(&self.ends).filter(|(f, _)| f.is_some());
            for (_, map) in free {
                self.by_end.copy_from_slice(&self.row);
                map.pull_back(&mut self.by_end);
                for &col in &frame.cols {
                    jacobian[column * gradients.len() + r] = self.by_end[col];
                    column += 1;
                }
            }
        }
    }

    /// Adds the Hessian by increments of q_s of a function of a relative pose.
    fn add_curvature(
        &mut self,
        (frame, relative): (&RelativeFrame, &Relative),
        gradient: &Vector6<f64>,
        hessian: &Matrix6<f64>,
    ) {
        let (cols, by_q) = (&frame.cols, &mut self.hessian);
        frame.pose_hessian(relative, gradient, hessian, |k, l, value| {
            by_q[(cols[k], cols[l])] += value;
            if k != l {
                by_q[(cols[l], cols[k])] += value;
            }
        });
    }

    /// Adds D_Eᵀ H D_F for both ends E and F to the element's Hessian.
    fn add_hessian(&mut self, firsts: [Option<usize>; 2], out: &mut ElementData) {
        let n = out.gradient.len();
        for (e, from) in firsts.iter().enumerate() {
            for (f, to) in firsts.iter().enumerate().skip(e) {
                let (Some(from), Some(to)) = (from, to) else {
                    continue;
                };
                let ends = [&self.ends[e], &self.ends[f]];
                chain(&self.hessian, ends, &mut self.chained);
                for c in 0..self.chained.ncols() {
                    for r in (if e == f { c } else { 0 })..self.chained.nrows() {
                        let (i, j) = (from + r, to + c);
                        out.hessian[i.min(j) * n + i.max(j)] += self.chained[(r, c)];
                    }
                }
            }
        }
    }
}

/// D_Eᵀ H D_F of a symmetric H.
fn chain(h: &DMatrix<f64>, [e, f]: [&EndMap; 2], out: &mut DMatrix<f64>) {
    out.copy_from(h);
    for mut column in out.column_iter_mut() {
        f.pull_back(column.as_mut_slice());
    }
    for c in 0..out.ncols() {
        for r in 0..c {
            out.swap((r, c), (c, r));
        }
    }
    for mut column in out.column_iter_mut() {
        e.pull_back(column.as_mut_slice());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::samples::Sequence;
    use crate::collision::{Crossing, Crossings};
    use crate::guess;
    use crate::motion::{Planner, near};
    use crate::problem::Trajectory;
    use crate::program::Grid;
    use crate::settings::{Preset, Settings};
    use solver::Problem;
    use spatial::Random;

    /// The interval with passages.
    const T: usize = 4;

    /// A walk whose nodes are scattered, the base by `base`, with rows of everything near the ground on the way from node 4.
    fn walk(base: f64) -> (Trajectory, Point) {
        let Sequence { scene, phases } = Sequence::with_steps("flat/forward_2.toml", 8);
        let planner = Planner::new(&scene).unwrap();
        let model = &planner.system.model;
        let mut random = Random::new(5);
        let mut scattered = || {
            let by =
                (0..model.nv).map(|i| if i < 6 { base } else { 0.1 } * random.uniform(-1.0, 1.0));
            model.integrate(&planner.system.start(&scene), &by.collect::<Vec<_>>())
        };
        let nodes: Vec<_> = (0..=8 * phases.len()).map(|_| scattered()).collect();
        let mut crossings = Crossings::new();
        for a in 0..model.joints.len() {
            let of = |share| Crossing {
                share,
                at_nodes: 0.0,
                depth: 0.01,
            };
            let ways = &mut crossings.ways;
            ways.insert((T, a, Err(0)), vec![of(0.25), of(0.5)]);
            ways.extend((0..a).map(|b| ((T, a, Ok(b)), vec![of(0.5)])));
        }
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let clearances = near(&nodes, &crossings);
        let program = planner.program(&phases, &settings, Grid::Motion, clearances);
        let point = guess::point(&program, &scene, nodes);
        (Trajectory::new(program), point)
    }

    fn linearised(trajectory: &mut Trajectory, x: &Point, y: &[f64]) -> Vec<ElementData> {
        let elements = trajectory.structure().elements.iter();
        let mut data: Vec<_> = elements.map(ElementData::new).collect();
        trajectory.linearise(x, y, &mut data);
        data
    }

    /// Jᵀy of element 4, for multipliers of the rows of passages alone.
    fn pull(data: &[ElementData], trajectory: &Trajectory, y: &[f64]) -> Vec<f64> {
        let element = &trajectory.structure().elements[T];
        let mut out = vec![0.0; element.vars.len()];
        for (block, jacobian) in element.blocks.iter().zip(&data[T].jacobians) {
            for (c, &col) in block.cols.iter().enumerate() {
                for r in 0..block.n_rows {
                    out[col] += y[block.first_row + r] * jacobian[c * block.n_rows + r];
                }
            }
        }
        out
    }

    #[test]
    fn rows_on_the_way_match_central_differences() {
        for (base, curved) in [(0.2, false), (0.0, true)] {
            let (mut trajectory, x) = walk(base);
            let elements = trajectory.structure().elements.clone();
            let n = elements[T].vars.len();
            let first: usize = elements[..T]
                .iter()
                .map(solver::ElementStructure::n_rows)
                .sum();
            let labels = trajectory.program.labels.clone();
            let mut random = Random::new(9);
            let mut y = vec![0.0; labels.len()];
            for (y, label) in y.iter_mut().zip(&labels) {
                if label.category == "clearance between nodes" {
                    *y = random.uniform(0.5, 1.0);
                }
            }
            let own = &y[first..first + elements[T].n_rows()];
            assert!(own.iter().filter(|y| **y > 0.0).count() > 4);
            let zero = linearised(&mut trajectory, &x, &vec![0.0; y.len()]);
            let data = linearised(&mut trajectory, &x, &y);
            let slope = pull(&data, &trajectory, own);
            let hessian = |i: usize, j: usize| {
                let at = i.min(j) * n + i.max(j);
                data[T].hessian[at] - zero[T].hessian[at]
            };
            let interval = &trajectory.program.intervals[T];
            let nodes = [interval.a.unwrap(), interval.b.unwrap()];
            let nv = trajectory.program.system.model.nv;
            let is_joint = |i: usize| nodes.iter().any(|&a| (a + 6..a + nv).contains(&i));
            for i in 0..n {
                let mut direction = vec![0.0; trajectory.structure().n_vars];
                direction[elements[T].vars[i]] = 1.0;
                let mut at = |h: f64| {
                    let mut moved = x.clone();
                    trajectory.retract(&x, &direction, h, &mut moved);
                    let data = linearised(&mut trajectory, &moved, &y);
                    let sum: f64 = own.iter().zip(&data[T].values).map(|(y, c)| y * c).sum();
                    (sum, pull(&data, &trajectory, own))
                };
                let h = 1e-5;
                let (plus, minus) = (at(h), at(-h));
                let numeric = (plus.0 - minus.0) / (2.0 * h);
                let analytic = slope[i];
                assert!(
                    (numeric - analytic).abs() < 1e-4,
                    "{i}: {analytic}, {numeric}"
                );
                // The Hessian, but for the base, in whose chart a gradient at another point is not the same function's.
                if !curved || !is_joint(i) {
                    continue;
                }
                for j in (0..n).filter(|&j| is_joint(j)) {
                    let numeric = (plus.1[j] - minus.1[j]) / (2.0 * h);
                    let analytic = hessian(i, j);
                    let close = (numeric - analytic).abs() < 1e-3 * (10.0 + analytic.abs());
                    assert!(close, "{i}, {j}: {analytic}, {numeric}");
                }
            }
        }
    }
}
