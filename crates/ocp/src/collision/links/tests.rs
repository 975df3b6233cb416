use super::super::samples::scene;
use super::super::self_pair::{AT_REST, PLAY};
use super::*;
use nalgebra::Vector3;

/// Joints of the G1, more than two apart.
const HAND: &str = "left_wrist_yaw_joint";
const THIGH: &str = "right_hip_roll_joint";
/// Three joints apart.
const FOREARM: &str = "left_elbow_joint";
const SHOULDER: &str = "left_shoulder_pitch_joint";

/// The G1 with two links' shapes alone, placed in the world in the home posture.
fn pairs_of(hand: &[(Pose, Shape)], thigh: &[(Pose, Shape)]) -> Vec<SelfPair> {
    pairs_of_links((HAND, hand), (THIGH, thigh))
}

/// The same of any two links.
fn pairs_of_links(one: (&str, &[(Pose, Shape)]), other: (&str, &[(Pose, Shape)])) -> Vec<SelfPair> {
    let scene = scene("");
    let system = System::new(&scene).unwrap();
    let postures = Postures::new(&scene, &system);
    let joint = |name: &str| {
        let mut joints = system.model.joints.iter();
        joints.position(|j| j.name == name).unwrap()
    };
    let mut shapes = vec![vec![]; system.model.joints.len()];
    for (name, placed) in [one, other] {
        let joint_from_world = postures.0[0].world_from_joint[joint(name)].inverse();
        for (world_from_shape, shape) in placed {
            shapes[joint(name)].push(LinkShape::new(
                &(joint_from_world * *world_from_shape),
                shape,
            ));
        }
    }
    self_pairs(&scene, &system, &shapes)
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(x, y, z)
}

fn ball(radius: f64) -> Shape {
    Shape::Sphere { radius }
}

#[test]
fn shapes_that_the_robot_joins_leave_the_others_of_their_links_apart() {
    // Large enough to overlap in whatever posture, small ones 0.1 m apart.
    let hand = [
        (at(0.0, 0.0, 1.0), ball(2.0)),
        (at(3.0, 0.0, 1.0), ball(0.1)),
    ];
    let thigh = [
        (at(0.0, 0.0, 1.0), ball(2.0)),
        (at(3.3, 0.0, 1.0), ball(0.1)),
    ];
    let pairs = pairs_of(&hand, &thigh);
    let apart = |x: f64, y: f64| {
        let has = |pair: &&SelfPair| {
            let ball = |b: &Ball| b.1 == x;
            let part = |p: &Part| matches!(p, Part::Ball(_, radius) if *radius == y);
            pair.balls.iter().any(ball) && pair.parts.iter().any(part)
        };
        pairs.iter().filter(has).count()
    };
    assert_eq!(apart(2.0, 2.0), 0);
    assert_eq!([apart(0.1, 0.1), apart(2.0, 0.1), apart(0.1, 2.0)], [1; 3]);
}

#[test]
fn a_capsule_that_is_joined_at_one_end_keeps_out_with_the_other() {
    let along_x =
        nalgebra::Rotation3::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
    let capsule = Shape::Capsule {
        radius: 0.1,
        half_length: 2.0,
    };
    let across = Pose::from_parts(*along_x.matrix(), Vector3::new(4.0, 0.0, 1.0));
    let pairs = pairs_of(&[(at(0.0, 0.0, 1.0), ball(3.0))], &[(across, capsule)]);
    let [pair] = &pairs[..] else {
        panic!("{pairs:?}");
    };
    let balls = pair.balls.iter().map(|b| b.1);
    let parts = pair.parts.iter().map(|part| match part {
        Part::Ball(_, radius) => *radius,
        Part::Box(..) => f64::NAN,
    });
    let mut radii: Vec<f64> = balls.chain(parts).collect();
    radii.sort_by(f64::total_cmp);
    assert_eq!(radii, [0.1, 3.0]);
    // From the middle of the large ball to the far end.
    assert!((pair.at_home - (6.0 - 3.0 - 0.1)).abs() < 1e-9, "{pair:?}");
}

#[test]
fn links_that_overlap_at_home_alone_may_stay_as_deep_and_get_no_deeper() {
    let depth = 0.01;
    let hand = [(at(0.0, 0.0, 1.0), ball(0.05))];
    let thigh = [(at(0.1 - depth, 0.0, 1.0), ball(0.05))];
    let pairs = pairs_of(&hand, &thigh);
    let [pair] = &pairs[..] else {
        panic!("{pairs:?}");
    };
    assert!((pair.at_home + depth).abs() < 1e-9, "{pair:?}");
    for wish in [0.015, -BLUR] {
        let allowed = -pair.clearance(wish);
        assert!(
            allowed > depth && allowed < depth + 2.0 * AT_REST,
            "{allowed}"
        );
    }
}

