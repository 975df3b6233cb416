//! A posture that stands: soles level and equally high, the centre of mass over their middle, knees bent, hands before the body.
//!
//! Frames: `base`, upright in the origin, so that it is the world here. Legend: x the variables, each a joint of one limb with its mirror
//! image in the other.

use crate::bodies::Bodies;
use crate::heading::{Heading, knee, pitch_joints};
use crate::least_squares::{Residuals, minimise};
use crate::limbs::Ends;
use crate::mirror::sign;
use multibody::{CenterOfMass, Kinematics};
use nalgebra::{Vector3, Vector6};
use spatial::{Pose, Random};

/// Weights: what must hold, per rad or m.
const MUST: f64 = 1e3;
/// Heading of the soles, and their distance.
const HEADING: f64 = 30.0;
const STANCE: f64 = 20.0;
/// Knees, joints of legs from their guess, joints of arms from rest.
const KNEE: f64 = 3.0;
const LEG: f64 = 0.1;
const ARM: f64 = 0.06;
/// Place of hands and elbows [1/m], where palms face, where hands point.
const HAND: f64 = 4.0;
const ELBOW: f64 = 1.5;
const PALM: f64 = 0.7;
const POINTING: f64 = 0.35;
/// How far knees are bent [rad].
const BEND: f64 = 0.5;
/// Joints keep so far away from their limits [rad or m], and no further than this share of their range.
const MARGIN: (f64, f64) = (0.05, 0.05);
/// Beginnings of the arms that are tried, and how far from rest they are [rad].
const BEGINNINGS: u64 = 12;
const AWAY: f64 = 1.2;

/// A joint, with its mirror image if it has one.
#[derive(Debug, Clone)]
struct Variable {
    /// Joints with the sign by which they move.
    joints: Vec<(usize, f64)>,
    rest: f64,
    lower: f64,
    upper: f64,
    guess: f64,
    weight: f64,
    of_arm: bool,
}

/// Where one hand is to be.
#[derive(Debug, Clone)]
pub(crate) struct Reach {
    pub joint: usize,
    /// Middle of the hand, direction of it and normal of its palm, in the joint.
    pub middle: Vector3<f64>,
    pub along: Vector3<f64>,
    pub palm: Vector3<f64>,
    /// Where the middle is to be, in the base [m].
    pub place: Vector3<f64>,
    /// The joint that is the elbow, and where it is to be.
    pub elbow: (usize, Vector3<f64>),
    /// Unit vectors of the base: where the palm is to face, where the hand is to point.
    pub inward: Vector3<f64>,
    pub ahead: Vector3<f64>,
}

/// What is asked of a posture.
#[derive(Debug, Clone)]
pub(crate) struct Wish {
    /// Distance of the soles across [m].
    pub stance: f64,
    /// Where the hands are to be, left and right; empty for a robot without arms.
    pub hands: Vec<Reach>,
}

/// How well a posture stands.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Stand {
    /// Largest angle of a sole from level [rad].
    pub tilt: f64,
    /// By how much one sole is higher than the other [m].
    pub uneven: f64,
    /// Horizontal distance of the centre of mass from the soles' middle, forward and to the left [m].
    pub com: [f64; 2],
    /// Height of the base over the soles [m].
    pub base: f64,
    /// Distance of the soles' origins across [m].
    pub stance: f64,
}

/// The problem of one robot.
pub(crate) struct Posture<'a> {
    bodies: &'a Bodies<'a>,
    heading: &'a Heading,
    /// Joints that carry the soles, and these in them; left and right.
    soles: [(usize, Pose); 2],
    variables: Vec<Variable>,
    /// Variables that are knees, by joint.
    knees: Vec<usize>,
    /// Does each leg move on its own.
    legs_apart: bool,
}

impl<'a> Posture<'a> {
    /// The problem of legs and arms. `legs_apart`: legs need not be mirror images, so that the centre of mass is over the middle of the soles
    /// to the left too.
    pub fn new(
        bodies: &'a Bodies<'a>,
        heading: &'a Heading,
        soles: [(usize, Pose); 2],
        (feet, hands): (&Ends, Option<&Ends>),
        legs_apart: bool,
    ) -> Self {
        let mut out = Self {
            bodies,
            heading,
            soles,
            variables: Vec::new(),
            knees: Vec::new(),
            legs_apart,
        };
        out.add_limbs(feet, LEG, false);
        if let Some(hands) = hands {
            out.add_limbs(hands, ARM, true);
        }
        out.guess_legs(feet);
        out
    }

