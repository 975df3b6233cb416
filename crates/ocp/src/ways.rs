//! Ways of the base around what stands between two places, as seen from above: guesses of walks, and how many steps these take.
//!
//! Shortest on a grid (Dijkstra 1959), where being near or in something static counts as a multiple of the way, then pulled straight.
//! What a leg steps over or a head passes under is in nobody's way. It guides, it forbids nothing.
//!
//! Source: ours.

use crate::program::Phase;
use nalgebra::{Vector2, Vector3};
use scene::{Owner, PlacedShape, Role, Scene, Shape};
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// Heights over the ground between which something is in the way, how far from its base a robot keeps from it, and the least
/// distance at which it may still pass, in heights of the base.
const LOW: f64 = 0.4;
const HIGH: f64 = 1.7;
const APART: f64 = 0.45;
const TIGHT: f64 = 0.2;
/// What a way inside something counts for: so many times its length more.
const INSIDE: f64 = 20.0;
/// Distance of grid points [m], most of them in one direction, and how far the grid reaches beyond everything [m].
const CELL: f64 = 0.1;
const MOST_CELLS: usize = 120;
const AROUND: f64 = 1.2;
/// Distance of places at which a straight way is looked at [m], and number of heights at which something is.
const SAMPLE: f64 = 0.05;
const HEIGHTS: usize = 14;
/// How much longer a way around something is at least than the straight one.
const BENDS: f64 = 1.02;
/// Moves of the base that count as the same [m].
const SAME: f64 = 1e-9;

type Place = Vector2<f64>;

/// Ways around what is static in a scene.
#[derive(Debug, Clone)]
pub struct Ways {
    /// With the static body that each belongs to.
    obstacles: Vec<(usize, PlacedShape)>,
    /// Height of the base over the ground, height of that [m].
    base: f64,
    ground: f64,
    corner: Place,
    cell: f64,
    counts: [usize; 2],
}

impl Ways {
    /// Of a scene as it is at the start.
    pub fn new(scene: &Scene) -> Self {
        let start = |i: usize| scene.start.get(i).copied().unwrap_or(0.0);
        let ground = ground(scene);
        let base = base_height(scene);
        let statics = scene.statics.iter().enumerate();
        let shapes = statics.flat_map(|(n, s)| s.shapes.iter().map(move |shape| (n, shape)));
        let in_the_way = |(_, s): &(usize, &PlacedShape)| {
            let (middle, half) = (s.body_from_shape.origin().z, half_height(s));
            middle + half > ground + LOW * base && middle - half < ground + HIGH * base
        };
        let solid = shapes.filter(|(_, s)| !matches!(s.shape, Shape::HalfSpace));
        let obstacles: Vec<(usize, PlacedShape)> = solid
            .filter(in_the_way)
            .map(|(n, shape)| (n, shape.clone()))
            .collect();
        let mut low = Place::new(start(0), start(1));
        let mut high = low;
        for (_, placed) in &obstacles {
            let middle = placed.body_from_shape.origin().xy();
            let reach = Place::repeat(radius(&placed.shape));
            low = low.inf(&(middle - reach));
            high = high.sup(&(middle + reach));
        }
        let size = high - low + Place::repeat(2.0 * AROUND);
        let cell = CELL.max(size.max() / MOST_CELLS as f64);
        Self {
            obstacles,
            base,
            ground,
            corner: low - Place::repeat(AROUND),
            cell,
            counts: [0, 1].map(|i| (size[i] / cell).ceil() as usize + 1),
        }
    }

    /// The same for a sequence: what a foot stands on in any of its states is in nobody's way.
    #[must_use]
    pub fn of(&self, scene: &Scene, phases: &[Phase]) -> Self {
        let stood_on = |n: usize| {
            let mut contacts = phases.iter().flat_map(|phase| phase.state.iter());
            contacts.any(|c| {
                let [foot, surface] = [c.a, c.b].map(|i| &scene.interfaces[i.0]);
                foot.role == Role::Foot && surface.owner == Owner::Static(n)
            })
        };
        let mut ways = self.clone();
        ways.obstacles.retain(|(n, _)| !stood_on(*n));
        ways
    }

    /// Length of the way from one place to another [m].
    pub fn length(&self, from: Place, to: Place) -> f64 {
        length(&self.between(from, to))
    }

    /// The way from one place to another: straight, or by corners where something is in between. Something in which an end lies is not.
    pub fn between(&self, from: Place, to: Place) -> Vec<Place> {
        if !self.is_blocked(from, to) {
            return vec![from, to];
        }
        let mut way = vec![from];
        way.extend(self.on_grid(from, to));
        way.push(to);
        self.pulled_straight(&way)
    }

