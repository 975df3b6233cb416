//! Scenes built in memory: a random tree with feet and hands, tables and a box.

use multibody::{Model, Root, TorqueSpeed};
use nalgebra::{Matrix3, Vector3, Vector6};
use ocp::collision::CollisionModel;
use ocp::{
    Grid, Integrator, Phase, Point, Preset, Program, Settings, Sticking, System, Trajectory,
};
use scene::{
    Interface, Object, Objective, OptimiserOptions, Owner, PlacedShape, Robot, Role, Scene,
    SearchOptions, Shape, StaticBody,
};
use spatial::{Pose, Random};
use std::collections::BTreeSet;
use symbolic::ContactType::{BilateralPatch, UnilateralPatch, UnilateralPoint};
use symbolic::{Contact, ContactState, ContactType, InterfaceId};

fn interface(
    name: &str,
    owner: Owner,
    role: Role,
    pose: Pose,
    patch: bool,
    half: Option<[f64; 2]>,
) -> Interface {
    Interface {
        name: name.into(),
        owner,
        role,
        body_from_interface: pose,
        patch,
        half_size: half,
        limb: -Vector3::z(),
        contact_types: vec![],
        max_force: 200.0,
        max_moment: 10.0,
        mu: 0.7,
        mu_r: 0.03,
        overhang: false,
        lands: true,
        bears_feet: true,
    }
}

fn placed(pose: Pose, shape: Shape) -> PlacedShape {
    PlacedShape {
        body_from_shape: pose,
        shape,
    }
}

/// A random robot with balls on its links, a ground, a table and a box; interfaces:
/// 0 foot (patch), 1 hand (patch), 2 tip (point), 3 box bottom, 4 box side, 5 ground, 6 table top.
#[allow(clippy::too_many_lines)] // one expression or layout, written down in its own order
pub fn random_scene(seed: u64) -> Scene {
    let mut model = Model::random(seed, Root::Floating, 7);
    for joint in model.joints.iter_mut().skip(1).step_by(2) {
        joint.torque_limit = 40.0;
        joint.torque_speed = Some(TorqueSpeed {
            corner: 3.0,
            no_load: 7.0,
        });
    }
    let n_joints = model.nv - 6;
    let shapes: Vec<_> = model
        .frames
        .iter()
        .enumerate()
        .map(|(i, _)| {
            vec![
                placed(Pose::random(i as u64), Shape::Sphere { radius: 0.05 }),
                placed(
                    Pose::random(i as u64 + 50),
                    Shape::Capsule {
                        radius: 0.03,
                        half_length: 0.1,
                    },
                ),
            ]
        })
        .collect();
    let frames = model.frames.len();
    let flip = Pose::exp(&Vector6::new(0.0, 0.0, 0.0, std::f64::consts::PI, 0.0, 0.0));
    let mut start = model.random_configuration(seed + 1);
    start.truncate(model.nq);
    let table = Pose::from_translation(0.4, 0.1, 0.6);
    let half = Vector3::new(0.1, 0.08, 0.07);
    let link = |i: usize| Owner::Robot {
        frame: frames - 1 - i % frames,
    };
    let interfaces = vec![
        interface(
            "foot",
            link(0),
            Role::Foot,
            Pose::random(3),
            true,
            Some([0.08, 0.03]),
        ),
        interface(
            "hand",
            link(1),
            Role::Hand,
            Pose::random(4),
            true,
            Some([0.02, 0.02]),
        ),
        interface("tip", link(2), Role::Hand, Pose::random(5), false, None),
        interface(
            "box_bottom",
            Owner::Object(0),
            Role::Surface,
            Pose::from_translation(0.0, 0.0, -half.z) * flip,
            true,
            Some([0.1, 0.08]),
        ),
        interface(
            "box_side",
            Owner::Object(0),
            Role::Surface,
            Pose::random(9),
            true,
            Some([0.05, 0.05]),
        ),
        interface(
            "ground_top",
            Owner::Static(0),
            Role::Surface,
            Pose::identity(),
            true,
            None,
        ),
        Interface {
            overhang: true,
            ..interface(
                "table_top",
                Owner::Static(1),
                Role::Surface,
                table,
                true,
                Some([0.3, 0.2]),
            )
        },
    ];
    Scene {
        doubts: vec![],
        name: "random".into(),
        gravity: Vector3::new(0.0, 0.0, -9.81),
        robot: Robot {
            name: "random".into(),
            urdf: String::new(),
            home: vec![0.1; n_joints],
            shapes,
            model,
        },
        start,
        objects: vec![Object {
            name: "box".into(),
            mass: 1.3,
            inertia: Matrix3::from_diagonal(&Vector3::new(0.004, 0.005, 0.006)),
            shapes: vec![placed(Pose::identity(), Shape::Box { half_size: half })],
            world_from_start: Pose::from_translation(0.4, 0.1, 0.67),
        }],
        statics: vec![
            StaticBody {
                name: "ground".into(),
                shapes: vec![placed(Pose::identity(), Shape::HalfSpace)],
            },
            StaticBody {
                name: "table".into(),
                shapes: vec![placed(
                    Pose::from_translation(0.4, 0.1, 0.3),
                    Shape::Box {
                        half_size: Vector3::new(0.3, 0.2, 0.3),
                    },
                )],
            },
        ],
        interfaces,
        start_contacts: vec![],
        goal_contacts: vec![],
        goal_regions: vec![scene::RegionGoal {
            body: "box".into(),
            lower: Vector3::new(-1.0, -1.0, f64::NEG_INFINITY),
            upper: Vector3::new(1.0, 1.0, f64::INFINITY),
            yaw: Some([-2.0, 1.5]),
            tilt: Some(1.2),
        }],
        objective: Objective::BaseHeight,
        search: SearchOptions {
            max_phases: None,
            max_skeleton: None,
            max_changes: 1,
            support_hands: true,
            flights: true,
            domain: None,
            steps: 8,
        },
        optimiser: OptimiserOptions {
            steps: 3,
            min_duration: 0.2,
            max_duration: 1.5,
            torque_limits: true,
            max_iterations: 100,
        },
    }
}

