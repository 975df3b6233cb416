//! The pose of one frame relative to another, b_from_a, as a function of all increments of a node.
//!
//! Moving every degree of freedom by its body increment δ changes the relative pose X = b_from_a to
//!
//! ```text
//! X(δ) = X · exp(J_1 δ_1) · exp(J_2 δ_2) · … · exp(J_n δ_n)
//! ```
//!
//! first the chain of b from its tip to its root (with negative columns), then the chain of a from root to tip; the
//! six columns of a floating body share one exponential. All columns are twists of a relative to b, in axes of a.
//! Everything a term needs follows: with gradient g and Hessian H of a function of X by increments of a,
//! its gradient by δ is Jᵀg, and its Hessian Jᵀ H J plus ½ gᵀ[J_k, J_l] for k before l (Baker–Campbell–Hausdorff).
//!
//! Common ancestors of two frames on the robot do not move X and are left out.
//!
//! Source: Murray, Li, Sastry, *A Mathematical Introduction to Robotic Manipulation*, ch. 3 (product of exponentials).

use multibody::{Kinematics, Model};
use nalgebra::{Matrix6, Vector6};
use spatial::Pose;

/// What carries a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Body {
    /// A joint of the system: of the robot, or the free flyer of an object.
    Joint(usize),
    /// The world.
    World,
}

/// A frame fixed to a body.
#[derive(Debug, Clone, Copy)]
pub struct Carrier {
    /// The body.
    pub body: Body,
    /// Pose of the frame in the joint or world frame.
    pub body_from_frame: Pose,
}

impl Carrier {
    /// Pose of the frame in the world.
    pub fn world_from_frame(&self, kinematics: &Kinematics) -> Pose {
        match self.body {
            Body::Joint(j) => kinematics.world_from_joint[j] * self.body_from_frame,
            Body::World => self.body_from_frame,
        }
    }
}

/// Columns that share one exponential.
#[derive(Debug, Clone, Copy)]
struct Group {
    first: usize,
    count: usize,
    /// True if the group's own increments move its own columns (a floating body at the far end of b's chain).
    own: bool,
}

/// The structure of one relative pose: which increments move it, in which order.
#[derive(Debug, Clone)]
pub struct RelativeFrame {
    a: Carrier,
    b: Carrier,
    /// Index of each column in the node's increments.
    pub cols: Vec<usize>,
    groups: Vec<Group>,
    /// Group of each column.
    group_of: Vec<usize>,
    /// How many columns belong to b's chain.
    n_reversed: usize,
}

/// A relative pose and its columns at one configuration.
#[derive(Debug, Clone)]
pub struct Relative {
    /// X = b_from_a.
    pub b_from_a: Pose,
    /// J, one twist per column of the [`RelativeFrame`].
    pub columns: Vec<Vector6<f64>>,
}

impl RelativeFrame {
    /// Analyses which increments of a node move frame `a` relative to frame `b`.
    pub fn new(model: &Model, a: Carrier, b: Carrier) -> Self {
        let chain = |body: Body| -> Vec<Vec<usize>> {
            match body {
                Body::Joint(j) => {
                    let mut groups = Vec::new();
                    let mut joint = Some(j);
                    while let Some(j) = joint {
                        let first = model.joints[j].idx_v;
                        groups.push((first..first + model.joints[j].kind.nv()).collect());
                        joint = model.joints[j].parent;
                    }
                    groups.reverse();
                    groups
                }
                Body::World => vec![],
            }
        };
        let (chain_a, chain_b) = (chain(a.body), chain(b.body));
        let common = chain_a
            .iter()
            .zip(&chain_b)
            .take_while(|(x, y)| x == y)
            .count();
        let mut frame = Self {
            a,
            b,
            cols: vec![],
            groups: vec![],
            group_of: vec![],
            n_reversed: 0,
        };
        for group in chain_b[common..].iter().rev() {
            frame.push(group, group.len() > 1);
        }
        frame.n_reversed = frame.cols.len();
        for group in &chain_a[common..] {
            frame.push(group, false);
        }
        frame
    }

    fn push(&mut self, group: &[usize], own: bool) {
        self.group_of
            .extend(group.iter().map(|_| self.groups.len()));
        self.groups.push(Group {
            first: self.cols.len(),
            count: group.len(),
            own,
        });
        self.cols.extend(group);
    }

    /// Buffers for [`RelativeFrame::update`].
    pub fn relative(&self) -> Relative {
        Relative {
            b_from_a: Pose::identity(),
            columns: vec![Vector6::repeat(f64::NAN); self.cols.len()],
        }
    }

    /// Pose and columns at a configuration.
    pub fn update(&self, kinematics: &Kinematics, out: &mut Relative) {
        let world_from_a = self.a.world_from_frame(kinematics);
        out.b_from_a = self.b.world_from_frame(kinematics).inverse() * world_from_a;
        let (r, p) = (world_from_a.rotation(), world_from_a.origin());
        for (k, (&col, column)) in self.cols.iter().zip(&mut out.columns).enumerate() {
            let sign = if k < self.n_reversed { -1.0 } else { 1.0 };
            let in_world = kinematics.column_in_world[col];
            let (v, w) = (in_world.fixed_rows::<3>(0), in_world.fixed_rows::<3>(3));
            let linear = r.tr_mul(&(v + w.cross(&p))) * sign;
            let angular = r.tr_mul(&w) * sign;
            *column = Vector6::new(
                linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
            );
        }
    }

