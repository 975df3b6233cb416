//! Which way the robot looks.
//!
//! Frames: `base`, upright. Forward is an axis of it, left is up × forward.

use crate::DraftError;
use crate::bodies::Bodies;
use crate::limbs::Ends;
use multibody::JointKind;
use nalgebra::Vector3;

/// Height above the lowest point of a foot up to which it counts as sole here [m].
const SOLE: f64 = 0.01;
/// Soles tell front from back if one side is longer than the other by this share of their length.
const LONGER: f64 = 0.08;
/// Knees tell it if they bend this many times as far one way as the other.
const FARTHER: f64 = 2.0;
/// Cosine of the angle to the left up to which a joint counts as one of pitch: axes of hips may be inclined by 45°.
const PITCH: f64 = 0.65;

/// An axis of the base that points forward.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Forward {
    /// +x
    X,
    /// −x
    MinusX,
    /// +y
    Y,
    /// −y
    MinusY,
}

impl Forward {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::X, Self::MinusX, Self::Y, Self::MinusY];

    /// As it is written: "x", "-x", "y", "-y".
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::MinusX => "-x",
            Self::Y => "y",
            Self::MinusY => "-y",
        }
    }

    /// The unit vector in the base.
    pub fn direction(self) -> Vector3<f64> {
        match self {
            Self::X => Vector3::x(),
            Self::MinusX => -Vector3::x(),
            Self::Y => Vector3::y(),
            Self::MinusY => -Vector3::y(),
        }
    }

    /// The turn about z with which the robot looks along the world's x [rad].
    pub fn yaw_to_x(self) -> f64 {
        let direction = self.direction();
        -direction.y.atan2(direction.x) + 0.0
    }
}

/// Where front and left are.
#[derive(Debug, Clone)]
pub(crate) struct Heading {
    pub axis: Forward,
    /// Unit vectors in the base.
    pub forward: Vector3<f64>,
    pub left: Vector3<f64>,
    /// What told it, as a clause.
    pub how: String,
    /// What speaks against it, as a sentence.
    pub doubt: Option<String>,
}

impl Heading {
    fn new(axis: Forward, how: String) -> Self {
        let forward = axis.direction();
        Self {
            axis,
            forward,
            left: Vector3::z().cross(&forward),
            how,
            doubt: None,
        }
    }
}

/// The direction that is given, or that soles and knees tell.
pub(crate) fn heading(
    bodies: &Bodies,
    feet: &Ends,
    given: Option<Forward>,
) -> Result<Heading, DraftError> {
    let [a, b] = feet.pair.ends().map(|j| bodies.origin(j));
    let across = (a - b).abs();
    let along = if across.y >= across.x {
        [Forward::X, Forward::MinusX]
    } else {
        [Forward::Y, Forward::MinusY]
    };
    if let Some(axis) = given {
        if along.contains(&axis) {
            return Ok(Heading::new(axis, "as given".into()));
        }
        return Err(DraftError::Sideways {
            given: axis.name().into(),
            expected: along.map(Forward::name).join(" or "),
        });
    }
    let [positive, negative] = along;
    let (front, back) = sole_lengths(bodies, feet, &positive.direction());
    let by_sole = ((front - back).abs() > LONGER * (front + back)).then_some(front > back);
    let left = Vector3::z().cross(&positive.direction());
    let by_knee = knees_bend(bodies, feet, &left);
    let (is_positive, how) = match (by_sole, by_knee) {
        (Some(side), _) => {
            let (long, short) = (front.max(back), front.min(back));
            let how = format!(
                "the soles reach {:.0} mm before and {:.0} mm behind the ankles",
                1e3 * long,
                1e3 * short
            );
            (side, how)
        }
        (None, Some(side)) => (side, "the knees bend that way".to_owned()),
        (None, None) => {
            return Err(DraftError::NoFront {
                front: 1e3 * front,
                back: 1e3 * back,
            });
        }
    };
    let mut out = Heading::new(if is_positive { positive } else { negative }, how);
    if by_knee.is_some_and(|knee| knee != is_positive) {
        out.doubt = Some(format!(
            "the knees bend the other way than the soles point: if the robot looks along {}, say --forward {0}",
            if is_positive { negative } else { positive }.name()
        ));
    }
    Ok(out)
}

/// How far the soles reach before and behind the ankles [m], the mean of both.
fn sole_lengths(bodies: &Bodies, feet: &Ends, forward: &Vector3<f64>) -> (f64, f64) {
    let (mut front, mut back) = (0.0, 0.0);
    for foot in feet.pair.ends() {
        let ankle = bodies.origin(foot).dot(forward);
        let low = bodies.lowest(foot) + SOLE;
        let (mut most, mut least) = (0f64, 0f64);
        let behind = (1..bodies.tips.len()).filter(|&j| bodies.is_behind(j, foot));
        for (j, tip) in behind.flat_map(|j| bodies.tips[j].iter().map(move |tip| (j, tip))) {
            let place = bodies.kinematics.world_from_joint[j].act(tip.in_joint);
            if place.z - tip.radius <= low {
                let along = place.dot(forward) - ankle;
                (most, least) = (most.max(along), least.min(along));
            }
        }
        (front, back) = (front + most / 2.0, back - least / 2.0);
    }
    (front, back)
}

/// Do the knees bend so that shins go away from up × `left`, as a man's do; `None` if they do not say.
fn knees_bend(bodies: &Bodies, feet: &Ends, left: &Vector3<f64>) -> Option<bool> {
    let says = feet.pair.chains.each_ref().map(|chain| {
        let (knee, turn) = knee(bodies, chain, left)?;
        let joint = &bodies.model().joints[knee];
        let rest = bodies.q[joint.idx_q];
        let (up, down) = (joint.upper - rest, rest - joint.lower);
        if up > FARTHER * down {
            Some(turn > 0.0)
        } else if down > FARTHER * up {
            Some(turn < 0.0)
        } else {
            None
        }
    });
    if says[0] == says[1] { says[0] } else { None }
}

/// Joints of a chain that turn about the left, with the sign of that.
pub(crate) fn pitch_joints(
    bodies: &Bodies,
    chain: &[usize],
    left: &Vector3<f64>,
) -> Vec<(usize, f64)> {
    let turn = |&j: &usize| match bodies.model().joints[j].kind {
        JointKind::Revolute { axis } => {
            let cosine = bodies.kinematics.world_from_joint[j].rotate(axis).dot(left);
            (cosine.abs() > PITCH).then(|| (j, cosine.signum()))
        }
        _ => None,
    };
    chain.iter().filter_map(turn).collect()
}

/// The knee of a leg: of the joints that turn about the left, but for the first and the last, the one farthest from both. With the sign
/// of its axis along the left.
pub(crate) fn knee(bodies: &Bodies, chain: &[usize], left: &Vector3<f64>) -> Option<(usize, f64)> {
    let pitch = pitch_joints(bodies, chain, left);
    let [(hip, _), between @ .., (ankle, _)] = pitch.as_slice() else {
        return None;
    };
    let far = |(j, _): &(usize, f64)| {
        let from = |other: usize| (bodies.origin(*j) - bodies.origin(other)).norm();
        from(*hip).min(from(*ankle))
    };
    between
        .iter()
        .copied()
        .max_by(|a, b| far(a).total_cmp(&far(b)))
}
