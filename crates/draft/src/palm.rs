//! The palm of a hand: a rectangle on one of its sides.
//!
//! Frames: `joint`, that of the hand's body; `patch`, z out of the palm, x along the hand.

use crate::DraftError;
use crate::bodies::Bodies;
use crate::face::{axes_of, in_plane, near_face, reach};
use crate::heading::Heading;
use crate::hull::{bounds, convex_hull, largest_rectangle};
use crate::mirror::mirrored;
use crate::patch::Patch;
use crate::sole::{require_shape, signed_columns};
use multibody::Kinematics;
use nalgebra::{Vector2, Vector3};
use scene::Robot;
use spatial::Pose;

/// Where the hand begins is at least so far from its middle [m].
const WRIST: f64 = 0.03;
/// Cosine of the angle to the direction of the hand from which on a side is its tip or its root.
const TIP: f64 = 0.7;
/// What counts for a side beside where it faces: how large it is.
const FACE: f64 = 1.0;
/// Points belong to the face of a palm if within this of its plane; tried in this order [m].
const FLAT: [f64; 2] = [0.01, 0.02];
/// A hand is at most so long, as a multiple of the sole: what is further back of its link is forearm.
const LENGTH: f64 = 0.75;
/// A palm lies in this share of the hand, at its end: what is further back is near the wrist, whose links are to keep clear of what is held.
const OUTER: f64 = 0.5;
/// Share of the face that is taken, and how large a palm is at most and at least: half sizes [m].
const SHARE: f64 = 0.75;
const SIZES: (f64, f64) = (0.03, 0.008);
/// A hand without a flat side gets a palm of this share of its size.
const ROUND_SHARE: f64 = 0.25;
/// Cosine of the angle from inward at most for a side to stay the palm.
pub(crate) const INWARD: f64 = 0.7;
/// Joints up the arm that a palm is kept outside of, how near to it they count, and how far it goes out for their sake [m].
const UP: usize = 3;
const AROUND: f64 = 0.12;
const OUTWARDS: f64 = 0.015;

/// The outward normal of a side in the joint, and its area as a share of the largest.
type Side = (Vector3<f64>, f64);

/// A hand whose palm is sought.
#[derive(Debug, Clone)]
pub(crate) struct Hand {
    pub frame: usize,
    pub joint: usize,
    /// Points of the link, those of the forearm moved out to where the hand begins, with the radius of what is round about them [m].
    tips: Vec<(Vector3<f64>, f64)>,
    /// Middle of the hand, in the joint [m].
    pub middle: Vector3<f64>,
    /// Unit vector from the wrist to the middle, in the joint.
    pub along: Vector3<f64>,
    /// Outward normals of the sides that are no tip, in the joint, with the areas of these sides as shares of the largest.
    pub sides: Vec<Side>,
}

/// The hand that a link is, of a robot with soles of this length [m].
pub(crate) fn hand(bodies: &Bodies, frame: usize, sole: f64) -> Result<Hand, DraftError> {
    require_shape(bodies, "hand", frame)?;
    let link = &bodies.model().frames[frame];
    let joint = link.joint.unwrap_or(0);
    let mut tips = tips_of(bodies, joint, frame);
    let columns = signed_columns(link.joint_from_frame.rotation());
    let middle = middle_of(&tips, &columns);
    let joint_from_base = bodies.kinematics.world_from_joint[joint].inverse();
    let from_wrist = bodies
        .up(joint)
        .map(|j| middle - joint_from_base.act(bodies.origin(j)));
    let along = { from_wrist }.find(|v| v.norm() > WRIST);
    let along = along
        .unwrap_or(middle)
        .try_normalize(1e-9)
        .unwrap_or(Vector3::x());
    let begin = reach(&tips, &along) - LENGTH * sole;
    for (p, radius) in &mut tips {
        *p += along * (begin - p.dot(&along) + *radius).max(0.0);
    }
    let sizes = columns.map(|axis| reach(&tips, &axis) + reach(&tips, &-axis));
    let volume: f64 = sizes[0] * sizes[2] * sizes[4];
    let areas = sizes.map(|size| volume / size.max(1e-6));
    let sides = columns.into_iter().zip(areas);
    let sides: Vec<_> = sides.filter(|(n, _)| n.dot(&along).abs() < TIP).collect();
    let largest = sides.iter().map(|(_, area)| *area).fold(1e-9, f64::max);
    let sides = sides.into_iter().map(|(n, area)| (n, area / largest));
    Ok(Hand {
        frame,
        joint,
        middle: middle_of(&tips, &columns),
        tips,
        along,
        sides: sides.collect(),
    })
}

