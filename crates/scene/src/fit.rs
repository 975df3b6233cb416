//! The tightest box or capsule around the corners of a mesh.
//!
//! Frames: `link`, that of the points; `shape`, centred in what is fitted. Candidates are boxes and capsules along given axes, those
//! of a sole or a palm or else the link's, and along the principal axes of the points; the least volume wins, of those that end where
//! the points do along the normal of a sole or palm. It contains all points; no side is optimal.

use crate::{PlacedShape, Shape};
use nalgebra::{Matrix3, Vector2, Vector3};
use spatial::Pose;

/// Least half size of a box and radius of a capsule [m]: flat parts get some body, and few balls then cover them.
const THINNEST: f64 = 0.005;

/// Shapes are larger than what they hold by this much on every side, so that rounding in a text lets nothing out [m].
pub(crate) const ROUNDING: f64 = 2e-6;

/// The given axes are kept unless other axes need less than this share of the volume: soles stay level.
const WORTH_TURNING: f64 = 0.95;

/// Steps towards the centre of the smallest circle around points: its radius is then a few per cent too large at most.
const CIRCLE_STEPS: u32 = 30;

/// How far a shape may reach beyond the points along the normal of a patch [m]: it would be as deep in what the patch touches.
const BEYOND_PATCH: f64 = 1e-3;

/// The box or capsule of least volume that was found around points, at least one, in their frame; along the axes of the link's patch
/// (columns, the third its normal) if it has one, or the link's, or others.
pub(crate) fn enclose(points: &[Vector3<f64>], patch: Option<&Matrix3<f64>>) -> PlacedShape {
    let given = patch.copied().unwrap_or_else(Matrix3::identity);
    let normal = given.column(2).into_owned();
    let end = reach(&enclosing_box(points, &given), &normal) + BEYOND_PATCH;
    let fits = |placed: &PlacedShape| patch.is_none() || reach(placed, &normal) < end;
    let tightest = |axes: &Matrix3<f64>| {
        let both = candidates(points, axes).into_iter();
        both.filter(fits)
            .min_by(|a, b| volume(&a.shape).total_cmp(&volume(&b.shape)))
    };
    let as_given = tightest(&given).expect("the box along them ends there");
    let most = WORTH_TURNING * volume(&as_given.shape);
    let turned = tightest(&principal_axes(points)).filter(|x| volume(&x.shape) < most);
    turned.unwrap_or(as_given)
}

/// How far a shape reaches along a direction from the origin of its link [m].
fn reach(placed: &PlacedShape, direction: &Vector3<f64>) -> f64 {
    let pose = &placed.body_from_shape;
    let along = pose.rotation().tr_mul(direction);
    let from_centre = match &placed.shape {
        Shape::Box { half_size } => along.abs().dot(half_size),
        Shape::Sphere { radius } => *radius,
        Shape::Capsule {
            radius,
            half_length,
        } => radius + along.z.abs() * half_length,
        Shape::HalfSpace => f64::INFINITY,
    };
    direction.dot(&pose.origin()) + from_centre
}

/// The box along given axes, and the capsule along the longest side of that.
fn candidates(points: &[Vector3<f64>], link_from_axes: &Matrix3<f64>) -> [PlacedShape; 2] {
    let bounds = enclosing_box(points, link_from_axes);
    let long = match bounds.shape {
        Shape::Box { half_size } => half_size.imax(),
        _ => 2,
    };
    let axis = |k: usize| link_from_axes.column((long + k) % 3);
    let along_z = Matrix3::from_columns(&[axis(1), axis(2), axis(0)]);
    let round = enclosing_capsule(points, &along_z);
    [bounds, round]
}

/// Volume [m³]; infinite for a half-space.
pub(crate) fn volume(shape: &Shape) -> f64 {
    let ball = |radius: f64| 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    match shape {
        Shape::Box { half_size } => 8.0 * half_size.product(),
        Shape::Sphere { radius } => ball(*radius),
        Shape::Capsule {
            radius,
            half_length,
        } => ball(*radius) + 2.0 * std::f64::consts::PI * radius.powi(2) * half_length,
        Shape::HalfSpace => f64::INFINITY,
    }
}

/// Is a point of the body inside the shape, or on its surface.
pub(crate) fn contains(placed: &PlacedShape, in_body: &Vector3<f64>) -> bool {
    let p = placed.body_from_shape.inverse().act(*in_body);
    match &placed.shape {
        Shape::Box { half_size } => (0..3).all(|k| p[k].abs() <= half_size[k]),
        Shape::Sphere { radius } => p.norm() <= *radius,
        Shape::Capsule {
            radius,
            half_length,
        } => {
            let beyond = (p.z.abs() - half_length).max(0.0);
            p.xy().norm().hypot(beyond) <= *radius
        }
        Shape::HalfSpace => p.z <= 0.0,
    }
}

