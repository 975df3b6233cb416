//! The convex hull of points of a plane, and the largest rectangle along the axes inside it.
//!
//! Source: A. M. Andrew, Another efficient algorithm for convex hulls in two dimensions (1979): the monotone chain.

use nalgebra::Vector2;

/// Places across the hull at which a rectangle may begin and end.
const PLACES: usize = 81;
/// Share of the width that is left out at either end.
const INSET: f64 = 1e-6;

/// Smallest and largest coordinates of an axis-parallel rectangle [m].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rectangle {
    pub lower: Vector2<f64>,
    pub upper: Vector2<f64>,
}

impl Rectangle {
    pub fn centre(&self) -> Vector2<f64> {
        (self.lower + self.upper) / 2.0
    }

    pub fn half_size(&self) -> Vector2<f64> {
        (self.upper - self.lower) / 2.0
    }
}

/// The smallest rectangle around points; `None` without any.
pub(crate) fn bounds(points: &[Vector2<f64>]) -> Option<Rectangle> {
    let (first, rest) = points.split_first()?;
    let mut out = Rectangle {
        lower: *first,
        upper: *first,
    };
    for p in rest {
        (out.lower, out.upper) = (out.lower.inf(p), out.upper.sup(p));
    }
    Some(out)
}

/// Corners of the convex hull, counter-clockwise; fewer than three if the points lie on a line.
pub(crate) fn convex_hull(points: &[Vector2<f64>]) -> Vec<Vector2<f64>> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let half = |points: &mut dyn Iterator<Item = &Vector2<f64>>| {
        let mut chain: Vec<Vector2<f64>> = Vec::new();
        for p in points {
            while let [.., a, b] = chain.as_slice()
                && (b - a).perp(&(p - a)) <= 0.0
            {
                chain.pop();
            }
            chain.push(*p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut sorted.iter());
    hull.extend(half(&mut sorted.iter().rev()));
    hull
}

/// Area of a polygon with corners in counter-clockwise order [m²].
pub(crate) fn area(polygon: &[Vector2<f64>]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    polygon
        .iter()
        .zip(next)
        .map(|(a, b)| a.perp(b))
        .sum::<f64>()
        / 2.0
}

/// The largest rectangle along the axes inside a convex polygon, with x from `from` on; `None` if there is none.
pub(crate) fn largest_rectangle(polygon: &[Vector2<f64>], from: f64) -> Option<Rectangle> {
    let around = bounds(polygon)?;
    // A little inside: an upright edge may be slanted by rounding, and then only a corner of it is at the very end.
    let inset = INSET * (around.upper.x - around.lower.x);
    let left = (around.lower.x + inset).max(from);
    let width = around.upper.x - inset - left;
    if width <= 0.0 {
        return None;
    }
    let at = |i: usize| left + width * i as f64 / (PLACES - 1) as f64;
    let reach: Vec<Option<[f64; 2]>> = (0..PLACES).map(|i| between(polygon, at(i))).collect();
    let mut best: Option<(f64, Rectangle)> = None;
    for i in 0..PLACES {
        for j in i + 1..PLACES {
            let (Some(a), Some(b)) = (reach[i], reach[j]) else {
                continue;
            };
            // Between two places a convex polygon reaches at least as far as on the line from one to the other.
            let (bottom, top) = (a[0].max(b[0]), a[1].min(b[1]));
            let area = (at(j) - at(i)) * (top - bottom);
            if top > bottom && best.as_ref().is_none_or(|(most, _)| area > *most) {
                let rectangle = Rectangle {
                    lower: Vector2::new(at(i), bottom),
                    upper: Vector2::new(at(j), top),
                };
                best = Some((area, rectangle));
            }
        }
    }
    best.map(|(_, rectangle)| rectangle)
}

/// Smallest and largest y of a convex polygon at x.
fn between(polygon: &[Vector2<f64>], x: f64) -> Option<[f64; 2]> {
    let next = polygon.iter().cycle().skip(1);
    let crossings = polygon.iter().zip(next).flat_map(|(a, b)| {
        let (low, high) = (a.x.min(b.x), a.x.max(b.x));
        if x < low || x > high {
            vec![]
        } else if high == low {
            vec![a.y, b.y]
        } else {
            vec![a.y + (b.y - a.y) * (x - a.x) / (b.x - a.x)]
        }
    });
    crossings.fold(None, |reach, y| {
        let [least, most] = reach.unwrap_or([y, y]);
        Some([y.min(least), y.max(most)])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(of: &[[f64; 2]]) -> Vec<Vector2<f64>> {
        of.iter().map(|p| Vector2::from(*p)).collect()
    }

    #[test]
    fn the_hull_of_a_square_and_points_in_it_is_the_square() {
        let some = points(&[
            [0.0, 0.0],
            [1.0, 0.0],
            [0.5, 0.5],
            [1.0, 1.0],
            [0.5, 0.0],
            [0.0, 1.0],
        ]);
        let hull = convex_hull(&some);
        assert_eq!(
            hull,
            points(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        );
        assert!((area(&hull) - 1.0).abs() < 1e-15);
        assert_eq!(
            convex_hull(&points(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]])).len(),
            2
        );
    }

    #[test]
    fn the_largest_rectangle_in_a_rectangle_is_itself_and_in_a_rhombus_half_of_it() {
        let square = convex_hull(&points(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]));
        let found = largest_rectangle(&square, f64::NEG_INFINITY).unwrap();
        assert!((found.centre() - Vector2::new(1.0, 0.5)).norm() < 1e-9);
        assert!((found.half_size() - Vector2::new(1.0, 0.5)).norm() < 1e-5);
        let right = largest_rectangle(&square, 1.5).unwrap();
        assert!((right.centre() - Vector2::new(1.75, 0.5)).norm() < 1e-5);
        assert_eq!(largest_rectangle(&square, 2.5), None);
        let rhombus = convex_hull(&points(&[[-2.0, 0.0], [0.0, -1.0], [2.0, 0.0], [0.0, 1.0]]));
        let found = largest_rectangle(&rhombus, f64::NEG_INFINITY).unwrap();
        assert!((found.half_size() - Vector2::new(1.0, 0.5)).norm() < 1e-5);
        assert_eq!(
            largest_rectangle(&points(&[[0.0, 0.0], [1.0, 0.0]]), 0.0),
            None
        );
    }
}
