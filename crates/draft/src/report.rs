//! What is told of a draft.

use crate::Parts;
use crate::patch::Patch;
use crate::posture::Stand;
use multibody::{JointKind, Kinematics};
use std::fmt::Write;

/// Links that are nearer to each other in the stance than this are told [m].
const NEAR: f64 = 0.03;
/// Cosine of the angle from inward beyond which a palm is told.
const TURNED: f64 = 0.9;
/// A centre of mass so far beside the middle of the soles is told [m].
const BESIDE: f64 = 0.005;

/// A draft with what was measured of it.
pub(crate) struct Told<'a> {
    pub parts: &'a Parts<'a>,
    /// Palms, left and right, if there are hands.
    pub patches: &'a [Patch],
    pub q: &'a [f64],
    pub stand: Stand,
    /// How far the knees are bent [rad].
    pub knees: Option<f64>,
    /// The links that are nearest in the stance [m].
    pub nearest: Option<(f64, usize, usize)>,
}

impl Told<'_> {
    /// What was found and how.
    pub fn lines(&self) -> Vec<String> {
        let parts = self.parts;
        let model = parts.bodies.model();
        let moving = model
            .joints
            .iter()
            .filter(|j| j.kind != JointKind::FreeFlyer);
        let name = |frame: usize| model.frames[frame].name.as_str();
        let mut out = vec![format!(
            "robot: {}, {} joints, {:.2} kg",
            model.name,
            moving.count(),
            model.total_mass()
        )];
        let how = |named: bool, found: &str, n: usize| {
            if named {
                "as given".to_owned()
            } else {
                format!("{found} {n} joints that are like each other")
            }
        };
        let [a, b] = parts.feet.frames.map(name);
        let [x, y] = parts.soles[0].half_size;
        out.push(format!(
            "feet: {a}, {b} ({}); soles {:.0} x {:.0} mm",
            how(
                parts.feet.named,
                "lowest ends of two limbs of",
                parts.feet.pair.len()
            ),
            2e3 * x,
            2e3 * y
        ));
        if let (Some((ends, _)), Some(palm)) = (&parts.hands, self.patches.first()) {
            let [a, b] = ends.frames.map(name);
            let [x, y] = palm.half_size;
            out.push(format!(
                "hands: {a}, {b} ({}); palms {:.0} x {:.0} mm",
                how(ends.named, "ends of two limbs of", ends.pair.len()),
                2e3 * x,
                2e3 * y
            ));
        } else {
            out.push(
                "hands: none, no two other limbs of at least 3 joints are like each other".into(),
            );
        }
        out.push(format!(
            "forward: {} ({})",
            parts.heading.axis.name(),
            parts.heading.how
        ));
        out.extend(self.about_home());
        out
    }

    /// What a scene has to say for the robot to look along x.
    pub fn about_facing(&self) -> Option<String> {
        let axis = self.parts.heading.axis;
        let yaw = axis.yaw_to_x();
        (yaw != 0.0).then(|| {
            format!(
                "The robot looks along {} of its base: in a scene it faces +x with start.yaw = {yaw:.5}.",
                axis.name()
            )
        })
    }

    /// The stance, in sentences.
    pub fn about_home(&self) -> Vec<String> {
        let stand = &self.stand;
        let mut out = vec![format!(
            "home: soles {:.3} m apart, the base {:.4} m above them, the centre of mass {:.1} mm from over their middle.",
            stand.stance.abs(),
            stand.base,
            1e3 * stand.com[0].hypot(stand.com[1]),
        )];
        if let Some(knees) = self.knees {
            let _ = write!(out[0], " Knees are bent by {:.2} rad.", knees.abs());
        }
        if let (Some((ends, _)), Some(angle)) = (&self.parts.hands, self.palm_angle()) {
            let height = self.hand_height(ends.frames[0]);
            out.push(format!(
                "Hands {height:.2} m above the soles; palms {:.0}° from facing inward.",
                angle.to_degrees()
            ));
        }
        out
    }

    /// What is to be checked by hand.
    pub fn doubts(&self) -> Vec<String> {
        let parts = self.parts;
        let mut out: Vec<String> = self.about_facing().into_iter().collect();
        out.extend(parts.doubts.iter().cloned());
        if self.knees.is_none() {
            out.push(
                "the legs have no three joints that turn about the same axis: knees are not bent in [home], do it by hand".into(),
            );
        }
        if self.palm_angle().is_some_and(|angle| angle.cos() < TURNED) {
            out.push("the palms do not face each other in [home]: the arms cannot, or another side of the hands is the palm".into());
        }
        let beside = self.stand.com[1];
        if beside.abs() > BESIDE {
            out.push(format!(
                "the centre of mass is {:.0} mm to the {} of the soles' middle: the robot is not the same left and right",
                1e3 * beside.abs(),
                if beside > 0.0 { "left" } else { "right" }
            ));
        }
        if let Some((distance, a, b)) = self.nearest.filter(|(distance, ..)| *distance < NEAR) {
            let [a, b] = [a, b].map(|j| parts.bodies.name(j));
            out.push(format!(
                "in [home] {a} and {b} are {:.0} mm apart: turn a joint of [home] if they can be further",
                1e3 * distance
            ));
        }
        if !self.patches.is_empty() {
            out.push(
                "look whether the palms are on the right side of the hands, and what hands and wrists bear: max_force and max_moment are \
                 guesses"
                    .into(),
            );
        }
        out
    }

    fn kinematics(&self) -> Kinematics {
        let model = self.parts.bodies.model();
        let mut kinematics = Kinematics::new(model);
        kinematics.update(model, self.q);
        kinematics
    }

    /// Largest angle of a palm from inward [rad].
    fn palm_angle(&self) -> Option<f64> {
        let model = self.parts.bodies.model();
        let kinematics = self.kinematics();
        let left = &self.parts.heading.left;
        let angles = self.patches.iter().zip([-1.0, 1.0]).map(|(palm, sign)| {
            let pose = kinematics.frame_pose(model, palm.frame) * palm.frame_from_patch;
            (sign * pose.rotation().column(2).dot(left))
                .clamp(-1.0, 1.0)
                .acos()
        });
        angles.reduce(f64::max)
    }

    fn hand_height(&self, frame: usize) -> f64 {
        let pose = self
            .kinematics()
            .frame_pose(self.parts.bodies.model(), frame);
        pose.origin().z + self.stand.base
    }
}
