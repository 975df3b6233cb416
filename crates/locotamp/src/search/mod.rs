//! The plan search: a policy proposes contact sequences, states, transitions and keyframes filter them, the trajectory
//! optimiser judges, and the policy learns what they were worth.
//!
//! Up to [`IN_FLIGHT`] sequences are optimised at once by as many threads as there are. Their results are taken in the order
//! in which they were proposed, so that the run is the same however many threads there are and however long they take.

mod diverse;
mod failures;
mod reward;
mod workers;

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Instant;

use crate::api::{Alternative, Attempt, Error, Event, Found, Outcome, Reached, Request, Search};
use crate::checks::Checks;
use crate::journal::{Header, Journal, Tried};
use crate::{domain, refine, summary};
use diverse::{Diverse, loaded};
use failures::Failures;
use ocp::{Integrator, Phase, Planner, Point, Preset, Relative, Settings};
use reward::Rewards;
use scene::{Objective, Scene};
use symbolic::search::Rejected;
use symbolic::{BestFirst, Policy, Rollouts, SearchLimits, Sequence, SkeletonGraph, TreeSearch};
use workers::{Evaluated, From, Job, Message, Shop, Workers};

/// Overlap of bodies at the start that is tolerated [m]: less than the collision model's own accuracy.
const START_OVERLAP: f64 = 0.005;
/// Phases at the end in which a sequence may differ from another whose motion it starts from.
const DIFFERENT_AT_END: usize = 2;
/// Sequences that are under evaluation at once. Part of what decides which sequence comes next, hence no option.
const IN_FLIGHT: usize = 4;
/// Sequences drawn for each that is optimised.
const DRAWS: usize = 4;
/// What a phase adds to the cost that keyframes promise: its time, at about half a second.
const PHASE: f64 = 0.5;
/// What the cost of keyframes counts for: a phase costs as much as sixteen of its nodes.
const STRAIN: f64 = 16.0;
/// Height by which a motion may end above its keyframes [m]: those are near the home posture at the end, motions stretch.
const HEIGHT_ROOM: f64 = 0.12;
/// Motions that others may start from.
const MOST_RELATIVES: usize = 16;

/// Finds contacts and motion for a scene.
///
/// `observe` sees everything that happens and ends the search by returning false; the best so far is returned then.
///
/// # Errors
/// If the scene is no planning problem: start in collision, goal out of reach of every manipulation. If the journal is of
/// another problem.
pub fn plan(
    scene: &Scene,
    request: &Request,
    observe: &mut dyn FnMut(&Event) -> bool,
) -> Result<Outcome, Error> {
    let begin = Instant::now();
    let planner = Planner::new(scene)?;
    check_start(scene, &planner)?;
    let (graph, limits) = domain::graph(scene)?;
    let Some(skeleton) = graph.shortest_skeleton() else {
        let goal = goal_text(scene);
        return Err(Error::Unreachable(format!(
            "no sequence of grasp, lift, place and release leads to the goal {goal}; does a hand accept the object's \
             handle or two opposite patches, and the goal surface its bottom?"
        )));
    };
    let contacts = graph.domain().contacts().len();
    let policy = policy(scene, request, graph, &limits);
    let settings = settings(scene, request)?;
    let journal = match &request.journal {
        Some(path) => {
            let content = format!("{scene:?} {settings:?}");
            let name = request.search.name();
            let header = Header::new(
                &scene.name,
                name,
                request.seed,
                &content,
                policy.max_phases(),
            );
            Journal::open(path, request.resume, &header)?
        }
        None => Journal::default(),
    };
    let started = Event::Started {
        interfaces: scene.interfaces.len(),
        contacts,
        max_phases: policy.max_phases(),
        skeleton,
    };
    let stop = AtomicBool::new(!observe(&started));
    let shop = Shop {
        planner: &planner,
        settings: &settings,
        stop: &stop,
        begin,
        time_limit: request.time_limit,
    };
    let checks = Checks::new(
        (&planner, &settings, scene.search.steps),
        (begin, request.time_limit, request.stop.clone()),
        journal,
    );
    thread::scope(|scope| {
        let workers = Workers::start(scope, threads(request), shop);
        let mut run = Run {
            shop,
            request,
            policy,
            checks,
            workers,
            observe,
            drawn: 0,
            waiting: vec![],
            under_way: VecDeque::new(),
            results: BTreeMap::new(),
            rewards: Rewards::default(),
            failures: Failures::default(),
            attempts: vec![],
            best: None,
            diverse: Diverse::new(request.alternatives),
            first_after: None,
            relatives: vec![],
        };
        let ended = run.search();
        Ok(run.finish(ended))
    })
}

