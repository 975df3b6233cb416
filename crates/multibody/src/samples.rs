//! Random robots with random states, for the tests of this crate: fixed, floating, and a forest of free bodies.

use crate::{Kinematics, Model, Root};
use spatial::Random;

pub(crate) struct Sample {
    pub model: Model,
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub a: Vec<f64>,
    /// Weights on the generalised forces.
    pub w: Vec<f64>,
}

impl Sample {
    fn new(seed: u64, model: Model) -> Self {
        let mut random = Random::new(seed);
        let mut draw = || (0..model.nv).map(|_| random.uniform(-1.0, 1.0)).collect();
        let (v, a, w) = (draw(), draw(), draw());
        Self {
            q: model.random_configuration(seed),
            model,
            v,
            a,
            w,
        }
    }

    pub fn kinematics(&self) -> Kinematics {
        self.kinematics_at(&vec![0.0; self.model.nv])
    }

    /// Kinematics at q ⊕ dq.
    pub fn kinematics_at(&self, dq: &[f64]) -> Kinematics {
        let mut kinematics = Kinematics::new(&self.model);
        kinematics.update(&self.model, &self.model.integrate(&self.q, dq));
        kinematics
    }
}

pub(crate) fn samples() -> Vec<Sample> {
    let mut samples: Vec<Sample> = (0..3)
        .map(|seed| Sample::new(seed, Model::random(seed, Root::Fixed, 6)))
        .collect();
    samples.extend((3..6).map(|seed| Sample::new(seed, Model::random(seed, Root::Floating, 6))));
    samples.push(Sample::new(6, forest()));
    samples
}

/// A floating tree and two loose bodies, one of them in front.
fn forest() -> Model {
    let tree = Model::random(6, Root::Floating, 4);
    let mut joints = vec![tree.joints[0].clone()];
    joints.extend(tree.joints.iter().cloned().map(|mut joint| {
        joint.parent = joint.parent.map(|parent| parent + 1);
        joint
    }));
    joints.push(tree.joints[0].clone());
    Model::new("forest", joints, Vec::new()).expect("roots are free flyers, trees are in order")
}
