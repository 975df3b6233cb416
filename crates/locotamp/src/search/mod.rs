//! The plan search: a policy proposes contact sequences, states, transitions and keyframes filter them, the trajectory
//! optimiser judges, and the policy learns what they were worth.
//!
//! A sequence is tried on the coarse grid first, and if that costs less than what others promise, or enough others have
//! their motions too, on the grid on which it must hold.
//! Up to [`IN_FLIGHT`] sequences are optimised at once, two at first, and those to choose the next from are drawn meanwhile. Results
//! are taken in the order of the work that was done on them ([`turns`]), so that a motion that is hard to find holds up nothing and
//! the run is the same however many threads there are and however long they take.

mod candidate;
mod diverse;
mod failures;
mod growth;
mod more_steps;
mod order;
mod places;
mod proposals;
mod results;
mod reward;
mod stances;
mod turns;
mod under_way;
mod why;
mod workers;

use std::mem;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Instant;

use crate::api::{Attempt, Error, Event, Found, Outcome, Request, Search};
use crate::checks::Checks;
use crate::journal::{Header, Journal, States};
use crate::start::check_start;
use crate::{departures, domain};
use candidate::{Candidate, Work};
use diverse::{Diverse, Kept, Stored};
use failures::Failures;
use growth::Growth;
use more_steps::Longer;
use ocp::{Ending, Integrator, Phase, Planner, Preset, Relative, Settings, Sticking};
use places::Places;
use reward::Rewards;
use scene::{Owner, Scene};
use symbolic::{
    BestFirst, Contact, Policy, Rollouts, SearchLimits, Sequence, SkeletonGraph, TreeSearch,
};
use under_way::UnderWay;
use workers::{Shop, Workers};

/// Sequences that are under evaluation at once. Part of what decides which sequence comes next, hence no option.
const IN_FLIGHT: usize = 4;
/// The same before there are results.
const FIRST: usize = 2;
/// Weight of the centre of mass over the feet in keyframes [1/m²]: it ranks sequences, and leads fewer beginnings into local
/// minima (benches/runs/2026-11-22-balance.md, 2026-11-30-hurdles.md).
const BALANCE: f64 = 2.0;
/// The same in keyframes from which others begin, in case these promise less ([`Run::promise_from_balanced`]).
const BALANCED: f64 = 10.0;
/// Largest share of the time limit that the search may use once there is a plan; the rest is for refining it.
const SEARCH_SHARE: f64 = 0.9;
/// Time that refining a plan is expected to take, in that of its motion and per interval: 0.14 to 0.85 in 39 runs, half of them below
/// 0.33, those above 0.6 of a few seconds (benches/runs/2026-11-25-scenes.md).
const REFINING: f64 = 0.6;
/// Largest share of the search's time that is spent on more sequences once there is a plan.
const CHOOSING_SHARE: f64 = 0.5;
/// Largest share of the time limit that is kept for refining.
const MOST_REFINING: f64 = 0.6;

/// Why a search ends for which no skeleton is left.
const NO_SKELETON: &str = "every order of grasps and places needs contacts that are impossible";

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
    let changed = departures::with_places_to_leave(scene);
    let scene = changed.as_ref().unwrap_or(scene);
    let planner = Planner::new(scene)?;
    check_start(scene, &planner)?;
    let domain::Skeletons {
        graph,
        limits,
        too_heavy,
    } = domain::skeletons(scene)?;
    let skeleton = graph.shortest_skeleton();
    if skeleton.is_none() && too_heavy.is_empty() {
        let goal = goal_contacts(scene).join(", ");
        return Err(Error::Unreachable(format!(
            "no sequence of grasp, lift, place and release leads to the goal {goal}; does a hand accept the object's \
             handle or two opposite patches, and the goal surface its bottom?"
        )));
    }
    let contacts = graph.domain().contacts().len();
    let policy = policy(scene, request, graph, &limits);
    let settings = balanced(settings(scene, request)?);
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
                goal_contacts(scene),
            );
            Journal::open(path, request.resume, &header)?
        }
        None => Journal::default(),
    };
    let started = Event::Started {
        interfaces: scene.interfaces.len(),
        contacts,
        max_phases: policy.max_phases(),
        skeleton: skeleton.unwrap_or(0),
    };
    let stop = AtomicBool::new(!observe(&started));
    let shop = Shop {
        planner: &planner,
        settings: &settings,
        holds: request.refines(),
        stop: &stop,
        begin,
        time_limit: request.time_limit,
    };
    let checks = Checks::new(
        (&planner, &settings, scene.search.steps),
        (begin, request.time_limit, request.stop.clone()),
        (journal, too_heavy),
    );
    let places = request.thread_count().min(IN_FLIGHT);
    let least_gain = reward::least_gain(scene, &settings);
    thread::scope(|scope| {
        let workers = Workers::start(scope, IN_FLIGHT, places, shop);
        let mut run = Run {
            shop,
            request,
            policy,
            checks,
            workers,
            observe,
            drawn: 0,
            drawn_before: 0,
            begun_at: 0,
            submitted: 0,
            waiting: vec![],
            moved: 0,
            growth: Growth::new(Places::new(resting(scene)), &scene.objective, least_gain),
            clock: 0,
            under_way: UnderWay::default(),
            lost: false,
            ended: None,
            least_gain,
            rewards: Rewards::new(least_gain),
            coarse_rewards: Rewards::new(least_gain),
            failures: Failures::new(Places::new(resting(scene))),
            longer: Longer::default(),
            attempts: vec![],
            diverse: Diverse::new(request.solutions, least_gain),
            refined: None,
            coarse: None,
            aside: vec![],
            nearest: None,
            first_after: None,
            relatives: vec![],
        };
        let ended = run.search_until_refined();
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
            let tree = TreeSearch::new(graph, limits, costs, request.seed);
            let tree = tree.with_own_costs(domain::own_cost(scene), domain::end_cost(scene));
            Box::new(if domain::looks_ahead(scene) {
                tree.with_outlook()
            } else {
                tree
            })
        }
        Search::BestFirst => Box::new(BestFirst::new(graph, limits, costs)),
        Search::Random => Box::new(Rollouts::new(graph, limits, costs, request.seed)),
    }
}

