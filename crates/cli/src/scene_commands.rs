//! `locotamp scenes`: what is built in.

use crate::failure::Failure;
use crate::{Exit, output};
use scene::Scene;
use std::fmt::Write;

/// Lists the built-in scenes, or prints the text of one.
pub(crate) fn scenes(name: Option<&str>) -> Result<Exit, Failure> {
    let Some(name) = name else {
        let mut text = String::new();
        for name in Scene::builtin_names() {
            let about = Scene::builtin_text(name).map(about).unwrap_or_default();
            let _ = writeln!(text, "{name:12} {about}");
        }
        output::result(&text);
        return Ok(Exit::Done);
    };
    match Scene::builtin_text(name) {
        Some(text) => output::result(text),
        None => drop(Scene::builtin(name)?),
    }
    Ok(Exit::Done)
}

/// The first two sentences of the comment at the head of a scene.
fn about(text: &str) -> String {
    let comment: Vec<&str> = text
        .lines()
        .map_while(|line| line.strip_prefix('#'))
        .map(str::trim)
        .collect();
    let sentences: Vec<String> = comment
        .join(" ")
        .split_inclusive(". ")
        .take(2)
        .map(str::to_owned)
        .collect();
    sentences.concat().trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_is_described_by_two_sentences_of_its_head() {
        let text =
            "# The robot lifts\n# a box by 0.1 m. Both hands. More.\nname = \"x\"\n# no head\n";
        assert_eq!(about(text), "The robot lifts a box by 0.1 m. Both hands.");
        for name in Scene::builtin_names() {
            assert!(
                about(Scene::builtin_text(name).unwrap()).len() > 20,
                "{name}"
            );
        }
    }
}
