//! What feet do on fine grids around landings.

use super::keyframes::sequence;
use ocp::{Grid, Integrator, Planner, Program};

/// Phases of two steps ahead in 50 intervals each, the first one in which a foot lands, and what `look` sees of their program on a
/// grid of so long steps.
fn of_two_steps<T>(max_step: f64, look: impl Fn(&Program, usize) -> T) -> T {
    let (scene, mut phases, mut settings) = sequence("flat/forward_2.toml");
    settings.integrator = Integrator::ConstantAcceleration;
    settings.max_step = max_step;
    let planner = Planner::new(&scene).expect("a model");
    let landing = (1..phases.len())
        .find(|&k| phases[k].state.contacts.len() > phases[k - 1].state.contacts.len())
        .expect("a foot lands");
    for phase in &mut phases {
        phase.steps = 50;
    }
    let nodes = vec![planner.system.start(&scene); 50 * phases.len() + 1];
    let crossings = ocp::collision::Crossings::new();
    let near = ocp::collision::Clearances::Near {
        nodes: &nodes,
        crossings: &crossings,
    };
    let program = Program::new(
        &scene,
        &planner.system,
        &planner.collisions,
        &phases,
        &settings,
        Grid::Motion,
        near,
    );
    look(&program, landing)
}

#[test]
fn on_fine_grids_the_weight_is_over_the_standing_foot_before_another_one_lands() {
    let balanced = |max_step: f64| {
        of_two_steps(max_step, |program, landing| {
            let swing = 50 * (landing - 1)..50 * landing;
            let is_balanced = |t: &usize| program.nodes[*t].balance.is_some();
            let balanced = swing.filter(is_balanced);
            balanced.map(|t| t % 50).collect::<Vec<_>>()
        })
    };
    // Of the last 0.4 s in steps of 20 ms.
    assert_eq!(balanced(0.02), (30..50).collect::<Vec<_>>());
    assert!(balanced(0.12).is_empty(), "coarse grids are left alone");
}

#[test]
fn on_fine_grids_feet_share_their_load_but_where_one_lands_or_leaves() {
    let weights = |max_step: f64| {
        of_two_steps(max_step, |program, landing| {
            let of_loads = |t: usize| {
                let forces = program.intervals[t].forces.iter();
                forces.map(|force| force.weights[2]).collect::<Vec<_>>()
            };
            let begin = 50 * landing;
            [0, 3, 10, 25, 49].map(|t| of_loads(begin + t))
        })
    };
    let [landed, soon, later, middle, leaving] = weights(0.02);
    assert_eq!((landed.len(), &landed), (2, &leaving));
    assert_eq!(later, middle);
    for foot in 0..2 {
        // 0.01, 0.07 s after the landing, and more than 0.2 s from any change.
        let share = |weights: &[f64]| weights[foot] / middle[foot];
        assert!((share(&landed) - 0.05).abs() < 0.01, "{}", share(&landed));
        assert!((share(&soon) - 0.35).abs() < 0.01, "{}", share(&soon));
    }
    let [landed, .., middle, _] = weights(0.12);
    assert_eq!(landed, middle, "coarse grids are left alone");
}
