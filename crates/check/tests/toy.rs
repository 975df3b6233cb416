//! Valid plans of the toy robot (`toy.urdf`), right by construction.
//!
//! Everything moves in the x–z plane, so the dynamics are written down by hand: each body has its place, velocity
//! and acceleration as plain trigonometry, forces on the feet are what momentum (or the accelerations) ask for, shared
//! equally, and the joint forces follow from the free-body diagrams of legs, arm and hand.
//!
//! - `stand`: one phase; the stick leans on a shelf behind, a box rests on the table in front.
//! - `lift`: the hand holds the box by its top, then lifts it while the legs stretch and the arm swings.

use nalgebra::Vector3;
use plan::{
    Contact, ContactType, Dynamics, Extra, Geometry, GoalContact, Integrator, Interface,
    InterfaceKind, Object, ObjectStates, Phase, Plan, Pose7, Robot, Row6, StaticBody, Status,
};
use spatial::{Pose, exp_so3};

const URDF: &str = include_str!("toy.urdf");
const G: f64 = 9.81;
const DT: f64 = 0.01;
/// Centre of the sole, seen from the leg.
const SOLE_IN_LEG: [f64; 3] = [0.05, 0.0, -0.4];
const BASE_HEIGHT: f64 = 0.6;
const BOX_HALF: f64 = 0.05;
const BOX_MASS: f64 = 1.2;
const BOX_INERTIA: f64 = 0.003;
const NO_TURN: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
const UPSIDE_DOWN: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

fn xz(x: f64, z: f64) -> Vector3<f64> {
    Vector3::new(x, 0.0, z)
}

fn pose7(p: Vector3<f64>, [x, y, z, w]: [f64; 4]) -> Pose7 {
    [p.x, p.y, p.z, x, y, z, w]
}

/// A vector of the x–z plane turned by `angle` about y.
fn turned(v: Vector3<f64>, angle: f64) -> Vector3<f64> {
    xz(
        angle.cos() * v.x + angle.sin() * v.z,
        -angle.sin() * v.x + angle.cos() * v.z,
    )
}

/// ω ŷ × r
fn spin(omega: f64, r: Vector3<f64>) -> Vector3<f64> {
    xz(omega * r.z, -omega * r.x)
}

/// y component of r × f
fn moment(r: Vector3<f64>, f: Vector3<f64>) -> f64 {
    r.z * f.x - r.x * f.z
}

/// Height of the base, angles of shoulder and wrist; or their rates.
type Coordinates = [f64; 3];

/// A point with its velocity and acceleration.
#[derive(Clone, Copy)]
struct Point {
    p: Vector3<f64>,
    v: Vector3<f64>,
    a: Vector3<f64>,
}

impl Point {
    /// The point `r` further along a rod at `angle` that turns with `rate` and `accel`.
    fn along(self, r: Vector3<f64>, [angle, rate, accel]: [f64; 3]) -> Self {
        let r = turned(r, angle);
        let v = spin(rate, r);
        Self {
            p: self.p + r,
            v: self.v + v,
            a: self.a + spin(accel, r) + spin(rate, v),
        }
    }
}

struct Body {
    mass: f64,
    inertia: f64,
    at: Point,
    rate: f64,
    accel: f64,
}

impl Body {
    /// Force that moves it so against gravity.
    fn force(&self) -> Vector3<f64> {
        (self.at.a + xz(0.0, G)) * self.mass
    }

    /// Moment about `point` that moves it so.
    fn moment_about(&self, point: Vector3<f64>) -> f64 {
        self.inertia * self.accel + moment(self.at.p - point, self.force())
    }
}

/// The robot at one node.
struct Snapshot {
    bodies: [Body; 6],
    shoulder: Vector3<f64>,
    wrist: Vector3<f64>,
    palm: Vector3<f64>,
    stick_tip: Vector3<f64>,
}

