//! Limbs that are like each other left and right.

use crate::bodies::Bodies;
use multibody::JointKind;
use nalgebra::Vector3;

/// How far a joint may be from the mirror image of its counterpart [m].
const PLACE: f64 = 0.02;
/// By which share masses of counterparts may differ, and by how much at least [kg].
const MASS: (f64, f64) = (0.1, 0.1);
/// The ends of two limbs are at least so far apart [m].
const APART: f64 = 0.03;
/// Cosine of the angle up to which joint axes count as mirror images.
const PARALLEL: f64 = 0.99;

/// Two bodies that are mirror images of each other at rest, with the chains from what carries both.
#[derive(Debug, Clone)]
pub(crate) struct Pair {
    /// From the first joint to the body, which is the last.
    pub chains: [Vec<usize>; 2],
}

impl Pair {
    /// The two bodies.
    pub fn ends(&self) -> [usize; 2] {
        [0, 1].map(|side| *self.chains[side].last().expect("chains are not empty"))
    }

    /// Joints of a chain.
    pub fn len(&self) -> usize {
        self.chains[0].len()
    }

    pub fn swapped(self) -> Self {
        let [a, b] = self.chains;
        Self { chains: [b, a] }
    }
}

/// All pairs of bodies that are like each other.
pub(crate) fn pairs(bodies: &Bodies) -> Vec<Pair> {
    let n = bodies.model().joints.len();
    let mut out = Vec::new();
    for a in 1..n {
        for b in a + 1..n {
            out.extend(bodies.chains(a, b).and_then(|chains| {
                let pair = Pair { chains };
                is_mirrored(bodies, &pair).then_some(pair)
            }));
        }
    }
    out
}

fn is_mirrored(bodies: &Bodies, pair: &Pair) -> bool {
    let [a, b] = &pair.chains;
    if a.len() != b.len() {
        return false;
    }
    let [end, other] = pair.ends().map(|j| bodies.origin(j));
    let across = Vector3::new(end.x - other.x, end.y - other.y, 0.0);
    let apart = across.norm();
    if apart < APART {
        return false;
    }
    let (across, middle) = (across / apart, (end + other) / 2.0);
    let joints = &bodies.model().joints;
    a.iter().zip(b).all(|(&i, &j)| {
        let p = bodies.origin(i) - middle;
        let image = mirrored(&p, &across) + middle;
        let (own, its) = (joints[i].inertia.mass, joints[j].inertia.mass);
        let same_kind =
            std::mem::discriminant(&joints[i].kind) == std::mem::discriminant(&joints[j].kind);
        same_kind
            && (image - bodies.origin(j)).norm() < PLACE
            && (own - its).abs() < (MASS.0 * own.max(its)).max(MASS.1)
    })
}

/// A vector seen in a mirror with this unit normal.
pub(crate) fn mirrored(vector: &Vector3<f64>, across: &Vector3<f64>) -> Vector3<f64> {
    vector - across * (2.0 * across.dot(vector))
}

/// How a joint moves if its counterpart `i` moves by +1, so that the two stay mirror images: +1 or −1; `None` if it cannot.
pub(crate) fn sign(bodies: &Bodies, i: usize, j: usize, across: &Vector3<f64>) -> Option<f64> {
    let joints = &bodies.model().joints;
    let axis = |k: usize| match joints[k].kind {
        JointKind::Revolute { axis } => {
            Some((bodies.kinematics.world_from_joint[k].rotate(axis), -1.0))
        }
        JointKind::Prismatic { axis } => {
            Some((bodies.kinematics.world_from_joint[k].rotate(axis), 1.0))
        }
        JointKind::FreeFlyer => None,
    };
    // An axis of rotation is an axial vector: its image in a mirror is turned round.
    let ((own, turn), (its, _)) = (axis(i)?, axis(j)?);
    let cosine = (mirrored(&own, across) * turn).dot(&its);
    (cosine.abs() > PARALLEL).then(|| cosine.signum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirror_turns_what_is_across_it_and_leaves_the_rest() {
        let image = mirrored(&Vector3::new(1.0, 2.0, 3.0), &Vector3::y());
        assert_eq!(image, Vector3::new(1.0, -2.0, 3.0));
    }
}
