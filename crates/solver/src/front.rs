//! Multifrontal Cholesky factorisation of a symmetric matrix given as a sum of element matrices.
//!
//! Every variable is eliminated with one of the elements that touch it (`elimination`), so the *front* of an element holds
//! its own variables and those carried over from its neighbours. With elements that follow one another in time the fronts
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
use std::sync::atomic::{AtomicBool, Ordering};

use crate::Structure;
pub use crate::assembly::Assembly;
use crate::elimination::{Elimination, Symbolic};
use crate::kernels::{add_scaled, dot};
use crate::threads::join;

/// The matrix is not positive definite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotPositiveDefinite;

/// Factorisation with its buffers; allocated once.
pub struct Fronts {
    symbolic: Vec<Symbolic>,
    /// The element between the two halves.
    middle: usize,
    /// Global indices of the fixed variables, and of those that are eliminated in the second half.
    fixed: Vec<usize>,
    second: Vec<usize>,
    /// Per element the factor's columns, column-major `front × eliminated`.
    panels: Vec<Vec<f64>>,
    buffers: [Buffers; 2],
    /// The second half's right-hand side and solution, over all variables.
    second_rhs: Vec<f64>,
}

/// What one half works with.
struct Buffers {
    /// Schur complement of the front done last and of the one at hand.
    schur: [Vec<f64>; 2],
    stack: MemBuffer,
    local: Vec<f64>,
}

impl Buffers {
    /// For any of these fronts.
    fn new(symbolic: &[Symbolic]) -> Self {
        let most = |of: fn(&Symbolic) -> usize| symbolic.iter().map(of).max().unwrap_or(0);
        let n_schur = most(Symbolic::n_carried).pow(2);
        let n_eliminated = most(|s| s.n_eliminated);
        Self {
            schur: [vec![0.0; n_schur], vec![0.0; n_schur]],
            stack: MemBuffer::new(cholesky_in_place_scratch::<f64>(
                n_eliminated,
                Par::Seq,
                Spec::default(),
            )),
            local: vec![0.0; most(|s| s.vars.len())],
        }
    }
}

/// How the matrices of elements come into the fronts.
struct Assembler<'b, B, A> {
    symbolic: &'b [Symbolic],
    begin: &'b B,
    assemble: &'b A,
    /// Set once a pivot is not positive.
    failed: &'b AtomicBool,
}

