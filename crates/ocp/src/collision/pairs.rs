//! Which pairs of bodies get rows (or a penalty) at which node, and with which balls.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::shared::Shared;
use super::{Ball, Clearances, CollisionModel, ExtraClearance, Other, Primitive, SelfPair, Touch};
use crate::program::{Grid, Phase, Program, landing};
use crate::settings::Preset;
use crate::terms::PoseTerm;
use crate::terms::distance::{Distance, EVENNESS, MOST_CLEARANCE, Obstacle, Part};
use crate::terms::sigmoid::Sigmoid;
use multibody::Kinematics;
use scene::Scene;
use spatial::Pose;

/// A pair of bodies nearer than this in the guide configurations gets a row [m].
pub(super) const NEAR: f64 = 0.15;
/// Sixteenths of a phase before and after a node of a motion whose guide configurations count for it: phases shift while
/// they are optimised.
const WINDOW: f64 = 2.0;
/// Configurations looked at on either side.
const WINDOW_SAMPLES: usize = 2;
/// What the smooth least distance may fall short of the true one where a keyframe must not be rejected [m].
pub(super) const BLUR: f64 = 1.4 * EVENNESS;
/// Clearance demanded at a contact of the same bodies, beside what its row says there, and its growth per sixteenth of a
/// phase away from it [m].
const RAMP: (f64, f64) = (-0.002, 0.008);
/// The most that is demanded at a contact [m].
const MOST_AT_CONTACT: f64 = -0.008;
/// Share of the clearance that is demanded of a hand and its wrist from what the object that it grasps or places stands on.
const THROUGH: f64 = 0.25;
/// Sixteenths of a phase after a body has left where it stands at the start in which what is near there may still be so.
const FROM_START: f64 = 6.0;
/// Slope of the sigmoid penalties of the paper preset [1/m] (the yardstick's).
const SIGMOID_SLOPE: f64 = 40.0;

/// One pair that gets rows (or a penalty) at a node.
#[derive(Debug, Clone)]
pub struct Pair {
    /// Node.
    pub node: usize,
    /// Joint that carries the balls.
    pub a: usize,
    /// Joint that carries the obstacle; `None` for the world.
    pub b: Option<usize>,
    /// Rows.
    pub term: Arc<dyn PoseTerm>,
}

/// The nearest contact of a pair in time.
#[derive(Debug, Clone, Copy)]
struct Since {
    /// Sixteenths of a phase between it and the node.
    parts: f64,
    /// Node of the contact.
    node: usize,
}

/// Guide configurations that count for a node, and how long ago pairs touched.
struct At<'a> {
    node: usize,
    kinematics: &'a [Kinematics],
    window: &'a [&'a Kinematics],
    since: &'a dyn Fn(usize, Other) -> Option<Since>,
    /// The same where the first one touches an object that touches the other.
    through: &'a dyn Fn(usize, Other) -> Option<Since>,
    /// Sixteenths of a phase since each body, and its neighbours, stopped standing where they stand at the start.
    from_start: &'a [f64],
}

impl At<'_> {
    /// True if the pair touches at the node.
    fn touches(&self, a: usize, other: Other) -> bool {
        (self.since)(a, other).is_some_and(|since| since.node == self.node)
    }
}

impl CollisionModel {
    /// All pairs that get rows.
    pub fn pairs(
        &self,
        program: &Program,
        scene: &Scene,
        phases: &[Phase],
        clearances: Clearances<'_>,
    ) -> Vec<Pair> {
        match clearances {
            Clearances::Near { nodes, extra } => {
                self.near_pairs(program, scene, phases, nodes, extra)
            }
            Clearances::Watched(watched) => self.watched_pairs(program, watched),
        }
    }

