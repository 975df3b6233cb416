//! Sticking at velocity level: the tangential velocity of `a` relative to `b` and, for patches, its yaw rate are zero.
//!
//! Frames: the relative twist s = J(q) v is of a relative to b in axes of a; its rows here are turned into axes of b,
//! (R s_lin)_xy and (R s_ang)_z with R of b_from_a. For aligned patches they are the velocities of
//! [`Place`](super::place::Place).
//! Source: paper, eq. (point_position), (patch_patch_position) and (patch_patch_orientation), second parts:
//! (ʲv_i^rel)_xy = 0 and (ʲω_i^rel)_z = 0. For the paper's preset (formulation 2.2, 2.14).
//!
//! With g = (Rᵀu_lin, Rᵀu_ang), u the weights of the rows, the weighted sum is gᵀ J v.

use super::pose_functions::{direction_gradient, direction_hessian};
use crate::relative::{Relative, RelativeFrame};
use nalgebra::{Vector3, Vector6};

/// Rows: two, and one more with `yaw`.
pub fn n_rows(yaw: bool) -> usize {
    if yaw { 3 } else { 2 }
}

/// Weighted rows as the dual of a twist in axes of a.
fn dual(relative: &Relative, weights: &[f64]) -> Vector6<f64> {
    let (linear, angular) = directions(weights);
    let rot = relative.b_from_a.rotation();
    let (l, a) = (rot.tr_mul(&linear), rot.tr_mul(&angular));
    Vector6::new(l.x, l.y, l.z, a.x, a.y, a.z)
}

fn directions(weights: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
    let yaw = weights.get(2).copied().unwrap_or(0.0);
    (
        Vector3::new(weights[0], weights[1], 0.0),
        Vector3::new(0.0, 0.0, yaw),
    )
}

fn parts(twist: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (
        Vector3::new(twist[0], twist[1], twist[2]),
        Vector3::new(twist[3], twist[4], twist[5]),
    )
}

/// s = J v in axes of a.
fn twist(relative: &Relative, speeds: &[f64]) -> Vector6<f64> {
    relative
        .columns
        .iter()
        .zip(speeds)
        .map(|(j, v)| j * *v)
        .sum()
}

/// The rows [m/s, rad/s]; `speeds` of the frame's columns.
pub fn values(relative: &Relative, speeds: &[f64], out: &mut [f64]) {
    let (linear, angular) = parts(&twist(relative, speeds));
    let rot = relative.b_from_a.rotation();
    let v = rot * linear;
    out[0] = v.x;
    out[1] = v.y;
    if out.len() == 3 {
        out[2] = (rot * angular).z;
    }
}

/// Gradient of Σ weight · row by the frame's columns: calls `add(l, by increment, by speed)`.
pub fn gradient(
    frame: &RelativeFrame,
    relative: &Relative,
    speeds: &[f64],
    weights: &[f64],
    mut add: impl FnMut(usize, f64, f64),
) {
    let dual = dual(relative, weights);
    let turned = turn(relative, &twist(relative, speeds), weights);
    frame.virtual_power_gradient(relative, speeds, |l, moved| {
        let column = &relative.columns[l];
        add(l, turned.dot(column) + dual.dot(&moved), dual.dot(column));
    });
}

/// Gradient by increments of a of u_lin·(R s_lin) + u_ang·(R s_ang) at constant s.
fn turn(relative: &Relative, twist: &Vector6<f64>, weights: &[f64]) -> Vector6<f64> {
    let x = &relative.b_from_a;
    let ((u_lin, u_ang), (s_lin, s_ang)) = (directions(weights), parts(twist));
    direction_gradient(x, &s_lin, &u_lin) + direction_gradient(x, &s_ang, &u_ang)
}

/// Hessian of Σ weight · row: calls `by_increments(k, l, value)` for the lower triangle k ≥ l, and
/// `mixed(l, k, value)` by increment l and speed k.
pub fn hessian(
    frame: &RelativeFrame,
    relative: &Relative,
    speeds: &[f64],
    weights: &[f64],
    mut by_increments: impl FnMut(usize, usize, f64),
    mut mixed: impl FnMut(usize, usize, f64),
) {
    let x = &relative.b_from_a;
    let twist = twist(relative, speeds);
    let dual = dual(relative, weights);
    let ((u_lin, u_ang), (s_lin, s_ang)) = (directions(weights), parts(&twist));
    // The turn of R at constant s, and the motion of J v at constant R.
    let h = direction_hessian(x, &s_lin, &u_lin) + direction_hessian(x, &s_ang, &u_ang);
    frame.pose_hessian(
        relative,
        &turn(relative, &twist, weights),
        &h,
        &mut by_increments,
    );
    frame.virtual_power_hessian(relative, &dual, speeds, |_, _| (), &mut by_increments);
    frame.wrench_jacobian(relative, &dual, |k, l, value| mixed(l, k, value));
    // Both at once.
    let (d_lin, d_ang) = parts(&dual);
    for l in 0..relative.columns.len() {
        let omega = parts(&relative.columns[l]).1;
        let (lin, ang) = (d_lin.cross(&omega), d_ang.cross(&omega));
        let turned = Vector6::new(lin.x, lin.y, lin.z, ang.x, ang.y, ang.z);
        for (k, column) in relative.columns.iter().enumerate() {
            mixed(l, k, turned.dot(column));
        }
        frame.virtual_power_gradient(relative, speeds, |k, moved| {
            let value = turned.dot(&moved);
            by_increments(k.max(l), k.min(l), if k == l { 2.0 * value } else { value });
        });
    }
}