    fn add_limbs(&mut self, ends: &Ends, weight: f64, of_arm: bool) {
        let [a, b] = &ends.pair.chains;
        let alike = a.len() == b.len() && (of_arm || !self.legs_apart);
        let signs = a
            .iter()
            .zip(b)
            .map(|(&i, &j)| sign(self.bodies, i, j, &self.heading.left));
        let signs: Vec<Option<f64>> = signs.collect();
        for (k, &joint) in a.iter().enumerate() {
            let image = signs.get(k).copied().flatten().filter(|_| alike);
            let mut joints = vec![(joint, 1.0)];
            joints.extend(image.map(|sign| (b[k], sign)));
            self.add(joints, weight, of_arm);
        }
        for (k, &joint) in b.iter().enumerate() {
            if !alike || signs[k].is_none() {
                self.add(vec![(joint, 1.0)], weight, of_arm);
            }
        }
    }

    /// Adds a variable; it is the position of its first joint.
    fn add(&mut self, joints: Vec<(usize, f64)>, weight: f64, of_arm: bool) {
        let model = self.bodies.model();
        let known = |j: usize| {
            self.variables
                .iter()
                .any(|v| v.joints.iter().any(|x| x.0 == j))
        };
        if joints.iter().any(|(j, _)| known(*j)) {
            return;
        }
        let at_rest = |j: usize| self.bodies.q[model.joints[j].idx_q];
        let rest = at_rest(joints[0].0);
        let (mut lower, mut upper) = (f64::NEG_INFINITY, f64::INFINITY);
        for &(j, sign) in &joints {
            let joint = &model.joints[j];
            let margin = MARGIN.0.min(MARGIN.1 * (joint.upper - joint.lower));
            // Where the first joint is when this one is at its limits.
            let ends = [joint.lower + margin, joint.upper - margin];
            let ends = ends.map(|q| rest + sign * (q - at_rest(j)));
            lower = lower.max(ends[0].min(ends[1]));
            upper = upper.min(ends[0].max(ends[1]));
        }
        let upper = upper.max(lower);
        let guess = rest.clamp(lower, upper);
        self.variables.push(Variable {
            joints,
            rest,
            lower,
            upper,
            guess,
            weight,
            of_arm,
        });
    }

    /// Bends hips, knees and ankles that turn about the left.
    fn guess_legs(&mut self, feet: &Ends) {
        for chain in &feet.pair.chains {
            let left = &self.heading.left;
            let Some((middle, turn)) = knee(self.bodies, chain, left) else {
                continue;
            };
            let Some(of_knee) = self.variable(middle) else {
                continue;
            };
            if self.knees.contains(&of_knee) {
                continue;
            }
            self.knees.push(of_knee);
            let bent = |v: &Variable, by: f64| (v.rest + by).clamp(v.lower, v.upper);
            // Shins go back where knees can bend that way, as a man's do.
            let v = &self.variables[of_knee];
            let room = |by: f64| (bent(v, by) - v.rest).abs();
            let side = if room(turn * BEND) >= room(-turn * BEND) {
                turn
            } else {
                -turn
            };
            // A keyframe may have them bent already.
            let by = side * (BEND - side * (v.rest - self.zero(middle))).clamp(0.0, BEND);
            let knee_turn = by * turn;
            self.variables[of_knee].guess = bent(v, by);
            self.variables[of_knee].weight = KNEE;
            let pitch = pitch_joints(self.bodies, chain, left);
            for end in [pitch.first(), pitch.last()].into_iter().flatten() {
                if let Some(k) = self.variable(end.0) {
                    let guess = bent(&self.variables[k], -0.5 * knee_turn * end.1);
                    self.variables[k].guess = guess;
                }
            }
        }
    }

    /// The variable whose first joint this is.
    fn variable(&self, joint: usize) -> Option<usize> {
        self.variables.iter().position(|v| v.joints[0].0 == joint)
    }