    /// Pairs that come near in one guide configuration per node.
    fn near_pairs(
        &self,
        program: &Program,
        scene: &Scene,
        phases: &[Phase],
        near: &[Vec<f64>],
        extra: &ExtraClearance,
    ) -> Vec<Pair> {
        let model = &program.system.model;
        let kinematics: Vec<Kinematics> = near
            .iter()
            .map(|q| {
                let mut kinematics = Kinematics::new(model);
                kinematics.update(model, q);
                kinematics
            })
            .collect();
        let n = program.n_intervals();
        let touching: Vec<_> = (0..=n)
            .map(|t| Self::touching(scene, program, phases, t))
            .collect();
        let along = program.along();
        let window = |t: usize| -> Vec<&Kinematics> {
            let width = match program.grid {
                Grid::Motion => {
                    let here = along[t.min(n - 1) + 1] - along[t.min(n - 1)];
                    (WINDOW / here).round().max(1.0) as usize
                }
                Grid::Path => 1,
                Grid::Keyframes | Grid::OpenKeyframes | Grid::State => 0,
            };
            let samples = WINDOW_SAMPLES.min(width);
            let mut nodes: Vec<usize> = (1..=samples)
                .map(|i| i * width / samples)
                .flat_map(|d| [t.saturating_sub(d), (t + d).min(n)])
                .chain([t])
                .collect();
            nodes.sort_unstable();
            nodes.dedup();
            nodes.into_iter().map(|i| &kinematics[i]).collect()
        };
        let leaves = self.leaves(&touching, &along);
        let (mut out, mut shared) = (Vec::new(), Shared::default());
        for t in 0..=n {
            if program.nodes[t].var.is_none() || program.master_node(t) != t {
                continue;
            }
            let nearest = |touch: &dyn Fn(usize) -> bool| -> Option<Since> {
                (0..=n)
                    .filter(|&i| touch(i))
                    .map(|node| Since {
                        parts: f64::abs(along[node] - along[t]),
                        node,
                    })
                    .min_by(|x, y| x.parts.total_cmp(&y.parts))
            };
            let since = |a: usize, other: Other| nearest(&|i| touching[i].contains(&(a, other)));
            let through = |a: usize, other: Other| {
                let touches = |i: usize, object: usize| {
                    touching[i].contains(&(a, Ok(object))) && touching[i].contains(&(object, other))
                };
                let objects = program.system.n_robot_joints..model.joints.len();
                nearest(&|i| objects.clone().any(|o| touches(i, o)))
            };
            let window = window(t);
            let at = At {
                node: t,
                kinematics: &kinematics,
                window: &window,
                since: &since,
                through: &through,
                from_start: &leaves
                    .iter()
                    .map(|left| along[t] - left)
                    .collect::<Vec<_>>(),
            };
            self.obstacle_pairs(program, &at, extra, &mut shared, &mut out);
            if program.settings.preset == Preset::Default {
                self.link_pairs(program, &at, &mut shared, &mut out);
            } else {
                self.link_penalties(&at, &mut out);
            }
        }
        out
    }

    /// Sixteenths of a phase at which each body, and its neighbours, no longer touch a static body that they touch from the start
    /// on: a foot that stands cannot get farther from what it stands beside.
    fn leaves(&self, touching: &[BTreeSet<Touch>], along: &[f64]) -> Vec<f64> {
        let mut stands: Vec<&Touch> = touching[0].iter().filter(|t| t.1.is_err()).collect();
        let mut own = vec![along[0]; self.balls.len()];
        for (there, &now) in touching.iter().zip(along) {
            stands.retain(|&touch| there.contains(touch));
            for &&(a, _) in &stands {
                own[a] = now;
            }
        }
        let latest = |a: usize| {
            let beside = self.neighbours[a].iter().map(|&j| own[j]);
            beside.fold(own[a], f64::max)
        };
        (0..own.len()).map(latest).collect()
    }

    /// Links and objects against objects and the environment.
    fn obstacle_pairs(
        &self,
        program: &Program,
        at: &At<'_>,
        extra: &ExtraClearance,
        shared: &mut Shared,
        out: &mut Vec<Pair>,
    ) {
        let paper = program.settings.preset == Preset::Paper;
        for a in 0..self.balls.len() {
            for (index, primitive) in self.primitives.iter().enumerate() {
                if primitive.joint == Some(a) || self.balls[a].is_empty() {
                    continue;
                }
                let Some(other) = primitive.joint.map(Ok).or(primitive.body.map(Err)) else {
                    continue;
                };
                if at.touches(a, other) {
                    continue;
                }
                let balls = if paper {
                    // The paper penalises end-effectors, objects and large boxes, not every link.
                    [&self.points[a][..], &self.link_points[a]].concat()
                } else {
                    self.balls_near(a, primitive, at.window)
                };
                if balls.is_empty() {
                    continue;
                }
                let (obstacle, obstacle_from_b) = (primitive.obstacle.clone(), primitive.from_body);
                let term: Arc<dyn PoseTerm> = if paper {
                    Arc::new(Sigmoid {
                        points: balls,
                        obstacle,
                        obstacle_from_b,
                        slope: SIGMOID_SLOPE,
                    })
                } else {
                    let more = extra.get(&(at.node, a, other)).copied().unwrap_or(0.0);
                    let clearance = self.clearance(program, a, primitive, other, at) + more;
                    let clearance = clearance.min(MOST_CLEARANCE);
                    let shapes = (balls, obstacle);
                    Arc::new(shared.row((a, Some(index)), shapes, obstacle_from_b, clearance))
                };
                out.push(Pair {
                    node: at.node,
                    a,
                    b: primitive.joint,
                    term,
                });
            }
        }
    }