#[test]
fn links_that_all_but_touch_three_joints_apart_may_overlap_a_little() {
    let demanded = |other: &str, gap: f64| {
        // So far out that they are nowhere near one another with all joints at zero.
        let own = [(at(2.0, 0.0, 1.0), ball(0.05))];
        let of_other = [(at(2.1 + gap, 0.0, 1.0), ball(0.05))];
        let pairs = pairs_of_links((FOREARM, &own), (other, &of_other));
        pairs[0].clearance(0.015)
    };
    for gap in [0.002, 0.0005] {
        assert!((demanded(SHOULDER, gap) + PLAY).abs() < 1e-9);
    }
    for gap in [-0.002, -0.01] {
        let wanted = gap - AT_REST;
        assert!(
            (demanded(SHOULDER, gap) - wanted).abs() < 1e-9,
            "as at rest"
        );
    }
    assert!(demanded(SHOULDER, 0.01) > 0.0);
    assert!(demanded(THIGH, 0.002) >= 0.0);
}

#[test]
fn links_so_close_that_no_row_says_so_keep_out_of_one_another_near_a_configuration() {
    let (gap, half) = (0.004, 0.1);
    let cube = || Shape::Box {
        half_size: Vector3::repeat(half),
    };
    let hand = [(at(0.0, 0.0, 1.0), cube())];
    let pairs = pairs_of(&hand, &[(at(2.0 * half + gap, 0.0, 1.0), cube())]);
    let [pair] = &pairs[..] else {
        panic!("{pairs:?}");
    };
    let scene = scene("");
    let system = System::new(&scene).unwrap();
    let postures = Postures::new(&scene, &system);
    let home = &postures.0[0];
    // Balls at edges bulge.
    assert!(pair.at_home > 0.2 * gap && pair.at_home < gap, "{pair:?}");
    let says = pair.row_says(home);
    assert!(says < -0.005, "many balls are equally near: {says}");
    assert!(pair.clearance(0.015) < says && pair.clearance_near(0.015, home) < says);
    let mut cover = Vec::new();
    super::super::cover::cover(&Pose::identity(), &cube(), &mut cover);
    assert!(pair.balls.len() > cover.len() + 12, "edges have points");
    // Where fewer are near, more is demanded: as much as keeps the shapes apart.
    let mut turned = system.start(&scene);
    let wrist = (system.model.joints.iter())
        .find(|j| j.name == HAND)
        .unwrap();
    turned[wrist.idx_q] += 0.2;
    let mut here = Kinematics::new(&system.model);
    here.update(&system.model, &turned);
    let (distance, demanded) = (pair.distance(&here), pair.clearance_near(0.015, &here));
    assert!(demanded > pair.clearance(0.015) + 1e-3, "{demanded}");
    let apart = pair.row_says(&here) - demanded;
    assert!((apart - distance).abs() < 1e-9, "{apart} {distance}");
}

#[test]
fn edges_that_cross_between_their_points_are_as_deep_as_they_are() {
    // two roof ridges, one upside down across the other
    let half = 0.1;
    let cube = || Shape::Box {
        half_size: Vector3::repeat(half),
    };
    let eighth = std::f64::consts::FRAC_PI_4;
    let turned = |axis: Vector3<f64>, z: f64| {
        Pose::from_parts(
            spatial::exp_so3(&(axis * eighth)),
            Vector3::new(0.0, 0.0, z),
        )
    };
    let above = |gap: f64| {
        let ridge = 2.0_f64.sqrt() * half;
        let hand = [(turned(Vector3::x(), 1.0), cube())];
        let thigh = [(turned(Vector3::y(), 1.0 + 2.0 * ridge + gap), cube())];
        let pairs = pairs_of(&hand, &thigh);
        let [pair] = &pairs[..] else {
            panic!("{pairs:?}");
        };
        let scene = scene("");
        let system = System::new(&scene).unwrap();
        let says = pair.row_says(&Postures::new(&scene, &system).0[0]);
        (pair.at_home, says)
    };
    let depth = 0.004;
    let (at_home, says) = above(-depth);
    // the faces are at 45 degrees to what crosses them
    let normal = depth / 2.0_f64.sqrt();
    assert!(at_home < 5e-4 - normal, "{at_home}");
    assert!(at_home > -normal - 3e-3, "balls bulge: {at_home}");
    assert!(says < at_home + 1e-9, "{says} {at_home}");
    assert!(above(depth).0 > 0.0);
}
