//! Forward kinematics and frame Jacobians.
//!
//! Frames: `world`; column k is the twist of everything behind velocity index k for a unit rate, in world axes, at the
//! world origin, so columns of all joints live in one space and need no transport.
//! Source: Featherstone, *Rigid Body Dynamics Algorithms*, sections 2.2 and 4.4.

use crate::configuration::base_pose;
use crate::model::Motion;
use crate::{JointKind, Model};
use nalgebra::{DMatrix, Matrix3, Matrix6xX, Vector3, Vector6};
use spatial::{Pose, Twist, Wrench};

/// Poses and joint axes at one configuration; evaluated once, used by every algorithm.
#[derive(Debug, Clone)]
pub struct Kinematics {
    /// Pose of every joint frame in the world.
    pub world_from_joint: Vec<Pose>,
    /// For every velocity index the twist of a unit rate: at the world origin, world axes, linear first.
    pub column_in_world: Vec<Vector6<f64>>,
}

impl Kinematics {
    /// Room for a model; filled with NaN until the first update.
    pub fn new(model: &Model) -> Self {
        let nowhere = Pose::from_translation(f64::NAN, f64::NAN, f64::NAN);
        Self {
            world_from_joint: vec![nowhere; model.joints.len()],
            column_in_world: vec![Vector6::repeat(f64::NAN); model.nv],
        }
    }

    /// Poses and columns at the configuration `q` (length nq; the quaternion need not be normalised). No allocation.
    ///
    /// # Panics
    /// If `q` has the wrong length.
    pub fn update(&mut self, model: &Model, q: &[f64]) {
        assert_eq!(q.len(), model.nq, "length of q");
        for (i, joint) in model.joints.iter().enumerate() {
            let world_from_zero = match joint.parent {
                Some(parent) => self.world_from_joint[parent] * joint.parent_from_joint,
                None => joint.parent_from_joint,
            };
            let columns = &mut self.column_in_world[joint.idx_v..];
            self.world_from_joint[i] = match &model.motions[i] {
                Motion::Free => {
                    let world_from_joint = world_from_zero * base_pose(&q[joint.idx_q..]);
                    free_columns(&world_from_joint, columns);
                    world_from_joint
                }
                Motion::TurnAbout(axis) => {
                    let (rotation, origin) = (world_from_zero.rotation(), world_from_zero.origin());
                    columns[0] = turning(&rotation.column(*axis).into_owned(), &origin);
                    Pose::from_parts(turned_about(rotation, *axis, q[joint.idx_q]), origin)
                }
                Motion::Turn(axis) => {
                    let (rotation, origin) = (world_from_zero.rotation(), world_from_zero.origin());
                    columns[0] = turning(&(rotation * axis), &origin);
                    Pose::from_parts(
                        rotation * spatial::exp_so3(&(axis * q[joint.idx_q])),
                        origin,
                    )
                }
                Motion::Slide(axis) => {
                    let direction = world_from_zero.rotate(*axis);
                    columns[0] = Vector6::new(direction.x, direction.y, direction.z, 0.0, 0.0, 0.0);
                    let origin = world_from_zero.origin() + direction * q[joint.idx_q];
                    Pose::from_parts(*world_from_zero.rotation(), origin)
                }
            };
        }
    }

    /// Pose of a frame in the world.
    #[inline]
    pub fn frame_pose(&self, model: &Model, frame: usize) -> Pose {
        let frame = &model.frames[frame];
        match frame.joint {
            Some(joint) => self.world_from_joint[joint] * frame.joint_from_frame,
            None => frame.joint_from_frame,
        }
    }

    /// Body Jacobian of a frame, 6×nv: its twist in its own frame (at its origin, linear first) is J v, and a body
    /// increment of its pose is J δq. Every entry is written; columns outside [`Model::frame_support`] are zero.
    ///
    /// # Panics
    /// If `jacobian` has not nv columns.
    pub fn frame_jacobian_in_frame(
        &self,
        model: &Model,
        frame: usize,
        jacobian: &mut Matrix6xX<f64>,
    ) {
        assert_eq!(jacobian.ncols(), model.nv, "columns of the Jacobian");
        jacobian.fill(0.0);
        let world_from_frame = self.frame_pose(model, frame);
        for &k in model.frame_support(frame) {
            jacobian.set_column(k, &self.column_in(&world_from_frame, k));
        }
    }

