//! A sequence whose keyframes exist, and what is next for it.

use super::growth::Costs;
use super::results::name;
use super::workers::Evaluated;
use crate::api::Reached;
use crate::journal::{PointEntry, Tried};
use ocp::{Point, Relative};
use std::sync::Arc;
use symbolic::Sequence;

/// Work on the finer grid that counts as one unit: what may become a plan is not kept waiting by what else is tried. While one is held
/// that probably becomes one, hardly anything else is done (benches/runs/2026-11-28-all-threads.md).
const HOLD_PACE: u64 = 3;
const LIKELY_PACE: u64 = 16;

/// A sequence whose keyframes exist.
pub(super) struct Candidate {
    pub number: usize,
    pub sequence: Sequence,
    /// The cost that its keyframes promise.
    pub promise: f64,
    /// Its motion on the coarse grid, once there is one that may hold on a finer grid.
    pub coarse: Option<Coarse>,
    /// What is known of it from the run that is continued.
    pub known: Option<Tried>,
}

/// What the motion of a sequence on the coarse grid costs, and what it took.
pub(super) struct Coarse {
    pub costs: Costs,
    pub iterations: usize,
    pub work: u64,
    pub seconds: f64,
    pub relative: Option<Arc<Relative>>,
    /// True if it will probably hold on a finer grid as it is ([`super::growth::Growth`]).
    pub is_likely: bool,
}

impl Candidate {
    /// Work on it that counts as one unit of the search's clock.
    pub fn pace(&self) -> u64 {
        match &self.coarse {
            None => 1,
            Some(_) if self.is_likely() => LIKELY_PACE,
            Some(_) => HOLD_PACE,
        }
    }

    /// True if its motion on the finer grid is likely to become a plan: it has all threads.
    pub fn is_likely(&self) -> bool {
        (self.coarse.as_ref()).is_some_and(|coarse| coarse.is_likely)
    }
}

/// What is next for it.
pub(super) enum Work {
    /// The motion, from keyframes.
    Move(Vec<Vec<f64>>),
    /// The same motion on the grid on which it must hold, from that on the coarse grid with so many intervals per phase.
    Hold(Point, Vec<usize>),
    /// Nothing but to set up again a motion that is known, and whether it is feasible.
    Restore {
        point: PointEntry,
        feasible: bool,
        /// Work that it took.
        work: u64,
    },
    /// Nothing: it is known what comes of it.
    Remembered(Box<Evaluated>),
}

impl Work {
    /// After what the journal holds: a motion, or that there is none; `coarse` of the work was for that on the coarse grid.
    pub fn known(tried: &Tried, coarse: u64) -> Self {
        let feasible = tried.reached == name(Reached::Feasible);
        let work = tried.work.saturating_sub(coarse);
        let Some(point) = tried.point.clone() else {
            let known = Evaluated::remembered(tried);
            return Self::Remembered(Box::new(Evaluated { work, ..known }));
        };
        Self::Restore {
            point,
            feasible,
            work,
        }
    }

    /// Work that the run that is continued has done, and that need not be done again.
    pub fn spent(&self) -> u64 {
        match self {
            Self::Move(_) | Self::Hold(..) => 0,
            Self::Restore { work, .. } => *work,
            Self::Remembered(done) => done.work,
        }
    }
}