fn policy(
    scene: &Scene,
    request: &Request,
    graph: SkeletonGraph,
    limits: &SearchLimits,
) -> Box<dyn Policy> {
    let costs = domain::costs(scene);
    match request.search {
        Search::Tree => {
            let (extra, end) = domain::own_costs(scene);
            let tree = TreeSearch::new(graph, limits, costs, request.seed);
            Box::new(tree.with_own_costs(extra, end))
        }
        Search::BestFirst => Box::new(BestFirst::new(graph, limits, costs)),
        Search::Random => Box::new(Rollouts::new(graph, limits, costs, request.seed)),
    }
}

fn threads(request: &Request) -> usize {
    let processors = thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let wanted = if request.threads == 0 {
        processors
    } else {
        request.threads
    };
    wanted.min(IN_FLIGHT)
}

/// The problem's options for a request.
pub(crate) fn settings(scene: &Scene, request: &Request) -> Result<Settings, Error> {
    if request.preset == Preset::Paper && request.integrator != Integrator::Euler {
        return Err(Error::PaperIntegrator);
    }
    Ok(Settings {
        integrator: request.integrator,
        ..Settings::new(request.preset, &scene.optimiser)
    })
}

/// A sequence whose motion is being optimised.
struct UnderWay {
    number: usize,
    sequence: Sequence,
    promise: f64,
    /// What is known of it from the run that is continued.
    known: Option<Tried>,
}

/// A sequence whose keyframes exist.
struct Candidate {
    number: usize,
    sequence: Sequence,
    /// The cost to expect.
    promise: f64,
    /// `None` if it is known that there is no motion.
    from: Option<From>,
    known: Option<Tried>,
}

/// The best motion so far.
struct Best {
    feasible: bool,
    cost: f64,
    violation: f64,
    point: Point,
    sequence: Sequence,
}

struct Run<'a> {
    shop: Shop<'a>,
    request: &'a Request,
    policy: Box<dyn Policy>,
    checks: Checks<'a>,
    workers: Workers,
    observe: &'a mut dyn FnMut(&Event) -> bool,
    /// Number of sequences drawn from the policy.
    drawn: usize,
    /// Sequences that wait for their turn.
    waiting: Vec<Candidate>,
    under_way: VecDeque<UnderWay>,
    /// Results that came before their turn.
    results: BTreeMap<usize, Box<Evaluated>>,
    rewards: Rewards,
    failures: Failures,
    attempts: Vec<Attempt>,
    best: Option<Best>,
    diverse: Diverse,
    first_after: Option<f64>,
    /// What the motions found so far leave to others.
    relatives: Vec<Arc<Relative>>,
}

