//! Variables whose bounds are equal: they are put there at the start and stay.
//!
//! Their derivatives are replaced by zeros and their diagonal by one, so that the Newton system gives them no step, and
//! the others the step of the problem without them.

use crate::barrier::Bounded;
use crate::{ElementData, Structure};

/// The fixed variables of a structure.
pub(super) struct Fixed {
    /// Global indices.
    variables: Vec<usize>,
    /// Element and local index of each occurrence.
    places: Vec<(usize, usize)>,
}

impl Fixed {
    /// Those with `lower == upper`.
    pub fn new(structure: &Structure) -> Self {
        let is_fixed = |v: usize| structure.lower[v] == structure.upper[v];
        let mut places = Vec::new();
        for (e, element) in structure.elements.iter().enumerate() {
            let fixed = (0..element.vars.len()).filter(|&i| is_fixed(element.vars[i]));
            places.extend(fixed.map(|i| (e, i)));
        }
        Self {
            variables: (0..structure.n_vars).filter(|&v| is_fixed(v)).collect(),
            places,
        }
    }

    /// Takes their bounds away: no barrier acts on what does not move.
    pub fn unbind(&self, variables: &mut Bounded) {
        for &v in &self.variables {
            variables.lower[v] = f64::NEG_INFINITY;
            variables.upper[v] = f64::INFINITY;
        }
    }

    /// Sets their derivatives to zero.
    pub fn erase(&self, structure: &Structure, data: &mut [ElementData]) {
        for &(e, i) in &self.places {
            let (element, data) = (&structure.elements[e], &mut data[e]);
            let n = element.vars.len();
            data.gradient[i] = 0.0;
            data.hessian[i * n..(i + 1) * n].fill(0.0);
            for j in 0..i {
                data.hessian[j * n + i] = 0.0;
            }
            for (block, jacobian) in element.blocks.iter().zip(&mut data.jacobians) {
                if let Some(c) = block.cols.iter().position(|&c| c == i) {
                    jacobian[c * block.n_rows..(c + 1) * block.n_rows].fill(0.0);
                }
            }
        }
    }

    /// Sets their entries of the Newton system's diagonal to one.
    pub fn set_diagonal(&self, diagonal: &mut [f64]) {
        for &v in &self.variables {
            diagonal[v] = 1.0;
        }
    }
}
