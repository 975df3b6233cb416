//! Variables whose bounds are equal: they are put there at the start and stay. The Newton system is without them.

use crate::Structure;
use crate::barrier::Bounded;

/// The fixed variables of a structure.
pub(super) struct Fixed {
    /// Global indices.
    variables: Vec<usize>,
}

impl Fixed {
    /// Those with `lower == upper`.
    pub fn new(structure: &Structure) -> Self {
        let variables = 0..structure.n_vars;
        Self {
            variables: variables.filter(|&v| structure.is_fixed(v)).collect(),
        }
    }

    /// Takes their bounds away: no barrier acts on what does not move.
    pub fn unbind(&self, variables: &mut Bounded) {
        for &v in &self.variables {
            variables.lower[v] = f64::NEG_INFINITY;
            variables.upper[v] = f64::INFINITY;
        }
    }

    /// Sets their entries of a gradient to zero.
    pub fn erase(&self, gradient: &mut [f64]) {
        for &v in &self.variables {
            gradient[v] = 0.0;
        }
    }
}