impl Run<'_> {
    /// Tries sequences until enough plans are found; says why it ended.
    fn search(&mut self) -> String {
        let mut ended = None;
        loop {
            if let Some(reason) = self.is_over() {
                return reason;
            }
            if ended.is_none() && self.under_way.len() < IN_FLIGHT {
                if !self.propose() {
                    ended = Some(self.exhausted());
                }
            } else if let Some(next) = self.under_way.pop_front() {
                if let Some(done) = self.wait(next.number) {
                    self.take(next, *done);
                }
            } else if let Some(reason) = ended {
                return reason;
            }
        }
    }

    /// Why the search ends now, if it does.
    fn is_over(&mut self) -> Option<String> {
        let count = |reached| {
            self.attempts
                .iter()
                .filter(|a| a.reached == reached)
                .count()
        };
        let feasible = count(Reached::Feasible);
        let optimised = feasible + count(Reached::Optimised);
        let request = self.request;
        if self.is_stopped() {
            Some("stopped by the caller".into())
        } else if self.shop.begin.elapsed().as_secs_f64() > request.time_limit {
            Some(format!("time limit of {} s", request.time_limit))
        } else if feasible >= request.solutions {
            Some(format!("{feasible} plan(s) found, as asked for"))
        } else if optimised >= request.max_optimised {
            Some(format!("{optimised} sequences optimised, the limit"))
        } else {
            None
        }
    }

    fn exhausted(&self) -> String {
        match self.policy.status() {
            symbolic::Status::Full => "memory limit of the sequence search".into(),
            _ => format!(
                "all contact sequences of at most {} phases were tried",
                self.policy.max_phases()
            ),
        }
    }

    fn is_stopped(&self) -> bool {
        self.request.stop.is_set() || self.shop.stop.load(Ordering::SeqCst)
    }

    /// Has the next sequence optimised; false if there is none.
    ///
    /// A few sequences are drawn, and of all that wait the one whose keyframes promise the lowest cost is taken: postures at
    /// the edge of reach cost a lot, and make the optimiser's work hard.
    fn propose(&mut self) -> bool {
        let (mut drawn, mut more) = (0, true);
        while more && (drawn < DRAWS || self.waiting.is_empty()) && !self.is_stopped() {
            self.drawn += 1;
            more = self.draw(self.drawn);
            drawn += 1;
        }
        let promise = |c: &Candidate| (c.promise, c.number);
        let order = |a: &Candidate, b: &Candidate| promise(a).partial_cmp(&promise(b));
        let least = (0..self.waiting.len()).min_by(|&a, &b| {
            order(&self.waiting[a], &self.waiting[b]).unwrap_or(std::cmp::Ordering::Equal)
        });
        let Some(Candidate {
            number,
            sequence,
            promise,
            from,
            known,
        }) = least.map(|n| self.waiting.remove(n))
        else {
            return more;
        };
        match (from, &known) {
            (Some(from), _) => self.workers.submit(Job {
                number,
                labels: sequence.labels.clone(),
                phases: self.phases(&sequence),
                from,
            }),
            (None, Some(known)) => {
                let done = Evaluated::remembered(known);
                self.results.insert(number, Box::new(done));
            }
            (None, None) => unreachable!("what is not known starts from keyframes"),
        }
        self.under_way.push_back(UnderWay {
            number,
            sequence,
            promise,
            known,
        });
        true
    }

    /// Checks the next sequence by keyframes, to wait for its turn if it passes; false if there is none.
    fn draw(&mut self, number: usize) -> bool {
        let Some(sequence) = self.policy.next(&mut self.checks) else {
            return false;
        };
        let started = Instant::now();
        self.tell(&Event::Sequence {
            number,
            labels: sequence.labels.clone(),
        });
        let states = sequence
            .states
            .iter()
            .map(|s| self.checks.names(s))
            .collect();
        let known = self.checks.journal.take_sequence(&states);
        if known.is_none()
            && let Some(reason) = self.alike(&sequence)
        {
            self.leave_out(number, &sequence, Reached::Alike, Some(reason), started);
            return true;
        }
        if known.as_ref().is_some_and(|k| k.promise.is_none()) {
            self.again(number, &sequence, known);
            return true;
        }
        let phases = self.phases(&sequence);
        let (promise, from) = match known.as_ref().and_then(|k| k.promise) {
            Some(promise) => (promise, None),
            None => match self.keyframes(number, &sequence, &phases, started) {
                Some((promise, from)) => (promise, Some(from)),
                None => return true,
            },
        };
        let point = known.as_ref().and_then(|k| k.point.clone());
        self.waiting.push(Candidate {
            number,
            sequence,
            promise,
            from: point.map(From::Known).or(from),
            known,
        });
        true
    }

    /// The cost that keyframes promise, and a start for the motion; `None` if they are impossible or promise too little.
    fn keyframes(
        &mut self,
        number: usize,
        sequence: &Sequence,
        phases: &[Phase],
        started: Instant,
    ) -> Option<(f64, From)> {
        let keyframes = self.shop.planner.keyframes(phases, self.shop.settings);
        let possible = keyframes.possible;
        let worst = keyframes.worst.as_ref().filter(|_| !possible);
        let reason = worst.map(|w| summary::words(self.shop.planner.scene, w));
        self.tell(&Event::Keyframes {
            number,
            possible,
            reason: reason.clone(),
        });
        if !possible {
            self.reject_prefix(sequence, phases);
            self.leave_out(number, sequence, Reached::Keyframes, reason, started);
            return None;
        }
        if let Some(reason) = self.too_low(&keyframes.nodes) {
            self.leave_out(number, sequence, Reached::Keyframes, Some(reason), started);
            return None;
        }
        let promise = STRAIN * keyframes.report.objective + PHASE * phases.len() as f64;
        let relative = nearest(&self.relatives, phases);
        Some((promise, From::Keyframes(keyframes.nodes, relative)))
    }

    /// Takes over what is known of a sequence that has no motion.
    fn again(&mut self, number: usize, sequence: &Sequence, known: Option<Tried>) {
        let Some(known) = known else { return };
        let reached = [Reached::Keyframes, Reached::Alike, Reached::Optimised]
            .into_iter()
            .find(|&reached| name(reached) == known.reached);
        let reached = reached.unwrap_or(Reached::Optimised);
        if reached == Reached::Keyframes {
            let phases = self.phases(sequence);
            self.reject_prefix(sequence, &phases);
        }
        if let Some(phase) = known.failed_phase {
            self.failures.failed(number, &sequence.states, phase);
        }
        self.policy.learn(&sequence.states, known.reward);
        self.attempts.push(Attempt {
            number,
            labels: sequence.labels.clone(),
            reached,
            reason: known.reason,
            cost: known.cost,
            iterations: known.iterations,
            seconds: known.seconds,
        });
    }

    /// Takes note of a sequence that is not optimised.
    fn leave_out(
        &mut self,
        number: usize,
        sequence: &Sequence,
        reached: Reached,
        reason: Option<String>,
        started: Instant,
    ) {
        let attempt = Attempt {
            number,
            labels: sequence.labels.clone(),
            reached,
            reason,
            cost: None,
            iterations: 0,
            seconds: started.elapsed().as_secs_f64(),
        };
        self.conclude(sequence, attempt, reward::LEFT_OUT, None);
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

    /// Where the base is to get high: why keyframes cannot lead higher than the best plan.
    fn too_low(&self, nodes: &[Vec<f64>]) -> Option<String> {
        let scene = self.shop.planner.scene;
        let best = self.best.as_ref().filter(|best| best.feasible)?;
        let height = |nodes: &[Vec<f64>]| nodes.last().map_or(f64::NEG_INFINITY, |q| q[2]);
        let (now, before) = (height(nodes), height(&best.point.nodes));
        let low = scene.objective == Objective::BaseHeight && now < before - HEIGHT_ROOM;
        low.then(|| format!("the base ends at {now:.2} m at most, a plan is at {before:.2} m"))
    }

    /// The result of a sequence, in its turn; `None` if the search is stopped before.
    fn wait(&mut self, number: usize) -> Option<Box<Evaluated>> {
        while !self.results.contains_key(&number) {
            match self.workers.messages.recv().ok()? {
                Message::Event(event) => self.tell(&event),
                Message::Done(number, result) => {
                    self.results.insert(number, result);
                }
            }
            if self.is_stopped() {
                self.shop.stop.store(true, Ordering::SeqCst);
            }
        }
        self.results.remove(&number)
    }

    /// Takes note of an optimised motion.
    fn take(&mut self, from: UnderWay, done: Evaluated) {
        let UnderWay {
            number,
            sequence,
            promise,
            known,
        } = from;
        let late = self.shop.begin.elapsed().as_secs_f64() > self.request.time_limit;
        let whole = done.feasible || !(self.is_stopped() || late);
        let feasible = done.feasible || known.as_ref().is_some_and(|k| k.reached == "feasible");
        let reached = if feasible {
            Reached::Feasible
        } else {
            Reached::Optimised
        };
        let better = self.best.as_ref().is_none_or(|best| {
            let now = (!feasible, if feasible { done.cost } else { done.violation });
            let before = if best.feasible {
                (false, best.cost)
            } else {
                (true, best.violation)
            };
            now < before
        });
        let best = better && !done.point.nodes.is_empty();
        self.tell(&Event::Optimised {
            number,
            feasible,
            cost: done.cost,
            reason: done.reason.clone(),
        });
        if feasible {
            self.failures.succeeded(&sequence.states);
        } else if let Some(phase) = known
            .as_ref()
            .map_or(done.worst_phase, |known| known.failed_phase)
        {
            self.failures.failed(number, &sequence.states, phase);
        }
        let reward = match (feasible, &known) {
            (true, _) => self.rewards.of_plan(done.cost),
            (false, Some(known)) => known.reward,
            (false, None) => Rewards::of_failure(done.violation),
        };
        let attempt = Attempt {
            number,
            labels: sequence.labels.clone(),
            reached,
            reason: done.reason.clone(),
            cost: Some(done.cost),
            iterations: done.iterations,
            seconds: known.as_ref().map_or(done.seconds, |k| k.seconds),
        };
        if known.is_some() {
            self.policy.learn(&sequence.states, reward);
            self.attempts.push(attempt);
        } else if whole {
            self.conclude(&sequence, attempt, reward, Some((&done, best, promise)));
        }
        if feasible {
            self.relatives.extend(done.relative);
            let many = self.relatives.len().saturating_sub(MOST_RELATIVES);
            self.relatives.drain(..many);
            let now = self.shop.begin.elapsed().as_secs_f64();
            self.first_after.get_or_insert(now);
        }
        if let Some(plan) = done.plan {
            self.keep(number, best, done.cost, plan);
        }
        if best {
            self.best = Some(Best {
                feasible,
                cost: done.cost,
                violation: done.violation,
                point: done.point,
                sequence,
            });
        }
    }

    fn keep(&mut self, number: usize, best: bool, cost: f64, plan: plan::Plan) {
        let scene = self.shop.planner.scene;
        let weight = scene.robot.model.total_mass() * scene.gravity.norm();
        self.tell(&Event::Solution {
            number,
            best,
            plan: Box::new(plan.clone()),
        });
        self.diverse.offer(Alternative {
            number,
            cost,
            duration: plan.time.last().copied().unwrap_or(0.0),
            loaded: loaded(&plan, weight),
            plan,
        });
    }

    /// Tells the policy and the journal what became of a sequence.
    fn conclude(
        &mut self,
        sequence: &Sequence,
        attempt: Attempt,
        reward: f64,
        done: Option<(&Evaluated, bool, f64)>,
    ) {
        let keep = |(done, best, _): (&Evaluated, bool, f64)| {
            (done.feasible || best).then(|| (&done.point).into())
        };
        self.policy.learn(&sequence.states, reward);
        let states = sequence
            .states
            .iter()
            .map(|s| self.checks.names(s))
            .collect();
        self.checks.journal.note_sequence(Tried {
            number: attempt.number,
            at: self.shop.begin.elapsed().as_secs_f64(),
            labels: attempt.labels.clone(),
            states,
            reached: name(attempt.reached).into(),
            reason: attempt.reason.clone(),
            cost: attempt.cost,
            promise: done.map(|(_, _, promise)| promise),
            failed_phase: done.and_then(|(done, ..)| done.worst_phase),
            violation: done.map(|(done, ..)| done.violation),
            iterations: attempt.iterations,
            seconds: attempt.seconds,
            reward,
            point: done.and_then(keep),
        });
        self.attempts.push(attempt);
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

    fn phases(&self, sequence: &Sequence) -> Vec<Phase> {
        let steps = self.shop.planner.scene.search.steps;
        let phase = |state: &symbolic::ContactState| Phase {
            state: state.clone(),
            steps,
        };
        sequence.states.iter().map(phase).collect()
    }

    fn tell(&mut self, event: &Event) {
        if !(self.observe)(event) {
            self.shop.stop.store(true, Ordering::SeqCst);
        }
    }

    /// Stops what is under way, refines the best motion and puts everything together.
    fn finish(mut self, ended: String) -> Outcome {
        let shop = self.shop;
        let stopped = self.is_stopped();
        shop.stop.store(true, Ordering::SeqCst);
        drop(self.workers);
        let observe = self.observe;
        let best = self.best.take();
        let feasible = best.as_ref().is_some_and(|b| b.feasible);
        let found = best.map(|best| {
            let steps = shop.planner.scene.search.steps;
            let phases: Vec<Phase> = best
                .sequence
                .states
                .iter()
                .map(|state| Phase {
                    state: state.clone(),
                    steps,
                })
                .collect();
            let mut motion = shop.planner.restore(&phases, shop.settings, best.point);
            motion.feasible = best.feasible;
            let request = Request {
                refinement: self.request.refinement.filter(|_| !stopped),
                ..self.request.clone()
            };
            let (mut motion, refined) = refine::refine(
                shop.planner,
                &phases,
                shop.settings,
                motion,
                (&request, shop.begin),
                observe,
            );
            let labels = &best.sequence.labels;
            Found::of(shop.planner.scene, labels, &mut motion, refined)
        });
        Outcome {
            feasible,
            best: found,
            alternatives: self.diverse.plans,
            first_after: self.first_after,
            attempts: self.attempts,
            impossible: self.checks.impossible(),
            ended,
            seconds: shop.begin.elapsed().as_secs_f64(),
        }
    }
}

/// The name in files.
fn name(reached: Reached) -> &'static str {
    match reached {
        Reached::Keyframes => "keyframes",
        Reached::Alike => "alike",
        Reached::Optimised => "optimised",
        Reached::Feasible => "feasible",
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

fn goal_text(scene: &Scene) -> String {
    let pairs: Vec<_> = scene
        .goal_contacts
        .iter()
        .map(|g| {
            format!(
                "{} on {}",
                scene.interfaces[g.a.0].name, scene.interfaces[g.b.0].name
            )
        })
        .collect();
    pairs.join(", ")
}

/// Refuses a start in which bodies that do not touch overlap.
pub(crate) fn check_start(scene: &Scene, planner: &Planner<'_>) -> Result<(), Error> {
    let model = &planner.system.model;
    let mut kinematics = multibody::Kinematics::new(model);
    kinematics.update(model, &planner.system.start(scene));
    let touches = ocp::collision::CollisionModel::start_touches(scene, &planner.system);
    let deepest = planner
        .collisions
        .deepest(&kinematics, &|a, b| touches.contains(&(a, b)));
    match deepest {
        Some((depth, a, b)) if depth > START_OVERLAP => Err(Error::StartInCollision {
            a: summary::body_name(scene, &planner.system, Ok(a)),
            b: summary::body_name(scene, &planner.system, b),
            depth_mm: depth * 1e3,
        }),
        _ => Ok(()),
    }
}
