//! Multifrontal Cholesky factorisation of a symmetric matrix given as a sum of element matrices.
//!
//! Every variable is eliminated with the last element that touches it, so the *front* of an element holds its own
//! variables and those carried over from its predecessors. With elements that follow one another in time the fronts
//! stay small and the cost is linear in their number. Fixed variables are in no front.
//!
//! Source: Duff and Reid 1983; the dense kernels are faer's.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{
    LltRegularization, cholesky_in_place, cholesky_in_place_scratch,
};
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, Par, Spec};

use crate::Structure;
pub use crate::assembly::Assembly;
use crate::assembly::{NOWHERE, Run, runs};
use crate::kernels::{add_scaled, dot};

/// The matrix is not positive definite: the element and its failed pivot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotPositiveDefinite {
    /// Element at whose elimination the pivot failed.
    pub element: usize,
}

/// Index lists of one front; constant during a solve.
#[derive(Debug, Clone)]
struct Symbolic {
    /// Global variables of the front, the eliminated ones first.
    vars: Vec<usize>,
    /// How many of them are eliminated here.
    n_eliminated: usize,
    /// Position in the front of each variable of the element, [`NOWHERE`] for fixed ones.
    of_element: Vec<usize>,
    /// The same in runs.
    runs: Vec<Run>,
    /// Positions in the next front of the carried variables.
    of_carried: Vec<Run>,
}

/// Factorisation with its buffers; allocated once.
pub struct Fronts {
    symbolic: Vec<Symbolic>,
    /// Global indices of the fixed variables.
    fixed: Vec<usize>,
    /// Per element the factor's columns, column-major `front × eliminated`.
    panels: Vec<Vec<f64>>,
    /// Schur complement of the current and of the next front.
    schur: [Vec<f64>; 2],
    scratch: MemBuffer,
    local: Vec<f64>,
}

impl Fronts {
    /// Analyses the structure and allocates everything.
    ///
    /// # Panics
    /// If a variable belongs to no element: such a problem is ill-posed by construction.
    pub fn new(structure: &Structure) -> Self {
        let symbolic = analyse(structure);
        let panels = symbolic
            .iter()
            .map(|s| vec![0.0; s.vars.len() * s.n_eliminated])
            .collect();
        let n_schur = symbolic
            .iter()
            .map(|s| s.vars.len() - s.n_eliminated)
            .max()
            .unwrap_or(0);
        let n_elim = symbolic.iter().map(|s| s.n_eliminated).max().unwrap_or(0);
        let scratch = MemBuffer::new(cholesky_in_place_scratch::<f64>(
            n_elim,
            Par::Seq,
            Spec::default(),
        ));
        let n_front = symbolic.iter().map(|s| s.vars.len()).max().unwrap_or(0);
        Self {
            symbolic,
            fixed: (0..structure.n_vars)
                .filter(|&v| structure.is_fixed(v))
                .collect(),
            panels,
            schur: [vec![0.0; n_schur * n_schur], vec![0.0; n_schur * n_schur]],
            scratch,
            local: vec![0.0; n_front],
        }
    }

