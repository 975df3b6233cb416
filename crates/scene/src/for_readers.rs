//! The text of a URDF as readers of a plan need it.
//!
//! A limit of velocity or effort that is missing or zero is none. Readers take the text at its word, or do not take it at all, so there
//! it says one that no joint comes to. Locked joints are fixed ones there. Damping and friction of joints (`<dynamics>`) are left out, as they are of
//! the plan's torques: who replays them would find that much missing. Settings for MuJoCo (`<mujoco>`) are left out: they name folders of
//! the file's own place, and who replays a plan has their own.

use crate::locked_joints::fix_if_locked;
use crate::urdf_text::{Edits, child, children};
use roxmltree::Document;

/// What stands for no limit [rad/s or m/s; N·m or N].
const NO_LIMIT: [(&str, &str); 2] = [("velocity", "1000"), ("effort", "100000")];

/// The text of a URDF with velocity and effort in every `<limit>`, without `<mujoco>` and `<dynamics>`, and with fixed joints for those that are `locked`
/// ([`multibody::Model::locked`]). A text that cannot be read is left as it is.
pub(crate) fn for_readers(urdf: &str, locked: &[(String, f64)]) -> String {
    let mut edits = Edits::default();
    if let Ok(document) = Document::parse(urdf) {
        let robot = document.root_element();
        for settings in children(robot, "mujoco") {
            edits.replace(settings.range(), String::new());
        }
        for joint in children(robot, "joint") {
            fix_if_locked(joint, locked, &mut edits);
            for resistance in children(joint, "dynamics") {
                edits.replace(resistance.range(), String::new());
            }
        }
        let joints = children(robot, "joint");
        for limit in joints.filter_map(|joint| child(joint, "limit")) {
            let mut missing = String::new();
            for (name, most) in NO_LIMIT {
                match limit.attribute_node(name) {
                    Some(given) if is_zero(given.value()) => {
                        edits.replace(given.range_value(), most.to_owned());
                    }
                    Some(_) => {}
                    None => missing.extend([" ", name, "=\"", most, "\""]),
                }
            }
            let name_ends = limit.range().start + "<limit".len();
            edits.replace(name_ends..name_ends, missing);
        }
    }
    edits.apply(urdf)
}

fn is_zero(text: &str) -> bool {
    text.trim().parse() == Ok(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_that_are_none_say_so_in_numbers_and_the_others_stay() {
        let joint = |limit: &str| format!("<robot><joint name=\"j\">{limit}</joint></robot>");
        for (before, after) in [
            (
                "<limit effort='9'/>",
                "<limit velocity=\"1000\" effort='9'/>",
            ),
            (
                "<limit velocity=\" 0.0\" effort='9'/>",
                "<limit velocity=\"1000\" effort='9'/>",
            ),
            (
                "<limit velocity='3' effort='0'/>",
                "<limit velocity='3' effort='100000'/>",
            ),
            (
                "<limit lower='0'/>",
                "<limit velocity=\"1000\" effort=\"100000\" lower='0'/>",
            ),
            (
                "<limit velocity='3' effort='2'/>",
                "<limit velocity='3' effort='2'/>",
            ),
            ("<axis xyz='0 0 1'/>", "<axis xyz='0 0 1'/>"),
        ] {
            assert_eq!(for_readers(&joint(before), &[]), joint(after));
        }
        assert_eq!(for_readers("<robot", &[]), "<robot");
    }

    #[test]
    fn what_resists_in_joints_is_left_out_be_they_locked_or_not() {
        let joint = |kind: &str, resistance: &str| {
            format!("<robot><joint name=\"j\" type=\"{kind}\">{resistance}</joint></robot>")
        };
        let before = joint("revolute", "<dynamics damping='2' friction='1'/>");
        assert_eq!(for_readers(&before, &[]), joint("revolute", ""));
        let locked = [("j".to_owned(), 0.0)];
        assert_eq!(for_readers(&before, &locked), joint("fixed", ""));
    }

    #[test]
    fn settings_for_mujoco_are_left_out() {
        let robot = |settings: &str| format!("<robot>{settings}<link name='a'/></robot>");
        let settings = "<mujoco><compiler meshdir='meshes'/></mujoco>";
        assert_eq!(for_readers(&robot(settings), &[]), robot(""));
    }
}
