//! The contact sequence of a plan file, to be solved again.

use crate::failure::Failure;
use crate::plan_file;
use plan::Plan;
use scene::{Scene, Sequence, SequenceFile};
use std::fmt::Write;
use std::path::Path;

/// A sequence file's, or a plan file's if its name ends so.
pub(crate) fn load(path: &Path, scene: &Scene) -> Result<Sequence, Failure> {
    if path.extension().is_none_or(|extension| extension != "json") {
        return Ok(Sequence::load(path, scene)?);
    }
    let plan = plan_file::read(path)?;
    let name = path.display().to_string();
    let folder = path.parent().unwrap_or(Path::new(""));
    Ok(SequenceFile::from_toml(&toml(&plan), &name, folder)?.resolve(scene)?)
}

/// The phases of a plan as a sequence file. What people read in a plan says so in its labels.
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