/// The middle of the box around points along these axes and their opposites.
fn middle_of(tips: &[(Vector3<f64>, f64)], axes: &[Vector3<f64>; 6]) -> Vector3<f64> {
    let along =
        [0, 2, 4].map(|k| axes[k] * ((reach(tips, &axes[k]) - reach(tips, &axes[k + 1])) / 2.0));
    along.iter().sum()
}

/// Points of one link of a body, in its joint; of the whole body if the link has no shape of its own.
fn tips_of(bodies: &Bodies, joint: usize, frame: usize) -> Vec<(Vector3<f64>, f64)> {
    let tips = bodies.tips[joint].iter();
    let own: Vec<_> = tips.filter(|tip| tip.frame == frame).collect();
    let all = bodies.tips[joint].iter().collect();
    let counted = if own.is_empty() { all } else { own };
    counted
        .iter()
        .map(|tip| (tip.in_joint, tip.radius))
        .collect()
}

/// The sides of two hands, left and right, that are their palms as the arms are at rest: large ones that face inward where an arm
/// hangs or reaches forward, and downward where it is stretched out sideways.
pub(crate) fn palms_at_rest(
    bodies: &Bodies,
    hands: &[Hand; 2],
    heading: &Heading,
) -> [Vector3<f64>; 2] {
    let rotate =
        |hand: &Hand, v: &Vector3<f64>| bodies.kinematics.world_from_joint[hand.joint].rotate(*v);
    let sideways = rotate(&hands[0], &hands[0].along).dot(&heading.left).abs() > TIP;
    let wish = if sideways {
        -Vector3::z()
    } else {
        -heading.left
    };
    matching(bodies, hands, heading, |side| {
        rotate(&hands[0], &side.0).dot(&wish) + FACE * side.1
    })
}

/// The sides of two hands that face inward as the arms are in a posture.
pub(crate) fn palms_inward(
    bodies: &Bodies,
    hands: &[Hand; 2],
    heading: &Heading,
    posture: &Kinematics,
) -> [Vector3<f64>; 2] {
    let base_from_hand = posture.world_from_joint[hands[0].joint];
    matching(bodies, hands, heading, |side| {
        -base_from_hand.rotate(side.0).dot(&heading.left)
    })
}

/// The side of the left hand with the greatest score, and that of the right one that is its mirror image at rest.
fn matching(
    bodies: &Bodies,
    hands: &[Hand; 2],
    heading: &Heading,
    score: impl Fn(&Side) -> f64,
) -> [Vector3<f64>; 2] {
    let [left, right] = hands;
    let best = |hand: &Hand, score: &dyn Fn(&Side) -> f64| {
        let sides = hand.sides.iter();
        let best = sides.max_by(|x, y| score(x).total_cmp(&score(y)));
        best.map_or(Vector3::y(), |(normal, _)| *normal)
    };
    let own = best(left, &score);
    let in_base = bodies.kinematics.world_from_joint[left.joint].rotate(own);
    let image = mirrored(&in_base, &heading.left);
    let base_from_right = &bodies.kinematics.world_from_joint[right.joint];
    let other = best(right, &|side| base_from_right.rotate(side.0).dot(&image));
    [own, other]
}

/// A palm, with what is to be told of it.
pub(crate) struct Palm {
    pub patch: Patch,
    /// What is unusual, as a sentence.
    pub note: Option<String>,
}

