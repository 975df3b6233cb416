//! Start poses and contacts that follow from the geometry.

use crate::fixtures::{VALID, read, spoiled};
use nalgebra::Vector3;
use scene::{Scene, Shape};
use std::collections::BTreeSet;
use symbolic::ContactType;

fn contacts(scene: &Scene) -> BTreeSet<(&str, &str)> {
    scene
        .start_contacts
        .iter()
        .map(|c| {
            (
                scene.interfaces[c.a.0].name.as_str(),
                scene.interfaces[c.b.0].name.as_str(),
            )
        })
        .collect()
}

#[test]
fn an_object_placed_in_the_world_finds_its_support() {
    let scene = read(VALID).unwrap();
    assert!(contacts(&scene).contains(&("cup_foot", "crate_lid")));
}

#[test]
fn the_frame_of_an_object_moves_to_its_centre_of_mass() {
    let scene = read(VALID).unwrap();
    let cup = &scene.objects[1];
    assert_eq!(cup.world_from_start.origin(), Vector3::new(0.6, 0.1, 1.03));
    assert!(cup.shapes[0].body_from_shape.origin().norm() < 1e-15);
    let capsule = Shape::Capsule {
        radius: 0.03,
        half_length: 0.05,
    };
    assert_eq!(cup.shapes[0].shape, capsule);
    assert_eq!(cup.inertia[(0, 0)], 1e-4);
}

#[test]
fn a_stack_is_placed_from_below_in_any_order_of_the_file() {
    let stack = |first: &str, second: &str| {
        format!(
            "name = \"stack\"\nrobot = \"g1\"\n[[static]]\nname = \"ground\"\nplane = true\n{first}\n{second}\n\
         [goal]\ncontacts = [[\"top_bottom\", \"ground_top\"]]\n"
        )
    };
    let lower = "[[object]]\nname = \"base_block\"\nmass = 1\nsize = [0.2, 0.2, 0.2]\non = \"ground_top\"\n\
                 position = [0.5, 0.3]\nyaw = 0.5\n[[object.interface]]\nname = \"lid\"\nside = \"+z\"";
    let upper = "[[object]]\nname = \"top\"\nmass = 1\nsize = [0.1, 0.1, 0.1]\non = \"lid\"\nposition = [0.03, 0]\nyaw = 0.25";
    for text in [stack(lower, upper), stack(upper, lower)] {
        let scene = read(&text).unwrap();
        let top = scene.objects.iter().find(|o| o.name == "top").unwrap();
        let expected = Vector3::new(0.5 + 0.03 * 0.5f64.cos(), 0.3 + 0.03 * 0.5f64.sin(), 0.25);
        assert!((top.world_from_start.origin() - expected).norm() < 1e-12);
        let x_axis = top.world_from_start.rotate(Vector3::x());
        assert!((x_axis - Vector3::new(0.75f64.cos(), 0.75f64.sin(), 0.0)).norm() < 1e-12);
        assert!(contacts(&scene).contains(&("top_bottom", "lid")));
    }
}

#[test]
fn an_object_can_stand_on_another_of_its_sides() {
    let text = spoiled(
        "position = [0.0, 0.0]\n\n[[object.interface]]",
        "position = [0.0, 0.0]\nwith = \"crate_side\"\n\n[[object.interface]]\nname = \"crate_side\"\nside = \"+x\"\nlands = true\n\n[[object.interface]]",
    )
    .replace("position = [0.6, 0.1, 0.95]", "on = \"ground_top\"\nwith = \"cup_foot\"");
    let scene = read(&text).unwrap();
    let crate_body = &scene.objects[0];
    assert!((crate_body.world_from_start.origin() - Vector3::new(0.6, 0.0, 0.85)).norm() < 1e-12);
    let x_axis = crate_body.world_from_start.rotate(Vector3::x());
    assert!((x_axis + Vector3::z()).norm() < 1e-12);
}

#[test]
fn the_base_turns_and_the_feet_find_the_platform_below_them() {
    let text = spoiled(
        "position = [0.0, 0.0]\njoints",
        "position = [-2.0, 0.0]\nyaw = 1.5707963267948966\njoints",
    ) + "\n[[static]]\nname = \"platform\"\nsize = [1, 1, 0.2]\nposition = [-2, 0, 0.1]\n";
    let scene = read(&text).unwrap();
    let on_ground = read(VALID).unwrap();
    assert!((scene.start[2] - on_ground.start[2] - 0.2).abs() < 1e-12);
    assert!(contacts(&scene).contains(&("left_foot", "platform_top")));
    let half = 0.5f64.sqrt();
    assert!((scene.start[5] - half).abs() < 1e-15 && (scene.start[6] - half).abs() < 1e-15);
}

