//! The motions under way, and whose result is the next.

use super::proposals::Candidate;
use super::workers::Evaluated;
use std::collections::BTreeMap;

/// Motions that are optimised, by number of the sequence.
#[derive(Default)]
pub(super) struct UnderWay(BTreeMap<usize, Entry>);

struct Entry {
    candidate: Candidate,
    /// The search's clock when it was submitted.
    begin: u64,
    /// Work known to be done on it: all of it once there is a result.
    work: u64,
    result: Option<Evaluated>,
}

impl UnderWay {
    pub fn len(&self) -> usize {
        self.0.len()
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// A sequence is submitted at this clock of the search, with work that need not be done again.
    pub fn begin(&mut self, candidate: Candidate, clock: u64, work: u64) {
        let entry = Entry {
            begin: clock,
            work,
            result: None,
            candidate,
        };
        self.0.insert(entry.candidate.number, entry);
    }

    /// So much work has been done on it by now.
    pub fn worked(&mut self, number: usize, work: u64) {
        if let Some(entry) = self.0.get_mut(&number) {
            entry.work = entry.work.max(work);
        }
    }

    /// Its result has come.
    pub fn done(&mut self, number: usize, result: Evaluated) {
        self.worked(number, result.work);
        if let Some(entry) = self.0.get_mut(&number) {
            entry.result = Some(result);
        }
    }

    /// The next result: the one with the least clock, the first of these, if none under way can still come before it.
    pub fn next(&self) -> Option<&Evaluated> {
        self.next_entry()?.result.as_ref()
    }

    /// Takes it, with its clock.
    pub fn take_next(&mut self) -> Option<(u64, Candidate, Evaluated)> {
        self.next()?;
        let number = self.next_entry()?.candidate.number;
        let entry = self.0.remove(&number)?;
        Some((entry.begin + entry.work, entry.candidate, entry.result?))
    }

    fn next_entry(&self) -> Option<&Entry> {
        let entries = self.0.values();
        entries.min_by_key(|entry| (entry.begin + entry.work, entry.candidate.number))
    }

    /// Takes all plans that are there, and forgets the rest.
    pub fn take_plans(&mut self) -> Vec<(Candidate, Evaluated)> {
        let entries = std::mem::take(&mut self.0).into_values();
        let plan =
            |entry: Entry| Some((entry.candidate, entry.result.filter(|r| r.plan.is_some())?));
        entries.filter_map(plan).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocp::NEARLY_SOLVED;
    use symbolic::Sequence;

    fn candidate(number: usize) -> Candidate {
        Candidate {
            number,
            sequence: Sequence {
                states: vec![],
                labels: vec![],
                skeleton: vec![],
                cost: 0.0,
            },
            promise: 0.0,
            coarse: None,
            known: None,
        }
    }

    fn result(work: u64) -> Evaluated {
        Evaluated {
            feasible: false,
            must_hold: false,
            cost: 0.0,
            objective: 0.0,
            violation: 1.0,
            iterations: 1,
            work,
            seconds: 0.0,
            reason: None,
            worst_phase: None,
            dearest_phase: None,
            point: None,
            steps: vec![],
            plan: None,
            relative: None,
        }
    }

    #[test]
    fn results_come_in_the_order_of_work_as_soon_as_none_can_come_before_them() {
        let mut under_way = UnderWay::default();
        under_way.begin(candidate(1), 0, 0);
        under_way.begin(candidate(2), 10, 0);
        under_way.done(2, result(20));
        assert!(under_way.next().is_none(), "the first may end before 30");
        under_way.worked(1, 30);
        assert!(under_way.next().is_none(), "at 30 the first comes first");
        under_way.worked(1, 31);
        let (clock, taken, _) = under_way.take_next().expect("the second is next");
        assert_eq!((clock, taken.number), (30, 2));
        assert!(under_way.take_next().is_none());
        under_way.done(1, result(40));
        let (clock, taken, _) = under_way.take_next().expect("the first is next");
        assert_eq!((clock, taken.number), (40, 1));
        assert!(under_way.is_empty());
    }

    #[test]
    fn what_is_nearly_a_motion_has_failed_nowhere() {
        let failed = |violation| {
            let result = Evaluated {
                violation,
                worst_phase: Some(3),
                ..result(1)
            };
            result.failed_phase()
        };
        assert_eq!(failed(1.1 * NEARLY_SOLVED), Some(3));
        assert_eq!(failed(NEARLY_SOLVED), None);
    }
}
