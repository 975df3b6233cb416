//! Quadratic programs of several elements: f_e = ½ xᵀH_e x + g_eᵀx, rows A_e x between bounds.

use solver::{ElementData, Problem, Structure};

/// Coefficients of one element.
#[derive(Debug, Clone, Default)]
pub struct Coefficients {
    /// H_e, column-major, both triangles.
    pub hessian: Vec<f64>,
    /// g_e.
    pub gradient: Vec<f64>,
    /// Per block A, column-major.
    pub jacobians: Vec<Vec<f64>>,
}

/// A quadratic program.
#[derive(Debug, Clone)]
pub struct Quadratic {
    /// Sizes and bounds.
    pub structure: Structure,
    /// Coefficients per element.
    pub elements: Vec<Coefficients>,
}

impl Quadratic {
    /// All rows of A as dense rows with their bounds.
    pub fn dense_rows(&self) -> Vec<(Vec<f64>, f64, f64)> {
        let mut rows = Vec::new();
        for (element, coefficients) in self.structure.elements.iter().zip(&self.elements) {
            let first = rows.len();
            for (l, u) in element.row_lower.iter().zip(&element.row_upper) {
                rows.push((vec![0.0; self.structure.n_vars], *l, *u));
            }
            for (block, a) in element.blocks.iter().zip(&coefficients.jacobians) {
                for (k, &c) in block.cols.iter().enumerate() {
                    for r in 0..block.n_rows {
                        rows[first + block.first_row + r].0[element.vars[c]] +=
                            a[k * block.n_rows + r];
                    }
                }
            }
        }
        rows
    }

    /// Σ H_e as dense columns and Σ g_e.
    pub fn dense_objective(&self) -> (Vec<Vec<f64>>, Vec<f64>) {
        let n = self.structure.n_vars;
        let (mut h, mut g) = (vec![vec![0.0; n]; n], vec![0.0; n]);
        for (element, coefficients) in self.structure.elements.iter().zip(&self.elements) {
            let k = element.vars.len();
            for (j, &b) in element.vars.iter().enumerate() {
                g[b] += coefficients.gradient[j];
                for (i, &a) in element.vars.iter().enumerate() {
                    h[b][a] += coefficients.hessian[j * k + i];
                }
            }
        }
        (h, g)
    }

    /// ∇f + Aᵀy.
    pub fn stationarity(&self, x: &[f64], y: &[f64]) -> Vec<f64> {
        let (h, mut out) = self.dense_objective();
        for (column, xj) in h.iter().zip(x) {
            out.iter_mut().zip(column).for_each(|(o, c)| *o += c * xj);
        }
        for ((row, _, _), yi) in self.dense_rows().iter().zip(y) {
            out.iter_mut().zip(row).for_each(|(o, a)| *o += a * yi);
        }
        out
    }
}

impl Problem for Quadratic {
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
        for (e, data) in out.iter_mut().enumerate() {
            let (element, c) = (&self.structure.elements[e], &self.elements[e]);
            let n = element.vars.len();
            data.objective = 0.0;
            for (j, &b) in element.vars.iter().enumerate() {
                let hx: f64 = (0..n)
                    .map(|i| c.hessian[j * n + i] * x[element.vars[i]])
                    .sum();
                data.objective += x[b] * (0.5 * hx + c.gradient[j]);
            }
            data.values.fill(0.0);
            for (block, a) in element.blocks.iter().zip(&c.jacobians) {
                for (k, &col) in block.cols.iter().enumerate() {
                    for r in 0..block.n_rows {
                        data.values[block.first_row + r] +=
                            a[k * block.n_rows + r] * x[element.vars[col]];
                    }
                }
            }
        }
    }

    fn linearise(&mut self, x: &Vec<f64>, _multipliers: &[f64], out: &mut [ElementData]) {
        self.evaluate(x, out);
        for (e, data) in out.iter_mut().enumerate() {
            let (element, c) = (&self.structure.elements[e], &self.elements[e]);
            let n = element.vars.len();
            for j in 0..n {
                let hx: f64 = (0..n)
                    .map(|i| c.hessian[j * n + i] * x[element.vars[i]])
                    .sum();
                data.gradient[j] = hx + c.gradient[j];
            }
            data.hessian.copy_from_slice(&c.hessian);
            for (out, a) in data.jacobians.iter_mut().zip(&c.jacobians) {
                out.copy_from_slice(a);
            }
        }
    }
}
