//! Why a contact sequence has no motion, and which single number would give it one.
//!
//! Three questions, answered by solving: the shortest beginning of the sequence that fails says the phase; what is violated
//! and what pulls comes from the solve that failed; for each number that the pulling constraints depend on, the scene is
//! solved with that number changed as far as makes sense, and if that helps, the least change is found by bisection and
//! confirmed by the solve that the user would run.

mod candidates;
mod contacts;
mod knob;
mod remedy;
mod trial;
mod words;

use std::slice::from_ref;
use std::time::Instant;

use crate::api::{Event, Request};
use crate::summary;
use ocp::{Keyframes, Motion, Phase, Pull, Subject, Worst};
use plan::{Explanation, FailedStage, Obstacle};
use remedy::Found;
use scene::{Owner, Scene};
use solver::Status;
use trial::{Effort, Trials};

pub(crate) use contacts::remedy as remedy_of_contacts;
use knob::Knob;

/// Remedies after which the search ends.
const ENOUGH: usize = 2;
/// Numbers of geometry that are tried at most where configurations are possible but no motion is.
const MOST_PLACES: usize = 4;
/// Violations and pulls that are told.
const MOST_ROWS: usize = 6;

/// What failed.
pub(crate) enum Failed<'a> {
    /// There are no keyframes.
    Keyframes(&'a Keyframes),
    /// There is no motion.
    Motion(&'a Motion),
}

/// A sequence without a motion.
pub(crate) struct Case<'a> {
    /// The scene, with the goal of the sequence.
    pub scene: &'a Scene,
    pub phases: &'a [Phase],
    /// What happens on entering each phase.
    pub labels: &'a [String],
    pub request: &'a Request,
    /// Keyframes of trials are sought from the sequence alone, not as searches find them.
    pub is_quick: bool,
    /// Only the grid on which a motion must hold has none.
    pub falls_short: bool,
    pub failed: Failed<'a>,
}

impl Case<'_> {
    fn stage(&self) -> FailedStage {
        match self.failed {
            Failed::Keyframes(k) if k.report.status != Status::Contradictory => {
                FailedStage::Keyframes
            }
            Failed::Motion(m) if m.report.status != Status::Contradictory => FailedStage::Motion,
            _ => FailedStage::Contradiction,
        }
    }

    fn violated(&self) -> Vec<Worst> {
        match &self.failed {
            Failed::Keyframes(k) => k.violated.clone(),
            Failed::Motion(m) => ocp::violations(&m.trajectory.program, &m.report, 1e-5),
        }
    }

    fn pulls(&self) -> Vec<Pull> {
        match &self.failed {
            Failed::Keyframes(k) => k.pulls.clone(),
            Failed::Motion(m) => ocp::pulls(&m.trajectory.program, &m.report),
        }
    }

    fn obstacle(&self, worst: &Worst) -> Obstacle {
        Obstacle {
            phase: worst.phase + 1,
            action: self.action(worst.phase),
            group: words::group(worst.label.category).into(),
            constraint: worst.label.category.into(),
            subject: summary::subject(self.scene, worst.label.subject),
            amount: worst.amount,
            unit: worst.label.unit.into(),
        }
    }

    fn action(&self, phase: usize) -> String {
        self.labels.get(phase).cloned().unwrap_or_default()
    }
}

/// Explains why a sequence has no motion, in a run that began at `begin`; `observe` sees every solve and ends the search for
/// remedies by returning false, and so does the time limit of the request.
pub(crate) fn explain(
    case: &Case,
    begin: Instant,
    observe: &mut dyn FnMut(&Event) -> bool,
) -> Explanation {
    let stage = case.stage();
    let (violated, pulls) = (case.violated(), case.pulls());
    let mut search = Search {
        case,
        pulls: &pulls,
        trials: Trials::new(case, begin, observe),
        found: vec![],
        in_vain: vec![],
    };
    let mut phase = violated.first().map_or(0, |w| w.phase);
    if stage != FailedStage::Contradiction {
        phase = failing_phase(case, stage, &mut search.trials).unwrap_or(phase);
        search.run(stage);
    }
    let Search {
        trials,
        mut found,
        in_vain,
        ..
    } = search;
    found.sort_by(|a: &Found, b| a.size(case.scene).total_cmp(&b.size(case.scene)));
    let cause = match found.first() {
        Some(found) => words::cause(case, phase, found),
        None => worst_of(case, phase, &violated),
    };
    let mut explanation = Explanation {
        stage,
        cause,
        violated: (violated.iter().take(MOST_ROWS))
            .map(|w| case.obstacle(w))
            .collect(),
        pulls: pulls
            .iter()
            .take(MOST_ROWS)
            .map(|p| words::pull(case, p))
            .collect(),
        remedies: found.iter().map(|f| words::remedy(case.scene, f)).collect(),
        in_vain: in_vain.iter().map(|k| words::name(case.scene, k)).collect(),
        solves: trials.solves,
        complete: !trials.stopped,
        text: String::new(),
    };
    explanation.text = words::text(&explanation, case.falls_short) + &words::falling(case);
    explanation
}

