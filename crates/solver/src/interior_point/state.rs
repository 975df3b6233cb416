//! What changes from iteration to iteration beside the point: slacks, multipliers, barrier parameter, filter.

use super::InteriorPoint;
use super::barrier_update::Progress;
use super::inertia::Inertia;
use super::residuals::gather_rows;
use super::step::Direction;
use crate::barrier::{Bounded, push_inside};
use crate::filter::Filter;
use crate::{Options, Problem};

/// Relaxation that is given up in one go [scaled rows].
const CLOSE: f64 = 1e-3;
/// Least share of the row violation that a step is asked to remove.
const MIN_DAMPING: f64 = 0.2;
/// Violation below which steps ask for all of it.
const FULL_STEP: f64 = 1e-3;
/// Systems in a row that needed the same share of the rows' curvature after which steps count as circling, wherever they are: from
/// there on the diagonal is shifted instead ([`crate::Convexification::Shift`]). Solves that get on need now more, now less.
const CIRCLING: usize = 12;
/// Forced shift after which no step is hoped for.
const MAX_FORCED_SHIFT: f64 = 1e6;

/// The mutable state of one solve.
pub(super) struct State {
    pub options: Options,
    pub vars: Bounded,
    /// Slacks of the rows, their bounds relaxed where the start violates them.
    pub slacks: Bounded,
    pub equality: Vec<bool>,
    /// The rows' own bounds.
    goal_lower: Vec<f64>,
    goal_upper: Vec<f64>,
    /// Row multipliers.
    pub y: Vec<f64>,
    /// Share of the row violation that the next step is asked to remove.
    pub damping: f64,
    pub mu: f64,
    /// True while μ falls monotonically.
    pub monotone: bool,
    pub progress: Progress,
    pub filter: Filter,
    /// True if the filter is to be emptied whatever μ does.
    pub needs_reset: bool,
    /// What the last system needed; with [`crate::Convexification::Shift`] the last one that needed a shift.
    pub last_inertia: Inertia,
    /// How many systems in a row needed the same share of the rows' curvature, where that was not all.
    same_level: usize,
    /// Least shift of the next system, raised when no step was acceptable.
    pub forced_shift: f64,
}

impl<P: Problem> InteriorPoint<P> {
    /// Moves `x` between its bounds and sets up slacks and multipliers.
    pub(super) fn start(
        &mut self,
        problem: &mut P,
        x: &mut P::Point,
        options: &Options,
        warm: Option<&[f64]>,
    ) -> State {
        let mut vars = Bounded::new(&self.structure.lower, &self.structure.upper);
        problem.coordinates(x, &mut vars.value);
        let dx = &mut self.scratch.step.dx;
        for (i, dx) in dx.iter_mut().enumerate() {
            let (l, u) = (vars.lower[i], vars.upper[i]);
            *dx = if l.is_finite() || u.is_finite() {
                push_inside(vars.value[i], l, u, options.bound_push) - vars.value[i]
            } else {
                vars.value[i] = 0.0;
                0.0
            };
        }
        let mut inside = x.clone();
        problem.retract(x, dx, 1.0, &mut inside);
        *x = inside;
        problem.coordinates(x, &mut vars.value);
        self.fixed.unbind(&mut vars);
        problem.evaluate(x, &mut self.data);
        gather_rows(&self.data, &mut self.scratch.rows);
        let bounds = |of: fn(&crate::ElementStructure) -> &Vec<f64>| -> Vec<f64> {
            let elements = self.structure.elements.iter();
            elements.flat_map(|e| of(e).iter().copied()).collect()
        };
        let (lower, upper) = (bounds(|e| &e.row_lower), bounds(|e| &e.row_upper));
        State::new(vars, (lower, upper), &self.scratch.rows, options, warm)
    }
}

impl State {
    fn new(
        mut vars: Bounded,
        (goal_lower, goal_upper): (Vec<f64>, Vec<f64>),
        rows: &[f64],
        options: &Options,
        warm: Option<&[f64]>,
    ) -> Self {
        let equality: Vec<bool> = goal_lower
            .iter()
            .zip(&goal_upper)
            .map(|(l, u)| l == u)
            .collect();
        let mut slacks = Bounded::new(&goal_lower, &goal_upper);
        slacks.value.copy_from_slice(rows);
        for i in 0..rows.len() {
            if equality[i] {
                // An equality has no slack to move: s = l, no barrier.
                slacks.value[i] = goal_lower[i];
                slacks.lower[i] = f64::NEG_INFINITY;
                slacks.upper[i] = f64::INFINITY;
            } else {
                slacks.lower[i] = goal_lower[i].min(slacks.value[i] - options.bound_push);
                slacks.upper[i] = goal_upper[i].max(slacks.value[i] + options.bound_push);
            }
        }
        let mu = options.initial_barrier;
        vars.start(mu);
        slacks.start(mu);
        let mut y = vec![0.0; rows.len()];
        for i in 0..rows.len() {
            // Stationarity of the slacks: y = zu − zl.
            y[i] = warm.map_or(slacks.z_upper[i] - slacks.z_lower[i], |w| w[i]);
        }
        Self {
            options: options.clone(),
            vars,
            slacks,
            equality,
            goal_lower,
            goal_upper,
            y,
            damping: options.first_damping,
            mu,
            monotone: false,
            progress: Progress::default(),
            filter: Filter::new(),
            needs_reset: true,
            last_inertia: Inertia::newton(0.0),
            same_level: 0,
            forced_shift: 0.0,
        }
    }

