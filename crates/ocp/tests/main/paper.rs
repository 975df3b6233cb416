//! Given contact sequences of the scene "yardstick" on the G1: the paper's preset converges; loads of feet.
//!
//! Run with `--release -- --nocapture`: each test prints iterations and time.

use ocp::{Motion, Phase, Planner, Preset, Settings};
use scene::{Role, Scene};
use symbolic::{Contact, ContactState, ContactType, InterfaceId};

type Pair = (&'static str, &'static str);

const LEFT: Pair = ("left_foot", "ground_top");
const RIGHT: Pair = ("right_foot", "ground_top");
const GRASP: Pair = ("left_hand", "red_box_handle");
const ON_A: Pair = ("red_box_bottom", "table_a_top");
const ON_B: Pair = ("red_box_bottom", "table_b_top");

/// Solves a sequence with `steps` intervals per phase, in the preset `paper` or with a least load of the feet.
fn solve(name: &str, states: &[&[Pair]], steps: usize, load: Option<f64>) -> (Scene, Motion) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/yardstick.toml");
    let scene = Scene::load(std::path::Path::new(path)).expect("the scene is sound");
    let contact = |&(a, b): &Pair| {
        let kind = if (a, b) == GRASP {
            ContactType::BilateralPatch
        } else {
            ContactType::UnilateralPatch
        };
        let id = |name: &str| {
            scene
                .interfaces
                .iter()
                .position(|i| i.name == name)
                .map(InterfaceId)
        };
        Contact {
            a: id(a).expect("an interface"),
            b: id(b).expect("an interface"),
            kind,
        }
    };
    let phases: Vec<Phase> = states
        .iter()
        .map(|pairs| Phase {
            state: ContactState {
                contacts: pairs.iter().map(contact).collect(),
            },
            steps,
        })
        .collect();
    let planner = Planner::new(&scene).expect("a model");
    let mut settings = Settings::new(Preset::Paper, &scene.optimiser);
    if let Some(load) = load {
        settings = Settings::new(Preset::Default, &scene.optimiser);
        settings.margins.load = load;
    }
    let keyframes = planner.keyframes(&phases, &settings);
    assert!(
        keyframes.possible,
        "{name}: keyframes {:?}",
        keyframes.worst
    );
    let motion = planner.motion(&phases, &settings, &keyframes.nodes, &mut |_| true);
    println!(
        "{name}, {} phases of {steps}: {:?}, {} iterations, {:.1} s, {:.0} ms each, violation {:.1e}, objective {:.4}",
        phases.len(),
        motion.report.status,
        motion.iterations,
        motion.seconds,
        1e3 * motion.seconds / motion.iterations.max(1) as f64,
        motion.report.violation,
        motion.report.objective,
    );
    (scene, motion)
}

fn converges(name: &str, states: &[&[Pair]], steps: usize) {
    let (_, motion) = solve(name, states, steps, None);
    assert!(motion.report.violation < 1e-6, "{name}: {:?}", motion.worst);
}

#[test]
fn side_steps_converge() {
    let both: &[Pair] = &[LEFT, RIGHT, ON_A];
    converges(
        "step",
        &[both, &[RIGHT, ON_A], both, &[LEFT, ON_A], both],
        10,
    );
}

#[test]
fn carrying_a_box_with_fixed_feet_converges() {
    converges(
        "fixed",
        &[
            &[LEFT, RIGHT, ON_A],
            &[LEFT, RIGHT, GRASP, ON_A],
            &[LEFT, RIGHT, GRASP],
            &[LEFT, RIGHT, GRASP, ON_B],
            &[LEFT, RIGHT, ON_B],
        ],
        10,
    );
}

#[test]
fn feet_in_contact_bear_some_load_until_they_are_about_to_leave() {
    const SHARE: f64 = 0.3;
    let both: &[Pair] = &[LEFT, RIGHT, ON_A];
    let (scene, motion) = solve("load", &[both, &[RIGHT, ON_A], both], 16, Some(SHARE));
    assert!(motion.report.violation < 1e-6, "{:?}", motion.worst);
    let program = &motion.trajectory.program;
    let weight = program.system.robot_mass * 9.81;
    let before_it_leaves = &program.intervals[..12];
    let mut loads = Vec::new();
    for (interval, wrenches) in before_it_leaves.iter().zip(&motion.point.wrenches) {
        for force in &interval.forces {
            if scene.interfaces[force.contact.a.0].role == Role::Foot {
                loads.push(-ocp::physical_wrench(force, wrenches)[2] / weight);
            }
        }
    }
    assert_eq!(loads.len(), 24, "two feet");
    let least = loads.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(least > SHARE - 1e-6, "{least} of the weight");
    assert!(
        least < 1.1 * SHARE,
        "it is what the foot would rather not bear: {least}"
    );
}
