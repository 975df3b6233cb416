//! Which links are feet and hands.
//!
//! Feet are the lowest bodies of two limbs that are like each other; of several of these limbs, as where toes move, those with the
//! largest soles. Hands are where other such limbs end, or branch into fingers.

use crate::DraftError;
use crate::bodies::{Bodies, Tip};
use crate::face::near_face;
use crate::hull::{area, convex_hull};
use crate::mirror::{Pair, pairs};
use multibody::JointKind;
use nalgebra::Vector3;

/// Legs and arms have at least so many joints.
const JOINTS: usize = 3;
/// Bodies are as low as the lowest if within this [m].
const LOW: f64 = 0.04;
/// A limb goes on with one of several branches if that has at least this share of their mass, and joints of its own.
const MAIN_BRANCH: f64 = 0.8;
/// Height above the lowest point up to which a foot is looked at for its sole [m].
const SOLE: f64 = 0.003;
/// Most names that a message lists.
const NAMES: usize = 12;

/// Two limbs that end in feet or hands.
#[derive(Debug, Clone)]
pub(crate) struct Ends {
    pub pair: Pair,
    /// The links that carry the interfaces.
    pub frames: [usize; 2],
    /// Were they named by the user.
    pub named: bool,
}

impl Ends {
    /// The same with left and right exchanged.
    pub fn swapped(self) -> Self {
        let [a, b] = self.frames;
        Self {
            pair: self.pair.swapped(),
            frames: [b, a],
            named: self.named,
        }
    }
}

/// The two links that an option names.
pub(crate) fn named(
    bodies: &Bodies,
    names: &[String; 2],
    option: &'static str,
) -> Result<Ends, DraftError> {
    let model = bodies.model();
    let mut frames = [0; 2];
    for (frame, name) in frames.iter_mut().zip(names) {
        *frame = model.frame_id(name).ok_or_else(|| {
            let ends = (1..model.joints.len()).filter(|&j| bodies.children[j].is_empty());
            let hint = format!("ends of limbs: {}", list(bodies, ends));
            DraftError::UnknownLink {
                option,
                name: name.clone(),
                hint,
            }
        })?;
        if model.frames[*frame].joint.is_none_or(|joint| joint == 0) {
            let name = name.clone();
            return Err(DraftError::NotMoved { option, name });
        }
    }
    let [a, b] = frames.map(|frame| model.frames[frame].joint.unwrap_or(0));
    let chains = bodies.chains(a, b).ok_or_else(|| DraftError::OneLimb {
        option,
        first: names[0].clone(),
        second: names[1].clone(),
    })?;
    Ok(Ends {
        pair: Pair { chains },
        frames,
        named: true,
    })
}

/// The feet.
pub(crate) fn feet(bodies: &Bodies) -> Result<Ends, DraftError> {
    let mut legs = pairs(bodies);
    legs.retain(|pair| pair.len() >= JOINTS);
    let low = |pair: &Pair| {
        let [a, b] = pair.ends().map(|j| bodies.lowest(j));
        a.max(b)
    };
    let least = legs.iter().map(low).fold(f64::INFINITY, f64::min);
    let lowest = (1..bodies.children.len()).map(|j| bodies.lowest(j));
    let ground = lowest.fold(bodies.lowest(0), f64::min);
    legs.retain(|pair| low(pair) <= least.min(ground + LOW) + LOW);
    let on_one_limb = |a: usize, b: usize| bodies.is_behind(a, b) || bodies.is_behind(b, a);
    let Some(first) = legs.first() else {
        let ends = (1..bodies.children.len()).filter(|&j| bodies.children[j].is_empty());
        return Err(DraftError::NoFeet {
            joints: JOINTS,
            ends: list(bodies, ends),
        });
    };
    let [a, b] = first.ends();
    let same_limbs = |pair: &Pair| {
        let [c, d] = pair.ends();
        on_one_limb(a, c) && on_one_limb(b, d) || on_one_limb(a, d) && on_one_limb(b, c)
    };
    if !legs.iter().all(same_limbs) {
        return Err(ambiguous(bodies, &legs, "feet", "--feet"));
    }
    let size = |pair: &Pair| -> f64 { pair.ends().map(|j| sole_area(bodies, j)).iter().sum() };
    let pair = legs.iter().max_by(|x, y| size(x).total_cmp(&size(y)));
    let pair = pair.expect("there is a first one").clone();
    let frames = pair.ends().map(|j| sole_frame(bodies, j));
    Ok(Ends {
        pair,
        frames,
        named: false,
    })
}

/// The hands, of limbs that share nothing with the legs; `None` if there are no arms.
pub(crate) fn hands(bodies: &Bodies, feet: &Ends) -> Result<Option<Ends>, DraftError> {
    let all = pairs(bodies);
    let of_leg = |j: usize| {
        let mut legs = feet.pair.chains.iter().flatten();
        legs.any(|&leg| bodies.is_behind(j, leg) || bodies.is_behind(leg, j))
    };
    let roots = all
        .iter()
        .filter(|pair| pair.len() == 1 && !pair.ends().iter().any(|&j| of_leg(j)));
    let mut arms: Vec<Pair> = Vec::new();
    for root in roots {
        let mut ways = root.ends().map(|j| descend(bodies, j));
        // Where grippers are not mirror images, the hands are the bodies before.
        let alike = |ways: &[Vec<usize>; 2]| {
            let [a, b] = [0, 1].map(|side| *ways[side].last().unwrap_or(&0));
            all.iter().find(|pair| pair.ends() == [a, b]).cloned()
        };
        let length = ways[0].len().min(ways[1].len());
        for way in &mut ways {
            way.truncate(length);
        }
        let mut found = alike(&ways);
        while found.is_none() && ways[0].len() > JOINTS {
            for way in &mut ways {
                way.pop();
            }
            found = alike(&ways);
        }
        arms.extend(found.filter(|pair| pair.len() >= JOINTS));
    }
    if arms.len() > 1 {
        return Err(ambiguous(bodies, &arms, "hands", "--hands"));
    }
    Ok(arms.pop().map(|pair| Ends {
        frames: pair.ends().map(|j| hand_frame(bodies, j)),
        pair,
        named: false,
    }))
}

