//! Patches that are not where, or as large as, the faces that they stand for.

use crate::fit::contains;
use crate::notes::tips;
use crate::rules::fits;
use crate::{Interface, Owner, PlacedShape, Scene};
use nalgebra::Vector3;
use spatial::Pose;

/// How deep inside its own body a surface must be to be told, and how deep one is looked for [mm].
const SUNK: (u32, u32) = (5, 500);
/// How far behind the plane of a patch shapes count as its face [m], and how far it must reach beyond them to be told.
const BEHIND: f64 = 0.03;
const BEYOND: f64 = 0.015;
/// Room of a patch on another one, in its own half size, with which it counts as too tight to be met: the optimiser's bounds are met with
/// one per cent.
const TIGHT: f64 = 0.012;

impl Scene {
    /// How far it is along the normal of a surface out of the object or static body that it belongs to, where that is much: nothing gets
    /// at it there.
    pub(crate) fn inside_own_body(&self, interface: &Interface) -> Option<String> {
        let (body, shapes) = match interface.owner {
            Owner::Robot { .. } => return None,
            Owner::Object(o) => (&self.objects[o].name, &self.objects[o].shapes),
            Owner::Static(s) => (&self.statics[s].name, &self.statics[s].shapes),
        };
        let is_inside = |millimetres: u32| {
            let along = Vector3::new(0.0, 0.0, 1e-3 * f64::from(millimetres));
            let place = interface.body_from_interface.act(along);
            shapes.iter().any(|shape| contains(shape, &place))
        };
        let deep = (0..SUNK.1).find(|&at| !is_inside(at)).unwrap_or(SUNK.1);
        (deep > SUNK.0).then(|| {
            format!(
                "interface {:?} is {deep} mm inside the shapes of {body:?}, which it belongs to: nothing can touch it there; move its \
                 position outwards by as much, along its normal, or leave it out where side says enough",
                interface.name
            )
        })
    }

    /// Patches of the goal that fit onto others exactly: they could only stand there without any play, which no plan meets.
    pub(crate) fn too_tight_for_goal(&self) -> Vec<String> {
        let tight = self.goal_contacts.iter().filter_map(|goal| {
            let (a, b) = (&self.interfaces[goal.a.0], &self.interfaces[goal.b.0]);
            let (inner, outer) = (a.half_size?, b.half_size.filter(|_| !b.overhang)?);
            let room = |i: usize, j: usize| {
                (outer[0] - inner[i]).min(outer[1] - inner[j]) / inner[0].max(inner[1])
            };
            let most = room(0, 1).max(room(1, 0));
            (fits(a, b) && most < TIGHT).then(|| {
                let [x, y] = inner.map(|half| 2.0 * half);
                format!(
                    "interface {:?} ({x} m x {y} m) has no room on {:?}, where the goal has it: it would have to stand there without any \
                     play, which no plan meets; set overhang = true at {:?}, then its centre alone must be inside, or leave a centimetre",
                    a.name, b.name, b.name
                )
            })
        });
        tight.collect()
    }

    /// How far a patch of the robot reaches beyond the shapes behind it, where that is much: no force acts there.
    pub(crate) fn larger_than_link(&self, interface: &Interface) -> Option<String> {
        let (Owner::Robot { frame }, Some(half)) = (interface.owner, interface.half_size) else {
            return None;
        };
        let frames = &self.robot.model.frames;
        let joint_from_interface = frames[frame].joint_from_frame * interface.body_from_interface;
        let mut faces = vec![];
        for (link, shapes) in frames.iter().zip(&self.robot.shapes) {
            if link.joint == frames[frame].joint {
                let from_link = joint_from_interface.inverse() * link.joint_from_frame;
                faces.extend(shapes.iter().map(|shape| face(shape, &from_link)));
            }
        }
        let mut short = f64::NEG_INFINITY;
        for axis in 0..2 {
            for side in [-1.0, 1.0] {
                let reach = |point: &[f64; 2]| side * point[axis];
                let of_face = faces.iter().flatten().map(reach);
                short = short.max(half[axis] - of_face.fold(f64::NEG_INFINITY, f64::max));
            }
        }
        (short.is_finite() && short > BEYOND).then(|| {
            format!(
                "interface {:?} reaches {:.0} mm beyond the shapes of its link: half_size is to stay inside the real surface, since the \
                 centre of pressure may go to its edge",
                interface.name,
                1e3 * short
            )
        })
    }
}

