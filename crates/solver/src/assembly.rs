//! Adding dense symmetric matrices to a front, piece by piece where neighbours stay neighbours.

/// Consecutive local indices whose positions in the front are consecutive too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Run {
    local: usize,
    front: usize,
    length: usize,
}

/// The runs of a list that gives the position in the front of each local index.
pub(crate) fn runs(positions: impl IntoIterator<Item = usize>) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (local, front) in positions.into_iter().enumerate() {
        match runs.last_mut() {
            Some(run) if run.front + run.length == front => run.length += 1,
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
        let (i, j) = (self.of_element[i], self.of_element[j]);
        self.below(i.min(j), i.max(j))[0] += value;
    }

    /// Adds the lower triangle of a symmetric `n × n` matrix, column-major, whose indices lie where the runs say.
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
                    } else {
                        for (i, value) in values.iter().enumerate() {
                            self.below(other.front + i, position)[0] += value;
                        }
                    }
                }
            }
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
    }

    #[test]
    fn a_matrix_in_runs_is_added_as_entry_by_entry() {
        let (n, m) = (7, 3);
        // Runs that change their order, one that crosses the border of the eliminated columns.
        let places = [2, 3, 4, 6, 0, 1];
        let k = places.len();
        let matrix: Vec<f64> = (0..k * k).map(|i| 1.0 + i as f64).collect();
        let assembled = |by_entry: bool| {
            let mut panel = vec![0.5; n * m];
            let mut schur = vec![0.25; (n - m) * (n - m)];
            let mut front = Assembly {
                panel: &mut panel,
                schur: &mut schur,
                n_front: n,
                n_eliminated: m,
                of_element: &places,
            };
            if by_entry {
                for j in 0..k {
                    for i in j..k {
                        front.add(i, j, matrix[j * k + i]);
                    }
                }
            } else {
                front.add_symmetric(&runs(places), k, &matrix);
            }
            (panel, schur)
        };
        assert_eq!(assembled(true), assembled(false));
    }
}