/// The last phase of the shortest beginning that fails; the last one of all if only the goal cannot be met. `None` if the
/// trials were stopped.
fn failing_phase(case: &Case, stage: FailedStage, trials: &mut Trials) -> Option<usize> {
    let count = case.phases.len();
    let effort = match stage {
        FailedStage::Motion => Effort::Coarse,
        _ => Effort::Keyframes,
    };
    trials.doing = "which phase fails".into();
    let (mut possible, mut impossible) = (0, count);
    if !case.scene.goal_regions.is_empty() && trials.prefix_succeeds(case.scene, count, effort) {
        return Some(count - 1);
    }
    while impossible - possible > 1 && !trials.stopped {
        let middle = usize::midpoint(possible, impossible);
        let Some(end) = (middle..impossible).find(|&k| can_rest(case, k)) else {
            impossible = middle;
            continue;
        };
        if trials.prefix_succeeds(case.scene, end, effort) {
            possible = end;
        } else {
            impossible = middle;
        }
    }
    (!trials.stopped).then_some(impossible - 1)
}

/// Can a plan of the first `count` phases end at rest, as every plan must: the robot touches something.
fn can_rest(case: &Case, count: usize) -> bool {
    let on_something = |c: &symbolic::Contact| {
        let owner = |i: symbolic::InterfaceId| case.scene.interfaces[i.0].owner;
        matches!(owner(c.a), Owner::Robot { .. }) && matches!(owner(c.b), Owner::Static(_))
    };
    case.phases[count - 1]
        .state
        .contacts
        .iter()
        .any(on_something)
}

/// The search for numbers that help.
struct Search<'a, 'b> {
    case: &'a Case<'a>,
    pulls: &'a [Pull],
    trials: Trials<'b>,
    found: Vec<Found>,
    in_vain: Vec<Knob>,
}

impl Search<'_, '_> {
    /// Tries numbers until enough help: those of forces and times before those of geometry, but where few can be tried by what they pull.
    fn run(&mut self, stage: FailedStage) {
        let (scene, phases) = (self.case.scene, self.case.phases);
        if stage == FailedStage::Motion {
            let mut groups = candidates::of_motion(scene, phases, self.pulls);
            if self.case.falls_short {
                let knobs = candidates::of_geometry(scene, phases, self.pulls);
                groups.extend(knobs.into_iter().map(|knob| vec![knob]));
            }
            groups.sort_by(|a, b| self.relevance(b).total_cmp(&self.relevance(a)));
            for group in groups {
                self.group(group);
            }
            if !self.found.is_empty() || self.case.falls_short {
                return;
            }
        }
        let mut knobs = candidates::of_geometry(scene, phases, self.pulls);
        knobs.sort_by(|a, b| {
            self.relevance(from_ref(b))
                .total_cmp(&self.relevance(from_ref(a)))
        });
        let (guide, most) = match stage {
            FailedStage::Motion => (Effort::Coarse, MOST_PLACES),
            _ => (Effort::Keyframes, usize::MAX),
        };
        for knob in knobs.into_iter().take(most) {
            self.one(knob, guide);
        }
    }

