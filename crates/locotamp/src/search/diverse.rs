//! The best plans that differ in what they do: of plans with the same loaded contacts the cheapest stays.

use crate::api::Alternative;
use plan::{Plan, Row6};

/// Share of the robot's weight from which a contact of the robot counts as loaded.
const LOADED: f64 = 0.02;

/// The cheapest plans with different loaded contacts, at most so many, the cheapest first.
#[derive(Debug, Default)]
pub(super) struct Diverse {
    pub plans: Vec<Alternative>,
    most: usize,
}

impl Diverse {
    pub fn new(most: usize) -> Self {
        Self {
            plans: vec![],
            most,
        }
    }

    /// Takes a plan unless a cheaper one does the same.
    pub fn offer(&mut self, plan: Alternative) {
        let same = |other: &Alternative| other.loaded == plan.loaded;
        if self
            .plans
            .iter()
            .any(|other| same(other) && other.cost <= plan.cost)
        {
            return;
        }
        self.plans.retain(|other| !same(other));
        let at = self.plans.partition_point(|other| other.cost <= plan.cost);
        self.plans.insert(at, plan);
        self.plans.truncate(self.most);
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
