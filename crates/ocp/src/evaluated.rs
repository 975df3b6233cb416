//! What a trajectory knows from its last evaluation.

use crate::point::Point;
use crate::program::Program;
use solver::ElementStructure;

/// What was evaluated last: an accepted trial point is linearised without being evaluated again.
pub(crate) struct Evaluated {
    /// The point of nodes and differences; NaN before the first.
    point: Point,
    /// Objective and row values of every element; of an older point where `fresh` is false.
    pub(crate) values: Vec<(f64, Vec<f64>)>,
    pub(crate) fresh: bool,
}

impl Evaluated {
    /// Nothing yet, with room for a program's values.
    pub(crate) fn new(program: &Program) -> Self {
        let of_rows = |e: &ElementStructure| (f64::NAN, vec![f64::NAN; e.n_rows()]);
        Self {
            point: Point {
                nodes: vec![vec![f64::NAN; program.system.model.nq]; program.nodes.len()],
                wrenches: (program.intervals.iter())
                    .map(|i| vec![f64::NAN; i.n_wrench])
                    .collect(),
                velocities: if program.has_velocities() {
                    vec![vec![f64::NAN; program.system.model.nv]; program.nodes.len()]
                } else {
                    vec![]
                },
                durations: vec![f64::NAN; program.steps.len()],
            },
            values: program.structure.elements.iter().map(of_rows).collect(),
            fresh: false,
        }
    }

    /// False if the point is another one, which then takes its place.
    pub(crate) fn is_at(&mut self, x: &Point) -> bool {
        if self.point == *x {
            return true;
        }
        let of_vectors = |to: &mut [Vec<f64>], from: &[Vec<f64>]| {
            for (to, from) in to.iter_mut().zip(from) {
                to.copy_from_slice(from);
            }
        };
        of_vectors(&mut self.point.nodes, &x.nodes);
        of_vectors(&mut self.point.wrenches, &x.wrenches);
        of_vectors(&mut self.point.velocities, &x.velocities);
        self.point.durations.copy_from_slice(&x.durations);
        self.fresh = false;
        false
    }
}
