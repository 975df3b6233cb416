//! From a solved trajectory to the plan file.

use multibody::{Centroidal, Kinematics};
use nalgebra::Vector3;
use ocp::{CostTerm, Motion, Preset};
use plan::{
    Contact, ContactType, Costs, Dynamics, Extra, Geometry, GoalContact, GoalRegion, Integrator,
    Interface, InterfaceKind, Object, ObjectStates, Objective, Phase, Plan, Robot, StaticBody,
    Status, TorqueSpeed,
};
use scene::{Owner, PlacedShape, Scene, Shape};
use spatial::Pose;
use std::collections::BTreeMap;

/// Writes a motion as a plan.
#[allow(clippy::too_many_lines)] // one expression or layout, written down in its own order
pub fn plan(scene: &Scene, labels: &[String], motion: &mut Motion) -> Plan {
    let point = motion.point.clone();
    let n = motion.trajectory.program.n_intervals();
    let (nq, nv) = (
        motion.trajectory.program.system.robot_nq,
        motion.trajectory.program.system.robot_nv,
    );
    let (mut v, mut a, mut tau) = (Vec::new(), Vec::new(), Vec::new());
    let mut dt = Vec::new();
    for t in 0..n {
        let (vt, at) = motion.trajectory.velocity_and_acceleration(&point, t);
        v.push(vt);
        a.push(at);
        tau.push(motion.trajectory.torques(&point, t));
        dt.push(motion.trajectory.dt(&point, t));
    }
    let costs = costs(motion);
    let program = &motion.trajectory.program;
    v.push(vec![0.0; program.system.model.nv]);
    let mut object_states = BTreeMap::new();
    for (o, object) in scene.objects.iter().enumerate() {
        let (q0, v0) = (program.system.object_q(o), program.system.object_v(o));
        object_states.insert(
            object.name.clone(),
            ObjectStates {
                pose: point
                    .nodes
                    .iter()
                    .map(|q| std::array::from_fn(|i| q[q0 + i]))
                    .collect(),
                twist: v
                    .iter()
                    .map(|v| std::array::from_fn(|i| v[v0 + i]))
                    .collect(),
                accel: a
                    .iter()
                    .map(|a| std::array::from_fn(|i| a[v0 + i]))
                    .collect(),
                extra: Extra::new(),
            },
        );
    }
    let mut time = vec![0.0];
    time.extend(dt.iter().scan(0.0, |sum, dt| {
        *sum += dt;
        Some(*sum)
    }));
    let robot =
        |rows: &[Vec<f64>], width: usize| rows.iter().map(|r| r[..width].to_vec()).collect();
    Plan {
        format: "locotamp.plan/1".into(),
        generator: concat!("locotamp ", env!("CARGO_PKG_VERSION")).into(),
        task: scene.name.clone(),
        status: if motion.feasible {
            Status::Feasible
        } else {
            Status::Infeasible
        },
        objective: Some(objective(scene, motion, time[n])),
        violation: Some(largest_violation(motion)),
        gravity: scene.gravity.into(),
        integrator: match program.settings.integrator {
            ocp::Integrator::Euler => Integrator::Euler,
            ocp::Integrator::SemiImplicitEuler => Integrator::SemiImplicitEuler,
            ocp::Integrator::ConstantAcceleration => Integrator::ConstantAcceleration,
        },
        dynamics: match program.settings.preset {
            Preset::Default => Dynamics::BaseRows,
            Preset::Paper => Dynamics::Momentum,
        },
        robot: Robot {
            name: scene.robot.name.clone(),
            urdf: scene.robot.urdf.clone(),
            joints: program.system.actuated().map(|j| j.name.clone()).collect(),
            torque_limits: Some(
                program
                    .system
                    .actuated()
                    .map(|j| {
                        (program.settings.torque_limits && j.torque_limit.is_finite())
                            .then_some(j.torque_limit)
                    })
                    .collect(),
            ),
            torque_speed: torque_speed(program),
            extra: Extra::new(),
        },
        objects: scene.objects.iter().map(object).collect(),
        environment: scene
            .statics
            .iter()
            .map(|s| StaticBody {
                name: s.name.clone(),
                geometry: geometry(&s.shapes),
                extra: Extra::new(),
            })
            .collect(),
        interfaces: scene
            .interfaces
            .iter()
            .map(|i| interface(scene, i))
            .collect(),
        goal: scene
            .goal_contacts
            .iter()
            .map(|g| GoalContact {
                a: scene.interfaces[g.a.0].name.clone(),
                b: scene.interfaces[g.b.0].name.clone(),
                extra: Extra::new(),
            })
            .collect(),
        goal_regions: scene
            .goal_regions
            .iter()
            .map(|r| GoalRegion {
                body: goal_body(scene, &r.body),
                lower: std::array::from_fn(|i| r.lower[i].is_finite().then_some(r.lower[i])),
                upper: std::array::from_fn(|i| r.upper[i].is_finite().then_some(r.upper[i])),
                yaw: r.yaw,
                tilt: r.tilt,
                extra: Extra::new(),
            })
            .collect(),
        phases: phases(scene, labels, motion),
        time,
        q: robot(&point.nodes, nq),
        h: momenta(scene, &point.nodes, &v, nq, nv),
        v: robot(&v, nv),
        a: robot(&a, nv),
        tau: tau.iter().map(|row| row[6..nv].to_vec()).collect(),
        object_states,
        costs: Some(costs),
        explanation: None,
        extra: Extra::new(),
    }
}

