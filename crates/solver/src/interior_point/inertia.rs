//! Factorisation of a Newton system that is changed until it has the right inertia.
//!
//! The Hessian is ∇²f + κ Σ yᵢ ∇²cᵢ + δ 1: with all of the rows' curvature (κ = 1) Newton's, without any (κ = 0) that of Gauss
//! and Newton.
//!
//! Source: Wächter and Biegler 2006, section 3.1, for the test of the inertia and the shift δ. **Departs:** by
//! [`Convexification`].

use std::time::Instant;

use super::InteriorPoint;
use super::state::State;
use crate::kkt::Diagonals;
use crate::{Convexification, Problem};

/// Largest shift.
const MAX_SHIFT: f64 = 1e12;

/// [`Convexification::Curvature`]: shift of the first level, and the factor from one level to the next. Without a shift, steps
/// near a solution go far along what the rows' curvature had held.
const LEVEL_SHIFT: f64 = 0.01;
const LEVEL_GROWTH: f64 = 2.0;
/// Last level that has curvature of the rows.
const LAST_CURVED: i32 = 6;
/// Violation (scaled rows) below which Newton's system is tried first, whatever the last one needed: with less of the rows' curvature
/// there is less of what is positive too, so that half of it may have the wrong inertia where all of it has the right one, and steps
/// circle around the solution.
const NEAR: f64 = 1e-2;

/// [`Convexification::Shift`]: the first shift, and the one from which on the curvature of the rows is dropped instead.
const FIRST_SHIFT: f64 = 1e-4;
const GN_SHIFT: f64 = 1.0;

/// How the system was made positive definite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Inertia {
    /// κ.
    pub curvature: f64,
    /// δ.
    pub shift: f64,
    /// How often the curvature was halved.
    level: i32,
}

impl Inertia {
    /// Newton's system with this shift.
    pub fn newton(shift: f64) -> Self {
        Self {
            curvature: 1.0,
            shift,
            level: 0,
        }
    }

    /// [`Convexification::Curvature`]: the curvature of the rows halved so many times; `forced` is the least shift.
    fn halved(level: i32, forced: f64) -> Self {
        if level == 0 {
            return Self::newton(forced);
        }
        let curved = level <= LAST_CURVED;
        let shift = LEVEL_SHIFT * LEVEL_GROWTH.powi(level - 1);
        Self {
            curvature: if curved { 0.5_f64.powi(level) } else { 0.0 },
            shift: shift.max(forced),
            level,
        }
    }

    /// What to try first, Newton's system or what is near the last one; `last` is what earlier systems needed
    /// ([`State::last_inertia`]), `forced` the least shift.
    fn first(how: Convexification, last: Self, forced: f64, newton: bool) -> Self {
        match how {
            Convexification::Curvature if !newton => Self::halved((last.level - 1).max(0), forced),
            _ => Self::newton(forced),
        }
    }

    /// What to try when this was not enough; `last` and `forced` as in [`Inertia::first`].
    fn next(self, how: Convexification, last: Self, forced: f64) -> Self {
        match how {
            Convexification::Curvature => {
                Self::halved((self.level + 1).max(last.level - 1), forced)
            }
            Convexification::Shift => {
                if self.curvature > 0.0 && self.shift >= GN_SHIFT.max(forced) {
                    return Self {
                        curvature: 0.0,
                        shift: forced,
                        ..self
                    };
                }
                let shift = if self.shift > 0.0 {
                    self.shift * if last.shift == 0.0 { 100.0 } else { 8.0 }
                } else if last.shift > 0.0 {
                    (last.shift / 3.0).max(1e-9)
                } else {
                    FIRST_SHIFT
                };
                Self { shift, ..self }
            }
        }
    }
}

