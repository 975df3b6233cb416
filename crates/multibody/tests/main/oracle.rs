//! Agreement with Pinocchio on three robots; the numbers and the script that made them are in `tests/oracle/`.

use multibody::{
    CenterOfMass, Centroidal, CentroidalDerivatives, Crba, Joint, JointKind, Kinematics, Model,
    Rnea, RneaDerivatives, Root,
};
use nalgebra::{DMatrix, Matrix3, Vector3};
use serde_json::Value;
use spatial::{Inertia, Pose};

/// Relative to the largest entry of a quantity; both sides carry 15 digits.
const TOLERANCE: f64 = 1e-11;

#[test]
fn g1_agrees_with_pinocchio() {
    let record: Value =
        serde_json::from_str(include_str!("../oracle/g1.json")).expect("oracle file is JSON");
    let model =
        Model::from_urdf(include_str!("../oracle/g1.urdf"), Root::Floating).expect("g1 loads");
    check(&model, &record);
}

#[test]
fn panda_agrees_with_pinocchio() {
    let record: Value =
        serde_json::from_str(include_str!("../oracle/panda.json")).expect("oracle file is JSON");
    let model =
        Model::from_urdf(include_str!("../oracle/panda.urdf"), Root::Fixed).expect("panda loads");
    assert!(
        model
            .notes
            .iter()
            .any(|note| note.contains("panda_finger_joint2")),
        "{:?}",
        model.notes
    );
    check(&model, &record);
}

#[test]
fn talos_agrees_with_pinocchio() {
    let record: Value =
        serde_json::from_str(include_str!("../oracle/talos.json")).expect("oracle file is JSON");
    check(&model_of_table(&record["table"]), &record);
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().expect("a list of numbers");
    list.iter().map(|x| x.as_f64().expect("a number")).collect()
}

fn model_of_table(table: &Value) -> Model {
    let joint = |entry: &Value| {
        let kind = if entry["kind"] == "free" {
            JointKind::FreeFlyer
        } else {
            JointKind::Revolute {
                axis: Vector3::from_column_slice(&numbers(&entry["axis"])),
            }
        };
        let rotation = Matrix3::from_row_slice(&numbers(&entry["rotation"]));
        let translation = Vector3::from_column_slice(&numbers(&entry["translation"]));
        Joint {
            name: entry["name"].as_str().expect("a name").to_owned(),
            kind,
            parent: entry["parent"].as_u64().map(|parent| parent as usize),
            parent_from_joint: Pose::from_parts(rotation, translation),
            inertia: Inertia {
                mass: entry["mass"].as_f64().expect("a mass"),
                com: Vector3::from_column_slice(&numbers(&entry["com"])),
                inertia: Matrix3::from_row_slice(&numbers(&entry["inertia"])),
            },
            idx_q: 0,
            idx_v: 0,
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            velocity_limit: f64::INFINITY,
            torque_limit: f64::INFINITY,
            torque_speed: None,
        }
    };
    let joints = table
        .as_array()
        .expect("a list of joints")
        .iter()
        .map(joint)
        .collect();
    Model::new("table", joints, Vec::new()).expect("the table is a tree in order")
}

/// Where the entries of the record are in the order of the model: `order[k]` is the record's index of our index k.
fn velocity_order(model: &Model, record: &Value) -> Vec<usize> {
    let names: Vec<&str> = record["joints"]
        .as_array()
        .expect("names")
        .iter()
        .filter_map(Value::as_str)
        .collect();
    let base = model.nv - names.len();
    let mut order: Vec<usize> = (0..base).collect();
    for joint in model
        .joints
        .iter()
        .filter(|joint| joint.kind != JointKind::FreeFlyer)
    {
        let at = names.iter().position(|name| *name == joint.name);
        order.push(base + at.unwrap_or_else(|| panic!("the record has no joint {:?}", joint.name)));
    }
    order
}

/// A state and its results in the order of the model.
struct Reader<'a> {
    state: &'a Value,
    order: Vec<usize>,
    /// nq − nv
    extra: usize,
}