impl Snapshot {
    fn new(x: Coordinates, v: Coordinates, a: Coordinates) -> Self {
        let fixed = |p| Point {
            p,
            v: Vector3::zeros(),
            a: Vector3::zeros(),
        };
        let base = Point {
            p: xz(0.0, x[0]),
            v: xz(0.0, v[0]),
            a: xz(0.0, a[0]),
        };
        let upright = [0.0; 3];
        let arm_turn = [x[1], v[1], a[1]];
        let hand_turn = [x[1] + x[2], v[1] + v[2], a[1] + a[2]];
        let shoulder = base.along(xz(0.12, 0.1), upright);
        let wrist = shoulder.along(xz(0.3, 0.0), arm_turn);
        let body = |mass, inertia, at, [_, rate, accel]: [f64; 3]| Body {
            mass,
            inertia,
            at,
            rate,
            accel,
        };
        // The legs stand: their joints follow the base. Their lateral places cancel.
        let leg = || body(1.5, 0.02, fixed(xz(0.0, 0.1)), upright);
        let bodies = [
            body(10.0, 0.10, base, upright),
            leg(),
            leg(),
            body(0.2, 0.003, base.along(xz(-0.28, 0.0), upright), upright),
            body(
                1.0,
                0.008,
                shoulder.along(xz(0.15, 0.0), arm_turn),
                arm_turn,
            ),
            body(
                0.4,
                0.0006,
                wrist.along(xz(0.05, 0.0), hand_turn),
                hand_turn,
            ),
        ];
        let palm = wrist.along(xz(0.08, -0.03), hand_turn).p;
        let stick_tip = base.p + xz(-0.48, -0.015);
        Self {
            bodies,
            shoulder: shoulder.p,
            wrist: wrist.p,
            palm,
            stick_tip,
        }
    }

    fn mass(&self) -> f64 {
        self.bodies.iter().map(|b| b.mass).sum()
    }

    fn com(&self) -> Vector3<f64> {
        self.bodies
            .iter()
            .map(|b| b.at.p * b.mass)
            .sum::<Vector3<f64>>()
            / self.mass()
    }

    /// Linear momentum and angular momentum about the centre of mass.
    fn momentum(&self) -> (Vector3<f64>, f64) {
        let com = self.com();
        let linear = self.bodies.iter().map(|b| b.at.v * b.mass).sum();
        let angular = self
            .bodies
            .iter()
            .map(|b| b.inertia * b.rate + moment(b.at.p - com, b.at.v * b.mass))
            .sum();
        (linear, angular)
    }
}

/// A wrench in the plane: force, and moment about y.
#[derive(Clone, Copy)]
struct Planar(Vector3<f64>, f64);

impl Planar {
    fn row(self) -> Row6 {
        [self.0.x, self.0.y, self.0.z, 0.0, self.1, 0.0]
    }
}

/// Which plan to build.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Recipe {
    pub integrator: Integrator,
    pub dynamics: Dynamics,
    /// Stretch of the legs [m], swing of shoulder and wrist [rad] over the motion.
    pub travel: Coordinates,
}

impl Default for Recipe {
    fn default() -> Self {
        Self {
            integrator: Integrator::Euler,
            dynamics: Dynamics::Momentum,
            travel: [0.0; 3],
        }
    }
}

/// A robot that stands still: stick on the shelf, box on the table.
pub(crate) fn stand() -> Plan {
    Builder::new(Recipe::default(), &[20]).plan("stand")
}

/// The same without leaning on the stick.
pub(crate) fn stand_without_leaning() -> Plan {
    Builder {
        lean: Vector3::zeros(),
        ..Builder::new(Recipe::default(), &[20])
    }
    .plan("stand")
}

/// A robot that lifts the box.
pub(crate) fn lift() -> Plan {
    lift_by(Recipe {
        travel: [0.08, -0.25, 0.15],
        ..Recipe::default()
    })
}

/// A robot that lifts the box, built otherwise.
pub(crate) fn lift_by(recipe: Recipe) -> Plan {
    Builder::new(recipe, &[6, 40]).plan("lift")
}

/// Everything over time, in the making.
struct Builder {
    recipe: Recipe,
    /// Force of the shelf on the stick, when standing [N].
    lean: Vector3<f64>,
    steps: Vec<usize>,
    x: Vec<Coordinates>,
    v: Vec<Coordinates>,
    a: Vec<Coordinates>,
    box_pose: Vec<Pose>,
    box_twist: Vec<Row6>,
    box_accel: Vec<Row6>,
}