    /// Adds the Hessian of δ ↦ yᵀ log(X(q)⁻¹ X(q ⊕ δ)) at 0 for the pose X of a frame: the curvature that its body Jacobian
    /// leaves out. `y` is in the frame (force, then moment), `hessian` nv×nv, symmetric.
    ///
    /// With J the body Jacobian and k before l on the chain, ∂J_k/∂q_l = [J_k, J_l] and ∂J_l/∂q_k = 0, so both entries get
    /// ½ yᵀ[J_k, J_l]. The six base columns move as one exponential and add nothing among themselves.
    ///
    /// # Panics
    /// If `hessian` is smaller than nv×nv.
    pub fn add_frame_curvature(
        &self,
        model: &Model,
        frame: usize,
        y: &Wrench,
        hessian: &mut DMatrix<f64>,
    ) {
        let y_in_world = self.frame_pose(model, frame).act_wrench(y);
        let mut next = model.frames[frame].joint;
        while let Some(index) = next {
            let joint = &model.joints[index];
            let support = model.joint_support(index);
            let before = &support[..support.len() - joint.kind.nv()];
            for l in joint.idx_v..joint.idx_v + joint.kind.nv() {
                let column = Twist::from_vector(&self.column_in_world[l]);
                let turned = column.cross_wrench(&y_in_world) * 0.5;
                for &k in before {
                    let value = turned.power(&Twist::from_vector(&self.column_in_world[k]));
                    hessian[(k, l)] += value;
                    hessian[(l, k)] += value;
                }
            }
            next = joint.parent;
        }
    }

    /// Column k in the coordinates of a frame.
    #[inline]
    fn column_in(&self, world_from_frame: &Pose, k: usize) -> Vector6<f64> {
        let column = Twist::from_vector(&self.column_in_world[k]);
        let linear = world_from_frame.rotate_inverse(column.at(&world_from_frame.origin()));
        let angular = world_from_frame.rotate_inverse(column.angular);
        Vector6::new(
            linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
        )
    }

    /// Twist of a joint frame with velocity `v`: at the world origin, world axes.
    pub fn joint_twist_in_world(&self, model: &Model, joint: usize, v: &[f64]) -> Twist {
        let sum = model
            .joint_support(joint)
            .iter()
            .map(|&k| self.column_in_world[k] * v[k])
            .sum();
        Twist::from_vector(&sum)
    }
}

#[inline]
fn free_columns(world_from_joint: &Pose, columns: &mut [Vector6<f64>]) {
    let (rotation, origin) = (world_from_joint.rotation(), world_from_joint.origin());
    for c in 0..3 {
        let axis = rotation.column(c).into_owned();
        columns[c] = Vector6::new(axis.x, axis.y, axis.z, 0.0, 0.0, 0.0);
        columns[3 + c] = turning(&axis, &origin);
    }
}

/// Twist at the world origin of a unit turn about `axis` through `point`.
#[inline]
fn turning(axis: &Vector3<f64>, point: &Vector3<f64>) -> Vector6<f64> {
    let linear = point.cross(axis);
    Vector6::new(linear.x, linear.y, linear.z, axis.x, axis.y, axis.z)
}

/// R · Rot(e_axis, angle): only the two other columns change.
#[inline]
fn turned_about(rotation: &Matrix3<f64>, axis: usize, angle: f64) -> Matrix3<f64> {
    let (sine, cosine) = angle.sin_cos();
    let (j, k) = [(1, 2), (2, 0), (0, 1)][axis];
    let (along_j, along_k) = (
        rotation.column(j).into_owned(),
        rotation.column(k).into_owned(),
    );
    let mut turned = *rotation;
    turned.set_column(j, &(along_j * cosine + along_k * sine));
    turned.set_column(k, &(along_k * cosine - along_j * sine));
    turned
}

