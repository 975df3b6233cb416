//! What becomes of optimised motions: taken in the order of the work done on them, told to policy and journal, kept if good.

use std::mem;
use std::sync::atomic::Ordering;

use super::candidate::{Candidate, Coarse, Work};
use super::diverse::{Kept, Stored, loaded};
use super::reward::{Rewards, Worth};
use super::workers::{Evaluated, Message, Shop, with_steps};
use super::{Nearest, Run, reward};
use crate::api::{Alternative, Attempt, Event, Found, Outcome, Reached, Request};
use crate::journal::{self, PointEntry, Tried};
use crate::refine::{self, Refined};
use ocp::{Motion, Settings};
use symbolic::Sequence;

/// Motions that others may start from.
const MOST_RELATIVES: usize = 16;

impl Run<'_> {
    /// Takes the next result when it is sure which one that is, if it comes before this clock; true if there was one, or the search is
    /// over: what that cuts off says nothing.
    pub fn take_next(&mut self, before: u64) -> bool {
        while self.under_way.comes_before(before) && self.is_over().is_none() {
            if let Some((clock, candidate, done)) = self.under_way.take_next() {
                self.clock = self.clock.max(clock);
                self.take(candidate, done);
                return true;
            }
            match self.workers.messages.recv() {
                Ok(message) => self.receive(message),
                Err(_) => self.lost = true,
            }
        }
        self.is_over().is_some()
    }

    /// Takes the plans that are there but for their turn, if the search was cut off.
    fn take_plans(&mut self) {
        if !self.is_after(self.deadline()) && !self.is_stopped() {
            return;
        }
        while let Ok(message) = self.workers.messages.try_recv() {
            self.receive(message);
        }
        for (candidate, done) in self.under_way.take_plans() {
            self.take(candidate, done);
        }
    }

    /// Takes note of news from a worker.
    pub fn receive(&mut self, message: Message) {
        match message {
            Message::Worked(number, work, event) => {
                self.under_way.worked(number, work);
                self.tell(&event);
            }
            Message::Done(number, result) => self.under_way.done(number, *result),
            Message::Lost => self.lost = true, // its panic comes up when the threads are joined
        }
    }

    /// Takes note of a motion on the coarse grid, which waits for its turn on a finer one.
    fn take_coarse(&mut self, mut candidate: Candidate, done: Evaluated) {
        let number = candidate.number;
        self.tell(&Event::Coarse {
            number,
            cost: done.cost,
        });
        let costs = done.costs(candidate.promise);
        self.growth.found(&candidate.sequence.states, &costs);
        if costs.lapse.is_serious() {
            let reward = Rewards::of_failure(costs.lapse.force);
            self.learn(&candidate.sequence.states, reward);
        } else if self.request.min_optimised > 0 {
            let reward = self.coarse_rewards.of_plan(costs.worth());
            self.learn(&candidate.sequence.states, reward);
        }
        let Some(point) = done.point else { return };
        if self.is_nearest(done.violation) {
            self.nearest = Some(Nearest {
                violation: done.violation,
                motion: Stored {
                    sequence: candidate.sequence.clone(),
                    steps: done.steps.clone(),
                    point: point.clone(),
                    iterations: done.iterations,
                    seconds: done.seconds,
                },
            });
        }
        self.checks.journal.note_coarse(journal::Coarse {
            number,
            at: self.shop.begin.elapsed().as_secs_f64(),
            states: self.names(&candidate.sequence),
            promise: candidate.promise,
            cost: done.cost,
            objective: done.objective,
            dearest_phase: done.dearest_phase,
            lapse: done.lapse,
            violation: done.violation,
            iterations: done.iterations,
            work: done.work,
            seconds: done.seconds,
            point: PointEntry::new(&done.steps, &point),
        });
        candidate.coarse = Some(Coarse {
            costs,
            iterations: done.iterations,
            work: done.work,
            seconds: done.seconds,
            relative: done.relative,
            is_likely: self.growth.is_likely(&costs),
        });
        let work = match &candidate.known {
            Some(tried) => Work::known(tried, done.work),
            None => Work::Hold(point, done.steps),
        };
        self.waiting.push((candidate, work));
    }

    /// Takes note of an optimised motion.
    pub fn take(&mut self, candidate: Candidate, mut done: Evaluated) {
        if candidate.coarse.is_none() {
            self.moved += 1;
        }
        if done.must_hold {
            self.take_coarse(candidate, done);
            return;
        }
        let Candidate {
            number,
            sequence,
            promise,
            coarse,
            known,
        } = candidate;
        if let Some(tried) = &known {
            (done.iterations, done.seconds) = (tried.iterations, tried.seconds);
            // A motion that is set up again has other clearances, and so other violations.
            done.worst_phase = tried.failed_phase;
            done.dearest_phase = tried.dearest_phase;
            done.violation = tried.violation.unwrap_or(done.violation);
            done.lapse = tried.lapse;
        } else if let Some(coarse) = &coarse {
            done.iterations += coarse.iterations;
            done.work += coarse.work;
            done.seconds += coarse.seconds;
            done.relative = done.relative.or(coarse.relative.clone());
        }
        self.tell(&Event::Optimised {
            number,
            feasible: done.feasible,
            cost: done.cost,
            reason: done.reason.clone(),
        });
        let reward = match (done.feasible, &known) {
            (true, _) => self.rewards.of_plan(done.costs(promise).worth()),
            (false, Some(known)) => known.reward,
            (false, None) => Rewards::of_failure(done.violation.max(done.lapse.force)),
        };
        if done.feasible {
            self.failures.succeeded(&sequence.states);
            self.growth.holds(&sequence.states);
        } else {
            let worst = done.failed_phase();
            if let Some(phase) = worst {
                self.failures.failed(number, &sequence.states, phase);
            }
            match (&coarse, worst) {
                (None, _) => {
                    let costs = done.costs(promise);
                    self.growth.failed(&sequence.states, &costs, worst);
                }
                (Some(coarse), Some(phase)) => {
                    let effort = coarse.costs.effort;
                    self.growth.did_not_hold(&sequence.states, effort, phase);
                }
                _ => {}
            }
        }
        let attempt = Attempt {
            number,
            labels: sequence.labels.clone(),
            reached: if done.feasible {
                Reached::Feasible
            } else {
                Reached::Optimised
            },
            reason: done.reason.clone(),
            cost: Some(done.cost),
            iterations: done.iterations,
            seconds: done.seconds,
        };
        if known.is_some() {
            self.learn(&sequence.states, reward);
            self.count(attempt);
        } else {
            self.conclude(&sequence, attempt, reward, Some((&done, promise)));
        }
        self.keep(number, sequence, done);
    }

    /// Keeps a plan, or the motion that comes nearest to one.
    fn keep(&mut self, number: usize, sequence: Sequence, done: Evaluated) {
        let Some(point) = done.point else { return };
        let motion = Stored {
            sequence,
            steps: done.steps,
            point,
            iterations: done.iterations,
            seconds: done.seconds,
        };
        let Some(plan) = done.plan else {
            if self.is_nearest(done.violation) {
                let violation = done.violation;
                self.nearest = Some(Nearest { violation, motion });
            }
            return;
        };
        let now = self.shop.begin.elapsed().as_secs_f64();
        self.first_after.get_or_insert(now);
        self.relatives.extend(done.relative);
        let many = self.relatives.len().saturating_sub(MOST_RELATIVES);
        self.relatives.drain(..many);
        let scene = self.shop.planner.scene;
        let weight = scene.robot.model.total_mass() * scene.gravity.norm();
        let worth = Worth::of(&plan, scene, self.shop.settings);
        let alternative = Alternative {
            number,
            cost: done.cost,
            duration: plan.time.last().copied().unwrap_or(0.0),
            loaded: loaded(&plan, weight),
            plan: plan.clone(),
        };
        self.diverse.offer(Kept {
            alternative,
            worth,
            motion,
        });
        let best = self.diverse.best();
        self.tell(&Event::Solution {
            number,
            best: best.is_some_and(|best| best.alternative.number == number),
            plan: Box::new(plan),
        });
    }

    /// True if there is neither a plan nor a motion that is less violated.
    fn is_nearest(&self, violation: f64) -> bool {
        let less = |nearest: &Nearest| violation < nearest.violation;
        self.diverse.best().is_none() && self.nearest.as_ref().is_none_or(less)
    }

    /// Tells the policy and the journal what became of a sequence; `done` with what keyframes promised.
    pub fn conclude(
        &mut self,
        sequence: &Sequence,
        attempt: Attempt,
        reward: f64,
        done: Option<(&Evaluated, f64)>,
    ) {
        self.learn(&sequence.states, reward);
        let statistics = self.policy.statistics(&sequence.states);
        let motion = done.map(|(motion, _)| motion);
        let kept = motion.filter(|m| m.feasible || self.is_nearest(m.violation));
        let tried = Tried {
            number: attempt.number,
            at: self.shop.begin.elapsed().as_secs_f64(),
            labels: attempt.labels.clone(),
            states: self.names(sequence),
            reached: name(attempt.reached).into(),
            reason: attempt.reason.clone(),
            promise: done.map(|(_, promise)| promise),
            cost: attempt.cost,
            failed_phase: motion.and_then(|m| m.worst_phase),
            dearest_phase: motion.and_then(|m| m.dearest_phase),
            lapse: motion.map(|m| m.lapse).unwrap_or_default(),
            violation: motion.map(|m| m.violation),
            iterations: attempt.iterations,
            work: motion.map_or(0, |m| m.work),
            seconds: attempt.seconds,
            reward,
            visits: statistics.iter().map(|x| x.visits).collect(),
            values: statistics.iter().map(|x| rounded(x.value)).collect(),
            point: kept.and_then(|m| Some(PointEntry::new(&m.steps, m.point.as_ref()?))),
        };
        self.checks.journal.note_sequence(tried);
        self.count(attempt);
    }

    /// Adds a sequence to those that were tried.
    pub fn count(&mut self, attempt: Attempt) {
        let Attempt {
            number, reached, ..
        } = attempt;
        self.attempts.push(attempt);
        self.tell(&Event::Tried { number, reached });
    }

    /// Stops what is under way, refines the best plan that can be refined and puts everything together.
    pub fn finish(mut self, ended: String) -> Outcome {
        let wanted = !self.is_stopped();
        self.take_plans();
        self.shop.stop.store(true, Ordering::SeqCst);
        self.count_coarse();
        let mut refined = self.refined.take();
        if refined.is_none() {
            let latest = self.refine_best(wanted);
            let before = self.coarse.take();
            refined = match latest {
                Some(found) if found.is_refined() => Some(found),
                latest => self.best_of(before.into_iter().chain(latest)),
            };
        }
        let feasible = refined.is_some();
        let best = if feasible {
            refined
        } else {
            self.nearest.take().map(|nearest| {
                let mut motion = self.set_up_again(&nearest.motion, false);
                let labels = &nearest.motion.sequence.labels;
                Found::of(self.shop.planner.scene, labels, &mut motion, Refined::No)
            })
        };
        let (possible, explained) = self.why(feasible || !wanted, best.is_some());
        let mut plans: Vec<Kept> = self.diverse.plans().chain(self.aside).collect();
        reward::sort(&mut plans, self.least_gain, |kept| kept.worth);
        let alternatives = plans.into_iter().map(|kept| kept.alternative).collect();
        Outcome {
            feasible,
            best,
            alternatives,
            first_after: self.first_after,
            attempts: self.attempts,
            impossible: self.checks.impossible(),
            possible,
            explained,
            ended,
            seconds: self.shop.begin.elapsed().as_secs_f64(),
        }
    }

    /// The best one of those that the checker accepts, of all if there is none.
    pub fn best_of(&self, plans: impl IntoIterator<Item = Found>) -> Option<Found> {
        let mut plans: Vec<Found> = plans.into_iter().collect();
        let Shop {
            planner, settings, ..
        } = self.shop;
        let worth = |found: &Found| Worth::of(&found.plan, planner.scene, settings);
        reward::sort(&mut plans, self.least_gain, worth);
        let accepted = |found: &Found| refine::refusal(&found.plan, settings).is_none();
        first_accepted(plans, accepted)
    }

    /// Counts the sequences whose motions on the coarse grid had no turn on the finer one, or whose turn had no end.
    fn count_coarse(&mut self) {
        let waiting = mem::take(&mut self.waiting).into_iter();
        let under_way = mem::take(&mut self.under_way).candidates();
        for candidate in waiting.map(|(candidate, _)| candidate).chain(under_way) {
            let Some(coarse) = candidate.coarse else {
                continue;
            };
            self.count(Attempt {
                number: candidate.number,
                labels: candidate.sequence.labels,
                reached: Reached::Coarse,
                reason: None,
                cost: Some(coarse.costs.cost),
                iterations: coarse.iterations,
                seconds: coarse.seconds,
            });
        }
    }

    /// The best plan whose motion can be refined to one that the checker accepts; if none can, or it is not `wanted`, the best as it is,
    /// of those that the checker accepts so if there are any.
    pub fn refine_best(&mut self, wanted: bool) -> Option<Found> {
        let planner = self.shop.planner;
        let turns = self.workers.turns.clone();
        let _all = turns.all();
        let settings = &Settings {
            threads: self.request.thread_count(),
            ..self.shop.settings.clone()
        };
        let mut as_they_are: Vec<Found> = vec![];
        let request = Request {
            refinement: self.request.refinement.filter(|_| wanted),
            ..self.request.clone()
        };
        for n in 0..self.diverse.len() {
            let kept = &self.diverse[n].motion;
            let phases = with_steps(&self.phases(&kept.sequence), &kept.steps);
            let labels = kept.sequence.labels.clone();
            let mut motion = self.shop.restore_to_refine(&phases, kept.point.clone());
            motion.feasible = true;
            let limits = (&request, self.shop.begin);
            let mut observe = |event: &Event| {
                let goes_on = (self.observe)(event);
                self.shop.stop.fetch_or(!goes_on, Ordering::SeqCst);
                goes_on
            };
            let (mut motion, refined) =
                refine::refine(planner, &phases, settings, motion, limits, &mut observe);
            let again = || self.set_up_again(kept, true);
            let refined = if matches!(refined, Refined::Done { .. }) {
                let found = Found::of(planner.scene, &labels, &mut motion, refined);
                let Some(reason) = refine::refusal(&found.plan, settings) else {
                    return Some(found);
                };
                motion = again();
                Refined::Failed(reason)
            } else {
                if motion.trajectory.program.steps == kept.steps {
                    motion = again();
                }
                refined
            };
            let failed = matches!(refined, Refined::Failed(_));
            as_they_are.push(Found::of(planner.scene, &labels, &mut motion, refined));
            if !failed || self.is_late() || self.is_stopped() {
                break;
            }
        }
        // Those that had no turn.
        let accepted = |found: &Found| refine::refusal(&found.plan, settings).is_none();
        let without = || match request.refines() {
            None => Refined::No,
            Some(_) if self.is_stopped() => Refined::Failed("stopped by the caller".into()),
            Some(_) => Refined::Failed(format!("time limit of {} s", request.time_limit)),
        };
        for n in as_they_are.len()..self.diverse.len() {
            if !wanted || as_they_are.iter().any(accepted) {
                break;
            }
            let kept = &self.diverse[n].motion;
            let mut motion = self.set_up_again(kept, true);
            let labels = &kept.sequence.labels;
            as_they_are.push(Found::of(planner.scene, labels, &mut motion, without()));
        }
        self.best_of(as_they_are)
    }

    /// A motion as it was found.
    fn set_up_again(&self, stored: &Stored, feasible: bool) -> Motion {
        let phases = with_steps(&self.phases(&stored.sequence), &stored.steps);
        let mut motion = self.shop.restore(&phases, stored.point.clone());
        motion.feasible = feasible;
        (motion.iterations, motion.seconds) = (stored.iterations, stored.seconds);
        motion
    }
}

/// The first one that is accepted, else the first one; nobody is asked about a single one.
fn first_accepted<T>(mut plans: Vec<T>, accepted: impl FnMut(&T) -> bool) -> Option<T> {
    let chosen = match plans.len() {
        0 => return None,
        1 => 0,
        _ => plans.iter().position(accepted).unwrap_or(0),
    };
    Some(plans.swap_remove(chosen))
}

/// A mean reward as it is written, in millionths.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

/// The name in files.
pub(super) fn name(reached: Reached) -> &'static str {
    match reached {
        Reached::Keyframes => "keyframes",
        Reached::Alike => "alike",
        Reached::Coarse => "coarse",
        Reached::Optimised => "optimised",
        Reached::Feasible => "feasible",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_plans_that_cannot_be_refined_one_that_is_accepted_comes_first() {
        let accepted = |plan: &i32| *plan > 2;
        assert_eq!(first_accepted(vec![1, 2, 4, 3], accepted), Some(4));
        assert_eq!(first_accepted(vec![1, 2], accepted), Some(1));
        assert_eq!(first_accepted(vec![1], |_| panic!("one alone")), Some(1));
        assert_eq!(first_accepted(vec![], accepted), None);
    }
}
