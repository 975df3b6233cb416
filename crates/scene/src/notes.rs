//! What a user should know of a scene that is no error.

use crate::fit::contains;
use crate::{Interface, Owner, Role, Scene, Shape};
use multibody::{Centroidal, Joint, JointKind, Kinematics};
use nalgebra::{Vector2, Vector3};
use spatial::Inertia;

/// How far the centre of mass must be outside the soles to be told [m].
const LEAST: f64 = 1e-3;
/// How deep inside its own link a hand or foot must be to be told, and how deep one is looked for [mm].
const SUNK: (u32, u32) = (10, 300);
/// How far from a patch its own link is looked at for what sticks out beyond the patch's plane [m]: about as far as a finger.
const AROUND: f64 = 0.15;
/// Lever of the robot's weight beyond whose torque no motor of a humanoid gets [m]: the G1's give 0.43 m, the H1's 0.6 m.
const LONGEST_LEVER: f64 = 1.0;
/// Joints of a whole robot, at least.
const MANY: usize = 10;
/// Share by which the inertia about an axis may exceed that about the other two: what rounding does to a rod's.
const PLAY: f64 = 0.01;
/// Joints of a leg with which a sole stays where it is however the base moves.
const WHOLE_LEG: usize = 6;

impl Scene {
    /// What is unusual or left out: of the robot's description, and whether the robot can stand as it starts.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = self.robot.model.notes.clone();
        notes.extend(self.doubts.iter().cloned());
        notes.extend(self.shapeless());
        notes.extend(self.impossible_inertias());
        notes.extend(self.boundless_torques());
        for interface in &self.interfaces {
            let deep = self.inside_own_link(interface);
            if deep > SUNK.0 {
                notes.push(format!(
                    "interface {:?} is {deep} mm inside the shapes of its own link: what it touches will be that deep in the link; \
                     move its pose outwards by as much, along its normal",
                    interface.name
                ));
                continue;
            }
            notes.extend(self.inside_own_body(interface));
            notes.extend(self.larger_than_link(interface));
            notes.extend(self.beyond_plane(interface));
        }
        notes.extend(self.too_tight_for_goal());
        notes.extend(self.stretched());
        notes.extend(self.short_legs());
        if let Some(beyond) = self.beyond_soles().filter(|beyond| *beyond > LEAST) {
            notes.push(format!(
                "at the start the centre of mass is {:.0} mm outside the soles: the robot cannot stand like that, only fall or \
                 step; [home] of the robot file or start.joints of the scene change it",
                1e3 * beyond
            ));
        }
        notes
    }

    /// A whole robot whose home posture nobody gave.
    fn stretched(&self) -> Option<String> {
        let joints = &self.robot.model.joints[1..];
        let at_zero =
            |(joint, home): (&Joint, &f64)| *home == 0.0_f64.max(joint.lower).min(joint.upper);
        let all = joints.iter().zip(&self.robot.home).all(at_zero);
        (all && joints.len() >= MANY).then(|| {
            "in the home posture all joints are at zero, or at the limit nearest to it: if knees are straight there, plans keep them so, \
             at the edge of what legs can do; [home] of the robot file gives one, with the knees bent"
                .to_owned()
        })
    }

    /// Soles on legs of a whole robot that have too few joints.
    fn short_legs(&self) -> Option<String> {
        let model = &self.robot.model;
        let joints_to = |interface: &Interface| {
            let Owner::Robot { frame } = interface.owner else {
                return usize::MAX;
            };
            let up = |joint: &usize| model.joints[*joint].parent;
            let with_base = std::iter::successors(model.frames[frame].joint, up).count();
            with_base.saturating_sub(1)
        };
        let is_sole = |i: &&Interface| i.role == Role::Foot && i.half_size.is_some();
        let mut soles = self.interfaces.iter().filter(is_sole);
        let sole = soles.find(|sole| joints_to(sole) < WHOLE_LEG)?;
        let (name, joints) = (&sole.name, joints_to(sole));
        (model.joints.len() > MANY).then(|| {
            format!(
                "{joints} joints lead from the base to the sole of {name:?}: it takes {WHOLE_LEG} to keep a sole flat however the base \
                 moves. With fewer the robot shifts its weight from foot to foot hardly at all while both are flat, and steps, which \
                 begin with that here, are found seldom"
            )
        })
    }

    /// Hands and feet on bodies without a shape: nothing keeps them out of what they do not touch, and simulators let them through.
    fn shapeless(&self) -> Option<String> {
        let frames = &self.robot.model.frames;
        let is_bare = |interface: &&Interface| {
            let Owner::Robot { frame } = interface.owner else {
                return false;
            };
            let mut of_body = frames.iter().zip(&self.robot.shapes);
            !of_body.any(|(f, shapes)| f.joint == frames[frame].joint && !shapes.is_empty())
        };
        let bare: Vec<&str> = (self.interfaces.iter().filter(is_bare))
            .map(|interface| interface.name.as_str())
            .collect();
        (!bare.is_empty()).then(|| {
            format!(
                "{} {} no collision shape: nothing keeps what carries {} out of other things, and simulators let it through; give the \
                 links boxes, spheres, cylinders or meshes as <collision>",
                bare.join(", "),
                if bare.len() == 1 { "has" } else { "have" },
                if bare.len() == 1 { "it" } else { "them" },
            )
        })
    }

    /// Bodies with an inertia that nothing of their mass has.
    fn impossible_inertias(&self) -> Option<String> {
        let model = &self.robot.model;
        let is_impossible = |inertia: &Inertia| {
            let about = inertia.inertia.symmetric_eigenvalues();
            let (least, most) = (about.min(), about.max());
            // The triangle inequality: what is left of the sum of all three.
            inertia.mass > 0.0 && (least <= 0.0 || about.sum() < (2.0 - PLAY) * most)
        };
        let joints = (0..model.joints.len()).filter(|&j| is_impossible(&model.joints[j].inertia));
        let links: Vec<&str> = joints
            .filter_map(|j| model.frames.iter().find(|f| f.joint == Some(j)))
            .map(|f| f.name.as_str())
            .collect();
        (!links.is_empty()).then(|| {
            format!(
                "no body has an inertia like {}: zero, negative, or one axis more than the other two; it is taken as it is, but \
                 simulators refuse it",
                links.join(", ")
            )
        })
    }

    /// Torque limits that limit nothing, as simulators have them.
    fn boundless_torques(&self) -> Option<String> {
        let model = &self.robot.model;
        let most = LONGEST_LEVER * model.total_mass() * self.gravity.norm().max(1.0);
        let is_boundless = |joint: &&Joint| {
            let limit = joint.torque_limit;
            matches!(joint.kind, JointKind::Revolute { .. }) && limit.is_finite() && limit > most
        };
        let boundless: Vec<&Joint> = model.joints.iter().filter(is_boundless).collect();
        let first = boundless.first()?;
        Some(format!(
            "torque limits such as the {} N m of {} are beyond any motor of such a robot, whose whole weight on a lever of 1 m makes \
             {most:.0} N m; those of {} of its {} joints limit nothing: give the motors' own",
            first.torque_limit,
            first.name,
            boundless.len(),
            model.joints.len() - 1
        ))
    }

    /// How far it is along the normal of a hand or foot out of its own link, whole millimetres; 0 for what is not the robot's.
    pub fn inside_own_link(&self, interface: &Interface) -> u32 {
        let Owner::Robot { frame } = interface.owner else {
            return 0;
        };
        let frames = &self.robot.model.frames;
        let joint_from_interface = frames[frame].joint_from_frame * interface.body_from_interface;
        let is_inside = |millimetres: u32| {
            let along = Vector3::new(0.0, 0.0, 1e-3 * f64::from(millimetres));
            let place = joint_from_interface.act(along);
            let of_link = frames.iter().zip(&self.robot.shapes);
            let mut of_link = of_link.filter(|(f, _)| f.joint == frames[frame].joint);
            of_link.any(|(f, shapes)| {
                let in_frame = f.joint_from_frame.inverse().act(place);
                shapes.iter().any(|shape| contains(shape, &in_frame))
            })
        };
        (0..SUNK.1).find(|&at| !is_inside(at)).unwrap_or(SUNK.1)
    }

    /// What sticks out beyond the plane of a patch of the robot, near it: shapes of its own link, or of what that carries at the start.
    fn beyond_plane(&self, interface: &Interface) -> Option<String> {
        let (Owner::Robot { frame }, Some(_)) = (interface.owner, interface.half_size) else {
            return None;
        };
        let model = &self.robot.model;
        let own = model.frames[frame].joint;
        let mut kinematics = Kinematics::new(model);
        kinematics.update(model, &self.start);
        let interface_from_world =
            (kinematics.frame_pose(model, frame) * interface.body_from_interface).inverse();
        let mut most = (f64::from(SUNK.0), frame);
        for (link, shapes) in self.robot.shapes.iter().enumerate() {
            let joint = model.frames[link].joint;
            let parent = |j: &usize| model.joints[*j].parent;
            if !std::iter::successors(joint, parent).any(|j| Some(j) == own) {
                continue;
            }
            let interface_from_link = interface_from_world * kinematics.frame_pose(model, link);
            for placed in shapes {
                for (point, radius) in tips(&placed.shape) {
                    let p = (interface_from_link * placed.body_from_shape).act(point);
                    if p.xy().norm() <= AROUND && 1e3 * (p.z + radius) > most.0 {
                        most = (1e3 * (p.z + radius), link);
                    }
                }
            }
        }
        let (out, link) = most;
        let is_own = link == frame;
        let (name, link) = (&interface.name, &model.frames[link]);
        if out <= f64::from(SUNK.0) {
            None
        } else if link.joint == own {
            let of = if is_own {
                "its own link".to_owned()
            } else {
                format!(
                    "{}, which is one body with the link of the interface,",
                    link.name
                )
            };
            Some(format!(
                "shapes of {of} stick out {out:.0} mm beyond the plane of interface {name:?}: they will be that deep in what it \
                 touches, and in the way when it lets go; move its pose outwards by as much, along its normal, or give the link shapes \
                 that end there"
            ))
        } else {
            Some(format!(
                "as its joints are at the start, shapes of {} stick out {out:.0} mm beyond the plane of interface {name:?}, and are in \
                 the way of what it is to touch: bend them back in [home], or move the pose of the interface outwards by as much, \
                 along its normal",
                link.name
            ))
        }
    }

    /// Horizontal distance of the robot's centre of mass from the soles that bear it at the start, negative inside [m]; `None`
    /// if something else bears it too, or gravity is not along −z.
    fn beyond_soles(&self) -> Option<f64> {
        let model = &self.robot.model;
        let falls = self.gravity.xy().norm() < 1e-9 && self.gravity.z < 0.0;
        let mut kinematics = Kinematics::new(model);
        kinematics.update(model, &self.start);
        let mut corners = Vec::new();
        for contact in &self.start_contacts {
            let interface = &self.interfaces[contact.a.0];
            let Owner::Robot { frame } = interface.owner else {
                continue;
            };
            if interface.role != Role::Foot {
                return None;
            }
            let [x, y] = interface.half_size.unwrap_or([0.0; 2]);
            let world_from_foot =
                kinematics.frame_pose(model, frame) * interface.body_from_interface;
            for (i, j) in [(-x, -y), (-x, y), (x, y), (x, -y)] {
                corners.push(world_from_foot.act(Vector3::new(i, j, 0.0)).xy());
            }
        }
        let mut centroidal = Centroidal::new(model);
        centroidal.compute(model, &kinematics);
        (falls && !corners.is_empty()).then(|| outside(&corners, centroidal.com().xy()))
    }
}

