//! Every derivative of the assembled program against central differences of its values.

use crate::scenes::{of_phases, program, program_with};
use ocp::{CostTerm, Grid, Integrator, Point, Preset, Stage, Trajectory};
use solver::{ElementData, Problem};
use spatial::Random;

struct Evaluation {
    objective: f64,
    rows: Vec<f64>,
}

fn evaluate(trajectory: &mut Trajectory, x: &Point) -> Evaluation {
    let mut data: Vec<_> = trajectory
        .structure()
        .elements
        .iter()
        .map(ElementData::new)
        .collect();
    trajectory.evaluate(x, &mut data);
    Evaluation {
        objective: data.iter().map(|d| d.objective).sum(),
        rows: data.iter().flat_map(|d| d.values.iter().copied()).collect(),
    }
}

/// Every entry that counts is a number.
fn assert_written(data: &[ElementData]) {
    for (t, d) in data.iter().enumerate() {
        let n = d.gradient.len();
        assert!(
            (0..n).all(|j| d.hessian[j * n..][j..n].iter().all(|h| h.is_finite())),
            "element {t}: Hessian has unwritten entries"
        );
        assert!(
            d.jacobians.iter().flatten().all(|h| h.is_finite()),
            "element {t}: Jacobian has unwritten entries"
        );
    }
}

fn check(seed: u64, grid: Grid, preset: Preset) {
    check_program(seed, program(seed, grid, preset));
}

fn check_program(seed: u64, (mut trajectory, x): (Trajectory, Point)) {
    let structure = trajectory.structure().clone();
    let mut data: Vec<_> = structure.elements.iter().map(ElementData::new).collect();
    let mut random = Random::new(seed + 77);
    let n_rows: usize = structure
        .elements
        .iter()
        .map(solver::ElementStructure::n_rows)
        .sum();
    let y: Vec<f64> = (0..n_rows).map(|_| random.uniform(-1.0, 1.0)).collect();
    trajectory.linearise(&x, &y, &mut data);
    assert_written(&data);
    for trial in 0..400 {
        // A direction over one, two or all variables.
        let mut direction = vec![0.0; structure.n_vars];
        if trial < 8 {
            for d in &mut direction {
                *d = random.uniform(-1.0, 1.0);
            }
        } else {
            let e = random.index(structure.elements.len());
            let vars = &structure.elements[e].vars;
            for _ in 0..=trial % 2 {
                direction[vars[random.index(vars.len())]] = random.uniform(0.5, 1.0);
            }
        }
        if let Some(still) = trajectory.program.still_var {
            direction[still] = 0.0;
        }
        let mut at = |s: f64| {
            let mut moved = x.clone();
            trajectory.retract(&x, &direction, s, &mut moved);
            evaluate(&mut trajectory, &moved)
        };
        let h = 1e-4; // small beside the evenness of clearances
        let (p1, p2, m1, m2, zero) = (at(h), at(2.0 * h), at(-h), at(-2.0 * h), at(0.0));
        let first = |f: &dyn Fn(&Evaluation) -> f64| {
            (8.0 * (f(&p1) - f(&m1)) - f(&p2) + f(&m2)) / (12.0 * h)
        };
        let lagrangian =
            |e: &Evaluation| e.objective + e.rows.iter().zip(&y).map(|(c, y)| c * y).sum::<f64>();
        let second = (-lagrangian(&p2) + 16.0 * lagrangian(&p1) - 30.0 * lagrangian(&zero)
            + 16.0 * lagrangian(&m1)
            - lagrangian(&m2))
            / (12.0 * h * h);
        // Gradient, rows and Hessian along the direction.
        let (mut slope, mut curvature) = (0.0, 0.0);
        let mut row = 0;
        for (e, d) in structure.elements.iter().zip(&data) {
            let n = e.vars.len();
            let local: Vec<f64> = e.vars.iter().map(|&v| direction[v]).collect();
            slope += d
                .gradient
                .iter()
                .zip(&local)
                .map(|(g, x)| g * x)
                .sum::<f64>();
            for j in 0..n {
                for i in j..n {
                    let twice = if i == j { 1.0 } else { 2.0 };
                    curvature += twice * d.hessian[j * n + i] * local[i] * local[j];
                }
            }
            for (block, jacobian) in e.blocks.iter().zip(&d.jacobians) {
                for r in 0..block.n_rows {
                    let analytic: f64 = (0..block.cols.len())
                        .map(|c| jacobian[c * block.n_rows + r] * local[block.cols[c]])
                        .sum();
                    let index = row + block.first_row + r;
                    let numeric = first(&|e: &Evaluation| e.rows[index]);
                    let label = &trajectory.program.labels[index];
                    assert!(
                        (analytic - numeric).abs() < 1e-5 * (1.0 + analytic.abs()),
                        "seed {seed}, trial {trial}, {label:?}: {analytic} analytic, {numeric} by differences"
                    );
                }
            }
            row += e.n_rows();
        }
        let numeric = first(&|e: &Evaluation| e.objective);
        assert!(
            (slope - numeric).abs() < 1e-6 * (1.0 + slope.abs()),
            "trial {trial}: slope {slope}, {numeric}"
        );
        assert!(
            (curvature - second).abs() < 1e-4 * (10.0 + curvature.abs()),
            "seed {seed}, trial {trial}: curvature {curvature} analytic, {second} by differences; variables {:?}",
            direction
                .iter()
                .enumerate()
                .filter(|(_, d)| **d != 0.0)
                .map(|(i, _)| i)
                .take(4)
                .collect::<Vec<_>>()
        );
    }
}