impl Builder {
    fn new(recipe: Recipe, steps: &[usize]) -> Self {
        let n: usize = steps.iter().sum();
        let moving = steps.last().copied().unwrap_or(1) as f64;
        let first = n as f64 - moving;
        // Velocities rise and fall smoothly over the last phase; they sum to the travel.
        let rate = |t: usize| {
            let share = ((t as f64 - first) / moving).max(0.0);
            recipe
                .travel
                .map(|x| x * 2.0 / (moving * DT) * (std::f64::consts::PI * share).sin().powi(2))
        };
        let v: Vec<_> = (0..=n).map(rate).collect();
        let a: Vec<_> = (0..n)
            .map(|t| [0, 1, 2].map(|i| (v[t + 1][i] - v[t][i]) / DT))
            .collect();
        let mut x = vec![[BASE_HEIGHT, 0.0, 0.0]];
        for t in 0..n {
            let step = |i: usize| match recipe.integrator {
                Integrator::Euler => v[t][i] * DT,
                Integrator::SemiImplicitEuler => v[t + 1][i] * DT,
                Integrator::ConstantAcceleration => v[t][i] * DT + 0.5 * a[t][i] * DT * DT,
            };
            x.push([0, 1, 2].map(|i| x[t][i] + step(i)));
        }
        let box_pose: Vec<_> = x.iter().map(|x| box_under_palm(*x)).collect();
        let mut builder = Self {
            recipe,
            lean: xz(1.5, 8.0),
            steps: steps.to_vec(),
            x,
            v,
            a,
            box_pose,
            box_twist: Vec::new(),
            box_accel: Vec::new(),
        };
        builder.box_rates();
        builder
    }

    fn n(&self) -> usize {
        self.a.len()
    }

    /// The box's twists are such that the integrator leads exactly from pose to pose.
    fn box_rates(&mut self) {
        let n = self.n();
        let screw = |t: usize| self.box_pose[t + 1].minus(&self.box_pose[t]) / DT;
        let row = |xi: nalgebra::Vector6<f64>| -> Row6 { xi.into() };
        self.box_twist = match self.recipe.integrator {
            Integrator::Euler => (0..n).map(screw).map(row).chain([[0.0; 6]]).collect(),
            Integrator::SemiImplicitEuler => [[0.0; 6]]
                .into_iter()
                .chain((0..n).map(screw).map(row))
                .collect(),
            // Only a vertical motion, exact under this rule too.
            Integrator::ConstantAcceleration => self
                .v
                .iter()
                .map(|v| [0.0, 0.0, v[0], 0.0, 0.0, 0.0])
                .collect(),
        };
        let twist = &self.box_twist;
        self.box_accel = (0..n)
            .map(|t| std::array::from_fn(|i| (twist[t + 1][i] - twist[t][i]) / DT))
            .collect();
    }

    /// What moves the box so: force, and moment about its centre.
    fn box_load(&self, t: usize) -> Planar {
        let (twist, accel) = (self.box_twist[t], self.box_accel[t]);
        let part = |x: Row6, i: usize| Vector3::new(x[i], x[i + 1], x[i + 2]);
        let acceleration = part(accel, 0) + part(twist, 3).cross(&part(twist, 0));
        let force = (self.box_pose[t].rotate(acceleration) + xz(0.0, G)) * BOX_MASS;
        Planar(force, BOX_INERTIA * accel[4])
    }

    fn snapshot(&self, t: usize) -> Snapshot {
        Snapshot::new(
            self.x[t],
            self.v[t],
            self.a.get(t).copied().unwrap_or_default(),
        )
    }

    /// Wrenches on foot (each), palm and stick, about the sole, the palm and the tip; and the joint forces.
    fn loads(&self, t: usize, palm: Planar, stick: Planar) -> (Planar, [f64; 4]) {
        let now = self.snapshot(t);
        let com = now.com();
        let (force, about_com) = match self.recipe.dynamics {
            Dynamics::Momentum => {
                let ((p, l), (p_next, l_next)) = (now.momentum(), self.snapshot(t + 1).momentum());
                (
                    (p_next - p) / DT + xz(0.0, G * now.mass()),
                    (l_next - l) / DT,
                )
            }
            Dynamics::BaseRows => (
                now.bodies.iter().map(Body::force).sum(),
                now.bodies.iter().map(|b| b.moment_about(com)).sum(),
            ),
        };
        let at_com = |load: Planar, at: Vector3<f64>| load.1 + moment(at - com, load.0);
        let feet = force - palm.0 - stick.0;
        let feet_about_com = about_com - at_com(palm, now.palm) - at_com(stick, now.stick_tip);
        let sole = xz(SOLE_IN_LEG[0], 0.0);
        let foot = Planar(
            feet / 2.0,
            (feet_about_com - moment(sole - com, feet)) / 2.0,
        );

        let [.., leg, _, arm, hand] = &now.bodies;
        // A leg slides down along its axis −z; it needs its own weight less what the ground gives.
        let slide = -(leg.force().z - foot.0.z);
        let on_palm = |about: Vector3<f64>| palm.1 + moment(now.palm - about, palm.0);
        let wrist = hand.moment_about(now.wrist) - on_palm(now.wrist);
        let shoulder = arm.moment_about(now.shoulder) + hand.moment_about(now.shoulder)
            - on_palm(now.shoulder);
        (foot, [slide, slide, shoulder, wrist])
    }

