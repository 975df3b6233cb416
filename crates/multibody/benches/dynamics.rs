//! Microseconds per call of every algorithm on the G1 (29 joints, floating base): `cargo bench -p multibody`.
//!
//! 64 random states are cycled; printed are median and minimum over passes, each shorter than a time slice. "with FK" includes the forward kinematics,
//! as in other libraries; here it is evaluated once per state and shared. Times are of the wall clock: use a quiet machine,
//! or read the minimum. Recorded runs: `benches/runs/` at the root of the repository.

use multibody::{
    CenterOfMass, Centroidal, CentroidalDerivatives, Crba, Kinematics, Model, Rnea,
    RneaDerivatives, RneaHessian, Root,
};
use nalgebra::{Matrix6xX, Vector6};
use spatial::Random;
use std::hint::black_box;
use std::time::Instant;

const STATES: usize = 64;
const BATCHES: usize = 501;
const FEET_AND_HANDS: [&str; 4] = [
    "left_ankle_roll_link",
    "right_ankle_roll_link",
    "left_rubber_hand",
    "right_rubber_hand",
];

/// A random state with its kinematics.
struct State {
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    w: Vec<f64>,
    kinematics: Kinematics,
}

fn state(model: &Model, seed: u64) -> State {
    let mut random = Random::new(seed);
    let mut draw = || (0..model.nv).map(|_| random.uniform(-1.0, 1.0)).collect();
    let (v, a, w) = (draw(), draw(), draw());
    let q = model.random_configuration(seed);
    let mut kinematics = Kinematics::new(model);
    kinematics.update(model, &q);
    State {
        q,
        v,
        a,
        w,
        kinematics,
    }
}

fn bench(name: &str, states: &mut [State], mut call: impl FnMut(&mut State)) {
    let mut times = Vec::new();
    for _ in 0..BATCHES {
        let start = Instant::now();
        for state in states.iter_mut() {
            call(black_box(state));
        }
        times.push(start.elapsed().as_secs_f64() * 1e6 / STATES as f64);
    }
    times.sort_by(f64::total_cmp);
    println!("{name:44} {:8.2} {:8.2}", times[BATCHES / 2], times[0]);
}

/// Computes a result that nobody reads.
fn keep<T>(value: T) {
    black_box(value);
}

fn main() {
    let model = Model::from_urdf(include_str!("../tests/oracle/g1.urdf"), Root::Floating)
        .expect("g1 loads");
    let frames = FEET_AND_HANDS.map(|name| model.frame_id(name).expect("g1 has feet and hands"));
    let states = &mut (0..STATES as u64)
        .map(|seed| state(&model, seed))
        .collect::<Vec<_>>();
    let y = Vector6::new(0.1, 0.2, 0.3, 0.4, 0.5, 0.6);
    println!(
        "{} nq {} nv {}; microseconds: median, minimum",
        model.name, model.nq, model.nv
    );

    let mut moved = model.neutral();
    bench("integrate", states, |s| {
        model.integrate_into(&s.q, &s.v, &mut moved);
    });
    bench("forward kinematics (poses and columns)", states, |s| {
        s.kinematics.update(&model, &s.q);
    });
    let mut jacobian = Matrix6xX::zeros(model.nv);
    bench("the same and four frame Jacobians", states, |s| {
        s.kinematics.update(&model, &s.q);
        for frame in frames {
            s.kinematics
                .frame_jacobian_in_frame(&model, frame, &mut jacobian);
        }
    });
    let mut rnea = Rnea::new(&model);
    bench("RNEA", states, |s| {
        keep(rnea.compute(&model, &s.kinematics, &s.v, &s.a)[0]);
    });
    bench("RNEA with FK", states, |s| {
        s.kinematics.update(&model, &s.q);
        black_box(rnea.compute(&model, &s.kinematics, &s.v, &s.a)[0]);
    });
    let mut crba = Crba::new(&model);
    bench("CRBA", states, |s| {
        keep(crba.compute(&model, &s.kinematics)[0]);
    });
    bench("CRBA with FK", states, |s| {
        s.kinematics.update(&model, &s.q);
        black_box(crba.compute(&model, &s.kinematics)[0]);
    });
    let mut com = CenterOfMass::new(&model);
    bench("centre of mass and Jacobian", states, |s| {
        keep(com.compute(&model, &s.kinematics).0);
    });
    let mut centroidal = Centroidal::new(&model);
    bench("centroidal map and momentum", states, |s| {
        centroidal.compute(&model, &s.kinematics);
        black_box(centroidal.momentum(&s.v));
    });
    bench("centroidal map and momentum with FK", states, |s| {
        s.kinematics.update(&model, &s.q);
        centroidal.compute(&model, &s.kinematics);
        black_box(centroidal.momentum(&s.v));
    });
    let mut momentum = CentroidalDerivatives::new(&model);
    bench("centroidal momentum derivatives with FK", states, |s| {
        s.kinematics.update(&model, &s.q);
        momentum.compute(&model, &s.kinematics, &s.v);
    });
    bench("the same and contracted Hessian", states, |s| {
        s.kinematics.update(&model, &s.q);
        momentum.compute(&model, &s.kinematics, &s.v);
        momentum.compute_hessian(&model, &y);
    });
    let mut derivatives = RneaDerivatives::new(&model);
    bench("RNEA derivatives", states, |s| {
        derivatives.compute(&model, &s.kinematics, &s.v, &s.a);
    });
    bench("RNEA derivatives with FK", states, |s| {
        s.kinematics.update(&model, &s.q);
        derivatives.compute(&model, &s.kinematics, &s.v, &s.a);
    });
    let mut hessian = RneaHessian::new(&model);
    bench("RNEA contracted gradient", states, |s| {
        hessian.compute_gradient(&model, &s.kinematics, &s.v, &s.a, &s.w);
    });
    bench("the same, first derivatives and Hessian", states, |s| {
        hessian.compute(&model, &s.kinematics, &s.v, &s.a, &s.w);
    });
    bench("the same with FK", states, |s| {
        s.kinematics.update(&model, &s.q);
        hessian.compute(&model, &s.kinematics, &s.v, &s.a, &s.w);
    });
}
