//! The motions under way, and whose result is the next.

use super::candidate::Candidate;
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

impl Entry {
    /// The clock by which so much was done.
    fn clock(&self) -> u64 {
        self.begin + self.work / self.candidate.pace()
    }
}

impl UnderWay {
    pub fn len(&self) -> usize {
        self.0.len()
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Work of drawing that counts as one unit: as of the slowest motion, unless one of them has all threads.
    pub fn pace_of_drawing(&self) -> u64 {
        let all = || self.0.values().map(|entry| &entry.candidate);
        if all().any(Candidate::is_likely) {
            return 1;
        }
        all().map(Candidate::pace).min().unwrap_or(1)
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

    /// True if the next result may come before this clock.
    pub fn comes_before(&self, clock: u64) -> bool {
        let next = self.next_entry();
        next.is_some_and(|entry| entry.clock() < clock)
    }

    /// Takes it, with its clock.
    pub fn take_next(&mut self) -> Option<(u64, Candidate, Evaluated)> {
        self.next()?;
        let number = self.next_entry()?.candidate.number;
        let entry = self.0.remove(&number)?;
        Some((entry.clock(), entry.candidate, entry.result?))
    }

    fn next_entry(&self) -> Option<&Entry> {
        let entries = self.0.values();
        entries.min_by_key(|entry| (entry.clock(), entry.candidate.number))
    }

    /// Takes all plans that are there.
    pub fn take_plans(&mut self) -> Vec<(Candidate, Evaluated)> {
        let is_plan = |entry: &Entry| {
            let result = entry.result.as_ref();
            result.is_some_and(|result| result.plan.is_some())
        };
        let (plans, rest) = std::mem::take(&mut self.0)
            .into_iter()
            .partition(|(_, entry)| is_plan(entry));
        self.0 = rest;
        let plans: BTreeMap<usize, Entry> = plans;
        let parts = |entry: Entry| Some((entry.candidate, entry.result?));
        plans.into_values().filter_map(parts).collect()
    }

    /// The sequences, results or not.
    pub fn candidates(self) -> impl Iterator<Item = Candidate> {
        self.0.into_values().map(|entry| entry.candidate)
    }
}

#[cfg(test)]
mod tests {
    use super::super::candidate::Coarse;
    use super::*;
    use crate::lapse::Lapse;
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
            lapse: Lapse::default(),
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
    fn motions_on_the_finer_grid_advance_faster() {
        let held = |number, is_likely| Candidate {
            coarse: Some(Coarse {
                costs: result(1).costs(1.0),
                iterations: 1,
                work: 1,
                seconds: 0.0,
                relative: None,
                is_likely,
            }),
            ..candidate(number)
        };
        assert!(held(1, true).pace() > held(1, false).pace());
        let pace = held(1, false).pace();
        let mut under_way = UnderWay::default();
        assert_eq!(under_way.pace_of_drawing(), 1);
        under_way.begin(held(1, false), 10, 0);
        assert_eq!(under_way.pace_of_drawing(), pace);
        under_way.worked(1, 2 * pace);
        assert!(under_way.comes_before(13) && !under_way.comes_before(12));
        under_way.begin(candidate(2), 0, 0);
        assert_eq!(under_way.pace_of_drawing(), 1);
        under_way.done(2, result(13));
        under_way.done(1, result(2 * pace));
        let order: Vec<_> = std::iter::from_fn(|| under_way.take_next())
            .map(|(clock, taken, _)| (clock, taken.number))
            .collect();
        assert_eq!(order, [(12, 1), (13, 2)]);
        under_way.begin(held(3, true), 20, 0);
        assert_eq!(under_way.pace_of_drawing(), 1, "it has all threads");
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
