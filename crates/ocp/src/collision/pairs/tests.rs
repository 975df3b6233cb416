use super::super::samples::{Sequence, scene};
use super::*;
use crate::motion::Planner;
use crate::settings::Settings;
use nalgebra::{Vector3, Vector6};

/// The node of a pair without crossings.
fn node(pair: &Pair) -> usize {
    match pair.place {
        Place::Node(node) => node,
        Place::Way { .. } => panic!("{pair:?}"),
    }
}

/// The start, and the same without the left foot's contact.
fn standing_and_lifted(scene: &Scene, steps: usize) -> [Phase; 2] {
    let left = scene.interface_id("left_foot").unwrap();
    let state = scene.start_state();
    let lifted = state.iter().filter(|c| c.a != left).collect();
    [state, lifted].map(|state| Phase { state, steps })
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
            let row = pair.row_says(&kinematics);
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
    let phases = standing_and_lifted(&scene, 8);
    let start = planner.system.start(&scene);
    let nodes = vec![start; 17];
    let none = Crossings::new();
    let settings = Settings::new(Preset::Default, &scene.optimiser);
    let near = || Clearances::Near {
        nodes: &nodes,
        crossings: &none,
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
        if node(pair) <= 8 {
            near_wall += usize::from(value[0] < settings.margins.swing);
            assert!(
                demanded < value[0],
                "node {}: {demanded} of {value:?}",
                node(pair)
            );
        } else {
            later += usize::from(demanded > value[0]);
        }
    }
    assert!(near_wall > 0 && later > 0, "{near_wall} {later}");
}

#[test]
fn what_is_beside_a_contact_may_not_overlap_as_it_does_in_the_guide() {
    let scene = scene("");
    let planner = Planner::new(&scene).unwrap();
    let model = &planner.system.model;
    let shin = model
        .joints
        .iter()
        .position(|j| j.name == "left_knee_joint")
        .unwrap();
    let ground = planner
        .collisions
        .primitives
        .iter()
        .position(|p| p.joint.is_none())
        .unwrap();
    let mut sunk = planner.system.start(&scene);
    let depth = |q: &[f64]| {
        let mut kinematics = Kinematics::new(model);
        kinematics.update(model, q);
        let primitive = &planner.collisions.primitives[ground];
        planner.collisions.depth(shin, primitive, &kinematics)
    };
    while depth(&sunk) < 0.02 {
        sunk[2] -= 0.005;
    }
    let [standing, lifted] = standing_and_lifted(&scene, 4);
    let phases = [standing.clone(), lifted, standing];
    let nodes = vec![sunk; 13];
    let none = Crossings::new();
    let near = || Clearances::Near {
        nodes: &nodes,
        crossings: &none,
    };
    let settings = Settings::new(Preset::Default, &scene.optimiser);
    let program = planner.program(&phases, &settings, Grid::Motion, near());
    let pairs = planner.collisions.pairs(&program, &scene, &phases, near());
    let of_shin = pairs
        .iter()
        .filter(|p| p.a == shin && p.b.is_none() && node(p) > 8);
    let demanded: Vec<f64> = of_shin.map(|p| p.term.bounds()[0].0).collect();
    assert!(!demanded.is_empty());
    // The smooth minimum says up to a few millimetres less than the distance.
    assert!(demanded.iter().all(|d| *d > -0.012), "{demanded:?}");
}

