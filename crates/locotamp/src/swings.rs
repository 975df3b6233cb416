//! How many foot swings the ways of a scene take: what limits the length of sequences, and which are hardly long enough.

use nalgebra::Vector2;
use ocp::Ways;
use scene::{Interface, Owner, RegionGoal, Scene};

/// Phases of a foot swing.
pub(crate) const PHASES_PER_SWING: usize = 2;
/// The base's way by one swing as a rule, and at most [m]; and the way that takes none, since arms and legs reach as far [m].
const SWING: f64 = 0.25;
const LONG_SWING: f64 = 0.4;
const REACH: f64 = 0.5;
/// Swings that [`symbolic::search::default_phases`] already counts: to an object or with it, per foot of the goal, and without
/// any goal contact. As many as the last are for a region that goes with goal contacts, however near.
const SWINGS_OF_OBJECT: usize = 4;
const SWINGS_OF_FOOT: usize = 2;
const SWINGS_OF_NOTHING: usize = 4;

type Place = Vector2<f64>;

/// Swings of a scene.
pub(crate) struct Swings<'a> {
    scene: &'a Scene,
    ways: Ways,
    base: Place,
}

impl<'a> Swings<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        let start = |i: usize| scene.start.get(i).copied().unwrap_or(0.0);
        Self {
            scene,
            ways: Ways::new(scene),
            base: Place::new(start(0), start(1)),
        }
    }

    /// Swings that are needed beyond those of the default limit: to the objects of the goal and on to their places, to places and
    /// regions of the robot, and, without a goal, to the farthest object or bounded surface.
    pub fn beyond_default(&self) -> usize {
        let scene = self.scene;
        let swings = |from, to| swings(self.ways.length(from, to), SWING);
        let mut more = 0;
        for goal in &scene.goal_contacts {
            let (a, b) = (&scene.interfaces[goal.a.0], &scene.interfaces[goal.b.0]);
            let Some(to) = self.place(b) else { continue };
            more += match self.place(a) {
                Some(object) => {
                    let swings = swings(self.base, object) + swings(object, to);
                    swings.saturating_sub(SWINGS_OF_OBJECT)
                }
                None => swings(self.base, to).saturating_sub(SWINGS_OF_FOOT),
            };
        }
        for region in &scene.goal_regions {
            let (from, to) = self.way_to(region);
            more += if scene.goal_contacts.is_empty() {
                swings(from, to).saturating_sub(SWINGS_OF_NOTHING)
            } else if from != to {
                swings(from, to).max(SWINGS_OF_NOTHING)
            } else {
                0
            };
        }
        if scene.goal_contacts.is_empty() && scene.goal_regions.is_empty() {
            let places = scene.interfaces.iter().filter_map(|i| self.place(i));
            let all = places.map(|p| swings(self.base, p));
            more += all.max().unwrap_or(0).saturating_sub(SWINGS_OF_NOTHING);
        }
        more
    }

    /// Swings without which the regions of a goal without contacts are hardly reached.
    pub fn fewest(&self) -> usize {
        if !self.scene.goal_contacts.is_empty() {
            return 0;
        }
        let regions = self.scene.goal_regions.iter();
        let ways = regions.map(|region| {
            let (from, to) = self.way_to(region);
            swings(self.ways.length(from, to), LONG_SWING)
        });
        ways.max().unwrap_or(0)
    }

    /// Where a surface or object is at the start; `None` of the robot and of what is everywhere.
    fn place(&self, interface: &Interface) -> Option<Place> {
        match interface.owner {
            Owner::Object(o) => Some(self.scene.objects[o].world_from_start.origin().xy()),
            Owner::Static(_) => interface
                .half_size
                .map(|_| interface.body_from_interface.origin().xy()),
            Owner::Robot { .. } => None,
        }
    }

    /// Where what a region is for is at the start, the base for parts of the robot, and the nearest place in the region.
    fn way_to(&self, region: &RegionGoal) -> (Place, Place) {
        let object = self.scene.objects.iter().find(|o| o.name == region.body);
        let now = object.map_or(self.base, |o| o.world_from_start.origin().xy());
        let to = now.sup(&region.lower.xy()).inf(&region.upper.xy());
        (now, to)
    }
}

/// Swings for a way [m] with so much by one [m].
fn swings(way: f64, by_one: f64) -> usize {
    ((way - REACH) / by_one).ceil().max(0.0) as usize
}