/// The bodies from a shoulder to where its limb ends or branches into fingers.
fn descend(bodies: &Bodies, shoulder: usize) -> Vec<usize> {
    let mut way = vec![shoulder];
    loop {
        let children = &bodies.children[way[way.len() - 1]];
        let masses: Vec<f64> = children.iter().map(|&j| bodies.mass_behind(j)).collect();
        let whole: f64 = masses.iter().sum();
        let next = match children.as_slice() {
            &[only] => Some(only),
            several => (several.iter().zip(&masses))
                .find(|(j, mass)| **mass >= MAIN_BRANCH * whole && bodies.depth_behind(**j) >= 2)
                .map(|(j, _)| *j),
        };
        let slides =
            |j: &usize| matches!(bodies.model().joints[*j].kind, JointKind::Prismatic { .. });
        match next.filter(|j| !slides(j)) {
            Some(j) => way.push(j),
            None => return way,
        }
    }
}

/// Area of the lowest face of a body at rest [m²].
fn sole_area(bodies: &Bodies, joint: usize) -> f64 {
    let rotation = bodies.kinematics.world_from_joint[joint].rotation();
    let down = rotation.tr_mul(&-Vector3::z());
    let tips: Vec<(Vector3<f64>, f64)> = bodies.tips[joint]
        .iter()
        .map(|tip| (tip.in_joint, tip.radius))
        .collect();
    let face = near_face(&tips, &down, SOLE);
    let plane = face.iter().map(|p| (rotation * p).xy());
    area(&convex_hull(&plane.collect::<Vec<_>>()))
}

/// The link of a body with most points of its lowest face.
pub(crate) fn sole_frame(bodies: &Bodies, joint: usize) -> usize {
    let base_from_joint = &bodies.kinematics.world_from_joint[joint];
    let low = bodies.lowest(joint) + SOLE;
    let is_low = |tip: &&Tip| base_from_joint.act(tip.in_joint).z - tip.radius <= low;
    let count = |frame: usize| {
        let of_sole = bodies.tips[joint].iter().filter(is_low);
        of_sole.filter(|tip| tip.frame == frame).count()
    };
    best_frame(bodies, joint, |frame| count(frame) as f64)
}

/// The link of a body that is the hand itself: of those that are nearly as large as its largest, the farthest out.
fn hand_frame(bodies: &Bodies, joint: usize) -> usize {
    let size = |frame: usize| {
        let (lower, upper) = extent(bodies, joint, frame);
        (upper - lower).map(|x| x.max(0.0)).norm()
    };
    let frames = 0..bodies.model().frames.len();
    let largest = frames.map(size).fold(0.0, f64::max);
    best_frame(bodies, joint, |frame| {
        let (lower, upper) = extent(bodies, joint, frame);
        let middle = (lower + upper) / 2.0;
        if size(frame) > 0.5 * largest {
            middle.norm()
        } else {
            0.0
        }
    })
}

/// Smallest and largest coordinates of what a link of a body is made of, in the joint [m]; infinite without shapes.
fn extent(bodies: &Bodies, joint: usize, frame: usize) -> (Vector3<f64>, Vector3<f64>) {
    let none = Vector3::repeat(f64::INFINITY);
    let of_link = bodies.tips[joint].iter().filter(|tip| tip.frame == frame);
    of_link.fold((none, -none), |(lower, upper), tip| {
        let radius = Vector3::repeat(tip.radius);
        (
            lower.inf(&(tip.in_joint - radius)),
            upper.sup(&(tip.in_joint + radius)),
        )
    })
}

/// The link of a body for which `score` is greatest, of equal ones the first.
fn best_frame(bodies: &Bodies, joint: usize, score: impl Fn(usize) -> f64) -> usize {
    let frames = &bodies.model().frames;
    let of_body = (0..frames.len()).filter(|&f| frames[f].joint == Some(joint));
    let mut best: Option<(f64, usize)> = None;
    for frame in of_body {
        let score = score(frame);
        if best.is_none_or(|(most, _)| score > most) {
            best = Some((score, frame));
        }
    }
    best.map_or(0, |(_, frame)| frame)
}

fn ambiguous(
    bodies: &Bodies,
    pairs: &[Pair],
    what: &'static str,
    option: &'static str,
) -> DraftError {
    let mut ends: Vec<usize> = pairs.iter().flat_map(Pair::ends).collect();
    ends.sort_unstable();
    ends.dedup();
    DraftError::Ambiguous {
        what,
        candidates: list(bodies, ends.into_iter()),
        option,
    }
}

/// Names of bodies, the first of many.
fn list(bodies: &Bodies, joints: impl Iterator<Item = usize>) -> String {
    let names: Vec<&str> = joints.map(|j| bodies.name(j)).collect();
    let more = if names.len() > NAMES { ", …" } else { "" };
    format!("{}{more}", names[..names.len().min(NAMES)].join(", "))
}