    /// Numbers that can be relaxed together: if all of them do not help, none does.
    fn group(&mut self, mut group: Vec<Knob>) {
        if self.is_over() {
            return;
        }
        let scene = self.case.scene;
        group.sort_by(|a, b| {
            self.relevance(from_ref(b))
                .total_cmp(&self.relevance(from_ref(a)))
        });
        if group.len() > 1 {
            let names: Vec<String> = group.iter().map(|k| words::name(scene, k)).collect();
            self.trials.doing = names.join(", ");
            let changed = |changed: Scene, knob: &Knob| knob.relaxed(&changed, scene);
            let all = group.iter().fold(scene.clone(), changed);
            if !self.trials.succeeds(&all, Effort::Coarse) {
                if !self.trials.stopped {
                    self.in_vain.append(&mut group);
                }
                return;
            }
        }
        for knob in group {
            self.one(knob, Effort::Coarse);
        }
    }

    /// One number.
    fn one(&mut self, knob: Knob, guide: Effort) {
        if self.is_over() || self.found.iter().any(|f| f.includes(&knob)) {
            return;
        }
        let (scene, trials) = (self.case.scene, &mut self.trials);
        trials.doing = words::name(scene, &knob);
        let found = match knob {
            Knob::AllTorques => remedy::find_torque(trials, scene),
            _ => remedy::find(trials, scene, &knob, guide),
        };
        match found {
            Some(found) => self.found.push(found),
            None if !trials.stopped => self.in_vain.push(knob),
            None => {}
        }
    }

    fn is_over(&self) -> bool {
        self.trials.stopped || self.found.len() >= ENOUGH
    }

    /// Share of the pulls that numbers have a part in.
    fn relevance(&self, knobs: &[Knob]) -> f64 {
        let scene = self.case.scene;
        let counts = |p: &&Pull| knobs.iter().any(|k| concerns(scene, k, p));
        self.pulls.iter().filter(counts).map(|p| p.share).sum()
    }
}

/// Does a constraint depend on a number.
fn concerns(scene: &Scene, knob: &Knob, pull: &Pull) -> bool {
    let category = pull.label.category;
    let touches = |owner: Owner| match pull.label.subject {
        Subject::Contact(c) => {
            scene.interfaces[c.a.0].owner == owner || scene.interfaces[c.b.0].owner == owner
        }
        _ => false,
    };
    let contact_of = |of: &[usize]| match pull.label.subject {
        Subject::Contact(c) => of.contains(&c.a.0) || of.contains(&c.b.0),
        _ => false,
    };
    let of_object = |o: usize| match pull.label.subject {
        Subject::Coordinate(v) => v.checked_sub(scene.robot.model.nv).map(|v| v / 6) == Some(o),
        _ => false,
    };
    match knob {
        Knob::Mass(o) => {
            of_object(*o) || category.contains("friction") && touches(Owner::Object(*o))
        }
        Knob::Friction(of) => category == "friction cone" && contact_of(of),
        Knob::Torsion(of) => category == "torsional friction" && contact_of(of),
        Knob::Torque(_) | Knob::AllTorques => {
            matches!(category, "torque limit" | "torque at speed")
        }
        Knob::Velocity(_) => category == "joint velocity",
        Knob::Range(..) => category == "joint range",
        Knob::Force(of) | Knob::Moment(of) => {
            matches!(category, "contact force" | "grasp strength") && contact_of(of)
        }
        Knob::Longest | Knob::Shortest => category == "phase duration",
        Knob::Static(s, _) => category.starts_with("contact ") && touches(Owner::Static(*s)),
        Knob::Object(o, _) | Knob::Width(o, _) => {
            category.starts_with("contact ") && touches(Owner::Object(*o))
        }
        Knob::Goal(r, ..) => pull.label.subject == Subject::Goal(*r),
    }
}

/// The worst violation in a phase, else the worst of all.
fn worst_of(case: &Case, phase: usize, violated: &[Worst]) -> Obstacle {
    let here = violated.iter().find(|w| w.phase == phase);
    let mut obstacle = match here.or(violated.first()) {
        Some(worst) => case.obstacle(worst),
        None => Obstacle {
            phase: 0,
            action: String::new(),
            group: "unknown".into(),
            constraint: "no violated constraint is known".into(),
            subject: String::new(),
            amount: 0.0,
            unit: String::new(),
        },
    };
    (obstacle.phase, obstacle.action) = (phase + 1, case.action(phase));
    obstacle
}
