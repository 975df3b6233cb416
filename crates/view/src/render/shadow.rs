//! The shadow of a distant light: depths along its rays, asked at several places around a point, so that edges are soft.

use nalgebra::Vector3;

/// Cells of the map in each direction.
const CELLS: usize = 900;

/// Places asked are this far apart [cells].
const SPREAD: f64 = 1.6;

/// A point is lit if nothing is nearer to the light by more than this [m].
const BIAS: f64 = 0.012;

/// Depths as the light sees them.
pub(crate) struct Shadow {
    /// Unit vector towards the light.
    pub towards: Vector3<f64>,
    axes: [Vector3<f64>; 2],
    low: [f64; 2],
    cells_per_metre: f64,
    /// Largest height along `towards`, per cell.
    height: Vec<f64>,
}

impl Shadow {
    /// An empty map over the `points` for light from the direction `towards`.
    pub fn new(points: &[Vector3<f64>], towards: &Vector3<f64>) -> Self {
        let towards = towards.normalize();
        let x = Vector3::z().cross(&towards).normalize();
        let axes = [x, towards.cross(&x)];
        let [mut low, mut high] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for point in points {
            for (k, axis) in axes.iter().enumerate() {
                let at = point.dot(axis);
                (low[k], high[k]) = (low[k].min(at - 0.1), high[k].max(at + 0.1));
            }
        }
        let span = (high[0] - low[0]).max(high[1] - low[1]).max(0.1);
        Self {
            towards,
            axes,
            low,
            cells_per_metre: CELLS as f64 / span,
            height: vec![f64::NEG_INFINITY; CELLS * CELLS],
        }
    }

    fn cell(&self, point: &Vector3<f64>) -> [f64; 2] {
        [0, 1].map(|k| (point.dot(&self.axes[k]) - self.low[k]) * self.cells_per_metre)
    }

    /// Enters a triangle.
    pub fn add(&mut self, corners: [Vector3<f64>; 3]) {
        let cells = corners.map(|corner| self.cell(&corner));
        let heights = corners.map(|corner| corner.dot(&self.towards));
        super::painter::cover(cells, [CELLS; 2], |x, y, weights| {
            let height: f64 = (0..3).map(|k| weights[k] * heights[k]).sum();
            let here = &mut self.height[y * CELLS + x];
            *here = here.max(height);
        });
    }

    /// How much of the light reaches a point, 0 to 1.
    pub fn light(&self, point: &Vector3<f64>) -> f64 {
        let [x, y] = self.cell(point);
        let height = point.dot(&self.towards);
        let mut lit = 0;
        for i in -2..=2 {
            for j in -2..=2 {
                let [u, v] = [x + SPREAD * f64::from(i), y + SPREAD * f64::from(j)];
                let inside = |w: f64| w >= 0.0 && w < CELLS as f64;
                let is_lit = !(inside(u) && inside(v))
                    || self.height[v as usize * CELLS + u as usize] < height + BIAS;
                lit += usize::from(is_lit);
            }
        }
        lit as f64 / 25.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plate_throws_a_shadow_below_itself_with_a_soft_edge() {
        let corner = |x: f64, y: f64| Vector3::new(x, y, 1.0);
        let points = [Vector3::new(-2.0, -2.0, 0.0), Vector3::new(2.0, 2.0, 1.0)];
        let mut shadow = Shadow::new(&points, &Vector3::new(1e-3, 0.0, 1.0));
        shadow.add([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0)]);
        shadow.add([corner(-1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
        assert_eq!(shadow.light(&Vector3::zeros()), 0.0);
        assert_eq!(shadow.light(&Vector3::new(1.5, 0.0, 0.0)), 1.0);
        assert_eq!(shadow.light(&Vector3::new(0.0, 0.0, 1.0)), 1.0);
        let edge = shadow.light(&Vector3::new(0.999, 0.0, 0.0));
        assert!(edge > 0.2 && edge < 0.8, "{edge}");
    }
}
