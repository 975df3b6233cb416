//! From a plan to the page's data.

use crate::compact::{Table, all_rounded, rounded};
use crate::loads::loads;
use crate::meshes::Meshes;
use crate::motion::{Carrier, Motion};
use crate::page_data::{
    AxisData, CheckData, ContactData, CostsData, FormData, InterfaceData, JointData, MarginData,
    ObjectData, PhaseData, PlanData, RegionData, RobotData, RowData, ShapeData, StaticData,
};
use crate::robot::{Form, Look, looks};
use crate::torques::TorqueLimits;
use crate::viewpoint::Viewpoint;
use check::{Report, Series};
use multibody::{JointKind, Shape};
use plan::{ContactType, Costs, Geometry, Integrator, Plan, Status};
use spatial::Pose;

/// Resolution of positions [m], quaternions and joint angles [rad].
const POSE_STEP: f64 = 2e-5;
/// Resolution of joint rates [rad/s].
const RATE_STEP: f64 = 2e-3;
/// Resolution of torques [N m].
const TORQUE_STEP: f64 = 0.02;
/// Resolution of shares of limits.
const SHARE_STEP: f64 = 1e-3;
/// Resolution of forces [N] and moments [N m].
const WRENCH_STEP: f64 = 0.02;
/// Resolution of costs per second [1/s].
const COST_RATE_STEP: f64 = 1e-3;
/// Resolution of time [s].
const TIME_STEP: f64 = 1e-5;
/// Residuals below this share of their tolerance all the time get no curve.
const VISIBLE_RESIDUAL: f64 = 0.01;

/// The data of one plan under the name by which the reader calls it.
pub(crate) fn plan_data(
    motion: &Motion,
    meshes: &Meshes,
    name: &str,
    verdict: &(Report, Vec<Series>),
) -> PlanData {
    let plan = motion.plan;
    let limits = TorqueLimits::new(motion);
    let view = Viewpoint::of(motion);
    let rows = |rows: &[Vec<f64>], from: usize, step| {
        Table::new(step, rows.iter().map(|row| row[from..].to_vec()))
    };
    let q = continuous(plan.q.iter().map(Vec::as_slice), 3);
    PlanData {
        name: name.to_owned(),
        task: plan.task.clone(),
        feasible: plan.status == Status::Feasible,
        generator: plan.generator.clone(),
        objective: plan
            .objective
            .as_ref()
            .map(|x| (x.name.clone(), rounded(x.value, 4))),
        cost: plan.objective.as_ref().and_then(|x| x.cost),
        costs: plan.costs.as_ref().map(|x| costs_data(plan, x)),
        integrator: match plan.integrator {
            Integrator::Euler => "explicit Euler",
            Integrator::SemiImplicitEuler => "semi-implicit Euler",
            Integrator::ConstantAcceleration => "constant acceleration",
        },
        view: all_rounded([view.azimuth, view.elevation], 4),
        robot: robot_data(motion, meshes, &limits),
        objects: objects(motion),
        environment: environment(plan),
        interfaces: interfaces(motion),
        goal: goal(motion),
        goal_regions: regions(plan),
        phases: phases(motion),
        time: Table::column(TIME_STEP, plan.time.iter().copied()),
        q: Table::new(POSE_STEP, q),
        rates: rows(&plan.v, 6, RATE_STEP),
        tau: rows(&plan.tau, 0, TORQUE_STEP),
        torque_share: torque_shares(motion, &limits),
        com: Table::new(POSE_STEP, motion.com.iter().map(|c| [c.x, c.y, c.z])),
        check: check_data(verdict),
        quality: plan.extra.get("quality").cloned(),
        explanation: plan.explanation.as_ref().map(|x| x.text.clone()),
    }
}

fn costs_data(plan: &Plan, costs: &Costs) -> CostsData {
    let intervals = plan.time.windows(2).map(|t| t[1] - t[0]);
    let rates = (costs.per_interval.iter().zip(intervals))
        .map(|(row, dt)| row.iter().map(|cost| cost / dt).collect::<Vec<_>>());
    let sum = |i: usize| costs.per_interval.iter().map(|row| row[i]).sum::<f64>();
    let terms = costs.terms.iter().enumerate();
    let end = costs.end.iter();
    CostsData {
        terms: terms
            .map(|(i, x)| (x.clone(), rounded(sum(i), 6)))
            .collect(),
        rates: Table::new(COST_RATE_STEP, rates),
        end: end
            .map(|(x, cost)| (x.clone(), rounded(*cost, 6)))
            .collect(),
    }
}

fn torque_shares(motion: &Motion, limits: &TorqueLimits) -> Table {
    let row = |t: usize| {
        let joints = 0..motion.plan.n_joints();
        joints
            .map(|j| limits.share(motion, j, t))
            .collect::<Vec<_>>()
    };
    Table::new(SHARE_STEP, (0..motion.plan.tau.len()).map(row))
}

