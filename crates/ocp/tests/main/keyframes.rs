//! Keyframe checks and warm starts on sequences of the repository.

use multibody::{CenterOfMass, Kinematics};
use nalgebra::{Vector3, Vector6};
use ocp::{Arrangement, Ending, Margins, Phase, Planner, Preset, Refinement, Settings};
use scene::{Scene, SequenceFile};
use spatial::Pose;
use std::path::Path;
use symbolic::{Contact, ContactState, ContactType};

/// Scene, phases and options of a sequence file.
pub fn sequence(name: &str) -> (Scene, Vec<Phase>, Settings) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/sequences");
    let file = SequenceFile::load(folder.join(name)).expect("a sequence of the repository");
    let mut scene = file.load_scene().expect("its scene");
    let sequence = file.resolve(&scene).expect("names of the scene");
    if let Some(goal) = &sequence.goal {
        scene.goal_contacts.clone_from(&goal.contacts);
        scene.goal_regions.clone_from(&goal.regions);
    }
    let phase = |p: &scene::SequencePhase| Phase {
        state: p.state.clone(),
        steps: 8,
    };
    let settings = Settings::new(Preset::Default, &scene.optimiser);
    let phases = sequence.phases.iter().map(phase).collect();
    (scene, phases, settings)
}

/// All of a sequence that has a plan passes: every state, transition and beginning, and the whole.
fn all_pass(name: &str) {
    let (scene, phases, settings) = sequence(name);
    let planner = Planner::new(&scene).expect("a model");
    for (k, phase) in phases.iter().enumerate() {
        let state = planner.state(&phase.state, &settings);
        assert!(state.possible, "{name}: state {k}: {:?}", state.worst);
        let beginning = planner.keyframes_of_prefix(&phases[..=k], &settings);
        let worst = &beginning.worst;
        assert!(beginning.possible, "{name}: beginning {k}: {worst:?}");
    }
    for pair in phases.windows(2) {
        let both = planner.transition(&pair[0].state, &pair[1].state, &settings);
        assert!(both.possible, "{name}: transition: {:?}", both.worst);
    }
    let whole = planner.keyframes(&phases, &settings);
    assert!(whole.possible, "{name}: {:?}", whole.worst);
}

#[test]
fn small_sequences_with_a_plan_pass_all_checks() {
    for name in [
        "boxes/squeeze.toml",
        "flat/forward_2.toml",
        "flat/one_leg.toml",
        "stairs/up_one.toml",
        "support/lean.toml",
        "yardstick/fixed.toml",
        "yardstick/green_fixed.toml",
    ] {
        all_pass(name);
    }
}

#[test]
#[ignore = "slow: 10 s"]
fn long_sequences_with_a_plan_pass_all_checks() {
    for name in [
        "boxes/pick_place.toml",
        "boxes/squeeze_carry.toml",
        "flat/turn_left.toml",
        "stairs/up_down.toml",
        "stairs/up_three.toml",
        "yardstick/green_step.toml",
        "yardstick/two_box.toml",
    ] {
        all_pass(name);
    }
}

#[test]
fn a_wall_of_a_metre_is_out_of_reach_for_state_transition_and_sequence() {
    let (scene, phases, settings) = sequence("stairs/wall.toml");
    let planner = Planner::new(&scene).expect("a model");
    assert!(!planner.state(&phases[2].state, &settings).possible);
    let [before, after] = [&phases[1].state, &phases[2].state];
    assert!(!planner.transition(before, after, &settings).possible);
    let sequence = planner.keyframes(&phases, &settings);
    assert!(!sequence.possible && sequence.worst.is_some());
    assert!(
        !planner
            .keyframes_of_prefix(&phases[..3], &settings)
            .possible
    );
    assert!(
        planner
            .keyframes_of_prefix(&phases[..2], &settings)
            .possible
    );
}

