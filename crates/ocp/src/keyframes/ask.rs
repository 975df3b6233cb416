//! How a question about configurations is answered: which guesses are tried, and how they are solved.

use super::{CAREFUL_PHASES, KEYFRAME_TOLERANCE, Keyframes, NEAR};
use crate::collision::{Clearances, Crossings, Watched};
use crate::guess;
use crate::motion::{Planner, near, report_at};
use crate::problem::Trajectory;
use crate::program::{Grid, Phase, Program};
use crate::resistance::{pulls, violations, worst_row};
use crate::settings::{Arrangement, Preset, Settings};
use crate::stagnation::{MOST_HURRIED, Stagnation};
use solver::{Convexification, Enough, InteriorPoint, Options, Problem};

/// Distance below which pairs get a row in a guess [m].
const GUESS_NEAR: f64 = 0.1;
/// Distance below which what is walked around gets rows [m].
const BESIDE: f64 = 0.6;
/// Rounds of solving with more collision pairs.
const ROUNDS: usize = 8;
/// Violation (m, rad) from which no slow attempt is made after two others.
const FAR: f64 = 0.2;
/// Most iterations of a solve; the same from a guess that satisfies everything, where the cost of what is found
/// ranks sequences: 25 to 116 of those that end, but for one of 38 (benches/runs/2026-11-29-walks.md).
const MOST: usize = 240;
const MOST_KNOWN: usize = 160;
/// Where the latter may end: within a hundredth of the least cost.
const RANKED: Enough = Enough {
    violation: 0.2 * KEYFRAME_TOLERANCE,
    dual: 1.0,
    barrier: 1e-4,
};
/// Rounds of refinement of a step; with one less two beginnings of `tasks/past_higher` are refused (benches/runs/2026-11-29-paths.md).
const REFINEMENTS: usize = 3;
/// Phases that are solved together for a guess.
const WINDOW: usize = 3;

/// One question about configurations.
pub(crate) struct Ask<'a> {
    planner: &'a Planner<'a>,
    phases: &'a [Phase],
    settings: &'a Settings,
    grid: Grid,
    manner: Manner,
}

/// How fast a solve goes away from its guess.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Manner {
    Swift,
    /// The same from a guess that goes on from keyframes or lies between some: most of it has the clearances.
    Further,
    /// Short steps: slower, with other local minima.
    Careful,
    /// The same with as many as it takes, since the guess satisfies everything.
    Known,
}

impl<'a> Ask<'a> {
    /// Keyframes of these phases.
    pub fn new(
        planner: &'a Planner<'a>,
        phases: &'a [Phase],
        settings: &'a Settings,
        grid: Grid,
    ) -> Self {
        Self {
            planner,
            phases,
            settings,
            grid,
            manner: Manner::Swift,
        }
    }

    /// The same from guesses that go on from keyframes.
    pub fn further(&self) -> Self {
        Self {
            manner: Manner::Further,
            ..*self
        }
    }

    /// Solves from a guess from the sequence alone, then, unless that ended hopelessly far from satisfying the contacts, from one with
    /// objects the other way round where they share a support and from one that was solved boundary by boundary, at last from the
    /// first and the third with short steps, no pull to the home posture at the end and, if clearances resist, with those of all
    /// that is near the guess from the beginning: once a link is inside something, its row may lead out on the wrong side.
    pub(super) fn answer(&self) -> Keyframes {
        let (best, rows, guesses) = self.attempts();
        self.carefully(best, rows, guesses)
    }

    /// The last attempts: short steps from every guess, `rows` says with the clearances of what is near, until one succeeds.
    pub(super) fn carefully(
        &self,
        mut best: Keyframes,
        rows: bool,
        guesses: Vec<Vec<Vec<f64>>>,
    ) -> Keyframes {
        let mut settings = self.settings.clone();
        settings.weights.final_posture = settings.weights.posture;
        let careful = Ask {
            manner: Manner::Careful,
            settings: &settings,
            ..*self
        };
        for nodes in guesses {
            if best.possible {
                break;
            }
            let near = if rows {
                self.near(&nodes, GUESS_NEAR)
            } else {
                Watched::new()
            };
            best = less_violated(best, careful.solve(nodes, near).0);
        }
        best
    }

    /// A guess from the sequence alone.
    pub(super) fn guess(&self) -> Vec<Vec<f64>> {
        self.guess_in(self.settings.arrangement)
    }

