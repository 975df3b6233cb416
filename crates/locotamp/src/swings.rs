//! How many foot swings the ways of a scene take: what limits the length of sequences, and which are hardly long enough.

use nalgebra::Vector2;
use ocp::Ways;
use scene::{Interface, Owner, RegionGoal, Role, Scene};

/// Phases of a foot swing.
pub(crate) const PHASES_PER_SWING: usize = 2;
/// The base's way by one swing as a rule, and at most; and the way to a surface or object that takes none, since arms and legs reach as
/// far: in heights of the base over the feet (0.25, 0.4 and 0.5 m for a G1).
const SWING: f64 = 0.324;
const LONG_SWING: f64 = 0.52;
const REACH: f64 = 0.65;
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
    /// Height of the base over the feet [m].
    height: f64,
}

impl<'a> Swings<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        let start = |i: usize| scene.start.get(i).copied().unwrap_or(0.0);
        Self {
            scene,
            ways: Ways::new(scene),
            base: Place::new(start(0), start(1)),
            height: ocp::base_height(scene),
        }
    }

    /// Swings that are needed beyond those of the default limit: to the objects of the goal and on to their places, to places and
    /// regions of the robot, and, without a goal, to the farthest object or bounded surface.
    pub fn beyond_default(&self) -> usize {
        let scene = self.scene;
        let swings = |from, to| self.to_reach(self.ways.length(from, to), REACH, SWING);
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
            let swings = self.swings_to(region, SWING);
            more += if scene.goal_contacts.is_empty() {
                swings.saturating_sub(SWINGS_OF_NOTHING)
            } else if self.way_to(region) > 0.0 {
                swings.max(SWINGS_OF_NOTHING)
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
        let swings = regions.map(|region| self.swings_to(region, LONG_SWING));
        swings.max().unwrap_or(0)
    }

    /// Swings for a way [m] of which so much takes none, with so much by one (heights of the base).
    fn to_reach(&self, way: f64, reach: f64, by_one: f64) -> usize {
        let beyond = way / self.height - reach;
        (beyond / by_one).ceil().max(0.0) as usize
    }

    /// Swings until what a region is for is in it, if the base gets so far by one (heights of the base). A foot makes twice the way of
    /// the base and stands where it is until the other one has landed, so that both swing as often; the base itself, and hands, lean
    /// forward by what one swing makes; objects are carried by arms that reach.
    fn swings_to(&self, region: &RegionGoal, by_one: f64) -> usize {
        let way = self.way_to(region);
        if self.scene.objects.iter().any(|o| o.name == region.body) {
            self.to_reach(way, REACH, by_one)
        } else if self.is_foot(&region.body) {
            2 * self.to_reach(way, 0.0, 2.0 * by_one)
        } else {
            self.to_reach(way, by_one, by_one)
        }
    }

    /// Is it the name of a foot, or of its link.
    fn is_foot(&self, name: &str) -> bool {
        let frames = &self.scene.robot.model.frames;
        let mut feet = (self.scene.interfaces.iter()).filter(|i| i.role == Role::Foot);
        feet.any(|foot| match foot.owner {
            Owner::Robot { frame } => foot.name == name || frames[frame].name == name,
            _ => false,
        })
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

    /// The way of what a region is for from the start, of the base for parts of the robot, to the nearest place in the region [m].
    fn way_to(&self, region: &RegionGoal) -> f64 {
        let object = self.scene.objects.iter().find(|o| o.name == region.body);
        let now = object.map_or(self.base, |o| o.world_from_start.origin().xy());
        let to = now.sup(&region.lower.xy()).inf(&region.upper.xy());
        self.ways.length(now, to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// Swings as a rule and at least into a region of a body, from `x` on, of a scene where the robot has room.
    fn swings(body: &str, x: f64) -> [usize; 2] {
        let region = format!(
            "[[goal.region]]\nbody = \"{body}\"\nx = [{x}, {}]\n",
            x + 0.3
        );
        let text = format!(
            "name = \"s\"\nrobot = \"g1\"\n[[static]]\nname = \"ground\"\nplane = true\n{region}"
        );
        let scene = Scene::from_toml(&text, "s.toml", Path::new(".")).expect("a scene");
        let swings = Swings::new(&scene);
        [SWINGS_OF_NOTHING + swings.beyond_default(), swings.fewest()]
    }

    #[test]
    fn feet_swing_in_turns_until_both_are_there() {
        // By half a metre as a rule, by 0.8 m at most.
        assert_eq!(swings("left_foot", 1.4), [6, 4]);
        assert_eq!(swings("right_ankle_roll_link", 1.4), [6, 4]);
        assert_eq!(swings("left_foot", 0.6), [SWINGS_OF_NOTHING, 2]);
        assert_eq!(swings("left_foot", -0.1), [SWINGS_OF_NOTHING, 0]);
    }

    #[test]
    fn the_base_is_there_one_swing_before_its_feet() {
        assert_eq!(swings("base", 1.4), [5, 3]);
        assert_eq!(swings("left_hand", 1.4), [5, 3]);
    }

    #[test]
    fn small_robots_take_more_swings() {
        let scene = Scene::builtin("side-step").expect("a built-in scene");
        let mut swings = Swings::new(&scene);
        let of_g1 = swings.to_reach(2.0, REACH, SWING);
        swings.height *= 0.5;
        let of_half = swings.to_reach(1.0, REACH, SWING);
        assert_eq!(of_g1, of_half);
        assert!(swings.to_reach(2.0, REACH, SWING) > of_g1);
    }
}