    fn plan(&self, task: &str) -> Plan {
        let n = self.n();
        let lifting = self.steps.len() > 1;
        let mut tau = Vec::new();
        let [mut feet, mut palms, mut sticks, mut bottoms] = [(); 4].map(|()| Vec::new());
        for t in 0..n {
            let Planar(force, torque) = self.box_load(t);
            let centre_to_palm = self.box_pose[t].rotate(xz(0.0, BOX_HALF));
            let held = t >= self.steps[0];
            let zero = Planar(Vector3::zeros(), 0.0);
            let palm = if held {
                Planar(-force, -(torque - moment(centre_to_palm, force)))
            } else {
                zero
            };
            let stick = if lifting {
                zero
            } else {
                Planar(self.lean, 0.0)
            };
            let (foot, joints) = self.loads(t, palm, stick);
            feet.push(foot.row());
            palms.push(palm.row());
            sticks.push(stick.row());
            bottoms.push(Planar(force, torque).row());
            tau.push(joints.to_vec());
        }
        let start = self.snapshot(0);
        let contact = |a: &str, b: &str, kind, wrench: &[Row6]| Contact {
            a: a.into(),
            b: b.into(),
            kind,
            mu: 0.7,
            mu_r: 0.02,
            overhang: false,
            wrench: wrench.to_vec(),
            extra: Extra::new(),
        };
        let mut phases = Vec::new();
        let mut first = 0;
        for (k, steps) in self.steps.iter().enumerate() {
            let s = first..first + steps;
            first += steps;
            let mut contacts = vec![
                contact(
                    "left_foot",
                    "ground_top",
                    ContactType::UnilateralPatch,
                    &feet[s.clone()],
                ),
                contact(
                    "right_foot",
                    "ground_top",
                    ContactType::UnilateralPatch,
                    &feet[s.clone()],
                ),
            ];
            if k == 0 {
                contacts.push(contact(
                    "box_bottom",
                    "table_top",
                    ContactType::UnilateralPatch,
                    &bottoms[s.clone()],
                ));
            }
            contacts.push(if lifting {
                contact("palm", "box_top", ContactType::BilateralPatch, &palms[s])
            } else {
                contact("tip", "shelf_top", ContactType::UnilateralPoint, &sticks[s])
            });
            let action = ["start", "lift box"][k].to_owned();
            phases.push(Phase {
                duration: *steps as f64 * DT,
                steps: *steps,
                action,
                contacts,
                extra: Extra::new(),
            });
        }
        let momentum = |t: usize| {
            let (linear, angular) = self.snapshot(t).momentum();
            Planar(linear, angular).row()
        };
        let vector = |x: Coordinates| vec![0.0, 0.0, x[0], 0.0, 0.0, 0.0, x[0], x[0], x[1], x[2]];
        let configuration = |x: &Coordinates| {
            let leg = x[0] - BASE_HEIGHT;
            let base = pose7(xz(0.0, x[0]), NO_TURN);
            base.into_iter().chain([leg, leg, x[1], x[2]]).collect()
        };
        let states = ObjectStates {
            pose: self.box_pose.iter().map(Pose::to_xyzquat).collect(),
            twist: self.box_twist.clone(),
            accel: self.box_accel.clone(),
            extra: Extra::new(),
        };
        let goal = if lifting {
            ("palm", "box_top")
        } else {
            ("box_bottom", "table_top")
        };
        Plan {
            format: plan::FORMAT.into(),
            generator: "toy".into(),
            task: task.into(),
            status: Status::Feasible,
            objective: None,
            violation: None,
            gravity: [0.0, 0.0, -G],
            integrator: self.recipe.integrator,
            dynamics: self.recipe.dynamics,
            robot: Robot {
                name: "toy".into(),
                urdf: URDF.into(),
                joints: ["left_slide", "right_slide", "shoulder", "wrist"]
                    .map(String::from)
                    .to_vec(),
                torque_limits: Some(vec![Some(200.0), Some(200.0), Some(30.0), Some(10.0)]),
                extra: Extra::new(),
            },
            objects: vec![Object {
                name: "box".into(),
                mass: BOX_MASS,
                inertia: [BOX_INERTIA, BOX_INERTIA, BOX_INERTIA, 0.0, 0.0, 0.0],
                geometry: vec![Geometry::cuboid(
                    [BOX_HALF; 3],
                    pose7(Vector3::zeros(), NO_TURN),
                )],
                extra: Extra::new(),
            }],
            environment: environment(&start),
            interfaces: interfaces(&start),
            goal: vec![GoalContact {
                a: goal.0.into(),
                b: goal.1.into(),
                extra: Extra::new(),
            }],
            goal_regions: Vec::new(),
            phases,
            time: (0..=n).map(|t| t as f64 * DT).collect(),
            q: self.x.iter().map(configuration).collect(),
            v: self.v.iter().map(|v| vector(*v)).collect(),
            h: (0..=n).map(momentum).collect(),
            a: self.a.iter().map(|a| vector(*a)).collect(),
            tau,
            object_states: [("box".to_owned(), states)].into(),
            extra: Extra::new(),
        }
    }
}