    /// Clearance demanded of a body and a primitive: growing with the distance in time from where they touch, or where the
    /// body's neighbours in the limb do: a wrist is as near to a box as the hand that holds it makes it. The same from where a
    /// body has stood since the start, which may be nearer to something than a motion may come.
    fn clearance(
        &self,
        program: &Program,
        a: usize,
        primitive: &Primitive,
        other: Other,
        at: &At<'_>,
    ) -> f64 {
        if matches!(
            program.grid,
            Grid::Keyframes | Grid::OpenKeyframes | Grid::State
        ) {
            return -BLUR;
        }
        let margins = &program.settings.margins;
        let full = if self.feet[a] && primitive.joint.is_none() {
            margins.swing
        } else {
            margins.clearance
        };
        let own = (at.since)(a, other);
        let neighbours = self.neighbours[a].iter();
        // Neighbours are one part later on the ramp: no clearance, but no overlap either.
        let beside = neighbours
            .filter_map(|&j| (at.since)(j, other))
            .map(|since| Since {
                parts: since.parts + 1.0,
                ..since
            });
        let nearest = own
            .into_iter()
            .chain(beside)
            .min_by(|x, y| x.parts.total_cmp(&y.parts));
        let rise = |parts: f64| landing::rise(program, at.node, parts).unwrap_or(RAMP.1 * parts);
        let there = |node: usize| self.distance_at(a, primitive, &at.kinematics[node]) + RAMP.0;
        let mut demanded = full;
        if let Some(since) = nearest {
            demanded = full.min(there(since.node).min(MOST_AT_CONTACT) + rise(since.parts));
        }
        // Where an object that is held stands, the hand that holds it, and its wrist, is as near as the grasp makes it.
        let limb = self.neighbours[a].iter().copied().chain([a]);
        let through = limb.filter_map(|j| (at.through)(j, other));
        if let Some(since) = through.min_by(|x, y| x.parts.total_cmp(&y.parts)) {
            demanded = demanded.min(THROUGH * full + rise(since.parts));
        }
        if at.from_start[a] < FROM_START {
            demanded = demanded.min(there(0) + rise(at.from_start[a].max(0.0)));
        }
        demanded
    }

    /// What the row of a body and a primitive says in a configuration [m].
    fn distance_at(&self, a: usize, primitive: &Primitive, kinematics: &Kinematics) -> f64 {
        let row = Distance::new(
            self.balls[a].clone(),
            primitive.obstacle.clone(),
            Pose::identity(),
            0.0,
        );
        let mut value = [0.0];
        row.values(&primitive.pose_of_joint(kinematics, a), &mut value);
        value[0]
    }

    /// Balls of a body that come near a primitive in any of the configurations.
    fn balls_near(&self, a: usize, primitive: &Primitive, window: &[&Kinematics]) -> Vec<Ball> {
        let (centre, radius) = self.bounds[a];
        let poses: Vec<Pose> = window
            .iter()
            .map(|kinematics| primitive.pose_of_joint(kinematics, a))
            .filter(|x| primitive.obstacle.roughly_nearest(&x.act(centre)) - radius < NEAR)
            .collect();
        let near = |(c, r): &&Ball| {
            poses
                .iter()
                .any(|x| primitive.obstacle.roughly_nearest(&x.act(*c)) - r < NEAR)
        };
        self.balls[a].iter().filter(near).copied().collect()
    }

