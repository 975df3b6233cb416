use super::samples::Sequence;
use super::*;
use crate::motion::{Planner, near};
use crate::settings::{Preset, Settings};

#[test]
fn a_foot_that_lands_through_the_edge_of_a_block_collides_before_it_lands() {
    let Sequence { scene, phases } = Sequence::with_steps("stairs/block.toml", 8);
    let planner = Planner::new(&scene).unwrap();
    let settings = Settings::new(Preset::Default, &scene.optimiser);
    let keyframes = planner.keyframes(&phases, &settings);
    assert!(keyframes.possible);
    // On the ground until the last interval before the foot stands on the block.
    let landing = 16;
    let mut nodes = vec![keyframes.nodes[0].clone(); landing];
    nodes.resize(41, keyframes.nodes[2].clone());
    let mut crossings = Crossings::new();
    let program = planner.program(&phases, &settings, Grid::Motion, near(&nodes, &crossings));
    let found =
        planner
            .collisions
            .find_crossings(&program, &scene, &phases, &nodes, &mut crossings);
    assert!(found);
    let (swings, stands) = (&phases[1].state.contacts, &phases[2].state.contacts);
    let foot = stands.iter().find(|c| !swings.contains(c)).unwrap();
    let Owner::Robot { frame } = scene.interfaces[foot.a.0].owner else {
        panic!("a foot is the robot's");
    };
    let joint = planner.system.model.frames[frame].joint.unwrap();
    let of_foot = |&(&(t, a, _), _): &(&(usize, usize, Other), _)| (t, a) == (landing - 1, joint);
    let mut of_foot = crossings.ways.iter().filter(of_foot);
    let ((.., other), places) = of_foot.next().expect("the foot comes through the edge");
    assert!(places[0].depth > 0.01, "{places:?}");
    // Rows there say so, and demand that it be otherwise.
    let program = planner.program(&phases, &settings, Grid::Motion, near(&nodes, &crossings));
    let passages = &program.intervals[landing - 1].passages;
    assert!(!passages.is_empty(), "{other:?}");
    let point = crate::guess::point(&program, &scene, nodes);
    let mut trajectory = crate::problem::Trajectory::new(program);
    let report = crate::motion::report_at(&mut trajectory, &point);
    let worst = |category: &str| {
        let mut out = f64::INFINITY;
        for (row, label) in trajectory.program.labels.iter().enumerate() {
            if label.category == category {
                out = out.min(report.rows[row]);
            }
        }
        out
    };
    assert!(worst("clearance between nodes") < -0.01);
}

#[test]
fn what_touches_by_a_point_keeps_out_of_what_it_touches() {
    let scene = samples::scene(
        "[[robot_interface]]\nname = \"fist\"\nlink = \"left_rubber_hand\"\nkind = \"point\"\nrole = \"hand\"\n\
         pose = [0.2, 0, 0, 0, 0.70710678, 0, 0.70710678]\ncontacts = [\"unilateral_point\"]\n\
         [[static]]\nname = \"wall\"\nsize = [0.1, 2, 2]\nposition = [0.6, 0, 1]\n",
    );
    let planner = Planner::new(&scene).unwrap();
    let settings = Settings::new(Preset::Default, &scene.optimiser);
    let interface = |name: &str| scene.interface_id(name).unwrap();
    let wall = scene
        .interfaces
        .iter()
        .position(|i| i.name.starts_with("wall"));
    let touch = |hand: &str, kind: symbolic::ContactType| Contact {
        a: interface(hand),
        b: symbolic::InterfaceId(wall.unwrap()),
        kind,
    };
    let start: symbolic::ContactState = scene.start_contacts.iter().copied().collect();
    let rows = |contact: Contact| {
        let with: symbolic::ContactState = start.iter().chain([contact]).collect();
        let phases = [start.clone(), with].map(|state| Phase { state, steps: 2 });
        let mut q = planner.system.start(&scene);
        q[0] += 0.2; // the hands in the wall
        let (nodes, none) = (vec![q; 5], Crossings::new());
        let program = planner.program(&phases, &settings, Grid::Motion, near(&nodes, &none));
        let Owner::Robot { frame } = scene.interfaces[contact.a.0].owner else {
            panic!("a hand is the robot's");
        };
        let joint = planner.system.model.frames[frame].joint.unwrap();
        let pairs = planner
            .collisions
            .pairs(&program, &scene, &phases, near(&nodes, &none));
        let of_hand = pairs.iter().filter(|p| (p.a, p.b) == (joint, None));
        let at_contact = of_hand.filter(|p| p.place == Place::Node(3));
        at_contact.map(|p| p.term.bounds()[0].0).collect::<Vec<_>>()
    };
    let by_point = rows(touch("fist", symbolic::ContactType::UnilateralPoint));
    assert!(
        !by_point.is_empty() && by_point.iter().all(|&b| b < 0.0),
        "{by_point:?}"
    );
    let by_patch = rows(touch("left_hand", symbolic::ContactType::UnilateralPatch));
    assert!(by_patch.is_empty(), "{by_patch:?}");
}
