//! Whether the interfaces describe what is there: on the surface of their bodies, with a plausible torsional friction.

use plan::{Geometry, InterfaceKind};
use spatial::Pose;

use crate::categories::Category;
use crate::distance::{point_to_cuboid, point_to_solid};
use crate::measure::Measurements;
use crate::motion::{Interface, Motion, Owner};
use crate::report::Location;

/// Judges the interfaces and the torsional friction of the contacts.
pub(crate) fn judge(motion: &Motion, found: &mut Measurements) {
    torsional_friction(motion, found);
    for interface in &motion.interfaces {
        let place = || Location::of(interface.name);
        match interface.owner {
            Owner::Link(link) => {
                if let Some(distance) = distance_to_link(motion, interface, link) {
                    found.add(Category::InterfaceRobot, 1e3 * distance, place);
                }
            }
            Owner::Object(i) => {
                if let Some(distance) =
                    distance_to_surface(interface, &motion.plan.objects[i].geometry)
                {
                    found.add(Category::InterfaceSurface, distance, place);
                }
            }
            Owner::Static(i) => {
                if let Some(distance) =
                    distance_to_surface(interface, &motion.plan.environment[i].geometry)
                {
                    found.add(Category::InterfaceSurface, distance, place);
                }
            }
        }
    }
}

/// Uniform pressure on a patch with sliding friction μ resists torsion with μ fn times the mean radius of the patch.
fn torsional_friction(motion: &Motion, found: &mut Measurements) {
    for (phase, contact) in motion.contacts() {
        let a = &motion.interfaces[contact.a];
        if contact.kind.is_unilateral() && contact.kind.is_patch() && a.is_bounded() {
            let excess = (contact.mu_r - contact.mu * mean_radius(a.half)).max(0.0);
            found.add(Category::MuR, excess, || {
                motion.place(phase.start, &contact.name)
            });
        }
    }
}

/// Mean distance from the centre over a rectangle of half sizes [m], by the midpoint rule.
fn mean_radius([half_x, half_y]: [f64; 2]) -> f64 {
    const CELLS: usize = 20;
    let at = |i: usize, half: f64| (i as f64 + 0.5) / CELLS as f64 * half;
    let radii = (0..CELLS * CELLS).map(|n| at(n / CELLS, half_x).hypot(at(n % CELLS, half_y)));
    radii.sum::<f64>() / (CELLS * CELLS) as f64
}

/// Distance of the origin of a patch to the nearest surface of its body [m]; `None` for points and unread shapes.
fn distance_to_surface(interface: &Interface, geometry: &[Geometry]) -> Option<f64> {
    if interface.kind != InterfaceKind::Patch {
        return None;
    }
    let to_shape = |shape: &Geometry| {
        let point = Pose::from_xyzquat(&shape.pose)
            .inverse()
            .act(interface.body_from_interface.origin());
        match shape.half_size {
            _ if shape.is_plane() => Some(point.z.abs()),
            Some(half) => Some(point_to_cuboid(&point, &half.into()).abs()),
            None => None,
        }
    };
    geometry.iter().filter_map(to_shape).reduce(f64::min)
}

/// Distance of the origin of an interface to the nearest shape that moves with its link [m]; `None` if there is none.
fn distance_to_link(motion: &Motion, interface: &Interface, link: usize) -> Option<f64> {
    let robot = &motion.robot;
    let at_start = |link: usize| motion.links[0][link].world_from_frame;
    let origin_in_world = at_start(link).act(interface.body_from_interface.origin());
    let rigid = robot
        .shapes
        .iter()
        .filter(|shape| robot.links[shape.link].group == robot.links[link].group);
    let distances = rigid.map(|shape| {
        let world_from_shape = at_start(shape.link) * shape.link_from_shape;
        point_to_solid(
            &world_from_shape.inverse().act(origin_in_world),
            &shape.solid,
        )
        .abs()
    });
    distances.reduce(f64::min)
}

#[cfg(test)]
mod tests {
    use super::mean_radius;

    #[test]
    fn the_mean_radius_of_a_square_is_known() {
        // (√2 + ln(1 + √2)) / 3 for the square of half size 1
        let exact = (2.0f64.sqrt() + (1.0 + 2.0f64.sqrt()).ln()) / 3.0;
        assert!((mean_radius([1.0, 1.0]) - exact).abs() < 1e-3);
    }
}
