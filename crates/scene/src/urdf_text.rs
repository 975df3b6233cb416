//! The text of a URDF: elements of it, and changes that leave the rest as it is.

use nalgebra::Vector3;
use roxmltree::Node;
use std::ops::Range;

/// Changes of a text, each of a stretch of it.
#[derive(Default)]
pub(crate) struct Edits(Vec<(Range<usize>, String)>);

impl Edits {
    pub fn replace(&mut self, range: Range<usize>, text: String) {
        self.0.push((range, text));
    }

    /// Adds text to the end of an element of the document `whole`.
    pub fn append(&mut self, node: Node, whole: &str, text: String) {
        let (range, tag) = (node.range(), node.tag_name().name());
        match whole[range.clone()].strip_suffix("/>") {
            Some(open) if !node.has_children() => {
                let end = range.start + open.len();
                self.replace(end..range.end, format!(">{text}</{tag}>"));
            }
            _ => {
                let before_end = whole[range.clone()].rfind("</").unwrap_or(0);
                let end = range.start + before_end;
                self.replace(end..end, text);
            }
        }
    }

    pub fn apply(mut self, text: &str) -> String {
        self.0.sort_by_key(|(range, _)| (range.start, range.end));
        let (mut out, mut done) = (String::new(), 0);
        for (range, new) in self.0 {
            out += &text[done..range.start];
            out += &new;
            done = range.end;
        }
        out + &text[done..]
    }
}

/// Children of an element with this tag.
pub(crate) fn children<'a, 'i, 't>(
    node: Node<'a, 'i>,
    tag: &'t str,
) -> impl Iterator<Item = Node<'a, 'i>> + use<'a, 'i, 't> {
    node.children().filter(move |x| x.has_tag_name(tag))
}

/// The first of them.
pub(crate) fn child<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    children(node, tag).next()
}

/// Three finite numbers.
pub(crate) fn vector(node: Node, attribute: &str) -> Option<Vector3<f64>> {
    let words = node.attribute(attribute)?.split_whitespace();
    let numbers: Vec<f64> = words.map(|word| word.parse().ok()).collect::<Option<_>>()?;
    let vector = Vector3::from_row_slice(numbers.get(..3)?);
    (numbers.len() == 3 && vector.iter().all(|x| x.is_finite())).then_some(vector)
}