#[test]
fn the_box_on_the_other_side_is_out_of_reach_of_a_hand_in_the_sequence_only() {
    let (scene, phases, settings) = sequence("boxes/wrong_hand.toml");
    let planner = Planner::new(&scene).expect("a model");
    // Some robot may stand somewhere, and the box lie anywhere on its table: a lone state knows no start.
    assert!(planner.state(&phases[1].state, &settings).possible);
    assert!(!planner.keyframes(&phases, &settings).possible);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation")]
fn a_motion_starts_the_same_sequence_with_the_box_moved_in_half_the_iterations() {
    let (scene, phases, settings) = sequence("boxes/squeeze.toml");
    let solve = |scene: &Scene| {
        let planner = Planner::new(scene).expect("a model");
        let keyframes = planner.keyframes(&phases, &settings);
        planner.motion(&phases, &settings, &keyframes.nodes, &mut |_| true)
    };
    let relative = solve(&scene).relative();
    assert_eq!(relative.shared_phases(&phases), phases.len());
    let mut moved = scene.clone();
    let shift = Pose::from_translation(0.02, 0.0, 0.0);
    moved.objects[0].world_from_start = shift * moved.objects[0].world_from_start;
    let cold = solve(&moved);
    let planner = Planner::new(&moved).expect("a model");
    let warm = planner.motion_from(&phases, &settings, &relative, &mut |_| true);
    let warm = warm.expect("a motion");
    assert!(cold.feasible && warm.feasible);
    assert!(
        2 * warm.iterations <= cold.iterations,
        "cold {}, warm {}",
        cold.iterations,
        warm.iterations
    );
    let difference = (warm.report.objective - cold.report.objective).abs();
    assert!(difference < 0.01 * cold.report.objective);
    assert_eq!(warm.point.nodes[0], planner.system.start(&moved));
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation")]
fn a_beginning_starts_the_longer_sequence_and_a_stranger_starts_nothing() {
    let (scene, phases, settings) = sequence("yardstick/step.toml");
    let planner = Planner::new(&scene).expect("a model");
    let beginning = &phases[..phases.len() - 2];
    let keyframes = planner.keyframes_of_prefix(beginning, &settings);
    let shorter = planner.motion(beginning, &settings, &keyframes.nodes, &mut |_| true);
    assert!(shorter.feasible);
    let relative = shorter.relative();
    let longer = planner.motion_from(&phases, &settings, &relative, &mut |_| true);
    assert!(longer.expect("a motion").feasible);
    let stranger = &phases[1..];
    let none = planner.motion_from(stranger, &settings, &relative, &mut |_| true);
    assert!(none.is_none(), "not one phase is shared");
}

#[test]
fn keyframes_shift_the_weight_to_the_foot_that_stays() {
    let (scene, phases, mut settings) = sequence("flat/one_leg.toml");
    settings.weights.balance = 2.0;
    let planner = Planner::new(&scene).expect("a model");
    let keyframes = planner.keyframes(&phases, &settings);
    let on_one_foot = phases
        .iter()
        .position(|phase| phase.state.contacts.len() == 1)
        .expect("it stands on one leg");
    let contact = phases[on_one_foot].state.iter().next().expect("a foot");
    let foot = &scene.interfaces[contact.a.0];
    let robot = &planner.system.robot;
    let away = |q: &[f64]| {
        let mut kinematics = Kinematics::new(&planner.system.model);
        kinematics.update(&planner.system.model, q);
        let place = planner.system.world_from_interface(foot, &kinematics);
        let com = CenterOfMass::new(robot).compute(robot, &kinematics).0;
        (com - place.origin()).xy().norm()
    };
    let (before, after) = (
        away(&keyframes.nodes[0]),
        away(&keyframes.nodes[on_one_foot + 1]),
    );
    assert!(before > 0.1, "the start stands on both: {before}");
    assert!(after < 0.05, "{after}");
}

#[test]
fn what_is_carried_at_the_end_comes_along_with_every_step() {
    let (scene, phases, settings) = sequence("boxes/carry_away.toml");
    let planner = Planner::new(&scene).expect("a model");
    let keyframes = planner.keyframes(&phases, &settings);
    assert!(keyframes.possible, "{:?}", keyframes.worst);
    let object = planner.system.object_q(0);
    let place = |q: &Vec<f64>| [q[0], q[1], q[object], q[object + 1]];
    let places: Vec<[f64; 4]> = keyframes.nodes.iter().map(place).collect();
    let way = |from: &[f64; 4], to: &[f64; 4], first: usize| {
        (to[first] - from[first]).hypot(to[first + 1] - from[first + 1])
    };
    for first in [0, 2] {
        let whole = way(&places[0], &places[places.len() - 1], first);
        let longest = places.windows(2).map(|p| way(&p[0], &p[1], first));
        let longest = longest.fold(0.0, f64::max);
        assert!(
            whole > 0.9 && longest < 0.4 * whole,
            "{longest} of {whole} m"
        );
    }
}

#[test]
fn a_stride_over_a_stair_leans_more_than_one_onto_it() {
    let most = |name: &str| {
        let (scene, phases, mut settings) = sequence(name);
        settings.weights.balance = 2.0;
        let planner = Planner::new(&scene).expect("a model");
        let keyframes = planner.keyframes(&phases, &settings);
        assert!(keyframes.possible, "{name}");
        let leans = planner.leans(&phases, &keyframes.nodes);
        assert_eq!(leans.len(), phases.len(), "{name}");
        leans.into_iter().fold(0.0, f64::max)
    };
    let (onto, over) = (most("stairs/up_one.toml"), most("stairs/skip.toml"));
    assert!(onto < 0.4, "{onto}");
    assert!(over > onto + 0.1, "{over} > {onto}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation")]
fn a_rough_motion_misses_little_after_fewer_iterations_and_is_a_start_for_a_finer_grid() {
    let (scene, phases, settings) = sequence("yardstick/red_step.toml");
    let planner = Planner::new(&scene).expect("a model");
    let keyframes = planner.keyframes(&phases, &settings);
    let solve =
        |settings: &Settings| planner.motion(&phases, settings, &keyframes.nodes, &mut |_| true);
    let rough = Settings {
        ending: Ending::Rough,
        ..settings.clone()
    };
    let (exact, motion) = (solve(&settings), solve(&rough));
    assert!(exact.feasible && motion.is_nearly_feasible());
    let misses = motion.report.violation;
    assert!(misses <= 3e-3, "{misses}");
    let worst = motion.worst.as_ref().map(|w| w.amount / w.label.scale);
    assert_eq!(motion.feasible, worst.is_none(), "{worst:?}");
    assert!(
        motion.iterations < exact.iterations,
        "rough {}, exact {}",
        motion.iterations,
        exact.iterations
    );
    let grid = Refinement {
        max_step: 0.06,
        ..Refinement::default()
    };
    let fine = planner.refine(&phases, &rough, &motion, grid, &mut |_| true);
    assert!(fine.feasible, "{:?}", fine.worst);
    assert!(fine.report.violation <= 1e-5);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation")]
fn another_first_barrier_is_another_way_to_the_same_motion() {
    let (scene, phases, settings) = sequence("flat/cross_step.toml");
    let planner = Planner::new(&scene).expect("a model");
    let nodes = planner.keyframes(&phases, &settings).nodes;
    let solve = |first_barrier: f64| {
        let settings = Settings {
            first_barrier,
            ..settings.clone()
        };
        let mut first = None;
        let motion = planner.motion(&phases, &settings, &nodes, &mut |i| {
            first.get_or_insert(i.barrier);
            true
        });
        assert!(motion.feasible, "{:?}", motion.worst);
        (motion, first.expect("an iteration"))
    };
    let ((usual, low), (mut other, high)) = (solve(0.0), solve(0.1));
    assert!(high > low, "{high} and {low}");
    let costs = [&usual, &other].map(|motion| motion.report.objective);
    assert!((costs[0] / costs[1] - 1.0).abs() < 0.05, "{costs:?}");
    let own = other.iterations;
    other.add_work(&usual);
    assert_eq!(other.iterations, own + usual.iterations);
}

/// Stands on both feet at the start, is in the air, and has both hands on the green box; of the boxes only those of these contacts
/// are known to be where they were.
fn squeezing(scene: &Scene, resting: &[&str]) -> [Phase; 3] {
    let contact = |a: &str, b: &str| Contact {
        a: scene.interface_id(a).expect("an interface"),
        b: scene.interface_id(b).expect("an interface"),
        kind: ContactType::UnilateralPatch,
    };
    let rest = resting.iter().map(|&bottom| contact(bottom, "table_a_top"));
    let air: ContactState = rest.collect();
    let hands = [
        ("left_hand", "green_box_left"),
        ("right_hand", "green_box_right"),
    ];
    let hands = hands.map(|(a, b)| contact(a, b));
    let there = air.iter().chain(hands).collect();
    [scene.start_state(), air, there].map(|state| Phase { state, steps: 8 })
}

/// The gap is 65 mm wide: room for the hand, but not for its clearance too.
#[test]
fn a_hand_does_not_go_where_there_is_no_room_for_its_clearance() {
    let scene = Scene::builtin("three-boxes").expect("a built-in scene");
    let planner = Planner::new(&scene).expect("a model");
    let settings = Settings::new(Preset::Default, &scene.optimiser);
    let object = |name: &str| {
        scene
            .objects
            .iter()
            .position(|o| o.name == name)
            .expect("an object")
    };
    let beside = squeezing(
        &scene,
        &["red_box_bottom", "blue_box_bottom", "green_box_bottom"],
    );
    let found = planner.keyframes_anywhere(&beside, &settings, &[]);
    assert!(!found.possible);
    let margin = settings.margins.clearance;
    let none = Settings {
        margins: Margins {
            clearance: 0.0,
            ..settings.margins.clone()
        },
        ..settings.clone()
    };
    let without = planner.keyframes_anywhere(&beside, &none, &[]);
    assert!(without.possible, "without {margin} m: {:?}", without.worst);
    let alone = squeezing(&scene, &["green_box_bottom"]);
    let elsewhere = [object("red_box"), object("blue_box")];
    let found = planner.keyframes_anywhere(&alone, &settings, &elsewhere);
    assert!(found.possible, "{:?}", found.worst);
}

#[test]
fn a_box_is_grasped_from_beside_another_that_stands_nearer_than_motions_may_come() {
    let text = Scene::builtin_text("three-boxes").expect("a built-in scene");
    // The gap between red and blue is from the knob of the blue one to the red one.
    let near = text.replace("position = [-0.07, -0.06]", "position = [-0.07, 0.045]");
    let scene = Scene::from_toml(&near, "near.toml", Path::new(".")).expect("a scene");
    let planner = Planner::new(&scene).expect("a model");
    let settings = Settings::new(Preset::Default, &scene.optimiser);
    let boxes = ["red_box_bottom", "blue_box_bottom", "green_box_bottom"];
    let [start, air, _] = squeezing(&scene, &boxes);
    let contact = Contact {
        a: scene.interface_id("left_hand").expect("an interface"),
        b: scene.interface_id("red_box_handle").expect("an interface"),
        kind: ContactType::BilateralPatch,
    };
    let there = Phase {
        state: air.state.iter().chain([contact]).collect(),
        steps: 8,
    };
    let found = planner.keyframes_anywhere(&[start, air, there], &settings, &[]);
    assert!(found.possible, "{:?}", found.worst);
}

/// Both boxes are to stand side by side on a table that has so much room for the gap between them [m].
fn side_by_side(gap: f64, margins: Margins) -> bool {
    let text = Scene::builtin_text("two-box").expect("a built-in scene");
    let (table, wide) = (
        "[0.34, 0.70, 0.03]\nposition = [0.45, 0.95,",
        0.15 + 0.20 + gap,
    );
    assert!(text.contains(table));
    let middle = 0.47 + 0.5 * wide;
    let narrow = format!("[0.34, {wide}, 0.03]\nposition = [0.45, {middle},");
    let text = text.replace(table, &narrow);
    let scene = Scene::from_toml(&text, "narrow.toml", Path::new(".")).expect("a scene");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/sequences");
    let file = SequenceFile::load(folder.join("tasks/beyond.toml")).expect("a sequence");
    let sequence = file.resolve(&scene).expect("names of the scene");
    let phase = |p: &scene::SequencePhase| Phase {
        state: p.state.clone(),
        steps: 8,
    };
    let phases: Vec<Phase> = sequence.phases.iter().map(phase).collect();
    let settings = Settings {
        margins,
        ..Settings::new(Preset::Default, &scene.optimiser)
    };
    let planner = Planner::new(&scene).expect("a model");
    planner.keyframes(&phases, &settings).possible
}

/// No motion parts what rests too near: it was tried for half a minute each time.
#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation")]
fn boxes_do_not_rest_nearer_to_one_another_than_motions_may_come() {
    assert!(side_by_side(0.05, Margins::executable()));
    assert!(!side_by_side(0.01, Margins::executable()));
    let touching = Margins {
        clearance: 0.0,
        ..Margins::executable()
    };
    assert!(side_by_side(0.01, touching));
}

#[test]
fn a_robot_that_faces_another_way_goes_on_in_the_same_direction() {
    let (scene, phases, _) = sequence("yardstick/two_box.toml");
    let planner = Planner::new(&scene).expect("a model");
    let guess = planner.guess_after(&[], &phases, Arrangement::default());
    let mut known = guess[..3].to_vec();
    let about_z = Pose::exp(&Vector6::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.5));
    let base = Pose::from_xyzquat(known[2].first_chunk().expect("a base"));
    let turned = Pose::from_parts(about_z.rotation() * base.rotation(), base.origin());
    known[2][..7].copy_from_slice(&turned.to_xyzquat());
    let after = planner.guess_after(&known, &phases, Arrangement::default());
    let way = |nodes: &[Vec<f64>], k: usize| [0, 1, 2].map(|i| nodes[k][i] - nodes[2][i]);
    let far = way(&guess, phases.len());
    assert!(far[0].hypot(far[1]) > 0.1, "{far:?}");
    for k in 3..=phases.len() {
        let (one, other) = (way(&guess, k), way(&after, k));
        assert!(
            (0..3).all(|i| (one[i] - other[i]).abs() < 1e-9),
            "{one:?} and {other:?}"
        );
        let base = Pose::from_xyzquat(after[k].first_chunk().expect("a base"));
        let ahead = base.rotate(Vector3::x());
        assert!(
            (ahead.y.atan2(ahead.x) - 0.5).abs() < 1e-6,
            "it still faces that way"
        );
    }
}

/// Lowest corner of the soles over what they land on or have left, at the nodes next to those contacts [m].
fn lowest_beside_contacts(name: &str) -> f64 {
    let (scene, phases, settings) = sequence(name);
    let planner = Planner::new(&scene).expect("a model");
    let keyframes = planner.keyframes(&phases, &settings);
    let motion = planner.motion(&phases, &settings, &keyframes.nodes, &mut |_| true);
    assert!(motion.feasible, "{name}: {:?}", motion.worst);
    let mut kinematics = Kinematics::new(&planner.system.model);
    let mut lowest = f64::INFINITY;
    let mut first = 0;
    for (k, phase) in phases.iter().enumerate() {
        let end = first + phase.steps;
        let beside = [(k.wrapping_sub(1), first + 2), (k + 1, end - 1)];
        for (neighbour, node) in beside {
            let Some(neighbour) = phases.get(neighbour) else {
                continue;
            };
            kinematics.update(&planner.system.model, &motion.point.nodes[node]);
            let apart = neighbour.state.contacts.iter();
            for contact in apart.filter(|c| !phase.state.contains(c)) {
                let [a, b] = [contact.a, contact.b].map(|i| {
                    let interface = &scene.interfaces[i.0];
                    let carrier = planner
                        .system
                        .carrier(interface.owner, &interface.body_from_interface);
                    carrier.world_from_frame(&kinematics)
                });
                let half = scene.interfaces[contact.a.0].half_size.expect("a sole");
                for (i, j) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                    let corner = a.act(Vector3::new(i * half[0], j * half[1], 0.0));
                    lowest = lowest.min(b.inverse().act(corner).z);
                }
            }
        }
        first = end;
    }
    lowest
}

#[test]
fn soles_are_not_below_what_they_land_on_one_interval_before() {
    let lowest = lowest_beside_contacts("stairs/up_three.toml");
    // Without the rows it is 6 mm below.
    assert!(lowest > -1e-6, "{lowest} m");
}
