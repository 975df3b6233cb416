//! Checks of analytic derivatives by central differences; for tests only.
//!
//! Functions take and return plain slices. Matrices are column-major slices (`as_slice()` of a `nalgebra` matrix), rows
//! are outputs, columns inputs. On a manifold let `x` be a tangent increment and pass zeros.
//! The differences are of fourth order (five points), so that a correct derivative agrees to about 1e-10.

/// Step of the differences: truncation h⁴ and rounding ε/h both stay near 1e-12 for functions of scale one.
pub const STEP: f64 = 5e-4;

/// Step of second differences of values: truncation h⁴ and rounding ε/h² both stay near 1e-10.
const SECOND_STEP: f64 = 3e-3;

/// Factor over the rounding noise ε·|f|/h that is granted to every entry.
const NOISE_FACTOR: f64 = 100.0;

/// Entries of rows that are tiny throughout are judged relative to this part of the largest entry of all.
const SMALL_ROW: f64 = 1e-3;

/// Central-difference Jacobian of `f` at `x` with the step [`STEP`], column-major, `f(x).len()` × `x.len()`.
pub fn jacobian(f: impl Fn(&[f64]) -> Vec<f64>, x: &[f64]) -> Vec<f64> {
    jacobian_with_step(f, x, STEP)
}

/// Central-difference gradient of a scalar function.
pub fn gradient(f: impl Fn(&[f64]) -> f64, x: &[f64]) -> Vec<f64> {
    jacobian(|y| vec![f(y)], x)
}

/// [`jacobian`] with a chosen step, for functions that bend sharply or live on another scale.
pub fn jacobian_with_step(f: impl Fn(&[f64]) -> Vec<f64>, x: &[f64], step: f64) -> Vec<f64> {
    let mut columns = Vec::new();
    for j in 0..x.len() {
        let at = |steps: f64| {
            let mut y = x.to_vec();
            y[j] += steps * step;
            f(&y)
        };
        let (p1, m1, p2, m2) = (at(1.0), at(-1.0), at(2.0), at(-2.0));
        columns.extend(
            (0..p1.len()).map(|i| (8.0 * (p1[i] - m1[i]) - (p2[i] - m2[i])) / (12.0 * step)),
        );
    }
    columns
}

/// Fails unless `jac` (column-major) is the Jacobian of `f` at `x` to `rel_tol`, relative to the largest entry of a row.
///
/// # Panics
/// When an entry is off or not a number, or the sizes disagree; the message lists the worst entries.
#[track_caller]
pub fn assert_jacobian(f: impl Fn(&[f64]) -> Vec<f64>, x: &[f64], jac: &[f64], rel_tol: f64) {
    assert_jacobian_with_step(f, x, jac, rel_tol, STEP);
}

/// [`assert_jacobian`] with a chosen step.
///
/// # Panics
/// As [`assert_jacobian`].
#[track_caller]
pub fn assert_jacobian_with_step(
    f: impl Fn(&[f64]) -> Vec<f64>,
    x: &[f64],
    jac: &[f64],
    rel_tol: f64,
    step: f64,
) {
    let values = f(x);
    let largest_value = values.iter().map(|v| v.abs()).fold(0.0, f64::max);
    let noise = NOISE_FACTOR * f64::EPSILON * largest_value / step;
    let numeric = jacobian_with_step(f, x, step);
    compare(jac, &numeric, x.len(), rel_tol, noise);
}

/// Fails unless every entry is within `rel_tol` of the largest of its row, plus `noise`.
#[track_caller]
fn compare(analytic: &[f64], numeric: &[f64], columns: usize, rel_tol: f64, noise: f64) {
    let rows = numeric.len().checked_div(columns).unwrap_or(0);
    let given = analytic.len();
    assert!(
        given == rows * columns,
        "{given} entries given for {rows} outputs and {columns} inputs"
    );
    let row_scale = |i: usize| {
        (0..columns)
            .map(|j| numeric[i + j * rows].abs())
            .fold(0.0, f64::max)
    };
    let scales: Vec<f64> = (0..rows).map(row_scale).collect();
    let largest = scales.iter().copied().fold(0.0, f64::max);

    let mut wrong = Vec::new();
    for j in 0..columns {
        for i in 0..rows {
            let (analytic, numeric) = (analytic[i + j * rows], numeric[i + j * rows]);
            let tolerance = rel_tol * scales[i].max(SMALL_ROW * largest) + noise;
            let error = (analytic - numeric).abs();
            // a NaN on either side compares false and must count as wrong
            if error.is_nan() || error > tolerance {
                wrong.push((error / tolerance, i, j, analytic, numeric, tolerance));
            }
        }
    }
    wrong.sort_by(|a, b| b.0.total_cmp(&a.0));
    let list: Vec<String> = wrong.iter().take(8).map(describe).collect();
    let (count, all) = (wrong.len(), rows * columns);
    assert!(
        wrong.is_empty(),
        "{count} of {all} entries are wrong; the worst:\n{}",
        list.join("\n")
    );
}