/// Costs are written in whole parts of one over this.
const COST_PARTS: f64 = 1e7;

/// What the optimiser minimised by interval and term; terms that are zero all the time are left out.
fn costs(motion: &mut Motion) -> Costs {
    let Motion {
        trajectory, point, ..
    } = motion;
    let intervals = 0..trajectory.program.n_intervals();
    let rows: Vec<_> = intervals.map(|t| trajectory.cost_terms(point, t)).collect();
    let used = |term: &CostTerm| rows.iter().any(|row| row.of(*term) != 0.0);
    let used: Vec<_> = CostTerm::ALL.into_iter().filter(used).collect();
    let (end, over_time): (Vec<_>, Vec<_>) = used.into_iter().partition(|x| x.is_at_the_end());
    let rounded = |cost: f64| (cost * COST_PARTS).round() / COST_PARTS;
    let all = |term: CostTerm| rounded(rows.iter().map(|row| row.of(term)).sum());
    Costs {
        terms: over_time.iter().map(|x| x.name().to_owned()).collect(),
        per_interval: (rows.iter())
            .map(|row| over_time.iter().map(|x| rounded(row.of(*x))).collect())
            .collect(),
        end: end.iter().map(|x| (x.name().into(), all(*x))).collect(),
        extra: Extra::new(),
    }
}

/// What is enforced of torque at speed, by joint.
fn torque_speed(program: &ocp::Program) -> BTreeMap<String, TorqueSpeed> {
    let enforced = program.settings.torque_speed();
    let joints = program.system.actuated().filter(|_| enforced);
    let declared = joints.filter_map(|joint| {
        let multibody::TorqueSpeed { corner, no_load } = joint.torque_speed?;
        let max = no_load;
        Some((joint.name.clone(), TorqueSpeed { corner, max }))
    });
    declared.collect()
}

/// The body of a goal region as the plan knows it: the base is the robot's root link.
fn goal_body(scene: &Scene, name: &str) -> String {
    let frames = &scene.robot.model.frames;
    let root = frames.iter().find(|f| f.joint == Some(0));
    match root {
        Some(root) if name == "base" => root.name.clone(),
        _ => name.to_owned(),
    }
}

/// Largest violation of any row, in the row's own SI unit.
pub(crate) fn largest_violation(motion: &Motion) -> f64 {
    let program = &motion.trajectory.program;
    let mut row = 0;
    let mut largest = 0.0_f64;
    for element in &program.structure.elements {
        for (l, u) in element.row_lower.iter().zip(&element.row_upper) {
            let value = motion.report.rows[row];
            largest = largest.max((l - value).max(value - u).max(0.0) * program.labels[row].scale);
            row += 1;
        }
    }
    largest
}

/// Centroidal momenta h = A(q) v of the robot, linear then angular, world axes.
fn momenta(scene: &Scene, q: &[Vec<f64>], v: &[Vec<f64>], nq: usize, nv: usize) -> Vec<[f64; 6]> {
    let model = &scene.robot.model;
    let (mut kinematics, mut centroidal) = (Kinematics::new(model), Centroidal::new(model));
    q.iter()
        .zip(v)
        .map(|(q, v)| {
            kinematics.update(model, &q[..nq]);
            centroidal.compute(model, &kinematics);
            let h = centroidal.momentum(&v[..nv]);
            std::array::from_fn(|i| h[i])
        })
        .collect()
}