/// The problem's options for a request.
pub(crate) fn settings(scene: &Scene, request: &Request) -> Result<Settings, Error> {
    if request.preset == Preset::Paper && request.integrator != Integrator::Euler {
        return Err(Error::PaperIntegrator);
    }
    if request.sticking == Sticking::Velocity && request.integrator != Integrator::Euler {
        return Err(Error::VelocitySticking);
    }
    let settings = Settings::new(request.preset, &scene.optimiser);
    Ok(Settings {
        integrator: request.integrator,
        sticking: request.sticking,
        between: settings.between && request.refines().is_none(),
        ending: match request.refines() {
            Some(_) => Ending::Rough,
            None => Ending::Exact,
        },
        ..settings
    })
}

/// The same with balanced keyframes, but for the problem of the paper.
pub(crate) fn balanced(mut settings: Settings) -> Settings {
    if settings.preset == Preset::Default {
        settings.weights.balance = BALANCE;
    }
    settings
}

/// The same for a motion that all threads work on.
pub(crate) fn settings_of_one(scene: &Scene, request: &Request) -> Result<Settings, Error> {
    let threads = request.thread_count();
    settings(scene, request).map(|all| Settings { threads, ..all })
}

/// A motion that violates its constraints.
struct Nearest {
    /// By how much (scaled rows).
    violation: f64,
    motion: Stored,
}

/// A search with all that it knows.
struct Run<'a> {
    shop: Shop<'a>,
    request: &'a Request,
    policy: Box<dyn Policy>,
    checks: Checks<'a>,
    workers: Workers,
    observe: &'a mut dyn FnMut(&Event) -> bool,
    /// Number of sequences drawn from the policy; that and the clock when a motion was begun last; how many were begun.
    drawn: usize,
    drawn_before: usize,
    begun_at: u64,
    submitted: usize,
    /// Sequences that wait for their turn, with or without a motion on the coarse grid.
    waiting: Vec<(Candidate, Work)>,
    /// Number of sequences tried on the coarse grid, and what their motions cost more than their keyframes promised.
    moved: usize,
    growth: Growth,
    /// Work done until now as the search counts it ([`turns`]): that of the result taken last, or of the draws since.
    clock: u64,
    /// Sequences whose motion is being optimised, or was and whose result waits for its turn.
    under_way: UnderWay,
    /// A worker panicked.
    lost: bool,
    /// Why no more sequences are begun.
    ended: Option<String>,
    /// What the scene's objective has to get more to be worth more whatever it costs.
    least_gain: f64,
    rewards: Rewards,
    /// Of motions on the coarse grid, while the best of many is sought.
    coarse_rewards: Rewards,
    failures: Failures,
    longer: Longer,
    attempts: Vec<Attempt>,
    /// The plans.
    diverse: Diverse,
    /// The best of them, refined.
    refined: Option<Found>,
    /// The best of those that cannot be refined, and all of these.
    coarse: Option<Found>,
    aside: Vec<Kept>,
    /// Without any: the least violated motion.
    nearest: Option<Nearest>,
    first_after: Option<f64>,
    /// What the motions found so far leave to others.
    relatives: Vec<Arc<Relative>>,
}