    /// The paper's penalties of end-effectors and objects against the boxes of torso, shins and forearms.
    fn link_penalties(&self, at: &At<'_>, out: &mut Vec<Pair>) {
        for a in 0..self.points.len() {
            if self.points[a].is_empty() {
                continue;
            }
            for b in 0..self.parts.len() {
                let near = a == b || self.neighbours[a].contains(&b) || at.touches(a, Ok(b));
                if near {
                    continue;
                }
                for part in &self.parts[b] {
                    let Part::Box(obstacle_from_b, half) = part else {
                        continue;
                    };
                    if half.max() < super::LARGE_BOX {
                        continue;
                    }
                    out.push(Pair {
                        node: at.node,
                        a,
                        b: Some(b),
                        term: Arc::new(Sigmoid {
                            points: self.points[a].clone(),
                            obstacle: Obstacle::Box(*half),
                            obstacle_from_b: *obstacle_from_b,
                            slope: SIGMOID_SLOPE,
                        }),
                    });
                }
            }
        }
    }

    /// Links of the robot against one another.
    fn link_pairs(&self, program: &Program, at: &At<'_>, shared: &mut Shared, out: &mut Vec<Pair>) {
        for (index, pair) in self.self_pairs.iter().enumerate() {
            let (near_a, near_b) = self.balls_near_link(pair, at.window);
            if near_a.is_empty() {
                continue;
            }
            let clearance = match program.grid {
                Grid::Keyframes | Grid::OpenKeyframes | Grid::State => pair.clearance(-BLUR),
                _ => pair.clearance(program.settings.margins.self_clearance),
            };
            out.push(Pair {
                node: at.node,
                a: pair.a,
                b: Some(pair.b),
                term: Arc::new(shared.row(
                    (index, None),
                    (near_a, Obstacle::Parts(near_b)),
                    Pose::identity(),
                    clearance,
                )),
            });
        }
    }

