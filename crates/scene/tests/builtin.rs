//! The scenes that are part of the program.

use multibody::Kinematics;
use nalgebra::Vector3;
use scene::{Fault, Owner, Role, Scene};
use symbolic::ContactType;

fn pick_place() -> Scene {
    Scene::builtin("pick-place").expect("the built-in scene is valid")
}

#[test]
fn every_builtin_scene_loads_under_its_name() {
    for name in Scene::builtin_names() {
        let scene = Scene::builtin(name).unwrap_or_else(|error| panic!("{}", error.render()));
        assert_eq!(scene.name, name);
        assert!(!scene.start_contacts.is_empty());
    }
}

#[test]
fn another_name_is_refused_with_a_suggestion() {
    let error = Scene::builtin("pick-and-place").unwrap_err();
    assert!(matches!(error.fault(), Fault::UnknownBuiltin { .. }));
    let message = error.to_string();
    assert!(
        message.contains("did you mean \"pick-place\"?"),
        "{message}"
    );
    assert!(error.place().is_none());
    assert!(error.render().contains("no scene \"pick-and-place\""));
}

#[test]
fn in_pick_place_the_feet_stand_and_the_box_rests() {
    let scene = pick_place();
    let names: Vec<_> = scene
        .start_contacts
        .iter()
        .map(|contact| {
            let name = |id: symbolic::InterfaceId| scene.interfaces[id.0].name.as_str();
            (name(contact.a), name(contact.b), contact.kind)
        })
        .collect();
    let kind = ContactType::UnilateralPatch;
    let expected = [
        ("left_foot", "ground_top", kind),
        ("right_foot", "ground_top", kind),
        ("red_box_bottom", "table_a_top", kind),
    ];
    assert_eq!(names, expected);
    assert_eq!(scene.start_state().contacts.len(), 3);
}

#[test]
fn in_pick_place_the_soles_are_on_the_ground() {
    let scene = pick_place();
    let model = &scene.robot.model;
    assert_eq!(scene.start.len(), model.nq);
    let mut kinematics = Kinematics::new(model);
    kinematics.update(model, &scene.start);
    let feet = scene.interfaces.iter().filter(|i| i.role == Role::Foot);
    for foot in feet {
        let Owner::Robot { frame } = foot.owner else {
            panic!("{} is not on the robot", foot.name);
        };
        let world_from_foot = kinematics.frame_pose(model, frame) * foot.body_from_interface;
        assert!(world_from_foot.origin().z.abs() < 1e-12);
        assert!((world_from_foot.rotate(Vector3::z()) + Vector3::z()).norm() < 1e-12);
    }
}

#[test]
fn in_pick_place_the_box_frame_is_at_its_centre_of_mass() {
    let scene = pick_place();
    let red_box = &scene.objects[0];
    // the knob weighs 1 kg · 3.2e-5 / (3.375e-3 + 3.2e-5) and lies at (-0.03, 0.085, 0)
    let share = 3.2e-5 / (3.375e-3 + 3.2e-5);
    let centre = Vector3::new(0.38, -0.02, 0.825) + Vector3::new(-0.03, 0.085, 0.0) * share;
    assert!((red_box.world_from_start.origin() - centre).norm() < 1e-12);
    let handle = scene.interface_id("red_box_handle").unwrap();
    let world_from_handle =
        red_box.world_from_start * scene.interfaces[handle.0].body_from_interface;
    assert!((world_from_handle.origin() - Vector3::new(0.35, 0.075, 0.825)).norm() < 1e-12);
    assert!((world_from_handle.rotate(Vector3::z()) - Vector3::y()).norm() < 1e-12);
    // a 1 kg cube of 0.15 m alone has m a²/6
    assert!((red_box.inertia[(2, 2)] / (0.15f64.powi(2) / 6.0) - 1.0).abs() < 0.02);
}

#[test]
fn in_pick_place_only_hands_hold_the_handle_and_the_goal_is_the_other_table() {
    let scene = pick_place();
    let id = |name: &str| scene.interface_id(name).unwrap();
    let handle = id("red_box_handle");
    for (index, interface) in scene.interfaces.iter().enumerate() {
        let a = symbolic::InterfaceId(index);
        let possible = scene.contact_possible(a, handle, ContactType::BilateralPatch);
        assert_eq!(possible, interface.role == Role::Hand, "{}", interface.name);
    }
    assert_eq!(scene.goal_contacts.len(), 1);
    assert_eq!(scene.goal_contacts[0].a, id("red_box_bottom"));
    assert_eq!(scene.goal_contacts[0].b, id("table_b_top"));
}

#[test]
fn lift_box_has_a_patch_on_either_side() {
    let scene = Scene::builtin("lift-box").unwrap();
    let normals = ["box_left", "box_right"].map(|name| {
        let id = scene.interface_id(name).unwrap();
        scene.interfaces[id.0]
            .body_from_interface
            .rotate(Vector3::z())
    });
    assert!((normals[0] + normals[1]).norm() < 1e-15);
    assert_eq!(scene.goal_regions[0].body, "box");
    assert_eq!(scene.goal_regions[0].lower.z, 0.95);
    assert_eq!(scene.goal_regions[0].upper.z, f64::INFINITY);
    assert_eq!(scene.goal_regions[0].lower.x, f64::NEG_INFINITY);
}
