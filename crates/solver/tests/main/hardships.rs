//! What goes wrong: infeasible programs, functions without values, degenerate bounds, limits, callers that stop.

use crate::programs::solve;
use crate::samples::{Dense, INF, dense, hock_schittkowski_71};
use solver::{Contradiction, Enough, InteriorPoint, Options, Problem, Report, Status};

fn solve_with(
    mut problem: Dense,
    start: &[f64],
    options: &Options,
    observe: &mut dyn FnMut(&solver::Iteration) -> bool,
) -> (Vec<f64>, Report) {
    let mut x = start.to_vec();
    let structure = problem.structure().clone();
    let report = InteriorPoint::new(&structure).solve(&mut problem, &mut x, options, None, observe);
    (x, report)
}

/// ½ Σ (x − goal)² with bounds and no rows.
fn nearest(goal: [f64; 2], lower: [f64; 2], upper: [f64; 2]) -> Dense {
    dense(&lower, &upper, &[], move |x, _, out| {
        out.objective = 0.5 * ((x[0] - goal[0]).powi(2) + (x[1] - goal[1]).powi(2));
        out.gradient
            .copy_from_slice(&[x[0] - goal[0], x[1] - goal[1]]);
        out.hessian.copy_from_slice(&[1.0, 0.0, 0.0, 1.0]);
    })
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

/// x² = −1 with the cost x: nothing meets it, x = 0 comes closest.
fn no_square_is_negative() -> Dense {
    dense(&[-INF], &[INF], &[(-1.0, -1.0)], |x, y, out| {
        out.objective = x[0];
        out.values[0] = x[0] * x[0];
        out.gradient[0] = 1.0;
        out.jacobians[0][0] = 2.0 * x[0];
        out.hessian[0] = 2.0 * y[0];
    })
}

#[test]
fn an_infeasible_program_returns_the_least_violated_point_it_has_seen() {
    let mut seen = f64::INFINITY;
    let (x, report) = solve_with(
        no_square_is_negative(),
        &[2.0],
        &Options::default(),
        &mut |i| {
            seen = seen.min(i.violation);
            true
        },
    );
    assert_ne!(report.status, Status::Solved);
    assert!(
        report.violation <= seen,
        "{} but saw {seen}",
        report.violation
    );
    assert!(report.violation < 1.05, "{} at {x:?}", report.violation);
    // The report speaks of the point returned.
    assert!((report.rows[0] - x[0] * x[0]).abs() < 1e-12);
    assert!((report.objective - x[0]).abs() < 1e-12);
    assert!((report.violation - (x[0] * x[0] + 1.0)).abs() < 1e-12);
}

#[test]
fn rows_beyond_the_bounds_end_as_not_solved() {
    // x + y ≥ 3 on the unit square: 1 short.
    let p = dense(&[0.0; 2], &[1.0; 2], &[(3.0, INF)], |x, _, out| {
        out.objective = x[0];
        out.values[0] = x[0] + x[1];
        out.gradient.copy_from_slice(&[1.0, 0.0]);
        out.jacobians[0].copy_from_slice(&[1.0, 1.0]);
        out.hessian.fill(0.0);
    });
    let (x, report) = solve(p, &[0.5, 0.5]);
    assert_ne!(report.status, Status::Solved);
    assert!(
        report.violation >= 1.0 - 1e-9 && report.violation < 1.2,
        "{x:?}"
    );
    assert!(x.iter().all(|x| (0.0..=1.0).contains(x)), "{x:?}");
}

#[test]
fn a_cost_without_value_at_a_trial_point_makes_the_search_back_off() {
    // x − ln x from 3: the Newton step leads to −3, where the logarithm has no value.
    let p = dense(&[-INF], &[INF], &[], |x, _, out| {
        out.objective = x[0] - x[0].ln();
        out.gradient[0] = 1.0 - 1.0 / x[0];
        out.hessian[0] = 1.0 / (x[0] * x[0]);
    });
    let (x, report) = solve(p, &[3.0]);
    assert_eq!(report.status, Status::Solved);
    assert!((x[0] - 1.0).abs() < 1e-5, "{x:?}");
}

#[test]
fn a_row_without_value_at_a_trial_point_makes_the_search_back_off() {
    // √x = 2 from 400: linearised, the row vanishes at −320.
    let p = dense(&[-INF], &[INF], &[(2.0, 2.0)], |x, y, out| {
        let root = x[0].sqrt();
        out.objective = 0.0;
        out.values[0] = root;
        out.gradient[0] = 0.0;
        out.jacobians[0][0] = 0.5 / root;
        out.hessian[0] = -0.25 * y[0] / (root * x[0]);
    });
    let (x, report) = solve(p, &[400.0]);
    assert_eq!(report.status, Status::Solved);
    assert!((x[0] - 4.0).abs() < 1e-4, "{x:?}");
}

#[test]
fn a_row_that_overflows_at_a_trial_point_makes_the_search_back_off() {
    // eˣ = 1 from −8: the first step is hundreds long, where the row is infinite.
    let p = dense(&[-INF], &[INF], &[(1.0, 1.0)], |x, y, out| {
        let e = x[0].exp();
        out.objective = 0.0;
        out.values[0] = e;
        out.gradient[0] = 0.0;
        out.jacobians[0][0] = e;
        out.hessian[0] = y[0] * e;
    });
    let (x, report) = solve(p, &[-8.0]);
    assert_eq!(report.status, Status::Solved);
    assert!(x[0].abs() < 1e-5, "{x:?}");
}

#[test]
fn a_start_without_value_fails_without_a_panic() {
    let p = dense(&[-INF], &[INF], &[], |x, _, out| {
        out.objective = x[0].ln();
        out.gradient[0] = x[0].ln();
        out.hessian[0] = 1.0;
    });
    let (_, report) = solve(p, &[-1.0]);
    assert_ne!(report.status, Status::Solved);
}

#[test]
fn starts_outside_and_on_bounds_are_moved_inside() {
    let (x, report) = solve(nearest([0.3, 2.0], [0.0; 2], [1.0; 2]), &[-50.0, 1.0]);
    assert_eq!(report.status, Status::Solved);
    assert!(
        (x[0] - 0.3).abs() < 1e-4 && (x[1] - 1.0).abs() < 1e-4,
        "{x:?}"
    );
    assert!(x[1] <= 1.0);
}

#[test]
fn bounds_a_hair_apart_hold_their_variable() {
    for gap in [1e-3, 1e-6, 1e-9] {
        let (x, report) = solve(
            nearest([5.0, 2.0], [1.0, -INF], [1.0 + gap, INF]),
            &[0.0, 0.0],
        );
        assert_eq!(report.status, Status::Solved, "gap {gap}");
        assert!((1.0..=1.0 + gap).contains(&x[0]), "gap {gap}: {x:?}");
        assert!((x[1] - 2.0).abs() < 1e-5, "gap {gap}: {x:?}");
    }
}

#[test]
fn equal_bounds_fix_their_variable() {
    let (x, report) = solve(nearest([5.0, 2.0], [1.0, -INF], [1.0, INF]), &[0.0, 0.0]);
    assert_eq!(report.status, Status::Solved);
    assert!(
        (x[0] - 1.0).abs() < 1e-6 && (x[1] - 2.0).abs() < 1e-5,
        "{x:?}"
    );
}

#[test]
fn fixed_variables_leave_the_others_the_program_without_them() {
    // Hock and Schittkowski 71 with the first two variables held: both kinds of rows and a full Hessian touch them. The
    // equality then reads x₃² + x₄² = 40 − 1 − 4.743²; the optimum of the whole program solves this one too.
    let mut held = hock_schittkowski_71();
    for (v, value) in [(0, 1.0), (1, 4.743)] {
        held.structure.lower[v] = value;
        held.structure.upper[v] = value;
    }
    let (x, report) = solve(held, &[4.0, 2.0, 3.0, 2.0]);
    assert_eq!(report.status, Status::Solved);
    assert!((x[0] - 1.0).abs() < 1e-12 && (x[1] - 4.743).abs() < 1e-12);
    assert!(
        (report.objective - 17.014_017_3).abs() < 1e-4,
        "{} at {x:?}",
        report.objective
    );
    assert!(report.iterations <= 30, "{} iterations", report.iterations);
}

#[test]
fn a_row_that_only_fixed_variables_could_meet_is_not_solved() {
    let p = dense(&[1.0, -INF], &[1.0, INF], &[(3.0, 3.0)], |x, _, out| {
        out.objective = x[1] * x[1];
        out.values[0] = x[0];
        out.gradient.copy_from_slice(&[0.0, 2.0 * x[1]]);
        out.jacobians[0].copy_from_slice(&[1.0, 0.0]);
        out.hessian.copy_from_slice(&[0.0, 0.0, 0.0, 2.0]);
    });
    let (x, report) = solve(p, &[0.0, 1.0]);
    assert_ne!(report.status, Status::Solved);
    assert!((report.violation - 2.0).abs() < 1e-12, "{x:?}");
}

#[test]
fn blocks_without_rows_or_columns_change_nothing() {
    let mut empty = hock_schittkowski_71();
    let blocks = &mut empty.structure.elements[0].blocks;
    for (n_rows, cols) in [(0, vec![0, 2]), (0, vec![])] {
        blocks.push(solver::BlockStructure {
            first_row: 2,
            n_rows,
            cols,
        });
    }
    let start = [1.0, 5.0, 5.0, 1.0];
    let (plain, _) = solve(hock_schittkowski_71(), &start);
    let (x, report) = solve(empty, &start);
    assert_eq!(report.status, Status::Solved);
    assert_eq!(x, plain);
}

#[test]
fn a_row_with_bounds_a_hair_apart_is_met() {
    for gap in [1e-3, 1e-6, 1e-9] {
        let p = dense(&[-INF; 2], &[INF; 2], &[(1.0, 1.0 + gap)], |x, _, out| {
            out.objective = 0.5 * (x[0] * x[0] + x[1] * x[1]);
            out.values[0] = x[0] + x[1];
            out.gradient.copy_from_slice(&[x[0], x[1]]);
            out.jacobians[0].copy_from_slice(&[1.0, 1.0]);
            out.hessian.copy_from_slice(&[1.0, 0.0, 0.0, 1.0]);
        });
        let (x, report) = solve(p, &[3.0, -4.0]);
        assert_eq!(report.status, Status::Solved, "gap {gap}");
        assert!(
            (x[0] - 0.5).abs() < 1e-3 && (x[1] - 0.5).abs() < 1e-3,
            "gap {gap}: {x:?}"
        );
    }
}

#[test]
fn an_observer_ends_the_solve() {
    let mut lines = Vec::new();
    let (_, report) = solve_with(
        hock_schittkowski_71(),
        &[1.0, 5.0, 5.0, 1.0],
        &Options::default(),
        &mut |i| {
            lines.push(i.number);
            i.number < 3
        },
    );
    assert_eq!(report.status, Status::Interrupted);
    assert_eq!(lines, [0, 1, 2, 3]);
    assert_eq!(report.iterations, 3);
}

#[test]
fn limits_of_iterations_and_time_end_the_solve() {
    let start = [1.0, 5.0, 5.0, 1.0];
    let few = Options {
        max_iterations: 2,
        ..Options::default()
    };
    let (_, report) = solve_with(hock_schittkowski_71(), &start, &few, &mut |_| true);
    assert_eq!(
        (report.status, report.iterations),
        (Status::IterationLimit, 2)
    );
    let no_time = Options {
        time_limit: 0.0,
        ..Options::default()
    };
    let (x, report) = solve_with(hock_schittkowski_71(), &start, &no_time, &mut |_| true);
    assert_eq!(report.status, Status::Interrupted);
    assert!(x.iter().all(|x| (1.0..=5.0).contains(x)), "{x:?}");
}

#[test]
fn the_same_solve_twice_gives_the_same_bits() {
    let run = || solve(hock_schittkowski_71(), &[1.0, 5.0, 5.0, 1.0]);
    let ((a, first), (b, second)) = (run(), run());
    assert_eq!(a, b);
    assert_eq!(first.multipliers, second.multipliers);
}

#[test]
#[should_panic(expected = "every variable belongs to an element")]
fn a_variable_of_no_element_is_refused() {
    let mut structure = hock_schittkowski_71().structure;
    structure.n_vars = 5;
    let _ = InteriorPoint::<Dense>::new(&structure);
}

#[test]
fn crossed_bounds_are_named_and_nothing_is_tried() {
    let crossed_row = || {
        dense(&[-INF], &[INF], &[(2.0, 1.0)], |x, _, out| {
            out.objective = 0.0;
            out.values[0] = x[0];
            out.gradient[0] = 0.0;
            out.jacobians[0][0] = 1.0;
            out.hessian[0] = 0.0;
        })
    };
    assert_eq!(
        crossed_row().structure().contradiction(),
        Some(Contradiction::Row(0))
    );
    let (x, report) = solve(crossed_row(), &[5.0]);
    assert_eq!(
        (report.status, report.iterations),
        (Status::Contradictory, 0)
    );
    assert_eq!((x, report.violation), (vec![5.0], 4.0));
    let crossed_variable = nearest([0.0; 2], [0.0, 1.0], [1.0, -1.0]);
    let found = crossed_variable.structure().contradiction();
    assert_eq!(found, Some(Contradiction::Variable(1)));
    let (_, report) = solve(crossed_variable, &[0.5, 0.5]);
    assert_eq!(report.status, Status::Contradictory);
}

#[test]
fn a_solve_ends_where_the_point_is_as_near_to_a_solution_as_was_asked_for() {
    let solved_to = |enough| {
        let options = Options {
            enough,
            ..Options::default()
        };
        let start = [1.0, 5.0, 5.0, 1.0];
        solve_with(hock_schittkowski_71(), &start, &options, &mut |_| true).1
    };
    let enough = Enough {
        violation: 1e-2,
        dual: 1.0,
        barrier: 1e-2,
    };
    let (exact, report) = (solved_to(None), solved_to(Some(enough)));
    assert_eq!(exact.status, Status::Solved);
    assert_eq!(report.status, Status::Enough);
    assert!(report.iterations < exact.iterations);
    assert!(report.violation <= 1e-2 && report.violation > exact.violation);
    assert!((report.objective - 17.014).abs() < 0.5, "near the optimum");
    // Each of the three counts.
    let stricter = [
        Enough {
            violation: 1e-6,
            ..enough
        },
        Enough {
            dual: 1e-6,
            ..enough
        },
        Enough {
            barrier: 1e-6,
            ..enough
        },
    ];
    for enough in stricter {
        assert!(solved_to(Some(enough)).iterations > report.iterations);
    }
}
