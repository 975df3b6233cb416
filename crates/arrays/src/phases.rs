//! What is held over each interval of a plan: phase, active contacts and their wrenches.

use plan::{Plan, Row6};

/// Contacts of a plan by pair of interfaces.
pub(crate) struct Phases<'a> {
    plan: &'a Plan,
    /// Phase of each interval.
    of_interval: Vec<usize>,
    /// First interval of each phase.
    starts: Vec<usize>,
    /// Interfaces `a` and `b` of every pair that some phase has, in the order in which they come.
    pairs: Vec<[&'a str; 2]>,
}

impl<'a> Phases<'a> {
    pub fn new(plan: &'a Plan) -> Self {
        let mut pairs = Vec::new();
        for contact in plan.phases.iter().flat_map(|phase| &phase.contacts) {
            let pair = [contact.a.as_str(), contact.b.as_str()];
            if !pairs.contains(&pair) {
                pairs.push(pair);
            }
        }
        let steps = plan.phases.iter().enumerate();
        Self {
            plan,
            of_interval: steps.flat_map(|(k, x)| vec![k; x.steps]).collect(),
            starts: plan.phase_starts(),
            pairs,
        }
    }

    /// `a on b` of every pair.
    pub fn names(&self) -> Vec<String> {
        let pairs = self.pairs.iter();
        pairs.map(|[a, b]| format!("{a} on {b}")).collect()
    }

    /// Phase of an interval.
    pub fn of(&self, interval: usize) -> usize {
        self.of_interval[interval]
    }

    /// Per pair the wrench on `a` in an interval; `None`: not in contact. World axes, about the origin of `a`.
    pub fn wrenches(&self, interval: usize) -> Vec<Option<Row6>> {
        let k = self.of(interval);
        let mut wrenches = vec![None; self.pairs.len()];
        for contact in &self.plan.phases[k].contacts {
            let found = |pair: &[&str; 2]| *pair == [contact.a.as_str(), contact.b.as_str()];
            let place = self.pairs.iter().position(found);
            let place = place.expect("all pairs of all phases were collected");
            let sum = wrenches[place].get_or_insert([0.0; 6]);
            let wrench = contact.wrench[interval - self.starts[k]];
            sum.iter_mut().zip(wrench).for_each(|(sum, x)| *sum += x);
        }
        wrenches
    }
}
