//! Numbers of a file: finite, in range, unit quaternions.

use crate::source::{At, Source};
use crate::{Fault, SceneError};
use nalgebra::Vector3;
use spatial::Pose;
use std::ops::Range;

/// Quaternions may differ from unit length by this much; they are normalised.
const QUATERNION_TOLERANCE: f64 = 1e-3;

/// Coordinates beyond this are taken for mistakes [m].
const LARGEST_LENGTH: f64 = 1e4;

/// An orientation as written: by yaw, by quaternion, or not at all.
pub(crate) struct Orientation<'a> {
    pub yaw: Option<&'a At<f64>>,
    pub quaternion: Option<&'a At<[f64; 4]>>,
}

impl Source {
    /// A fault of the value at `span`.
    pub fn fault(&self, span: Range<usize>, fault: Fault) -> SceneError {
        SceneError::at(self.place(span), fault)
    }

    fn bad(&self, span: Range<usize>, what: &str, value: String, expected: &str) -> SceneError {
        let fault = Fault::Value {
            what: what.to_owned(),
            value,
            expected: expected.to_owned(),
        };
        self.fault(span, fault)
    }

    /// A fault of keys that do not go together.
    pub fn bad_keys(&self, span: Range<usize>, what: &str, problem: &str) -> SceneError {
        let fault = Fault::Keys {
            what: what.to_owned(),
            problem: problem.to_owned(),
        };
        self.fault(span, fault)
    }

    /// A finite number.
    pub fn finite(&self, what: &str, value: &At<f64>) -> Result<f64, SceneError> {
        if value.is_finite() {
            return Ok(**value);
        }
        Err(self.bad(value.span(), what, value.to_string(), "a finite number"))
    }

    /// A finite number above zero.
    pub fn positive(&self, what: &str, unit: &str, value: &At<f64>) -> Result<f64, SceneError> {
        if value.is_finite() && **value > 0.0 {
            return Ok(**value);
        }
        let shown = with_unit(**value, unit);
        Err(self.bad(value.span(), what, shown, "a positive number"))
    }

    /// A finite number, zero or above.
    pub fn not_negative(&self, what: &str, unit: &str, value: &At<f64>) -> Result<f64, SceneError> {
        if value.is_finite() && **value >= 0.0 {
            return Ok(**value);
        }
        let shown = with_unit(**value, unit);
        Err(self.bad(
            value.span(),
            what,
            shown,
            "a finite number that is not negative",
        ))
    }

    /// A positive limit, +∞ allowed; +∞ if not given.
    pub fn limit(
        &self,
        what: &str,
        unit: &str,
        value: Option<&At<f64>>,
    ) -> Result<f64, SceneError> {
        match value {
            None => Ok(f64::INFINITY),
            Some(value) if **value > 0.0 => Ok(**value),
            Some(value) => {
                let shown = with_unit(**value, unit);
                Err(self.bad(value.span(), what, shown, "a positive number"))
            }
        }
    }

    /// Positive lengths [m].
    pub fn sizes<const N: usize>(
        &self,
        what: &str,
        value: &At<[f64; N]>,
    ) -> Result<[f64; N], SceneError> {
        if value
            .iter()
            .all(|x| x.is_finite() && *x > 0.0 && *x < LARGEST_LENGTH)
        {
            return Ok(**value);
        }
        let shown = format!("{:?} m", **value);
        Err(self.bad(
            value.span(),
            what,
            shown,
            &format!("{N} positive numbers below {LARGEST_LENGTH}"),
        ))
    }

    /// Coordinates of a point [m] or any finite numbers of that magnitude.
    pub fn point(&self, what: &str, value: &At<[f64; 3]>) -> Result<Vector3<f64>, SceneError> {
        self.coordinates(what, value.span(), &**value)?;
        Ok(Vector3::from(**value))
    }

    /// Finite coordinates of a sensible magnitude [m].
    pub fn coordinates(
        &self,
        what: &str,
        span: Range<usize>,
        values: &[f64],
    ) -> Result<(), SceneError> {
        if values.iter().all(|x| x.abs() < LARGEST_LENGTH) {
            return Ok(());
        }
        let expected = format!("finite numbers below {LARGEST_LENGTH}");
        Err(self.bad(span, what, format!("{values:?}"), &expected))
    }

    /// A pose from a position and an orientation; no rotation if none is given.
    pub fn pose(
        &self,
        what: &str,
        position: Vector3<f64>,
        orientation: &Orientation,
    ) -> Result<Pose, SceneError> {
        let [x, y, z, w] = match (orientation.yaw, orientation.quaternion) {
            (Some(_), Some(quaternion)) => {
                return Err(self.bad_keys(
                    quaternion.span(),
                    what,
                    "both yaw and quaternion are given, expected one of them",
                ));
            }
            (Some(yaw), None) => {
                let (sin, cos) = (self.finite(&format!("yaw of {what}"), yaw)? / 2.0).sin_cos();
                [0.0, 0.0, sin, cos]
            }
            (None, Some(quaternion)) => {
                self.unit_quaternion(what, quaternion.span(), **quaternion)?
            }
            (None, None) => [0.0, 0.0, 0.0, 1.0],
        };
        let p = position;
        Ok(Pose::from_xyzquat(&[p.x, p.y, p.z, x, y, z, w]))
    }

    /// A pose from seven numbers.
    pub fn pose7(&self, what: &str, value: &At<[f64; 7]>) -> Result<Pose, SceneError> {
        let [x, y, z, qx, qy, qz, qw] = **value;
        self.coordinates(&format!("pose of {what}"), value.span(), &[x, y, z])?;
        self.unit_quaternion(what, value.span(), [qx, qy, qz, qw])?;
        Ok(Pose::from_xyzquat(&[x, y, z, qx, qy, qz, qw]))
    }

    fn unit_quaternion(
        &self,
        what: &str,
        span: Range<usize>,
        quaternion: [f64; 4],
    ) -> Result<[f64; 4], SceneError> {
        let norm = quaternion.iter().map(|c| c * c).sum::<f64>().sqrt();
        if (norm - 1.0).abs() <= QUATERNION_TOLERANCE {
            return Ok(quaternion);
        }
        let what = format!("quaternion [x, y, z, w] of {what}");
        let shown = format!("{quaternion:?} of length {norm:.4}");
        Err(self.bad(
            span,
            &what,
            shown,
            "length 1; [0, 0, 0, 1] means no rotation",
        ))
    }

    /// A count within a range.
    pub fn count(
        &self,
        what: &str,
        value: &At<usize>,
        range: std::ops::RangeInclusive<usize>,
    ) -> Result<usize, SceneError> {
        if range.contains(value) {
            return Ok(**value);
        }
        let expected = format!("a whole number from {} to {}", range.start(), range.end());
        Err(self.bad(value.span(), what, value.to_string(), &expected))
    }
}

fn with_unit(value: f64, unit: &str) -> String {
    if unit.is_empty() {
        value.to_string()
    } else {
        format!("{value} {unit}")
    }
}
