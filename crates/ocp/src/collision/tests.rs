use super::samples::Sequence;
use super::*;
use crate::motion::{Planner, near};
use crate::settings::{Preset, Settings};

#[test]
fn a_foot_that_lands_through_the_edge_of_a_block_collides_before_it_lands() {
    let Sequence { scene, phases } = Sequence::load("stairs/block.toml");
    let phases: Vec<Phase> = phases
        .into_iter()
        .map(|p| Phase { steps: 8, ..p })
        .collect();
    let planner = Planner::new(&scene).unwrap();
    let settings = Settings::new(Preset::Default, &scene.optimiser);
    let keyframes = planner.keyframes(&phases, &settings);
    assert!(keyframes.possible);
    // On the ground until the last interval before the foot stands on the block.
    let landing = 16;
    let mut nodes = vec![keyframes.nodes[0].clone(); landing];
    nodes.resize(41, keyframes.nodes[2].clone());
    let none = ExtraClearance::new();
    let program = planner.program(&phases, &settings, Grid::Motion, near(&nodes, &none));
    let found = planner
        .collisions
        .between(&program, &scene, &phases, &nodes, 0.002);
    let (swings, stands) = (&phases[1].state.contacts, &phases[2].state.contacts);
    let foot = stands.iter().find(|c| !swings.contains(c)).unwrap();
    let Owner::Robot { frame } = scene.interfaces[foot.a.0].owner else {
        panic!("a foot is the robot's");
    };
    let joint = planner.system.model.frames[frame].joint.unwrap();
    let before_it_lands = |o: &&Overlap| o.a == joint && o.nodes == [landing - 1];
    let mut of_foot = found.iter().filter(before_it_lands);
    let overlap = of_foot.next().expect("the foot comes through the edge");
    assert!(overlap.depth > 0.01, "{overlap:?}");
}
