//! `<include>`: the children of another file's outermost element, whatever that is called, in place of it.

use crate::error::MjcfError;
use roxmltree::{Document, Node};
use std::path::{Path, PathBuf};

/// The text of a file with what it includes.
pub fn whole_text(path: &Path) -> Result<String, MjcfError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    with_included(path, folder, &mut vec![])
}

/// The same; included files are looked for in `folder`, and each may come once.
fn with_included(path: &Path, folder: &Path, seen: &mut Vec<PathBuf>) -> Result<String, MjcfError> {
    let fault = |reason: String| MjcfError::File {
        file: path.display().to_string(),
        reason,
    };
    if seen.iter().any(|p| p == path) {
        return Err(fault("it is included twice".into()));
    }
    seen.push(path.to_owned());
    let text = std::fs::read_to_string(path).map_err(|error| fault(error.to_string()))?;
    let document = Document::parse(&text).map_err(|error| fault(error.to_string()))?;
    let (mut out, mut done) = (String::new(), 0);
    for node in document.descendants().filter(|n| n.has_tag_name("include")) {
        let Some(file) = node.attribute("file") else {
            return Err(fault("<include> without file=\"...\"".into()));
        };
        let included = with_included(&folder.join(file), folder, seen)?;
        let inner = Document::parse(&included).map_err(|error| fault(error.to_string()))?;
        out += &text[done..node.range().start];
        out += inside(inner.root_element(), &included);
        done = node.range().end;
    }
    Ok(out + &text[done..])
}

/// The text between an element's tags.
fn inside<'t>(element: Node, text: &'t str) -> &'t str {
    match (element.first_child(), element.last_child()) {
        (Some(first), Some(last)) => &text[first.range().start..last.range().end],
        _ => "",
    }
}