    /// Factorises; `assemble` adds the matrix of each element, in order.
    ///
    /// # Errors
    /// [`NotPositiveDefinite`] at the first pivot that is not positive.
    pub fn factorise(
        &mut self,
        assemble: impl FnMut(usize, &mut Assembly<'_>),
    ) -> Result<(), NotPositiveDefinite> {
        self.factorise_from(|_| None, assemble)
    }

    /// The same where every element begins with a symmetric matrix over its variables, given by its lower triangle.
    pub(crate) fn factorise_from<'a>(
        &mut self,
        begin: impl Fn(usize) -> Option<&'a [f64]>,
        mut assemble: impl FnMut(usize, &mut Assembly<'_>),
    ) -> Result<(), NotPositiveDefinite> {
        let [now, next] = &mut self.schur;
        let mut carried = 0;
        for (e, symbolic) in self.symbolic.iter().enumerate() {
            let (n_front, n_elim) = (symbolic.vars.len(), symbolic.n_eliminated);
            let n_rest = n_front - n_elim;
            let panel = &mut self.panels[e];
            let mut front = Assembly {
                panel,
                schur: &mut next[..n_rest * n_rest],
                n_front,
                n_eliminated: n_elim,
                of_element: &symbolic.of_element,
            };
            match begin(e) {
                Some(matrix) => {
                    front.set_symmetric(&symbolic.runs, symbolic.of_element.len(), matrix);
                }
                None => front.clear(),
            }
            if e > 0 {
                front.add_symmetric(&self.symbolic[e - 1].of_carried, carried, now);
            }
            assemble(e, &mut front);
            let stack = MemStack::new(&mut self.scratch);
            eliminate(panel, &mut next[..n_rest * n_rest], n_front, n_elim, stack)
                .map_err(|()| NotPositiveDefinite { element: e })?;
            std::mem::swap(now, next);
            carried = n_rest;
        }
        Ok(())
    }

    /// Solves in place with the last factorisation; `rhs` over all variables, of which the fixed ones become zero.
    pub fn solve(&mut self, rhs: &mut [f64]) {
        for &v in &self.fixed {
            rhs[v] = 0.0;
        }
        self.forward(rhs);
        self.backward(rhs);
    }

    /// The first half of [`Fronts::solve`]: with the factor L, `rhs` becomes L⁻¹ rhs.
    fn forward(&mut self, rhs: &mut [f64]) {
        for (symbolic, panel) in self.symbolic.iter().zip(&self.panels) {
            let (n, m) = (symbolic.vars.len(), symbolic.n_eliminated);
            let b = &mut self.local[..n];
            for (x, &v) in b.iter_mut().zip(&symbolic.vars) {
                *x = rhs[v];
            }
            for j in 0..m {
                let column = &panel[j * n..(j + 1) * n];
                let x = b[j] / column[j];
                b[j] = x;
                add_scaled(&mut b[j + 1..], &column[j + 1..], -x);
            }
            for (x, &v) in b.iter().zip(&symbolic.vars) {
                rhs[v] = *x;
            }
        }
    }

    /// The second half of [`Fronts::solve`]: `rhs` becomes L⁻ᵀ rhs.
    fn backward(&mut self, rhs: &mut [f64]) {
        for (symbolic, panel) in self.symbolic.iter().zip(&self.panels).rev() {
            let (n, m) = (symbolic.vars.len(), symbolic.n_eliminated);
            let b = &mut self.local[..n];
            for (x, &v) in b.iter_mut().zip(&symbolic.vars) {
                *x = rhs[v];
            }
            for j in (0..m).rev() {
                let column = &panel[j * n..(j + 1) * n];
                b[j] = (b[j] - dot(&column[j + 1..], &b[j + 1..])) / column[j];
            }
            for (x, &v) in b[..m].iter().zip(&symbolic.vars) {
                rhs[v] = *x;
            }
        }
    }

    /// Where an element's variables lie in its front.
    pub(crate) fn positions(&self, element: usize) -> &[usize] {
        &self.symbolic[element].of_element
    }

    /// Bytes held by the factor and its buffers.
    pub fn memory(&self) -> usize {
        8 * (self.panels.iter().map(Vec::len).sum::<usize>() + self.schur[0].len() * 2)
    }
}

/// Dense partial Cholesky of one front: L₁₁, L₂₁ in the panel, the Schur complement in `schur`.
fn eliminate(
    panel: &mut [f64],
    schur: &mut [f64],
    n: usize,
    m: usize,
    stack: &mut MemStack,
) -> Result<(), ()> {
    if m == 0 {
        return Ok(());
    }
    let panel = MatMut::from_column_major_slice_mut(panel, n, m);
    let (mut l11, l21) = panel.split_at_row_mut(m);
    let regularisation = LltRegularization::default();
    cholesky_in_place(
        l11.rb_mut(),
        regularisation,
        Par::Seq,
        stack,
        Spec::default(),
    )
    .map_err(|_| ())?;
    if n == m {
        return Ok(());
    }
    let mut l21 = l21;
    solve_lower_triangular_in_place(l11.rb(), l21.rb_mut().transpose_mut(), Par::Seq);
    let rest = MatMut::from_column_major_slice_mut(schur, n - m, n - m);
    triangular::matmul(
        rest,
        BlockStructure::TriangularLower,
        Accum::Add,
        l21.rb(),
        BlockStructure::Rectangular,
        l21.rb().transpose(),
        BlockStructure::Rectangular,
        -1.0,
        Par::Seq,
    );
    Ok(())
}

fn analyse(structure: &Structure) -> Vec<Symbolic> {
    let mut last = vec![usize::MAX; structure.n_vars];
    for (e, element) in structure.elements.iter().enumerate() {
        for &v in &element.vars {
            last[v] = e;
        }
    }
    assert!(
        last.iter().all(|&e| e != usize::MAX),
        "every variable belongs to an element"
    );
    let mut fronts: Vec<Symbolic> = Vec::with_capacity(structure.elements.len());
    let mut position = vec![NOWHERE; structure.n_vars];
    let mut carried: Vec<usize> = Vec::new();
    for (e, element) in structure.elements.iter().enumerate() {
        // In the element's own order where possible, so that its matrix is added in few runs.
        let mut vars: Vec<usize> = Vec::new();
        for &v in element.vars.iter().chain(&carried) {
            if !structure.is_fixed(v) && !vars.contains(&v) {
                vars.push(v);
            }
        }
        vars.sort_by_key(|&v| last[v] != e);
        let n_eliminated = vars.iter().filter(|&&v| last[v] == e).count();
        for (i, &v) in vars.iter().enumerate() {
            position[v] = i;
        }
        if let Some(previous) = fronts.last_mut() {
            previous.of_carried = runs(carried.iter().map(|&v| position[v]));
        }
        let of_element: Vec<usize> = element.vars.iter().map(|&v| position[v]).collect();
        carried = vars[n_eliminated..].to_vec();
        fronts.push(Symbolic {
            vars,
            n_eliminated,
            runs: runs(of_element.iter().copied()),
            of_element,
            of_carried: Vec::new(),
        });
    }
    fronts
}
