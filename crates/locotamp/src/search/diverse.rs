//! The best plans that differ in what they do: of plans with the same loaded contacts the best stays.

use std::ops::Index;

use super::reward::{self, Worth};
use crate::api::Alternative;
use ocp::Point;
use plan::{Plan, Row6};
use symbolic::Sequence;

/// Share of the robot's weight from which a contact of the robot counts as loaded.
const LOADED: f64 = 0.02;

/// A plan with what it takes to refine it.
pub(super) struct Kept {
    pub alternative: Alternative,
    pub worth: Worth,
    pub motion: Stored,
}

/// What it takes to set a motion up again, and what it took to find it.
pub(super) struct Stored {
    pub sequence: Sequence,
    /// Intervals per phase.
    pub steps: Vec<usize>,
    pub point: Point,
    /// Of the solver.
    pub iterations: usize,
    /// Time of the optimiser [s].
    pub seconds: f64,
}

/// The best plans with different loaded contacts, at most so many, the best first.
pub(super) struct Diverse {
    plans: Vec<Kept>,
    most: usize,
    least_gain: f64,
}

impl Diverse {
    /// At least one is kept.
    pub fn new(most: usize, least_gain: f64) -> Self {
        Self {
            plans: vec![],
            most: most.max(1),
            least_gain,
        }
    }

    /// The best plan.
    pub fn best(&self) -> Option<&Kept> {
        self.plans.first()
    }

    pub fn len(&self) -> usize {
        self.plans.len()
    }

    pub fn plans(self) -> impl Iterator<Item = Kept> {
        self.plans.into_iter()
    }

    /// Takes a plan unless a better one does the same.
    pub fn offer(&mut self, kept: Kept) {
        let loaded = kept.alternative.loaded.clone();
        self.plans.push(kept);
        reward::sort(&mut self.plans, self.least_gain, |kept| kept.worth);
        let mut is_there = false;
        self.plans.retain(|other| {
            let same = other.alternative.loaded == loaded;
            let worse = same && is_there;
            is_there |= same;
            !worse
        });
        self.plans.truncate(self.most);
    }
}

impl Index<usize> for Diverse {
    type Output = Kept;

    fn index(&self, n: usize) -> &Kept {
        &self.plans[n]
    }
}

/// The contacts that bear load, phase by phase; a phase that bears on the same ones as the phase before does not count.
///
/// `weight` is that of the robot [N]. Contacts of objects with the environment count whatever they bear.
pub(super) fn loaded(plan: &Plan, weight: f64) -> Vec<Vec<String>> {
    let mut phases: Vec<Vec<String>> = Vec::new();
    for phase in &plan.phases {
        let mut contacts: Vec<String> = Vec::new();
        for contact in &phase.contacts {
            let most = contact.wrench.iter().map(force).fold(0.0, f64::max);
            let of_object = plan.objects.iter().any(|o| {
                plan.interfaces
                    .iter()
                    .any(|i| i.name == contact.a && i.body == o.name)
            });
            if of_object || most > LOADED * weight {
                contacts.push(format!("{} on {}", contact.a, contact.b));
            }
        }
        contacts.sort_unstable();
        if phases.last() != Some(&contacts) {
            phases.push(contacts);
        }
    }
    phases
}

fn force(wrench: &Row6) -> f64 {
    wrench[..3].iter().map(|f| f * f).sum::<f64>().sqrt()
}