    /// Calls `add(k, l, value)` for the lower triangle (columns k ≥ l) of Jᵀ H J + ½ gᵀ[J_l, J_k].
    ///
    /// `gradient` and `hessian` are those of a scalar function of X by body increments of a.
    pub fn pose_hessian(
        &self,
        relative: &Relative,
        gradient: &Vector6<f64>,
        hessian: &Matrix6<f64>,
        mut add: impl FnMut(usize, usize, f64),
    ) {
        for (l, (first, &group)) in relative.columns.iter().zip(&self.group_of).enumerate() {
            let h = hessian * first;
            // gᵀ[J_l, J_k] = (ad(J_l)ᵀ g)·J_k
            let bracket = h + bracket_transpose(first, gradient) * 0.5;
            let later = relative.columns.iter().zip(&self.group_of).enumerate();
            for (k, (column, &other)) in later.skip(l) {
                let by = if other == group { &h } else { &bracket };
                add(k, l, by.dot(column));
            }
        }
    }

    /// The columns before column `l` in the product, those of its own exponential included if it moves itself.
    fn end_of_predecessors(&self, l: usize) -> usize {
        let group = self.groups[self.group_of[l]];
        if group.own {
            group.first + group.count
        } else {
            group.first
        }
    }

    /// ∂(J_kᵀ λ)/∂δ_l = λᵀ[J_k, J_l] for every k that precedes l: calls `add(k, l, value)`.
    pub fn wrench_jacobian(
        &self,
        relative: &Relative,
        wrench: &Vector6<f64>,
        mut add: impl FnMut(usize, usize, f64),
    ) {
        for l in 0..self.cols.len() {
            // λᵀ[J_k, J_l] = −(ad(J_l)ᵀ λ)·J_k
            let dual = -bracket_transpose(&relative.columns[l], wrench);
            for k in 0..self.end_of_predecessors(l) {
                add(k, l, dual.dot(&relative.columns[k]));
            }
        }
    }

    /// ∂(J W)/∂δ_l for virtual speeds W of the columns: calls `add(l, derivative)`.
    pub fn virtual_power_gradient(
        &self,
        relative: &Relative,
        virtual_speeds: &[f64],
        mut add: impl FnMut(usize, Vector6<f64>),
    ) {
        let mut prefix = Vector6::zeros();
        let mut summed = 0;
        for l in 0..self.cols.len() {
            while summed < self.end_of_predecessors(l) {
                prefix += relative.columns[summed] * virtual_speeds[summed];
                summed += 1;
            }
            add(l, bracket(&prefix, &relative.columns[l]));
        }
    }

    /// Derivatives of λᵀ J W for virtual speeds W of the columns: calls `by_wrench(l, ∂²/∂λ∂δ_l)` and
    /// `by_increments(m, l, ∂²/∂δ_m∂δ_l)` for m ≥ l.
    pub fn virtual_power_hessian(
        &self,
        relative: &Relative,
        wrench: &Vector6<f64>,
        virtual_speeds: &[f64],
        mut by_wrench: impl FnMut(usize, Vector6<f64>),
        mut by_increments: impl FnMut(usize, usize, f64),
    ) {
        let mut prefix = Vector6::zeros();
        let mut summed = 0;
        for l in 0..self.cols.len() {
            let end = self.end_of_predecessors(l);
            while summed < end {
                prefix += relative.columns[summed] * virtual_speeds[summed];
                summed += 1;
            }
            let column = &relative.columns[l];
            // J W moves by [P_l, J_l]; moved again by a later (or the same) column m: [[P_l, J_l], J_m].
            let moved = bracket(&prefix, column);
            by_wrench(l, moved);
            let group = self.groups[self.group_of[l]];
            let dual = bracket_transpose(&moved, wrench);
            for m in l..self.cols.len() {
                let mut value = dual.dot(&relative.columns[m]);
                if m < group.first + group.count && m > l {
                    // Inside one exponential the second-order term is symmetric in the two columns.
                    let other = bracket(&prefix, &relative.columns[m]);
                    value = 0.5 * (value + bracket_transpose(&other, wrench).dot(column));
                }
                by_increments(m, l, value);
            }
        }
    }
}

/// Lie bracket [x, y] of twists, linear part first.
#[inline]
pub(crate) fn bracket(x: &Vector6<f64>, y: &Vector6<f64>) -> Vector6<f64> {
    let (vx, wx) = (x.fixed_rows::<3>(0), x.fixed_rows::<3>(3));
    let (vy, wy) = (y.fixed_rows::<3>(0), y.fixed_rows::<3>(3));
    let linear = wx.cross(&vy) + vx.cross(&wy);
    let angular = wx.cross(&wy);
    Vector6::new(
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    )
}

/// ad(x)ᵀ g, so that gᵀ[x, y] = (ad(x)ᵀ g)·y.
#[inline]
pub(crate) fn bracket_transpose(x: &Vector6<f64>, g: &Vector6<f64>) -> Vector6<f64> {
    let (v, w) = (x.fixed_rows::<3>(0), x.fixed_rows::<3>(3));
    let (f, n) = (g.fixed_rows::<3>(0), g.fixed_rows::<3>(3));
    // g·[x, y] = f·(w × y_v) + f·(v × y_w) + n·(w × y_w)
    let linear = f.cross(&w);
    let angular = f.cross(&v) + n.cross(&w);
    Vector6::new(
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    )
}
