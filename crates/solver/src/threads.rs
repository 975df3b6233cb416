//! Parts of a task, on threads of their own where there may be any.

use std::panic::resume_unwind;
use std::{iter, thread};

/// Runs both, the second one on a thread of its own if there may be two.
///
/// # Panics
/// If one of them does.
pub fn join<A, B: Send>(
    threads: usize,
    first: impl FnOnce() -> A,
    second: impl FnOnce() -> B + Send,
) -> (A, B) {
    if threads < 2 {
        return (first(), second());
    }
    thread::scope(|scope| {
        let second = scope.spawn(second);
        let first = first();
        (
            first,
            second.join().unwrap_or_else(|panic| resume_unwind(panic)),
        )
    })
}

/// Does all tasks, every one but the first on a thread of its own.
///
/// # Panics
/// If one of them does.
pub fn each<T: Send>(mut tasks: impl Iterator<Item = T>, work: impl Fn(T) + Sync) {
    let Some(first) = tasks.next() else { return };
    let Some(second) = tasks.next() else {
        return work(first);
    };
    let work = &work;
    thread::scope(|scope| {
        for task in iter::once(second).chain(tasks) {
            scope.spawn(move || work(task));
        }
        work(first);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_task_is_done_once() {
        for count in 0..4 {
            let mut done = vec![0; count];
            each(done.iter_mut(), |done| *done += 1);
            assert_eq!(done, vec![1; count]);
        }
    }

    #[test]
    fn both_halves_are_done_with_one_thread_and_with_two() {
        for threads in [1, 2] {
            let mut numbers = [1, 2];
            let (first, second) = numbers.split_at_mut(1);
            let both = join(
                threads,
                || std::mem::replace(&mut first[0], 3),
                || std::mem::replace(&mut second[0], 4),
            );
            assert_eq!((both, numbers), ((1, 2), [3, 4]));
        }
    }
}