/// Points of a shape, with the radius of what is round about them [m], one of which is farthest out in any direction.
pub(crate) fn tips(shape: &Shape) -> Vec<(Vector3<f64>, f64)> {
    match shape {
        Shape::Box { half_size } => {
            let sign = |code: usize, k: usize| if code >> k & 1 == 0 { -1.0 } else { 1.0 };
            let corner = |code| Vector3::from_fn(|k, _| sign(code, k) * half_size[k]);
            (0..8).map(|code| (corner(code), 0.0)).collect()
        }
        Shape::Sphere { radius } => vec![(Vector3::zeros(), *radius)],
        Shape::Capsule {
            radius,
            half_length,
        } => [-half_length, *half_length]
            .map(|z| (Vector3::new(0.0, 0.0, z), *radius))
            .into(),
        Shape::HalfSpace => vec![],
    }
}

/// Distance of a point from the convex hull of others; negative inside, as far as the nearest edge.
fn outside(corners: &[Vector2<f64>], point: Vector2<f64>) -> f64 {
    // A point is as far outside as it is beyond the farthest of the corners in some direction.
    (0..360)
        .map(|degree| {
            let (y, x) = f64::from(degree).to_radians().sin_cos();
            let along = Vector2::new(x, y);
            let most = corners.iter().map(|c| along.dot(c));
            along.dot(&point) - most.fold(f64::NEG_INFINITY, f64::max)
        })
        .fold(f64::NEG_INFINITY, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PlacedShape;
    use spatial::Pose;

    #[test]
    fn a_point_is_outside_a_square_by_its_distance_from_the_edge_or_the_corner() {
        let square =
            [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Vector2::new(x, y));
        let beyond = |x, y| outside(&square, Vector2::new(x, y));
        assert!((beyond(0.5, 0.5) + 0.5).abs() < 1e-9);
        assert!((beyond(0.5, 1.2) - 0.2).abs() < 1e-9);
        assert!((beyond(1.3, 1.3) - 0.3 * 2f64.sqrt()).abs() < 1e-4);
    }

    #[test]
    fn a_hand_inside_its_own_link_is_told() {
        let hand = |z: f64| {
            let text = format!(
                "name = \"s\"\nrobot = \"g1\"\n[[robot_interface]]\nname = \"shin\"\nlink = \"left_knee_link\"\nkind = \"point\"\n\
                 role = \"hand\"\npose = [0, 0, {z}, 1, 0, 0, 0]\ncontacts = [\"unilateral_point\"]\n[[static]]\n\
                 name = \"ground\"\nplane = true\n[objective]\nkind = \"base_height\"\n"
            );
            let path = std::path::Path::new(".");
            Scene::from_toml(&text, "s.toml", path).unwrap().notes()
        };
        let notes = hand(-0.1);
        assert!(notes.len() == 1, "{notes:?}");
        assert!(notes[0].contains("\"shin\" is"), "{notes:?}");
        assert_eq!(hand(-0.5), Vec::<String>::new());
    }

    #[test]
    fn fingers_beyond_the_plane_of_a_palm_are_told() {
        let mut scene = Scene::builtin("pick-place").unwrap();
        assert_eq!(scene.notes(), Vec::<String>::new());
        let hand = &scene.interfaces[2];
        let Owner::Robot { frame } = hand.owner else {
            panic!("{hand:?}");
        };
        // A ball beside the palm, and one so far away that it is no part of a hand.
        let finger = |x: f64| PlacedShape {
            body_from_shape: hand.body_from_interface * Pose::from_translation(x, 0.0, 0.02),
            shape: Shape::Sphere { radius: 0.01 },
        };
        let (near, far) = (finger(0.1), finger(0.3));
        let told = format!("30 mm beyond the plane of interface {:?}", hand.name);
        scene.robot.shapes[frame].push(far);
        assert_eq!(scene.notes(), Vec::<String>::new());
        scene.robot.shapes[frame].push(near);
        assert!(scene.notes()[0].contains(&told), "{:?}", scene.notes());
    }

    #[test]
    fn what_a_link_carries_on_joints_of_its_own_is_told_if_it_sticks_out_at_the_start() {
        let mut scene = Scene::builtin("pick-place").unwrap();
        let elbow = (scene.robot.model.frames.iter())
            .position(|f| f.name == "left_elbow_link")
            .unwrap();
        // A patch at the end of the forearm, which looks along it, so that the wrist and the hand are in its way.
        let patch = &mut scene.interfaces[2];
        assert_eq!(patch.name, "left_hand");
        patch.owner = Owner::Robot { frame: elbow };
        patch.body_from_interface = Pose::from_xyzquat(&[0.1, 0.0, 0.0, 0.0, 0.5, 0.0, 0.5]);
        let notes = scene.notes();
        assert!(
            notes[0].contains("in [home]") && notes[0].contains("left_"),
            "{notes:?}"
        );
    }

    #[test]
    fn a_start_that_leans_too_far_is_told_and_the_built_in_robot_at_home_is_not() {
        let text = |joints: &str| {
            format!(
                "name = \"s\"\nrobot = \"g1\"\n[start]\njoints = {{ {joints} }}\n[[static]]\nname = \"ground\"\n\
                 plane = true\n[objective]\nkind = \"base_height\"\n"
            )
        };
        let notes = |joints: &str| {
            let path = std::path::Path::new(".");
            Scene::from_toml(&text(joints), "s.toml", path)
                .unwrap()
                .notes()
        };
        assert_eq!(notes(""), Vec::<String>::new());
        let legs =
            |side: &str| format!("{side}_hip_pitch_joint = 0.06, {side}_ankle_pitch_joint = -0.56");
        let leaning = notes(&format!("{}, {}", legs("left"), legs("right")));
        assert!(
            leaning.len() == 1 && leaning[0].contains("outside the soles"),
            "{leaning:?}"
        );
    }

    #[test]
    fn feet_without_a_shape_and_impossible_inertias_are_told() {
        let builtin = || Scene::builtin("side-step").unwrap();
        assert_eq!(builtin().notes(), Vec::<String>::new());
        let mut bare = builtin();
        bare.robot.shapes.iter_mut().for_each(Vec::clear);
        assert!(
            bare.notes()[0].contains("left_foot, right_foot"),
            "{:?}",
            bare.notes()
        );
        let mut rod = builtin();
        rod.robot.model.joints[3].inertia.inertia =
            nalgebra::Matrix3::from_diagonal(&Vector3::new(1.0, 0.2, 0.3));
        assert!(
            rod.notes()[0].contains("left_hip_yaw_link"),
            "{:?}",
            rod.notes()
        );
    }

    #[test]
    fn torque_limits_that_no_motor_has_are_told() {
        let mut scene = Scene::builtin("side-step").unwrap();
        let joints = &mut scene.robot.model.joints;
        (joints[2].torque_limit, joints[3].torque_limit) = (f64::INFINITY, 2e4);
        let note = &scene.notes()[0];
        for part in [
            "20000 N m",
            &scene.robot.model.joints[3].name,
            "1 of its 29",
        ] {
            assert!(note.contains(part), "{note}");
        }
    }

    #[test]
    fn legs_without_enough_joints_for_flat_soles_are_told() {
        let mut scene = Scene::builtin("side-step").unwrap();
        assert_eq!(scene.notes(), Vec::<String>::new());
        let model = &mut scene.robot.model;
        let roll = |joint: &Joint| joint.name == "left_ankle_roll_joint";
        let at = model.joints.iter().position(roll).unwrap();
        let above = model.joints[at].parent;
        let of_foot = model.frames.iter_mut().filter(|f| f.joint == Some(at));
        of_foot.for_each(|frame| frame.joint = above);
        let notes = scene.notes();
        let told = |note: &&String| note.starts_with("5 joints lead") && note.contains("left_foot");
        assert_eq!(notes.iter().filter(told).count(), 1, "{notes:?}");
    }

    #[test]
    fn a_whole_robot_without_a_home_posture_is_told() {
        let mut scene = Scene::builtin("lift-box").unwrap();
        let told = |scene: &Scene| scene.notes().iter().any(|note| note.contains("at zero"));
        assert!(!told(&scene));
        let limits = scene.robot.model.joints[1..].iter();
        scene.robot.home = limits.map(|j| 0.0_f64.clamp(j.lower, j.upper)).collect();
        assert!(told(&scene));
    }
}
