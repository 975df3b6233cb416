//! Small programs with known answers; one element of all variables, derivatives by hand.

use solver::{BlockStructure, ElementData, ElementStructure, Problem, Structure};

/// No bound.
pub const INF: f64 = f64::INFINITY;

type Function = Box<dyn Fn(&[f64], &[f64], &mut ElementData)>;

/// A program given by a function of the point and the row multipliers that writes everything.
pub struct Dense {
    /// Its structure.
    pub structure: Structure,
    function: Function,
}

impl Problem for Dense {
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
        let element = &self.structure.elements[0];
        let mut all = ElementData::new(element);
        (self.function)(x, &vec![0.0; element.n_rows()], &mut all);
        out[0].objective = all.objective;
        out[0].values = all.values;
    }
    fn linearise(&mut self, x: &Vec<f64>, y: &[f64], out: &mut [ElementData]) {
        (self.function)(x, y, &mut out[0]);
    }
}

/// A program with bounds of variables and of rows.
pub fn dense(
    lower: &[f64],
    upper: &[f64],
    rows: &[(f64, f64)],
    function: impl Fn(&[f64], &[f64], &mut ElementData) + 'static,
) -> Dense {
    let n = lower.len();
    let element = ElementStructure {
        vars: (0..n).collect(),
        row_lower: rows.iter().map(|r| r.0).collect(),
        row_upper: rows.iter().map(|r| r.1).collect(),
        blocks: if rows.is_empty() {
            vec![]
        } else {
            vec![BlockStructure {
                first_row: 0,
                n_rows: rows.len(),
                cols: (0..n).collect(),
            }]
        },
    };
    Dense {
        structure: Structure {
            n_vars: n,
            lower: lower.to_vec(),
            upper: upper.to_vec(),
            elements: vec![element],
        },
        function: Box::new(function),
    }
}

/// min x₁x₄(x₁+x₂+x₃) + x₃, x₁x₂x₃x₄ ≥ 25, Σx² = 40, 1 ≤ x ≤ 5 from (1, 5, 5, 1); optimum 17.0140173.
///
/// Source: Hock and Schittkowski 1981, problem 71.
pub fn hock_schittkowski_71() -> Dense {
    let rows = [(25.0, INF), (40.0, 40.0)];
    dense(&[1.0; 4], &[5.0; 4], &rows, |x, y, out| {
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
    })
}

/// min −x − y on the unit circle: −√2 at (1, 1)/√2.
pub fn line_on_circle() -> Dense {
    dense(&[-INF; 2], &[INF; 2], &[(1.0, 1.0)], |x, y, out| {
        out.objective = -x[0] - x[1];
        out.values[0] = x[0] * x[0] + x[1] * x[1];
        out.gradient.copy_from_slice(&[-1.0, -1.0]);
        out.jacobians[0].copy_from_slice(&[2.0 * x[0], 2.0 * x[1]]);
        out.hessian
            .copy_from_slice(&[2.0 * y[0], 0.0, 0.0, 2.0 * y[0]]);
    })
}

/// min (1 − x)² + 100 (y − x²)² with x² + y² ≤ `square_radius`: the plain optimum (1, 1) if the disc holds it.
pub fn rosenbrock_in_a_disc(square_radius: f64) -> Dense {
    let rows = [(-INF, square_radius)];
    dense(&[-INF; 2], &[INF; 2], &rows, |x, y, out| {
        let (a, b) = (1.0 - x[0], x[1] - x[0] * x[0]);
        out.objective = a * a + 100.0 * b * b;
        out.values[0] = x[0] * x[0] + x[1] * x[1];
        out.gradient
            .copy_from_slice(&[-2.0 * a - 400.0 * x[0] * b, 200.0 * b]);
        out.jacobians[0].copy_from_slice(&[2.0 * x[0], 2.0 * x[1]]);
        let h00 = 2.0 - 400.0 * (b - 2.0 * x[0] * x[0]) + 2.0 * y[0];
        let h10 = -400.0 * x[0];
        out.hessian
            .copy_from_slice(&[h00, h10, h10, 200.0 + 2.0 * y[0]]);
    })
}

/// min x² + 2y² with x + y = 1 written `copies` times, x, y ≥ 0: (2/3, 1/3), 2/3.
pub fn repeated_rows(copies: usize) -> Dense {
    let rows = vec![(1.0, 1.0); copies];
    dense(&[0.0; 2], &[INF; 2], &rows, |x, _, out| {
        out.objective = x[0] * x[0] + 2.0 * x[1] * x[1];
        out.values.fill(x[0] + x[1]);
        out.gradient.copy_from_slice(&[2.0 * x[0], 4.0 * x[1]]);
        out.jacobians[0].fill(1.0);
        out.hessian.copy_from_slice(&[2.0, 0.0, 0.0, 4.0]);
    })
}
