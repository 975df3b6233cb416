//! Small programs with known answers.

use crate::samples::{
    Dense, INF, dense, hock_schittkowski_71, line_on_circle, repeated_rows, rosenbrock_in_a_disc,
};
use solver::{InteriorPoint, Options, Problem, Report, Status};

/// Solves with tight tolerances.
pub fn solve(mut problem: Dense, start: &[f64]) -> (Vec<f64>, Report) {
    let mut x = start.to_vec();
    let structure = problem.structure().clone();
    let options = Options {
        dual_tolerance: 1e-7,
        complementarity_tolerance: 1e-7,
        ..Options::default()
    };
    let report =
        InteriorPoint::new(&structure).solve(&mut problem, &mut x, &options, None, &mut |_| true);
    (x, report)
}

#[test]
fn hock_schittkowski_71_is_solved() {
    let (x, report) = solve(hock_schittkowski_71(), &[1.0, 5.0, 5.0, 1.0]);
    assert_eq!(report.status, Status::Solved);
    assert!(
        (report.objective - 17.014_017_3).abs() < 1e-5,
        "{} at {x:?}",
        report.objective
    );
    assert!(report.iterations <= 30, "{} iterations", report.iterations);
}

#[test]
fn a_circle_is_met_where_the_line_touches_it_from_a_saddle() {
    // The start has the wrong curvature.
    let (x, report) = solve(line_on_circle(), &[0.1, -0.3]);
    assert_eq!(report.status, Status::Solved);
    let half = 0.5_f64.sqrt();
    assert!(
        (x[0] - half).abs() < 1e-6 && (x[1] - half).abs() < 1e-6,
        "{x:?}"
    );
}

#[test]
fn repeated_rows_do_not_disturb() {
    for copies in [1, 2, 3, 7] {
        let (x, report) = solve(repeated_rows(copies), &[5.0, 5.0]);
        assert_eq!(report.status, Status::Solved, "{copies} copies");
        assert!((x[0] - 2.0 / 3.0).abs() < 1e-6, "{copies} copies: {x:?}");
    }
}

#[test]
fn rosenbrocks_valley_is_followed_to_its_end_or_to_the_disc() {
    let (x, report) = solve(rosenbrock_in_a_disc(4.0), &[-1.2, 1.0]);
    assert_eq!(report.status, Status::Solved);
    assert!(
        (x[0] - 1.0).abs() < 1e-4 && (x[1] - 1.0).abs() < 1e-4,
        "{x:?}"
    );
    assert!(report.iterations <= 60, "{} iterations", report.iterations);
    // The unit disc: 0.0456748 at (0.7864, 0.6177), the row's multiplier is positive at its upper bound.
    let (x, report) = solve(rosenbrock_in_a_disc(1.0), &[-0.5, 0.5]);
    assert_eq!(report.status, Status::Solved);
    assert!((report.objective - 0.045_674_8).abs() < 1e-6, "{x:?}");
    assert!(report.multipliers[0] > 0.01);
}

#[test]
fn a_concave_cost_ends_at_a_vertex() {
    // min −x² − y² on [−1, 2]²: indefinite everywhere, the corner (2, 2) from its side.
    let p = dense(&[-1.0; 2], &[2.0; 2], &[], |x, _, out| {
        out.objective = -x[0] * x[0] - x[1] * x[1];
        out.gradient.copy_from_slice(&[-2.0 * x[0], -2.0 * x[1]]);
        out.hessian.copy_from_slice(&[-2.0, 0.0, 0.0, -2.0]);
    });
    let (x, report) = solve(p, &[0.9, 1.1]);
    assert_eq!(report.status, Status::Solved);
    assert!(x[0] > 2.0 - 1e-4 && x[1] > 2.0 - 1e-4, "{x:?}");
}

#[test]
fn a_linear_program_ends_at_its_vertex() {
    // min −x − 2y with x + y ≤ 4, x + 3y ≤ 6, x, y ≥ 0: (3, 1), −5. No curvature at all.
    let rows = [(-INF, 4.0), (-INF, 6.0)];
    let p = dense(&[0.0; 2], &[INF; 2], &rows, |x, _, out| {
        out.objective = -x[0] - 2.0 * x[1];
        out.values
            .copy_from_slice(&[x[0] + x[1], x[0] + 3.0 * x[1]]);
        out.gradient.copy_from_slice(&[-1.0, -2.0]);
        out.jacobians[0].copy_from_slice(&[1.0, 1.0, 1.0, 3.0]);
        out.hessian.fill(0.0);
    });
    let (x, report) = solve(p, &[0.5, 0.5]);
    assert_eq!(report.status, Status::Solved);
    assert!(
        (x[0] - 3.0).abs() < 1e-5 && (x[1] - 1.0).abs() < 1e-5,
        "{x:?}"
    );
    // y = −∂f*/∂b: 1/2 for each row.
    for y in &report.multipliers {
        assert!((y - 0.5).abs() < 1e-5, "{:?}", report.multipliers);
    }
}

#[test]
fn the_maratos_effect_does_not_slow_it() {
    // min 2(x² + y² − 1) − x on the unit circle, from (cos 0.9, sin 0.9): full steps raise both cost and violation near
    // the optimum (1, 0), so a filter needs its second-order correction.
    let p = dense(&[-INF; 2], &[INF; 2], &[(1.0, 1.0)], |x, y, out| {
        let c = x[0] * x[0] + x[1] * x[1];
        out.objective = 2.0 * (c - 1.0) - x[0];
        out.values[0] = c;
        out.gradient
            .copy_from_slice(&[4.0 * x[0] - 1.0, 4.0 * x[1]]);
        out.jacobians[0].copy_from_slice(&[2.0 * x[0], 2.0 * x[1]]);
        let h = 4.0 + 2.0 * y[0];
        out.hessian.copy_from_slice(&[h, 0.0, 0.0, h]);
    });
    let (x, report) = solve(p, &[0.9_f64.cos(), 0.9_f64.sin()]);
    assert_eq!(report.status, Status::Solved);
    assert!((x[0] - 1.0).abs() < 1e-6, "{x:?}");
    assert!(report.iterations <= 25, "{} iterations", report.iterations);
}
