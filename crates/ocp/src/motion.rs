//! From keyframes to a motion: trajectory, repair of missed collision pairs and of collisions between nodes.

use crate::collision::{Clearances, CollisionModel, Crossings};
use crate::guess;
use crate::point::Point;
use crate::problem::Trajectory;
use crate::program::{Grid, Phase, Program};
use crate::relative_motion::Relative;
use crate::resistance::{Worst, hardest_limit, worst_row};
use crate::rounds::First;
use crate::settings::{Ending, NEARLY_SOLVED, Settings};
use crate::system::System;
use crate::ways::Ways;
use scene::Scene;
use solver::{ElementData, InteriorPoint, Iteration, Problem, Report, Status, Structure, Timing};

/// Rounds of solving with more rows for what collides.
const REPAIRS: usize = 4;
/// Violation of a clearance that had no row which is tolerated [m]: a small part of every margin.
pub(crate) const NEW_TOLERANCE: f64 = 1e-3;
/// The same after the last round [m]: less than half of every margin, which a finer grid regains.
const MISSED_TOLERANCE: f64 = 1e-2;
/// Violation of such a clearance from which the last solution is no better a start than a coarser grid's motion [m].
const FAR_OFF: f64 = 0.02;
/// Largest violation of a solution (scaled rows).
pub(crate) const SOLVED: f64 = 1e-6;

/// A motion.
pub struct Motion {
    /// The program it solves, with scratch.
    pub trajectory: Trajectory,
    /// The point.
    pub point: Point,
    /// The solver's report of the last round.
    pub report: Report,
    /// Iterations of all rounds.
    pub iterations: usize,
    /// Solver time of all rounds [s].
    pub seconds: f64,
    /// The same, part by part.
    pub timing: Timing,
    /// True if every row holds.
    pub feasible: bool,
    /// What is violated most, if anything is.
    pub worst: Option<Worst>,
    /// The limit that pulls hardest against what is violated: the inequality with the largest multiplier.
    pub hardest: Option<Worst>,
}

/// What all rounds took.
#[derive(Clone, Copy, Default)]
struct Work {
    iterations: usize,
    seconds: f64,
    timing: Timing,
}

impl Work {
    fn add(&mut self, report: &Report) {
        self.iterations += report.iterations;
        self.seconds += report.timing.total.as_secs_f64();
        self.timing += report.timing;
    }
}

impl Motion {
    /// True if it is feasible or misses so little that a finer grid may have a feasible one.
    pub fn is_nearly_feasible(&self) -> bool {
        let ended = self.report.status != Status::Interrupted;
        self.feasible || (ended && self.report.violation <= NEARLY_SOLVED)
    }

    /// Counts the work of another attempt too.
    pub fn add_work(&mut self, other: &Self) {
        self.iterations += other.iterations;
        self.seconds += other.seconds;
        self.timing += other.timing;
    }

    fn new(
        trajectory: Trajectory,
        point: Point,
        report: Report,
        work: Work,
        feasible: bool,
        worst: Option<Worst>,
    ) -> Self {
        let hardest = hardest_limit(&trajectory.program, &report).filter(|_| !feasible);
        Self {
            trajectory,
            point,
            report,
            iterations: work.iterations,
            seconds: work.seconds,
            timing: work.timing,
            feasible,
            worst,
            hardest,
        }
    }
}

/// What a planner needs for one scene, made once.
pub struct Planner<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Robot and objects as one model.
    pub system: System,
    /// Balls and obstacles.
    pub collisions: CollisionModel,
    /// Ways of the base around what stands.
    pub ways: Ways,
}

impl<'a> Planner<'a> {
    /// Prepares a scene.
    ///
    /// # Errors
    /// If robot and objects do not make a model.
    pub fn new(scene: &'a Scene) -> Result<Self, multibody::ModelError> {
        let system = System::new(scene)?;
        let collisions = CollisionModel::new(scene, &system);
        Ok(Self {
            scene,
            system,
            collisions,
            ways: Ways::new(scene),
        })
    }

    /// Optimises the motion of a sequence from its keyframes; `observe` sees every iteration and may stop it.
    pub fn motion(
        &self,
        phases: &[Phase],
        settings: &Settings,
        keyframes: &[Vec<f64>],
        observe: &mut dyn FnMut(&Iteration) -> bool,
    ) -> Motion {
        let nodes = self.guide(phases, settings, keyframes);
        let none = Crossings::new();
        let program = self.program(phases, settings, Grid::Motion, near(&nodes, &none));
        let point = guess::point(&program, self.scene, nodes);
        let first = First::guessed(&program);
        self.optimise(phases, program, point, first, observe)
    }

