//! Fewer triangles: edges shrink to points, those first that change the surface least, until all surfaces fit into a size.
//!
//! All surfaces are one problem, so that each keeps triangles where it needs them.
//! Source: as [`super::quadric`]; planes count with the area of their triangle.

use super::quadric::Quadric;
use super::surface::{Surface, twice_area};
use nalgebra::Vector3;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// No edge shrinks that moves the surface further [m].
const FARTHEST: f64 = 0.01;

/// Weight of a plane that holds an open rim in its place, relative to that of a triangle.
const RIM: f64 = 10.0;

/// A triangle turns by less when an edge shrinks: the cosine.
const LEAST_COSINE: f64 = 0.3;

/// Bytes of a place: three whole numbers of 16 bits.
const PLACE: usize = 6;

/// Bytes of a surface with so many places and faces.
pub(super) fn bytes(places: usize, faces: usize) -> usize {
    PLACE * places + 3 * index_bytes(places) * faces
}

/// Bytes of an index into so many places.
pub(super) fn index_bytes(places: usize) -> usize {
    if places <= 1 << 16 { 2 } else { 4 }
}

/// Simplifies until all together take at most `budget` bytes; false if they do not fit without being spoilt.
pub(super) fn simplify(surfaces: &mut [Surface], budget: usize) -> bool {
    let size = |surface: &Surface| bytes(surface.places.len(), surface.faces.len());
    if surfaces.iter().map(size).sum::<usize>() <= budget {
        return true;
    }
    let mut net = Net::new(surfaces);
    let fits = net.shrink(budget);
    for (surface, simpler) in surfaces.iter_mut().zip(net.surfaces()) {
        *surface = simpler;
    }
    fits
}

/// An edge that may shrink.
#[derive(Debug)]
struct Edge {
    /// Q at the place that is left.
    cost: f64,
    ends: [usize; 2],
    /// Of the ends, when the cost was computed: an edge of changed ends is stale.
    ages: [u32; 2],
}

impl Ord for Edge {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_cost = self.cost.total_cmp(&other.cost);
        by_cost.then_with(|| (self.ends, self.ages).cmp(&(other.ends, other.ages)))
    }
}

impl PartialOrd for Edge {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Edge {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Edge {}

/// All surfaces while they shrink.
struct Net {
    places: Vec<Vector3<f64>>,
    quadrics: Vec<Quadric>,
    /// How often a place changed; `None`: it is gone.
    ages: Vec<Option<u32>>,
    /// Faces at a place; some may be gone.
    around: Vec<Vec<usize>>,
    /// `None`: gone.
    faces: Vec<Option<[usize; 3]>>,
    /// Surface of a face.
    owner: Vec<usize>,
    /// Per surface: places and faces that are left.
    left: Vec<[usize; 2]>,
    edges: BinaryHeap<Reverse<Edge>>,
}

impl Net {
    fn new(surfaces: &[Surface]) -> Self {
        let mut net = Self {
            places: Vec::new(),
            quadrics: Vec::new(),
            ages: Vec::new(),
            around: Vec::new(),
            faces: Vec::new(),
            owner: Vec::new(),
            left: Vec::new(),
            edges: BinaryHeap::new(),
        };
        for (i, surface) in surfaces.iter().enumerate() {
            let first = net.places.len();
            net.places.extend(&surface.places);
            let faces = surface.faces.iter();
            net.faces
                .extend(faces.map(|face| Some(face.map(|x| first + x as usize))));
            net.owner.resize(net.faces.len(), i);
            net.left.push([surface.places.len(), surface.faces.len()]);
        }
        net.ages.resize(net.places.len(), Some(0));
        net.around.resize(net.places.len(), Vec::new());
        net.quadrics.resize(net.places.len(), Quadric::ZERO);
        net.measure();
        net
    }

