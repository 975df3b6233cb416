//! What a contact can transmit: normal force, friction, centre of pressure, torsion.
//!
//! With f the force in the axes of `b`, k the moment in the axes of `a`, fn = f_z: `fn ≥ 0`, `|f_xy| ≤ μ fn`; patches:
//! `|k_x| ≤ fn ξ_y`, `|k_y| ≤ fn ξ_x` with ξ the half size of `a`, the centre of pressure inside `b`, `|k_z| ≤ μ_r fn`.
//! A point transmits no moment. Source: paper, unilateral point and patch contacts; `docs/plan-format.md`, wrenches.

use nalgebra::Vector3;

use crate::categories::Category;
use crate::measure::Measurements;
use crate::motion::{Contact, Motion};

/// Least normal force at which the centre of pressure on `b` is judged [N]: below, it is noise.
const LEAST_FORCE_FOR_COP: f64 = 1.0;

/// Judges the wrench of every contact in every interval; the centre of pressure may be `bounds_tolerance` [m] outside
/// `b`, as the patch itself may.
pub(crate) fn judge(motion: &Motion, bounds_tolerance: f64, found: &mut Measurements) {
    for t in 0..motion.n_intervals() {
        for (contact, force, moment) in motion.loads(t) {
            let place = || motion.place(t, &contact.name);
            let (force_in_b, moment_in_a) = in_own_axes(motion, contact, t, &force, &moment);
            if !contact.kind.is_patch() {
                found.add(Category::PointMoment, moment_in_a.norm(), place);
            }
            if !contact.kind.is_unilateral() {
                continue;
            }
            let normal = force_in_b.z;
            found.add(Category::NormalForce, at_least_zero(-normal), place);
            found.add(
                Category::FrictionCone,
                at_least_zero(force_in_b.xy().norm() - contact.mu * normal),
                place,
            );
            if contact.kind.is_patch() {
                let normal = normal.max(0.0);
                found.add(
                    Category::Torsion,
                    at_least_zero(moment_in_a.z.abs() - contact.mu_r * normal),
                    place,
                );
                if let Some(excess) = beyond_patch_a(motion, contact, &moment_in_a, normal) {
                    found.add(Category::Cop, excess, place);
                }
                if let Some(excess) =
                    beyond_patch_b(motion, contact, t, &moment_in_a, normal, bounds_tolerance)
                {
                    found.add(Category::Cop, excess, place);
                }
            }
        }
    }
}

/// Force in the axes of `b`, moment about `a`'s origin in the axes of `a`.
pub(crate) fn in_own_axes(
    motion: &Motion,
    contact: &Contact,
    t: usize,
    force: &Vector3<f64>,
    moment: &Vector3<f64>,
) -> (Vector3<f64>, Vector3<f64>) {
    let [world_from_a, world_from_b] =
        [contact.a, contact.b].map(|i| &motion.frames[t][i].world_from_frame);
    (
        world_from_b.rotate_inverse(*force),
        world_from_a.rotate_inverse(*moment),
    )
}

/// Like `max(x, 0)`, but keeps what is not a number.
fn at_least_zero(x: f64) -> f64 {
    if x < 0.0 { 0.0 } else { x }
}

/// Moment beyond what the extent of `a` allows [N m]; `None`: unbounded.
fn beyond_patch_a(
    motion: &Motion,
    contact: &Contact,
    moment_in_a: &Vector3<f64>,
    normal: f64,
) -> Option<f64> {
    let [half_x, half_y] = motion.interfaces[contact.a].half;
    let excess = |moment: f64, half: f64| {
        half.is_finite()
            .then(|| at_least_zero(moment.abs() - normal * half))
    };
    let (about_x, about_y) = (excess(moment_in_a.x, half_y), excess(moment_in_a.y, half_x));
    about_x.into_iter().chain(about_y).reduce(f64::max)
}

/// Distance of the centre of pressure from `b`'s rectangle times the normal force [N m]; `None`: unbounded or hardly
/// loaded.
fn beyond_patch_b(
    motion: &Motion,
    contact: &Contact,
    t: usize,
    moment_in_a: &Vector3<f64>,
    normal: f64,
    bounds_tolerance: f64,
) -> Option<f64> {
    let half = motion.interfaces[contact.b].half;
    if half.iter().all(|x| x.is_infinite()) || normal <= LEAST_FORCE_FOR_COP {
        return None;
    }
    // The normal of `a` points into `b`, so the force on `a` along it is −fn: x = k_y / fn, y = −k_x / fn.
    let cop_in_a = Vector3::new(moment_in_a.y, -moment_in_a.x, 0.0) / normal;
    let cop_in_b = motion.b_from_a(contact, t).act(cop_in_a);
    let beyond = (cop_in_b.x.abs() - half[0]).max(cop_in_b.y.abs() - half[1]);
    Some(normal * at_least_zero(beyond - bounds_tolerance))
}