#[test]
fn a_wrist_may_be_as_near_to_a_wall_as_the_palm_on_it_makes_it() {
    let Sequence { scene, phases } = Sequence::load("support/button.toml");
    let planner = Planner::new(&scene).unwrap();
    let settings = Settings::new(Preset::Default, &scene.optimiser);
    let keyframes = planner.keyframes(&phases, &settings);
    assert!(keyframes.possible, "{:?}", keyframes.worst);
    let steps: usize = phases.iter().map(|p| p.steps).sum();
    let reach = phases.last().unwrap().steps;
    let model = &planner.system.model;
    let wrist = ["right_wrist_pitch_joint", "right_wrist_roll_joint"]
        .map(|name| model.joints.iter().position(|j| j.name == name).unwrap());
    let nodes = vec![keyframes.nodes[phases.len()].clone(); steps + 1];
    let none = Crossings::new();
    let near = || Clearances::Near {
        nodes: &nodes,
        crossings: &none,
    };
    let program = planner.program(&phases, &settings, Grid::Motion, near());
    let pairs = planner.collisions.pairs(&program, &scene, &phases, near());
    let mut kinematics = Kinematics::new(model);
    kinematics.update(model, &nodes[0]);
    let (mut at_contact, mut nearest) = (0, f64::INFINITY);
    for pair in pairs
        .iter()
        .filter(|p| wrist.contains(&p.a) && p.b.is_none())
    {
        let says = value(&*pair.term, &kinematics.world_from_joint[pair.a]);
        if node(pair) > steps - reach {
            assert!(pair.term.bounds()[0].0 < says, "{says} m in {pair:?}");
            (at_contact, nearest) = (at_contact + 1, says.min(nearest));
        }
    }
    assert!(at_contact > 0 && nearest < 0.01, "{nearest} m");
}

/// The demanded clearance of a joint and static bodies, the least at each node of a sequence of the repository at its start,
/// where `wish` is wanted.
fn demanded(name: &str, joint: &str, wish: f64) -> (usize, Vec<Option<f64>>) {
    let Sequence { scene, phases } = Sequence::load(name);
    let planner = Planner::new(&scene).unwrap();
    let n = phases.iter().map(|p| p.steps).sum::<usize>();
    let nodes = vec![planner.system.start(&scene); n + 1];
    let joints = &planner.system.model.joints;
    let a = joints.iter().position(|j| j.name == joint).unwrap();
    let none = Crossings::new();
    let mut settings = Settings::new(Preset::Default, &scene.optimiser);
    settings.margins.clearance = wish;
    let near = || Clearances::Near {
        nodes: &nodes,
        crossings: &none,
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
        let least: &mut Option<f64> = &mut least[node(pair)];
        *least = Some(least.map_or(here, |least| least.min(here)));
    }
    (phases[0].steps, least)
}