impl<P: Problem> InteriorPoint<P> {
    /// Factorises the Newton system at the current point, which has this violation; `None` if nothing helps.
    pub(super) fn factorise(
        &mut self,
        problem: &mut P,
        x: &P::Point,
        state: &mut State,
        violation: f64,
    ) -> Option<Inertia> {
        let clock = Instant::now();
        for (i, d) in self.scratch.diagonal_y.iter_mut().enumerate() {
            *d = if state.equality[i] {
                0.0
            } else {
                1.0 / state.slack_sigma(i)
            };
        }
        let (last, forced) = (state.last_inertia, state.forced_shift);
        let mut inertia = Inertia::newton(forced);
        let how = if state.circles() {
            Convexification::Shift
        } else {
            state.options.convexification
        };
        let newton = violation < NEAR;
        let mut next = Inertia::first(how, last, forced, newton);
        loop {
            if next.curvature < inertia.curvature {
                let factor = next.curvature / inertia.curvature;
                problem.scale_row_curvature(x, factor, &mut self.data);
            }
            inertia = next;
            if inertia.shift > MAX_SHIFT || self.factorise_shifted(state, inertia.shift) {
                break;
            }
            next = inertia.next(how, last, forced);
        }
        self.timing.factorise += clock.elapsed();
        state.note_level(inertia.level > 0 && inertia.level == last.level);
        match how {
            Convexification::Curvature => state.last_inertia = inertia,
            Convexification::Shift if inertia.shift > 0.0 => state.last_inertia = inertia,
            Convexification::Shift => {}
        }
        (inertia.shift <= MAX_SHIFT).then_some(inertia)
    }

    /// True if the system with this shift is positive definite.
    fn factorise_shifted(&mut self, state: &State, shift: f64) -> bool {
        for (i, d) in self.scratch.diagonal_x.iter_mut().enumerate() {
            *d = state.vars.sigma(i) + shift;
        }
        let diagonals = Diagonals {
            variables: &self.scratch.diagonal_x,
            rows: &self.scratch.diagonal_y,
            delta: state.options.row_regularisation,
        };
        self.factorisations += 1;
        self.kkt
            .factorise(&self.structure, &self.data, diagonals)
            .is_ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Curvature and shift of what is tried one after the other.
    fn tried(how: Convexification, last: Inertia, forced: f64) -> Vec<(f64, f64)> {
        tried_from(false, how, last, forced)
    }

    /// The same where Newton's system may come first.
    fn tried_from(
        newton: bool,
        how: Convexification,
        last: Inertia,
        forced: f64,
    ) -> Vec<(f64, f64)> {
        let first = Some(Inertia::first(how, last, forced, newton));
        let all = std::iter::successors(first, |now| Some(now.next(how, last, forced)));
        all.map(|i| (i.curvature, i.shift)).take(9).collect()
    }

    #[test]
    fn the_curvature_of_the_rows_is_halved_until_there_is_none_while_the_shift_grows() {
        let all = tried(Convexification::Curvature, Inertia::newton(0.0), 0.0);
        let curvature: Vec<f64> = all.iter().map(|i| i.0).collect();
        assert_eq!(curvature[..5], [1.0, 0.5, 0.25, 0.125, 0.0625]);
        assert_eq!(curvature[5..], [1.0 / 32.0, 1.0 / 64.0, 0.0, 0.0]);
        let shifts: Vec<f64> = all.iter().map(|i| i.1).collect();
        assert_eq!(shifts[..5], [0.0, 0.01, 0.02, 0.04, 0.08]);
    }

    #[test]
    fn what_is_tried_begins_with_twice_the_curvature_of_the_last_system() {
        for (level, first) in [(0, (1.0, 0.0)), (1, (1.0, 0.0)), (3, (0.25, 0.02))] {
            let last = Inertia::halved(level, 0.0);
            assert_eq!(tried(Convexification::Curvature, last, 0.0)[0], first);
        }
    }

    #[test]
    fn newtons_system_may_be_tried_before_twice_the_last_curvature() {
        let last = Inertia::halved(4, 0.0);
        let all = tried_from(true, Convexification::Curvature, last, 0.0);
        let curvature: Vec<f64> = all.iter().map(|i| i.0).collect();
        assert_eq!(curvature[..4], [1.0, 0.125, 0.0625, 0.03125]);
    }

    #[test]
    fn shifts_grow_to_one_before_the_curvature_is_dropped() {
        let all = tried(Convexification::Shift, Inertia::newton(0.0), 0.0);
        let curved = [0.0, 1e-4, 1e-2, 1.0].map(|shift| (1.0, shift));
        assert_eq!(all[..4], curved);
        assert_eq!(all[4..6], [(0.0, 0.0), (0.0, 1e-4)]);
    }

    #[test]
    fn a_shift_that_is_asked_for_anyway_is_kept() {
        for how in [Convexification::Curvature, Convexification::Shift] {
            let all = tried(how, Inertia::newton(0.0), 1.0);
            assert!(all.iter().all(|&(_, shift)| shift >= 1.0), "{all:?}");
        }
    }
}
