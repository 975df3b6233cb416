//! `actuatorfrcrange` of joints, which the parser does not keep: of the joint itself, of its class, or of the class of the bodies
//! around it.

use roxmltree::{Document, Node};
use std::collections::BTreeMap;

/// Ranges by name of the joint [N·m or N].
pub type ForceRanges = BTreeMap<String, [f64; 2]>;

/// Name of the attribute.
const RANGE: &str = "actuatorfrcrange";
/// The class of what names none.
const MAIN: &str = "main";

/// The ranges that a text gives. One that cannot be read gives none: the parser says why.
pub fn read(text: &str) -> ForceRanges {
    let mut ranges = ForceRanges::new();
    let Ok(document) = Document::parse(text) else {
        return ranges;
    };
    let mut classes = BTreeMap::new();
    for node in elements(document.root_element(), "default") {
        add_classes(node, MAIN, None, &mut classes);
    }
    for node in elements(document.root_element(), "worldbody") {
        add_joints(node, MAIN, &classes, &mut ranges);
    }
    ranges
}

fn elements<'a, 'i>(node: Node<'a, 'i>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |n| n.has_tag_name(tag))
}

fn range(joint: Node) -> Option<[f64; 2]> {
    let mut numbers = joint.attribute(RANGE)?.split_whitespace().map(str::parse);
    match [numbers.next(), numbers.next()] {
        [Some(Ok(low)), Some(Ok(high))] => Some([low, high]),
        _ => None,
    }
}

/// The ranges of a class and of those within it, which have its own unless they say otherwise.
fn add_classes(
    node: Node,
    name: &str,
    inherited: Option<[f64; 2]>,
    classes: &mut BTreeMap<String, [f64; 2]>,
) {
    let own = elements(node, "joint").find_map(range).or(inherited);
    if let Some(own) = own {
        classes.insert(name.to_owned(), own);
    }
    for inner in elements(node, "default") {
        add_classes(
            inner,
            inner.attribute("class").unwrap_or(MAIN),
            own,
            classes,
        );
    }
}

/// The ranges of the joints of a body and of the bodies on it; `class` is that of joints that name none.
fn add_joints(
    body: Node,
    class: &str,
    classes: &BTreeMap<String, [f64; 2]>,
    ranges: &mut ForceRanges,
) {
    let class = body.attribute("childclass").unwrap_or(class);
    for joint in elements(body, "joint") {
        let of_class = || classes.get(joint.attribute("class").unwrap_or(class));
        let range = range(joint).or_else(|| of_class().copied());
        if let (Some(name), Some(range)) = (joint.attribute("name"), range) {
            ranges.insert(name.to_owned(), range);
        }
    }
    let inner = body.children();
    for node in inner.filter(|n| n.has_tag_name("body") || n.has_tag_name("frame")) {
        add_joints(node, class, classes, ranges);
    }
}