/// Rows with the quaternion at column `at` turned into the hemisphere of its predecessor, so that differences stay small.
fn continuous<'r>(rows: impl Iterator<Item = &'r [f64]>, at: usize) -> Vec<Vec<f64>> {
    let mut before = [0.0, 0.0, 0.0, 1.0];
    rows.map(|row| {
        let mut row = row.to_vec();
        let quat = &mut row[at..at + 4];
        let dot: f64 = quat.iter().zip(&before).map(|(x, y)| x * y).sum();
        if dot < 0.0 {
            for x in quat {
                *x = -*x;
            }
        }
        before.copy_from_slice(&row[at..at + 4]);
        row
    })
    .collect()
}

fn robot_data(motion: &Motion, meshes: &Meshes, limits: &TorqueLimits) -> RobotData {
    let (plan, model) = (motion.plan, &motion.model);
    let (looks, mut notes) = looks(model, &plan.robot.urdf, meshes);
    notes.extend(model.notes.iter().cloned());
    let tree = model.joints.iter().zip(motion.order.columns());
    let axis = |(j, name): (usize, &String)| {
        let id = model
            .joint_id(name)
            .expect("joints were looked up when the motion was made");
        let joint = &model.joints[id];
        let finite = |x: f64| x.is_finite().then(|| rounded(x, 4));
        AxisData {
            name: name.clone(),
            torque: limits.largest[j].map(|(limit, _)| limit),
            enforced: limits.largest[j].is_some_and(|(_, enforced)| enforced),
            speed: finite(joint.velocity_limit),
            lower: finite(joint.lower),
            upper: finite(joint.upper),
        }
    };
    RobotData {
        name: plan.robot.name.clone(),
        mass: rounded(model.total_mass(), 3),
        tree: tree
            .map(|(joint, column)| {
                let (kind, axis) = match joint.kind {
                    JointKind::FreeFlyer => ("free", [0.0; 3]),
                    JointKind::Revolute { axis } => ("turn", axis.into()),
                    JointKind::Prismatic { axis } => ("slide", axis.into()),
                };
                JointData {
                    parent: joint.parent,
                    pose: short_pose(&joint.parent_from_joint),
                    kind,
                    axis: all_rounded(axis, 6),
                    q: column,
                }
            })
            .collect(),
        shapes: looks.iter().map(|look| shape_data(motion, look)).collect(),
        joints: plan.robot.joints.iter().enumerate().map(axis).collect(),
        notes,
    }
}

fn shape_data(motion: &Motion, look: &Look) -> ShapeData {
    let frame = &motion.model.frames[look.frame];
    let [r, g, b] = look
        .color
        .map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8);
    let (form, mirror) = match &look.form {
        Form::Primitive(shape) => (primitive(shape), None),
        Form::Surface { index, mirror } => {
            let mirrored = mirror.iter().any(|x| *x < 0.0);
            (FormData::Mesh(*index), mirrored.then_some(*mirror))
        }
    };
    ShapeData {
        joint: frame.joint,
        pose: short_pose(&(frame.joint_from_frame * look.frame_from_shape)),
        form,
        mirror,
        color: Some(format!("#{r:02x}{g:02x}{b:02x}")),
    }
}

fn primitive(shape: &Shape) -> FormData {
    match *shape {
        Shape::Box { half_size } => FormData::Box(all_rounded(half_size.into(), 5)),
        Shape::Sphere { radius } => FormData::Sphere(rounded(radius, 5)),
        Shape::Cylinder {
            radius,
            half_length,
        } => FormData::Cylinder(all_rounded([radius, half_length], 5)),
        Shape::Capsule {
            radius,
            half_length,
        } => FormData::Capsule(all_rounded([radius, half_length], 5)),
        // A surface or rods took its place; a point that is not seen keeps this total.
        Shape::Mesh { .. } => FormData::Sphere(0.0),
    }
}

fn short_pose(pose: &Pose) -> [f64; 7] {
    all_rounded(pose.to_xyzquat(), 6)
}

fn geometry(shapes: &[Geometry]) -> Vec<ShapeData> {
    let shape = |shape: &Geometry| ShapeData {
        joint: None,
        pose: all_rounded(shape.pose, 6),
        form: match shape.half_size {
            Some(half_size) => FormData::Box(all_rounded(half_size, 5)),
            None => FormData::Plane(true),
        },
        mirror: None,
        color: None,
    };
    shapes.iter().map(shape).collect()
}