fn phases(scene: &Scene, labels: &[String], motion: &Motion) -> Vec<Phase> {
    let program = &motion.trajectory.program;
    let mut kinematics = Kinematics::new(&program.system.model);
    let mut out = Vec::new();
    let mut first = 0;
    for (k, &steps) in program.steps.iter().enumerate() {
        let mut contacts: Vec<Contact> = program.intervals[first]
            .forces
            .iter()
            .map(|force| {
                let (a, b) = (
                    &scene.interfaces[force.contact.a.0],
                    &scene.interfaces[force.contact.b.0],
                );
                Contact {
                    a: a.name.clone(),
                    b: b.name.clone(),
                    kind: contact_type(force.contact.kind),
                    mu: a.mu.min(b.mu),
                    mu_r: a.mu_r.min(b.mu_r),
                    overhang: b.overhang,
                    wrench: Vec::with_capacity(steps),
                    extra: Extra::new(),
                }
            })
            .collect();
        for t in first..first + steps {
            kinematics.update(&program.system.model, &motion.point.nodes[t]);
            for (contact, force) in contacts.iter_mut().zip(&program.intervals[t].forces) {
                let a = &scene.interfaces[force.contact.a.0];
                let carrier = program.system.carrier(a.owner, &a.body_from_interface);
                let world_from_a = carrier.world_from_frame(&kinematics);
                let wrench = ocp::physical_wrench(force, &motion.point.wrenches[t]);
                let turn = |first: usize| {
                    world_from_a.rotate(Vector3::new(
                        wrench[first],
                        wrench[first + 1],
                        wrench[first + 2],
                    ))
                };
                let (f, m) = (turn(0), turn(3));
                contact.wrench.push([f.x, f.y, f.z, m.x, m.y, m.z]);
            }
        }
        out.push(Phase {
            duration: motion.point.durations[k],
            steps,
            action: labels.get(k).cloned().unwrap_or_default(),
            contacts,
            extra: Extra::new(),
        });
        first += steps;
    }
    out
}

fn contact_type(kind: symbolic::ContactType) -> ContactType {
    match kind {
        symbolic::ContactType::UnilateralPoint => ContactType::UnilateralPoint,
        symbolic::ContactType::BilateralPoint => ContactType::BilateralPoint,
        symbolic::ContactType::UnilateralPatch => ContactType::UnilateralPatch,
        symbolic::ContactType::BilateralPatch => ContactType::BilateralPatch,
    }
}

fn interface(scene: &Scene, i: &scene::Interface) -> Interface {
    let body = match i.owner {
        Owner::Robot { frame } => scene.robot.model.frames[frame].name.clone(),
        Owner::Object(o) => scene.objects[o].name.clone(),
        Owner::Static(s) => scene.statics[s].name.clone(),
    };
    Interface {
        name: i.name.clone(),
        body,
        pose: i.body_from_interface.to_xyzquat(),
        kind: if i.patch {
            InterfaceKind::Patch
        } else {
            InterfaceKind::Point
        },
        half_size: i.half_size.map(|h| h.map(Some)),
        limb: Some([i.limb.x, i.limb.y, i.limb.z]),
        extra: Extra::new(),
    }
}

fn object(o: &scene::Object) -> Object {
    let i = &o.inertia;
    Object {
        name: o.name.clone(),
        mass: o.mass,
        inertia: [
            i[(0, 0)],
            i[(1, 1)],
            i[(2, 2)],
            i[(0, 1)],
            i[(0, 2)],
            i[(1, 2)],
        ],
        geometry: geometry(&o.shapes),
        extra: Extra::new(),
    }
}

/// Boxes and planes as the format has them; a ball or capsule is written as the box around it, marked so.
fn geometry(shapes: &[PlacedShape]) -> Vec<Geometry> {
    let around = |half: [f64; 3], pose: &Pose, radius: f64| {
        let mut out = Geometry::cuboid(half, pose.to_xyzquat());
        out.extra.insert("rounded_by".into(), radius.into());
        out
    };
    shapes
        .iter()
        .map(|s| match &s.shape {
            Shape::Box { half_size } => {
                Geometry::cuboid((*half_size).into(), s.body_from_shape.to_xyzquat())
            }
            Shape::HalfSpace => Geometry::half_space(s.body_from_shape.to_xyzquat()),
            Shape::Sphere { radius } => around([*radius; 3], &s.body_from_shape, *radius),
            Shape::Capsule {
                radius,
                half_length,
            } => around(
                [*radius, *radius, radius + half_length],
                &s.body_from_shape,
                *radius,
            ),
        })
        .collect()
}

/// The objective and its value: the duration [s], or how far its body is along its direction at the end [m].
fn objective(scene: &Scene, motion: &Motion, duration: f64) -> Objective {
    let along = |body: &str, direction: Vector3<f64>| {
        let system = &motion.trajectory.program.system;
        let carrier = ocp::goal_body(scene, system, body)?;
        let mut kinematics = Kinematics::new(&system.model);
        kinematics.update(&system.model, motion.point.nodes.last()?);
        let pose = carrier.world_from_frame(&kinematics);
        Some(pose.origin().dot(&direction))
    };
    let (name, value) = match &scene.objective {
        scene::Objective::Time => ("time", Some(duration)),
        scene::Objective::BaseHeight => ("base_height", along("base", Vector3::z())),
        scene::Objective::Reach { body, direction } => ("reach", along(body, *direction)),
    };
    Objective {
        name: name.into(),
        value: value.unwrap_or(duration),
        cost: Some(motion.report.objective),
        extra: Extra::new(),
    }
}