    fn guess_in(&self, arrangement: Arrangement) -> Vec<Vec<f64>> {
        let mut guess = self.planner.guess_after(&[], self.phases, arrangement);
        if self.grid == Grid::Keyframes {
            self.planner.lead_to_goal(&mut guess, self.phases, 0);
        }
        guess
    }

    /// The result from a guess with the objects the other way round where they share a support, if that is another one and
    /// satisfies everything.
    fn other_way_round(&self, guess: impl Fn(Arrangement) -> Vec<Vec<f64>>) -> Option<Keyframes> {
        let settings = Settings {
            arrangement: Arrangement::EarlierBeside,
            ..self.settings.clone()
        };
        let other = Ask {
            settings: &settings,
            ..*self
        };
        let nodes = guess(settings.arrangement);
        if nodes == guess(self.settings.arrangement) {
            return None;
        }
        let near = other.near(&nodes, NEAR);
        let found = other.solve(nodes, near).0;
        found.possible.then_some(found)
    }

    /// The first attempts: the less violated result, whether clearances resist, and guesses for further attempts.
    pub(super) fn attempts(&self) -> (Keyframes, bool, Vec<Vec<Vec<f64>>>) {
        let guess = self.guess();
        let (first, first_rows) = self.solve(guess.clone(), Watched::new());
        if first.possible || first.is_hopeless() {
            return (first, false, vec![]);
        }
        let from_nothing = |arrangement| self.guess_in(arrangement);
        if let Some(found) = self.other_way_round(from_nothing) {
            return (found, false, vec![]);
        }
        let (forward, watched) = self.forward(guess.clone());
        let (second, second_rows) = self.solve(forward.clone(), watched);
        let resist = !first_rows.is_empty() || !second_rows.is_empty();
        (less_violated(first, second), resist, vec![guess, forward])
    }

    /// Solves from keyframes of the first phases, then from another guess, if there is one, then from one from the sequence alone, the
    /// first and the last with objects the other way round too, then, for few phases and unless these ended far from satisfying
    /// everything, from one solved boundary by boundary if clearances resist, and from the first and the last with short steps.
    pub(super) fn answer_after(
        &self,
        known: &[Vec<f64>],
        another: &mut dyn FnMut() -> Option<Vec<Vec<f64>>>,
    ) -> Keyframes {
        let (planner, phases) = (self.planner, self.phases);
        let after = planner.guess_after(known, phases, self.settings.arrangement);
        let further = self.further();
        let (from_known, known_rows) = further.solve(after.clone(), self.near(&after, NEAR));
        if from_known.possible {
            return from_known;
        }
        let guess_after = |arrangement| planner.guess_after(known, phases, arrangement);
        if let Some(found) = further.other_way_round(guess_after) {
            return found;
        }
        if let Some(from_another) = another().and_then(|nodes| self.answer_near(nodes)) {
            return from_another;
        }
        let guess = self.guess();
        let (first, first_rows) = self.solve(guess.clone(), Watched::new());
        if first.possible || first.is_hopeless() {
            return first;
        }
        let from_nothing = |arrangement| self.guess_in(arrangement);
        if let Some(found) = self.other_way_round(from_nothing) {
            return found;
        }
        let rows = !known_rows.is_empty() || !first_rows.is_empty();
        let best = less_violated(from_known, first);
        if best.report.violation > FAR || phases.len() > CAREFUL_PHASES {
            return best;
        }
        let best = if rows {
            let (forward, watched) = self.forward(guess.clone());
            less_violated(best, self.solve(forward, watched).0)
        } else {
            best
        };
        self.carefully(best, rows, vec![after, guess])
    }

    /// From keyframes that should satisfy everything: others near them, with less strain, or they themselves; with less clearance
    /// if they have no more; `None` if they do not.
    pub(super) fn answer_near(&self, nodes: Vec<Vec<f64>>) -> Option<Keyframes> {
        let with_clearances = self.answer_near_at_once(nodes.clone());
        with_clearances.or_else(|| {
            let settings = self.without_margins();
            let outside = Ask {
                settings: &settings,
                ..*self
            };
            outside.answer_near_at_once(nodes)
        })
    }

    fn answer_near_at_once(&self, nodes: Vec<Vec<f64>>) -> Option<Keyframes> {
        let near = self.near(&nodes, NEAR);
        let known = Ask {
            manner: Manner::Known,
            ..*self
        };
        let found = known.solve(nodes.clone(), near.clone()).0;
        if found.possible {
            return Some(found);
        }
        let mut trajectory = Trajectory::new(self.first_program(&nodes, &near));
        let point = guess::point(&trajectory.program, self.planner.scene, nodes);
        let report = report_at(&mut trajectory, &point);
        (report.violation <= KEYFRAME_TOLERANCE).then(|| Keyframes {
            violated: vec![],
            pulls: vec![],
            worst: worst_row(&trajectory.program, &report, 1e-7),
            nodes: point.nodes,
            possible: true,
            iterations: found.iterations,
            report,
        })
    }