    /// The same from a relative ([`Motion::relative`]) if that leads to a motion; `None` if it does not, or if the two share
    /// too little.
    pub fn motion_from(
        &self,
        phases: &[Phase],
        settings: &Settings,
        relative: &Relative,
        observe: &mut dyn FnMut(&Iteration) -> bool,
    ) -> Option<Motion> {
        let (program, point, first) = self.start_from(phases, settings, relative)?;
        let motion = self.optimise(phases, program, point, first, observe);
        let found = match settings.ending {
            Ending::Rough => motion.is_nearly_feasible(),
            Ending::Exact | Ending::Good => motion.feasible,
        };
        let ended = found || motion.report.status == Status::Interrupted;
        ended.then_some(motion)
    }

    /// Optimises the motion of a sequence from a motion of the same contacts and intervals in a scene that differs in numbers.
    pub fn motion_near(
        &self,
        phases: &[Phase],
        settings: &Settings,
        relative: &Motion,
        observe: &mut dyn FnMut(&Iteration) -> bool,
    ) -> Motion {
        let none = Crossings::new();
        let mut point = relative.point.clone();
        let program = self.program(phases, settings, Grid::Motion, near(&point.nodes, &none));
        let intervals = program.intervals.iter();
        let pairs = intervals.zip(&relative.trajectory.program.intervals);
        for ((now, before), wrench) in pairs.zip(&mut point.wrenches) {
            for (force, known) in now.forces.iter().zip(&before.forces) {
                for i in 0..force.n {
                    wrench[force.first + i] *= known.scale[i] / force.scale[i];
                }
            }
        }
        self.optimise(phases, program, point, First::near_solution(), observe)
    }

    /// A motion that is known: values at its point, no multipliers. Whether it is feasible is judged with the clearances that
    /// its nodes come near.
    pub fn restore(&self, phases: &[Phase], settings: &Settings, point: Point) -> Motion {
        let none = Crossings::new();
        let program = self.program(phases, settings, Grid::Motion, near(&point.nodes, &none));
        let mut trajectory = Trajectory::new(program);
        let report = report_at(&mut trajectory, &point);
        let feasible = report.violation <= NEW_TOLERANCE;
        let worst = worst_row(&trajectory.program, &report, NEW_TOLERANCE);
        Motion::new(trajectory, point, report, Work::default(), feasible, worst)
    }

    /// Solves a program, again with more rows where the motion collides, at nodes or between them. If no motion near the first one
    /// obeys these, since something passed through something else, it begins once more with all of them.
    pub(crate) fn optimise(
        &self,
        phases: &[Phase],
        mut program: Program,
        mut point: Point,
        mut first: First,
        observe: &mut dyn FnMut(&Iteration) -> bool,
    ) -> Motion {
        let settings = &program.settings.clone();
        let mut crossings = Crossings::new();
        crossings.earlier.push(point.nodes.clone());
        let mut begin = Some((point.clone(), first.clone()));
        let mut work = Work::default();
        for round in 0.. {
            let mut trajectory = Trajectory::new(program);
            let structure = trajectory.structure().clone();
            let options = first.options_of_round(&trajectory.program, work.iterations);
            trajectory.settle(&mut point);
            let report = InteriorPoint::new(&structure).solve(
                &mut trajectory,
                &mut point,
                &options,
                first.multipliers.take().as_deref(),
                observe,
            );
            work.add(&report);
            // Where an acceptable end is one, so is another end within its tolerance.
            let nearly = options.acceptable_iterations > 0
                && report.violation <= options.acceptable_tolerance;
            let solved = nearly || report.violation <= SOLVED;
            let is_rough = settings.ending == Ending::Rough;
            let nearly_solved = solved || (is_rough && report.violation <= NEARLY_SOLVED);
            if nearly_solved && report.status != Status::Interrupted && round < REPAIRS {
                let between = settings.between
                    && self.collisions.find_crossings(
                        &trajectory.program,
                        self.scene,
                        phases,
                        &point.nodes,
                        &mut crossings,
                    );
                let again = self.program(
                    phases,
                    settings,
                    Grid::Motion,
                    near(&point.nodes, &crossings),
                );
                let new = violation_of(&again, &point);
                // What the rows that were there miss is no news.
                if between || new > NEW_TOLERANCE.max(2.0 * report.violation) {
                    let most = first.max_iterations;
                    first = if new > FAR_OFF {
                        First::far_off(&again)
                    } else {
                        First::after(&trajectory.program, &report, &again)
                    };
                    first.max_iterations = most;
                    crossings.earlier.push(point.nodes.clone());
                    program = again;
                    continue;
                }
            }
            let stuck = report.status != Status::Interrupted && !crossings.ways.is_empty();
            if let Some(begin) = begin.take_if(|_| stuck && !nearly_solved) {
                (point, first) = begin;
                let clearances = near(&point.nodes, &crossings);
                program = self.program(phases, settings, Grid::Motion, clearances);
                continue;
            }
            // Nobody has asked yet about what came near in the last round.
            let worst = if nearly_solved {
                self.missed(phases, settings, &point)
            } else {
                worst_row(&trajectory.program, &report, 1e-7)
            };
            let feasible = solved && worst.is_none();
            let of_solve = || worst_row(&trajectory.program, &report, SOLVED);
            let worst = worst.or_else(|| of_solve().filter(|_| !solved));
            return Motion::new(trajectory, point, report, work, feasible, worst);
        }
        unreachable!("the loop returns in its last round")
    }

