//! Which sequence is optimised next: drawn from the policy, filtered by keyframes, the most promising of those that wait.

use std::sync::Arc;
use std::time::Instant;

use super::candidate::{Candidate, Work};
use super::more_steps::Promise;
use super::order::{self, May, Waiting};
use super::results::name;
use super::workers::{Evaluated, Job, Start, with_steps};
use super::{Run, reward};
use crate::api::{Attempt, Event, Reached};
use crate::journal::Tried;
use crate::summary;
use multibody::Kinematics;
use ocp::{Keyframes, Phase, Relative};
use scene::{Objective, Owner, Role};
use symbolic::search::Rejected;
use symbolic::{Contact, ContactState, Oracle, Sequence};

/// Phases at the end in which a sequence may differ from another whose motion it starts from.
const DIFFERENT_AT_END: usize = 2;
/// Sequences drawn for each that is optimised.
const DRAWS: usize = 4;
/// The same once there is a plan and the best of many is sought.
const DRAWS_TO_CHOOSE: usize = 1;
/// Iterations after which a sequence is given up once there is a plan and the best of many is sought: motions that take more cost
/// nearly twice as much as others where they are found at all (benches/runs/2026-11-26-best-of-many.md).
const PATIENCE: usize = 100;
/// Work of checks ([`super::turns`]) after which drawing pauses: results must not wait where many beginnings are refused.
const DRAWING: u64 = 1000;
/// Advance of the clock after which a motion is begun whatever there is to choose from.
const MOST_DRAWING: u64 = 12_000;
/// What keyframes of a sequence count as, and what a round of more steps adds that was found for it, over the square of its phases:
/// about the work that is done in the same time on one motion.
const KEYFRAMES: u64 = 2;
const MORE_STEPS: u64 = 6;
/// The same for the path between keyframes, from which a motion on the coarse grid begins.
const PATH: u64 = 9;
/// What a phase adds to the cost that keyframes promise: its time, at about half a second.
const PHASE: f64 = 0.5;
/// What the cost of keyframes counts for: a phase costs as much as sixteen of its nodes.
const STRAIN: f64 = 16.0;
/// Lean at phase boundaries up to which a stride can be done slowly ([`ocp::Planner::leans`]), and beyond which it is as good as
/// infinite; what lean between these adds: the stride past a stone or stair as much as the step onto it.
const EASY_LEAN: f64 = 0.28;
const MOST_LEAN: f64 = 4.0;
const LEAN: f64 = 30.0;
/// What a phase in flight adds where torques are limited: as much as six foot swings, like [`symbolic::Costs`]. Keyframes see none of
/// what a jump takes.
const FLIGHT: f64 = 18.0;
/// Height by which a motion may end above its keyframes or above the posture of the start [m]: motions stretch.
const HEIGHT_ROOM: f64 = 0.12;

/// What the work of keyframes grows with.
fn squared_phases(sequence: &Sequence) -> u64 {
    sequence.states.len().pow(2) as u64
}