    /// Rows of all that is nearer than `distance` [m] at these configurations of the first nodes.
    pub(super) fn near(&self, nodes: &[Vec<f64>], distance: f64) -> Watched {
        let Planner {
            scene, collisions, ..
        } = self.planner;
        let mut watched = Watched::new();
        if self.settings.preset == Preset::Default {
            let program = self.first_program(nodes, &watched);
            collisions.watch(&program, scene, self.phases, nodes, distance, &mut watched);
        }
        watched
    }

    /// The answer from another first configuration than the scene's start; `None` if it is no.
    pub fn answer_from(&self, first: &[f64]) -> Option<Keyframes> {
        let start = std::iter::once(first.to_vec());
        let nodes = start
            .chain(self.phases.iter().map(|_| first.to_vec()))
            .collect();
        let (nodes, watched) = self.forward(nodes);
        let found = self.solve(nodes, watched).0;
        found.possible.then_some(found)
    }

    /// A guess from solving a few phases at a time, each time from the first boundary of the time before.
    fn forward(&self, mut nodes: Vec<Vec<f64>>) -> (Vec<Vec<f64>>, Watched) {
        let n = self.phases.len();
        let mut watched = Watched::new();
        for k in 0..n {
            let end = (k + WINDOW).min(n);
            let grid = if end == n {
                self.grid
            } else {
                Grid::OpenKeyframes
            };
            let part = Ask {
                phases: &self.phases[k..end],
                grid,
                ..*self
            };
            let (found, rows) = part.solve(nodes[k..=end].to_vec(), Watched::new());
            nodes[k..=end].clone_from_slice(&found.nodes);
            watched.extend(rows.iter().map(|&(t, row)| (t + k, row)));
            if end == n {
                break;
            }
        }
        (nodes, watched)
    }

    /// Solves so that nothing is inside another, then from there with the clearances that are demanded of it: at once they lead into
    /// more local minima. Where that leads nowhere the first result stands: a motion may find room. From guesses that go on from
    /// keyframes it is done the other way round. With the clearances of some pairs (none at first), then with those too that turn out
    /// to be violated; says which these were.
    pub(super) fn solve(&self, nodes: Vec<Vec<f64>>, watched: Watched) -> (Keyframes, Watched) {
        let alone = self.grid == Grid::State || self.settings.preset == Preset::Paper;
        let margins = &self.settings.margins;
        let demands_none = margins.clearance.max(margins.self_clearance) <= 0.0;
        if alone || demands_none || self.manner == Manner::Known {
            return self.solve_at_once(nodes, watched);
        }
        if self.manner == Manner::Further {
            let (apart, rows) = self.solve_at_once(nodes.clone(), watched.clone());
            return if apart.possible {
                (apart, rows)
            } else {
                self.solve_outside(nodes, watched)
            };
        }
        let (outside, apart, watched) = self.solve_in_two(nodes, watched);
        let apart = apart.filter(|apart| apart.possible);
        (apart.unwrap_or(outside), watched)
    }

    /// The same where no more than the clearances that are demanded will do.
    pub(super) fn solve_apart(&self, nodes: Vec<Vec<f64>>, watched: Watched) -> Keyframes {
        let (outside, apart, _) = self.solve_in_two(nodes, watched);
        apart.unwrap_or(outside)
    }

    /// With nothing inside another, then, if that is possible, with the clearances that are demanded.
    fn solve_in_two(
        &self,
        nodes: Vec<Vec<f64>>,
        watched: Watched,
    ) -> (Keyframes, Option<Keyframes>, Watched) {
        let (outside, watched) = self.solve_outside(nodes, watched);
        if !outside.possible {
            return (outside, None, watched);
        }
        let (mut apart, watched) = self.solve_at_once(outside.nodes.clone(), watched);
        apart.iterations += outside.iterations;
        (outside, Some(apart), watched)
    }

    fn solve_outside(&self, nodes: Vec<Vec<f64>>, watched: Watched) -> (Keyframes, Watched) {
        let settings = self.without_margins();
        let outside = Ask {
            settings: &settings,
            ..*self
        };
        outside.solve_at_once(nodes, watched)
    }

