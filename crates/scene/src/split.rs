//! A mesh as one to three primitives: long or bent parts are cut across their longest axis where that saves much volume.
//!
//! Frames: `link`, that of the triangles. Triangles that reach over a cut count on both sides of it, up to the cut.

use crate::fit::{enclose, volume};
use crate::{PlacedShape, Shape};
use nalgebra::{Matrix3, Vector3};

/// The corners of a triangle [m].
pub(crate) type Triangle = [Vector3<f64>; 3];

/// Cuts may be at multiples of this part of the length.
const PLACES: usize = 6;

/// Half length from which on a part is worth cutting [m].
const LONG: f64 = 0.06;

/// A further piece must leave less than this share of the volume: each costs rows of clearance.
const WORTH_A_PIECE: f64 = 0.75;

/// One to three primitives that together contain the triangles, at least one; with the axes of the link's patch as for [`enclose`].
pub(crate) fn fit(triangles: &[Triangle], patch: Option<&Matrix3<f64>>) -> Vec<PlacedShape> {
    let mut points: Vec<Vector3<f64>> = triangles.iter().flatten().copied().collect();
    weld(&mut points);
    let whole = enclose(&points, patch);
    let (direction, half) = longest(&whole);
    if half < LONG {
        return vec![whole];
    }
    let middle = direction.dot(&whole.body_from_shape.origin());
    let cut = |i: usize| middle + half * (2.0 * i as f64 / PLACES as f64 - 1.0);
    let slab = |i: usize, j: usize| {
        let points = between(triangles, &direction, [cut(i), cut(j)]);
        (!points.is_empty()).then(|| enclose(&points, patch))
    };
    let slabs: Vec<Vec<Option<PlacedShape>>> = (0..PLACES)
        .map(|i| (i + 1..=PLACES).map(|j| slab(i, j)).collect())
        .collect();
    let piece = |i: usize, j: usize| slabs[i][j - i - 1].as_ref();
    let pieces = |cuts: &[usize]| -> Vec<PlacedShape> {
        let parts = cuts.windows(2).filter_map(|c| piece(c[0], c[1]));
        parts.cloned().collect()
    };
    let two = (1..PLACES).map(|i| pieces(&[0, i, PLACES]));
    let three = (1..PLACES)
        .flat_map(|i| (i + 1..PLACES).map(move |j| [0, i, j, PLACES]))
        .map(|cuts| pieces(&cuts));
    let mut best = vec![whole];
    for candidates in [two.collect::<Vec<_>>(), three.collect()] {
        let tightest = candidates
            .into_iter()
            .min_by(|a, b| total(a).total_cmp(&total(b)));
        let pays = |found: &Vec<PlacedShape>| total(found) < WORTH_A_PIECE * total(&best);
        if let Some(found) = tightest.filter(pays) {
            best = found;
        }
    }
    best
}

fn total(shapes: &[PlacedShape]) -> f64 {
    shapes.iter().map(|placed| volume(&placed.shape)).sum()
}

/// Unit direction of the longest axis of a shape in the link, and how far the shape reaches along it from its centre [m].
fn longest(placed: &PlacedShape) -> (Vector3<f64>, f64) {
    let (axis, half) = match &placed.shape {
        Shape::Box { half_size } => (half_size.imax(), half_size.max()),
        Shape::Capsule {
            radius,
            half_length,
        } => (2, radius + half_length),
        Shape::Sphere { radius } => (2, *radius),
        Shape::HalfSpace => (2, 0.0),
    };
    let direction = placed.body_from_shape.rotation().column(axis).into_owned();
    (direction, half)
}

/// Corners of what the triangles are between two planes across a direction.
fn between(
    triangles: &[Triangle],
    direction: &Vector3<f64>,
    [from, to]: [f64; 2],
) -> Vec<Vector3<f64>> {
    let mut points = Vec::new();
    for triangle in triangles {
        let along = triangle.map(|corner| direction.dot(&corner));
        for k in 0..3 {
            let (a, b) = (k, (k + 1) % 3);
            if (from..=to).contains(&along[a]) {
                points.push(triangle[a]);
            }
            for plane in [from, to] {
                if (along[a] - plane) * (along[b] - plane) < 0.0 {
                    let share = (plane - along[a]) / (along[b] - along[a]);
                    points.push(triangle[a].lerp(&triangle[b], share));
                }
            }
        }
    }
    weld(&mut points);
    points
}

/// Leaves one of equal points.
fn weld(points: &mut Vec<Vector3<f64>>) {
    points.sort_unstable_by(|a, b| {
        let by_axis = (0..3).map(|k| a[k].total_cmp(&b[k]));
        by_axis.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
    });
    points.dedup();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::contains;

    /// The twelve triangles of a box from one corner to the opposite one.
    fn block(from: [f64; 3], to: [f64; 3]) -> Vec<Triangle> {
        let corner = |code: usize| {
            let at = |k: usize| if code >> k & 1 == 0 { from[k] } else { to[k] };
            Vector3::new(at(0), at(1), at(2))
        };
        let sides = [
            [0, 1, 3, 2],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 3, 7, 6],
            [0, 2, 6, 4],
            [1, 3, 7, 5],
        ];
        sides
            .iter()
            .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
            .map(|side| side.map(|code| corner(*code)))
            .collect()
    }

    /// Is the triangle inside, judged by points on it.
    fn holds(shapes: &[PlacedShape], triangle: &Triangle) -> bool {
        let [a, b, c] = triangle;
        (0..=20).all(|i| {
            (0..=20 - i).all(|j| {
                let (s, t) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                let p = a + (b - a) * s + (c - a) * t;
                shapes.iter().any(|shape| contains(shape, &p))
            })
        })
    }

    #[test]
    fn a_boot_becomes_a_shaft_and_a_foot_and_all_of_it_is_inside() {
        let mut boot = block([-0.05, -0.05, 0.0], [0.05, 0.05, 0.5]);
        boot.extend(block([-0.05, -0.05, -0.1], [0.25, 0.05, 0.0]));
        let shapes = fit(&boot, None);
        assert_eq!(shapes.len(), 2, "{shapes:?}");
        assert!(boot.iter().all(|triangle| holds(&shapes, triangle)));
    }

    #[test]
    fn a_beam_stays_whole() {
        assert_eq!(fit(&block([0.0; 3], [0.5, 0.1, 0.1]), None).len(), 1);
    }
}
