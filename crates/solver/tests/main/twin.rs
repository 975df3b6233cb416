//! Whole solves against dense twins: random quadratic programs with elements of irregular sizes. With equality rows only,
//! the answer is one dense linear system; with inequalities, the answer carries its own certificate.

use crate::front::Random;
use crate::quadratic::{Coefficients, Quadratic};
use crate::samples::INF;
use solver::{BlockStructure, ElementStructure, InteriorPoint, Options, Report, Status, Structure};

/// Solves A x = b by elimination with row exchange; A as rows.
fn gauss(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        let pivot = (k..n)
            .max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()))
            .expect("a row is left");
        assert!(a[pivot][k].abs() > 1e-12, "the twin's matrix is singular");
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            for j in k..n {
                a[i][j] -= factor * a[k][j];
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    b
}

/// Variables of each element and, per block, its rows and columns.
type Shape<'a> = &'a [(&'a [usize], &'a [(usize, &'a [usize])])];

/// Carried variables, an element without rows, one of a single variable, one without variables of its own, two blocks.
const IRREGULAR: Shape<'static> = &[
    (&[0, 1, 2, 11], &[(1, &[0, 1]), (1, &[1, 2, 3])]),
    (&[2, 3, 11], &[]),
    (&[3, 2], &[(1, &[1, 0])]),
    (&[4, 3, 5, 11], &[(2, &[0, 1, 2, 3])]),
    (&[5], &[]),
    (&[5, 6, 7, 8, 11], &[(1, &[4, 0])]),
    (&[8, 9, 10], &[(1, &[0, 1, 2]), (1, &[2])]),
];

/// Random convex coefficients on a shape; every row with the bounds that `bounds` draws about its value at a point within
/// [−0.3, 0.3], which so is feasible.
fn random_program(
    shape: Shape<'_>,
    random: &mut Random,
    mut bounds: impl FnMut(&mut Random, f64) -> (f64, f64),
) -> Quadratic {
    let n_vars = 1 + shape.iter().flat_map(|s| s.0).max().expect("variables");
    let mut structure = Structure {
        n_vars,
        lower: vec![-INF; n_vars],
        upper: vec![INF; n_vars],
        elements: vec![],
    };
    let feasible: Vec<f64> = (0..n_vars).map(|_| 0.3 * random.next()).collect();
    let mut elements = Vec::new();
    for (vars, blocks) in shape {
        let n = vars.len();
        let mut element = ElementStructure {
            vars: vars.to_vec(),
            ..ElementStructure::default()
        };
        let g: Vec<f64> = (0..n * n).map(|_| random.next()).collect();
        let mut c = Coefficients {
            hessian: vec![0.0; n * n],
            gradient: (0..n).map(|_| 3.0 * random.next()).collect(),
            jacobians: vec![],
        };
        for i in 0..n {
            for j in 0..n {
                c.hessian[j * n + i] = (0..n).map(|k| g[i * n + k] * g[j * n + k]).sum::<f64>()
                    + if i == j { 0.3 } else { 0.0 };
            }
        }
        for &(n_rows, cols) in *blocks {
            element.blocks.push(BlockStructure {
                first_row: element.row_lower.len(),
                n_rows,
                cols: cols.to_vec(),
            });
            let entries = n_rows * cols.len();
            let a: Vec<f64> = (0..entries).map(|_| random.next()).collect();
            for row in 0..n_rows {
                let terms = cols.iter().enumerate();
                let value = terms.map(|(k, &c)| a[k * n_rows + row] * feasible[vars[c]]);
                let (l, u) = bounds(random, value.sum());
                element.row_lower.push(l);
                element.row_upper.push(u);
            }
            c.jacobians.push(a);
        }
        structure.elements.push(element);
        elements.push(c);
    }
    Quadratic {
        structure,
        elements,
    }
}

fn solve(program: &mut Quadratic, start: f64) -> (Vec<f64>, Report) {
    let structure = program.structure.clone();
    let mut x = vec![start; structure.n_vars];
    let options = Options {
        feasibility_tolerance: 1e-9,
        dual_tolerance: 1e-9,
        complementarity_tolerance: 1e-9,
        min_barrier: 1e-12,
        ..Options::default()
    };
    let report =
        InteriorPoint::new(&structure).solve(program, &mut x, &options, None, &mut |_| true);
    (x, report)
}

/// Compares a solve with the dense system [H Aᵀ; A 0] [x; y] = [−g; b].
fn assert_twin(program: &mut Quadratic) {
    let (h, g) = program.dense_objective();
    let rows = program.dense_rows();
    let (n, m) = (g.len(), rows.len());
    let mut matrix = vec![vec![0.0; n + m]; n + m];
    let mut rhs: Vec<f64> = g.iter().map(|g| -g).collect();
    for i in 0..n {
        for j in 0..n {
            matrix[i][j] = h[j][i];
        }
        for (r, row) in rows.iter().enumerate() {
            matrix[i][n + r] = row.0[i];
            matrix[n + r][i] = row.0[i];
        }
    }
    rhs.extend(rows.iter().map(|row| row.1));
    let expected = gauss(matrix, rhs);

    let (x, report) = solve(program, 0.5);
    assert_eq!(report.status, Status::Solved);
    for (i, (found, expected)) in x
        .iter()
        .chain(&report.multipliers)
        .zip(&expected)
        .enumerate()
    {
        assert!(
            (found - expected).abs() < 1e-7 * expected.abs().max(1.0),
            "entry {i} of (x, y): {found} instead of {expected}"
        );
    }
    assert!(report.iterations <= 12, "{} iterations", report.iterations);
}

#[test]
fn equality_programs_of_irregular_elements_match_the_dense_system() {
    for seed in 0..20 {
        let mut random = Random(seed);
        let mut program = random_program(IRREGULAR, &mut random, |_, b| (b, b));
        assert_twin(&mut program);
    }
}

/// Unknowns that stand twice: next to each other, apart, in rows of all sizes, eliminated and carried.
const REPEATED: Shape<'static> = &[
    (
        &[0, 1, 2, 0, 1, 2, 7],
        &[(1, &[0, 1, 3, 4]), (1, &[5, 3, 2, 1, 0, 6])],
    ),
    (&[2, 3, 4, 3, 2, 7], &[(1, &[0, 4, 1, 2, 3])]),
    (&[4, 4, 5], &[]),
    (&[6, 5, 7, 5, 6], &[(2, &[4, 3, 2, 1, 0])]),
];

#[test]
fn unknowns_that_stand_twice_match_the_dense_system() {
    for seed in 0..20 {
        let mut random = Random(500 + seed);
        assert_twin(&mut random_program(REPEATED, &mut random, |_, b| (b, b)));
    }
    // In a block for the dense kernel.
    let vars: Vec<usize> = (0..25).chain(10..25).collect();
    let cols: Vec<usize> = (0..40).collect();
    let blocks = [(15, cols.as_slice())];
    let mut random = Random(600);
    let shape: Shape<'_> = &[(&vars, &blocks), (&[24, 25, 24], &[])];
    assert_twin(&mut random_program(shape, &mut random, |_, b| (b, b)));
}

#[test]
fn fixed_unknowns_that_stand_twice_stay_and_the_others_are_best() {
    for seed in 0..20 {
        let mut random = Random(700 + seed);
        let mut program = random_program(REPEATED, &mut random, |_, b| (b - 0.5, b + 0.5));
        for fixed in [1, 3, 7] {
            program.structure.lower[fixed] = 0.1;
            program.structure.upper[fixed] = 0.1;
        }
        let (x, report) = solve(&mut program, 0.5);
        assert_eq!(report.status, Status::Solved, "seed {seed}");
        assert_optimal(&program, &x, &report.multipliers);
    }
}

#[test]
fn wide_blocks_match_the_dense_system() {
    // More than 600 Jacobian entries in one block: the dense kernel of the condensation.
    let vars: Vec<usize> = (0..40).collect();
    let last: Vec<usize> = (30..45).collect();
    let (cols, last_cols): (Vec<usize>, Vec<usize>) = ((0..40).rev().collect(), (0..15).collect());
    let blocks = [(20, cols.as_slice())];
    let last_blocks = [(5, last_cols.as_slice())];
    let mut random = Random(77);
    let mut program = random_program(
        &[(&vars, &blocks), (&last, &last_blocks)],
        &mut random,
        |_, b| (b, b),
    );
    assert_twin(&mut program);
}

/// Checks the certificate of optimality: ∇f + Aᵀy − zl + zu = 0 with multipliers of the right sign on active bounds only.
fn assert_optimal(program: &Quadratic, x: &[f64], y: &[f64]) {
    const TOLERANCE: f64 = 1e-6;
    for (i, ((row, l, u), y)) in program.dense_rows().iter().zip(y).enumerate() {
        let value: f64 = row.iter().zip(x).map(|(a, x)| a * x).sum();
        assert!(
            value >= l - TOLERANCE && value <= u + TOLERANCE,
            "row {i}: {value} outside [{l}, {u}]"
        );
        if l < u {
            let at_upper = (u - value).abs() < 1e-4;
            let at_lower = (value - l).abs() < 1e-4;
            assert!(
                *y < TOLERANCE || at_upper,
                "row {i}: {y} off its upper bound"
            );
            assert!(
                *y > -TOLERANCE || at_lower,
                "row {i}: {y} off its lower bound"
            );
        }
    }
    for (i, r) in program.stationarity(x, y).iter().enumerate() {
        let (l, u) = (program.structure.lower[i], program.structure.upper[i]);
        assert!(
            x[i] >= l - 1e-12 && x[i] <= u + 1e-12,
            "variable {i}: {}",
            x[i]
        );
        // r = zl − zu.
        assert!(
            *r < TOLERANCE || x[i] - l < 1e-4,
            "variable {i}: {r} off its lower bound"
        );
        assert!(
            *r > -TOLERANCE || u - x[i] < 1e-4,
            "variable {i}: {r} off its upper bound"
        );
    }
}

#[test]
fn inequality_programs_carry_their_certificate() {
    let mut active = 0;
    for seed in 0..30 {
        let mut random = Random(1000 + seed);
        // One- and two-sided rows, no equality.
        let mut program = random_program(IRREGULAR, &mut random, |r, b| {
            let (l, u) = (b - 0.1 * r.next().abs(), b + 0.1 * r.next().abs());
            match (r.next() * 3.0) as i32 {
                0 => (l, u),
                1 | 2 => (l, INF),
                _ => (-INF, u),
            }
        });
        let (x, report) = solve(&mut program, 2.0);
        assert_eq!(report.status, Status::Solved, "seed {seed}");
        assert_optimal(&program, &x, &report.multipliers);
        assert!(report.iterations <= 40, "{} iterations", report.iterations);
        active += report.multipliers.iter().filter(|y| y.abs() > 1e-3).count();
    }
    assert!(
        active > 30,
        "only {active} rows were active: the test proves little"
    );
}

#[test]
fn mixed_programs_with_bounds_carry_their_certificate() {
    for seed in 0..30 {
        let mut random = Random(2000 + seed);
        let mut program = random_program(IRREGULAR, &mut random, |r, b| {
            if r.next() < 0.0 {
                (b, b)
            } else {
                (b - 0.2, b + 0.2)
            }
        });
        for i in 0..program.structure.n_vars {
            match i % 4 {
                0 => program.structure.lower[i] = -0.4,
                1 => program.structure.upper[i] = 0.4,
                2 => (program.structure.lower[i], program.structure.upper[i]) = (-0.6, 0.6),
                _ => (),
            }
        }
        let (x, report) = solve(&mut program, 5.0);
        assert_eq!(report.status, Status::Solved, "seed {seed}");
        assert_optimal(&program, &x, &report.multipliers);
        assert!(report.iterations <= 60, "{} iterations", report.iterations);
    }
}
