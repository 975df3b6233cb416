//! A patch of the robot in the making.

use spatial::Pose;

/// Decimals of positions, and of sizes, which are rounded down [m].
const PLACES: (i32, i32) = (6, 4);

/// Where a hand or foot touches.
#[derive(Debug, Clone)]
#[allow(
    clippy::struct_field_names,
    reason = "a pose is named by both of its frames"
)]
pub(crate) struct Patch {
    /// The link that carries it.
    pub frame: usize,
    /// Local z out of the link, x forward or along the hand.
    pub frame_from_patch: Pose,
    /// Half extents along the own x and y [m].
    pub half_size: [f64; 2],
}

impl Patch {
    /// The same with numbers as they are written in a file.
    #[must_use]
    pub fn rounded(self) -> Self {
        let [sizes, places] = [PLACES.1, PLACES.0].map(|n| 10f64.powi(n));
        let origin = (self.frame_from_patch.origin() * places).map(f64::round) / places;
        let rotation = *self.frame_from_patch.rotation();
        Self {
            frame: self.frame,
            frame_from_patch: Pose::from_parts(rotation, origin),
            half_size: self
                .half_size
                .map(|half| (half * sizes + 1e-6).floor() / sizes),
        }
    }

    /// Mean distance of the points of the patch from its middle [m]: the lever of uniform pressure in torsion.
    pub fn mean_radius(&self) -> f64 {
        let n = 40;
        let at = |i: usize| (i as f64 + 0.5) / n as f64;
        let [x, y] = self.half_size;
        let radii = (0..n).flat_map(|i| (0..n).map(move |j| (x * at(i)).hypot(y * at(j))));
        radii.sum::<f64>() / (n * n) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_radius_of_a_square_is_as_in_books() {
        let patch = Patch {
            frame: 0,
            frame_from_patch: Pose::identity(),
            half_size: [0.5, 0.5],
        };
        // (√2 + ln(1 + √2)) / 6 of the side
        assert!((patch.mean_radius() - 0.382_597_858).abs() < 1e-4);
    }
}