#[test]
fn a_wrist_is_as_near_to_a_table_as_the_handle_of_what_stands_there() {
    let full = crate::settings::Margins::executable().clearance;
    let (steps, least) = demanded("support/reach.toml", "right_wrist_yaw_joint", full);
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

/// The edge of a board, 5 cm beside a box, at half of its height, until the box is moved there.
const BOARD: &str = "[[object]]\nname = \"box\"\nmass = 1.0\nsize = [0.24, 0.24, 0.24]\non = \"ground_top\"\nposition = [0.6, 0.0]\n\
    [[static]]\nname = \"board\"\nsize = [0.2, 0.6, 0.02]\nposition = [0.87, 0.0, 0.07]";

#[test]
fn a_board_is_seen_where_it_enters_the_side_of_a_box_between_its_corners() {
    let scene = scene(BOARD);
    let planner = Planner::new(&scene).unwrap();
    let (system, collisions) = (&planner.system, &planner.collisions);
    let a = system.object_joint(0);
    let is_board = |p: &&Primitive| p.body.is_some() && matches!(p.obstacle, Obstacle::Box(_));
    let board = collisions.primitives.iter().find(is_board).unwrap();
    let mut moved = system.start(&scene);
    moved[system.model.joints[a].idx_q] += 0.06;
    let mut kinematics = Kinematics::new(&system.model);
    kinematics.update(&system.model, &moved);
    let corners = distance_at((a, &collisions.balls[a]), board, &kinematics).row;
    assert!(corners > 0.02, "all corners are outside: {corners}");
    let own = collisions.own(a).next().unwrap();
    let (_, edges) = collisions.edges_inside((a, own), board, &[&kinematics]);
    let row = edge_row((a, own), board, &edges, &|_| 0.0);
    let seen = value(&row, &kinematics.world_from_joint[a]);
    assert!((-0.02..-0.009).contains(&seen), "10 mm inside: {seen}");
    let (depth, ..) = collisions.deepest(&kinematics, &|_, _| false).unwrap();
    assert!((depth - 0.01).abs() < 1e-3, "{depth}");
}

#[test]
fn a_wedge_is_seen_where_it_enters_the_edge_of_a_foot_between_its_balls() {
    let scene = scene("");
    let planner = Planner::new(&scene).unwrap();
    let (system, mut collisions) = (&planner.system, planner.collisions.clone());
    let mut joints = 0..collisions.feet.len();
    let a = joints.find(|&a| collisions.feet[a]).unwrap();
    let foot = collisions.link_boxes[a][0].clone();
    let Obstacle::Box(half) = foot.obstacle else {
        panic!("a box of a link is a box");
    };
    let mut kinematics = Kinematics::new(&system.model);
    kinematics.update(&system.model, &system.start(&scene));
    // A centimetre wide, a quarter of the way along the edge, with a face at 45° to both of the foot's, 6 mm in it.
    let edge = Vector3::new(0.5 * half.x, half.y, half.z);
    let centre = edge + Vector3::new(0.0, 1.0, 1.0).normalize() * (0.1 - 0.006);
    let turned = Pose::exp(&Vector6::new(
        0.0,
        0.0,
        0.0,
        std::f64::consts::FRAC_PI_4,
        0.0,
        0.0,
    ));
    let foot_from_wedge = Pose::from_translation(centre.x, centre.y, centre.z) * turned;
    let world_from_foot = kinematics.world_from_joint[a] * foot.from_body.inverse();
    let wedge = Primitive {
        joint: None,
        body: Some(7),
        from_body: (world_from_foot * foot_from_wedge).inverse(),
        obstacle: Obstacle::Box(Vector3::new(0.005, 0.1, 0.1)),
    };
    let balls = collisions.balls[a].iter();
    let outside = balls.map(|(c, r)| {
        let x = wedge.pose_of_joint(&kinematics, a);
        wedge.obstacle.roughly_nearest(&x.act(*c)) - r
    });
    assert!(outside.fold(f64::INFINITY, f64::min) > -0.002);
    collisions.primitives.push(wedge.clone());
    let others = |joint: usize, other: Other| (joint, other) != (a, Err(7));
    let (depth, ..) = collisions.deepest(&kinematics, &others).unwrap();
    assert!((0.004..0.009).contains(&depth), "{depth}");
    // The wedge's edges are inside the foot, and a row of them says so, as far as a box with smooth edges does.
    let (_, of_wedge) = collisions.edges_inside((a, &foot), &wedge, &[&kinematics]);
    let row = edge_row((a, &foot), &wedge, &of_wedge, &|_| 0.0);
    let seen = value(&row, &kinematics.world_from_joint[a]);
    assert!((-0.01..-0.0005).contains(&seen), "{seen}");
}

#[test]
fn an_edge_that_was_inside_in_an_earlier_round_keeps_its_points() {
    let scene = scene(BOARD);
    let planner = Planner::new(&scene).unwrap();
    let joints = &planner.system.model.joints;
    let a = planner.system.object_joint(0);
    let on_box = scene.interface_id("box_bottom").unwrap();
    let standing = scene.start_state();
    let lifted = standing.iter().filter(|c| c.a != on_box);
    let phases = [standing.clone(), lifted.collect()].map(|state| Phase { state, steps: 4 });
    let start = planner.system.start(&scene);
    let mut inside = start.clone();
    inside[joints[a].idx_q] += 0.06;
    let (outside, inside) = (vec![start; 9], vec![inside; 9]);
    let settings = Settings::new(Preset::Default, &scene.optimiser);
    let rows = |nodes: &[Vec<f64>], earlier: &[&Vec<Vec<f64>>]| {
        let crossings = Crossings {
            earlier: earlier.iter().copied().cloned().collect(),
            ..Crossings::new()
        };
        let near = || Clearances::Near {
            nodes,
            crossings: &crossings,
        };
        let program = planner.program(&phases, &settings, Grid::Motion, near());
        let pairs = (planner.collisions).pairs(&program, &scene, &phases, near());
        pairs.iter().filter(|pair| pair.a == a).count()
    };
    let (never, now) = (rows(&outside, &[]), rows(&inside, &[]));
    assert!(now > never, "{now} and {never} rows");
    assert_eq!(rows(&outside, &[&outside]), never);
    assert_eq!(rows(&outside, &[&outside, &inside]), now);
}
