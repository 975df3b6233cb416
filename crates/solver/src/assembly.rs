//! Adding dense symmetric matrices to a front, piece by piece where neighbours stay neighbours.

use faer::linalg::matmul::matmul;
use faer::prelude::ReborrowMut;
use faer::{Accum, MatMut, MatRef, Par};

use crate::kernels::add_lower_product;

/// Position of what is in no front.
pub(crate) const NOWHERE: usize = usize::MAX;

/// Consecutive local indices whose positions in the front are consecutive too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Run {
    local: usize,
    front: usize,
    length: usize,
}

/// The runs of a list that gives the position in the front of each local index; without those that are nowhere.
pub(crate) fn runs(positions: impl IntoIterator<Item = usize>) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (local, front) in positions.into_iter().enumerate() {
        match runs.last_mut() {
            _ if front == NOWHERE => {}
            Some(run)
                if [run.local, run.front].map(|first| first + run.length) == [local, front] =>
            {
                run.length += 1;
            }
            _ => runs.push(Run {
                local,
                front,
                length: 1,
            }),
        }
    }
    runs
}

/// The front under assembly: the lower triangle, column-major, the eliminated columns apart from the others.
pub struct Assembly<'a> {
    pub(crate) panel: &'a mut [f64],
    pub(crate) schur: &'a mut [f64],
    pub(crate) n_front: usize,
    pub(crate) n_eliminated: usize,
    pub(crate) of_element: &'a [usize],
}

impl Assembly<'_> {
    /// Adds `value` at the element's local row `i` and column `j`; symmetric, give each pair once.
    #[inline]
    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        let places = (self.of_element[i], self.of_element[j]);
        if places.0 != NOWHERE && places.1 != NOWHERE {
            // Two local indices of the same unknown: the pair and its mirror image meet on the diagonal.
            let both = i != j && places.0 == places.1;
            self.add_at(places, if both { 2.0 * value } else { value });
        }
    }

    /// Adds `value` at a pair of positions.
    #[inline]
    fn add_at(&mut self, (i, j): (usize, usize), value: f64) {
        self.below(i.min(j), i.max(j))[0] += value;
    }

    /// All zero.
    pub(crate) fn clear(&mut self) {
        self.panel.fill(0.0);
        self.schur.fill(0.0);
    }

    /// Begins with the lower triangle of a symmetric `n × n` matrix, placed as in [`Assembly::add_symmetric`].
    pub(crate) fn set_symmetric(&mut self, runs: &[Run], n: usize, matrix: &[f64]) {
        let in_order = |run: &Run| run.length == n && n == self.n_front;
        if !matches!(runs, [run] if in_order(run)) {
            self.clear();
            self.add_symmetric(runs, n, matrix);
            return;
        }
        for j in 0..n {
            self.below(j, j)
                .copy_from_slice(&matrix[j * n + j..(j + 1) * n]);
        }
    }

    /// Adds the lower triangle of a symmetric `n × n` matrix, column-major, whose indices lie where the runs say, several at
    /// the same place if need be.
    pub(crate) fn add_symmetric(&mut self, runs: &[Run], n: usize, matrix: &[f64]) {
        for (k, run) in runs.iter().enumerate() {
            for step in 0..run.length {
                let (j, position) = (run.local + step, run.front + step);
                let column = &matrix[j * n..(j + 1) * n];
                let rest = &column[j..run.local + run.length];
                add_to(self.below(position, position), rest);
                for other in &runs[k + 1..] {
                    let values = &column[other.local..other.local + other.length];
                    if other.front > position {
                        add_to(self.below(position, other.front), values);
                        continue;
                    }
                    for (i, value) in (other.front..).zip(values) {
                        let value = if i == position { 2.0 * value } else { *value };
                        self.add_at((i, position), value);
                    }
                }
            }
        }
    }

    /// Adds aᵀ a with `a` column-major with `m` rows, whose columns lie where the run says.
    pub(crate) fn add_gram(&mut self, run: Run, m: usize, a: &[f64]) {
        let (n, n_panel, first, width) = (self.n_front, self.n_eliminated, run.front, run.length);
        // The columns before the border of the eliminated ones, and the others.
        let k = n_panel.clamp(first, first + width) - first;
        let a = MatRef::from_column_major_slice(&a[..m * width], m, width);
        let (left, right) = a.split_at_col(k);
        let mut panel = MatMut::from_column_major_slice_mut(&mut *self.panel, n, n_panel);
        if k > 0 {
            let corner = panel.rb_mut().submatrix_mut(first, first, k, k);
            add_lower_product(corner, left.transpose(), left);
            let below = panel.submatrix_mut(first + k, first, width - k, k);
            matmul(below, Accum::Add, right.transpose(), left, 1.0, Par::Seq);
        }
        if k < width {
            let (rest, first) = (n - n_panel, first + k - n_panel);
            let schur = &mut self.schur[..rest * rest];
            let schur = MatMut::from_column_major_slice_mut(schur, rest, rest);
            let corner = schur.submatrix_mut(first, first, width - k, width - k);
            add_lower_product(corner, right.transpose(), right);
        }
    }

    /// Column `j` from row `i ≥ j` on.
    #[inline]
    fn below(&mut self, j: usize, i: usize) -> &mut [f64] {
        let (n, m) = (self.n_front, self.n_eliminated);
        if j < m {
            &mut self.panel[j * n + i..(j + 1) * n]
        } else {
            let rest = n - m;
            &mut self.schur[(j - m) * rest + i - m..(j - m + 1) * rest]
        }
    }
}