impl<'m, B: Fn(usize) -> Option<&'m [f64]>, A> Assembler<'_, B, A> {
    /// Assembles and eliminates the front of element `e`, which has its panel, with the Schur complements of others: the element,
    /// and the matrix.
    fn front<S>(
        &self,
        (e, panel): (usize, &mut [f64]),
        carried: [Option<(usize, &[f64])>; 2],
        (schur, stack): (&mut [f64], &mut MemBuffer),
        state: &mut S,
    ) -> Result<(), NotPositiveDefinite>
    where
        A: Fn(&mut S, usize, &mut Assembly<'_>),
    {
        let symbolic = &self.symbolic[e];
        let (n_front, n_eliminated) = (symbolic.vars.len(), symbolic.n_eliminated);
        let n_rest = n_front - n_eliminated;
        let mut front = Assembly {
            panel,
            schur: &mut schur[..n_rest * n_rest],
            n_front,
            n_eliminated,
            of_element: &symbolic.of_element,
        };
        match (self.begin)(e) {
            Some(matrix) => {
                front.set_symmetric(&symbolic.runs, symbolic.of_element.len(), matrix);
            }
            None => front.clear(),
        }
        for (from, matrix) in carried.into_iter().flatten() {
            let from = &self.symbolic[from];
            front.add_symmetric(&from.of_carried, from.n_carried(), matrix);
        }
        (self.assemble)(state, e, &mut front);
        let stack = MemStack::new(stack);
        eliminate(
            panel,
            &mut schur[..n_rest * n_rest],
            n_front,
            n_eliminated,
            stack,
        )
        .map_err(|()| self.failed.store(true, Ordering::Relaxed))
        .map_err(|()| NotPositiveDefinite)
    }

    /// One half, in the order in which its elements come with their panels; the last one, whose Schur complement is left.
    fn half<'p, S>(
        &self,
        order: impl Iterator<Item = (usize, &'p mut Vec<f64>)>,
        buffers: &mut Buffers,
        state: &mut S,
    ) -> Result<Option<usize>, NotPositiveDefinite>
    where
        A: Fn(&mut S, usize, &mut Assembly<'_>),
    {
        let [before, now] = &mut buffers.schur;
        let mut last = None;
        for (e, panel) in order {
            if self.failed.load(Ordering::Relaxed) {
                return Err(NotPositiveDefinite);
            }
            let carried = last.map(|from| (from, &before[..]));
            let out = (&mut now[..], &mut buffers.stack);
            self.front((e, panel), [carried, None], out, state)?;
            std::mem::swap(before, now);
            last = Some(e);
        }
        Ok(last)
    }
}

impl Fronts {
    /// Analyses the structure and allocates everything.
    ///
    /// # Panics
    /// If a variable belongs to no element: such a problem is ill-posed by construction.
    pub fn new(structure: &Structure) -> Self {
        let Elimination {
            fronts: symbolic,
            middle,
        } = Elimination::new(structure);
        let panel = |s: &Symbolic| vec![0.0; s.vars.len() * s.n_eliminated];
        let second = symbolic.iter().skip(middle + 1);
        Self {
            middle,
            fixed: (0..structure.n_vars)
                .filter(|&v| structure.is_fixed(v))
                .collect(),
            second: second
                .flat_map(|s| &s.vars[..s.n_eliminated])
                .copied()
                .collect(),
            panels: symbolic.iter().map(panel).collect(),
            buffers: [Buffers::new(&symbolic), Buffers::new(&symbolic)],
            second_rhs: vec![0.0; structure.n_vars],
            symbolic,
        }
    }

    /// Number of elements in the first half, the middle one with them.
    pub(crate) fn n_first(&self) -> usize {
        (self.middle + 1).min(self.symbolic.len())
    }

    /// Factorises; `assemble` adds the matrix of each element.
    ///
    /// # Errors
    /// [`NotPositiveDefinite`] if a pivot is not positive.
    pub fn factorise(
        &mut self,
        assemble: impl Fn(usize, &mut Assembly<'_>) + Sync,
    ) -> Result<(), NotPositiveDefinite> {
        let states = [&mut (), &mut ()];
        self.factorise_from(1, states, |_| None, |(), e, front| assemble(e, front))
    }

    /// The same on so many threads, where every element begins with a symmetric matrix over its variables, given by its lower
    /// triangle, and each half has a state of its own; the middle element is one of the first half.
    pub(crate) fn factorise_from<'m, S: Send>(
        &mut self,
        threads: usize,
        [first, second]: [&mut S; 2],
        begin: impl Fn(usize) -> Option<&'m [f64]> + Sync,
        assemble: impl Fn(&mut S, usize, &mut Assembly<'_>) + Sync,
    ) -> Result<(), NotPositiveDefinite> {
        let assembler = Assembler {
            symbolic: &self.symbolic,
            begin: &begin,
            assemble: &assemble,
            failed: &AtomicBool::new(false),
        };
        let middle = self.middle;
        let (before, rest) = self.panels.split_at_mut(middle);
        let Some((panel, after)) = rest.split_first_mut() else {
            return Ok(());
        };
        let [first_buffers, second_buffers] = &mut self.buffers;
        let upwards = (0..).zip(before);
        let downwards = (middle + 1..self.symbolic.len()).zip(after).rev();
        let (last, next) = join(
            threads,
            || assembler.half(upwards, first_buffers, &mut *first),
            || assembler.half(downwards, second_buffers, second),
        );
        let carried = [
            last?.map(|from| (from, &first_buffers.schur[0][..])),
            next?.map(|from| (from, &second_buffers.schur[0][..])),
        ];
        let out = (&mut [][..], &mut first_buffers.stack);
        assembler.front((middle, panel), carried, out, first)
    }

    /// Solves in place with the last factorisation; `rhs` over all variables, of which the fixed ones become zero.
    pub fn solve(&mut self, rhs: &mut [f64]) {
        self.solve_then(1, rhs, |_| (), |_| ());
    }

    /// The same on so many threads; as soon as the variables of one half's elements have their values, these are handed on.
    pub(crate) fn solve_then(
        &mut self,
        threads: usize,
        rhs: &mut [f64],
        first_then: impl FnOnce(&[f64]),
        second_then: impl FnOnce(&[f64]) + Send,
    ) {
        for &v in &self.fixed {
            rhs[v] = 0.0;
        }
        let second_rhs = &mut self.second_rhs;
        for &v in &self.second {
            second_rhs[v] = rhs[v];
        }
        let factors = || self.symbolic.iter().zip(&self.panels);
        let (first, second) = (factors().take(self.middle), factors().skip(self.middle + 1));
        let Some(middle) = factors().nth(self.middle) else {
            return;
        };
        for &v in &middle.0.vars {
            second_rhs[v] = 0.0;
        }
        let [here, there] = self.buffers.each_mut().map(|b| &mut b.local[..]);
        join(
            threads,
            || (first.clone()).for_each(|front| forward(front, here, rhs)),
            || (second.clone().rev()).for_each(|front| forward(front, there, second_rhs)),
        );
        for &v in &middle.0.vars {
            rhs[v] += second_rhs[v];
        }
        forward(middle, here, rhs);
        backward(middle, here, rhs);
        for &v in &middle.0.vars {
            second_rhs[v] = rhs[v];
        }
        join(
            threads,
            || {
                first.rev().for_each(|front| backward(front, here, rhs));
                first_then(rhs);
            },
            || {
                second.for_each(|front| backward(front, there, second_rhs));
                second_then(second_rhs);
            },
        );
        for &v in &self.second {
            rhs[v] = second_rhs[v];
        }
    }

    /// Where an element's variables lie in its front.
    pub(crate) fn positions(&self, element: usize) -> &[usize] {
        &self.symbolic[element].of_element
    }

    /// Bytes held by the factor and its buffers.
    pub fn memory(&self) -> usize {
        let schur = self.buffers.iter().flat_map(|b| &b.schur);
        8 * self.panels.iter().chain(schur).map(Vec::len).sum::<usize>()
    }
}

/// With the factor L of one front, its part of `rhs` becomes L⁻¹ rhs; what is carried is changed too.
fn forward((symbolic, panel): (&Symbolic, &Vec<f64>), local: &mut [f64], rhs: &mut [f64]) {
    let (n, m) = (symbolic.vars.len(), symbolic.n_eliminated);
    let b = &mut local[..n];
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

/// Its part of `rhs` becomes L⁻ᵀ rhs.
fn backward((symbolic, panel): (&Symbolic, &Vec<f64>), local: &mut [f64], rhs: &mut [f64]) {
    let (n, m) = (symbolic.vars.len(), symbolic.n_eliminated);
    let b = &mut local[..n];
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
