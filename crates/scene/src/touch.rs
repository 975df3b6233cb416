//! How far two interfaces are from a contact of theirs, at given poses.
//!
//! Frames: `a` lands on `b`; `b`'s local z is its outward normal. Source: paper, contact constraints of the transcription.

use crate::Interface;
use spatial::Pose;
use symbolic::ContactType;

/// A start contact may miss by this much [m].
pub(crate) const POSITION_TOLERANCE: f64 = 1e-4;

/// The normals of a start contact may differ by this much [rad].
pub(crate) const ANGLE_TOLERANCE: f64 = 1e-3;

/// Distances of a pair from being in contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Touch {
    /// Origin of `a` above the plane of `b` [m].
    pub height: f64,
    /// Angle between the normal of `a` and the opposite of the normal of `b` [rad]; 0 for point contacts.
    pub angle: f64,
    /// How far `a` (its origin for points and with overhang) reaches beyond the rectangle of `b` [m]; 0 if inside.
    pub outside: f64,
    /// Cosine of the angle between the limb of `a` and the normal of `b`; negative if the limb comes from behind.
    pub limb: f64,
}

impl Touch {
    /// The pair at its poses in the world.
    pub fn measure(
        kind: ContactType,
        (a, world_from_a): (&Interface, &Pose),
        (b, world_from_b): (&Interface, &Pose),
    ) -> Self {
        let b_from_a = world_from_b.inverse() * *world_from_a;
        let r = b_from_a.rotation();
        let origin = b_from_a.origin();
        let angle = if kind.is_patch() {
            // both sine and cosine, so that small angles are exact
            (r[(0, 2)].hypot(r[(1, 2)])).atan2(-r[(2, 2)])
        } else {
            0.0
        };
        let inner = match a.half_size {
            Some([x, y]) if kind.is_patch() && !b.overhang => [
                r[(0, 0)].abs() * x + r[(0, 1)].abs() * y,
                r[(1, 0)].abs() * x + r[(1, 1)].abs() * y,
            ],
            _ => [0.0, 0.0],
        };
        let outside = match b.half_size {
            None => 0.0,
            Some(outer) => (0..2)
                .map(|i| origin[i].abs() + inner[i] - outer[i])
                .fold(0.0, f64::max),
        };
        Self {
            height: origin.z,
            angle,
            outside,
            limb: b_from_a.rotate(a.limb).z,
        }
    }

    /// True if the pair is in contact within the tolerances.
    pub fn holds(&self) -> bool {
        self.gap().is_none()
    }

    /// What keeps the pair from being in contact, in words and numbers.
    pub fn gap(&self) -> Option<String> {
        if self.angle > ANGLE_TOLERANCE {
            let degrees = self.angle.to_degrees();
            return Some(format!("the surfaces are {degrees:.2}° from parallel"));
        }
        if self.outside > POSITION_TOLERANCE {
            return Some(format!(
                "it reaches {} beyond the edge",
                millimetres(self.outside)
            ));
        }
        if self.height.abs() > POSITION_TOLERANCE {
            return Some(offset(self.height));
        }
        (self.limb < -ANGLE_TOLERANCE).then(|| "the limb comes from behind the surface".to_owned())
    }
}

/// "it is 3.1 mm above the surface".
pub(crate) fn offset(height: f64) -> String {
    if height > 0.0 {
        format!("it is {} above the surface", millimetres(height))
    } else {
        format!("it is {} below the surface", millimetres(-height))
    }
}

/// A length [m] in millimetres.
pub(crate) fn millimetres(length: f64) -> String {
    format!("{:.1} mm", length * 1e3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Owner, Role};
    use nalgebra::{Matrix3, Vector3};

    fn patch(half_size: Option<[f64; 2]>) -> Interface {
        Interface {
            name: "p".into(),
            owner: Owner::Static(0),
            role: Role::Surface,
            body_from_interface: Pose::identity(),
            patch: true,
            half_size,
            limb: -Vector3::z(),
            contact_types: vec![ContactType::UnilateralPatch],
            max_force: f64::INFINITY,
            max_moment: f64::INFINITY,
            mu: 0.5,
            mu_r: 0.0,
            overhang: false,
            bears_feet: true,
            lands: true,
        }
    }

    /// A face that looks down, its origin at (x, y, z).
    fn facing_down(x: f64, y: f64, z: f64) -> Pose {
        let flip = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0));
        Pose::from_parts(flip, Vector3::new(x, y, z))
    }

    fn measure(a: &Interface, world_from_a: Pose, b: &Interface) -> Touch {
        let kind = ContactType::UnilateralPatch;
        Touch::measure(kind, (a, &world_from_a), (b, &Pose::identity()))
    }

    #[test]
    fn a_face_on_a_face_holds_until_it_is_lifted_or_tilted_or_shifted() {
        let (a, b) = (patch(Some([0.05, 0.1])), patch(Some([0.2, 0.2])));
        assert!(measure(&a, facing_down(0.1, 0.1, 0.0), &b).holds());
        let lifted = measure(&a, facing_down(0.0, 0.0, 0.003), &b);
        assert_eq!(lifted.gap().unwrap(), "it is 3.0 mm above the surface");
        let sunk = measure(&a, facing_down(0.0, 0.0, -0.003), &b);
        assert_eq!(sunk.gap().unwrap(), "it is 3.0 mm below the surface");
        let beyond = measure(&a, facing_down(0.0, 0.13, 0.0), &b);
        assert_eq!(beyond.gap().unwrap(), "it reaches 30.0 mm beyond the edge");
        let upright = measure(&a, Pose::identity(), &b);
        assert!((upright.angle - std::f64::consts::PI).abs() < 1e-12);
    }

    #[test]
    fn a_turned_rectangle_reaches_as_far_as_its_corners() {
        let (a, b) = (patch(Some([0.1, 0.1])), patch(Some([0.1, 0.1])));
        let half = (std::f64::consts::FRAC_PI_8).sin_cos();
        let turn = Pose::from_xyzquat(&[0.0, 0.0, 0.0, 0.0, 0.0, half.0, half.1]);
        let touch = measure(&a, turn * facing_down(0.0, 0.0, 0.0), &b);
        assert!((touch.outside - 0.1 * (2f64.sqrt() - 1.0)).abs() < 1e-12);
    }

    #[test]
    fn with_overhang_only_the_origin_must_be_inside() {
        let (a, mut b) = (patch(Some([0.3, 0.3])), patch(Some([0.1, 0.1])));
        b.overhang = true;
        assert!(measure(&a, facing_down(0.09, 0.0, 0.0), &b).holds());
        assert!(!measure(&a, facing_down(0.11, 0.0, 0.0), &b).holds());
    }

    #[test]
    fn a_limb_from_behind_is_noticed() {
        let (mut a, b) = (patch(Some([0.01, 0.01])), patch(None));
        a.limb = Vector3::z();
        let gap = measure(&a, facing_down(0.0, 0.0, 0.0), &b).gap().unwrap();
        assert!(gap.contains("behind"), "{gap}");
    }
}