impl Reader<'_> {
    fn configuration(&self) -> Vec<f64> {
        let all = numbers(&self.state["q"]);
        let base = if self.extra == 1 {
            &all[..7]
        } else {
            &all[..0]
        };
        let joints = self
            .order
            .iter()
            .skip(base.len() - self.extra)
            .map(|k| all[k + self.extra]);
        base.iter().copied().chain(joints).collect()
    }

    fn vector(&self, key: &str) -> Vec<f64> {
        let all = numbers(&self.state[key]);
        self.order.iter().map(|&k| all[k]).collect()
    }

    /// Rows of any kind, columns by velocity index.
    fn columns(&self, key: &str, rows: usize) -> DMatrix<f64> {
        let n = self.order.len();
        let all = DMatrix::from_row_slice(rows, n, &numbers(&self.state[key]));
        DMatrix::from_fn(rows, n, |i, k| all[(i, self.order[k])])
    }

    fn square(&self, key: &str) -> DMatrix<f64> {
        let all = self.columns(key, self.order.len());
        DMatrix::from_fn(all.nrows(), all.ncols(), |i, k| all[(self.order[i], k)])
    }

    fn mass_matrix(&self) -> DMatrix<f64> {
        let (n, upper) = (self.order.len(), numbers(&self.state["M_upper"]));
        let entry = |i: usize, k: usize| {
            let (row, column) = (
                self.order[i].min(self.order[k]),
                self.order[i].max(self.order[k]),
            );
            upper[row * n - row * (row + 1) / 2 + column]
        };
        DMatrix::from_fn(n, n, entry)
    }
}

fn assert_close(what: &str, ours: &[f64], theirs: &[f64]) {
    assert_eq!(ours.len(), theirs.len(), "{what}: lengths");
    let largest = theirs.iter().fold(0.0, |max: f64, x| max.max(x.abs()));
    let worst = ours
        .iter()
        .zip(theirs)
        .map(|(x, y)| (x - y).abs())
        .fold(0.0, f64::max);
    assert!(ours.iter().all(|x| x.is_finite()), "{what}: not finite");
    assert!(
        worst <= TOLERANCE * largest,
        "{what}: off by {worst:.1e} of {largest:.1e}"
    );
}

fn check(model: &Model, record: &Value) {
    let mass = record["mass"].as_f64().expect("a mass");
    assert_close("total mass", &[model.total_mass()], &[mass]);
    let order = velocity_order(model, record);
    for state in record["states"].as_array().expect("a list of states") {
        let reader = Reader {
            state,
            order: order.clone(),
            extra: model.nq - model.nv,
        };
        let (q, v, a) = (
            reader.configuration(),
            reader.vector("v"),
            reader.vector("a"),
        );
        let mut kinematics = Kinematics::new(model);
        kinematics.update(model, &q);
        check_dynamics(model, &kinematics, &reader, &v, &a);
        check_momentum(model, &kinematics, &reader, &v);
        check_frame(model, &kinematics, record, state);
    }
}

fn check_dynamics(model: &Model, kinematics: &Kinematics, reader: &Reader, v: &[f64], a: &[f64]) {
    let mass_matrix = reader.mass_matrix();
    assert_close(
        "M",
        Crba::new(model).compute(model, kinematics).as_slice(),
        mass_matrix.as_slice(),
    );
    assert_close(
        "tau",
        Rnea::new(model).compute(model, kinematics, v, a),
        &reader.vector("tau"),
    );
    let mut derivatives = RneaDerivatives::new(model);
    derivatives.compute(model, kinematics, v, a);
    assert_close(
        "dtau_dq",
        derivatives.dtau_dq().as_slice(),
        reader.square("dtau_dq").as_slice(),
    );
    assert_close(
        "dtau_dv",
        derivatives.dtau_dv().as_slice(),
        reader.square("dtau_dv").as_slice(),
    );
    assert_close(
        "dtau_da",
        derivatives.dtau_da().as_slice(),
        mass_matrix.as_slice(),
    );
}

fn check_momentum(model: &Model, kinematics: &Kinematics, reader: &Reader, v: &[f64]) {
    let com = CenterOfMass::new(model).compute(model, kinematics).0;
    assert_close("com", com.as_slice(), &numbers(&reader.state["com"]));
    let mut centroidal = Centroidal::new(model);
    let map = centroidal.compute(model, kinematics);
    assert_close("A", map.as_slice(), reader.columns("A", 6).as_slice());
    let h = numbers(&reader.state["h"]);
    assert_close("h", centroidal.momentum(v).as_slice(), &h);
    let mut derivatives = CentroidalDerivatives::new(model);
    derivatives.compute(model, kinematics, v);
    assert_close("h with derivatives", derivatives.h().as_slice(), &h);
    assert_close(
        "dh_dq",
        derivatives.dh_dq().as_slice(),
        reader.columns("dh_dq", 6).as_slice(),
    );
}

fn check_frame(model: &Model, kinematics: &Kinematics, record: &Value, state: &Value) {
    // a table of joints has no frames
    let Some(frame) = model.frame_id(record["frame"].as_str().expect("a name")) else {
        return;
    };
    let expected: Vec<f64> = numbers(&state["frame_xyzquat"]);
    let expected = Pose::from_xyzquat(expected.as_slice().try_into().expect("seven numbers"));
    assert!(kinematics.frame_pose(model, frame).minus(&expected).norm() < 1e-12);
}
