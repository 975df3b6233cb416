//! What feet do on fine grids around landings.

use super::keyframes::sequence;
use nalgebra::Vector3;
use ocp::{CostTerm, Grid, Integrator, Phase, Planner, Program};
use scene::Owner;
use symbolic::{Contact, InterfaceId};

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

/// Phases in which the box of a sequence is drawn upright, on a grid of this integrator; and all in which it is in the air. It may be put
/// down on one of its sides.
fn upright(integrator: Integrator, on_its_side: bool) -> [Vec<usize>; 2] {
    let (scene, mut phases, mut settings) = sequence("yardstick/green_fixed.toml");
    settings.integrator = integrator;
    let planner = Planner::new(&scene).expect("a model");
    let owner = |i: InterfaceId| scene.interfaces[i.0].owner;
    let rest = |phase: &Phase| {
        let mut on = phase.state.iter();
        on.find(|c| {
            matches!(
                (owner(c.a), owner(c.b)),
                (Owner::Object(_), Owner::Static(_))
            )
        })
    };
    let in_air: Vec<usize> = (0..phases.len())
        .filter(|&k| rest(&phases[k]).is_none())
        .collect();
    assert!(!in_air.is_empty());
    if on_its_side {
        let bottom = rest(&phases[0]).expect("it stands").a;
        let side = scene.interfaces.iter().position(|i| {
            let up = i.body_from_interface.rotate(Vector3::z()).z;
            i.owner == owner(bottom) && up.abs() < 0.1
        });
        let a = InterfaceId(side.expect("a palm's side"));
        for phase in &mut phases[in_air[0] + in_air.len()..] {
            let old = rest(phase).expect("it is put down");
            assert!(phase.state.contacts.remove(&old));
            phase.state.contacts.insert(Contact { a, ..old });
        }
    }
    let nodes = vec![planner.system.start(&scene); 8 * phases.len() + 1];
    let crossings = ocp::collision::Crossings::new();
    let near = ocp::collision::Clearances::Near {
        nodes: &nodes,
        crossings: &crossings,
    };
    let (system, collisions) = (&planner.system, &planner.collisions);
    let program = Program::new(
        &scene,
        system,
        collisions,
        &phases,
        &settings,
        Grid::Motion,
        near,
    );
    // The base is drawn upright at all nodes.
    let tilts = |t: usize| {
        let costs = program.nodes[t].costs.iter();
        costs.filter(|cost| cost.kind == CostTerm::Tilt).count()
    };
    let drawn = (0..phases.len()).filter(|k| (8 * k + 1..8 * (k + 1)).all(|t| tilts(t) == 2));
    let elsewhere = (0..phases.len()).filter(|k| (8 * k + 1..8 * (k + 1)).all(|t| tilts(t) < 2));
    let drawn: Vec<usize> = drawn.collect();
    assert_eq!(drawn.len() + elsewhere.count(), phases.len());
    [drawn, in_air]
}

#[test]
fn where_velocities_are_unknowns_what_is_carried_stays_upright() {
    let [drawn, in_air] = upright(Integrator::ConstantAcceleration, false);
    assert_eq!(drawn, in_air);
    assert!(upright(Integrator::Euler, false)[0].is_empty());
}

#[test]
fn what_is_put_down_on_another_side_turns_as_it_likes() {
    assert!(upright(Integrator::ConstantAcceleration, true)[0].is_empty());
}