fn objects(motion: &Motion) -> Vec<ObjectData> {
    let objects = motion.plan.objects.iter().enumerate();
    objects
        .map(|(i, object)| {
            let poses: Vec<_> = (0..motion.n_nodes())
                .map(|t| motion.world_from_object(t, i).to_xyzquat())
                .collect();
            let rows = continuous(poses.iter().map(<[f64; 7]>::as_slice), 3);
            ObjectData {
                name: object.name.clone(),
                mass: object.mass,
                shapes: geometry(&object.geometry),
                pose: Table::new(POSE_STEP, rows),
            }
        })
        .collect()
}

fn environment(plan: &Plan) -> Vec<StaticData> {
    let body = |body: &plan::StaticBody| StaticData {
        name: body.name.clone(),
        shapes: geometry(&body.geometry),
    };
    plan.environment.iter().map(body).collect()
}

fn interfaces(motion: &Motion) -> Vec<InterfaceData> {
    let interfaces = motion.plan.interfaces.iter().zip(&motion.carriers);
    interfaces
        .map(|(interface, carrier)| {
            let own = Pose::from_xyzquat(&interface.pose);
            let (on, index, pose) = match *carrier {
                Carrier::Frame(frame) => {
                    let frame = &motion.model.frames[frame];
                    ("joint", frame.joint, frame.joint_from_frame * own)
                }
                Carrier::Object(object) => ("object", Some(object), own),
                Carrier::Static(body) => ("static", Some(body), own),
            };
            InterfaceData {
                name: interface.name.clone(),
                body: interface.body.clone(),
                on,
                index,
                pose: short_pose(&pose),
                point: interface.kind == plan::InterfaceKind::Point,
                half_size: interface.half_size,
            }
        })
        .collect()
}

fn goal(motion: &Motion) -> Vec<[usize; 2]> {
    let index = |name: &String| motion.interfaces.get(name.as_str()).copied();
    let goal = motion.plan.goal.iter();
    goal.filter_map(|x| Some([index(&x.a)?, index(&x.b)?]))
        .collect()
}

fn regions(plan: &Plan) -> Vec<RegionData> {
    let region = |x: &plan::GoalRegion| RegionData {
        body: x.body.clone(),
        lower: x.lower,
        upper: x.upper,
    };
    plan.goal_regions.iter().map(region).collect()
}

fn phases(motion: &Motion) -> Vec<PhaseData> {
    let starts = motion.plan.phase_starts();
    let phases = motion.plan.phases.iter().zip(starts);
    phases
        .map(|(phase, start)| PhaseData {
            duration: rounded(phase.duration, 5),
            steps: phase.steps,
            action: phase.action.clone(),
            contacts: phase
                .contacts
                .iter()
                .map(|x| contact(motion, x, start))
                .collect(),
        })
        .collect()
}

fn contact(motion: &Motion, contact: &plan::Contact, start: usize) -> ContactData {
    let loads = loads(motion, contact, start);
    // One step for all columns: kilonewtons to 0.1 N, shares to 1 in 10 000, metres to 0.1 mm.
    let load = loads.iter().map(|x| {
        let [cop_x, cop_y] = x.pressure;
        [x.normal * 1e-3, x.friction, cop_x, cop_y]
    });
    ContactData {
        a: motion.interfaces[contact.a.as_str()],
        b: motion.interfaces[contact.b.as_str()],
        kind: match contact.kind {
            ContactType::UnilateralPoint => "point",
            ContactType::BilateralPoint => "held point",
            ContactType::UnilateralPatch => "patch",
            ContactType::BilateralPatch => "grasp",
        },
        mu: contact.mu,
        mu_r: contact.mu_r,
        wrench: Table::new(WRENCH_STEP, &contact.wrench),
        load: Table::new(1e-4, load),
    }
}

fn check_data((report, series): &(Report, Vec<Series>)) -> CheckData {
    let rows = report.rows.iter().enumerate().map(|(i, row)| {
        let curve = series.iter().find(|x| x.row == i).map(|x| &x.values);
        let visible = |values: &&Vec<f64>| {
            let largest = values.iter().copied().fold(0.0, f64::max);
            row.tolerance > 0.0 && largest > VISIBLE_RESIDUAL * row.tolerance
        };
        RowData {
            category: row.category,
            what: row.what,
            unit: row.unit,
            value: row.value,
            tolerance: row.tolerance,
            status: row.status.to_string(),
            place: row.location.to_string(),
            node: row.location.node,
            over_time: curve.filter(visible).map(|values| {
                Table::column(1e-3, values.iter().map(|x| (x / row.tolerance).min(1e3)))
            }),
        }
    });
    let margins = report.margins_used.iter().map(|x| MarginData {
        limit: x.limit,
        largest: rounded(x.largest, 4),
        what: x.location.what.clone(),
        node: x.location.node,
    });
    CheckData {
        ok: report.ok(),
        rows: rows.collect(),
        margins: margins.collect(),
    }
}
