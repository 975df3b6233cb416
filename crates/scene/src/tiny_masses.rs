//! Links without mass between two joints, as in a universal joint. Simulators refuse what moves and has no mass, so in the text of a
//! URDF such links get as little as makes no difference.

use crate::urdf_text::{Edits, child, children};
use roxmltree::{Document, Node};

/// A millionth of a kilogram, in a ball of a few centimetres.
const TINY: &str = "<inertial><mass value=\"1e-6\"/><inertia ixx=\"1e-9\" ixy=\"0\" ixz=\"0\" iyy=\"1e-9\" iyz=\"0\" \
                    izz=\"1e-9\"/></inertial>";

/// The text of a URDF with that. A text that cannot be read is left as it is, and so are links without mass at the end of a limb.
pub(crate) fn with_tiny_masses(urdf: &str) -> String {
    let mut edits = Edits::default();
    if let Ok(document) = Document::parse(urdf) {
        let robot = document.root_element();
        let joints: Vec<Joint> = children(robot, "joint").filter_map(Joint::of).collect();
        for link in children(robot, "link") {
            let Some(name) = link.attribute("name") else {
                continue;
            };
            let moves = |joint: &Joint| joint.moves && joint.child == name;
            if joints.iter().any(moves) {
                let body = body(name, &joints);
                let carries = |joint: &Joint| joint.moves && body.contains(&joint.parent);
                if !has_mass(robot, &body) && joints.iter().any(carries) {
                    edits.append(link, urdf, TINY.to_owned());
                }
            }
        }
    }
    edits.apply(urdf)
}

struct Joint<'a> {
    parent: &'a str,
    child: &'a str,
    moves: bool,
}

impl<'a> Joint<'a> {
    fn of(node: Node<'a, '_>) -> Option<Self> {
        let end = |tag| child(node, tag)?.attribute("link");
        Some(Self {
            parent: end("parent")?,
            child: end("child")?,
            moves: node.attribute("type") != Some("fixed"),
        })
    }
}

/// A link and all that is fixed to it further out.
fn body<'a>(link: &'a str, joints: &[Joint<'a>]) -> Vec<&'a str> {
    let mut body = vec![link];
    let mut next = 0;
    while let Some(&parent) = body.get(next) {
        for joint in joints.iter().filter(|j| !j.moves && j.parent == parent) {
            if !body.contains(&joint.child) {
                body.push(joint.child);
            }
        }
        next += 1;
    }
    body
}

fn has_mass(robot: Node, body: &[&str]) -> bool {
    children(robot, "link").any(|link| {
        let is_part = link
            .attribute("name")
            .is_some_and(|name| body.contains(&name));
        is_part && child(link, "inertial").is_some()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_has_no_mass_between_two_joints_gets_some() {
        let joint = |kind: &str, parent: &str, child: &str| {
            format!(
                "<joint name='{child}' type='{kind}'><parent link='{parent}'/><child link='{child}'/></joint>"
            )
        };
        let heavy = "<inertial><mass value='1'/></inertial>";
        let urdf = |cross: &str| {
            format!(
                "<robot><link name='root'>{heavy}</link>{cross}<link name='foot'>{heavy}</link><link name='shell'/>\
                 <link name='core'>{heavy}</link><link name='tip'/><link name='end'/>{}{}{}{}{}{}</robot>",
                joint("revolute", "root", "cross"),
                joint("revolute", "cross", "foot"),
                joint("fixed", "foot", "tip"),
                joint("continuous", "foot", "shell"),
                joint("fixed", "shell", "core"),
                joint("revolute", "core", "end"),
            )
        };
        let filled = format!("<link name='cross'>{TINY}</link>");
        assert_eq!(
            with_tiny_masses(&urdf("<link name='cross'/>")),
            urdf(&filled)
        );
        assert_eq!(with_tiny_masses(&urdf(&filled)), urdf(&filled));
        assert_eq!(with_tiny_masses("<robot"), "<robot");
    }
}
