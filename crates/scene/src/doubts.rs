//! Numbers of a scene file that can be meant, but hardly are: degrees for radians, millimetres for metres, gravity upwards.

use crate::file::{SceneFile, ShapeEntry};
use crate::source::At;
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// Sizes beyond this are doubted [m].
const LARGE: f64 = 100.0;

/// What is doubted, in words; `gravity` in the world [m/s²].
pub(crate) fn doubts(file: &SceneFile, gravity: Vector3<f64>) -> Vec<String> {
    let mut doubts = Vec::new();
    if gravity.z > 0.0 {
        doubts.push(format!(
            "gravity points up, z = {} m/s²: is the sign meant? The usual gravity is [0, 0, -9.81]",
            gravity.z
        ));
    }
    doubts.extend(yaw("the start", file.start.yaw.as_ref()));
    for entry in &file.object {
        let what = format!("object {:?}", *entry.name);
        doubts.extend(yaw(&what, entry.yaw.as_ref()));
        doubts.extend(size(&what, entry.size.as_ref(), &entry.shape));
    }
    for entry in &file.statics {
        let what = format!("static body {:?}", *entry.name);
        doubts.extend(yaw(&what, entry.yaw.as_ref()));
        doubts.extend(size(&what, entry.size.as_ref(), &entry.shape));
    }
    let goal = file.goal.as_deref();
    for entry in goal.into_iter().flat_map(|goal| &goal.region) {
        let what = format!("goal region of {:?}", *entry.body);
        let mut bounds = entry.yaw.iter().flat_map(|yaw| **yaw);
        doubts.extend(bounds.find_map(|bound| angle(&what, bound)));
        let is_far = |bound: &f64| bound.is_finite() && bound.abs() > LARGE;
        let mut axes = [&entry.x, &entry.y, &entry.z].into_iter().flatten();
        if let Some(axis) = axes.find(|axis| axis.iter().any(is_far)) {
            doubts.push(format!("{what} = {:?} m: are these millimetres?", **axis));
        }
    }
    doubts
}

fn yaw(what: &str, yaw: Option<&At<f64>>) -> Option<String> {
    angle(what, **yaw?)
}

fn angle(what: &str, yaw: f64) -> Option<String> {
    (yaw.abs() > TAU).then(|| {
        format!(
            "yaw of {what} = {yaw} rad: are these degrees? {yaw} degrees are {:.4} rad",
            yaw.to_radians()
        )
    })
}

/// Of the body itself, or of the first of its boxes that is large.
fn size(what: &str, size: Option<&At<[f64; 3]>>, shapes: &[At<ShapeEntry>]) -> Option<String> {
    let boxes = shapes.iter().filter_map(|shape| shape.cuboid.as_ref());
    let mut sizes = size.into_iter().chain(boxes);
    let large = sizes.find(|size| size.iter().any(|x| *x > LARGE))?;
    Some(format!(
        "size of {what} = {:?} m: are these millimetres?",
        **large
    ))
}

#[cfg(test)]
mod tests {
    use crate::Scene;
    use std::path::Path;

    fn doubts(from: &str, to: &str) -> Vec<String> {
        let text = "name = \"s\"\nrobot = \"g1\"\ngravity = [0, 0, -9.81]\n[[static]]\nname = \"ground\"\nplane = true\n\
                    [[static]]\nname = \"wall\"\nsize = [0.1, 2, 2]\nposition = [900, 0, 1]\nyaw = 3.14\n\
                    [objective]\nkind = \"base_height\"\n";
        assert!(text.contains(from), "{from}");
        let text = text.replacen(from, to, 1);
        let scene = Scene::from_toml(&text, "s.toml", Path::new(".")).expect("a scene");
        assert_eq!(scene.doubts, scene.notes());
        scene.doubts
    }

    #[test]
    fn usual_numbers_raise_no_doubt() {
        assert_eq!(doubts("", ""), Vec::<String>::new());
    }

    #[test]
    fn a_yaw_of_more_than_a_turn_might_be_in_degrees() {
        assert_eq!(
            doubts("yaw = 3.14", "yaw = -90"),
            [
                "yaw of static body \"wall\" = -90 rad: are these degrees? -90 degrees are -1.5708 rad"
            ]
        );
    }

    #[test]
    fn a_size_of_more_than_a_hundred_metres_might_be_in_millimetres() {
        assert_eq!(
            doubts("[0.1, 2, 2]", "[100, 2, 1200]"),
            ["size of static body \"wall\" = [100.0, 2.0, 1200.0] m: are these millimetres?"]
        );
    }

    #[test]
    fn a_goal_might_be_in_millimetres_and_degrees() {
        let goal = "[[goal.region]]\nbody = \"base\"\nx = [-inf, 400]\ny = [-50, 50]\nyaw = [85, 90]\n[objective]";
        assert_eq!(
            doubts("[objective]", goal),
            [
                "yaw of goal region of \"base\" = 85 rad: are these degrees? 85 degrees are 1.4835 rad",
                "goal region of \"base\" = [-inf, 400.0] m: are these millimetres?"
            ]
        );
    }

    #[test]
    fn gravity_that_points_up_might_have_the_wrong_sign() {
        let found = doubts("-9.81", "9.81");
        assert!(
            found.len() == 1 && found[0].contains("gravity points up, z = 9.81 m/s²"),
            "{found:?}"
        );
    }
}
