//! Valid plans of the toy robot (`toy.urdf`), right by construction.
//!
//! Everything moves in the x–z plane, so the dynamics are written down by hand: each body has its place, velocity
//! and acceleration as plain trigonometry, forces on the feet are what momentum (or the accelerations) ask for, shared
//! equally, and the joint forces follow from the free-body diagrams of legs, arm and hand.
//!
//! - `stand`: one phase; the stick leans on a shelf behind, a box rests on the table in front.
//! - `lift`: the hand holds the box by its top, then lifts it while the legs stretch and the arm swings.

mod planar;
mod scene;

use nalgebra::Vector3;
use plan::{
    Contact, ContactType, Dynamics, Extra, GoalContact, Integrator, ObjectStates, Phase, Plan,
    Row6, Status,
};
use spatial::{Pose, exp_so3};

use planar::{Body, Coordinates, G, Planar, Snapshot, moment, turned, xz};
use scene::{BOX_HALF, BOX_INERTIA, BOX_MASS, NO_TURN, SOLE_IN_LEG, pose7};

const DT: f64 = 0.01;
const BASE_HEIGHT: f64 = 0.6;

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

    fn lifting(&self) -> bool {
        self.steps.len() > 1
    }

    /// Wrenches of all contacts and joint forces, over time.
    fn all_loads(&self) -> AllLoads {
        let mut all = AllLoads::default();
        for t in 0..self.n() {
            let Planar(force, torque) = self.box_load(t);
            let centre_to_palm = self.box_pose[t].rotate(xz(0.0, BOX_HALF));
            let zero = Planar(Vector3::zeros(), 0.0);
            let held = t >= self.steps[0];
            let palm = if held {
                Planar(-force, -(torque - moment(centre_to_palm, force)))
            } else {
                zero
            };
            let stick = if self.lifting() {
                zero
            } else {
                Planar(self.lean, 0.0)
            };
            let (foot, joints) = self.loads(t, palm, stick);
            all.feet.push(foot.row());
            all.palm.push(palm.row());
            all.stick.push(stick.row());
            all.bottom.push(Planar(force, torque).row());
            all.tau.push(joints.to_vec());
        }
        all
    }

    fn phases(&self, loads: &AllLoads) -> Vec<Phase> {
        let (unilateral, bilateral) = (ContactType::UnilateralPatch, ContactType::BilateralPatch);
        let mut phases = Vec::new();
        let mut first = 0;
        for (k, steps) in self.steps.iter().enumerate() {
            let s = first..first + steps;
            first += steps;
            let mut contacts = vec![
                contact(
                    "left_foot",
                    "ground_top",
                    unilateral,
                    &loads.feet[s.clone()],
                ),
                contact(
                    "right_foot",
                    "ground_top",
                    unilateral,
                    &loads.feet[s.clone()],
                ),
            ];
            if k == 0 {
                contacts.push(contact(
                    "box_bottom",
                    "table_top",
                    unilateral,
                    &loads.bottom[s.clone()],
                ));
            }
            contacts.push(if self.lifting() {
                contact("palm", "box_top", bilateral, &loads.palm[s])
            } else {
                contact(
                    "tip",
                    "shelf_top",
                    ContactType::UnilateralPoint,
                    &loads.stick[s],
                )
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
        phases
    }

    fn plan(&self, task: &str) -> Plan {
        let n = self.n();
        let loads = self.all_loads();
        let start = self.snapshot(0);
        let momentum = |t: usize| {
            let (linear, angular) = self.snapshot(t).momentum();
            Planar(linear, angular).row()
        };
        let vector = |x: &Coordinates| vec![0.0, 0.0, x[0], 0.0, 0.0, 0.0, x[0], x[0], x[1], x[2]];
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
        let goal = if self.lifting() {
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
            robot: scene::robot(),
            objects: vec![scene::object()],
            environment: scene::environment(&start),
            interfaces: scene::interfaces(&start),
            goal: vec![GoalContact {
                a: goal.0.into(),
                b: goal.1.into(),
                extra: Extra::new(),
            }],
            goal_regions: Vec::new(),
            explanation: None,
            costs: None,
            phases: self.phases(&loads),
            time: (0..=n).map(|t| t as f64 * DT).collect(),
            q: self.x.iter().map(configuration).collect(),
            v: self.v.iter().map(vector).collect(),
            h: (0..=n).map(momentum).collect(),
            a: self.a.iter().map(vector).collect(),
            tau: loads.tau,
            object_states: [("box".to_owned(), states)].into(),
            extra: Extra::new(),
        }
    }
}

/// Wrenches by contact, and joint forces; one row per interval.
#[derive(Default)]
struct AllLoads {
    feet: Vec<Row6>,
    palm: Vec<Row6>,
    stick: Vec<Row6>,
    bottom: Vec<Row6>,
    tau: Vec<Vec<f64>>,
}

fn contact(a: &str, b: &str, kind: ContactType, wrench: &[Row6]) -> Contact {
    let wrench = wrench.to_vec();
    Contact {
        a: a.into(),
        b: b.into(),
        kind,
        mu: 0.7,
        mu_r: 0.02,
        overhang: false,
        wrench,
        extra: Extra::new(),
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