/// Right-handed axes along which the points vary most and least (columns, in their frame).
fn principal_axes(points: &[Vector3<f64>]) -> Matrix3<f64> {
    let mean = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let covariance: Matrix3<f64> = points
        .iter()
        .map(|p| (p - mean) * (p - mean).transpose())
        .sum();
    let mut axes = covariance.symmetric_eigen().eigenvectors;
    if axes.determinant() < 0.0 {
        axes.column_mut(2).neg_mut();
    }
    axes
}

/// The box around the points whose sides are along given axes.
fn enclosing_box(points: &[Vector3<f64>], link_from_axes: &Matrix3<f64>) -> PlacedShape {
    let (mut lower, mut upper) = (
        Vector3::repeat(f64::INFINITY),
        Vector3::repeat(f64::NEG_INFINITY),
    );
    for point in points {
        let p = link_from_axes.tr_mul(point);
        lower = lower.inf(&p);
        upper = upper.sup(&p);
    }
    let centre_in_link = link_from_axes * ((lower + upper) * 0.5);
    let half_size = ((upper - lower) * 0.5).map(|h| (h + ROUNDING).max(THINNEST));
    PlacedShape {
        body_from_shape: Pose::from_parts(*link_from_axes, centre_in_link),
        shape: Shape::Box { half_size },
    }
}

/// The capsule around the points along the third of given axes, about the smallest circle around their shadows.
fn enclosing_capsule(points: &[Vector3<f64>], link_from_axes: &Matrix3<f64>) -> PlacedShape {
    let seen: Vec<_> = points.iter().map(|p| link_from_axes.tr_mul(p)).collect();
    let centre = circle_centre(&seen);
    let aside = |p: &Vector3<f64>| (p.xy() - centre).norm();
    let widest = seen.iter().map(aside).fold(0.0, f64::max);
    let radius = (widest + ROUNDING).max(THINNEST);
    let (mut lower, mut upper) = (f64::INFINITY, f64::NEG_INFINITY);
    for p in &seen {
        // What the round end leaves free above the point; less what rounding of the length may take.
        let cap = (radius.powi(2) - aside(p).powi(2)).max(0.0).sqrt() - ROUNDING;
        lower = lower.min(p.z + cap);
        upper = upper.max(p.z - cap);
    }
    let middle = 0.5 * (lower + upper);
    let centre_in_link = link_from_axes * Vector3::new(centre.x, centre.y, middle);
    PlacedShape {
        body_from_shape: Pose::from_parts(*link_from_axes, centre_in_link),
        shape: Shape::Capsule {
            radius,
            half_length: (0.5 * (upper - lower)).max(ROUNDING),
        },
    }
}

