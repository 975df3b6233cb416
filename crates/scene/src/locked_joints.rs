//! Joints that a model locks, in the text of a URDF: a plan says nothing of them, and to simulators they would be joints that nothing
//! drives.

use crate::urdf_text::{Edits, child, vector};
use nalgebra::{Rotation3, Translation3, Unit, Vector3};
use roxmltree::Node;

/// Makes a joint a fixed one if it is among those that are `locked` ([`multibody::Model::locked`]), where it is locked.
pub(crate) fn fix_if_locked(joint: Node, locked: &[(String, f64)], edits: &mut Edits) {
    let Some(kind) = joint.attribute_node("type") else {
        return;
    };
    let is_this = |(name, _): &&(String, f64)| joint.attribute("name") == Some(name);
    let Some(&(_, position)) = locked.iter().find(is_this) else {
        return;
    };
    let origin = child(joint, "origin");
    let of_origin = |attribute| {
        origin
            .and_then(|x| vector(x, attribute))
            .unwrap_or_default()
    };
    let axis = child(joint, "axis").and_then(|x| vector(x, "xyz"));
    let axis = Unit::new_normalize(axis.unwrap_or(Vector3::x()));
    let [roll, pitch, yaw] = of_origin("rpy").into();
    let mut rotation = Rotation3::from_euler_angles(roll, pitch, yaw);
    let mut place = Translation3::from(of_origin("xyz"));
    if kind.value() == "prismatic" {
        place.vector += rotation * axis.into_inner() * position;
    } else {
        rotation *= Rotation3::from_axis_angle(&axis, position);
    }
    if position != 0.0 {
        let (roll, pitch, yaw) = rotation.euler_angles();
        let [x, y, z] = place.vector.into();
        let text = format!("<origin xyz=\"{x} {y} {z}\" rpy=\"{roll} {pitch} {yaw}\"/>");
        match origin {
            Some(origin) => edits.replace(origin.range(), text),
            None => edits.append(joint, joint.document().input_text(), text),
        }
    }
    if let Some(mimic) = child(joint, "mimic") {
        edits.replace(mimic.range(), String::new());
    }
    edits.replace(kind.range_value(), "fixed".to_owned());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::urdf_text::children;
    use multibody::{Kinematics, Model, Root};
    use roxmltree::Document;

    fn fixed(urdf: &str) -> String {
        let model = Model::from_urdf(urdf, Root::Floating).unwrap();
        let (document, mut edits) = (Document::parse(urdf).unwrap(), Edits::default());
        for joint in children(document.root_element(), "joint") {
            fix_if_locked(joint, &model.locked, &mut edits);
        }
        edits.apply(urdf)
    }

    /// Two links, the second on a joint with these elements.
    fn robot(kind: &str, elements: &str) -> String {
        let link = |name: &str| {
            format!(
                "<link name='{name}'><inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/>\
                 </inertial></link>"
            )
        };
        format!(
            "<robot name='r'>{}{}<joint name='j' type='{kind}'><parent link='a'/><child link='b'/>{elements}</joint></robot>",
            link("a"),
            link("b")
        )
    }

    #[test]
    fn a_joint_that_is_locked_is_fixed_where_it_was() {
        let origin = "<origin xyz='0.1 0.2 0.3' rpy='0.4 0.5 0.6'/>";
        let axis = "<axis xyz='0 0.6 0.8'/>";
        let range = "<limit lower='-1' upper='1' effort='1' velocity='1'/>";
        let point = "<limit lower='0.7' upper='0.7' effort='1' velocity='1'/>";
        let mimic = "<mimic joint='j' offset='-0.3'/>";
        for (kind, elements) in [
            ("revolute", [origin, axis, range, mimic].concat()),
            ("revolute", [axis, range, mimic].concat()),
            ("prismatic", [origin, axis, point].concat()),
            ("continuous", [origin, mimic].concat()),
        ] {
            let before = robot(kind, &elements);
            let after = fixed(&before);
            assert!(
                after.contains("type='fixed'") && !after.contains("mimic"),
                "{after}"
            );
            let [pose, same] = [before, after].map(|text| {
                let model = Model::from_urdf(&text, Root::Floating).unwrap();
                assert_eq!(model.nv, 6);
                let mut kinematics = Kinematics::new(&model);
                kinematics.update(&model, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
                kinematics.frame_pose(&model, 1)
            });
            assert!(pose.minus(&same).norm() < 1e-12, "{kind}: {elements}");
        }
    }

    #[test]
    fn a_joint_that_moves_stays_as_it_is() {
        for (kind, elements) in [
            (
                "revolute",
                "<axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='1' velocity='1'/>",
            ),
            (
                "continuous",
                "<axis xyz='0 0 1'/><limit effort='1' velocity='1'/>",
            ),
            ("fixed", ""),
        ] {
            let text = robot(kind, elements);
            assert_eq!(fixed(&text), text);
        }
    }
}
