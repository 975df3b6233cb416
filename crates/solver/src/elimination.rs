//! The order of elimination: from both ends of the chain of elements to its middle.
//!
//! Elements before the middle one are eliminated in their order, those after it in the reverse order, and the middle one at last. The
//! two halves know nothing of one another, so that two threads can work on them. A variable that only elements of one half
//! touch is eliminated with the last one of them that comes up; all others with the middle one.

use crate::assembly::{NOWHERE, Run, runs};
use crate::{ElementStructure, Structure};

/// Fewer elements are eliminated from the first to the last one.
const FEW: usize = 16;

/// Index lists of one front; constant during a solve.
#[derive(Debug, Clone)]
pub(crate) struct Symbolic {
    /// Global variables of the front, the eliminated ones first.
    pub vars: Vec<usize>,
    /// How many of them are eliminated here.
    pub n_eliminated: usize,
    /// Position in the front of each variable of the element, [`NOWHERE`] for fixed ones.
    pub of_element: Vec<usize>,
    /// The same in runs.
    pub runs: Vec<Run>,
    /// Positions in the next front of the carried variables.
    pub of_carried: Vec<Run>,
}

impl Symbolic {
    /// How many variables are carried to the next front.
    pub fn n_carried(&self) -> usize {
        self.vars.len() - self.n_eliminated
    }

    fn carried(&self) -> &[usize] {
        &self.vars[self.n_eliminated..]
    }
}

/// The fronts of all elements.
pub(crate) struct Elimination {
    pub fronts: Vec<Symbolic>,
    /// The element that is eliminated at last.
    pub middle: usize,
}

impl Elimination {
    /// Analyses a structure.
    ///
    /// # Panics
    /// If a variable belongs to no element.
    pub fn new(structure: &Structure) -> Self {
        let n = structure.elements.len();
        let middle = middle(structure);
        let mut analysis = Analysis {
            structure,
            with: eliminated_with(structure, middle),
            fronts: vec![None; n],
            position: vec![NOWHERE; structure.n_vars],
        };
        let mut last = None;
        for e in 0..middle {
            analysis.add(e, &[last]);
            last = Some(e);
        }
        let mut first = None;
        for e in (middle + 1..n).rev() {
            analysis.add(e, &[first]);
            first = Some(e);
        }
        if n > 0 {
            analysis.add(middle, &[last, first]);
        }
        Self {
            fronts: analysis.fronts.into_iter().flatten().collect(),
            middle,
        }
    }
}

struct Analysis<'a> {
    structure: &'a Structure,
    /// Per variable the element with which it is eliminated.
    with: Vec<usize>,
    fronts: Vec<Option<Symbolic>>,
    /// Scratch: positions of variables in the front at hand.
    position: Vec<usize>,
}

impl Analysis<'_> {
    /// The front of an element, to which others carry what they have left.
    fn add(&mut self, e: usize, from: &[Option<usize>]) {
        let element = &self.structure.elements[e].vars;
        let from = || from.iter().flatten();
        let carried = |&p: &usize| self.fronts[p].as_ref().map_or(&[][..], Symbolic::carried);
        // In the element's own order where possible, so that its matrix is added in few runs.
        let mut vars: Vec<usize> = Vec::new();
        for &v in element.iter().chain(from().flat_map(carried)) {
            if !self.structure.is_fixed(v) && !vars.contains(&v) {
                vars.push(v);
            }
        }
        vars.sort_by_key(|&v| self.with[v] != e);
        let n_eliminated = vars.iter().filter(|&&v| self.with[v] == e).count();
        let position = &mut self.position;
        for (i, &v) in vars.iter().enumerate() {
            position[v] = i;
        }
        for &p in from() {
            if let Some(previous) = &mut self.fronts[p] {
                previous.of_carried = runs(previous.carried().iter().map(|&v| position[v]));
            }
        }
        let of_element: Vec<usize> = element.iter().map(|&v| position[v]).collect();
        self.fronts[e] = Some(Symbolic {
            vars,
            n_eliminated,
            runs: runs(of_element.iter().copied()),
            of_element,
            of_carried: Vec::new(),
        });
    }
}

/// The element before and after which there is about as much to do.
fn middle(structure: &Structure) -> usize {
    let elements = &structure.elements;
    if elements.len() < FEW {
        return elements.len().saturating_sub(1);
    }
    let cost = |e: &ElementStructure| e.vars.len().pow(2) * (e.vars.len() + e.n_rows());
    let all: usize = elements.iter().map(cost).sum();
    let mut until = 0;
    let reaches_half = |e: &ElementStructure| {
        until += cost(e);
        2 * until >= all
    };
    elements.iter().position(reaches_half).unwrap_or(0)
}

/// Per variable the element with which it is eliminated.
fn eliminated_with(structure: &Structure, middle: usize) -> Vec<usize> {
    let mut touching = vec![None; structure.n_vars];
    for (e, element) in structure.elements.iter().enumerate() {
        for &v in &element.vars {
            let (first, _) = touching[v].unwrap_or((e, e));
            touching[v] = Some((first, e));
        }
    }
    let with = |of: Option<(usize, usize)>| {
        let (first, last) = of.expect("every variable belongs to an element");
        if last < middle {
            last
        } else {
            first.max(middle)
        }
    };
    touching.into_iter().map(with).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_halves_carry_only_what_is_shared_with_the_next_element_to_the_middle() {
        // Every element touches its own variable, the next one and one that all share.
        let n = 2 * FEW;
        let element = |e: usize| ElementStructure {
            vars: vec![e, e + 1, n + 1],
            ..ElementStructure::default()
        };
        let structure = Structure {
            n_vars: n + 2,
            elements: (0..n).map(element).collect(),
            ..Structure::default()
        };
        let Elimination { fronts, middle } = Elimination::new(&structure);
        assert_eq!(middle, FEW - 1);
        let own = |f: &Symbolic| f.vars[..f.n_eliminated].to_vec();
        assert_eq!((own(&fronts[3]), fronts[3].n_carried()), (vec![3], 2));
        assert_eq!(
            (own(&fronts[n - 3]), fronts[n - 3].n_carried()),
            (vec![n - 2], 2)
        );
        assert_eq!(own(&fronts[middle]), [middle, middle + 1, n + 1]);
        let eliminated: usize = fronts.iter().map(|f| f.n_eliminated).sum();
        assert_eq!(eliminated, structure.n_vars);
    }
}