    /// The most violated clearance of all that is near at the nodes; `None` if all nearly hold.
    fn missed(&self, phases: &[Phase], settings: &Settings, point: &Point) -> Option<Worst> {
        let none = Crossings::new();
        let program = self.program(phases, settings, Grid::Motion, near(&point.nodes, &none));
        let mut trajectory = Trajectory::new(program);
        let report = report_at(&mut trajectory, point);
        worst_row(&trajectory.program, &report, MISSED_TOLERANCE)
    }

    pub(crate) fn program(
        &self,
        phases: &[Phase],
        settings: &Settings,
        grid: Grid,
        clearances: Clearances<'_>,
    ) -> Program {
        Program::new(
            self.scene,
            &self.system,
            &self.collisions,
            phases,
            settings,
            grid,
            clearances,
        )
    }
}

/// The pairs that come near at these configurations, or cross one another between them.
pub(crate) fn near<'a>(nodes: &'a [Vec<f64>], crossings: &'a Crossings) -> Clearances<'a> {
    Clearances::Near { nodes, crossings }
}

/// Largest violation of a program's rows at a point (scaled).
fn violation_of(program: &Program, point: &Point) -> f64 {
    let mut trajectory = Trajectory::new(program.clone());
    let data = evaluate(&mut trajectory, point);
    largest_violation(&data, trajectory.structure())
}

/// What a solver would report of a point that it leaves as it is: no multipliers.
pub(crate) fn report_at(trajectory: &mut Trajectory, point: &Point) -> Report {
    let data = evaluate(trajectory, point);
    let structure = trajectory.structure();
    let rows: Vec<f64> = data.iter().flat_map(|d| d.values.iter().copied()).collect();
    Report {
        status: Status::Solved,
        iterations: 0,
        objective: data.iter().map(|d| d.objective).sum(),
        violation: largest_violation(&data, structure),
        dual: 0.0,
        multipliers: vec![0.0; rows.len()],
        bound_multipliers: vec![0.0; structure.n_vars],
        rows,
        factorisations: 0,
        timing: Timing::default(),
    }
}

/// Values of all elements at a point.
fn evaluate(trajectory: &mut Trajectory, point: &Point) -> Vec<ElementData> {
    let elements = trajectory.structure().elements.iter();
    let mut data: Vec<_> = elements.map(ElementData::of_values).collect();
    trajectory.evaluate(point, &mut data);
    data
}

/// Largest violation of the rows' bounds (scaled).
fn largest_violation(data: &[ElementData], structure: &Structure) -> f64 {
    let mut most = 0.0_f64;
    for (data, element) in data.iter().zip(&structure.elements) {
        let bounds = element.row_lower.iter().zip(&element.row_upper);
        for (value, (lower, upper)) in data.values.iter().zip(bounds) {
            most = most.max(lower - value).max(value - upper);
        }
    }
    most
}