    /// Sums up the planes at every place, and queues all edges.
    fn measure(&mut self) {
        let mut sides = Vec::with_capacity(3 * self.faces.len());
        for (i, face) in self.faces.iter().enumerate() {
            let Some(face) = *face else { continue };
            let twice = twice_area(&face.map(|x| self.places[x]));
            let normal = twice.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
            let plane = Quadric::plane(&normal, &self.places[face[0]], twice.norm() / 2.0);
            for k in 0..3 {
                self.quadrics[face[k]] += plane;
                self.around[face[k]].push(i);
                let [from, to] = [face[k], face[(k + 1) % 3]];
                sides.push(([from.min(to), from.max(to)], normal));
            }
        }
        sides.sort_by_key(|(ends, _)| *ends);
        for group in sides.chunk_by(|x, y| x.0 == y.0) {
            let (ends, normal) = group[0];
            if group.len() == 1 {
                self.hold_rim(ends, &normal);
            }
        }
        sides.dedup_by_key(|(ends, _)| *ends);
        for (ends, _) in sides {
            self.queue(ends);
        }
    }

    /// A plane through an edge of one face alone, upright on it.
    fn hold_rim(&mut self, ends: [usize; 2], normal: &Vector3<f64>) {
        let [from, to] = ends.map(|x| self.places[x]);
        let along = to - from;
        if let Some(aside) = along.cross(normal).try_normalize(0.0) {
            let plane = Quadric::plane(&aside, &from, RIM * along.norm_squared());
            for end in ends {
                self.quadrics[end] += plane;
            }
        }
    }

    /// Sum of the quadrics of two places, and where an edge between them is best shrunk to.
    fn target(&self, ends: [usize; 2]) -> (Quadric, Vector3<f64>) {
        let mut quadric = self.quadrics[ends[0]];
        quadric += self.quadrics[ends[1]];
        let middle = (self.places[ends[0]] + self.places[ends[1]]) / 2.0;
        (quadric, quadric.best(&middle))
    }

    fn queue(&mut self, ends: [usize; 2]) {
        let (quadric, place) = self.target(ends);
        let cost = quadric.value(&place);
        if let [Some(a), Some(b)] = ends.map(|x| self.ages[x])
            && quadric.distance(cost) <= FARTHEST
        {
            let ages = [a, b];
            self.edges.push(Reverse(Edge { cost, ends, ages }));
        }
    }

    fn size(&self) -> usize {
        self.left.iter().map(|[v, f]| bytes(*v, *f)).sum()
    }

    fn shrink(&mut self, budget: usize) -> bool {
        while self.size() > budget {
            let Some(Reverse(edge)) = self.edges.pop() else {
                return false;
            };
            if edge.ends.map(|x| self.ages[x]) == edge.ages.map(Some) {
                self.try_edge(edge.ends);
            }
        }
        true
    }

    /// Shrinks an edge, unless a triangle would turn over.
    fn try_edge(&mut self, [kept, gone]: [usize; 2]) {
        let (quadric, place) = self.target([kept, gone]);
        if self.turns(kept, gone, &place) || self.turns(gone, kept, &place) {
            return;
        }
        self.quadrics[kept] = quadric;
        self.places[kept] = place;
        self.ages[kept] = self.ages[kept].map(|age| age + 1);
        self.ages[gone] = None;
        let moved = std::mem::take(&mut self.around[gone]);
        let mut owner = None;
        for i in moved {
            let Some(face) = &mut self.faces[i] else {
                continue;
            };
            owner = Some(self.owner[i]);
            if face.contains(&kept) {
                self.faces[i] = None;
                self.left[self.owner[i]][1] -= 1;
            } else {
                *face = face.map(|x| if x == gone { kept } else { x });
                self.around[kept].push(i);
            }
        }
        if let Some(owner) = owner {
            self.left[owner][0] -= 1;
        }
        let faces = &self.faces;
        self.around[kept].retain(|i| faces[*i].is_some());
        let mut near: Vec<_> = self.around[kept]
            .iter()
            .flat_map(|i| self.faces[*i].into_iter().flatten())
            .filter(|x| *x != kept)
            .collect();
        near.sort_unstable();
        near.dedup();
        for other in near {
            self.queue([kept.min(other), kept.max(other)]);
        }
    }

    /// True if moving `from` to `place` turns a triangle that does not have `other`, or takes its area.
    fn turns(&self, from: usize, other: usize, place: &Vector3<f64>) -> bool {
        let faces = self.around[from].iter().filter_map(|i| self.faces[*i]);
        let mut stay = faces.filter(|face| !face.contains(&other));
        stay.any(|face| {
            let before = twice_area(&face.map(|x| self.places[x]));
            let after = twice_area(&face.map(|x| if x == from { *place } else { self.places[x] }));
            after.dot(&before) <= LEAST_COSINE * after.norm() * before.norm()
        })
    }