    /// Balls of one link and parts of another that come near one another in any of the configurations.
    fn balls_near_link(&self, pair: &SelfPair, window: &[&Kinematics]) -> (Vec<Ball>, Vec<Part>) {
        let poses: Vec<Pose> = window
            .iter()
            .map(|k| k.world_from_joint[pair.b].inverse() * k.world_from_joint[pair.a])
            .collect();
        let near = |(centre, radius): &Ball, part: &Part| {
            let mut points = poses.iter().map(|x| x.act(*centre));
            points.any(|p| part.rough_distance(&p) - radius < pair.near)
        };
        let bound = self.bounds[pair.a];
        let parts = self.parts[pair.b].iter();
        let parts: Vec<Part> = parts.filter(|part| near(&bound, part)).cloned().collect();
        let balls = self.balls[pair.a].iter();
        let balls = balls.filter(|ball| parts.iter().any(|part| near(ball, part)));
        (balls.copied().collect(), parts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Planner;
    use crate::settings::Settings;
    use std::path::Path;

    /// The G1 on the ground, beside or before something.
    fn scene(more: &str) -> Scene {
        let text = format!(
            "name = \"s\"\nrobot = \"g1\"\n[[static]]\nname = \"ground\"\nplane = true\n{more}\n[objective]\nkind = \"base_height\"\n"
        );
        Scene::from_toml(&text, "s.toml", Path::new(".")).unwrap()
    }

    #[test]
    fn links_that_are_near_one_another_at_the_start_may_stay_as_near() {
        let mut scene = scene("");
        let named = |j: &multibody::Joint| j.name == "left_shoulder_roll_joint";
        let roll = scene
            .robot
            .model
            .joints
            .iter()
            .find(|j| named(j))
            .unwrap()
            .idx_q;
        let mut nearest = f64::INFINITY;
        while nearest > 0.003 {
            scene.start[roll] -= 0.01;
            let planner = Planner::new(&scene).unwrap();
            let model = &planner.system.model;
            let mut kinematics = Kinematics::new(model);
            kinematics.update(model, &planner.system.start(&scene));
            for pair in &planner.collisions.self_pairs {
                let row = planner.collisions.row_of_links(&kinematics, pair.a, pair.b);
                for wish in [0.015, -BLUR] {
                    assert!(pair.clearance(wish) < row, "{pair:?}: {row}");
                }
                nearest = nearest.min(row);
            }
        }
    }

    #[test]
    fn a_foot_that_stands_near_a_wall_need_not_get_away_from_it() {
        // The tip of the left sole is 12 mm before the wall, which is low enough for the other links.
        let wall = "[[static]]\nname = \"wall\"\nsize = [0.02, 0.4, 0.03]\nposition = [0.131, 0.2, 0.015]\ntop = false";
        let scene = scene(wall);
        let planner = Planner::new(&scene).unwrap();
        let standing = Phase {
            state: scene.start_state(),
            steps: 8,
        };
        let mut lifted = standing.clone();
        let left = scene.interface_id("left_foot").unwrap();
        lifted.state = standing.state.iter().filter(|c| c.a != left).collect();
        let phases = [standing, lifted];
        let start = planner.system.start(&scene);
        let nodes = vec![start; 17];
        let none = ExtraClearance::new();
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let near = || Clearances::Near {
            nodes: &nodes,
            extra: &none,
        };
        let program = planner.program(&phases, &settings, Grid::Motion, near());
        let pairs = planner.collisions.pairs(&program, &scene, &phases, near());
        let mut kinematics = Kinematics::new(&planner.system.model);
        kinematics.update(&planner.system.model, &nodes[0]);
        let (mut near_wall, mut later) = (0, 0);
        for pair in pairs
            .iter()
            .filter(|p| p.b.is_none() && planner.collisions.feet[p.a])
        {
            let mut value = [f64::NAN];
            pair.term
                .values(&kinematics.world_from_joint[pair.a], &mut value);
            let demanded = pair.term.bounds()[0].0;
            if pair.node <= 8 {
                near_wall += usize::from(value[0] < settings.margins.swing);
                assert!(
                    demanded < value[0],
                    "node {}: {demanded} of {value:?}",
                    pair.node
                );
            } else {
                later += usize::from(demanded > value[0]);
            }
        }
        assert!(near_wall > 0 && later > 0, "{near_wall} {later}");
    }

    /// The demanded clearance of a joint and static bodies, the least at each node of a sequence of the repository at its start.
    fn demanded(name: &str, joint: &str, extra: f64) -> (usize, Vec<Option<f64>>) {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/sequences");
        let file = scene::SequenceFile::load(folder.join(name)).unwrap();
        let scene = file.load_scene().unwrap();
        let sequence = file.resolve(&scene).unwrap();
        let phase = |p: &scene::SequencePhase| Phase {
            state: p.state.clone(),
            steps: p.steps,
        };
        let phases: Vec<Phase> = sequence.phases.iter().map(phase).collect();
        let planner = Planner::new(&scene).unwrap();
        let n = phases.iter().map(|p| p.steps).sum::<usize>();
        let nodes = vec![planner.system.start(&scene); n + 1];
        let joints = &planner.system.model.joints;
        let a = joints.iter().position(|j| j.name == joint).unwrap();
        let mut more = ExtraClearance::new();
        for node in 0..=n {
            more.extend((0..scene.statics.len()).map(|s| ((node, a, Err(s)), extra)));
        }
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let near = || Clearances::Near {
            nodes: &nodes,
            extra: &more,
        };
        let program = planner.program(&phases, &settings, Grid::Motion, near());
        let mut least = vec![None; n + 1];
        for pair in planner
            .collisions
            .pairs(&program, &scene, &phases, near())
            .iter()
            .filter(|pair| pair.a == a && pair.b.is_none())
        {
            let here = pair.term.bounds()[0].0;
            let least: &mut Option<f64> = &mut least[pair.node];
            *least = Some(least.map_or(here, |least| least.min(here)));
        }
        (phases[0].steps, least)
    }

    #[test]
    fn a_wrist_is_as_near_to_a_table_as_the_handle_of_what_stands_there() {
        let (steps, least) = demanded("support/reach.toml", "right_wrist_yaw_joint", 0.0);
        let full = crate::settings::Margins::executable().clearance;
        // Phases: stand, lean, grasp, lift, set down, release, stand.
        for (k, may_be_near) in [(1, false), (2, true), (4, true), (6, false)] {
            let here = least[k * steps + steps / 2].expect("the hand hangs beside the table");
            let expected = if may_be_near { THROUGH * full } else { full };
            assert!((here - expected).abs() < 1e-12, "phase {k}: {here}");
        }
    }

    #[test]
    fn no_more_is_demanded_than_a_row_can_say() {
        let (_, least) = demanded("support/reach.toml", "right_wrist_yaw_joint", 0.5);
        let most = least.into_iter().flatten().fold(0.0, f64::max);
        assert!((most - MOST_CLEARANCE).abs() < 1e-12, "{most}");
    }
}
