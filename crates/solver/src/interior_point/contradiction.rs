//! Programs whose bounds contradict each other: reported as they are, with the rows at the start.

use super::InteriorPoint;
use super::residuals::gather_rows;
use crate::{Problem, Report, Status};

impl<P: Problem> InteriorPoint<P> {
    /// The report of a program with crossed bounds; its violation is at least half of the largest crossing of a row.
    pub(super) fn refuse(&mut self, problem: &mut P, x: &P::Point) -> Report {
        problem.evaluate(x, &mut self.data);
        gather_rows(&self.data, &mut self.scratch.rows);
        let rows = &self.scratch.rows;
        let elements = self.structure.elements.iter();
        let bounds = elements.flat_map(|e| e.row_lower.iter().zip(&e.row_upper));
        let violation = rows
            .iter()
            .zip(bounds)
            .map(|(c, (l, u))| (l - c).max(c - u))
            .fold(0.0, f64::max);
        Report {
            status: Status::Contradictory,
            iterations: 0,
            objective: self.data.iter().map(|d| d.objective).sum(),
            violation,
            dual: f64::NAN,
            multipliers: vec![0.0; rows.len()],
            bound_multipliers: vec![0.0; self.structure.n_vars],
            rows: rows.clone(),
            factorisations: 0,
            timing: self.timing,
        }
    }
}
