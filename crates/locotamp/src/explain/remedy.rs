//! The least change of one number that makes a sequence feasible, found and confirmed by solving.

use super::candidates::mirrored;
use super::knob::Knob;
use super::trial::{Effort, Success, Trials};
use ocp::Motion;
use scene::Scene;

/// Sizes of the changes by which a value goes further when the full problem refuses it.
const FURTHER: [f64; 4] = [0.0, 0.05, 0.15, 0.5];
/// Values between a refused and an accepted one that are tried where trials are few.
const MOST_HALVINGS: usize = 3;
/// Overloaded joints that are tried alone.
const MOST_JOINTS: usize = 3;

/// A number with a value that will do.
#[derive(Debug, Clone)]
pub(super) struct Found {
    pub knob: Knob,
    pub from: f64,
    pub to: f64,
}

impl Found {
    /// Size of the change, comparable between numbers.
    pub fn size(&self, scene: &Scene) -> f64 {
        self.knob.size(scene, self.to)
    }

    /// Is a number the same one on more surfaces or joints.
    pub fn includes(&self, other: &Knob) -> bool {
        let all = |of: &[usize], more: &[usize]| of.iter().all(|i| more.contains(i));
        match (&self.knob, other) {
            (Knob::Friction(of), Knob::Friction(more)) => all(of, more),
            _ => false,
        }
    }
}

/// Looks for a value of one number. Where `guide` is keyframes, these come first, then a coarse motion from the value that
/// they allow; the full problem confirms the result.
pub(super) fn find(
    trials: &mut Trials,
    scene: &Scene,
    knob: &Knob,
    guide: Effort,
) -> Option<Found> {
    let from = knob.value(scene);
    for &direction in knob.directions() {
        let ladder = knob.ladder(scene, direction);
        let mut ladder: Vec<f64> = ladder.iter().map(|s| knob.rounded(*s, direction)).collect();
        if trials.are_few() && ladder.len() > 1 {
            ladder = ladder.into_iter().skip(1).step_by(2).collect();
        }
        let mut refused = from;
        if guide == Effort::Keyframes {
            let Some(ends) = climb(trials, scene, knob, guide, (from, &ladder)) else {
                continue;
            };
            refused = ends[0];
            ladder.retain(|step| (step - ends[1]) * direction > 0.0);
            ladder.insert(0, ends[1]);
        }
        let coarse = Effort::Coarse;
        let mut found = climb(trials, scene, knob, coarse, (refused, &ladder));
        if found.is_none() && guide == Effort::Keyframes {
            // A motion that is not found need not be impossible: values between those that were tried.
            let middle = |pair: &[f64]| knob.rounded(0.5 * (pair[0] + pair[1]), direction);
            let between: Vec<f64> = ladder.windows(2).map(middle).collect();
            found = climb(trials, scene, knob, coarse, (refused, &between));
        }
        let Some([_, to]) = found else {
            continue;
        };
        if let Some(to) = confirm(trials, scene, knob, to, (&ladder, direction)) {
            let knob = knob.clone();
            return Some(Found { knob, from, to });
        }
    }
    None
}

/// The least value that succeeds, after a refused one: the first step of a ladder that does, then bisection between it and the
/// one before.
fn climb(
    trials: &mut Trials,
    scene: &Scene,
    knob: &Knob,
    effort: Effort,
    (from, ladder): (f64, &[f64]),
) -> Option<[f64; 2]> {
    let mut refused = from;
    for &step in ladder {
        if let Some(known) = trials.solve(&knob.with(scene, step), effort, None) {
            return Some(narrow(trials, scene, knob, effort, (refused, step), known).0);
        }
        refused = step;
    }
    None
}