#[test]
fn a_given_base_height_is_kept_if_the_feet_touch() {
    let height = read(VALID).unwrap().start[2];
    let text = spoiled(
        "position = [0.0, 0.0]\njoints",
        &format!("position = [0.0, 0.0, {height}]\njoints"),
    );
    let scene = read(&text).unwrap();
    assert_eq!(scene.start[2], height);
    assert!(contacts(&scene).contains(&("right_foot", "ground_top")));
}

#[test]
fn listed_contacts_replace_those_of_the_feet_in_either_order() {
    let text = spoiled(
        "[[static]]\nname = \"ground\"",
        "contacts = [[\"ground_top\", \"left_foot\", \"unilateral_patch\"]]\n\n[[static]]\nname = \"ground\"",
    );
    let scene = read(&text.replace("joints = { waist_yaw_joint = 0.1 }\n\n", "")).unwrap();
    let found = contacts(&scene);
    assert!(found.contains(&("left_foot", "ground_top")));
    assert!(!found.iter().any(|(a, _)| *a == "right_foot"));
    assert!(found.contains(&("crate_bottom", "table_top")));
}

#[test]
fn a_robot_in_the_air_has_no_contacts_if_the_file_says_so() {
    let text = spoiled(
        "position = [0.0, 0.0]\njoints",
        "position = [0.0, 0.0, 2.0]\ncontacts = []\njoints",
    );
    let scene = read(&text).unwrap();
    assert_eq!(scene.start[2], 2.0);
    assert_eq!(contacts(&scene).len(), 2);
}

#[test]
fn friction_comes_from_the_nearest_level_that_gives_it() {
    let text = spoiled(
        "robot = \"g1\"",
        "robot = \"g1\"\nfriction = { mu = 0.6, mu_r = 0.01 }",
    )
    .replace("mass = 2.0", "mass = 2.0\nmu = 0.5")
    .replace("name = \"crate_lid\"", "name = \"crate_lid\"\nmu = 0.4");
    let scene = read(&text).unwrap();
    let mu = |name: &str| scene.interfaces[scene.interface_id(name).unwrap().0].mu;
    assert_eq!(mu("ground_top"), 0.6);
    assert_eq!(mu("crate_bottom"), 0.5);
    assert_eq!(mu("crate_lid"), 0.4);
    let table = scene.interface_id("table_top").unwrap();
    assert_eq!(scene.interfaces[table.0].mu_r, 0.01);
}

#[test]
fn goals_may_be_written_in_either_order() {
    let text = spoiled(
        "[\"crate_bottom\", \"ground_top\"]",
        "[\"ground_top\", \"crate_bottom\"], [\"left_hand\", \"crate_handle\"]",
    );
    let scene = read(&text).unwrap();
    assert_eq!(scene.goal_contacts.len(), 2);
    let first = scene.goal_contacts[0];
    assert_eq!(scene.interfaces[first.a.0].name, "crate_bottom");
    assert!(scene.contact_possible(first.a, first.b, ContactType::UnilateralPatch));
}

#[test]
fn goals_may_ask_for_an_orientation_and_objectives_for_a_reach() {
    let text = spoiled("x = [-0.5, 0.5]", "yaw = [-0.1, 3.5]\ntilt = 0.2").replace(
        "[search]",
        "[objective]\nkind = \"reach\"\nbody = \"crate\"\ndirection = [0, -3, 4]\n[search]",
    );
    let scene = read(&text).unwrap();
    let region = &scene.goal_regions[0];
    assert_eq!((region.yaw, region.tilt), (Some([-0.1, 3.5]), Some(0.2)));
    assert!(region.lower.iter().all(|x| *x == f64::NEG_INFINITY));
    let scene::Objective::Reach { body, direction } = &scene.objective else {
        panic!("{:?}", scene.objective)
    };
    assert_eq!(body, "crate");
    assert!((direction - nalgebra::Vector3::new(0.0, -0.6, 0.8)).norm() < 1e-15);
}

#[test]
fn options_default_and_are_overridden() {
    let scene = read(VALID).unwrap();
    assert_eq!(
        (scene.search.max_changes, scene.search.max_phases),
        (2, None)
    );
    assert_eq!(scene.optimiser.steps, 8);
    assert_eq!(scene.optimiser.min_duration, 0.3);
    assert_eq!(scene.optimiser.max_duration, 2.0);
    assert!(scene.optimiser.torque_limits && !scene.search.support_hands);
}
