//! Which of the motions under way is optimised next where there are more of them than threads: the one with the least clock.
//!
//! The clock of a motion is that of the search at its submission, plus the work done on it: elements of its problem, summed over
//! iterations; on the finer grid, where a motion may become a plan, several units of work count as one. It is the same on every machine,
//! and results are taken in its order ([`super::Run::take_next`]); the least advanced motion is the one that everything else waits for.
//! A motion that is likely to become a plan takes all places, and threads, for itself: the others go on when it has ended, or is more
//! advanced.
//! Drawing sequences takes a place too, and has its clock: what it does advances the search's, and before it goes on all results are
//! taken that come before.

use std::collections::BTreeMap;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Places for as many motions as may be optimised at the same time.
pub(super) struct Turns {
    state: Mutex<State>,
    changed: Condvar,
}

struct State {
    places: isize,
    /// Negative while some that have one are to leave it to one that takes all.
    free: isize,
    /// By number of the sequence.
    jobs: BTreeMap<usize, Job>,
}

struct Job {
    clock: u64,
    /// Places that it takes, as soon as one is free.
    takes: isize,
    runs: bool,
}

impl State {
    /// The one without a place that is least advanced.
    fn next(&self) -> Option<(u64, usize)> {
        let waiting = self.jobs.iter().filter(|(_, job)| !job.runs);
        waiting.map(|(&number, job)| (job.clock, number)).min()
    }

    /// A job takes its places, or gives them back.
    fn run(&mut self, number: usize, runs: bool) {
        if let Some(job) = self.jobs.get_mut(&number).filter(|job| job.runs != runs) {
            self.free += if runs { -job.takes } else { job.takes };
            job.runs = runs;
        }
    }
}

/// A place of one motion, given back when it is dropped.
pub(super) struct Turn<'a> {
    turns: &'a Turns,
    number: usize,
}

impl Turns {
    /// For `places` motions at the same time.
    pub fn new(places: usize) -> Self {
        let places = places.try_into().unwrap_or(isize::MAX);
        let state = State {
            places,
            free: places,
            jobs: BTreeMap::new(),
        };
        Self {
            state: Mutex::new(state),
            changed: Condvar::new(),
        }
    }

    /// How many motions are optimised at the same time.
    pub fn places(&self) -> usize {
        self.lock().places.unsigned_abs()
    }

    /// Waits for a place for sequence `number`, whose clock stands at `clock`.
    pub fn enter(&self, number: usize, clock: u64) -> Turn<'_> {
        self.enter_with(number, clock, 1)
    }

    /// The same for what takes all places, as soon as one is free: the others leave theirs when they have worked.
    pub fn enter_for_all(&self, number: usize, clock: u64) -> Turn<'_> {
        let places = self.lock().places;
        self.enter_with(number, clock, places)
    }

    fn enter_with(&self, number: usize, clock: u64, takes: isize) -> Turn<'_> {
        let mut state = self.lock();
        let job = Job {
            clock,
            takes,
            runs: false,
        };
        state.jobs.insert(number, job);
        self.wait(state, number);
        Turn {
            turns: self,
            number,
        }
    }

    /// Waits for all places: before all motions, which wait in their turn until the places are given back.
    pub fn all(&self) -> Vec<Turn<'_>> {
        let turn = |place| self.enter(usize::MAX - place, 0);
        (0..self.places()).map(turn).collect()
    }

    fn wait(&self, mut state: MutexGuard<'_, State>, number: usize) {
        while state.free <= 0 || state.next().is_none_or(|(_, next)| next != number) {
            state = self
                .changed
                .wait(state)
                .unwrap_or_else(PoisonError::into_inner);
        }
        state.run(number, true);
        drop(state);
        self.changed.notify_all(); // there may be another free place
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Turn<'_> {
    /// Counts work, and leaves the place to a motion that is less advanced, if one waits or has taken all, until it is this one's turn
    /// again.
    pub fn worked(&self, work: u64) {
        let mut state = self.turns.lock();
        let (mut now, mut takes) = (0, 0);
        if let Some(job) = state.jobs.get_mut(&self.number) {
            job.clock += work;
            (now, takes) = (job.clock, job.takes);
        }
        let is_wanted = state.free < 0 && takes == 1;
        if is_wanted || state.next().is_some_and(|(clock, _)| clock < now) {
            state.run(self.number, false);
            self.turns.changed.notify_all();
            self.turns.wait(state, self.number);
        }
    }
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        let mut state = self.turns.lock();
        state.run(self.number, false);
        state.jobs.remove(&self.number);
        drop(state);
        self.turns.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
    use std::sync::mpsc::channel;
    use std::thread;
    use std::time::Duration;

    #[test]
    fn one_place_is_shared_so_that_all_advance_alike() {
        let turns = Turns::new(1);
        let (sender, receiver) = channel();
        let blocked = turns.enter(0, 0);
        thread::scope(|scope| {
            for (number, work) in [(1, 30), (2, 10), (3, 20)] {
                let (turns, sender) = (&turns, sender.clone());
                scope.spawn(move || {
                    let turn = turns.enter(number, 0);
                    for step in 1..=4 {
                        sender.send((work * (step - 1), number)).expect("sent");
                        turn.worked(work);
                    }
                });
            }
            // All three wait before the first begins.
            while turns.lock().jobs.len() < 4 {
                thread::yield_now();
            }
            drop(blocked);
        });
        drop(sender);
        let order: Vec<(u64, usize)> = receiver.into_iter().collect();
        let clocks: Vec<u64> = order.iter().map(|&(clock, _)| clock).collect();
        assert_eq!(order.len(), 12);
        assert!(clocks.is_sorted(), "the least advanced goes on: {order:?}");
    }

    /// Of two places, a motion that has worked stands still in one while all are taken so, until they are given back.
    fn stands_still_while<'a, T>(turns: &'a Turns, take: impl FnOnce(&'a Turns) -> T) {
        let (steps, ended) = (AtomicUsize::new(0), AtomicBool::new(false));
        thread::scope(|scope| {
            scope.spawn(|| {
                let turn = turns.enter(1, 1);
                while !ended.load(Ordering::SeqCst) {
                    turn.worked(1);
                    steps.fetch_add(1, Ordering::SeqCst);
                }
            });
            while steps.load(Ordering::SeqCst) < 5 {
                thread::yield_now();
            }
            let all = take(turns);
            while turns.lock().free < 0 {
                thread::yield_now();
            }
            let before = steps.load(Ordering::SeqCst);
            thread::sleep(Duration::from_millis(5));
            assert_eq!(steps.load(Ordering::SeqCst), before);
            ended.store(true, Ordering::SeqCst);
            drop(all);
        });
        assert_eq!(turns.lock().free, 2);
    }

    #[test]
    fn motions_stand_still_while_all_places_are_taken() {
        stands_still_while(&Turns::new(2), Turns::all);
    }

    #[test]
    fn what_takes_all_places_begins_in_one_and_the_others_leave_theirs() {
        stands_still_while(&Turns::new(2), |turns| turns.enter_for_all(2, 3));
    }

    #[test]
    fn a_place_is_given_back_by_a_motion_that_ends_early() {
        let turns = Turns::new(1);
        let ended = thread::scope(|scope| {
            let broken = scope.spawn(|| {
                let _turn = turns.enter(1, 0);
                panic!("in the middle of a motion");
            });
            broken.join().is_err()
        });
        assert!(ended);
        turns.enter(2, 5).worked(1);
        assert_eq!(turns.lock().free, 1);
    }
}
