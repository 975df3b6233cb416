//! Laws of mechanics that hold whatever the implementation: energy, momentum, symmetry.

use multibody::{
    CenterOfMass, Centroidal, CentroidalDerivatives, Crba, Kinematics, Model, Rnea, Root,
};
use nalgebra::{DVector, Vector3};
use spatial::Random;

struct State {
    model: Model,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
}

fn states() -> impl Iterator<Item = State> {
    (0..8).map(|seed| {
        let root = if seed % 2 == 0 {
            Root::Floating
        } else {
            Root::Fixed
        };
        let model = Model::random(seed, root, 12);
        let mut random = Random::new(seed);
        let mut draw = || (0..model.nv).map(|_| random.uniform(-1.0, 1.0)).collect();
        let (v, a) = (draw(), draw());
        State {
            q: model.random_configuration(seed),
            model,
            v,
            a,
        }
    })
}

impl State {
    /// After a time `t` of constant acceleration, to second order exact: configuration and velocity.
    fn after(&self, t: f64) -> (Kinematics, Vec<f64>) {
        let step: Vec<f64> = self
            .v
            .iter()
            .zip(&self.a)
            .map(|(v, a)| t * v + 0.5 * t * t * a)
            .collect();
        let mut kinematics = Kinematics::new(&self.model);
        kinematics.update(&self.model, &self.model.integrate(&self.q, &step));
        (
            kinematics,
            self.v.iter().zip(&self.a).map(|(v, a)| v + t * a).collect(),
        )
    }
}

/// Derivative at zero of a curve that is known to second order: differences with two steps, extrapolated.
fn rate(f: impl Fn(f64) -> f64) -> f64 {
    let central = |h: f64| (f(h) - f(-h)) / (2.0 * h);
    (4.0 * central(5e-4) - central(1e-3)) / 3.0
}

fn energy(state: &State, t: f64) -> f64 {
    let (kinematics, v) = state.after(t);
    let model = &state.model;
    let v = DVector::from_vec(v);
    let kinetic = 0.5 * v.dot(&(Crba::new(model).compute(model, &kinematics) * &v));
    let com = CenterOfMass::new(model).compute(model, &kinematics).0;
    kinetic - model.total_mass() * model.gravity.dot(&com)
}

#[test]
fn the_power_of_the_generalised_forces_is_the_rate_of_energy() {
    for state in states() {
        let (kinematics, v) = state.after(0.0);
        let mut rnea = Rnea::new(&state.model);
        let tau = rnea.compute(&state.model, &kinematics, &v, &state.a);
        let power: f64 = tau.iter().zip(&v).map(|(tau, v)| tau * v).sum();
        let measured = rate(|t| energy(&state, t));
        assert!(
            (power - measured).abs() < 1e-6 * (1.0 + power.abs()),
            "{power} against {measured}"
        );
    }
}

#[test]
fn the_base_force_is_the_rate_of_momentum_without_gravity() {
    for state in states().filter(|state| state.q.len() != state.v.len()) {
        let (kinematics, v) = state.after(0.0);
        let model = &state.model;
        let tau = Rnea::new(model)
            .compute(model, &kinematics, &v, &state.a)
            .to_vec();
        let base = kinematics.world_from_joint[0];
        let force = base.rotate(Vector3::new(tau[0], tau[1], tau[2]));
        let moment_at_base = base.rotate(Vector3::new(tau[3], tau[4], tau[5]));
        let com = CenterOfMass::new(model).compute(model, &kinematics).0;
        let moment = moment_at_base + (base.origin() - com).cross(&force);

        let h = |t: f64| {
            let (kinematics, v) = state.after(t);
            let mut centroidal = Centroidal::new(model);
            centroidal.compute(model, &kinematics);
            centroidal.momentum(&v)
        };
        let weight = model.gravity * model.total_mass();
        for row in 0..3 {
            let linear = rate(|t| h(t)[row]);
            assert!((force[row] + weight[row] - linear).abs() < 1e-6 * (1.0 + force.norm()));
            let angular = rate(|t| h(t)[3 + row]);
            assert!((moment[row] - angular).abs() < 1e-6 * (1.0 + moment.norm()));
        }
    }
}

#[test]
fn the_rate_of_momentum_follows_from_its_derivatives() {
    // ḣ = ∂h/∂q v + A a must equal the base wrench as well, without any difference quotient
    for state in states().filter(|state| state.q.len() != state.v.len()) {
        let (kinematics, v) = state.after(0.0);
        let model = &state.model;
        let mut derivatives = CentroidalDerivatives::new(model);
        derivatives.compute(model, &kinematics, &v);
        let h_dot = derivatives.dh_dq() * DVector::from_column_slice(&v)
            + derivatives.dh_dv() * DVector::from_column_slice(&state.a);
        let tau = Rnea::new(model)
            .compute(model, &kinematics, &v, &state.a)
            .to_vec();
        let base = kinematics.world_from_joint[0];
        let force = base.rotate(Vector3::new(tau[0], tau[1], tau[2]));
        let moment_at_base = base.rotate(Vector3::new(tau[3], tau[4], tau[5]));
        let moment = moment_at_base + (base.origin() - derivatives.com()).cross(&force);
        let linear = force + model.gravity * model.total_mass();
        assert!((h_dot.rows(0, 3) - linear).norm() < 1e-11 * linear.norm());
        assert!((h_dot.rows(3, 3) - moment).norm() < 1e-11 * moment.norm());
    }
}

#[test]
fn inverse_dynamics_is_mass_matrix_times_acceleration_plus_bias() {
    for state in states() {
        let (kinematics, v) = state.after(0.0);
        let model = &state.model;
        let mut rnea = Rnea::new(model);
        let bias =
            DVector::from_column_slice(rnea.compute(model, &kinematics, &v, &vec![0.0; model.nv]));
        let tau = DVector::from_column_slice(rnea.compute(model, &kinematics, &v, &state.a));
        let a = DVector::from_column_slice(&state.a);
        let expected = Crba::new(model).compute(model, &kinematics) * a + bias;
        assert!((tau - &expected).norm() < 1e-12 * expected.norm());
    }
}

#[test]
fn moving_the_whole_robot_changes_no_joint_torque() {
    // gravity must point along the same body direction, so only the position and the heading move
    for state in states().filter(|state| state.q.len() != state.v.len()) {
        let model = &state.model;
        let mut moved = state.q.clone();
        let world_from_base = spatial::Pose::from_xyzquat(&std::array::from_fn(|i| state.q[i]));
        let half = 0.4f64;
        let turn = spatial::Pose::from_xyzquat(&[3.0, -2.0, 1.0, 0.0, 0.0, half.sin(), half.cos()]);
        moved[..7].copy_from_slice(&(turn * world_from_base).to_xyzquat());
        let torque = |q: &[f64]| {
            let mut kinematics = Kinematics::new(model);
            kinematics.update(model, q);
            DVector::from_column_slice(Rnea::new(model).compute(
                model,
                &kinematics,
                &state.v,
                &state.a,
            ))
        };
        let (here, there) = (torque(&state.q), torque(&moved));
        assert!((&here - there).norm() < 1e-12 * here.norm());
    }
}
