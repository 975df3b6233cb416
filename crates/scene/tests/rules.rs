//! Which interfaces can touch.

use crate::fixtures::{VALID, read};
use scene::Scene;
use symbolic::ContactType::{self, BilateralPatch, UnilateralPatch, UnilateralPoint};

fn possible(scene: &Scene, a: &str, b: &str, kind: ContactType) -> bool {
    let id = |name: &str| scene.interface_id(name).expect("known name");
    scene.contact_possible(id(a), id(b), kind)
}

#[test]
fn owners_types_and_sizes_decide() {
    let scene = read(VALID).unwrap();
    let cases = [
        ("left_foot", "ground_top", UnilateralPatch, true),
        ("left_foot", "crate_lid", UnilateralPatch, true),
        ("left_foot", "crate_handle", UnilateralPatch, false),
        ("left_hand", "crate_handle", BilateralPatch, true),
        ("left_hand", "crate_lid", BilateralPatch, false),
        ("left_hand", "table_top", UnilateralPoint, false),
        ("crate_handle", "left_hand", BilateralPatch, false),
        ("crate_bottom", "table_top", UnilateralPatch, true),
        ("crate_bottom", "ground_top", UnilateralPatch, true),
        ("crate_bottom", "crate_lid", UnilateralPatch, false),
        ("crate_lid", "table_top", UnilateralPatch, false),
        ("table_top", "ground_top", UnilateralPatch, false),
        // too large for the shelf and for the cup
        ("crate_bottom", "shelf_top", UnilateralPatch, false),
        ("cup_foot", "shelf_top", UnilateralPatch, true),
        ("cup_foot", "crate_lid", UnilateralPatch, true),
        // the long side of a sole fits along one axis only
        ("left_foot", "shelf_top", UnilateralPatch, false),
        ("left_foot", "right_foot", UnilateralPatch, false),
    ];
    for (a, b, kind, expected) in cases {
        assert_eq!(possible(&scene, a, b, kind), expected, "{a} on {b}");
    }
}

#[test]
fn overhang_lets_a_larger_patch_rest() {
    let text = VALID.replace(
        "position = [0.6, 0.8, 0.73]",
        "position = [0.6, 0.8, 0.73]\ninterface = [{ name = \"shelf_top\", side = \"+z\", overhang = true }]",
    );
    let scene = read(&text).unwrap();
    assert!(possible(
        &scene,
        "crate_bottom",
        "shelf_top",
        UnilateralPatch
    ));
}

#[test]
fn a_surface_that_is_not_for_feet_bears_hands_and_objects() {
    let text = VALID.replace(
        "position = [0.6, 0.8, 0.73]",
        "position = [0.6, 0.8, 0.73]\ninterface = [{ name = \"shelf_top\", side = \"+z\", overhang = true, feet = false }]",
    );
    let scene = read(&text).unwrap();
    for (a, expected) in [
        ("left_foot", false),
        ("left_hand", true),
        ("cup_foot", true),
    ] {
        assert_eq!(
            possible(&scene, a, "shelf_top", UnilateralPatch),
            expected,
            "{a}"
        );
    }
}

#[test]
fn unknown_interfaces_have_no_id_and_no_contacts() {
    let scene = read(VALID).unwrap();
    assert_eq!(scene.interface_id("nothing"), None);
    let beyond = symbolic::InterfaceId(scene.interfaces.len());
    assert!(!scene.contact_possible(beyond, beyond, UnilateralPatch));
}