#[test]
fn the_motion_program_matches_central_differences() {
    for seed in 0..4 {
        check(seed, Grid::Motion, Preset::Default);
    }
}

#[test]
fn programs_with_velocities_as_unknowns_match_central_differences() {
    for integrator in [
        Integrator::SemiImplicitEuler,
        Integrator::ConstantAcceleration,
    ] {
        for seed in 0..3 {
            let program = program_with(seed, Grid::Motion, Preset::Default, integrator);
            let labels = &program.0.program.labels;
            assert!(labels.iter().any(|l| l.category == "integrator"));
            assert!(labels.iter().any(|l| l.category == "contact velocity"));
            assert!(labels.iter().any(|l| l.category == "landing speed"));
            assert!(labels.iter().any(|l| l.category == "torque at speed"));
            check_program(seed, program);
        }
    }
}

#[test]
fn programs_with_landings_on_fine_grids_match_central_differences() {
    for seed in 0..3 {
        let integrator = Integrator::ConstantAcceleration;
        let program = of_phases(seed, Grid::Motion, Preset::Default, integrator, true);
        let around = program
            .0
            .program
            .intervals
            .iter()
            .filter(|i| i.stage == Stage::Landing);
        assert_eq!(around.count(), 5, "the first two phases");
        check_program(seed, program);
    }
}

#[test]
fn the_terms_of_the_cost_are_the_objective() {
    let mut seen = Vec::new();
    let cases = [
        (Grid::Motion, Preset::Default, Integrator::Euler),
        (
            Grid::Motion,
            Preset::Default,
            Integrator::ConstantAcceleration,
        ),
        (Grid::Motion, Preset::Paper, Integrator::Euler),
        (Grid::Path, Preset::Default, Integrator::Euler),
    ];
    for (grid, preset, integrator) in cases {
        let (mut trajectory, x) = program_with(1, grid, preset, integrator);
        let objective = evaluate(&mut trajectory, &x).objective;
        let mut sum = 0.0;
        for t in 0..trajectory.program.n_intervals() {
            let costs = trajectory.cost_terms(&x, t);
            sum += costs.sum;
            let terms = CostTerm::ALL.map(|term| costs.of(term));
            let difference = terms.iter().sum::<f64>() - costs.sum;
            assert!(difference.abs() < 1e-12 * (1.0 + costs.sum.abs()));
            seen.extend((CostTerm::ALL.into_iter()).filter(|term| costs.of(*term) != 0.0));
        }
        assert_eq!(sum, objective, "{grid:?}, {preset:?}, {integrator:?}");
    }
    for term in [CostTerm::Tilt, CostTerm::FinalPosture, CostTerm::ForceRate] {
        assert!(seen.contains(&term), "{term:?}");
    }
}