    /// How far the left knee is bent in a posture [rad].
    pub fn knees(&self, q: &[f64]) -> Option<f64> {
        let knee = self.variables[*self.knees.first()?].joints[0].0;
        Some(q[self.bodies.model().joints[knee].idx_q] - self.zero(knee))
    }

    /// Zero, or the limit of a joint that is nearest to it.
    fn zero(&self, joint: usize) -> f64 {
        let joint = &self.bodies.model().joints[joint];
        0f64.max(joint.lower).min(joint.upper)
    }

    /// The best posture for a wish that is found, positions of base and joints, and how good it is (less is better).
    pub fn solve(&self, wish: &Wish) -> (Vec<f64>, f64) {
        let bounds = [
            self.variables.iter().map(|v| v.lower).collect::<Vec<_>>(),
            self.variables.iter().map(|v| v.upper).collect(),
        ];
        let mut work = (
            Kinematics::new(self.bodies.model()),
            CenterOfMass::new(self.bodies.model()),
        );
        let mut best: Option<(f64, Vec<f64>)> = None;
        let beginnings = if wish.hands.is_empty() { 1 } else { BEGINNINGS };
        for seed in 0..beginnings {
            let mut random = Random::new(seed);
            let begin = |v: &Variable| {
                let away = if seed > 0 && v.of_arm {
                    random.uniform(-AWAY, AWAY)
                } else {
                    0.0
                };
                (v.guess + away).clamp(v.lower, v.upper)
            };
            let mut x: Vec<f64> = self.variables.iter().map(begin).collect();
            let bounds = [bounds[0].as_slice(), bounds[1].as_slice()];
            let cost = minimise(&mut x, bounds, &mut |x| self.residuals(x, wish, &mut work));
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, x));
            }
        }
        let (cost, x) = best.expect("there is a beginning");
        (self.configuration(&x), cost)
    }

    /// Positions of base and joints.
    fn configuration(&self, x: &[f64]) -> Vec<f64> {
        let joints = &self.bodies.model().joints;
        let mut q = self.bodies.q.clone();
        for (variable, x) in self.variables.iter().zip(x) {
            for &(j, sign) in &variable.joints {
                q[joints[j].idx_q] += sign * (x - variable.rest);
            }
        }
        q
    }

    fn residuals(
        &self,
        x: &[f64],
        wish: &Wish,
        (kinematics, com): &mut (Kinematics, CenterOfMass),
    ) -> Residuals {
        let model = self.bodies.model();
        kinematics.update(model, &self.configuration(x));
        let (centre, jacobian) = com.compute(model, kinematics);
        let (forward, left) = (&self.heading.forward, &self.heading.left);
        let at = Derivatives {
            posture: self,
            kinematics,
        };
        let mut out = Residuals::default();
        let mut places = Vec::new();
        for (joint, joint_from_sole) in &self.soles {
            let world_from_sole = kinematics.world_from_joint[*joint] * *joint_from_sole;
            let normal = world_from_sole.rotation().column(2).into_owned();
            let ahead = world_from_sole.rotation().column(0).into_owned();
            for axis in [forward, left] {
                out.push(MUST, normal.dot(axis), at.direction(*joint, &normal, axis));
            }
            out.push(HEADING, ahead.dot(left), at.direction(*joint, &ahead, left));
            places.push((*joint, world_from_sole.origin()));
        }
        // What two soles have along an axis: (a − b)·axis, and (a + b)/2·axis.
        let along = |signs: [f64; 2], axis: &Vector3<f64>| {
            let mut value = 0.0;
            let mut row = vec![0.0; x.len()];
            for ((joint, place), sign) in places.iter().zip(signs) {
                value += sign * place.dot(axis);
                let own = at.point(*joint, place, axis);
                row.iter_mut()
                    .zip(own)
                    .for_each(|(sum, d)| *sum += sign * d);
            }
            (value, row)
        };
        let (height, row) = along([1.0, -1.0], &Vector3::z());
        out.push(MUST, height, row);
        let (before, row) = along([1.0, -1.0], forward);
        out.push(HEADING, before, row);
        let (across, row) = along([1.0, -1.0], left);
        out.push(STANCE, across - wish.stance, row);
        let axes = if self.legs_apart {
            &[forward, left][..]
        } else {
            &[forward]
        };
        for axis in axes {
            let (middle, mut row) = along([-0.5, -0.5], axis);
            for (k, variable) in self.variables.iter().enumerate() {
                for &(j, sign) in &variable.joints {
                    row[k] += sign * jacobian.column(model.joints[j].idx_v).dot(axis);
                }
            }
            out.push(MUST, centre.dot(axis) + middle, row);
        }
        for hand in &wish.hands {
            at.reach(hand, &mut out);
        }
        for (k, variable) in self.variables.iter().enumerate() {
            let mut row = vec![0.0; x.len()];
            row[k] = 1.0;
            out.push(variable.weight, x[k] - variable.guess, row);
        }
        out
    }

    /// How well a posture stands, as it is written.
    pub fn stand(&self, q: &[f64]) -> Stand {
        let model = self.bodies.model();
        let mut kinematics = Kinematics::new(model);
        kinematics.update(model, q);
        let centre = CenterOfMass::new(model).compute(model, &kinematics).0;
        let soles = (self.soles.iter())
            .map(|(joint, sole)| kinematics.world_from_joint[*joint] * *sole)
            .collect::<Vec<Pose>>();
        let tilt = |sole: &Pose| sole.rotation().column(2).xy().norm();
        let (a, b) = (soles[0].origin(), soles[1].origin());
        let off = centre - (a + b) / 2.0;
        Stand {
            tilt: tilt(&soles[0]).max(tilt(&soles[1])),
            uneven: (a.z - b.z).abs(),
            com: [off.dot(&self.heading.forward), off.dot(&self.heading.left)],
            base: -(a.z + b.z) / 2.0,
            stance: (a - b).dot(&self.heading.left),
        }
    }
}

