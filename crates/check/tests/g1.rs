//! The built-in G1 stands still: the forces are those of statics, the torques those of virtual work.
//!
//! Torques: τ_j = ∂V/∂q_j − Σ (f · ∂x/∂q_j + μ · ∂θ/∂q_j), with V the potential energy and (f, μ) the wrench at the sole x,
//! by central differences of a forward kinematics of the test's own.

use std::collections::BTreeMap;
use std::path::Path;

use check::{Options, check};
use nalgebra::Vector3;
use plan::{
    Contact, ContactType, Dynamics, Extra, Geometry, Integrator, Interface, InterfaceKind, Phase,
    Plan, Robot,
};
use plan::{Row6, StaticBody, Status};
use spatial::{Pose, exp_so3, log_so3};

const G: f64 = 9.81;
const SOLE: [f64; 7] = [0.035, 0.0, -0.0354, 1.0, 0.0, 0.0, 0.0];
const POSTURE: [(&str, f64); 8] = [
    ("hip_pitch", -0.2),
    ("knee", 0.5),
    ("ankle_pitch", -0.3),
    ("shoulder_pitch", 0.7),
    ("left_shoulder_roll", 0.18),
    ("right_shoulder_roll", -0.18),
    ("elbow", -0.2),
    ("wrist_yaw", 0.1),
];
const FEET: [&str; 2] = ["left_ankle_roll_link", "right_ankle_roll_link"];

struct G1 {
    text: String,
    urdf: urdf_rs::Robot,
    joints: Vec<String>,
}

impl G1 {
    fn read() -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/g1.urdf");
        let text = std::fs::read_to_string(path).unwrap();
        let urdf = urdf_rs::read_from_string(&text).unwrap();
        let movable = urdf
            .joints
            .iter()
            .filter(|j| j.joint_type == urdf_rs::JointType::Revolute);
        let joints = movable.map(|j| j.name.clone()).collect();
        Self { text, urdf, joints }
    }

    fn posture(&self) -> Vec<f64> {
        let angle = |name: &String| {
            POSTURE
                .iter()
                .find(|(part, _)| name.contains(part))
                .map_or(0.0, |(_, x)| *x)
        };
        self.joints.iter().map(angle).collect()
    }

    /// Poses of all links, seen from the base.
    fn base_from_links(&self, q: &[f64]) -> BTreeMap<&str, Pose> {
        let mut poses = BTreeMap::from([("pelvis", Pose::identity())]);
        while poses.len() < self.urdf.links.len() {
            for joint in &self.urdf.joints {
                let Some(parent) = poses.get(joint.parent.link.as_str()) else {
                    continue;
                };
                let angle = self
                    .joints
                    .iter()
                    .position(|name| *name == joint.name)
                    .map_or(0.0, |j| q[j]);
                let turn = Pose::from_parts(
                    exp_so3(&(Vector3::from(joint.axis.xyz.0) * angle)),
                    Vector3::zeros(),
                );
                let pose = *parent * origin(&joint.origin) * turn;
                poses.insert(&joint.child.link, pose);
            }
        }
        poses
    }

    fn mass(&self) -> f64 {
        self.urdf
            .links
            .iter()
            .map(|link| link.inertial.mass.value)
            .sum()
    }

    fn com(&self, q: &[f64]) -> Vector3<f64> {
        let poses = self.base_from_links(q);
        let moment = |link: &urdf_rs::Link| {
            poses[link.name.as_str()].act(link.inertial.origin.xyz.0.into())
                * link.inertial.mass.value
        };
        self.urdf.links.iter().map(moment).sum::<Vector3<f64>>() / self.mass()
    }

    fn soles(&self, q: &[f64]) -> [Pose; 2] {
        let poses = self.base_from_links(q);
        FEET.map(|foot| poses[foot] * Pose::from_xyzquat(&SOLE))
    }

    /// Torques in equilibrium with the wrenches on the soles; the base stands upright.
    fn torques(&self, q: &[f64], wrenches: &[Row6; 2]) -> Vec<f64> {
        const H: f64 = 1e-5;
        let torque = |j: usize| {
            let [before, after] = [-H, H].map(|h| {
                let mut q = q.to_vec();
                q[j] += h;
                (self.com(&q).z * self.mass() * G, self.soles(&q))
            });
            let mut work = after.0 - before.0;
            for (wrench, (from, to)) in wrenches.iter().zip(before.1.iter().zip(&after.1)) {
                let moved = to.origin() - from.origin();
                let turned = log_so3(&(to.rotation() * from.rotation().transpose()));
                let [force, moment] =
                    [0, 3].map(|i| Vector3::new(wrench[i], wrench[i + 1], wrench[i + 2]));
                work -= force.dot(&moved) + moment.dot(&turned);
            }
            work / (2.0 * H)
        };
        (0..self.joints.len()).map(torque).collect()
    }
}

fn origin(origin: &urdf_rs::Pose) -> Pose {
    let [roll, pitch, yaw] = origin.rpy.0;
    let turn = |axis: Vector3<f64>, angle: f64| exp_so3(&(axis * angle));
    let rotation = turn(Vector3::z(), yaw) * turn(Vector3::y(), pitch) * turn(Vector3::x(), roll);
    Pose::from_parts(rotation, origin.xyz.0.into())
}