    /// The settings with which nothing need be further from another than outside it, objects from one another aside.
    fn without_margins(&self) -> Settings {
        let mut settings = self.settings.clone();
        settings.objects_apart = settings.objects_apart.max(settings.margins.clearance);
        (settings.margins.clearance, settings.margins.self_clearance) = (0.0, 0.0);
        settings
    }

    fn solve_at_once(&self, nodes: Vec<Vec<f64>>, mut watched: Watched) -> (Keyframes, Watched) {
        let planner = self.planner;
        let watches = self.settings.preset == Preset::Default;
        if watches && self.grid != Grid::State {
            let (scene, system) = (planner.scene, &planner.system);
            let model = &planner.collisions;
            model.watch_objects(scene, system, self.phases, &mut watched);
        }
        let mut program = self.first_program(&nodes, &watched);
        let around = planner.ways_of(self.phases).around(&nodes);
        if watches && self.grid != Grid::State && around.contains(&true) {
            let (scene, model, around) = (planner.scene, &planner.collisions, (&*around, BESIDE));
            model.watch_static(&program, scene, self.phases, &nodes, around, &mut watched);
            program = self.first_program(&nodes, &watched);
        }
        let mut point = guess::point(&program, planner.scene, nodes);
        let mut iterations = 0;
        for round in 0.. {
            let mut trajectory = Trajectory::new(program);
            let structure = trajectory.structure().clone();
            let mut stagnation = if self.settings.hurries {
                Stagnation::default()
            } else {
                Stagnation::of_keyframes()
            };
            let report = InteriorPoint::new(&structure).solve(
                &mut trajectory,
                &mut point,
                &self.options(),
                None,
                &mut |i| self.manner == Manner::Known || stagnation.goes_on(i),
            );
            iterations += report.iterations;
            let possible = report.violation <= KEYFRAME_TOLERANCE;
            let solved = &trajectory.program;
            let (scene, phases, model) = (planner.scene, self.phases, &planner.collisions);
            if watches
                && possible
                && round < ROUNDS
                && model.watch(solved, scene, phases, &point.nodes, NEAR, &mut watched)
            {
                let clearances = Clearances::Watched(&watched);
                program = planner.program(phases, self.settings, self.grid, clearances);
                continue;
            }
            let (violated, pulls) = if possible {
                (vec![], vec![])
            } else {
                (violations(solved, &report, 1e-5), pulls(solved, &report))
            };
            let keyframes = Keyframes {
                violated,
                pulls,
                worst: worst_row(solved, &report, 1e-7),
                nodes: point.nodes,
                possible,
                report,
                iterations,
            };
            return (keyframes, watched);
        }
        unreachable!("the loop returns in its last round")
    }

    fn options(&self) -> Options {
        let lone = self.grid == Grid::State;
        let optimality = if lone { f64::INFINITY } else { 1e-2 };
        let swift = Options {
            initial_barrier: 1e-3,
            first_damping: 1.0,
            tightening: 0.8,
            ..Options::default()
        };
        let manner = match self.manner {
            Manner::Swift | Manner::Further => swift,
            Manner::Careful | Manner::Known => Options::default(),
        };
        Options {
            max_iterations: match self.manner {
                Manner::Known => MOST_KNOWN,
                _ if self.settings.hurries => MOST_HURRIED,
                _ => MOST,
            },
            stall_iterations: 25, // cheap, and to refuse a possible sequence is expensive
            feasibility_tolerance: if lone { 0.5 * KEYFRAME_TOLERANCE } else { 1e-6 },
            dual_tolerance: optimality,
            complementarity_tolerance: optimality,
            min_barrier: 1e-6,
            enough: (self.manner == Manner::Known).then_some(RANKED),
            refinements: REFINEMENTS,
            convexification: Convexification::Shift,
            keeps_filter: true, // without it a beginning of `climb/carry` ends in a local minimum
            ..manner
        }
    }

    /// With the preset `paper` the penalties of what is near the guess make it avoid obstacles.
    fn first_program(&self, nodes: &[Vec<f64>], watched: &Watched) -> Program {
        let none = Crossings::new();
        let clearances = if self.settings.preset == Preset::Paper && self.grid != Grid::State {
            near(nodes, &none)
        } else {
            Clearances::Watched(watched)
        };
        self.planner
            .program(self.phases, self.settings, self.grid, clearances)
    }
}

pub(super) fn less_violated(a: Keyframes, b: Keyframes) -> Keyframes {
    if b.possible || b.report.violation < a.report.violation {
        b
    } else {
        a
    }
}
