//! Motion of every joint and sums over the subtree behind it: what all derivatives of the dynamics share.
//!
//! Frames: world axes, world origin. Legend as in `rnea_derivatives.rs`.

use crate::rnea::{NAN_TWIST, NAN_WRENCH, rising};
use crate::symmetric3::Symmetric3;
use crate::world_inertia::{Gyration, WorldInertia};
use crate::{Kinematics, Model};
use spatial::{Twist, Wrench};

/// A velocity index: its column and the rates that carry derivatives.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Directions {
    /// S
    pub column: Twist,
    /// ψ̇ = [V_λ, S]
    pub psi_dot: Twist,
    /// ψ̈ = [A_λ, S] + [V_λ, ψ̇]
    pub psi_ddot: Twist,
    /// σ = ψ̇ + [V, S]
    pub sigma: Twist,
}

const NAN_DIRECTIONS: Directions = Directions {
    column: NAN_TWIST,
    psi_dot: NAN_TWIST,
    psi_ddot: NAN_TWIST,
    sigma: NAN_TWIST,
};

/// Motion per joint, directions per index, subtree sums per joint.
#[derive(Debug, Clone)]
pub(crate) struct Subtree {
    /// V
    pub twist: Vec<Twist>,
    /// A, the acceleration of the world against gravity included.
    pub acceleration: Vec<Twist>,
    pub directions: Vec<Directions>,
    /// Σ I
    pub inertia: Vec<WorldInertia>,
    /// Σ I V
    pub momentum: Vec<Wrench>,
    /// Σ J̇
    pub rate: Vec<Symmetric3>,
    /// Σ f
    pub force: Vec<Wrench>,
}

impl Subtree {
    pub fn new(model: &Model) -> Self {
        let n = model.joints.len();
        Self {
            twist: vec![NAN_TWIST; n],
            acceleration: vec![NAN_TWIST; n],
            directions: vec![NAN_DIRECTIONS; model.nv],
            inertia: vec![WorldInertia::NAN; n],
            momentum: vec![NAN_WRENCH; n],
            rate: vec![Symmetric3::NAN; n],
            force: vec![NAN_WRENCH; n],
        }
    }

    pub fn compute(&mut self, model: &Model, kinematics: &Kinematics, v: &[f64], a: &[f64]) {
        for i in 0..model.joints.len() {
            self.forward(model, kinematics, v, a, i);
        }
        for (i, joint) in model.joints.iter().enumerate().rev() {
            if let Some(parent) = joint.parent {
                self.add_to(parent, i);
            }
        }
    }

    /// Motion of joint i, its directions, and the terms of its own body.
    #[inline]
    pub fn forward(
        &mut self,
        model: &Model,
        kinematics: &Kinematics,
        v: &[f64],
        a: &[f64],
        i: usize,
    ) {
        let joint = &model.joints[i];
        let own = joint.idx_v..joint.idx_v + joint.kind.nv();
        let (above, above_acceleration) = match joint.parent {
            Some(parent) => (self.twist[parent], self.acceleration[parent]),
            None => (Twist::zero(), rising(model)),
        };
        let (mut twist, mut acceleration) = (above, above_acceleration);
        for k in own.clone() {
            let column = Twist::from_vector(&kinematics.column_in_world[k]);
            let psi_dot = above.cross(&column);
            let psi_ddot = above_acceleration.cross(&column) + above.cross(&psi_dot);
            twist += column * v[k];
            acceleration += column * a[k] + psi_dot * v[k];
            self.directions[k] = Directions {
                column,
                psi_dot,
                psi_ddot,
                sigma: NAN_TWIST,
            };
        }
        for k in own {
            let directions = &mut self.directions[k];
            directions.sigma = directions.psi_dot + twist.cross(&directions.column);
        }
        let inertia = WorldInertia::new(&joint.inertia, &kinematics.world_from_joint[i]);
        let momentum = inertia.apply(&twist);
        self.force[i] = inertia.apply(&acceleration) + twist.cross_wrench(&momentum);
        self.rate[i] = inertia.rate(&twist);
        (self.twist[i], self.acceleration[i]) = (twist, acceleration);
        (self.inertia[i], self.momentum[i]) = (inertia, momentum);
    }

    /// The gyration of the body of joint i, or of the subtree behind it once the sums are complete.
    #[inline]
    pub fn gyration(&self, i: usize) -> Gyration<'_> {
        Gyration {
            momentum: &self.momentum[i],
            rate: &self.rate[i],
        }
    }

    /// Adds the sums of joint i to those of its parent.
    #[inline]
    pub fn add_to(&mut self, parent: usize, i: usize) {
        let (inertia, momentum, rate, force) = (
            self.inertia[i],
            self.momentum[i],
            self.rate[i],
            self.force[i],
        );
        self.inertia[parent] += inertia;
        self.momentum[parent] += momentum;
        self.rate[parent] += rate;
        self.force[parent] += force;
    }
}