    /// Leads bases along ways: where they go straight on from one configuration to the next, evenly, and something is in between.
    /// The first configurations, up to number `from`, stay.
    pub fn bend(&self, nodes: &mut [Vec<f64>], from: usize) {
        let place = |q: &[f64]| Place::new(q[0], q[1]);
        let mut first = from;
        while first + 1 < nodes.len() {
            let step = place(&nodes[first + 1]) - place(&nodes[first]);
            let goes_on = |n: &usize| {
                let next = place(&nodes[*n]) - place(&nodes[*n - 1]);
                (next - step).norm() < SAME
            };
            let last = first + (first + 1..nodes.len()).take_while(goes_on).count();
            let way = self.between(place(&nodes[first]), place(&nodes[last]));
            if way.len() > 2 {
                for n in first + 1..last {
                    let share = (n - first) as f64 / (last - first) as f64;
                    let there = at_share(&way, share);
                    nodes[n][..2].copy_from_slice(there.as_slice());
                }
            }
            first = last;
        }
    }

    /// Which of some configurations lie on a way around something: not straight between two others where the straight way is blocked.
    pub(crate) fn around(&self, nodes: &[Vec<f64>]) -> Vec<bool> {
        let places: Vec<Place> = nodes.iter().map(|q| Place::new(q[0], q[1])).collect();
        let mut around = vec![false; nodes.len()];
        for from in 0..places.len() {
            let mut way = 0.0;
            for to in from + 1..places.len() {
                way += (places[to] - places[to - 1]).norm();
                let bends = way > BENDS * (places[to] - places[from]).norm() + CELL;
                if bends
                    && !around[from + 1..to].iter().all(|&a| a)
                    && self.is_blocked(places[from], places[to])
                {
                    around[from + 1..to].fill(true);
                }
            }
        }
        around
    }

    /// Distance of an upright robot at a place from everything [m].
    fn clearance(&self, place: Place) -> f64 {
        let height = |n: usize| {
            let share = n as f64 / (HEIGHTS - 1) as f64;
            self.ground + self.base * (LOW + share * (HIGH - LOW))
        };
        let points = (0..HEIGHTS).map(|n| Vector3::new(place.x, place.y, height(n)));
        let nearest = |p: Vector3<f64>| self.obstacles.iter().map(move |(_, o)| distance(o, &p));
        points.flat_map(nearest).fold(f64::INFINITY, f64::min)
    }

    /// True if something is in the straight way but for what is around its ends.
    fn is_blocked(&self, from: Place, to: Place) -> bool {
        let free: Vec<bool> = samples(from, to)
            .map(|place| self.clearance(place) > TIGHT * self.base)
            .collect();
        let first = free.iter().position(|&free| free);
        let last = free.iter().rposition(|&free| free);
        let (Some(first), Some(last)) = (first, last) else {
            return false;
        };
        free[first..=last].contains(&false)
    }

    /// What a metre at a place counts for.
    fn weight(&self, place: Place) -> f64 {
        let missing = 1.0 - self.clearance(place) / (APART * self.base);
        1.0 + INSIDE * missing.clamp(0.0, 1.0)
    }

    /// What a straight way counts for.
    fn cost(&self, from: Place, to: Place) -> f64 {
        let weights: Vec<f64> = samples(from, to).map(|p| self.weight(p)).collect();
        (to - from).norm() * weights.iter().sum::<f64>() / weights.len() as f64
    }

    /// Grid points of the way that counts least.
    fn on_grid(&self, from: Place, to: Place) -> Vec<Place> {
        let [nx, ny] = self.counts;
        let cell_of = |p: Place| {
            let index = |i: usize| {
                let n = ((p[i] - self.corner[i]) / self.cell).round().max(0.0) as usize;
                n.min(self.counts[i] - 1)
            };
            index(0) * ny + index(1)
        };
        let place =
            |n: usize| self.corner + self.cell * Place::new((n / ny) as f64, (n % ny) as f64);
        let weights: Vec<f64> = (0..nx * ny).map(|n| self.weight(place(n))).collect();
        let (start, end) = (cell_of(from), cell_of(to));
        let mut before: Vec<Option<usize>> = vec![None; nx * ny];
        let mut queue = BinaryHeap::from([Reverse((Cost(0.0), start, start))]);
        while let Some(Reverse((Cost(cost), n, from))) = queue.pop() {
            if before[n].is_some() {
                continue;
            }
            before[n] = Some(from);
            if n == end {
                break;
            }
            let (x, y) = (n / ny, n % ny);
            for to_x in x.saturating_sub(1)..=(x + 1).min(nx - 1) {
                for to_y in y.saturating_sub(1)..=(y + 1).min(ny - 1) {
                    let next = to_x * ny + to_y;
                    let way = (place(next) - place(n)).norm();
                    let more = way * 0.5 * (weights[n] + weights[next]);
                    if before[next].is_none() {
                        queue.push(Reverse((Cost(cost + more), next, n)));
                    }
                }
            }
        }
        let mut way = vec![];
        let mut at = end;
        while at != start {
            way.push(place(at));
            at = before[at].unwrap_or(start);
        }
        way.push(place(start));
        way.reverse();
        way
    }

