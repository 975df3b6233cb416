//! A motion as the start of a relative: a sequence with the same beginning, or the same sequence in a scene that differs a
//! little.
//!
//! Phases that both share keep configurations, wrenches and durations. Where the sequences part, the last shared phase is
//! planned anew, since it leads elsewhere: keyframes from its first configuration, a path, the first guess for the rest. If
//! all phases are shared, the multipliers are kept too, which makes a smaller first barrier parameter pay.

use crate::collision::Crossings;
use crate::guess;
use crate::keyframes::Ask;
use crate::motion::{Motion, Planner, near};
use crate::point::Point;
use crate::program::{Grid, Phase, Program, RowLabel};
use crate::rounds::First;
use crate::settings::Settings;
use solver::{Norm, Options, Report};
use symbolic::ContactState;

/// Iterations after which a round from a relative has failed: the cold start is better then.
const MOST_ITERATIONS: usize = 60;
/// Change of a coordinate of an object at rest [m].
const AT_REST: f64 = 1e-4;

/// Solver options of the first round (benches/runs/2026-11-21-keyframes.md); `whole` if all phases are shared.
fn options(whole: bool) -> Options {
    Options {
        initial_barrier: if whole { 1e-4 } else { 1e-3 },
        bound_push: if whole { 1e-4 } else { 1e-3 },
        first_damping: 1.0,
        tightening: 0.8,
        norm: Norm::Euclidean,
        ..Options::default()
    }
}

/// What a motion leaves to its relatives.
#[derive(Debug, Clone)]
pub struct Relative {
    phases: Vec<Phase>,
    point: Point,
    /// Labels and multipliers of the rows of every interval.
    rows: Vec<Vec<(RowLabel, f64)>>,
}

impl Motion {
    /// What this motion leaves to its relatives.
    pub fn relative(&self) -> Relative {
        let program = &self.trajectory.program;
        let mut first = 0;
        let phase = |&steps: &usize| {
            let forces = &program.intervals[first].forces;
            first += steps;
            let state: ContactState = forces.iter().map(|f| f.contact).collect();
            Phase { state, steps }
        };
        Relative {
            phases: program.steps.iter().map(phase).collect(),
            point: self.point.clone(),
            rows: rows(program, &self.report),
        }
    }
}

fn rows(program: &Program, report: &Report) -> Vec<Vec<(RowLabel, f64)>> {
    let mut all = program
        .labels
        .iter()
        .cloned()
        .zip(report.multipliers.iter().copied());
    let elements = program.structure.elements.iter();
    elements
        .map(|e| all.by_ref().take(e.n_rows()).collect())
        .collect()
}

impl Relative {
    /// Number of phases with which both begin.
    pub fn shared_phases(&self, phases: &[Phase]) -> usize {
        let pairs = self.phases.iter().zip(phases);
        pairs.take_while(|(a, b)| a == b).count()
    }

    /// Puts the shared phases' wrenches, durations and velocities, where these are unknowns, into a point.
    fn fill(&self, kept: usize, point: &mut Point) {
        let n: usize = self.phases[..kept].iter().map(|p| p.steps).sum();
        if !self.point.velocities.is_empty() && !point.velocities.is_empty() {
            point.velocities[..n].clone_from_slice(&self.point.velocities[..n]);
        }
        point.wrenches[..n].clone_from_slice(&self.point.wrenches[..n]);
        point.durations[..kept].copy_from_slice(&self.point.durations[..kept]);
    }

    /// Multipliers for the rows of a program with the same phases: those of rows with the same label, zero for others.
    fn multipliers(&self, program: &Program) -> Vec<f64> {
        multipliers(&self.rows, program)
    }
}

fn multipliers(known: &[Vec<(RowLabel, f64)>], program: &Program) -> Vec<f64> {
    let mut out = vec![0.0; program.labels.len()];
    let mut first = 0;
    for (rows, element) in known.iter().zip(&program.structure.elements) {
        let labels = &program.labels[first..first + element.n_rows()];
        transfer(rows, labels, &mut out[first..]);
        first += element.n_rows();
    }
    out
}

impl First {
    /// From the solution of a program that lacks some rows of this one.
    pub(crate) fn after(solved: &Program, report: &Report, program: &Program) -> Self {
        Self {
            options: options(true),
            multipliers: Some(multipliers(&rows(solved, report), program)),
            max_iterations: usize::MAX,
        }
    }
}

/// Copies the multipliers of equal labels, in their order.
fn transfer(from: &[(RowLabel, f64)], labels: &[RowLabel], out: &mut [f64]) {
    let mut used = vec![false; from.len()];
    let mut next = 0;
    for (label, y) in labels.iter().zip(out) {
        let order = (next..from.len()).chain(0..next);
        let same = |i: &usize| {
            let other = &from[*i].0;
            !used[*i] && other.category == label.category && other.subject == label.subject
        };
        if let Some(i) = order.into_iter().find(same) {
            *y = from[i].1;
            used[i] = true;
            next = i + 1;
        }
    }
}

impl Planner<'_> {
    /// The start of a motion from a relative; `None` if they share too little or the rest has no keyframes from there.
    pub(crate) fn start_from(
        &self,
        phases: &[Phase],
        settings: &Settings,
        relative: &Relative,
    ) -> Option<(Program, Point, First)> {
        let shared = relative.shared_phases(phases);
        let whole = shared == phases.len() && shared == relative.phases.len();
        let kept = if whole {
            shared
        } else {
            shared.checked_sub(1)?
        };
        let same_size = relative.point.nodes[0].len() == self.system.model.nq;
        if kept == 0 || !same_size {
            return None;
        }
        let n: usize = phases[..kept].iter().map(|p| p.steps).sum();
        let mut nodes = relative.point.nodes[..=n].to_vec();
        self.put_at_start(&mut nodes);
        if !whole {
            let keyframes = Ask::new(self, &phases[kept..], settings, Grid::Keyframes)
                .answer_from(&nodes[n])?;
            let rest = self.guide(&phases[kept..], settings, &keyframes.nodes);
            nodes.truncate(n);
            nodes.extend(rest);
        }
        let none = Crossings::new();
        let program = self.program(phases, settings, Grid::Motion, near(&nodes, &none));
        let mut point = guess::point(&program, self.scene, nodes);
        relative.fill(kept, &mut point);
        let first = First {
            options: options(whole),
            multipliers: whole.then(|| relative.multipliers(&program)),
            max_iterations: MOST_ITERATIONS,
        };
        Some((program, point, first))
    }

    /// The scene's own start at the first two nodes; what has not moved yet stays where it starts.
    fn put_at_start(&self, nodes: &mut [Vec<f64>]) {
        let (old, new) = (nodes[0].clone(), self.system.start(self.scene));
        for o in 0..self.scene.objects.len() {
            let first = self.system.object_q(o);
            let at = first..first + 7;
            for q in nodes.iter_mut() {
                let away = q[at.clone()]
                    .iter()
                    .zip(&old[at.clone()])
                    .any(|(a, b)| (a - b).abs() > AT_REST);
                if away {
                    break;
                }
                q[at.clone()].copy_from_slice(&new[at.clone()]);
            }
        }
        for q in nodes.iter_mut().take(2) {
            q.copy_from_slice(&new);
        }
    }
}
