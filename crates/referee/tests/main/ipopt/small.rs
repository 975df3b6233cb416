//! Small programs: both solvers find the known optimum.

use crate::charts::{Marks, Placed};
use crate::samples::{
    Dense, INF, dense, hock_schittkowski_71, line_on_circle, repeated_rows, rosenbrock_in_a_disc,
};
use nalgebra::Vector6;
use referee::{IpoptOptions, IpoptStatus, solve_with_ipopt};
use solver::{InteriorPoint, Options, Problem, Status};
use spatial::Pose;

/// Solves with both from one start and compares point and objective.
fn agree(mut problem: Dense, start: &[f64], optimum: f64) {
    let start = start.to_vec();
    let (theirs, report) = solve_with_ipopt(&mut problem, &start, &[], &IpoptOptions::default());
    assert_eq!(report.status, IpoptStatus::Solved, "{report:?}");
    let structure = problem.structure.clone();
    let options = Options {
        dual_tolerance: 1e-7,
        complementarity_tolerance: 1e-7,
        ..Options::default()
    };
    let mut ours = start;
    let own =
        InteriorPoint::new(&structure)
            .solve(&mut problem, &mut ours, &options, None, &mut |_| true);
    assert_eq!(own.status, Status::Solved);
    let tolerance = 1e-5 * optimum.abs().max(1.0);
    assert!(
        (own.objective - optimum).abs() < tolerance,
        "ours: {}",
        own.objective
    );
    assert!(
        (report.objective - optimum).abs() < tolerance,
        "IPOPT: {}",
        report.objective
    );
    for (a, b) in ours.iter().zip(&theirs) {
        assert!((a - b).abs() < 1e-3, "{ours:?} and {theirs:?}");
    }
}

#[test]
fn hock_schittkowski_71_agrees() {
    agree(hock_schittkowski_71(), &[1.0, 5.0, 5.0, 1.0], 17.014_017_3);
}

#[test]
fn the_circle_agrees() {
    agree(line_on_circle(), &[0.1, -0.3], -(2.0_f64.sqrt()));
}

#[test]
fn rosenbrock_in_a_disc_agrees() {
    // A disc that holds the plain optimum, and the unit disc, whose edge is active (0.0456748).
    agree(rosenbrock_in_a_disc(4.0), &[-1.2, 1.0], 0.0);
    agree(rosenbrock_in_a_disc(1.0), &[-0.5, 0.5], 0.045_674_8);
}

#[test]
fn repeated_rows_agree() {
    // More equality rows than variables are refused by IPOPT; two copies of one row are not.
    agree(repeated_rows(2), &[5.0, 5.0], 2.0 / 3.0);
}

#[test]
fn a_body_turned_by_two_radians_finds_its_place_in_both() {
    // One chart about the start serves all of IPOPT's way.
    let target = Pose::from_translation(0.2, -0.1, 0.8);
    let start = Placed {
        world_from_body: target.plus(&Vector6::new(0.3, -0.2, 0.4, 1.2, -1.0, 1.2)),
        s: 1.0,
    };
    let mut problem = Marks::new(target);
    let (theirs, report) = solve_with_ipopt(&mut problem, &start, &[1], &IpoptOptions::default());
    assert_eq!(report.status, IpoptStatus::Solved, "{report:?}");
    let structure = problem.structure().clone();
    let options = Options {
        dual_tolerance: 1e-7,
        complementarity_tolerance: 1e-7,
        ..Options::default()
    };
    let mut ours = start;
    let own =
        InteriorPoint::new(&structure)
            .solve(&mut problem, &mut ours, &options, None, &mut |_| true);
    assert_eq!(own.status, Status::Solved);
    assert!(
        (own.objective - report.objective).abs() < 1e-5,
        "{} and {report:?}",
        own.objective
    );
    let apart = ours.world_from_body.minus(&theirs.world_from_body);
    assert!(
        apart.amax() < 1e-4 && (ours.s - theirs.s).abs() < 1e-4,
        "{ours:?} and {theirs:?}"
    );
    assert!(report.iterations < 40, "{report:?}");
}

#[test]
fn contradicting_rows_are_infeasible_for_both() {
    // x₀ = 0 and x₀ + x₁² = −1; x₁ alone gives the second row something to move.
    let mut problem = dense(
        &[-INF; 2],
        &[INF; 2],
        &[(0.0, 0.0), (-1.0, -1.0)],
        |x, y, out| {
            out.objective = x[1];
            out.values.copy_from_slice(&[x[0], x[0] + x[1] * x[1]]);
            out.gradient.copy_from_slice(&[0.0, 1.0]);
            out.jacobians[0].copy_from_slice(&[1.0, 1.0, 0.0, 2.0 * x[1]]);
            out.hessian.copy_from_slice(&[0.0, 0.0, 0.0, 2.0 * y[1]]);
        },
    );
    let start = vec![0.5, 0.5];
    let (_, report) = solve_with_ipopt(&mut problem, &start, &[], &IpoptOptions::default());
    assert_eq!(report.status, IpoptStatus::Infeasible, "{report:?}");
    assert!(report.violation > 0.3, "{report:?}");
    let structure = problem.structure.clone();
    let mut x = start;
    let own = InteriorPoint::new(&structure).solve(
        &mut problem,
        &mut x,
        &Options::default(),
        None,
        &mut |_| true,
    );
    assert_ne!(own.status, Status::Solved);
    assert!(own.violation > 0.3);
}

#[test]
#[should_panic(expected = "the problem broke")]
fn a_panic_in_the_problem_comes_back_as_a_panic() {
    let mut problem = dense(&[-INF], &[INF], &[], |x, _, out| {
        assert!(x[0] < 1.5, "the problem broke");
        out.objective = (x[0] - 2.0).powi(2);
        out.gradient[0] = 2.0 * (x[0] - 2.0);
        out.hessian[0] = 2.0;
    });
    let _ = solve_with_ipopt(&mut problem, &vec![0.0], &[], &IpoptOptions::default());
}