/// How far a shape reaches along the plane of a patch, where it comes near that: points of it as the patch sees them.
fn face(placed: &PlacedShape, interface_from_body: &Pose) -> Vec<[f64; 2]> {
    let interface_from_shape = *interface_from_body * placed.body_from_shape;
    let mut points = vec![];
    for (tip, radius) in tips(&placed.shape) {
        let p = interface_from_shape.act(tip);
        if p.z + radius > -BEHIND {
            points.extend([[p.x - radius, p.y - radius], [p.x + radius, p.y + radius]]);
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use crate::Scene;
    use std::path::Path;

    #[test]
    fn a_surface_inside_its_own_body_is_told_and_one_on_its_face_is_not() {
        let scene = |position: &str| {
            let text = format!(
                "name = \"s\"\nrobot = \"g1\"\n[[static]]\nname = \"ground\"\nplane = true\n[[static]]\nname = \"wall\"\n\
                 size = [0.05, 2.0, 1.6]\nposition = [0.7, 0.0, 0.8]\ntop = false\n[[static.interface]]\nname = \"switch\"\n\
                 side = \"-x\"\n{position}half_size = [0.06, 0.06]\ncontacts = [\"unilateral_patch\"]\n\
                 [goal]\ncontacts = [[\"left_hand\", \"switch\"]]\n"
            );
            Scene::from_toml(&text, "s.toml", Path::new(".")).unwrap()
        };
        let notes = scene("position = [0.0, 0.1, 0.35]\n").notes();
        assert_eq!(notes.len(), 1, "{notes:?}");
        assert!(
            notes[0].contains("\"switch\" is 25 mm inside the shapes of \"wall\""),
            "{notes:?}"
        );
        for right in ["position = [-0.025, 0.1, 0.35]\n", ""] {
            assert_eq!(scene(right).notes(), Vec::<String>::new());
        }
    }

    #[test]
    fn a_box_that_is_to_stand_on_one_of_its_size_is_told_to_overhang() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/stack.toml");
        let text = std::fs::read_to_string(path).unwrap();
        let scene = |size: &str, more: &str| {
            let text = text.replace("size = [0.12, 0.12, 0.12]", size);
            let top = "name = \"green_box_top\"\n";
            let text = text.replace(top, &format!("{top}{more}"));
            Scene::from_toml(&text, "stack.toml", Path::new(".")).unwrap()
        };
        let same = "size = [0.14, 0.14, 0.12]";
        let notes = scene(same, "").notes();
        assert_eq!(notes.len(), 1, "{notes:?}");
        assert!(
            notes[0]
                .contains("\"red_box_bottom\" (0.14 m x 0.14 m) has no room on \"green_box_top\""),
            "{notes:?}"
        );
        for (size, more) in [
            ("size = [0.12, 0.12, 0.12]", ""),
            (same, "overhang = true\n"),
        ] {
            assert_eq!(scene(size, more).notes(), Vec::<String>::new());
        }
    }

    #[test]
    fn a_sole_that_is_larger_than_the_foot_is_told() {
        let mut scene = Scene::builtin("lift-box").unwrap();
        let foot = scene.interface_id("left_foot").unwrap().0;
        let told = |scene: &Scene| scene.larger_than_link(&scene.interfaces[foot]);
        assert_eq!(told(&scene), None);
        scene.interfaces[foot].half_size = Some([0.17, 0.027]);
        let note = told(&scene).expect("twice the length of the foot");
        assert!(note.contains("\"left_foot\" reaches"), "{note}");
    }
}
