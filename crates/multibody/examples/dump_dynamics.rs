//! Writes the dynamics of a robot at random states as JSON, for comparison with other software.
//!
//! `cargo run --release -p multibody --example dump_dynamics -- URDF [floating|fixed] [STATES] [SEED]`
//!
//! Matrices are written by rows, in the joint order of the model. `tests/oracle/live_check.py` reads the output.

use multibody::{
    CenterOfMass, Centroidal, CentroidalDerivatives, Crba, Kinematics, Model, Rnea,
    RneaDerivatives, RneaHessian, Root,
};
use nalgebra::{Dim, Matrix, RawStorage};
use serde_json::{Value, json};
use spatial::Random;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments
        .next()
        .ok_or("usage: dump_dynamics URDF [floating|fixed] [STATES] [SEED]")?;
    let root = if arguments.next().as_deref() == Some("fixed") {
        Root::Fixed
    } else {
        Root::Floating
    };
    let states: u64 = arguments.next().map_or(Ok(3), |text| text.parse())?;
    let seed: u64 = arguments.next().map_or(Ok(0), |text| text.parse())?;

    let model = Model::from_urdf(&std::fs::read_to_string(&path)?, root)?;
    let names: Vec<&str> = model
        .joints
        .iter()
        .map(|joint| joint.name.as_str())
        .collect();
    let frames: Vec<&str> = model
        .frames
        .iter()
        .map(|frame| frame.name.as_str())
        .collect();
    let states: Vec<Value> = (seed..seed + states)
        .map(|seed| state(&model, seed))
        .collect();
    let record = json!({
        "floating": root == Root::Floating,
        "nq": model.nq, "nv": model.nv, "mass": model.total_mass(),
        "joints": names, "frames": frames, "notes": model.notes, "states": states,
    });
    println!("{record}");
    Ok(())
}

fn state(model: &Model, seed: u64) -> Value {
    let mut random = Random::new(seed);
    let mut draw =
        |size: f64| -> Vec<f64> { (0..model.nv).map(|_| random.uniform(-size, size)).collect() };
    let (q, v, a, w) = (
        model.random_configuration(seed),
        draw(2.0),
        draw(5.0),
        draw(1.0),
    );
    let mut kinematics = Kinematics::new(model);
    kinematics.update(model, &q);
    let mut derivatives = RneaDerivatives::new(model);
    derivatives.compute(model, &kinematics, &v, &a);
    let mut hessian = RneaHessian::new(model);
    hessian.compute(model, &kinematics, &v, &a, &w);
    let mut momentum = CentroidalDerivatives::new(model);
    momentum.compute(model, &kinematics, &v);
    let mut centroidal = Centroidal::new(model);
    centroidal.compute(model, &kinematics);
    let poses: Vec<f64> = (0..model.frames.len())
        .flat_map(|frame| kinematics.frame_pose(model, frame).to_xyzquat())
        .collect();
    json!({
        "q": q, "v": v, "a": a, "w": w,
        "M": rows(Crba::new(model).compute(model, &kinematics)),
        "tau": Rnea::new(model).compute(model, &kinematics, &v, &a),
        "dtau_dq": rows(derivatives.dtau_dq()),
        "dtau_dv": rows(derivatives.dtau_dv()),
        "com": CenterOfMass::new(model).compute(model, &kinematics).0.as_slice(),
        "A": rows(centroidal.matrix()),
        "h": centroidal.momentum(&v).as_slice(),
        "dh_dq": rows(momentum.dh_dq()),
        "hessian_vv": rows(hessian.hessian_vv()),
        "hessian_qv": rows(hessian.hessian_qv()),
        "hessian_qa": rows(hessian.hessian_qa()),
        "frames_xyzquat": poses,
    })
}

fn rows<R: Dim, C: Dim, S: RawStorage<f64, R, C>>(matrix: &Matrix<f64, R, C, S>) -> Vec<f64> {
    (0..matrix.nrows())
        .flat_map(|i| (0..matrix.ncols()).map(move |k| matrix[(i, k)]))
        .collect()
}