/// About the centre of the smallest circle around the x and y of points: the best of the middle of their bounds and the steps from
/// there.
///
/// Source: Bădoiu and Clarkson, Smaller core-sets for balls (2003): step i goes 1/(i + 1) of the way to the farthest point.
fn circle_centre(points: &[Vector3<f64>]) -> Vector2<f64> {
    let (mut lower, mut upper) = (points[0].xy(), points[0].xy());
    for p in points {
        lower = lower.inf(&p.xy());
        upper = upper.sup(&p.xy());
    }
    let mut centre = (lower + upper) * 0.5;
    let mut best = (f64::INFINITY, centre);
    for i in 1..=CIRCLE_STEPS {
        let to_point = points.iter().map(|p| p.xy() - centre);
        let farthest = to_point.max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
        let step = farthest.unwrap_or_default();
        if step.norm() < best.0 {
            best = (step.norm(), centre);
        }
        centre += step / f64::from(i + 1);
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use spatial::exp_so3;

    /// Corners of a box of given half sizes, placed.
    fn corners(pose: &Pose, half: [f64; 3]) -> Vec<Vector3<f64>> {
        let sign = |code: usize, k: usize| {
            if code >> k & 1 == 0 {
                -half[k]
            } else {
                half[k]
            }
        };
        (0..8)
            .map(|c| pose.act(Vector3::new(sign(c, 0), sign(c, 1), sign(c, 2))))
            .collect()
    }

    fn turned() -> Pose {
        let rotation = exp_so3(&Vector3::new(0.3, -0.5, 0.8));
        Pose::from_parts(rotation, Vector3::new(0.1, 0.2, -0.3))
    }

    /// Points on a capsule of 4 cm radius and 10 cm half length along z.
    fn capsule_cloud() -> Vec<Vector3<f64>> {
        let mut points = Vec::new();
        for i in 0..24 {
            let (s, c) = (f64::from(i) * std::f64::consts::TAU / 24.0).sin_cos();
            for j in 0..=6 {
                let (sin, cos) = (f64::from(j) * std::f64::consts::FRAC_PI_2 / 6.0).sin_cos();
                for end in [-1.0, 1.0] {
                    let z = end * (0.1 + 0.04 * sin);
                    points.push(Vector3::new(0.04 * cos * c, 0.04 * cos * s, z));
                }
            }
        }
        points
    }

    #[test]
    fn the_corners_of_a_turned_box_give_that_box() {
        let half = [0.2, 0.05, 0.1];
        let fitted = enclose(&corners(&turned(), half), None);
        let Shape::Box { half_size } = &fitted.shape else {
            panic!("{fitted:?}");
        };
        let mut sorted: Vec<f64> = half_size.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        for (found, wanted) in sorted.iter().zip([0.05, 0.1, 0.2]) {
            assert!((found - wanted).abs() < 1e-5, "{half_size}");
        }
        assert!((fitted.body_from_shape.origin() - turned().origin()).norm() < 1e-9);
    }

    #[test]
    fn a_box_along_the_axes_of_the_link_stays_there() {
        let place = Pose::from_parts(Matrix3::identity(), Vector3::new(0.0, 0.1, 0.2));
        let fitted = enclose(&corners(&place, [0.1, 0.06, 0.08]), None);
        assert_eq!(*fitted.body_from_shape.rotation(), Matrix3::identity());
    }

    #[test]
    fn a_boot_on_a_tilted_sole_gets_a_box_that_ends_at_the_sole() {
        // Wedges on a sole, of which the principal axes are others than the sole's.
        let sole = exp_so3(&Vector3::new(0.0, 0.25, 0.0));
        let boot = [
            (0.1, 0.0),
            (-0.1, 0.0),
            (0.08, 0.03),
            (0.0, 0.12),
            (-0.1, 0.12),
        ];
        let points: Vec<_> = (boot.iter())
            .flat_map(|&(x, z)| [-0.04, 0.04].map(|y| sole * Vector3::new(x, y, z)))
            .collect();
        let lowest = |patch: Option<&Matrix3<f64>>| {
            let fitted = enclose(&points, patch);
            let Shape::Box { half_size } = fitted.shape else {
                panic!("{fitted:?}");
            };
            let down = |p: &Vector3<f64>| -(sole.transpose() * fitted.body_from_shape.act(*p)).z;
            let corners = corners(&Pose::identity(), half_size.into());
            corners.iter().map(down).fold(f64::NEG_INFINITY, f64::max)
        };
        assert!(lowest(Some(&sole)) < 1e-5, "{}", lowest(Some(&sole)));
        assert!(lowest(None) > 0.01);
    }

    #[test]
    fn nothing_around_a_sloping_toe_reaches_below_its_sole() {
        // flat below, sloping above: a box along the slope is smaller and goes through the sole
        let sole = Matrix3::from_columns(&[Vector3::x(), -Vector3::y(), -Vector3::z()]);
        let toe = [
            (0.06, 0.0),
            (0.0, 0.0),
            (-0.06, 0.04),
            (-0.06, 0.06),
            (0.06, 0.01),
            (0.0, 0.035),
        ];
        let points: Vec<_> = (toe.iter())
            .flat_map(|&(x, z)| [-0.04, 0.04].map(|y| Vector3::new(x, y, z)))
            .collect();
        let depth = |patch| reach(&enclose(&points, patch), &-Vector3::z());
        assert!(depth(Some(&sole)) < BEYOND_PATCH, "{}", depth(Some(&sole)));
        let loose = enclose(&points, None);
        let held = enclose(&points, Some(&sole));
        assert!(volume(&loose.shape) < volume(&held.shape) && depth(None) > 0.005);
    }

    #[test]
    fn points_of_a_turned_capsule_give_that_capsule() {
        let points: Vec<_> = capsule_cloud()
            .into_iter()
            .map(|p| turned().act(p))
            .collect();
        let Shape::Capsule {
            radius,
            half_length,
        } = enclose(&points, None).shape
        else {
            panic!("no capsule");
        };
        assert!((radius - 0.04).abs() < 1e-3, "{radius}");
        assert!((half_length - 0.1).abs() < 3e-3, "{half_length}");
    }

    #[test]
    fn every_point_is_inside_what_is_fitted_around_it() {
        for seed in 0..200_u32 {
            let number = |i: u32| f64::from((seed * 7919 + i * 104_729 + 13) * 31 % 1000) / 1e3;
            let size = Vector3::new(number(0), number(1), number(2)) * 0.4;
            let points: Vec<_> = (1..12)
                .map(|i| Vector3::new(number(3 * i), number(3 * i + 1), number(3 * i + 2)))
                .map(|p| p.component_mul(&size))
                .collect();
            let sole = *turned().rotation();
            for patch in [None, Some(&sole)] {
                let fitted = enclose(&points, patch);
                assert!(points.iter().all(|p| contains(&fitted, p)), "seed {seed}");
            }
        }
    }

    #[test]
    fn a_plane_a_line_and_a_point_get_some_body() {
        let plane: Vec<_> = [(0.0, 0.0), (0.1, 0.0), (0.0, 0.1), (0.1, 0.1)]
            .map(|(x, y)| Vector3::new(x, y, 0.0))
            .into();
        for points in [&plane[..], &plane[..2], &plane[..1]] {
            let fitted = enclose(points, None);
            assert!(volume(&fitted.shape) > 0.0 && volume(&fitted.shape).is_finite());
            assert!(points.iter().all(|p| contains(&fitted, p)));
        }
    }
}
