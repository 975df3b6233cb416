//! The contact sequence of a plan file, to be solved again.

use crate::failure::Failure;
use crate::plan_file;
use plan::Plan;
use scene::{Scene, Sequence, SequenceFile};
use std::fmt::Write;
use std::path::Path;

/// True if a file is named as a plan, not as a sequence.
pub(crate) fn is_plan(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension == "json")
}

/// The sequence of a sequence file or, if its name ends with `.json`, of a plan file.
pub(crate) fn load(path: &Path, scene: &Scene) -> Result<Sequence, Failure> {
    if !is_plan(path) {
        return Ok(Sequence::load(path, scene)?);
    }
    let plan = plan_file::read(path)?;
    // Lines of an error are those of the sequence, not of the plan file.
    let name = format!("sequence of {}", path.display());
    let folder = path.parent().unwrap_or(Path::new(""));
    Ok(SequenceFile::from_toml(&toml(&plan), &name, folder)?.resolve(scene)?)
}

/// The phases of a plan as the text of a sequence file.
fn toml(plan: &Plan) -> String {
    // Basic strings of TOML are written as those of JSON.
    let quoted = |text: &str| serde_json::Value::from(text).to_string();
    let mut text = String::new();
    for phase in &plan.phases {
        let _ = writeln!(
            text,
            "[[phase]]\nlabel = {}\ncontacts = [",
            quoted(&phase.action)
        );
        for contact in &phase.contacts {
            let kind = serde_json::to_value(contact.kind).unwrap_or_default();
            let (a, b) = (quoted(&contact.a), quoted(&contact.b));
            let _ = writeln!(text, "    [{a}, {b}, {kind}],");
        }
        text += "]\n\n";
    }
    text
}