/// The weight shared so that each foot's centre of pressure is beside the centre of mass.
fn static_wrenches(g1: &G1, q: &[f64]) -> [Row6; 2] {
    let (com, soles, weight) = (g1.com(q), g1.soles(q).map(|s| s.origin()), g1.mass() * G);
    let share_left = (com.y - soles[1].y) / (soles[0].y - soles[1].y);
    let wrench = |share: f64, sole: Vector3<f64>| {
        let force = share * weight;
        [0.0, 0.0, force, 0.0, -(com.x - sole.x) * force, 0.0]
    };
    [
        wrench(share_left, soles[0]),
        wrench(1.0 - share_left, soles[1]),
    ]
}

fn standing() -> Plan {
    let g1 = G1::read();
    let q = g1.posture();
    let (wrenches, n, steps) = (static_wrenches(&g1, &q), g1.joints.len(), 100);
    let height = -g1.soles(&q)[0].origin().z;
    let row: Vec<f64> = [0.0, 0.0, height, 0.0, 0.0, 0.0, 1.0]
        .into_iter()
        .chain(q.iter().copied())
        .collect();
    let no_turn = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let interface = |name: &str, body: &str, pose, half_size: Option<[f64; 2]>| Interface {
        name: name.into(),
        body: body.into(),
        pose,
        kind: InterfaceKind::Patch,
        half_size: half_size.map(|half| half.map(Some)),
        limb: None,
        extra: Extra::new(),
    };
    let contact = |i: usize| Contact {
        a: FEET[i].into(),
        b: "ground_top".into(),
        kind: ContactType::UnilateralPatch,
        mu: 0.7,
        mu_r: 0.03,
        overhang: false,
        wrench: vec![wrenches[i]; steps],
        extra: Extra::new(),
    };
    let sole = Some([0.085, 0.0275]);
    Plan {
        format: plan::FORMAT.into(),
        generator: "statics".into(),
        task: "stand".into(),
        status: Status::Feasible,
        objective: None,
        violation: None,
        gravity: [0.0, 0.0, -G],
        integrator: Integrator::Euler,
        dynamics: Dynamics::BaseRows,
        robot: Robot {
            name: "g1".into(),
            urdf: g1.text.clone(),
            joints: g1.joints.clone(),
            torque_limits: None,
            torque_speed: BTreeMap::new(),
            extra: Extra::new(),
        },
        objects: Vec::new(),
        environment: vec![StaticBody {
            name: "ground".into(),
            geometry: vec![Geometry::half_space(no_turn)],
            extra: Extra::new(),
        }],
        interfaces: vec![
            interface(FEET[0], FEET[0], SOLE, sole),
            interface(FEET[1], FEET[1], SOLE, sole),
            interface("ground_top", "ground", no_turn, None),
        ],
        goal: Vec::new(),
        goal_regions: Vec::new(),
        explanation: None,
        costs: None,
        phases: vec![Phase {
            duration: 1.0,
            steps,
            action: "stand".into(),
            contacts: vec![contact(0), contact(1)],
            extra: Extra::new(),
        }],
        time: (0..=steps).map(|t| t as f64 * 0.01).collect(),
        q: vec![row; steps + 1],
        v: vec![vec![0.0; 6 + n]; steps + 1],
        h: vec![[0.0; 6]; steps + 1],
        a: vec![vec![0.0; 6 + n]; steps],
        tau: vec![g1.torques(&q, &wrenches); steps],
        object_states: BTreeMap::new(),
        extra: Extra::new(),
    }
}

#[test]
fn the_g1_stands_still_and_passes() {
    let report = check(
        &standing(),
        &Options {
            strict: true,
            ..Options::accept()
        },
    );
    assert!(report.ok(), "{report}");
    for name in [
        "centroidal_force",
        "unactuated_force",
        "unactuated_moment",
        "contact_distance",
    ] {
        assert!(report.row(name).unwrap().value.unwrap() < 1e-9, "{report}");
    }
    assert!(
        report.row("torque_file").unwrap().value.unwrap() < 1e-5,
        "{report}"
    );
    assert_eq!(
        report.row("not_checked").unwrap().value,
        Some(0.0),
        "all links have shapes"
    );
}

#[test]
fn the_g1_with_a_hand_in_its_chest_is_rejected() {
    let mut plan = standing();
    let j = |name: &str| 7 + plan.robot.joints.iter().position(|x| x == name).unwrap();
    let bent = [
        (j("left_shoulder_yaw_joint"), -1.5),
        (j("left_shoulder_roll_joint"), -0.3),
        (j("left_elbow_joint"), -0.9),
    ];
    for q in &mut plan.q {
        for (column, angle) in bent {
            q[column] = angle;
        }
    }
    let report = check(&plan, &Options::default());
    assert!(
        report.failed().any(|name| name == "collision_self"),
        "{report}"
    );
}

#[test]
fn the_g1_with_a_block_under_its_thigh_is_rejected() {
    let mut plan = standing();
    let geometry = vec![Geometry::cuboid(
        [0.03; 3],
        [0.05, 0.12, 0.45, 0.0, 0.0, 0.0, 1.0],
    )];
    plan.environment.push(StaticBody {
        name: "block".into(),
        geometry,
        extra: Extra::new(),
    });
    let report = check(&plan, &Options::default());
    assert_eq!(
        report.failed().collect::<Vec<_>>(),
        ["collision_env"],
        "{report}"
    );
}