impl Run<'_> {
    /// Tries sequences until enough plans are found and one of them is refined, if that is asked for: where none can be, they are
    /// set aside and the search goes on. Says why it ended.
    fn search_until_refined(&mut self) -> String {
        loop {
            let ended = self.search();
            let enough = self.diverse.len() >= self.request.solutions;
            if !enough || self.request.refinement.is_none() || self.is_stopped() {
                return ended;
            }
            let best = self.refine_best(true);
            if best.as_ref().is_some_and(Found::is_refined) {
                self.refined = best;
                return ended;
            }
            let before = self.coarse.take();
            self.coarse = self.best_of(before.into_iter().chain(best));
            if self.is_late() {
                self.refined = self.coarse.take();
                return ended;
            }
            let none = Diverse::new(self.request.solutions, self.least_gain);
            let plans = mem::replace(&mut self.diverse, none);
            self.aside.extend(plans.plans());
        }
    }

    /// Tries sequences until enough plans are found; says why it ended.
    fn search(&mut self) -> String {
        self.ended = None;
        loop {
            if let Some(reason) = self.is_over() {
                return reason;
            }
            if self.take_next(self.clock) {
                continue;
            }
            let has_room = self.under_way.len() < IN_FLIGHT.min(FIRST + self.moved / 2);
            if self.is_full() {
                self.ended = self.ended.take().or_else(|| Some(self.full()));
            }
            let has_choice = self.ended.is_some() || self.has_choice();
            if has_room && self.submit(has_choice) {
                continue;
            }
            if !self.under_way.is_empty() && (has_choice || self.is_last_there()) {
                self.take_next(u64::MAX);
            } else if let Some(reason) = self.ended.take() {
                return reason;
            } else if !self.draw() {
                self.ended = Some(self.exhausted());
            }
        }
    }

    /// True if the next result is there, and is the one plan that is asked for: the search ends with it.
    fn is_last_there(&mut self) -> bool {
        while let Ok(message) = self.workers.messages.try_recv() {
            self.receive(message);
        }
        let is_last = self.request.solutions == 1 && self.moved >= self.request.min_optimised;
        let next = self.under_way.next();
        is_last && next.is_some_and(|done| done.plan.is_some())
    }

    /// True if there is a plan, and more sequences are to be tried on the coarse grid before others are held.
    fn chooses(&self) -> bool {
        let more = self.ended.is_none() || !self.under_way.is_empty() || self.has_unmoved();
        more && self.diverse.best().is_some()
            && self.moved < self.request.min_optimised
            && !self.is_after(CHOOSING_SHARE * self.deadline())
    }

    /// Why the search ends now, if it does.
    fn is_over(&self) -> Option<String> {
        let plans = self.diverse.len();
        let request = self.request;
        if self.is_stopped() {
            Some("stopped by the caller".into())
        } else if self.is_after(self.deadline()) {
            Some(format!("time limit of {} s", request.time_limit))
        } else if plans >= request.solutions && !self.chooses() {
            Some(format!("{plans} plan(s) found, as asked for"))
        } else {
            None
        }
    }

    /// True after so many seconds of the run.
    fn is_after(&self, seconds: f64) -> bool {
        self.shop.begin.elapsed().as_secs_f64() > seconds
    }

    /// True if the time is over.
    fn is_late(&self) -> bool {
        self.is_after(self.request.time_limit)
    }

    /// When the search ends, in seconds from its begin: in time to refine the best plan, if there is one.
    fn deadline(&self) -> f64 {
        let limit = self.request.time_limit;
        let refinement = self.request.refines();
        let (Some(best), Some(refinement)) = (self.diverse.best(), refinement) else {
            return limit;
        };
        let intervals = best.alternative.duration / refinement.max_step;
        let finer = intervals / best.motion.steps.iter().sum::<usize>().max(1) as f64;
        let needs = REFINING * finer * best.motion.seconds;
        limit - needs.clamp((1.0 - SEARCH_SHARE) * limit, MOST_REFINING * limit)
    }

    fn full(&self) -> String {
        format!("{} sequences optimised, the limit", self.submitted)
    }

    fn exhausted(&self) -> String {
        match self.policy.status() {
            symbolic::Status::Full => "memory limit of the sequence search".into(),
            symbolic::Status::NoSkeleton => NO_SKELETON.into(),
            _ if self.policy.graph().shortest_skeleton().is_none() => NO_SKELETON.into(),
            _ => format!(
                "all contact sequences of at most {} phases were tried",
                self.policy.max_phases()
            ),
        }
    }

    fn is_stopped(&self) -> bool {
        self.lost || self.request.stop.is_set() || self.shop.stop.load(Ordering::SeqCst)
    }

    fn phases(&self, sequence: &Sequence) -> Vec<Phase> {
        let steps = self.shop.planner.scene.search.steps;
        let phase = |state: &symbolic::ContactState| Phase {
            state: state.clone(),
            steps,
        };
        sequence.states.iter().map(phase).collect()
    }

    /// Contacts per phase in words.
    fn names(&self, sequence: &Sequence) -> States {
        let states = sequence.states.iter();
        states.map(|state| self.checks.names(state)).collect()
    }

    fn tell(&mut self, event: &Event) {
        if !(self.observe)(event) {
            self.shop.stop.store(true, Ordering::SeqCst);
        }
    }
}

/// Contacts of the start by which objects rest.
fn resting(scene: &Scene) -> Vec<Contact> {
    let of_object = |c: &&Contact| matches!(scene.interfaces[c.a.0].owner, Owner::Object(_));
    scene
        .start_contacts
        .iter()
        .filter(of_object)
        .copied()
        .collect()
}

fn goal_contacts(scene: &Scene) -> Vec<String> {
    let name = |i: usize| &scene.interfaces[i].name;
    let goals = scene.goal_contacts.iter();
    goals
        .map(|goal| format!("{} on {}", name(goal.a.0), name(goal.b.0)))
        .collect()
}