    /// What is left, surface by surface.
    fn surfaces(&self) -> Vec<Surface> {
        let mut faces = vec![Vec::new(); self.left.len()];
        for (face, owner) in self.faces.iter().zip(&self.owner) {
            faces[*owner].extend(face.map(|face| face.map(|x| x as u32)));
        }
        // Numbers of places go over all surfaces until each is made compact.
        let places = &self.places;
        faces
            .into_iter()
            .map(|faces| Surface::compact_of(places, faces))
            .collect()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// A closed ball of so many parts around and half as many from pole to pole.
    pub fn ball(radius: f64, around: u32) -> Surface {
        let down = around / 2;
        let place = |i: u32, j: u32| {
            let polar = PI * f64::from(i) / f64::from(down);
            let azimuth = 2.0 * PI * f64::from(j % around) / f64::from(around);
            // At the poles all are one place, to the bit.
            let ring = if i.is_multiple_of(down) {
                0.0
            } else {
                polar.sin()
            };
            let [x, y] = [ring * azimuth.cos(), ring * azimuth.sin()];
            Vector3::new(x, y, polar.cos()).add_scalar(0.0) * radius
        };
        let mut places = Vec::new();
        for i in 0..down {
            for j in 0..around {
                let [a, b, c, d] =
                    [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| place(i, j));
                places.extend([a, b, c, a, c, d]);
            }
        }
        let faces: Vec<_> = (0..places.len() as u32 / 3)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect();
        Surface::welded(&places, &faces)
    }

    fn size(surfaces: &[Surface]) -> usize {
        let one = |x: &Surface| bytes(x.places.len(), x.faces.len());
        surfaces.iter().map(one).sum()
    }

    #[test]
    fn what_fits_stays_as_it_is() {
        let before = [ball(0.1, 20)];
        let mut after = before.clone();
        assert!(simplify(&mut after, size(&before)));
        assert_eq!(after, before);
    }

    #[test]
    fn a_ball_stays_a_ball_with_a_tenth_of_its_triangles() {
        let mut surfaces = [ball(0.1, 80)];
        let budget = size(&surfaces) / 10;
        assert!(simplify(&mut surfaces, budget));
        let [ball] = &surfaces;
        assert!(size(&surfaces) <= budget && size(&surfaces) > budget - 100);
        let mut volume = 0.0;
        for face in &ball.faces {
            let [a, b, c] = ball.corners(face);
            volume += a.dot(&b.cross(&c)) / 6.0;
        }
        let exact = 4.0 / 3.0 * PI * 0.1f64.powi(3);
        assert!((volume / exact - 1.0).abs() < 0.02, "closed: {volume}");
        for place in &ball.places {
            assert!((place.norm() / 0.1 - 1.0).abs() < 0.02, "{place}");
        }
    }

    #[test]
    fn flat_and_straight_parts_go_first() {
        // A plate of 20 × 20 squares beside a ball: the plate can do with two triangles, its rim stays.
        let mut places = Vec::new();
        let mut faces = Vec::new();
        let at = |i: u32, j: u32| i * 21 + j;
        for i in 0..21 {
            for j in 0..21 {
                places.push(Vector3::new(f64::from(i) * 0.02, f64::from(j) * 0.02, 0.0));
                if i > 0 && j > 0 {
                    faces.push([at(i - 1, j - 1), at(i, j - 1), at(i, j)]);
                    faces.push([at(i - 1, j - 1), at(i, j), at(i - 1, j)]);
                }
            }
        }
        let round = ball(0.1, 30);
        let mut surfaces = [Surface::welded(&places, &faces), round.clone()];
        let budget = bytes(round.places.len(), round.faces.len()) + 300;
        assert!(simplify(&mut surfaces, budget));
        assert_eq!(surfaces[1], round);
        let area: f64 = surfaces[0]
            .faces
            .iter()
            .map(|face| twice_area(&surfaces[0].corners(face)).norm() / 2.0)
            .sum();
        assert!((area - 0.16).abs() < 1e-4, "{area}");
    }

    #[test]
    fn what_would_be_spoilt_does_not_fit() {
        assert!(!simplify(&mut [ball(1.0, 40)], 200));
    }
}