/// The palm on the side `normal` of a hand, outside of the shapes that a robot is planned with, which stands in `posture`.
pub(crate) fn palm(
    bodies: &Bodies,
    hand: &Hand,
    normal: &Vector3<f64>,
    robot: &Robot,
    posture: &Kinematics,
) -> Palm {
    let link = &bodies.model().frames[hand.frame];
    let columns = signed_columns(link.joint_from_frame.rotation());
    let across = columns.iter().filter(|axis| axis.dot(normal).abs() < TIP);
    let ahead = across.max_by(|a, b| a.dot(&hand.along).total_cmp(&b.dot(&hand.along)));
    let axes = axes_of(normal, ahead.unwrap_or(&hand.along));
    let tips = &hand.tips;
    let x = axes.column(0).into_owned();
    let (end, wrist) = (reach(tips, &x), -reach(tips, &-x));
    let begin = end - OUTER * (end - wrist);
    let places = [begin, f64::NEG_INFINITY].into_iter();
    let mut tries = places.flat_map(|from| FLAT.map(|depth| (from, depth)));
    let flat = tries.find_map(|(from, depth)| {
        let face = convex_hull(&in_plane(&near_face(tips, normal, depth), &axes));
        let found = largest_rectangle(&face, from);
        found.filter(|flat| flat.half_size().min() * SHARE >= SIZES.1)
    });
    let whole = in_plane(&tips.iter().map(|(p, _)| *p).collect::<Vec<_>>(), &axes);
    let (place, half, note) = if let Some(flat) = flat {
        (flat.centre(), flat.half_size() * SHARE, None)
    } else {
        let middle = axes.tr_mul(&hand.middle).xy();
        let size = bounds(&whole).map_or(Vector2::zeros(), |all| all.half_size());
        let note = format!(
            "the side of {:?} that faces inward has no flat part: its palm is a guess, in the middle of the hand",
            link.name
        );
        (middle, size * ROUND_SHARE, Some(note))
    };
    let half = half.map(|x| x.clamp(SIZES.1, SIZES.0));
    let at = |height: f64| Pose::from_parts(axes, axes * Vector3::new(place.x, place.y, height));
    let (height, forearm) = height(bodies, hand, &at(0.0), robot, posture);
    let patch = Patch {
        frame: hand.frame,
        frame_from_patch: link.joint_from_frame.inverse() * at(height),
        half_size: [half.x, half.y],
    };
    let note = note.or_else(|| {
        (forearm > height).then(|| {
            format!(
                "the arm behind {:?} is {:.0} mm thicker than where its palm is: the forearm will be in the way of flat things",
                link.name,
                1e3 * (forearm - height)
            )
        })
    });
    Palm {
        patch: patch.rounded(),
        note,
    }
}

/// How far out along its normal a patch is that nothing of the hand's own body is beyond [m], nor fingers and forearm if that takes little;
/// and where the arm behind it ends.
fn height(
    bodies: &Bodies,
    hand: &Hand,
    joint_from_patch: &Pose,
    robot: &Robot,
    posture: &Kinematics,
) -> (f64, f64) {
    let model = bodies.model();
    let patch_from_base = (posture.world_from_joint[hand.joint] * *joint_from_patch).inverse();
    let arm: Vec<usize> = bodies.up(hand.joint).skip(1).take(UP).collect();
    let [mut own, mut fingers, mut above] = [f64::NEG_INFINITY; 3];
    for (frame, link) in model.frames.iter().enumerate() {
        let Some(joint) = link.joint.filter(|&j| j != 0) else {
            continue;
        };
        let is_finger = joint != hand.joint && bodies.is_behind(joint, hand.joint);
        let patch_from_link = patch_from_base * posture.frame_pose(model, frame);
        for (tip, radius) in robot.tips(frame) {
            let p = patch_from_link.act(tip);
            let out = p.z + radius;
            if joint == hand.joint {
                own = own.max(out);
            } else if is_finger {
                fingers = fingers.max(out);
            } else if arm.contains(&joint) && p.xy().norm() < AROUND {
                above = above.max(out);
            }
        }
    }
    if own == f64::NEG_INFINITY {
        own = reach(
            &hand.tips,
            &joint_from_patch.rotation().column(2).into_owned(),
        );
    }
    (own.max(fingers.max(above).min(own + OUTWARDS)), above)
}