#[test]
fn the_curvature_of_the_rows_is_scaled_between_that_of_the_lagrangian_and_that_of_the_objective() {
    let euler = Integrator::Euler;
    let cases = [
        (Grid::Motion, Preset::Default, euler),
        (
            Grid::Motion,
            Preset::Default,
            Integrator::ConstantAcceleration,
        ),
        (Grid::Motion, Preset::Paper, euler),
        (Grid::Path, Preset::Default, euler),
        (Grid::Keyframes, Preset::Default, euler),
    ];
    for (grid, preset, integrator) in cases {
        let (mut trajectory, x) = program_with(2, grid, preset, integrator);
        let elements = &trajectory.structure().elements;
        let mut data: Vec<_> = elements.iter().map(ElementData::new).collect();
        let n_rows = data.iter().map(|d| d.values.len()).sum();
        let mut objective = data.clone();
        let mut random = Random::new(5);
        let y: Vec<f64> = (0..n_rows).map(|_| random.uniform(-1.0, 1.0)).collect();
        trajectory.linearise(&x, &vec![0.0; n_rows], &mut objective);
        for factor in [0.0, 0.5, 0.25] {
            trajectory.linearise(&x, &y, &mut data);
            let lagrangian = data.clone();
            trajectory.scale_row_curvature(&x, factor, &mut data);
            let (mut largest, mut rows) = (0.0_f64, 0.0_f64);
            for ((d, l), f) in data.iter().zip(&lagrangian).zip(&objective) {
                assert_eq!((&d.gradient, &d.values), (&l.gradient, &l.values));
                assert_eq!(d.jacobians, l.jacobians);
                let n = d.gradient.len();
                for (i, j) in (0..n).flat_map(|j| (j..n).map(move |i| (i, j))) {
                    let [h, l, f] = [d, l, f].map(|data| data.hessian[j * n + i]);
                    let difference = h - (factor * l + (1.0 - factor) * f);
                    largest = largest.max(difference.abs() / (1.0 + l.abs()));
                    rows = rows.max((l - f).abs());
                }
            }
            assert!(largest < 1e-12 && rows > 0.1, "{grid:?}: {largest}, {rows}");
        }
    }
}

#[test]
fn torque_at_speed_has_rows_unless_torque_limits_are_lifted_or_the_problem_is_the_papers() {
    let rows = |preset, integrator, limits| {
        let (trajectory, _) = program_with(0, Grid::Motion, preset, integrator);
        let mut program = trajectory.program;
        let settings = &mut program.settings;
        settings.torque_limits = limits;
        let labels = program.labels.iter();
        let n = labels.filter(|l| l.category == "torque at speed").count();
        (n, program.settings.torque_speed())
    };
    let (euler, on) = rows(Preset::Default, Integrator::Euler, true);
    assert!(euler > 0 && on);
    let (both_ends, _) = rows(Preset::Default, Integrator::ConstantAcceleration, true);
    assert!(both_ends > euler);
    assert_eq!(rows(Preset::Paper, Integrator::Euler, true), (0, false));
    assert!(!rows(Preset::Default, Integrator::Euler, false).1);
}

#[test]
fn the_keyframe_program_matches_central_differences() {
    for seed in 0..4 {
        let (trajectory, point) = program(seed, Grid::Keyframes, Preset::Default);
        let mut nodes = trajectory.program.nodes.iter();
        assert!(nodes.any(|node| node.balance.is_some()));
        check_program(seed, (trajectory, point));
        check(seed, Grid::State, Preset::Default);
    }
}

#[test]
fn the_path_program_matches_central_differences() {
    for seed in 0..4 {
        check(seed, Grid::Path, Preset::Default);
    }
}

#[test]
fn the_paper_program_matches_central_differences() {
    for seed in 0..4 {
        check(seed, Grid::Motion, Preset::Paper);
    }
}

#[test]
fn the_paper_keyframe_program_matches_central_differences() {
    check(0, Grid::Keyframes, Preset::Paper);
}