#[inline]
fn add_to(sums: &mut [f64], values: &[f64]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The lower triangle of a front of so many rows and eliminated columns, in which something was, after `assemble`.
    fn assembled(
        (n, m): (usize, usize),
        places: &[usize],
        assemble: impl FnOnce(&mut Assembly<'_>),
    ) -> Vec<f64> {
        let (mut panel, mut schur) = (vec![0.5; n * m], vec![0.25; (n - m) * (n - m)]);
        let mut front = Assembly {
            panel: &mut panel,
            schur: &mut schur,
            n_front: n,
            n_eliminated: m,
            of_element: places,
        };
        assemble(&mut front);
        let mut lower = Vec::new();
        each_below(n, |i, j| lower.push(front.below(j, i)[0]));
        lower
    }

    /// Calls `each(i, j)` for all i ≥ j.
    fn each_below(n: usize, mut each: impl FnMut(usize, usize)) {
        for j in 0..n {
            (j..n).for_each(|i| each(i, j));
        }
    }

    #[test]
    fn neighbours_in_the_front_share_a_run() {
        let run = |local, front, length| Run {
            local,
            front,
            length,
        };
        let expected = vec![run(0, 4, 3), run(3, 0, 1), run(4, 2, 2)];
        assert_eq!(runs([4, 5, 6, 0, 2, 3]), expected);
        assert!(runs([]).is_empty());
        let expected = vec![run(0, 4, 1), run(2, 5, 2)];
        assert_eq!(runs([4, NOWHERE, 5, 6, NOWHERE]), expected);
    }

    #[test]
    fn a_matrix_in_runs_is_added_as_entry_by_entry() {
        let (n, m) = (7, 3);
        // Runs that change their order, one that crosses the border of the eliminated columns; unknowns that stand twice.
        for places in [
            [2, 3, 4, 6, 0, 1],
            [2, 3, 4, 0, 3, 4],
            [1, 2, NOWHERE, 2, 1, 6],
        ] {
            let k = places.len();
            let matrix: Vec<f64> = (0..k * k).map(|i| 1.0 + i as f64).collect();
            let by_entry = assembled((n, m), &places, |front| {
                each_below(k, |i, j| front.add(i, j, matrix[j * k + i]));
            });
            let in_runs = assembled((n, m), &places, |front| {
                front.add_symmetric(&runs(places), k, &matrix);
            });
            assert_eq!(by_entry, in_runs, "{places:?}");
        }
    }

    #[test]
    fn a_product_is_added_as_its_entries() {
        let (n, n_panel, m) = (9, 4, 5);
        for (first, width) in [(0, 9), (1, 2), (2, 5), (5, 3), (0, 4)] {
            let a: Vec<f64> = (0..m * width).map(|i| ((7 * i) % 11) as f64).collect();
            let places: Vec<usize> = (first..first + width).collect();
            let by_entry = assembled((n, n_panel), &places, |front| {
                each_below(width, |i, j| {
                    let product = (0..m).map(|r| a[i * m + r] * a[j * m + r]).sum();
                    front.add(i, j, product);
                });
            });
            let at_once = assembled((n, n_panel), &places, |front| {
                front.add_gram(runs(places.iter().copied())[0], m, &a);
            });
            assert_eq!(by_entry, at_once, "{first}, {width}");
        }
    }

    #[test]
    fn a_matrix_to_begin_with_leaves_nothing_of_what_was_there() {
        let (n, m) = (4, 3);
        for places in [
            vec![0, 1, 2, 3],
            vec![1, 0, 3, 2],
            vec![2, 3],
            vec![0, 1, NOWHERE, 2, 3],
        ] {
            let k = places.len();
            let matrix: Vec<f64> = (0..k * k).map(|i| 1.0 + i as f64).collect();
            let runs = runs(places.iter().copied());
            let begun = assembled((n, m), &places, |front| {
                front.set_symmetric(&runs, k, &matrix);
            });
            let added = assembled((n, m), &places, |front| {
                front.clear();
                front.add_symmetric(&runs, k, &matrix);
            });
            assert_eq!(begun, added);
        }
    }
}
