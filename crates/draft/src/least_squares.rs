//! Nonlinear least squares within bounds.
//!
//! Source: K. Madsen, H. B. Nielsen, O. Tingleff, Methods for Non-Linear Least Squares Problems (2004), section 3.2
//! (Levenberg–Marquardt). **Departs:** variables at a bound that the gradient pushes against stay there in a step, and steps end at bounds.

use nalgebra::{DMatrix, DVector};

/// Most steps.
const STEPS: usize = 300;
/// First damping, and the factors by which it grows after a step that fails and falls after one that does not.
const DAMPING: (f64, f64, f64) = (1e-3, 4.0, 0.3);
/// Damping beyond which no step helps any more.
const MOST_DAMPING: f64 = 1e12;
/// The sum of squares is at its least when a step lowers it by less than this share.
const SMALL: f64 = 1e-14;

/// Residuals and their derivatives by the variables, a row each.
#[derive(Debug, Default)]
pub(crate) struct Residuals {
    values: Vec<f64>,
    rows: Vec<Vec<f64>>,
}

impl Residuals {
    /// Adds weight · value, with the derivatives of the value.
    pub fn push(&mut self, weight: f64, value: f64, derivatives: Vec<f64>) {
        self.values.push(weight * value);
        let scaled = derivatives.into_iter().map(|d| weight * d);
        self.rows.push(scaled.collect());
    }

    /// Half the sum of squares.
    pub fn cost(&self) -> f64 {
        0.5 * self.values.iter().map(|r| r * r).sum::<f64>()
    }

    /// JᵀJ and Jᵀr.
    fn normal(&self, n: usize) -> (DMatrix<f64>, DVector<f64>) {
        let jacobian = DMatrix::from_fn(self.rows.len(), n, |i, j| self.rows[i][j]);
        let values = DVector::from_column_slice(&self.values);
        (jacobian.tr_mul(&jacobian), jacobian.tr_mul(&values))
    }
}

/// Lowers the sum of squares from `x`, which stays between `lower` and `upper`; returns half of it.
pub(crate) fn minimise(
    x: &mut [f64],
    [lower, upper]: [&[f64]; 2],
    evaluate: &mut dyn FnMut(&[f64]) -> Residuals,
) -> f64 {
    let n = x.len();
    let mut here = evaluate(x);
    let mut damping = DAMPING.0;
    for _ in 0..STEPS {
        let (mut hessian, mut gradient) = here.normal(n);
        for i in 0..n {
            let held =
                (x[i] <= lower[i] && gradient[i] > 0.0) || (x[i] >= upper[i] && gradient[i] < 0.0);
            if held {
                hessian.row_mut(i).fill(0.0);
                hessian.column_mut(i).fill(0.0);
                hessian[(i, i)] = 1.0;
                gradient[i] = 0.0;
            }
        }
        let mut better = None;
        while better.is_none() && damping < MOST_DAMPING {
            let mut damped = hessian.clone();
            for i in 0..n {
                damped[(i, i)] += damping * hessian[(i, i)].max(1e-9);
            }
            if let Some(factor) = damped.cholesky() {
                let step = factor.solve(&gradient);
                let moved: Vec<f64> = (0..n)
                    .map(|i| (x[i] - step[i]).clamp(lower[i], upper[i]))
                    .collect();
                let there = evaluate(&moved);
                if there.cost() < here.cost() {
                    better = Some((moved, there));
                    damping *= DAMPING.2;
                    continue;
                }
            }
            damping *= DAMPING.1;
        }
        let Some((moved, there)) = better else {
            break;
        };
        let gain = here.cost() - there.cost();
        x.copy_from_slice(&moved);
        here = there;
        if gain <= SMALL * here.cost() {
            break;
        }
    }
    here.cost()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley as residuals: 10 (y − x²) and 1 − x.
    fn valley(x: &[f64]) -> Residuals {
        let mut out = Residuals::default();
        out.push(10.0, x[1] - x[0] * x[0], vec![-2.0 * x[0], 1.0]);
        out.push(1.0, 1.0 - x[0], vec![-1.0, 0.0]);
        out
    }

    #[test]
    fn the_bottom_of_a_bent_valley_is_found() {
        let mut x = [-1.2, 1.0];
        let free = [f64::INFINITY; 2];
        let cost = minimise(&mut x, [&free.map(|b| -b), &free], &mut |x| valley(x));
        assert!(cost < 1e-20 && (x[0] - 1.0).abs() < 1e-9, "{x:?}");
    }

    #[test]
    fn a_bound_is_kept_and_the_rest_is_best_for_it() {
        let mut x = [-1.2, 1.0];
        minimise(&mut x, [&[-2.0, -2.0], &[0.5, 2.0]], &mut |x| valley(x));
        assert!(
            (x[0] - 0.5).abs() < 1e-12 && (x[1] - 0.25).abs() < 1e-7,
            "{x:?}"
        );
    }
}
