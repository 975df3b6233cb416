//! What lies close under a surface: the floor under a mat.

use nalgebra::Vector3;
use scene::{Interface, PlacedShape, Shape, StaticBody};

/// Depth under a surface down to which something is close to what touches that [m]: more than any margin that would keep them apart.
const CLOSE: f64 = 0.06;
/// Rounding [m].
const SMALL: f64 = 1e-4;

/// True if no part of a static body comes above a patch that is fixed in the world, and some is close under it.
pub(super) fn is_close_under(patch: &Interface, body: &StaticBody) -> bool {
    let depths: Vec<f64> = (body.shapes.iter())
        .map(|placed| match placed.shape {
            Shape::HalfSpace => height_over(patch, placed),
            _ => depth_under(patch, placed),
        })
        .collect();
    let least = depths.iter().copied().fold(f64::INFINITY, f64::min);
    let is_under =
        |placed: &PlacedShape| placed.shape == Shape::HalfSpace || overlaps(patch, placed);
    let close = |(placed, &depth)| depth < CLOSE && is_under(placed);
    least >= -SMALL && body.shapes.iter().zip(&depths).any(close)
}

/// How far a bounded shape lies under the plane of a patch, where it is nearest to it [m]; negative if it comes above.
fn depth_under(patch: &Interface, placed: &PlacedShape) -> f64 {
    let normal = patch.body_from_interface.rotate(Vector3::z());
    let down = patch.body_from_interface.origin() - placed.body_from_shape.origin();
    normal.dot(&down) - reach(placed, &normal)
}

/// True if a bounded shape and a patch overlap in the axes of the patch.
fn overlaps(patch: &Interface, placed: &PlacedShape) -> bool {
    let pose = &patch.body_from_interface;
    let away = placed.body_from_shape.origin() - pose.origin();
    let half = patch.half_size.unwrap_or([f64::INFINITY; 2]);
    [Vector3::x(), Vector3::y()]
        .into_iter()
        .zip(half)
        .all(|(axis, half)| {
            let axis = pose.rotate(axis);
            axis.dot(&away).abs() < half + reach(placed, &axis)
        })
}

/// How far a bounded shape reaches from its centre along a direction [m].
fn reach(placed: &PlacedShape, direction: &Vector3<f64>) -> f64 {
    let own = placed.body_from_shape.inverse().rotate(*direction);
    match &placed.shape {
        Shape::Box { half_size } => own.abs().dot(half_size),
        Shape::Capsule {
            radius,
            half_length,
        } => radius + half_length * own.z.abs(),
        Shape::Sphere { radius } => *radius,
        Shape::HalfSpace => f64::INFINITY,
    }
}

/// Height of a patch over a plane, at its lowest corner [m]; negative if it faces down.
fn height_over(patch: &Interface, plane: &PlacedShape) -> f64 {
    let up = plane.body_from_shape.rotate(Vector3::z());
    let pose = &patch.body_from_interface;
    let [x, y] = patch.half_size.unwrap_or([f64::INFINITY; 2]);
    let falls = |axis: Vector3<f64>, half: f64| match up.dot(&pose.rotate(axis)).abs() {
        slope if slope < SMALL => 0.0,
        slope => slope * half,
    };
    if up.dot(&pose.rotate(Vector3::z())) <= 0.0 {
        return f64::NEG_INFINITY;
    }
    let middle = up.dot(&(pose.origin() - plane.body_from_shape.origin()));
    middle - falls(Vector3::x(), x) - falls(Vector3::y(), y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::samples::scene;

    #[test]
    fn the_floor_is_close_under_a_mat_and_a_ramp_and_not_under_a_block_nor_beside_one() {
        let scene = scene(
            r#"
            [[static]]
            name = "mat"
            size = [1.0, 1.0, 0.02]
            position = [2.0, 0.0, 0.01]
            [[static]]
            name = "block"
            size = [1.0, 1.0, 0.2]
            position = [4.0, 0.0, 0.1]
            [[static]]
            name = "step"
            size = [1.0, 1.0, 0.25]
            position = [5.0, 0.0, 0.125]
            [[static]]
            name = "ramp"
            size = [1.0, 1.0, 0.05]
            position = [8.0, 0.0, 0.1]
            quaternion = [0.0, 0.09983341664682815, 0.0, 0.9950041652780258]
            [[static]]
            name = "tile"
            size = [1.0, 1.0, 0.02]
            position = [2.0, 1.0, 0.01]
            [[static]]
            name = "board"
            size = [0.2, 0.2, 0.03]
            position = [5.0, 0.0, 0.265]
            "#,
        );
        let close_under = |top: &str| -> Vec<&str> {
            let patch = &scene.interfaces[scene.interface_id(top).expect("a top").0];
            let others = scene
                .statics
                .iter()
                .filter(|body| !top.starts_with(&*body.name));
            let close = others.filter(|body| is_close_under(patch, body));
            close.map(|body| body.name.as_str()).collect()
        };
        assert_eq!(close_under("mat_top"), ["ground"]);
        assert_eq!(close_under("block_top"), [""; 0]);
        assert_eq!(
            close_under("step_top"),
            [""; 0],
            "the block and the ramp are beside it"
        );
        assert_eq!(close_under("board_top"), ["step"]);
        assert_eq!(close_under("ramp_top"), ["ground"]);
        assert_eq!(close_under("ground_top"), [""; 0]);
    }
}
