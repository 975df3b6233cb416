//! The sole of a foot: a rectangle in its lowest face.
//!
//! Frames: `joint`, that of the foot's body; `patch`, z down out of the foot, x forward.

use crate::DraftError;
use crate::bodies::Bodies;
use crate::face::{axes_of, in_plane, near_face, reach};
use crate::heading::Heading;
use crate::hull::{area, bounds, convex_hull, largest_rectangle};
use crate::patch::Patch;
use nalgebra::{Matrix3, Vector3};
use spatial::Pose;

/// Points belong to the lowest face if within this of its plane [m].
const FLAT: f64 = 0.003;
/// Points that tell how a face lies that is level with no axis of its link [m].
const ROUGHLY_FLAT: f64 = 0.01;
/// Share of the rectangle that is taken: edges are rounded.
const SHARE: f64 = 0.93;
/// Cosine of the angle between down and the normal of a sole at most.
const NEARLY_DOWN: f64 = 0.94;
/// Cosine of the angle up to which an axis of the link stands for forward.
const NEARLY_FORWARD: f64 = 0.966;
/// Other directions than a link's axes must give a face larger by this factor.
const WORTH_TURNING: f64 = 1.05;
/// Half width that a sole has at least [m].
const LEAST: f64 = 0.008;
/// A sole that is less than this share of its foot as seen from below is told.
const SMALL: f64 = 0.4;

/// A sole with what is to be told of it.
pub(crate) struct Sole {
    pub patch: Patch,
    /// What is unusual, as a sentence.
    pub note: Option<String>,
}

/// The sole of the foot that a link belongs to.
pub(crate) fn sole(bodies: &Bodies, frame: usize, heading: &Heading) -> Result<Sole, DraftError> {
    let model = bodies.model();
    let link = &model.frames[frame];
    let joint = link.joint.unwrap_or(0);
    let tips: Vec<(Vector3<f64>, f64)> = (bodies.tips[joint].iter())
        .map(|tip| (tip.in_joint, tip.radius))
        .collect();
    let normal = lowest_normal(bodies, joint, &tips);
    let base_from_joint = &bodies.kinematics.world_from_joint[joint];
    let forward = base_from_joint.rotate_inverse(heading.forward);
    let snapped = axes_of_body(bodies, joint)
        .into_iter()
        .find(|axis| axis.dot(&forward) > NEARLY_FORWARD);
    let axes = axes_of(&normal, &snapped.unwrap_or(forward));
    let hull = convex_hull(&in_plane(&near_face(&tips, &normal, FLAT), &axes));
    let size = bounds(&hull).map_or_else(Default::default, |around| around.half_size() * 2.0);
    let small = || DraftError::SmallSole {
        link: link.name.clone(),
        length: 1e3 * size.x,
        width: 1e3 * size.y,
    };
    let rectangle = largest_rectangle(&hull, f64::NEG_INFINITY).ok_or_else(small)?;
    let half = rectangle.half_size() * SHARE;
    if half.min() < LEAST {
        return Err(small());
    }
    let (centre, height) = (rectangle.centre(), reach(&tips, &normal));
    let origin = axes * Vector3::new(centre.x, centre.y, height);
    let joint_from_patch = Pose::from_parts(axes, origin);
    let points: Vec<Vector3<f64>> = tips.iter().map(|(p, _)| *p).collect();
    let seen = area(&convex_hull(&in_plane(&points, &axes)));
    let share = 4.0 * half.x * half.y / seen;
    let note = (share < SMALL).then(|| {
        format!(
            "the lowest face of {:?} is flat in {:.0} % of what is seen from below: check that its sole is where the robot stands",
            link.name,
            1e2 * share
        )
    });
    let patch = Patch {
        frame,
        frame_from_patch: link.joint_from_frame.inverse() * joint_from_patch,
        half_size: [half.x, half.y],
    };
    Ok(Sole {
        patch: patch.rounded(),
        note,
    })
}

/// # Errors
/// [`DraftError::NoShape`] if the body of a link has no shape.
pub(crate) fn require_shape(
    bodies: &Bodies,
    what: &'static str,
    frame: usize,
) -> Result<(), DraftError> {
    let link = &bodies.model().frames[frame];
    if link
        .joint
        .is_some_and(|joint| !bodies.tips[joint].is_empty())
    {
        return Ok(());
    }
    let unread = match bodies.bare.unread.len() {
        0 => String::new(),
        n => format!(
            "; the meshes of {n} links were not found, name the folder of the robot\'s package as --meshes DIR"
        ),
    };
    Err(DraftError::NoShape {
        what,
        link: link.name.clone(),
        unread,
    })
}

/// The outward normal of the lowest face of a body, in its joint: an axis of one of its links, down, or that of the plane through the
/// lowest points.
fn lowest_normal(bodies: &Bodies, joint: usize, tips: &[(Vector3<f64>, f64)]) -> Vector3<f64> {
    let down = bodies.kinematics.world_from_joint[joint].rotate_inverse(-Vector3::z());
    let size = |normal: &Vector3<f64>| {
        let face = near_face(tips, normal, FLAT);
        area(&convex_hull(&in_plane(
            &face,
            &axes_of(normal, &Vector3::x()),
        )))
    };
    let of_links = axes_of_body(bodies, joint).into_iter();
    let of_links = of_links.filter(|axis| axis.dot(&down) > NEARLY_DOWN);
    let fitted = plane_normal(&near_face(tips, &down, ROUGHLY_FLAT), &down);
    let others = [Some(down), fitted.filter(|n| n.dot(&down) > NEARLY_DOWN)];
    let mut best: Option<(f64, Vector3<f64>)> = None;
    let candidates = of_links.map(|n| (1.0, n));
    for (worth, normal) in
        candidates.chain(others.into_iter().flatten().map(|n| (WORTH_TURNING, n)))
    {
        let size = size(&normal) / worth;
        if best.as_ref().is_none_or(|(most, _)| size > *most) {
            best = Some((size, normal));
        }
    }
    best.map_or(down, |(_, normal)| normal)
}

/// The axes of the links of a body and their opposites, in its joint.
pub(crate) fn axes_of_body(bodies: &Bodies, joint: usize) -> Vec<Vector3<f64>> {
    let frames = bodies.model().frames.iter();
    let rotations = frames
        .filter(|frame| frame.joint == Some(joint))
        .map(|frame| *frame.joint_from_frame.rotation());
    rotations
        .flat_map(|rotation| signed_columns(&rotation))
        .collect()
}

/// Columns of a matrix and their opposites.
pub(crate) fn signed_columns(matrix: &Matrix3<f64>) -> [Vector3<f64>; 6] {
    let column = |k: usize| matrix.column(k).into_owned();
    [
        column(0),
        -column(0),
        column(1),
        -column(1),
        column(2),
        -column(2),
    ]
}

/// Normal of the plane nearest to points, on the side of `side`; `None` for fewer than three.
fn plane_normal(points: &[Vector3<f64>], side: &Vector3<f64>) -> Option<Vector3<f64>> {
    if points.len() < 3 {
        return None;
    }
    let mean = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let covariance: Matrix3<f64> = (points.iter())
        .map(|p| (p - mean) * (p - mean).transpose())
        .sum();
    let eigen = covariance.symmetric_eigen();
    let normal = eigen
        .eigenvectors
        .column(eigen.eigenvalues.imin())
        .into_owned();
    Some(normal * normal.dot(side).signum())
}
