//! A long chain in time: a mass is pushed from rest to rest over one metre with the least effort.
//!
//! p' = p + h v, v' = v + h u, minimise ½ h Σ u². With N pushes the optimum is a straight line from push to brake:
//! u_t = b ((N − 1 − t) − (N − 1)/2), b = 12 / (h² N (N² − 1)).

use crate::quadratic::{Coefficients, Quadratic};
use crate::samples::INF;
use solver::{BlockStructure, ElementStructure, InteriorPoint, Options, Report, Status, Structure};

const N: usize = 100;
const H: f64 = 0.1;

/// The chain; `redundant` adds to each element the sum and the double of its rows; |u| ≤ `limit`.
fn chain(redundant: bool, limit: f64) -> Quadratic {
    let n_vars = 3 * N + 2;
    let mut structure = Structure {
        n_vars,
        lower: vec![-INF; n_vars],
        upper: vec![INF; n_vars],
        elements: vec![],
    };
    let mut elements = Vec::new();
    for t in 0..N {
        // p, v, u, p', v'.
        let vars = vec![3 * t, 3 * t + 1, 3 * t + 2, 3 * t + 3, 3 * t + 4];
        structure.lower[3 * t + 2] = -limit;
        structure.upper[3 * t + 2] = limit;
        let mut rows: Vec<([f64; 5], f64)> = vec![
            ([-1.0, -H, 0.0, 1.0, 0.0], 0.0),
            ([0.0, -1.0, -H, 0.0, 1.0], 0.0),
        ];
        if redundant {
            rows.push(([-1.0, -1.0 - H, -H, 1.0, 1.0], 0.0));
            rows.push(([-2.0, -2.0 * H, 0.0, 2.0, 0.0], 0.0));
        }
        if t == 0 {
            rows.push(([1.0, 0.0, 0.0, 0.0, 0.0], 0.0));
            rows.push(([0.0, 1.0, 0.0, 0.0, 0.0], 0.0));
        }
        if t + 1 == N {
            rows.push(([0.0, 0.0, 0.0, 1.0, 0.0], 1.0));
            rows.push(([0.0, 0.0, 0.0, 0.0, 1.0], 0.0));
        }
        let m = rows.len();
        let mut hessian = vec![0.0; 25];
        hessian[2 * 5 + 2] = H;
        elements.push(Coefficients {
            hessian,
            gradient: vec![0.0; 5],
            jacobians: vec![
                (0..5 * m)
                    .map(|k| rows[k % m].0[k / m])
                    .collect::<Vec<f64>>(),
            ],
        });
        structure.elements.push(ElementStructure {
            vars,
            row_lower: rows.iter().map(|r| r.1).collect(),
            row_upper: rows.iter().map(|r| r.1).collect(),
            blocks: vec![BlockStructure {
                first_row: 0,
                n_rows: m,
                cols: (0..5).collect(),
            }],
        });
    }
    Quadratic {
        structure,
        elements,
    }
}

fn solve(program: Quadratic) -> (Vec<f64>, Report) {
    solve_on(1, program)
}

fn solve_on(threads: usize, mut program: Quadratic) -> (Vec<f64>, Report) {
    let structure = program.structure.clone();
    let mut x = vec![0.0; structure.n_vars];
    let options = Options {
        dual_tolerance: 1e-7,
        complementarity_tolerance: 1e-8,
        min_barrier: 1e-11,
        threads,
        ..Options::default()
    };
    let report =
        InteriorPoint::new(&structure).solve(&mut program, &mut x, &options, None, &mut |_| true);
    (x, report)
}

fn push(t: usize) -> f64 {
    let n = N as f64;
    let b = 12.0 / (H * H * n * (n * n - 1.0));
    b * ((n - 1.0 - t as f64) - 0.5 * (n - 1.0))
}

#[test]
fn the_least_effort_is_a_straight_line_from_push_to_brake() {
    let (x, report) = solve(chain(false, INF));
    assert_eq!(report.status, Status::Solved);
    for t in 0..N {
        let u = x[3 * t + 2];
        assert!(
            (u - push(t)).abs() < 1e-6,
            "push {t}: {u} instead of {}",
            push(t)
        );
    }
    assert!(report.iterations <= 10, "{} iterations", report.iterations);
}

#[test]
fn two_threads_give_the_same_bits_as_one() {
    let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
    let [(one, first), (two, second)] = [1, 2].map(|threads| solve_on(threads, chain(true, 0.4)));
    assert_eq!(first.status, Status::Solved);
    assert_eq!(bits(&one), bits(&two));
    assert_eq!(bits(&first.multipliers), bits(&second.multipliers));
}

#[test]
fn redundant_rows_all_along_a_chain_change_nothing() {
    let (x, report) = solve(chain(true, INF));
    assert_eq!(report.status, Status::Solved);
    for t in 0..N {
        let u = x[3 * t + 2];
        assert!(
            (u - push(t)).abs() < 1e-6,
            "push {t}: {u} instead of {}",
            push(t)
        );
    }
    assert!(report.iterations <= 10, "{} iterations", report.iterations);
}

#[test]
fn limited_pushes_saturate_at_both_ends_with_and_without_redundant_rows() {
    const LIMIT: f64 = 0.05; // the free optimum needs 0.0594
    let (plain, report) = solve(chain(false, LIMIT));
    assert_eq!(report.status, Status::Solved);
    assert!(report.iterations <= 40, "{} iterations", report.iterations);
    let (redundant, report) = solve(chain(true, LIMIT));
    assert_eq!(report.status, Status::Solved);
    assert!(report.iterations <= 40, "{} iterations", report.iterations);
    for t in 0..N {
        let (a, b) = (plain[3 * t + 2], redundant[3 * t + 2]);
        assert!((a - b).abs() < 1e-4, "push {t}: {a} and {b}");
        assert!(a.abs() <= LIMIT, "push {t}: {a}");
        let mirrored = plain[3 * (N - 1 - t) + 2];
        assert!(
            (a + mirrored).abs() < 1e-4,
            "push and brake mirror each other"
        );
    }
    assert!(plain[2] > LIMIT - 1e-4 && plain[3 * N - 1] < -LIMIT + 1e-4);
}

#[test]
fn a_limit_that_no_push_can_meet_is_not_solved() {
    // Push and brake at the limit cover about limit · (N h / 2)²: 0.25 m.
    let (_, report) = solve(chain(false, 0.01));
    assert_ne!(report.status, Status::Solved);
    assert!(report.violation > 1e-3, "{}", report.violation);
}

#[test]
fn the_factor_of_a_chain_grows_with_its_length_only() {
    let memory = |elements: usize| {
        let mut structure = chain(false, INF).structure;
        structure.elements.truncate(elements);
        structure.n_vars = 3 * elements + 2;
        InteriorPoint::<Quadratic>::new(&structure).memory() as f64
    };
    let (short, long) = (memory(25), memory(100));
    assert!(long < 4.5 * short, "{short} and {long} bytes");
}
