//! Small programs with known answers, infeasible ones too.

use solver::{
    BlockStructure, ElementData, ElementStructure, InteriorPoint, Options, Problem, Report, Status,
    Structure,
};

/// A program given by closures over one element of all variables; derivatives by hand.
struct Dense<F: Fn(&[f64], &[f64], &mut ElementData)> {
    structure: Structure,
    function: F,
}

impl<F: Fn(&[f64], &[f64], &mut ElementData)> Problem for Dense<F> {
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
        (self.function)(
            x,
            &vec![0.0; self.structure.elements[0].n_rows()],
            &mut out[0],
        );
    }
    fn linearise(&mut self, x: &Vec<f64>, y: &[f64], out: &mut [ElementData]) {
        (self.function)(x, y, &mut out[0]);
    }
}

fn dense<F: Fn(&[f64], &[f64], &mut ElementData)>(
    lower: &[f64],
    upper: &[f64],
    rows: &[(f64, f64)],
    function: F,
) -> Dense<F> {
    let n = lower.len();
    let element = ElementStructure {
        vars: (0..n).collect(),
        row_lower: rows.iter().map(|r| r.0).collect(),
        row_upper: rows.iter().map(|r| r.1).collect(),
        blocks: vec![BlockStructure {
            first_row: 0,
            n_rows: rows.len(),
            cols: (0..n).collect(),
        }],
    };
    let structure = Structure {
        n_vars: n,
        lower: lower.to_vec(),
        upper: upper.to_vec(),
        elements: vec![element],
    };
    Dense {
        structure,
        function,
    }
}

fn solve<F: Fn(&[f64], &[f64], &mut ElementData)>(
    mut p: Dense<F>,
    start: &[f64],
) -> (Vec<f64>, Report) {
    let mut x = start.to_vec();
    let structure = p.structure.clone();
    let options = Options {
        dual_tolerance: 1e-7,
        complementarity_tolerance: 1e-7,
        ..Default::default()
    };
    let report =
        InteriorPoint::new(&structure).solve(&mut p, &mut x, &options, None, &mut |_| true);
    (x, report)
}

const INF: f64 = f64::INFINITY;

#[test]
fn hock_schittkowski_71_is_solved() {
    // min x1 x4 (x1 + x2 + x3) + x3, x1 x2 x3 x4 ≥ 25, Σ x² = 40, 1 ≤ x ≤ 5; optimum 17.0140173.
    let p = dense(
        &[1.0; 4],
        &[5.0; 4],
        &[(25.0, INF), (40.0, 40.0)],
        |x, y, out| {
            let s = x[0] + x[1] + x[2];
            out.objective = x[0] * x[3] * s + x[2];
            out.values
                .copy_from_slice(&[x.iter().product(), x.iter().map(|v| v * v).sum()]);
            out.gradient.copy_from_slice(&[
                x[3] * (s + x[0]),
                x[0] * x[3],
                x[0] * x[3] + 1.0,
                x[0] * s,
            ]);
            let product = |skip: &[usize]| {
                (0..4)
                    .filter(|i| !skip.contains(i))
                    .map(|i| x[i])
                    .product::<f64>()
            };
            for j in 0..4 {
                out.jacobians[0][2 * j] = product(&[j]);
                out.jacobians[0][2 * j + 1] = 2.0 * x[j];
            }
            let h = &mut out.hessian;
            h.fill(0.0);
            h[0] = 2.0 * x[3];
            (h[1], h[2], h[3]) = (x[3], x[3], 2.0 * x[0] + x[1] + x[2]);
            (h[4 + 3], h[8 + 3]) = (x[0], x[0]);
            for j in 0..4 {
                h[4 * j + j] += 2.0 * y[1];
                for i in j + 1..4 {
                    h[4 * j + i] += y[0] * product(&[i, j]);
                }
            }
        },
    );
    let (x, report) = solve(p, &[1.0, 5.0, 5.0, 1.0]);
    assert_eq!(report.status, Status::Solved);
    assert!(
        (report.objective - 17.014_017_3).abs() < 1e-5,
        "{} at {x:?}",
        report.objective
    );
}

#[test]
fn a_circle_is_met_where_the_line_touches_it_from_a_saddle() {
    // min −x − y on the unit circle: (1, 1)/√2; the start has the wrong curvature.
    let p = dense(&[-INF; 2], &[INF; 2], &[(1.0, 1.0)], |x, y, out| {
        out.objective = -x[0] - x[1];
        out.values[0] = x[0] * x[0] + x[1] * x[1];
        out.gradient.copy_from_slice(&[-1.0, -1.0]);
        out.jacobians[0].copy_from_slice(&[2.0 * x[0], 2.0 * x[1]]);
        out.hessian
            .copy_from_slice(&[2.0 * y[0], 0.0, 0.0, 2.0 * y[0]]);
    });
    let (x, report) = solve(p, &[0.1, -0.3]);
    assert_eq!(report.status, Status::Solved);
    assert!(
        (x[0] - 0.5_f64.sqrt()).abs() < 1e-6 && (x[1] - 0.5_f64.sqrt()).abs() < 1e-6,
        "{x:?}"
    );
}

#[test]
fn repeated_rows_do_not_disturb() {
    // The same equality three times.
    let p = dense(&[0.0; 2], &[INF; 2], &[(1.0, 1.0); 3], |x, _, out| {
        out.objective = x[0] * x[0] + 2.0 * x[1] * x[1];
        out.values.fill(x[0] + x[1]);
        out.gradient.copy_from_slice(&[2.0 * x[0], 4.0 * x[1]]);
        out.jacobians[0].fill(1.0);
        out.hessian.copy_from_slice(&[2.0, 0.0, 0.0, 4.0]);
    });
    let (x, report) = solve(p, &[5.0, 5.0]);
    assert_eq!(report.status, Status::Solved);
    assert!((x[0] - 2.0 / 3.0).abs() < 1e-6, "{x:?}");
}

#[test]
fn contradicting_rows_end_as_not_solved_with_their_violation() {
    // x = 0 and x = 1: the least largest violation is a half.
    let p = dense(&[-INF], &[INF], &[(0.0, 0.0), (1.0, 1.0)], |x, _, out| {
        out.objective = x[0] * x[0];
        out.values.fill(x[0]);
        out.gradient[0] = 2.0 * x[0];
        out.jacobians[0].fill(1.0);
        out.hessian[0] = 2.0;
    });
    let (x, report) = solve(p, &[3.0]);
    assert_ne!(report.status, Status::Solved);
    assert!(
        report.violation >= 0.5 - 1e-9 && report.violation < 0.6,
        "{} at {x:?}",
        report.violation
    );
}
