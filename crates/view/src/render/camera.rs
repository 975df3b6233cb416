//! A pinhole camera.

use nalgebra::Vector3;

/// Nothing nearer than this is drawn [m].
const NEAR: f64 = 0.05;

/// Half the vertical angle of view: its tangent.
const TAN_HALF_ANGLE: f64 = 0.31;

/// Share of the picture that the scene fills.
const FILL: f64 = 0.9;

/// Where a picture is taken from.
#[derive(Debug, Clone)]
pub(crate) struct Camera {
    /// Place [m].
    pub eye: Vector3<f64>,
    right: Vector3<f64>,
    up: Vector3<f64>,
    /// Unit vector of the direction of view.
    forward: Vector3<f64>,
    /// Width over height.
    pub aspect: f64,
}

impl Camera {
    /// Looks along `-away` at all `points`, which fill the picture; its shape is that of what is seen, within `aspects`.
    pub fn framing(points: &[Vector3<f64>], away: &Vector3<f64>, aspects: [f64; 2]) -> Self {
        let away = away.normalize();
        let right = Vector3::z().cross(&away).normalize();
        let up = away.cross(&right);
        let sum: Vector3<f64> = points.iter().sum();
        let (mut center, mut distance) = (sum / points.len().max(1) as f64, 4.0);
        let mut aspect = 1.0;
        for _ in 0..30 {
            let mut low = [f64::INFINITY; 2];
            let mut high = [f64::NEG_INFINITY; 2];
            for point in points {
                let at = point - center;
                let depth = (distance - at.dot(&away)).max(NEAR);
                for (k, axis) in [right, up].iter().enumerate() {
                    let tangent = at.dot(axis) / depth;
                    (low[k], high[k]) = (low[k].min(tangent), high[k].max(tangent));
                }
            }
            let middle = [0, 1].map(|k| distance * (low[k] + high[k]) / 2.0);
            center += right * middle[0] + up * middle[1];
            let [wide, tall] = [0, 1].map(|k| (high[k] - low[k]) / 2.0);
            aspect = (wide / tall).clamp(aspects[0], aspects[1]);
            let filled = (wide / aspect).max(tall) / TAN_HALF_ANGLE;
            distance = (distance * filled / FILL).clamp(0.3, 100.0);
        }
        Self {
            eye: center + away * distance,
            right,
            up,
            forward: -away,
            aspect,
        }
    }

    /// Place in a picture of so many pixels, and depth [m]; `None`: too near or behind.
    pub fn project(&self, point: &Vector3<f64>, size: [usize; 2]) -> Option<[f64; 3]> {
        let at = point - self.eye;
        let depth = at.dot(&self.forward);
        let focal = size[1] as f64 / 2.0 / TAN_HALF_ANGLE;
        (depth > NEAR).then(|| {
            let x = size[0] as f64 / 2.0 + focal * at.dot(&self.right) / depth;
            [
                x,
                size[1] as f64 / 2.0 - focal * at.dot(&self.up) / depth,
                depth,
            ]
        })
    }

    /// Direction in which a pixel looks, of length one along the axis of view.
    pub fn ray(&self, [x, y]: [f64; 2], size: [usize; 2]) -> Vector3<f64> {
        let focal = size[1] as f64 / 2.0 / TAN_HALF_ANGLE;
        let [right, up] = [x - size[0] as f64 / 2.0, size[1] as f64 / 2.0 - y];
        self.forward + self.right * (right / focal) + self.up * (up / focal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_points_are_in_the_picture_and_fill_it() {
        let points: Vec<_> = (0..8)
            .map(|i| {
                Vector3::new(
                    f64::from(i & 1),
                    f64::from(i >> 1 & 1) * 0.4,
                    f64::from(i >> 2) * 1.3,
                )
            })
            .collect();
        let camera = Camera::framing(&points, &Vector3::new(1.0, -1.0, 0.4), [0.5, 2.0]);
        let size = [(400.0 * camera.aspect) as usize, 400];
        let seen: Vec<_> = points
            .iter()
            .map(|p| camera.project(p, size).unwrap())
            .collect();
        assert!(
            seen.iter()
                .all(|[x, y, _]| *x > 0.0 && *x < size[0] as f64 && *y > 0.0 && *y < 400.0)
        );
        let height = seen.iter().map(|s| s[1]).fold(0.0, f64::max)
            - seen.iter().map(|s| s[1]).fold(400.0, f64::min);
        assert!((height / 400.0 - FILL).abs() < 0.01, "{height}");
    }

    #[test]
    fn the_ray_of_a_pixel_meets_the_point_that_it_shows() {
        let points = [Vector3::zeros(), Vector3::new(0.3, 0.2, 1.0)];
        let camera = Camera::framing(&points, &Vector3::new(1.0, 0.3, 0.2), [1.0, 1.0]);
        let [x, y, depth] = camera.project(&points[1], [300, 300]).unwrap();
        let met = camera.eye + camera.ray([x, y], [300, 300]) * depth;
        assert!((met - points[1]).norm() < 1e-12);
    }
}
