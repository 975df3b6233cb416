//! Multifrontal factorisation against a dense solution, on fronts of irregular sizes.

use solver::front::{Fronts, NotPositiveDefinite};
use solver::{BlockStructure, ElementStructure, Structure};

/// A small reproducible generator (splitmix64) for test data.
pub struct Random(pub u64);

impl Random {
    /// Uniform in [−1, 1).
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

fn structure(vars: &[&[usize]], n_vars: usize) -> Structure {
    let elements = vars
        .iter()
        .map(|v| ElementStructure {
            vars: v.to_vec(),
            blocks: Vec::<BlockStructure>::new(),
            ..Default::default()
        })
        .collect();
    Structure {
        n_vars,
        lower: vec![],
        upper: vec![],
        elements,
    }
}

/// Random element matrices G Gᵀ + shift and the dense sum.
fn random_matrices(s: &Structure, shift: f64) -> (Vec<Vec<f64>>, Vec<f64>) {
    let mut random = Random(7);
    let n = s.n_vars;
    let mut dense = vec![0.0; n * n];
    let mut local = Vec::new();
    for e in &s.elements {
        let k = e.vars.len();
        let g: Vec<f64> = (0..k * k).map(|_| random.next()).collect();
        let mut a = vec![0.0; k * k];
        for i in 0..k {
            for j in 0..k {
                a[j * k + i] = (0..k).map(|l| g[i * k + l] * g[j * k + l]).sum::<f64>()
                    + if i == j { shift } else { 0.0 };
                dense[e.vars[j] * n + e.vars[i]] += a[j * k + i];
            }
        }
        local.push(a);
    }
    (local, dense)
}

/// Factorises random positive definite elements and compares the solution for a random right-hand side with the dense matrix.
fn solves_a_random_system(s: &Structure, seed: u64) {
    let (local, dense) = random_matrices(s, 0.5);
    let mut fronts = Fronts::new(s);
    fronts
        .factorise(|e, front| {
            let k = s.elements[e].vars.len();
            for j in 0..k {
                for i in j..k {
                    front.add(i, j, local[e][j * k + i]);
                }
            }
        })
        .expect("positive definite by construction");
    let mut random = Random(seed);
    let rhs: Vec<f64> = (0..s.n_vars).map(|_| random.next()).collect();
    let mut x = rhs.clone();
    fronts.solve(&mut x);
    for (i, b) in rhs.iter().enumerate() {
        let ax: f64 = (0..s.n_vars).map(|j| dense[j * s.n_vars + i] * x[j]).sum();
        assert!((ax - b).abs() < 1e-10, "row {i}: {ax} instead of {b}");
    }
}

#[test]
fn the_fronts_solve_what_the_dense_matrix_says() {
    // Irregular overlaps: a variable carried across two elements, an element without own variables, one of one.
    let s = structure(
        &[
            &[0, 1, 2, 9],
            &[2, 3, 9],
            &[3, 2],
            &[4, 3, 5, 9],
            &[5],
            &[5, 6, 7, 8, 9],
        ],
        10,
    );
    solves_a_random_system(&s, 3);
}

#[test]
fn both_halves_of_many_fronts_meet_in_the_middle() {
    // A chain of elements of changing widths; one variable that all touch, one of the first and the last element alone, one
    // element without a variable that it touches alone.
    let n = 40;
    let vars: Vec<Vec<usize>> = (0..n)
        .map(|e| {
            let mut vars = vec![e, e + 1, n + 1];
            vars.extend((e % 3 == 0).then_some(n + 3 + e / 3));
            vars.extend((e == 0 || e + 1 == n).then_some(n + 2));
            vars.extend((e % 7 == 2).then_some(e + 4));
            vars
        })
        .collect();
    let borrowed: Vec<&[usize]> = vars.iter().map(Vec::as_slice).collect();
    let n_vars = n + 3 + n.div_ceil(3);
    let s = structure(&borrowed, n_vars.max(n + 6));
    solves_a_random_system(&s, 5);
}

#[test]
fn an_indefinite_matrix_is_reported() {
    let s = structure(&[&[0, 1], &[1, 2]], 3);
    let mut fronts = Fronts::new(&s);
    let result = fronts.factorise(|e, front| {
        front.add(0, 0, 1.0);
        front.add(1, 1, if e == 0 { 1.0 } else { -5.0 });
    });
    assert_eq!(result, Err(NotPositiveDefinite));
}
