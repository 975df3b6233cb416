//! A surface of triangles that share their corners.

use nalgebra::Vector3;
use std::collections::BTreeMap;

/// A corner: place [m] and unit normal.
pub(crate) type Corner = (Vector3<f64>, Vector3<f64>);

/// A triangle.
pub(crate) type Triangle = [Corner; 3];

/// Faces that meet at a smaller angle are shaded as one round surface: its cosine, of 40°. As in viewer/src/scene/mesh.ts.
const CREASE: f64 = 0.766;

/// Places [m] and the triangles between them.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Surface {
    pub places: Vec<Vector3<f64>>,
    /// Indices into the places, counter-clockwise from outside.
    pub faces: Vec<[u32; 3]>,
}

impl Surface {
    /// Puts equal places together and leaves out triangles without area.
    pub fn welded(places: &[Vector3<f64>], faces: &[[u32; 3]]) -> Self {
        let before = |i: usize, j: usize| {
            let by_axis = (0..3).map(|k| places[i][k].total_cmp(&places[j][k]));
            by_axis.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
        };
        let mut order: Vec<usize> = (0..places.len()).collect();
        order.sort_unstable_by(|i, j| before(*i, *j).then(i.cmp(j)));
        // The first of equal places, in the order of the file, stands for all.
        let mut first: Vec<usize> = (0..places.len()).collect();
        for pair in order.windows(2) {
            if before(pair[0], pair[1]).is_eq() {
                first[pair[1]] = first[pair[0]];
            }
        }
        let faces = faces
            .iter()
            .map(|face| face.map(|corner| first[corner as usize] as u32))
            .filter(|[a, b, c]| a != b && b != c && c != a);
        Self::compact_of(places, faces)
    }

    /// The surface of some faces, without the places that none of them has, numbered as faces meet them.
    pub fn compact_of(places: &[Vector3<f64>], faces: impl IntoIterator<Item = [u32; 3]>) -> Self {
        let mut number = BTreeMap::new();
        let mut compact = Self::default();
        for face in faces {
            compact.faces.push(face.map(|corner| {
                *number.entry(corner).or_insert_with(|| {
                    compact.places.push(places[corner as usize]);
                    compact.places.len() as u32 - 1
                })
            }));
        }
        compact
    }

    /// The corners of a triangle.
    pub fn corners(&self, face: &[u32; 3]) -> [Vector3<f64>; 3] {
        face.map(|corner| self.places[corner as usize])
    }

    /// Triangles with normals: round where faces meet at a small angle, with an edge elsewhere.
    pub fn triangles(&self) -> Vec<Triangle> {
        let normals: Vec<_> = self
            .faces
            .iter()
            .map(|face| twice_area(&self.corners(face)))
            .collect();
        let mut around = vec![Vec::new(); self.places.len()];
        for (i, face) in self.faces.iter().enumerate() {
            for corner in face {
                around[*corner as usize].push(i);
            }
        }
        let normal = |face: usize, corner: u32| {
            let own = &normals[face];
            let near = around[corner as usize]
                .iter()
                .map(|i| &normals[*i])
                .filter(|x| x.dot(own) >= CREASE * x.norm() * own.norm());
            let sum: Vector3<f64> = near.sum();
            sum.try_normalize(0.0).unwrap_or_else(Vector3::z)
        };
        let triangle = |i: usize| self.faces[i].map(|x| (self.places[x as usize], normal(i, x)));
        (0..self.faces.len()).map(triangle).collect()
    }
}

/// Normal of a triangle, twice as long as its area [m²].
pub(super) fn twice_area([a, b, c]: &[Vector3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A cube of edge 2 about the origin, every triangle with corners of its own, as in STL files.
    pub fn cube() -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
        let mut places = Vec::new();
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let n = Vector3::ith(axis, sign);
                let u = Vector3::ith((axis + 1) % 3, 1.0);
                let v = n.cross(&u);
                for (x, y) in [
                    (-1.0, -1.0),
                    (1.0, -1.0),
                    (1.0, 1.0),
                    (-1.0, -1.0),
                    (1.0, 1.0),
                    (-1.0, 1.0),
                ] {
                    places.push(n + u * x + v * y);
                }
            }
        }
        let faces = (0..places.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        let faces = faces.collect();
        (places, faces)
    }

    #[test]
    fn a_welded_cube_has_eight_corners_and_twelve_triangles() {
        let (places, mut faces) = cube();
        faces.push([0, 0, 1]);
        let cube = Surface::welded(&places, &faces);
        assert_eq!((cube.places.len(), cube.faces.len()), (8, 12));
        let outward = |face: &[u32; 3]| {
            let corners = cube.corners(face);
            twice_area(&corners).dot(&corners.iter().sum()) > 0.0
        };
        assert!(cube.faces.iter().all(outward));
    }

    #[test]
    fn a_cube_keeps_its_edges_and_a_ball_is_round() {
        let (places, faces) = cube();
        for triangle in Surface::welded(&places, &faces).triangles() {
            for (_, normal) in triangle {
                assert_eq!(normal.amax(), 1.0, "along an axis");
            }
        }
        // A ball of 40 × 20 parts: triangles meet at some 9°.
        let ball = super::super::simplify::tests::ball(1.0, 40);
        for (place, normal) in ball.triangles().into_iter().flatten() {
            assert!(normal.dot(&place) > 0.995, "{normal}, at {place}");
        }
    }
}
