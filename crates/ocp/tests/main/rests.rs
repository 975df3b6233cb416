//! Objects at rest are no unknowns.

use crate::scenes::program_with;
use ocp::{Grid, Integrator, Preset, Program, Subject};
use solver::Problem;

/// First variable of the object at every node that is free.
fn object_vars(program: &Program) -> Vec<Option<usize>> {
    let nodes = program.nodes.iter().filter_map(|n| n.var.as_ref());
    nodes.map(|vars| vars.objects[0]).collect()
}

/// The object's surface on the world: interfaces 3 and 6 of the random scene, in the first and in the last three intervals.
fn rows_of_support(program: &Program, category: &str) -> usize {
    let of_support =
        |subject: &Subject| matches!(subject, Subject::Contact(c) if (c.a.0, c.b.0) == (3, 6));
    let labels = program.labels.iter();
    labels
        .filter(|l| l.category == category && of_support(&l.subject))
        .count()
}

#[test]
fn an_object_is_an_unknown_only_where_it_can_move() {
    let of = |integrator| program_with(0, Grid::Motion, Preset::Default, integrator).0;
    // Nodes 0 to 3 at rest, 4 in hands, 5 to 8 at rest again, the last one as its predecessor.
    let program = of(Integrator::ConstantAcceleration).program;
    let vars = object_vars(&program);
    assert_eq!(vars[..3], [None; 3]);
    assert!(vars[3].is_some() && vars[4].is_some() && vars[3] != vars[4]);
    assert_eq!(vars[4..], [vars[4]; 4]);
    let velocities = program.nodes.iter().map(|n| n.velocity_var.as_ref());
    let moving: Vec<usize> = velocities
        .enumerate()
        .filter(|(_, vars)| vars.is_some_and(|vars| vars.objects[0].is_some()))
        .map(|(t, _)| t)
        .collect();
    assert_eq!(moving, [4]);
    // With explicit Euler it rests for one interval after the release, and nodes 0 and 1 are fixed.
    let vars = object_vars(&of(Integrator::Euler).program);
    assert_eq!(vars[..3], [None; 3]);
    assert_eq!(vars[3..], [vars[3]; 4]);
    // Keyframes begin where their rows do not hold yet: every node has its own.
    let keyframes = program_with(0, Grid::Keyframes, Preset::Default, Integrator::Euler).0;
    let vars = object_vars(&keyframes.program);
    assert!(vars.iter().all(Option::is_some) && vars[1] != vars[2]);
}

#[test]
fn where_an_object_rests_is_said_once() {
    for integrator in [Integrator::ConstantAcceleration, Integrator::Euler] {
        let (trajectory, _) = program_with(0, Grid::Motion, Preset::Default, integrator);
        let program = trajectory.program;
        let rows = |category| rows_of_support(&program, category);
        assert_eq!(rows("contact distance"), 1, "{integrator:?}");
        assert_eq!(rows("contact slip"), 0);
        assert_eq!(rows("contact velocity"), 0);
    }
}

#[test]
fn a_step_moves_an_object_at_rest_as_one() {
    let integrator = Integrator::ConstantAcceleration;
    let (trajectory, x) = program_with(1, Grid::Motion, Preset::Default, integrator);
    let n_vars = trajectory.structure().n_vars;
    let step: Vec<f64> = (0..n_vars).map(|i| 0.01 * (i % 7) as f64).collect();
    let mut moved = x.clone();
    trajectory.retract(&x, &step, 1.0, &mut moved);
    let object = trajectory.program.system.object_q(0);
    let change = |t: usize| {
        let of =
            |q: &[f64]| spatial::Pose::from_xyzquat(q[object..object + 7].try_into().expect("7"));
        of(&moved.nodes[t]).minus(&of(&x.nodes[t]))
    };
    for t in 0..=3 {
        assert!(change(t).norm() < 1e-12, "node {t}");
    }
    assert!(change(5).norm() > 1e-3);
    for t in 6..=8 {
        assert!((change(t) - change(5)).norm() < 1e-12, "node {t}");
    }
}