/// Pose of the box whose top the palm holds.
fn box_under_palm(x: Coordinates) -> Pose {
    let angle = x[1] + x[2];
    let palm = Snapshot::new(x, [0.0; 3], [0.0; 3]).palm;
    Pose::from_parts(
        exp_so3(&(Vector3::y() * angle)),
        palm + turned(xz(0.0, -BOX_HALF), angle),
    )
}

fn environment(start: &Snapshot) -> Vec<StaticBody> {
    let block = |name: &str, top: Vector3<f64>, half: f64| StaticBody {
        name: name.into(),
        geometry: vec![Geometry::cuboid(
            [half, half, 0.02],
            pose7(top - xz(0.0, 0.02), NO_TURN),
        )],
        extra: Extra::new(),
    };
    let ground = Geometry::half_space(pose7(Vector3::zeros(), NO_TURN));
    vec![
        StaticBody {
            name: "ground".into(),
            geometry: vec![ground],
            extra: Extra::new(),
        },
        block("table", start.palm - xz(0.0, 2.0 * BOX_HALF), 0.08),
        block("shelf", start.stick_tip, 0.05),
    ]
}

fn interfaces(start: &Snapshot) -> Vec<Interface> {
    let interface =
        |name: &str, body: &str, at: Vector3<f64>, turn, kind, half: Option<[f64; 2]>| Interface {
            name: name.into(),
            body: body.into(),
            pose: pose7(at, turn),
            kind,
            half_size: half.map(|half| half.map(Some)),
            limb: None,
            extra: Extra::new(),
        };
    let (patch, point) = (InterfaceKind::Patch, InterfaceKind::Point);
    let sole = Some([0.12, 0.04]);
    vec![
        interface(
            "left_foot",
            "left_leg",
            SOLE_IN_LEG.into(),
            UPSIDE_DOWN,
            patch,
            sole,
        ),
        interface(
            "right_foot",
            "right_leg",
            SOLE_IN_LEG.into(),
            UPSIDE_DOWN,
            patch,
            sole,
        ),
        interface(
            "palm",
            "hand",
            xz(0.08, -0.03),
            UPSIDE_DOWN,
            patch,
            Some([0.02, 0.02]),
        ),
        interface("tip", "stick", xz(-0.4, -0.015), UPSIDE_DOWN, point, None),
        interface(
            "box_bottom",
            "box",
            xz(0.0, -BOX_HALF),
            UPSIDE_DOWN,
            patch,
            Some([BOX_HALF; 2]),
        ),
        interface(
            "box_top",
            "box",
            xz(0.0, BOX_HALF),
            NO_TURN,
            patch,
            Some([BOX_HALF; 2]),
        ),
        interface(
            "ground_top",
            "ground",
            Vector3::zeros(),
            NO_TURN,
            patch,
            None,
        ),
        interface(
            "table_top",
            "table",
            start.palm - xz(0.0, 2.0 * BOX_HALF),
            NO_TURN,
            patch,
            Some([0.08; 2]),
        ),
        interface(
            "shelf_top",
            "shelf",
            start.stick_tip,
            NO_TURN,
            patch,
            Some([0.05; 2]),
        ),
    ]
}
