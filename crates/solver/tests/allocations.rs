//! The solver allocates at the start of a solve only: pendulums side by side swing from hanging to a given angle.
//!
//! Per pendulum p' = p + h v', v' = v + h (u − sin p), −1 ≤ v ≤ 1 as rows, |u| bounded, both ends fixed by equal bounds;
//! minimise Σ u². The elements are wide enough for the dense kernels, the sine gives curvature of both signs.

use solver::{
    BlockStructure, ElementData, ElementStructure, InteriorPoint, Iteration, Options, Problem,
    Report, Status, Structure,
};

/// Pendulums side by side, and steps.
const WIDTH: usize = 8;
const STEPS: usize = 20;
const H: f64 = 0.2;
/// Variables per node: p, v, u of every pendulum.
const NODE: usize = 3 * WIDTH;
/// Rows per element: two equations and a speed limit per pendulum.
const ROWS: usize = 3 * WIDTH;

struct Pendulums {
    structure: Structure,
}

impl Pendulums {
    fn new(angle: f64) -> Self {
        let n_vars = NODE * (STEPS + 1);
        let (mut lower, mut upper) = (vec![f64::NEG_INFINITY; n_vars], vec![f64::INFINITY; n_vars]);
        for node in 0..=STEPS {
            for i in 0..WIDTH {
                let first = NODE * node + 3 * i;
                (lower[first + 2], upper[first + 2]) = (-0.9, 0.9);
                if node == 0 || node == STEPS {
                    let p = if node == 0 { 0.0 } else { angle };
                    lower[first..first + 2].copy_from_slice(&[p, 0.0]);
                    upper[first..first + 2].copy_from_slice(&[p, 0.0]);
                }
            }
        }
        let element = |t: usize| ElementStructure {
            vars: (NODE * t..NODE * (t + 2)).collect(),
            row_lower: [0.0, 0.0, -1.0].repeat(WIDTH),
            row_upper: [0.0, 0.0, 1.0].repeat(WIDTH),
            blocks: vec![BlockStructure {
                first_row: 0,
                n_rows: ROWS,
                cols: (0..2 * NODE).collect(),
            }],
        };
        Self {
            structure: Structure {
                n_vars,
                lower,
                upper,
                elements: (0..STEPS).map(element).collect(),
            },
        }
    }
}

impl Problem for Pendulums {
    type Point = Vec<f64>;

    fn structure(&self) -> &Structure {
        &self.structure
    }

    fn retract(&self, x: &Vec<f64>, dx: &[f64], step: f64, out: &mut Vec<f64>) {
        for i in 0..x.len() {
            out[i] = x[i] + step * dx[i];
        }
    }

    fn coordinates(&self, x: &Vec<f64>, out: &mut [f64]) {
        out.copy_from_slice(x);
    }

    fn evaluate(&mut self, x: &Vec<f64>, out: &mut [ElementData]) {
        for (t, data) in out.iter_mut().enumerate() {
            data.objective = 0.0;
            for i in 0..WIDTH {
                let (now, next) = (&x[NODE * t + 3 * i..], &x[NODE * (t + 1) + 3 * i..]);
                data.objective += now[2] * now[2] + next[2] * next[2];
                data.values[3 * i] = next[0] - now[0] - H * next[1];
                data.values[3 * i + 1] = next[1] - now[1] - H * (now[2] - now[0].sin());
                data.values[3 * i + 2] = next[1];
            }
        }
    }

    fn linearise(&mut self, x: &Vec<f64>, multipliers: &[f64], out: &mut [ElementData]) {
        self.evaluate(x, out);
        let n = 2 * NODE;
        for (t, data) in out.iter_mut().enumerate() {
            data.gradient.fill(0.0);
            data.hessian.fill(0.0);
            data.jacobians[0].fill(0.0);
            for i in 0..WIDTH {
                let (now, next) = (3 * i, NODE + 3 * i);
                let p = x[NODE * t + now];
                for u in [now + 2, next + 2] {
                    data.gradient[u] = 2.0 * x[NODE * t + u];
                    data.hessian[u * n + u] = 2.0;
                }
                data.hessian[now * n + now] = -multipliers[ROWS * t + now + 1] * H * p.sin();
                let mut set = |row: usize, col: usize, value: f64| {
                    data.jacobians[0][col * ROWS + row] = value;
                };
                set(now, next, 1.0);
                set(now, now, -1.0);
                set(now, next + 1, -H);
                set(now + 1, next + 1, 1.0);
                set(now + 1, now + 1, -1.0);
                set(now + 1, now + 2, -H);
                set(now + 1, now, H * p.cos());
                set(now + 2, next + 1, 1.0);
            }
        }
    }

    fn scale_row_curvature(&mut self, _: &Vec<f64>, factor: f64, out: &mut [ElementData]) {
        let n = 2 * NODE;
        for data in out {
            for i in 0..WIDTH {
                data.hessian[3 * i * n + 3 * i] *= factor;
            }
        }
    }
}

/// Solves for a final angle with at most so many iterations; also the most trial points of a line search and the
/// allocations of the solve.
fn solve(angle: f64, max_iterations: usize) -> (Report, usize, u64) {
    let mut pendulums = Pendulums::new(angle);
    let mut solver = InteriorPoint::new(&pendulums.structure);
    let mut x: Vec<f64> = (0..pendulums.structure.n_vars)
        .map(|i| (i as f64).sin())
        .collect();
    let options = Options {
        max_iterations,
        stall_iterations: 0, // the infeasible ones are to use up their iterations
        ..Options::default()
    };
    let (mut trials, mut report) = (0, None);
    let info = allocation_counter::measure(|| {
        let mut observe = |line: &Iteration| {
            trials = trials.max(line.trials);
            true
        };
        report = Some(solver.solve(&mut pendulums, &mut x, &options, None, &mut observe));
    });
    (report.expect("the solve ran"), trials, info.count_total)
}

#[test]
fn the_allocations_of_a_solve_do_not_grow_with_its_iterations() {
    // The dense kernels keep memory per thread, which the first solve provides.
    solve(2.0, 1);
    // A swing within reach, and one out of reach whose line searches go to their end with every correction.
    for (angle, status, least_trials) in
        [(2.0, Status::Solved, 1), (3.0, Status::IterationLimit, 12)]
    {
        let (short, _, few) = solve(angle, 15);
        let (long, trials, many) = solve(angle, 200);
        assert_eq!(short.status, Status::IterationLimit, "angle {angle}");
        assert_eq!(long.status, status, "angle {angle}");
        assert!(long.iterations >= 20 && trials >= least_trials);
        assert!(few > 0, "the counter counts");
        assert_eq!(few, many, "angle {angle}, {} iterations", long.iterations);
    }
}
