//! What bears an object that nothing else touches is known.

use crate::keyframes::sequence;
use nalgebra::{Vector3, Vector6};
use ocp::collision::Clearances;
use ocp::{Grid, Phase, Planner, Program, Settings};
use scene::Scene;
use solver::Problem;
use std::collections::BTreeSet;

/// Intervals in which the object of "lift-box" is known to bear nothing but its weight: reach, squeeze and lift have eight each.
fn idle(change: impl Fn(&mut Scene)) -> Vec<usize> {
    let (mut scene, phases, settings) = sequence("boxes/squeeze.toml");
    change(&mut scene);
    let program = program(&scene, &phases, &settings);
    let intervals = program.intervals.iter().enumerate();
    let idle = intervals.filter(|(_, interval)| interval.idle == [0]);
    idle.map(|(t, _)| t).collect()
}

fn program(scene: &Scene, phases: &[Phase], settings: &Settings) -> Program {
    let planner = Planner::new(scene).expect("a model");
    let (system, collisions) = (&planner.system, &planner.collisions);
    let near = Clearances::Watched(&BTreeSet::new());
    Program::new(
        scene,
        system,
        collisions,
        phases,
        settings,
        Grid::Motion,
        near,
    )
}

#[test]
fn only_where_nothing_else_touches_an_object_on_a_level_table() {
    assert_eq!(idle(|_| ()), (0..8).collect::<Vec<_>>());
    let never: [fn(&mut Scene); 5] = [
        |scene| {
            let tilt = spatial::Pose::exp(&Vector6::new(0.0, 0.0, 0.0, 1e-4, 0.0, 0.0));
            scene.objects[0].world_from_start = scene.objects[0].world_from_start * tilt;
        },
        |scene| scene.gravity = Vector3::new(0.1, 0.0, -9.8),
        |scene| {
            let i = bottom(scene);
            scene.interfaces[i].max_force = 5.0;
        },
        // As near to the edge as the margin does not allow.
        |scene| {
            let i = bottom(scene);
            scene.interfaces[i].half_size = Some([1e-4, 0.1]);
            let moved = spatial::Pose::from_translation(9.5e-5, 0.0, 0.0);
            scene.interfaces[i].body_from_interface =
                scene.interfaces[i].body_from_interface * moved;
        },
        |scene| {
            let table = scene.interface_id("table_top").expect("the table");
            scene.interfaces[table.0].overhang = true;
        },
    ];
    for change in never {
        assert!(idle(change).is_empty());
    }
}

fn bottom(scene: &Scene) -> usize {
    scene.interface_id("box_bottom").expect("the box").0
}

#[test]
fn the_wrench_that_is_known_holds_the_object() {
    let (mut scene, phases, settings) = sequence("boxes/squeeze.toml");
    // Beside its middle.
    let i = bottom(&scene);
    let moved = spatial::Pose::from_translation(0.03, -0.02, 0.0);
    scene.interfaces[i].body_from_interface = scene.interfaces[i].body_from_interface * moved;
    let planner = Planner::new(&scene).expect("a model");
    let keyframes = planner.keyframes(&phases, &settings);
    let mut motion = planner.motion(&phases, &settings, &keyframes.nodes, &mut |_| true);
    assert!(motion.feasible);
    let trajectory = &mut motion.trajectory;
    let first = trajectory.program.system.robot_nv;
    for t in 0..trajectory.program.n_intervals() {
        let forces = trajectory.torques(&motion.point, t);
        let most = forces[first..]
            .iter()
            .fold(0.0, |most: f64, f| most.max(f.abs()));
        let known = trajectory.program.intervals[t].idle == [0];
        assert_eq!(known, t < 8, "{t}");
        assert!(most < if known { 1e-9 } else { 1e-3 }, "{t}: {most}");
    }
    // They are no unknowns.
    let interval = &trajectory.program.intervals[0];
    let of_box = interval.forces.iter().find(|f| f.contact.a.0 == i);
    let of_box = of_box.expect("the box stands on the table");
    let structure = trajectory.structure();
    let vars = interval.wrench_var + of_box.first..interval.wrench_var + of_box.first + 6;
    for v in vars {
        assert_eq!(structure.lower[v].to_bits(), structure.upper[v].to_bits());
    }
    assert!(of_box.rows.is_empty());
}
