//! Inverse dynamics τ = ID(q, v, a) by the recursive Newton–Euler algorithm.
//!
//! Frames: everything in world axes about the world origin. Legend: V twist, A spatial acceleration minus gravity,
//! f = I A + V ×* I V the force that a body needs, F its sum over the subtree, τ_k = S_k · F.
//! Source: Featherstone, *Rigid Body Dynamics Algorithms*, section 5.3.

use crate::model::Motion;
use crate::{Kinematics, Model};
use nalgebra::Vector3;
use spatial::{Inertia, Pose, Twist, Wrench};

/// Workspace of the recursive Newton–Euler algorithm.
#[derive(Debug, Clone)]
pub struct Rnea {
    twist: Vec<Twist>,
    acceleration: Vec<Twist>,
    force: Vec<Wrench>,
    tau: Vec<f64>,
}

impl Rnea {
    /// Room for a model; filled with NaN.
    pub fn new(model: &Model) -> Self {
        let n = model.joints.len();
        Self {
            twist: vec![NAN_TWIST; n],
            acceleration: vec![NAN_TWIST; n],
            force: vec![NAN_WRENCH; n],
            tau: vec![f64::NAN; model.nv],
        }
    }

    /// Generalised forces τ = M(q) a + b(q, v), gravity included, length nv: for a floating base the first six are the
    /// force and moment on the base in its own frame. No allocation.
    ///
    /// # Panics
    /// If `v` or `a` is shorter than nv.
    pub fn compute(
        &mut self,
        model: &Model,
        kinematics: &Kinematics,
        v: &[f64],
        a: &[f64],
    ) -> &[f64] {
        for (i, joint) in model.joints.iter().enumerate() {
            let world_from_joint = &kinematics.world_from_joint[i];
            let (above, above_acceleration) = match joint.parent {
                Some(parent) => (self.twist[parent], self.acceleration[parent]),
                None => (Twist::zero(), rising(model)),
            };
            let (relative, push) = if model.motions[i] == Motion::Free {
                let at = |x: &[f64]| world_from_joint.act_twist(&free_twist(&x[joint.idx_v..]));
                (at(v), at(a))
            } else {
                let column = Twist::from_vector(&kinematics.column_in_world[joint.idx_v]);
                (column * v[joint.idx_v], column * a[joint.idx_v])
            };
            let twist = above + relative;
            let acceleration = above_acceleration + push + above.cross(&relative);
            self.force[i] =
                force_of_inertia(&joint.inertia, world_from_joint, &twist, &acceleration);
            (self.twist[i], self.acceleration[i]) = (twist, acceleration);
        }
        for (i, joint) in model.joints.iter().enumerate().rev() {
            let force = self.force[i];
            for k in joint.idx_v..joint.idx_v + joint.kind.nv() {
                self.tau[k] = force.power(&Twist::from_vector(&kinematics.column_in_world[k]));
            }
            if let Some(parent) = joint.parent {
                self.force[parent] += force;
            }
        }
        &self.tau
    }
}

pub(crate) const NAN_TWIST: Twist = Twist {
    linear: NAN_VECTOR,
    angular: NAN_VECTOR,
};
pub(crate) const NAN_WRENCH: Wrench = Wrench {
    linear: NAN_VECTOR,
    angular: NAN_VECTOR,
};
pub(crate) const NAN_VECTOR: Vector3<f64> = Vector3::new(f64::NAN, f64::NAN, f64::NAN);

/// The acceleration of the world that replaces gravity.
#[inline]
pub(crate) fn rising(model: &Model) -> Twist {
    Twist {
        linear: -model.gravity,
        angular: Vector3::zeros(),
    }
}

#[inline]
pub(crate) fn free_twist(x: &[f64]) -> Twist {
    Twist {
        linear: Vector3::new(x[0], x[1], x[2]),
        angular: Vector3::new(x[3], x[4], x[5]),
    }
}

/// I A + V ×* I V through the classical acceleration of the centre of mass, the rotational part in body axes.
#[inline]
fn force_of_inertia(
    inertia: &Inertia,
    world_from_body: &Pose,
    twist: &Twist,
    acceleration: &Twist,
) -> Wrench {
    let com = world_from_body.act(inertia.com);
    let com_acceleration = acceleration.at(&com) + twist.angular.cross(&twist.at(&com));
    let linear = com_acceleration * inertia.mass;

    let w = world_from_body.rotate_inverse(twist.angular);
    let w_dot = world_from_body.rotate_inverse(acceleration.angular);
    let spin = inertia.inertia * w_dot + w.cross(&(inertia.inertia * w));
    Wrench {
        linear,
        angular: world_from_body.rotate(spin) + com.cross(&linear),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Frame, Joint, JointKind, Root};
    use nalgebra::Matrix3;

    /// A point of 2 kg on a massless rod of 0.5 m that turns about y; at q = 0 it hangs down.
    fn pendulum() -> Model {
        let tip = Inertia {
            mass: 2.0,
            com: Vector3::new(0.0, 0.0, -0.5),
            inertia: Matrix3::zeros(),
        };
        let joint = Joint {
            kind: JointKind::Revolute { axis: Vector3::y() },
            inertia: tip,
            ..Model::random(0, Root::Fixed, 1).joints[0].clone()
        };
        let joint = Joint {
            parent_from_joint: Pose::identity(),
            ..joint
        };
        Model::new("pendulum", vec![joint], Vec::<Frame>::new()).expect("one joint with mass")
    }

    #[test]
    fn a_pendulum_obeys_its_textbook_equation() {
        let model = pendulum();
        let (mut kinematics, mut rnea) = (Kinematics::new(&model), Rnea::new(&model));
        for (q, v, a) in [(0.0, 0.0, 0.0), (0.7, 2.0, 0.0), (-1.2, 0.3, 5.0)] {
            kinematics.update(&model, &[q]);
            // τ = m l² q̈ + m g l sin q
            let expected = 2.0 * 0.25 * a + 2.0 * 9.81 * 0.5 * f64::sin(q);
            let tau = rnea.compute(&model, &kinematics, &[v], &[a])[0];
            assert!((tau - expected).abs() < 1e-13, "{tau} for {expected}");
        }
    }

    #[test]
    fn a_floating_robot_at_rest_is_held_by_its_weight() {
        let model = Model::random(5, Root::Floating, 6);
        let (mut kinematics, mut rnea) = (Kinematics::new(&model), Rnea::new(&model));
        kinematics.update(&model, &model.random_configuration(5));
        let zero = vec![0.0; model.nv];
        let tau = rnea.compute(&model, &kinematics, &zero, &zero);
        let force_in_world =
            kinematics.world_from_joint[0].rotate(Vector3::new(tau[0], tau[1], tau[2]));
        let weight = Vector3::new(0.0, 0.0, 9.81 * model.total_mass());
        assert!((force_in_world - weight).norm() < 1e-11);
    }
}
