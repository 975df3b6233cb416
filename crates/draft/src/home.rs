//! The nominal stance: a posture whose arms, and legs, keep clear of the rest of the robot.

use crate::DraftError;
use crate::bodies::Bodies;
use crate::heading::Heading;
use crate::limbs::Ends;
use crate::palm::Hand;
use crate::posture::{Posture, Reach, Wish};
use nalgebra::Vector3;
use ocp::System;
use ocp::collision::CollisionModel;
use scene::Scene;

/// Ways to hold the arms, tried in this order.
pub(crate) const WAYS: [Way; 9] = [
    Way::new(0.25, 0.3, 0.1),
    Way::new(0.4, 0.3, 0.1),
    Way::new(0.55, 0.3, 0.1),
    Way::new(0.4, 0.0, -0.1),
    Way::new(0.55, 0.0, -0.3),
    Way::new(0.7, 0.2, 0.0),
    Way::new(0.7, 0.0, -0.4),
    Way::new(0.9, 0.2, -0.2),
    Way::new(0.9, 0.0, -0.5),
];
/// Elbows are so far below the shoulders, as a share of the upper arm.
const BELOW: f64 = 0.93;
/// Forearms point down by this angle [rad].
const DOWN: f64 = 0.3;
/// Links of arms are to be so far from the others, and those of legs [m].
const ARMS_CLEAR: f64 = 0.03;
const LEGS_CLEAR: f64 = 0.02;
/// Joints of a hip.
const HIP: usize = 3;
/// What a wider stance must add to the distance of links, as a share of what it is wider: of hips, whose levers are short, and of others.
const HIPS_GAIN: f64 = 0.03;
const LEGS_GAIN: f64 = 0.3;
/// By how much soles are put further apart than at rest, tried in this order [m].
const WIDER: [f64; 4] = [0.0, 0.03, 0.06, 0.1];
/// Soles that are nearer to each other at rest are put apart to this multiple of their half width.
const NARROWEST: f64 = 2.2;

/// Where elbows and hands are to be.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Way {
    /// How far elbows are out of the shoulders, as a share of the upper arm.
    spread: f64,
    /// How far hands come in again, as a share of that.
    inwards: f64,
    /// How far elbows are behind the shoulders, as a share of the upper arm.
    behind: f64,
}

impl Way {
    const fn new(spread: f64, inwards: f64, behind: f64) -> Self {
        Self {
            spread,
            inwards,
            behind,
        }
    }
}

/// What is asked of the arms: elbows below the shoulders, forearms forward, palms inward.
pub(crate) fn reaches(
    bodies: &Bodies,
    heading: &Heading,
    arms: &Ends,
    hands: &[Hand; 2],
    palms: &[Vector3<f64>; 2],
    way: Way,
) -> Vec<Reach> {
    let one = |side: usize| {
        let (chain, hand) = (&arms.pair.chains[side], &hands[side]);
        let out = if side == 0 {
            heading.left
        } else {
            -heading.left
        };
        let middle = bodies.kinematics.world_from_joint[hand.joint].act(hand.middle);
        let shoulder = bodies.origin(chain[0]);
        let lengths = |j: usize| {
            let place = bodies.origin(j);
            ((place - shoulder).norm(), (middle - place).norm())
        };
        let even = |j: &&usize| {
            let (upper, fore) = lengths(**j);
            upper.min(fore)
        };
        let elbow = chain.iter().max_by(|a, b| even(a).total_cmp(&even(b)));
        let elbow = *elbow.expect("an arm has joints");
        let (upper, fore) = lengths(elbow);
        let (sin, cos) = DOWN.sin_cos();
        let forearm = heading.forward * cos - Vector3::z() * sin;
        let to_elbow = out * way.spread - Vector3::z() * BELOW - heading.forward * way.behind;
        let at_elbow = shoulder + to_elbow.normalize() * upper;
        Reach {
            joint: hand.joint,
            middle: hand.middle,
            along: hand.along,
            palm: palms[side],
            place: at_elbow + (forearm - out * (way.inwards * way.spread)).normalize() * fore,
            elbow: (elbow, at_elbow),
            inward: -out,
            ahead: forearm,
        }
    };
    [0, 1].map(one).into()
}

/// Distance of the soles at rest, more if they would overlap [m].
pub(crate) fn stance(posture: &Posture, bodies: &Bodies, half_width: f64) -> f64 {
    let at_rest = posture.stand(&bodies.q).stance.abs();
    at_rest.max(NARROWEST * half_width)
}

/// A stance with what is near what in it.
pub(crate) struct Home {
    pub q: Vec<f64>,
    /// The least distance of links that keep out of one another, with their joints [m].
    pub nearest: Option<(f64, usize, usize)>,
}

