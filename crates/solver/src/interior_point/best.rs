//! The least violated point of a solve.
//!
//! Three points take turns as the current, the trial and the best one, so that none is copied.

/// Violation, point and multipliers.
pub(super) struct Best<X> {
    violation: f64,
    /// Meaningful unless the best point is the current one.
    point: X,
    /// Of the rows, and of the variables' lower and upper bounds.
    multipliers: [Vec<f64>; 3],
    is_current: bool,
}

impl<X: Clone> Best<X> {
    /// No point yet; the arguments give the sizes.
    pub fn new(x: &X, multipliers: [&[f64]; 3]) -> Self {
        Self {
            violation: f64::INFINITY,
            point: x.clone(),
            multipliers: multipliers.map(<[f64]>::to_vec),
            is_current: false,
        }
    }

    /// Its violation (scaled rows); ∞ before the first [`Best::note`].
    pub fn violation(&self) -> f64 {
        self.violation
    }

    /// The current point has this violation.
    pub fn note(&mut self, violation: f64, multipliers: [&[f64]; 3]) {
        if violation < self.violation {
            self.violation = violation;
            for (kept, now) in self.multipliers.iter_mut().zip(multipliers) {
                kept.copy_from_slice(now);
            }
            self.is_current = true;
        }
    }

    /// The trial point becomes the current one; afterwards `trial` is free.
    pub fn advance(&mut self, x: &mut X, trial: &mut X) {
        std::mem::swap(x, trial);
        if self.is_current {
            std::mem::swap(&mut self.point, trial);
            self.is_current = false;
        }
    }

    /// Puts the best point and its multipliers into `x` and `multipliers`.
    pub fn restore(self, x: &mut X, multipliers: [&mut Vec<f64>; 3]) {
        if !self.is_current {
            *x = self.point;
        }
        for (now, kept) in multipliers.into_iter().zip(self.multipliers) {
            *now = kept;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_violated_point_is_kept_while_the_points_take_turns() {
        let (mut x, trial) = (0, &mut 0);
        let mut best = Best::new(&x, [&[0.0], &[], &[]]);
        for (point, violation) in [(1, 5.0), (2, 3.0), (3, 4.0), (4, 3.5), (5, 9.0)] {
            *trial = point;
            best.advance(&mut x, trial);
            assert_eq!(x, point);
            best.note(violation, [&[f64::from(point)], &[], &[]]);
        }
        let (mut y, mut lower, mut upper) = (vec![0.0], vec![], vec![]);
        assert_eq!(best.violation(), 3.0);
        best.restore(&mut x, [&mut y, &mut lower, &mut upper]);
        assert_eq!((x, y), (2, vec![2.0]));
    }
}