impl Run<'_> {
    /// Has the next thing done, if there is one, for the most promising of the sequences that wait ([`Run::next`]).
    pub fn submit(&mut self, has_choice: bool) -> bool {
        let Some(next) = self.next(has_choice) else {
            return false;
        };
        let (candidate, work) = self.waiting.remove(next);
        if candidate.coarse.is_none() {
            self.submitted += 1;
            self.drawn_before = self.drawn;
            self.begun_at = self.clock;
        }
        self.begin(candidate, work);
        true
    }

    /// Which of the sequences that wait has its turn. While the best of many is sought, one plan is enough.
    fn next(&self, has_choice: bool) -> Option<usize> {
        let waits = |(candidate, _): &(Candidate, Work)| {
            let states = &candidate.sequence.states;
            match &candidate.coarse {
                Some(coarse) => Waiting {
                    has_motion: true,
                    cost: self.growth.expected_to_hold(states, &coarse.costs),
                    is_strained: self.growth.is_strained(&coarse.costs),
                    is_likely: coarse.is_likely,
                },
                None => Waiting {
                    has_motion: false,
                    cost: self.growth.expected(states, candidate.promise),
                    is_strained: false,
                    is_likely: false,
                },
            }
        };
        let waiting: Vec<_> = self.waiting.iter().map(waits).collect();
        let may = May {
            move_one: !self.is_full(),
            hold_one: !self.chooses(),
            choose: has_choice,
            moved: self.moved,
        };
        order::next(&waiting, may)
    }

    /// True if as many motions have been begun as the search may optimise.
    pub fn is_full(&self) -> bool {
        self.submitted >= self.request.max_optimised
    }

    /// True if a sequence waits that may still get its motion on the coarse grid.
    pub fn has_unmoved(&self) -> bool {
        let unmoved = |(candidate, _): &(Candidate, Work)| candidate.coarse.is_none();
        !self.is_full() && self.waiting.iter().any(unmoved)
    }

    /// Has the next thing done for a sequence.
    fn begin(&mut self, candidate: Candidate, work: Work) {
        let phases = self.phases(&candidate.sequence);
        let (number, labels) = (candidate.number, candidate.sequence.labels.clone());
        let cost = candidate.coarse.as_ref().map(|coarse| coarse.costs.cost);
        let (pace, is_likely) = (candidate.pace(), candidate.is_likely());
        let path = match candidate.coarse {
            None => PATH * squared_phases(&candidate.sequence),
            Some(_) => 0,
        };
        let clock = self.clock + path;
        self.under_way.begin(candidate, clock, work.spent());
        let (phases, start) = match work {
            Work::Remembered(done) => {
                self.under_way.done(number, *done);
                return;
            }
            Work::Move(nodes) => {
                let phases = self.shop.planner.paced(&phases, self.shop.settings, &nodes);
                let relative = nearest(&self.relatives, &phases);
                let most = if self.chooses() { PATIENCE } else { usize::MAX };
                (phases, Start::Keyframes(nodes, relative, most))
            }
            Work::Hold(point, steps) => {
                let start = Start::Coarse(point, cost.unwrap_or(f64::INFINITY));
                (with_steps(&phases, &steps), start)
            }
            Work::Restore {
                point, feasible, ..
            } => {
                let phases = with_steps(&phases, &point.steps);
                (phases, Start::Known(point, feasible))
            }
        };
        self.workers.submit(Job {
            number,
            clock,
            pace,
            is_likely,
            labels,
            phases,
            start,
        });
    }

    /// True if so many sequences have been drawn since the last submission as are wanted for the next, or drawing takes long. The first
    /// is begun at once, unless the scene rewards something: then some reach far less than others.
    pub fn has_choice(&self) -> bool {
        let draws = match self.submitted {
            0 if self.shop.planner.scene.objective == Objective::Time => 1,
            _ if self.chooses() => DRAWS_TO_CHOOSE,
            _ => DRAWS,
        };
        let is_late = self.clock >= self.begun_at + MOST_DRAWING;
        is_late || self.drawn >= self.drawn_before + draws
    }

    /// Draws the next sequence and checks it by keyframes, to wait for its turn if it passes, unless that takes so long that what else
    /// there is to do comes first; false if there is none.
    pub fn draw(&mut self) -> bool {
        let turns = self.workers.turns.clone();
        let _turn = turns.enter(0, self.clock);
        let before = self.checks.work;
        self.checks.pause_at = before + DRAWING;
        let next = self.policy.next(&mut self.checks);
        self.spend(self.checks.work - before);
        let Some(sequence) = next else {
            return self.checks.pause() && !self.checks.stop();
        };
        self.drawn += 1;
        let number = self.drawn;
        let clock = Instant::now();
        self.tell(&Event::Sequence {
            number,
            labels: sequence.labels.clone(),
        });
        let returned = sequence;
        let drawn = self.without_idle_end(&returned);
        if let Some(other) = self.longer.number_of(&drawn) {
            self.leave_out_same(number, returned, other);
            return true;
        }
        self.longer.note(number, &returned, &drawn);
        self.spend(KEYFRAMES * squared_phases(&drawn));
        let sequence = self.with_remembered_steps(&drawn);
        let states = self.names(&sequence);
        let journal = &mut self.checks.journal;
        let known = journal.take_sequence(&states);
        let (sequence, promise, work) = if let Some(coarse) = journal.coarse(&states) {
            let work = Work::Remembered(Box::new(Evaluated::coarse(coarse)));
            (sequence, coarse.promise, work)
        } else if let Some(tried) = &known {
            let Some(promise) = tried.promise else {
                self.leave_out_again(number, &sequence, tried);
                return true;
            };
            (sequence, promise, Work::known(tried, 0))
        } else {
            let Some((cost, nodes)) = self.keyframes(number, &drawn, clock) else {
                return true;
            };
            let sequence = drawn.clone();
            let longer = self.with_more_steps(Promise {
                sequence,
                cost,
                nodes,
            });
            (longer.sequence, longer.cost, Work::Move(longer.nodes))
        };
        if sequence.states.len() > drawn.states.len() {
            self.spend(MORE_STEPS * squared_phases(&sequence));
        }
        self.longer.note(number, &returned, &sequence);
        let candidate = Candidate {
            number,
            sequence,
            promise,
            coarse: None,
            known,
        };
        self.waiting.push((candidate, work));
        true
    }

    /// Counts work of drawing; less, while all that is under way advances faster but leaves a thread.
    fn spend(&mut self, work: u64) {
        self.clock += work / self.under_way.pace_of_drawing();
    }

    /// The cost that keyframes promise, and these; `None` if the sequence is not worth an optimisation.
    fn keyframes(
        &mut self,
        number: usize,
        sequence: &Sequence,
        clock: Instant,
    ) -> Option<(f64, Vec<Vec<f64>>)> {
        if let Some(reason) = self.alike(sequence) {
            self.leave_out(number, sequence, Reached::Alike, Some(reason), clock);
            return None;
        }
        let phases = self.phases(sequence);
        let keyframes = self.checks.keyframes(&phases);
        let possible = keyframes.possible;
        let worst = keyframes.worst.as_ref().filter(|_| !possible);
        let reason = worst.map(|w| summary::words(self.shop.planner.scene, w));
        self.tell(&Event::Keyframes {
            number,
            possible,
            reason: reason.clone(),
        });
        if !possible {
            self.reject_prefix(sequence, &phases);
            self.leave_out(number, sequence, Reached::Keyframes, reason, clock);
            return None;
        }
        let promise = self.promise(&phases, &keyframes);
        let balanced = self.promise_from_balanced(&phases);
        let less = balanced.filter(|(other, _)| *other < promise);
        let (promise, nodes) = less.unwrap_or((promise, keyframes.nodes));
        if let Some(reason) = self.too_low(sequence, &nodes) {
            self.leave_out(number, sequence, Reached::Keyframes, Some(reason), clock);
            return None;
        }
        Some((promise, nodes))
    }

    /// What keyframes promise that begin from others in which the centre of mass is drawn over the feet more, found from the sequence
    /// alone, and these; `None` if there are none. Those that grew with the sequence often end in worse local minima
    /// (benches/runs/2026-11-30-two-beginnings.md).
    fn promise_from_balanced(&self, phases: &[Phase]) -> Option<(f64, Vec<Vec<f64>>)> {
        let (planner, settings) = (self.shop.planner, self.shop.settings);
        if settings.weights.balance <= 0.0 {
            return None;
        }
        let mut balanced = settings.clone();
        balanced.weights.balance = super::BALANCED;
        let found = planner.keyframes_at_once(phases, &balanced);
        let near = found
            .possible
            .then(|| planner.keyframes_at(&found.nodes, phases, settings))??;
        near.possible
            .then(|| (self.promise(phases, &near), near.nodes))
    }

    /// The cost that keyframes promise.
    pub fn promise(&self, phases: &[Phase], keyframes: &Keyframes) -> f64 {
        let promise = STRAIN * keyframes.report.objective + PHASE * phases.len() as f64;
        promise + self.strides(phases, &keyframes.nodes)
    }

    /// What long strides and flights add to that.
    fn strides(&self, phases: &[Phase], nodes: &[Vec<f64>]) -> f64 {
        let flights = phases.iter().filter(|p| self.flies(&p.state)).count();
        let leans = self.shop.planner.leans(phases, nodes);
        let far = |lean: &f64| lean.clamp(EASY_LEAN, MOST_LEAN) - EASY_LEAN;
        let flight = if self.shop.settings.torque_limits {
            FLIGHT
        } else {
            0.0
        };
        LEAN * leans.iter().map(far).sum::<f64>() + flight * flights as f64
    }

    /// True if no foot has contact, and no hand with what is fixed.
    fn flies(&self, state: &ContactState) -> bool {
        let carries = |c: Contact| {
            let [a, b] = [c.a, c.b].map(|i| &self.shop.planner.scene.interfaces[i.0]);
            let robot = matches!(a.owner, Owner::Robot { .. });
            robot && (a.role == Role::Foot || matches!(b.owner, Owner::Static(_)))
        };
        !state.iter().any(carries)
    }

    /// Why the sequence is not worth a try: others failed at the same contacts.
    fn alike(&self, sequence: &Sequence) -> Option<String> {
        let (phase, numbers) = self.failures.known(&sequence.states)?;
        let numbers: Vec<String> = numbers.iter().map(ToString::to_string).collect();
        Some(format!(
            "sequences {} have no motion at the contacts of phase {} ({})",
            numbers.join(", "),
            phase + 1,
            sequence.labels[phase]
        ))
    }

    /// Where the base is to get high: why a sequence cannot lead higher than the best plan.
    fn too_low(&self, sequence: &Sequence, nodes: &[Vec<f64>]) -> Option<String> {
        if self.shop.planner.scene.objective != Objective::BaseHeight {
            return None;
        }
        let best = self.diverse.best()?.motion.point.nodes.last()?[2];
        let now = self.highest_end(sequence.states.last()?, nodes.last()?);
        let low = now < best - HEIGHT_ROOM;
        low.then(|| format!("the base ends at {now:.2} m at most, a plan is at {best:.2} m"))
    }

    /// Height at which the base ends in a configuration, or standing upright on the lower one of its feet [m].
    fn highest_end(&self, state: &ContactState, q: &[f64]) -> f64 {
        let planner = &self.shop.planner;
        let mut kinematics = Kinematics::new(&planner.system.model);
        kinematics.update(&planner.system.model, q);
        let interfaces = state.iter().map(|c| &planner.scene.interfaces[c.a.0]);
        let feet = interfaces.filter(|a| a.role == Role::Foot);
        let height = |foot| {
            planner
                .system
                .world_from_interface(foot, &kinematics)
                .origin()
                .z
        };
        let ground = feet.map(height).reduce(f64::min);
        let upright = ground.map(|ground| ground + ocp::base_height(planner.scene));
        upright.unwrap_or(q[2]).max(q[2])
    }

    /// Takes note of a sequence that is not optimised.
    fn leave_out(
        &mut self,
        number: usize,
        sequence: &Sequence,
        reached: Reached,
        reason: Option<String>,
        clock: Instant,
    ) {
        let attempt = Attempt {
            number,
            labels: sequence.labels.clone(),
            reached,
            reason,
            cost: None,
            iterations: 0,
            seconds: clock.elapsed().as_secs_f64(),
        };
        self.conclude(sequence, attempt, reward::LEFT_OUT, None);
    }

    /// The same for one that another has become by more steps, or fewer at the end: it is tried already.
    fn leave_out_same(&mut self, number: usize, sequence: Sequence, other: usize) {
        self.policy.learn(&sequence.states, reward::LEFT_OUT);
        self.count(Attempt {
            number,
            labels: sequence.labels,
            reached: Reached::Alike,
            reason: Some(format!(
                "sequence {other} is the same, with other steps than one of them was drawn with"
            )),
            cost: None,
            iterations: 0,
            seconds: 0.0,
        });
    }

    /// The same for one that the run that is continued left out.
    fn leave_out_again(&mut self, number: usize, sequence: &Sequence, known: &Tried) {
        let alike = known.reached == name(Reached::Alike);
        if !alike {
            let phases = self.phases(sequence);
            self.reject_prefix(sequence, &phases);
        }
        self.learn(&sequence.states, known.reward);
        self.count(Attempt {
            number,
            labels: sequence.labels.clone(),
            reached: if alike {
                Reached::Alike
            } else {
                Reached::Keyframes
            },
            reason: known.reason.clone(),
            cost: None,
            iterations: 0,
            seconds: known.seconds,
        });
    }

    /// Finds the shortest impossible beginning, so that nothing that starts with it is tried again. If the contacts
    /// alone are possible, only the goal is out of reach, and longer sequences may still get there.
    fn reject_prefix(&mut self, sequence: &Sequence, phases: &[Phase]) {
        let whole = self.checks.beginning(phases);
        if whole.possible {
            return;
        }
        let (mut possible, mut impossible) = (0, phases.len());
        let mut reason = whole.reason;
        while impossible - possible > 1 {
            let middle = usize::midpoint(possible, impossible);
            let answer = self.checks.beginning(&phases[..middle]);
            if answer.possible {
                possible = middle;
            } else {
                (impossible, reason) = (middle, answer.reason);
            }
        }
        let prefix = sequence.states[..impossible].to_vec();
        self.policy
            .reject(Rejected::Prefix(prefix), reason.unwrap_or_default());
    }
}

/// The relative that shares most phases, the first of these, if it differs in the last few only: a start that shares less
/// saved nothing (benches/runs/2026-11-21-keyframes.md).
fn nearest(relatives: &[Arc<Relative>], phases: &[Phase]) -> Option<Arc<Relative>> {
    let shared = |r: &Arc<Relative>| r.shared_phases(phases);
    let most = relatives.iter().map(shared).max()?;
    let near = relatives.iter().find(|r| shared(r) == most);
    near.filter(|_| most + DIFFERENT_AT_END >= phases.len())
        .cloned()
}