/// Derivatives by the variables at one configuration.
struct Derivatives<'a> {
    posture: &'a Posture<'a>,
    kinematics: &'a Kinematics,
}

impl Derivatives<'_> {
    /// Of something that a joint carries, given what a unit twist at the world's origin does to it.
    fn row(&self, carrier: usize, of: impl Fn(&Vector6<f64>) -> f64) -> Vec<f64> {
        let bodies = self.posture.bodies;
        let model = bodies.model();
        let by_joint = |&(j, sign): &(usize, f64)| {
            if bodies.is_behind(carrier, j) {
                sign * of(&self.kinematics.column_in_world[model.joints[j].idx_v])
            } else {
                0.0
            }
        };
        let by_variable = |v: &Variable| v.joints.iter().map(by_joint).sum();
        self.posture.variables.iter().map(by_variable).collect()
    }

    /// Of the coordinate of a point along an axis.
    fn point(&self, carrier: usize, point: &Vector3<f64>, axis: &Vector3<f64>) -> Vec<f64> {
        self.row(carrier, |column| {
            let (linear, angular) = (column.fixed_rows::<3>(0), column.fixed_rows::<3>(3));
            (linear + angular.cross(point)).dot(axis)
        })
    }

    /// Of the coordinate of a direction along an axis.
    fn direction(&self, carrier: usize, of: &Vector3<f64>, axis: &Vector3<f64>) -> Vec<f64> {
        self.row(carrier, |column| {
            column.fixed_rows::<3>(3).cross(of).dot(axis)
        })
    }

    fn reach(&self, hand: &Reach, out: &mut Residuals) {
        let world_from_hand = &self.kinematics.world_from_joint[hand.joint];
        let middle = world_from_hand.act(hand.middle);
        let (elbow, place) = hand.elbow;
        let elbow_place = self.kinematics.world_from_joint[elbow].origin();
        let (palm, along) = (
            world_from_hand.rotate(hand.palm),
            world_from_hand.rotate(hand.along),
        );
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            let off = (middle - hand.place).dot(&axis);
            out.push(HAND, off, self.point(hand.joint, &middle, &axis));
            let off = (elbow_place - place).dot(&axis);
            out.push(ELBOW, off, self.point(elbow, &elbow_place, &axis));
            let off = (palm - hand.inward).dot(&axis);
            out.push(PALM, off, self.direction(hand.joint, &palm, &axis));
            let off = (along - hand.ahead).dot(&axis);
            out.push(POINTING, off, self.direction(hand.joint, &along, &axis));
        }
    }
}