/// Bisects between a refused and an accepted value, from the motion of the accepted one on, and from keyframes where that leads
/// nowhere; both ends.
fn narrow(
    trials: &mut Trials,
    scene: &Scene,
    knob: &Knob,
    guide: Effort,
    (mut refused, mut accepted): (f64, f64),
    mut known: Success,
) -> ([f64; 2], Success) {
    let most = if trials.are_few() {
        MOST_HALVINGS
    } else {
        usize::MAX
    };
    for _ in 0..most {
        let Some(middle) = knob.between(refused, accepted) else {
            break;
        };
        if trials.stopped {
            break;
        }
        let changed = knob.with(scene, middle);
        let near = known.0.as_deref();
        let better = trials.solve(&changed, guide, near);
        // A motion far from what is wanted is a bad start.
        let anew = |trials: &mut Trials<'_>| trials.solve(&changed, guide, None);
        let better = better.or_else(|| near.and_then(|_| anew(trials)));
        if let Some(better) = better {
            (accepted, known) = (middle, better);
        } else {
            refused = middle;
        }
    }
    ([refused, accepted], known)
}

/// The first value with which the full problem succeeds: from `to` on in small steps, then those of the ladder.
fn confirm(
    trials: &mut Trials,
    scene: &Scene,
    knob: &Knob,
    to: f64,
    (ladder, direction): (&[f64], f64),
) -> Option<f64> {
    let limit = ladder.last().copied().unwrap_or(to);
    let further = |size: f64| {
        let value = if knob.is_ratio() {
            to * (direction * size).exp()
        } else {
            to + direction * 0.3 * size
        };
        if size == 0.0 {
            to
        } else {
            knob.rounded(value, direction)
        }
    };
    let inside = |value: &f64| (limit - value) * direction >= 0.0;
    let mut last = None;
    let steps = FURTHER.map(further).into_iter().filter(inside);
    for value in steps.chain(ladder.iter().copied()) {
        if last.is_some_and(|last| (value - last) * direction <= 0.0) {
            continue;
        }
        last = Some(value);
        if trials.succeeds(&knob.with(scene, value), Effort::Full) {
            return Some(value);
        }
    }
    None
}

/// If higher torque limits help: the limit of one joint (of two, if its counterpart is overloaded too) that alone is enough,
/// else the factor on all.
pub(super) fn find_torque(trials: &mut Trials, scene: &Scene) -> Option<Found> {
    let all = Knob::AllTorques;
    let limit = *all.ladder(scene, 1.0).last()?;
    let known = trials.solve(&all.with(scene, limit), Effort::Coarse, None)?;
    let ([_, factor], known) = narrow(trials, scene, &all, Effort::Coarse, (1.0, limit), known);
    let overloaded = overloaded(scene, &mut *known.0?);
    let mut tried: Vec<Vec<usize>> = Vec::new();
    for &joint in overloaded.iter().take(MOST_JOINTS) {
        let mut pair = mirrored(scene, joint);
        pair.retain(|j| overloaded.contains(j));
        pair.sort_unstable();
        if tried.contains(&pair) {
            continue;
        }
        tried.push(pair.clone());
        if let Some(found) = find(trials, scene, &Knob::Torque(pair), Effort::Coarse) {
            return Some(found);
        }
    }
    let to = confirm(trials, scene, &all, factor, (&[limit], 1.0))?;
    let (knob, from) = (all, 1.0);
    Some(Found { knob, from, to })
}

/// Joints that use more in a motion than they may in the scene, the most overloaded first.
fn overloaded(scene: &Scene, motion: &mut Motion) -> Vec<usize> {
    let point = motion.point.clone();
    let joints = &scene.robot.model.joints;
    let share = motion.trajectory.program.settings.margins.torque;
    let at_speed = motion.trajectory.program.settings.torque_speed();
    let mut load = vec![0.0_f64; joints.len()];
    for t in 0..motion.trajectory.program.n_intervals() {
        let used = motion.trajectory.torque_shares(&point, t, at_speed);
        let actuated = motion.trajectory.program.system.actuated();
        let single = (0..joints.len()).filter(|&j| joints[j].kind.nv() == 1);
        for ((j, used), enforced) in single.zip(used).zip(actuated) {
            let used = used * enforced.torque_limit / joints[j].torque_limit;
            load[j] = load[j].max(used / share);
        }
    }
    let mut over: Vec<usize> = (0..joints.len()).filter(|&j| load[j] > 1.0).collect();
    over.sort_by(|&i, &j| load[j].total_cmp(&load[i]));
    over
}
