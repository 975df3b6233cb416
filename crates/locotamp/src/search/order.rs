//! Which of the sequences that wait has its turn.

/// Sequences tried on the coarse grid before the first is tried on a finer one, which takes up to twice as long.
const CHOICE: usize = 2;
/// Motions on the coarse grid that wait for a finer one, from which on the cheapest is tried whatever others promise: of long sequences
/// there are always some that promise less than they cost.
const MOST_WAITING: usize = 3;
/// The same with strained ones ([`super::growth`]), which hardly ever hold on a finer grid.
const MOST_STRAINED: usize = 10;

/// A sequence that waits for its turn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Waiting {
    /// True if it has its motion on the coarse grid, and waits for the finer one.
    pub has_motion: bool,
    /// What that costs, or is likely to cost.
    pub cost: f64,
    /// True if it will hardly hold.
    pub is_strained: bool,
    /// True if it will probably hold.
    pub is_likely: bool,
}

/// What may be begun.
#[derive(Debug, Clone, Copy)]
pub(super) struct May {
    /// Motions on the coarse grid.
    pub move_one: bool,
    /// Motions on the finer grid.
    pub hold_one: bool,
    /// So many sequences have been drawn that there is a choice.
    pub choose: bool,
    /// Sequences that have been tried on the coarse grid.
    pub moved: usize,
}

/// The most promising one: whose motion on the coarse grid is likely to cost least, since postures at the edge of reach cost a lot,
/// and make the optimiser's work hard; of equal ones the first.
///
/// What will probably hold is tried on the finer grid at once, before what costs less and will hardly. What else has its motion is if it
/// is the most promising, and there are some to choose from, or no other waits. If many have theirs, the cheapest of them is tried.
/// Others are begun only if so many sequences have been drawn that there is a choice.
pub(super) fn next(waiting: &[Waiting], may: May) -> Option<usize> {
    let cost = |n: usize| waiting[n].cost;
    let least = |counts: &dyn Fn(&Waiting) -> bool| {
        (0..waiting.len())
            .filter(|&n| counts(&waiting[n]))
            .min_by(|&a, &b| cost(a).total_cmp(&cost(b)))
    };
    let likely = least(&|w| w.has_motion && w.is_likely);
    let held = likely.or_else(|| least(&|w| w.has_motion));
    let held = held.filter(|_| may.hold_one);
    let begun = least(&|w| !w.has_motion).filter(|_| may.move_one);
    let motions = || waiting.iter().filter(|w| w.has_motion);
    let are_many = motions().count() >= MOST_STRAINED
        || motions().filter(|w| !w.is_strained).count() >= MOST_WAITING;
    let is_chosen = |hold: usize, begin: usize| {
        let is_cheapest = may.moved >= CHOICE && cost(hold) <= cost(begin);
        waiting[hold].is_likely || is_cheapest
    };
    match (held, begun) {
        (Some(hold), Some(begin)) if are_many || is_chosen(hold, begin) => Some(hold),
        (_, Some(begin)) => Some(begin).filter(|_| may.choose),
        (hold, None) => hold.filter(|_| may.choose),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAY: May = May {
        move_one: true,
        hold_one: true,
        choose: true,
        moved: CHOICE,
    };

    /// Costs from which on motions are strained here.
    const STRAIN: f64 = 50.0;

    /// Sequences with motions at these costs, then others.
    fn waiting(with: &[f64], without: &[f64]) -> Vec<Waiting> {
        let all = |costs: &[f64], has_motion: bool| {
            let one = |&cost: &f64| Waiting {
                has_motion,
                cost,
                is_strained: cost > STRAIN,
                is_likely: false,
            };
            costs.iter().map(one).collect::<Vec<_>>()
        };
        [all(with, true), all(without, false)].concat()
    }

    #[test]
    fn the_cheapest_motion_is_tried_on_the_finer_grid_unless_others_promise_less() {
        assert_eq!(next(&waiting(&[5.0, 4.0], &[6.0]), MAY), Some(1));
        assert_eq!(next(&waiting(&[5.0, 4.0], &[6.0, 3.0]), MAY), Some(3));
    }

    #[test]
    fn if_many_have_a_motion_the_cheapest_is_tried_whatever_others_promise() {
        assert_eq!(next(&waiting(&[5.0, 4.0, 6.0], &[3.0]), MAY), Some(1));
    }

    #[test]
    fn strained_motions_wait_until_there_are_more_of_them() {
        let few: Vec<f64> = (1..MOST_STRAINED).map(|n| STRAIN + n as f64).collect();
        assert_eq!(next(&waiting(&few, &[3.0]), MAY), Some(few.len()));
        let many = [&[STRAIN + 0.5], few.as_slice()].concat();
        assert_eq!(next(&waiting(&many, &[3.0]), MAY), Some(0));
    }

    #[test]
    fn nothing_is_held_before_there_is_something_to_choose_from_unless_nothing_else_waits() {
        let few = May { moved: 1, ..MAY };
        assert_eq!(next(&waiting(&[4.0], &[6.0]), few), Some(1));
        assert_eq!(next(&waiting(&[4.0], &[]), few), Some(0));
        let undrawn = May {
            choose: false,
            ..few
        };
        assert_eq!(next(&waiting(&[4.0], &[6.0]), undrawn), None);
        assert_eq!(next(&waiting(&[4.0], &[]), undrawn), None);
    }

    #[test]
    fn what_will_probably_hold_is_held_at_once() {
        let first = May { moved: 1, ..MAY };
        let mut sequences = waiting(&[4.0], &[6.0, 3.0]);
        sequences[0].is_likely = true;
        assert_eq!(next(&sequences, first), Some(0), "whatever promises less");
        let mut two = waiting(&[4.0, 5.0], &[6.0]);
        two[1].is_likely = true;
        assert_eq!(next(&two, MAY), Some(1), "whatever motion costs less");
    }

    #[test]
    fn what_may_not_be_begun_is_not() {
        let (full, choosing) = (
            May {
                move_one: false,
                ..MAY
            },
            May {
                hold_one: false,
                ..MAY
            },
        );
        assert_eq!(next(&waiting(&[4.0], &[3.0]), full), Some(0));
        assert_eq!(next(&waiting(&[4.0], &[5.0]), choosing), Some(1));
        assert_eq!(next(&[], MAY), None);
    }
}
