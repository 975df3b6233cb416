//! Where the contacts are: in the plane, aligned, inside the extent; at both ends of every interval of their phase.
//!
//! With r and R the position and rotation of interface `a` in the frame of `b`: `r_z = 0`; patches: `a`'s z axis is −z of `b`;
//! points: the limb direction of `a` does not point below the plane of `b`; bounded `b`: the origin of `a` (or all four
//! corners) inside `b`'s rectangle.
//! Source: paper, eqs. on point–patch and patch–patch contact; `docs/plan-format.md`, contact geometry.

use nalgebra::Vector3;
use spatial::Pose;

use crate::categories::Category;
use crate::measure::Measurements;
use crate::motion::{Contact, Interface, Motion};

/// Judges all contacts at all nodes of their phases.
pub(crate) fn judge(motion: &Motion, found: &mut Measurements) {
    for (phase, contact) in motion.contacts() {
        for t in phase.start..=phase.end {
            let b_from_a = motion.b_from_a(contact, t);
            let place = || motion.place(t, &contact.name);
            found.add(Category::ContactDistance, b_from_a.origin().z.abs(), place);
            if contact.kind.is_patch() {
                let normal_in_b = b_from_a.rotate(Vector3::z());
                let angle = normal_in_b.xy().norm().atan2(-normal_in_b.z);
                found.add(Category::ContactAlignment, angle, place);
            } else {
                let limb_in_b = b_from_a.rotate(motion.interfaces[contact.a].limb);
                found.add(
                    Category::Halfspace,
                    (-limb_in_b.z).clamp(0.0, 1.0).asin(),
                    place,
                );
            }
            let [a, b] = [contact.a, contact.b].map(|i| &motion.interfaces[i]);
            if let Some(beyond) = beyond_extent(contact, a, b, &b_from_a) {
                found.add(Category::ContactBounds, beyond.max(0.0), place);
            }
        }
    }
}

/// How far the origin, or the corners, of `a` are outside `b`'s rectangle [m]; negative inside; `None`: unbounded.
fn beyond_extent(contact: &Contact, a: &Interface, b: &Interface, b_from_a: &Pose) -> Option<f64> {
    if b.half.iter().all(|half| half.is_infinite()) {
        return None;
    }
    let whole_patch = contact.kind.is_patch() && !contact.overhang && a.is_bounded();
    let [hx, hy] = if whole_patch { a.half } else { [0.0; 2] };
    let corners = [[hx, hy], [-hx, hy], [hx, -hy], [-hx, -hy]];
    let points = corners.map(|[x, y]| b_from_a.act(Vector3::new(x, y, 0.0)));
    let beyond = points
        .iter()
        .flat_map(|p| [p.x.abs() - b.half[0], p.y.abs() - b.half[1]]);
    Some(beyond.fold(f64::NEG_INFINITY, f64::max))
}