    /// Σ of a slack, kept from zero.
    pub fn slack_sigma(&self, i: usize) -> f64 {
        self.slacks.sigma(i).max(1e-16)
    }

    /// Violation of a row's own bounds, not of its slack: that is what counts for the user.
    pub fn violation(&self, i: usize, value: f64) -> f64 {
        if self.equality[i] {
            (value - self.slacks.value[i]).abs()
        } else {
            (self.goal_lower[i] - value)
                .max(value - self.goal_upper[i])
                .max(0.0)
        }
    }

    /// Takes note of whether a system needed the same share of the rows' curvature as the last one, until steps count as circling.
    pub fn note_level(&mut self, is_same: bool) {
        if !self.circles() {
            self.same_level = if is_same { self.same_level + 1 } else { 0 };
        }
    }

    /// True from when on steps count as circling.
    pub fn circles(&self) -> bool {
        self.same_level >= CIRCLING
    }

    /// After a refused line search: shifts the next system and forgets the filter; false if that was tried enough.
    pub fn shift_more(&mut self, inertia: Inertia) -> bool {
        if self.forced_shift > MAX_FORCED_SHIFT {
            return false;
        }
        self.forced_shift = (self.forced_shift * 100.0)
            .max(1e-2)
            .max(inertia.shift * 10.0);
        self.needs_reset = true;
        true
    }

    /// Of the rows, and of the variables' lower and upper bounds.
    pub fn multipliers(&self) -> [&[f64]; 3] {
        [&self.y, &self.vars.z_lower, &self.vars.z_upper]
    }

    /// Multipliers of the variables' bounds, positive where the upper one pulls.
    pub fn bound_multipliers(&self) -> Vec<f64> {
        let (lower, upper) = (&self.vars.z_lower, &self.vars.z_upper);
        upper.iter().zip(lower).map(|(u, l)| u - l).collect()
    }

    /// Moves the bound multipliers along a step, before the values move.
    pub fn step_multipliers(&mut self, step: &Direction, alpha_dual: f64) {
        self.vars.step_multipliers(&step.dx, self.mu, alpha_dual);
        self.slacks.step_multipliers(&step.ds, self.mu, alpha_dual);
    }

    /// Moves slacks and row multipliers along an accepted step from a point with this violation; the variables have moved.
    pub fn step_rows(&mut self, step: &Direction, alpha: f64, violation: f64) {
        for i in 0..self.y.len() {
            self.slacks.value[i] += alpha * step.ds[i];
            self.y[i] += alpha * step.dy[i];
        }
        for i in 0..self.y.len() {
            let moves = !self.equality[i] && self.tighten(i);
            // The filter belongs to a problem with other bounds.
            self.needs_reset |= moves && !self.options.keeps_filter;
        }
        self.vars.safeguard(self.mu);
        self.slacks.safeguard(self.mu);
        self.forced_shift = if self.forced_shift > 1e-3 {
            self.forced_shift * 0.1
        } else {
            0.0
        };
        if violation < FULL_STEP {
            self.damping = 1.0;
        } else if alpha < 0.3 {
            self.damping = (0.7 * self.damping).max(MIN_DAMPING);
        } else if alpha > 0.5 {
            self.damping = (2.0 * self.damping).min(1.0);
        }
    }

    /// Moves the relaxed bounds of a slack towards the row's own ones; false if they are there.
    fn tighten(&mut self, i: usize) -> bool {
        let (l, u, v) = (
            self.slacks.lower[i],
            self.slacks.upper[i],
            self.slacks.value[i],
        );
        let (mut new_l, mut new_u) = (l, u);
        let share = self.options.tightening;
        if l < self.goal_lower[i] {
            let full = self.goal_lower[i] - l;
            new_l = if full < CLOSE {
                self.goal_lower[i]
            } else {
                l + share * full
            };
        }
        if u > self.goal_upper[i] {
            let full = u - self.goal_upper[i];
            new_u = if full < CLOSE {
                self.goal_upper[i]
            } else {
                u - share * full
            };
        }
        let moves = new_l != l || new_u != u;
        if moves {
            let room = 0.25 * (new_u - new_l);
            let low = new_l + (v - l).min(0.01).min(room);
            let high = new_u - (u - v).min(0.01).min(room);
            self.slacks.lower[i] = new_l;
            self.slacks.upper[i] = new_u;
            self.slacks.value[i] = v.max(low).min(high);
        }
        moves
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_circle_from_when_on_twelve_systems_in_a_row_needed_the_same() {
        let mut state = State::new(
            Bounded::new(&[], &[]),
            (vec![], vec![]),
            &[],
            &Options::default(),
            None,
        );
        let mut note = |times: usize, is_same| {
            (0..times).for_each(|_| state.note_level(is_same));
            state.circles()
        };
        assert!(!note(CIRCLING - 1, true));
        assert!(!note(1, false));
        assert!(!note(CIRCLING - 1, true));
        assert!(note(1, true));
        assert!(note(1, false), "for the rest of the solve");
    }
}