    /// The way without corners that straight lines spare.
    fn pulled_straight(&self, way: &[Place]) -> Vec<Place> {
        let parts: Vec<f64> = way.windows(2).map(|w| self.cost(w[0], w[1])).collect();
        let mut out = vec![way[0]];
        let mut at = 0;
        while at + 1 < way.len() {
            let spares = |&to: &usize| {
                let straight = self.cost(way[at], way[to]);
                straight <= parts[at..to].iter().sum::<f64>() + SAME
            };
            at = (at + 1..way.len()).rev().find(spares).unwrap_or(at + 1);
            out.push(way[at]);
        }
        out
    }
}

/// A cost, ordered.
#[derive(PartialEq)]
struct Cost(f64);

impl Eq for Cost {}

impl PartialOrd for Cost {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cost {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

fn length(way: &[Place]) -> f64 {
    way.windows(2).map(|w| (w[1] - w[0]).norm()).sum()
}

/// The place at a share of a way.
fn at_share(way: &[Place], share: f64) -> Place {
    let mut left = share * length(way);
    for w in way.windows(2) {
        let part = (w[1] - w[0]).norm();
        if left <= part {
            return w[0] + (w[1] - w[0]) * (left / part.max(SAME));
        }
        left -= part;
    }
    way[way.len() - 1]
}

/// Places along a straight line.
fn samples(from: Place, to: Place) -> impl Iterator<Item = Place> {
    let count = ((to - from).norm() / SAMPLE).ceil() as usize + 1;
    (0..=count).map(move |n| from + (to - from) * (n as f64 / count as f64))
}

/// Height of the base at the start above the highest surface on which a foot stands, at least a centimetre [m].
pub fn base_height(scene: &Scene) -> f64 {
    let base = scene.start.get(2).copied().unwrap_or(0.0);
    (base - ground(scene)).max(0.01)
}

/// Height of what the feet stand on at the start [m].
pub(crate) fn ground(scene: &Scene) -> f64 {
    let on = |c: &symbolic::Contact| {
        let [foot, surface] = [c.a, c.b].map(|i| &scene.interfaces[i.0]);
        let height = match surface.owner {
            Owner::Object(o) => {
                (scene.objects[o].world_from_start * surface.body_from_interface)
                    .origin()
                    .z
            }
            _ => surface.body_from_interface.origin().z,
        };
        (foot.role == Role::Foot).then_some(height)
    };
    let heights = scene.start_contacts.iter().filter_map(on);
    heights.reduce(f64::max).unwrap_or(0.0)
}

/// Radius of the ball around the middle of a shape [m].
fn radius(shape: &Shape) -> f64 {
    match shape {
        Shape::Box { half_size } => half_size.norm(),
        Shape::Capsule {
            radius,
            half_length,
        } => radius + half_length,
        Shape::Sphere { radius } => *radius,
        Shape::HalfSpace => 0.0,
    }
}

/// Half of the height of a shape as it is placed [m].
fn half_height(placed: &PlacedShape) -> f64 {
    let up = placed.body_from_shape.rotate_inverse(Vector3::z()).abs();
    match &placed.shape {
        Shape::Box { half_size } => up.dot(half_size),
        Shape::Capsule {
            radius,
            half_length,
        } => radius + half_length * up.z,
        Shape::Sphere { radius } => *radius,
        Shape::HalfSpace => f64::INFINITY,
    }
}

/// Distance of a point from a shape, 0 inside [m].
fn distance(placed: &PlacedShape, point: &Vector3<f64>) -> f64 {
    let p = placed.body_from_shape.inverse().act(*point);
    match &placed.shape {
        Shape::Box { half_size } => (p.abs() - half_size).sup(&Vector3::zeros()).norm(),
        Shape::Capsule {
            radius,
            half_length,
        } => {
            let along = p.z.clamp(-half_length, *half_length);
            ((p - along * Vector3::z()).norm() - radius).max(0.0)
        }
        Shape::Sphere { radius } => (p.norm() - radius).max(0.0),
        Shape::HalfSpace => f64::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// Ways on flat ground with one box of this size, its middle there.
    fn ways(size: [f64; 3], position: [f64; 3]) -> Ways {
        let text = format!(
            "name = \"s\"\nrobot = \"g1\"\n[[static]]\nname = \"ground\"\nplane = true\n[[static]]\nname = \"block\"\n\
             size = {size:?}\nposition = {position:?}\n[[goal.region]]\nbody = \"base\"\nx = [1.8, 2.0]\n"
        );
        Ways::new(&Scene::from_toml(&text, "s.toml", Path::new(".")).expect("a scene"))
    }

    const START: [f64; 2] = [0.0, 0.0];
    const BEHIND: [f64; 2] = [2.0, 0.0];

    #[test]
    fn a_way_leads_around_a_wall_and_keeps_away_from_it() {
        let ways = ways([0.1, 1.6, 1.0], [1.0, 0.2, 0.5]);
        let way = ways.between(START.into(), BEHIND.into());
        let straight_at_corner = 2.0 * 1.0_f64.hypot(0.6);
        assert!((straight_at_corner..3.0).contains(&length(&way)), "{way:?}");
        assert!(way.iter().all(|p| p.y < 1e-9), "the other side is farther");
        for pair in way.windows(2) {
            for place in samples(pair[0], pair[1]) {
                assert!(ways.clearance(place) > TIGHT * ways.base, "{place}");
            }
        }
    }

    #[test]
    fn nothing_is_in_the_way_that_is_low_high_or_around_an_end() {
        let straight = |size, position, to: [f64; 2]| {
            ways(size, position).between(START.into(), to.into()).len() == 2
        };
        assert!(!straight([0.3, 1.0, 0.6], [1.0, 0.0, 0.3], BEHIND));
        assert!(straight([0.3, 1.0, 0.2], [1.0, 0.0, 0.1], BEHIND));
        assert!(straight([0.3, 1.0, 0.2], [1.0, 0.0, 1.6], BEHIND));
        assert!(straight([0.3, 1.0, 0.6], [1.0, 0.0, 0.3], [1.0, 0.1]));
        assert!(straight([0.3, 1.0, 0.6], [1.0, 1.5, 0.3], BEHIND));
    }

    #[test]
    fn what_a_foot_stands_on_is_in_nobodys_way() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/around-table.toml");
        let scene = Scene::load(&path).expect("a scene");
        let interface = |name: &str| scene.interface_id(name).expect("an interface");
        let step = |on: &str| Phase {
            state: std::iter::once(symbolic::Contact {
                a: interface("left_foot"),
                b: interface(on),
                kind: symbolic::ContactType::UnilateralPatch,
            })
            .collect(),
            steps: 1,
        };
        let corners = |on: &str| {
            let ways = Ways::new(&scene).of(&scene, &[step("ground_top"), step(on)]);
            ways.between(START.into(), [1.4, 0.0].into()).len() - 2
        };
        assert!(corners("ground_top") > 0);
        assert_eq!(corners("table_top"), 0);
    }

    #[test]
    fn guesses_are_bent_evenly_where_something_is_in_between() {
        let ways = ways([0.1, 1.0, 1.0], [1.0, 0.1, 0.5]);
        let straight: Vec<Vec<f64>> = (0..=10).map(|n| vec![0.2 * f64::from(n), 0.0]).collect();
        let mut nodes = straight.clone();
        ways.bend(&mut nodes, 2);
        assert_eq!(nodes[..=2], straight[..=2]);
        assert_eq!(nodes[10], straight[10]);
        let step = |n: usize| (nodes[n][0] - nodes[n - 1][0]).hypot(nodes[n][1] - nodes[n - 1][1]);
        let even = ways.length([0.4, 0.0].into(), BEHIND.into()) / 8.0;
        assert!((3..=10).all(|n| step(n) <= even + 1e-9 && step(n) > 0.7 * even));
        let around = ways.around(&nodes);
        assert!(around[3..10].iter().all(|&a| a) && !around[10]);
        assert!(!ways.around(&straight).contains(&true));
    }
}