impl JointKind {
    /// Pose of the joint frame relative to where it is at q = 0, for a single-degree joint at `position`.
    pub(crate) fn displacement(&self, position: f64) -> Pose {
        match self {
            Self::FreeFlyer => Pose::identity(),
            Self::Revolute { axis } => {
                Pose::from_parts(spatial::exp_so3(&(axis * position)), Vector3::zeros())
            }
            Self::Prismatic { axis } => Pose::from_parts(Matrix3::identity(), axis * position),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Root;
    use derivcheck::assert_jacobian;

    #[test]
    fn poses_are_products_of_placements_and_displacements() {
        for seed in 0..5 {
            let model = Model::random(seed, Root::Fixed, 7);
            let q = model.random_configuration(seed);
            let mut kinematics = Kinematics::new(&model);
            kinematics.update(&model, &q);
            for (i, joint) in model.joints.iter().enumerate() {
                let above = joint.parent.map_or(Pose::identity(), |parent| {
                    kinematics.world_from_joint[parent]
                });
                let expected =
                    above * joint.parent_from_joint * joint.kind.displacement(q[joint.idx_q]);
                assert!(expected.minus(&kinematics.world_from_joint[i]).norm() < 1e-14);
            }
        }
    }

    #[test]
    fn frame_jacobians_match_finite_differences() {
        for (seed, root) in [(1, Root::Fixed), (2, Root::Floating), (3, Root::Floating)] {
            let model = Model::random(seed, root, 9);
            let q = model.random_configuration(seed);
            let pose_at = |q: &[f64], frame| {
                let mut kinematics = Kinematics::new(&model);
                kinematics.update(&model, q);
                kinematics.frame_pose(&model, frame)
            };
            let mut kinematics = Kinematics::new(&model);
            kinematics.update(&model, &q);
            for frame in 0..model.frames.len() {
                let here = kinematics.frame_pose(&model, frame);
                let mut jacobian = Matrix6xX::repeat(model.nv, f64::NAN);
                kinematics.frame_jacobian_in_frame(&model, frame, &mut jacobian);
                let moved = |dq: &[f64]| {
                    pose_at(&model.integrate(&q, dq), frame)
                        .minus(&here)
                        .as_slice()
                        .to_vec()
                };
                assert_jacobian(moved, &vec![0.0; model.nv], jacobian.as_slice(), 1e-9);
            }
        }
    }

    #[test]
    fn frame_curvature_matches_finite_differences() {
        for (seed, root) in [(1, Root::Fixed), (2, Root::Floating), (3, Root::Floating)] {
            let model = Model::random(seed, root, 7);
            let q = model.random_configuration(seed);
            let y = Wrench::from_vector(&Vector6::new(0.3, -0.5, 0.8, 0.2, 0.9, -0.4));
            let pose_at = |q: &[f64], frame| {
                let mut kinematics = Kinematics::new(&model);
                kinematics.update(&model, q);
                kinematics.frame_pose(&model, frame)
            };
            let mut kinematics = Kinematics::new(&model);
            kinematics.update(&model, &q);
            let frame = model.frames.len() - 1;
            let here = kinematics.frame_pose(&model, frame);
            let mut hessian = DMatrix::zeros(model.nv, model.nv);
            kinematics.add_frame_curvature(&model, frame, &y, &mut hessian);
            let value = |dq: &[f64]| {
                let moved = pose_at(&model.integrate(&q, dq), frame).minus(&here);
                y.to_vector().dot(&moved)
            };
            let zero = vec![0.0; model.nv];
            derivcheck::assert_hessian_of_value(value, &zero, hessian.as_slice(), 1e-7);
        }
    }

    #[test]
    fn the_twist_of_a_joint_is_the_sum_over_its_support() {
        let model = Model::random(4, Root::Floating, 6);
        let mut kinematics = Kinematics::new(&model);
        kinematics.update(&model, &model.random_configuration(4));
        let v: Vec<f64> = (0..model.nv).map(|k| 0.1 * k as f64 - 0.4).collect();
        let frame = model.frames.len() - 1;
        let joint = model.frames[frame]
            .joint
            .expect("every frame of a random tree is on a joint");
        let mut jacobian = Matrix6xX::zeros(model.nv);
        kinematics.frame_jacobian_in_frame(&model, frame, &mut jacobian);
        let by_jacobian = jacobian * nalgebra::DVector::from_column_slice(&v);
        let world_from_frame = kinematics.frame_pose(&model, frame);
        let twist = world_from_frame
            .inverse()
            .act_twist(&kinematics.joint_twist_in_world(&model, joint, &v));
        assert!((twist.to_vector() - by_jacobian).norm() < 1e-13);
    }
}