/// A contact state of these pairs of interfaces.
pub fn state(pairs: &[(usize, usize, ContactType)]) -> ContactState {
    let contacts: BTreeSet<_> = pairs
        .iter()
        .map(|&(a, b, kind)| Contact {
            a: InterfaceId(a),
            b: InterfaceId(b),
            kind,
        })
        .collect();
    ContactState { contacts }
}

/// A program with every kind of contact, at a random point around which everything moves.
pub fn program(seed: u64, grid: Grid, preset: Preset) -> (Trajectory, Point) {
    program_with(seed, grid, preset, Integrator::Euler)
}

/// The same with an integrator.
pub fn program_with(
    seed: u64,
    grid: Grid,
    preset: Preset,
    integrator: Integrator,
) -> (Trajectory, Point) {
    of_phases(seed, grid, preset, integrator, false)
}

/// The same or, if `fine`, backwards in time, so that the foot lands, in steps of 20 ms at most.
pub fn of_phases(
    seed: u64,
    grid: Grid,
    preset: Preset,
    integrator: Integrator,
    fine: bool,
) -> (Trajectory, Point) {
    let scene = random_scene(seed);
    let system = System::new(&scene).expect("a model");
    let collisions = CollisionModel::new(&scene, &system);
    let phase = |steps, pairs: &[_]| Phase {
        state: state(pairs),
        steps,
    };
    let mut phases = vec![
        phase(3, &[(0, 5, UnilateralPatch), (3, 6, UnilateralPatch)]),
        phase(
            2,
            &[
                (0, 5, UnilateralPatch),
                (1, 4, BilateralPatch),
                (2, 4, UnilateralPoint),
            ],
        ),
        phase(
            3,
            &[
                (1, 4, BilateralPatch),
                (2, 6, UnilateralPoint),
                (3, 6, UnilateralPatch),
            ],
        ),
    ];
    let mut settings = Settings {
        integrator,
        ..Settings::new(preset, &scene.optimiser)
    };
    if preset == Preset::Paper {
        settings.sticking = Sticking::Velocity;
    }
    settings.weights.balance = 2.0;
    if fine {
        phases.reverse();
        settings.max_step = 0.02;
        // Beside hundreds differences see nothing else.
        settings.weights.landing_acceleration = 1.0;
        settings.weights.landing_balance = 1.0;
        settings.weights.shear = 1.0;
    }
    let mut random = Random::new(seed + 5);
    let n: usize = match grid {
        Grid::Motion | Grid::Path => 8,
        Grid::Keyframes | Grid::OpenKeyframes | Grid::State => 3,
    };
    let start = system.start(&scene);
    let mut nodes = vec![start.clone()];
    for _ in 0..n {
        let step: Vec<f64> = (0..system.model.nv)
            .map(|_| random.uniform(-0.15, 0.15))
            .collect();
        nodes.push(system.model.integrate(&nodes[nodes.len() - 1], &step));
    }
    if grid == Grid::Motion {
        if integrator == Integrator::Euler {
            nodes[1].copy_from_slice(&start);
        }
        let rest = nodes[n - 1].clone();
        nodes[n].copy_from_slice(&rest);
    }
    let program = Program::new(
        &scene,
        &system,
        &collisions,
        &phases,
        &settings,
        grid,
        ocp::collision::Clearances::Near {
            nodes: &nodes,
            crossings: &ocp::collision::Crossings::new(),
        },
    );
    let wrenches = program
        .intervals
        .iter()
        .map(|i| (0..i.n_wrench).map(|_| random.uniform(-1.0, 1.0)).collect())
        .collect();
    let mut velocities = vec![];
    if integrator.has_velocities() {
        let nv = system.model.nv;
        velocities = vec![vec![0.0; nv]; n + 1];
        for v in &mut velocities[1..n - 1] {
            v.fill_with(|| random.uniform(-1.0, 1.0));
        }
    }
    let durations = if grid == Grid::Motion {
        vec![0.9, 0.6, 1.2]
    } else {
        vec![1.0; 3]
    };
    (
        Trajectory::new(program),
        Point {
            nodes,
            velocities,
            wrenches,
            durations,
        },
    )
}