fn describe(entry: &(f64, usize, usize, f64, f64, f64)) -> String {
    let (_, i, j, analytic, numeric, tolerance) = entry;
    let error = (analytic - numeric).abs();
    format!(
        "  ∂f[{i}]/∂x[{j}]: analytic {analytic:.9e}, numeric {numeric:.9e}, off by {error:.1e} > {tolerance:.1e}"
    )
}

/// Fails unless `grad` is the gradient of `f` at `x` to `rel_tol`, relative to its largest entry.
///
/// # Panics
/// As [`assert_jacobian`].
#[track_caller]
pub fn assert_gradient(f: impl Fn(&[f64]) -> f64, x: &[f64], grad: &[f64], rel_tol: f64) {
    assert_jacobian(|y| vec![f(y)], x, grad, rel_tol);
}

/// Fails unless `hess` is symmetric and the Jacobian of the gradient `grad` at `x` to `rel_tol`.
///
/// # Panics
/// As [`assert_jacobian`], or when `hess` is not symmetric.
#[track_caller]
pub fn assert_hessian(grad: impl Fn(&[f64]) -> Vec<f64>, x: &[f64], hess: &[f64], rel_tol: f64) {
    assert_symmetric(x.len(), hess, rel_tol);
    assert_jacobian(grad, x, hess, rel_tol);
}

/// Fails unless `hess` is symmetric and the Hessian of the scalar `f` at `x` to `rel_tol`, by second differences of values
/// alone: free of any gradient, but good to 1e-7 at best.
///
/// # Panics
/// As [`assert_hessian`].
#[track_caller]
pub fn assert_hessian_of_value(f: impl Fn(&[f64]) -> f64, x: &[f64], hess: &[f64], rel_tol: f64) {
    assert_symmetric(x.len(), hess, rel_tol);
    let gradient = |y: &[f64]| jacobian_with_step(|z| vec![f(z)], y, SECOND_STEP);
    let numeric = jacobian_with_step(gradient, x, SECOND_STEP);
    let noise = NOISE_FACTOR * f64::EPSILON * f(x).abs() / (SECOND_STEP * SECOND_STEP);
    compare(hess, &numeric, x.len(), rel_tol, noise);
}

#[track_caller]
fn assert_symmetric(n: usize, hess: &[f64], rel_tol: f64) {
    assert!(
        hess.len() == n * n,
        "{} entries given for a {n}×{n} Hessian",
        hess.len()
    );
    let largest = hess.iter().map(|h| h.abs()).fold(0.0, f64::max);
    for j in 0..n {
        for i in 0..j {
            let (upper, lower) = (hess[i + j * n], hess[j + i * n]);
            let symmetric = (upper - lower).abs() <= rel_tol * largest;
            assert!(
                symmetric,
                "not symmetric: H[{i},{j}] = {upper:.9e}, H[{j},{i}] = {lower:.9e}"
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polar(x: &[f64]) -> Vec<f64> {
        vec![x[0] * x[1].cos(), x[0] * x[1].sin()]
    }

    fn polar_jacobian(x: &[f64]) -> Vec<f64> {
        let (s, c) = x[1].sin_cos();
        vec![c, s, -x[0] * s, x[0] * c]
    }

    #[test]
    fn a_right_jacobian_passes() {
        let x = [2.0, 0.7];
        assert_jacobian(polar, &x, &polar_jacobian(&x), 1e-10);
    }

    #[test]
    #[should_panic(expected = "1 of 4 entries are wrong")]
    fn an_error_of_one_in_ten_million_is_seen() {
        let x = [2.0, 0.7];
        let mut jac = polar_jacobian(&x);
        jac[2] *= 1.0 + 1e-7;
        assert_jacobian(polar, &x, &jac, 1e-8);
    }

    #[test]
    #[should_panic(expected = "∂f[0]/∂x[0]")]
    fn a_nan_is_an_error() {
        assert_gradient(|x| x[0], &[1.0], &[f64::NAN], 1e-6);
    }

    #[test]
    #[should_panic(expected = "not symmetric")]
    fn an_asymmetric_hessian_is_refused() {
        assert_hessian(
            |x| vec![x[0] + x[1], x[1]],
            &[0.0, 0.0],
            &[1.0, 0.0, 1.0, 1.0],
            1e-6,
        );
    }

    #[test]
    fn a_hessian_from_values_alone_is_good_to_seven_digits() {
        let f = |x: &[f64]| (x[0] * x[1]).exp();
        let (a, b) = (0.3, 0.5);
        let e = f(&[a, b]);
        let hess = [b * b * e, (1.0 + a * b) * e, (1.0 + a * b) * e, a * a * e];
        assert_hessian_of_value(f, &[a, b], &hess, 1e-8);
    }
}