/// The first of the postures that keep clear, or the one that does most; `scene` has the robot with its shapes and interfaces.
pub(crate) fn home(
    bodies: &Bodies,
    posture: &Posture,
    scene: &mut Scene,
    arms: Option<&Ends>,
    stance: f64,
    hands_at: &dyn Fn(Way) -> Vec<Reach>,
) -> Result<Home, DraftError> {
    let of_arm = |j: usize| {
        let roots = arms
            .into_iter()
            .flat_map(|arms| arms.pair.chains.iter().map(|chain| chain[0]));
        { roots }.any(|root| bodies.is_behind(j, root))
    };
    let is_arms = |pair: &(f64, usize, usize)| of_arm(pair.1) || of_arm(pair.2);
    // Where three joints are in one place, as in a hip, shapes are near each other in any posture.
    let is_hip = |pair: &(f64, usize, usize)| bodies.joints_between(pair.1, pair.2) <= HIP;
    let mut wish = Wish {
        stance,
        hands: hands_at(WAYS[0]),
    };
    let mut best: Option<Legs> = None;
    for wider in WIDER {
        wish.stance = stance + wider;
        let q = posture.solve(&wish).0;
        let of_legs = |pair: &_| !is_arms(pair) && !is_hip(pair);
        let of_hips = |pair: &_| !is_arms(pair) && is_hip(pair);
        let pairs = distances(scene, &q)?;
        let legs = Legs {
            clear: least(&pairs, &of_legs),
            hips: least(&pairs, &of_hips),
            q,
            stance: wish.stance,
        };
        if best.as_ref().is_none_or(|best| legs.pays(best, wider)) {
            best = Some(legs);
        }
        if best.as_ref().is_some_and(Legs::is_clear) {
            break;
        }
    }
    let Legs { mut q, stance, .. } = best.expect("one was tried");
    wish.stance = stance;
    if arms.is_some() {
        let mut most = f64::NEG_INFINITY;
        for way in WAYS {
            wish.hands = hands_at(way);
            let found = posture.solve(&wish).0;
            let clear = least(&distances(scene, &found)?, &is_arms);
            if clear > most {
                (most, q) = (clear, found);
            }
            if clear >= ARMS_CLEAR {
                break;
            }
        }
    }
    let mut pairs = distances(scene, &q)?.into_iter();
    let nearest = pairs.find(|pair| pair.0 < 0.0 || !is_hip(pair));
    Ok(Home { q, nearest })
}

/// A posture of the legs, and the least distances of other links than those of arms, of hips and of others [m].
struct Legs {
    clear: f64,
    hips: f64,
    q: Vec<f64>,
    stance: f64,
}

impl Legs {
    fn is_clear(&self) -> bool {
        self.clear >= LEGS_CLEAR && self.hips >= 0.0
    }

    /// Is a stance so much wider than the narrowest worth it?
    fn pays(&self, narrower: &Self, wider: f64) -> bool {
        let hips = narrower.hips < 0.0
            && self.hips > narrower.hips + HIPS_GAIN * (self.stance - narrower.stance)
            && self.clear >= narrower.clear.min(LEGS_CLEAR);
        self.clear > narrower.clear + LEGS_GAIN * wider || hips
    }
}

/// The least distance of the pairs of links that count [m].
fn least(pairs: &[(f64, usize, usize)], counts: &dyn Fn(&(f64, usize, usize)) -> bool) -> f64 {
    let counted = pairs.iter().find(|pair| counts(pair));
    counted.map_or(f64::INFINITY, |pair| pair.0)
}

/// Distances of links that keep out of one another, nearest first; the scene's home becomes this posture.
fn distances(scene: &mut Scene, q: &[f64]) -> Result<Vec<(f64, usize, usize)>, DraftError> {
    let first = q.len() - scene.robot.home.len();
    scene.robot.home.copy_from_slice(&q[first..]);
    scene.start[first..].copy_from_slice(&q[first..]);
    let system = System::new(scene)?;
    Ok(CollisionModel::new(scene, &system).distances_at_home())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wider_stance_pays_where_it_takes_hips_out_of_one_another_or_legs_apart() {
        let legs = |clear, hips, wider: f64| Legs {
            clear,
            hips,
            q: vec![],
            stance: 0.2 + wider,
        };
        let narrow = legs(0.03, -0.005, 0.0);
        assert!(!narrow.is_clear());
        assert!(legs(0.03, 0.003, 0.1).pays(&narrow, 0.1));
        assert!(!legs(0.03, -0.004, 0.1).pays(&narrow, 0.1), "hardly");
        assert!(
            !legs(0.01, 0.003, 0.1).pays(&narrow, 0.1),
            "legs in the way"
        );
        let apart = legs(0.03, 0.001, 0.0);
        assert!(apart.is_clear() && !legs(0.03, 0.02, 0.1).pays(&apart, 0.1));
        let near = legs(-0.01, 0.001, 0.0);
        assert!(legs(0.03, 0.001, 0.06).pays(&near, 0.06));
    }
}
