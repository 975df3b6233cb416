//! Damaged scene texts: an answer every time, never a panic, and messages that can be shown.

use crate::fixtures::{VALID, read};
use scene::{Scene, SceneError};
use std::path::Path;

/// Values that stand where others are expected.
const STRANGE: [&str; 18] = [
    "nan",
    "inf",
    "-inf",
    "-1",
    "0",
    "1e308",
    "1e-320",
    "9223372036854775807",
    "true",
    "\"\"",
    "\"ö\\u0000\"",
    "[]",
    "{}",
    "[[]]",
    "[nan, nan, nan]",
    "[0, 0, 0, 0]",
    "1979-05-27T07:32:00Z",
    "",
];

fn survives(text: &str) -> bool {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes");
    match Scene::from_toml(text, "damaged.toml", &folder) {
        Ok(scene) => {
            assert!(scene.start.iter().all(|x| x.is_finite()), "{text}");
            assert_eq!(scene.start.len(), scene.robot.model.nq);
            let finite = |m: &nalgebra::Matrix3<f64>| m.iter().all(|x| x.is_finite());
            assert!(scene.objects.iter().all(|object| finite(&object.inertia)));
            true
        }
        Err(error) => {
            check_shown(&error);
            false
        }
    }
}

fn check_shown(error: &SceneError) {
    assert!(!error.to_string().is_empty());
    assert!(!error.render().is_empty());
    assert!(error.place().is_some_and(|place| place.line() > 0));
}

fn texts() -> [&'static str; 2] {
    [VALID, include_str!("scenes/hopper.toml")]
}

#[test]
fn texts_cut_anywhere() {
    for text in texts() {
        for end in (0..text.len())
            .filter(|i| text.is_char_boundary(*i))
            .step_by(3)
        {
            survives(&text[..end]);
        }
    }
}

#[test]
fn texts_without_one_line_or_with_one_twice() {
    for text in texts() {
        let lines: Vec<&str> = text.lines().collect();
        for skipped in 0..lines.len() {
            let mut kept = lines.clone();
            kept.remove(skipped);
            survives(&kept.join("\n"));
            kept.insert(skipped, lines[skipped]);
            kept.insert(skipped, lines[skipped]);
            survives(&kept.join("\r\n"));
        }
    }
}

#[test]
fn strange_values_everywhere() {
    let mut accepted = 0;
    for text in texts() {
        let lines: Vec<&str> = text.lines().collect();
        for (index, line) in lines.iter().enumerate() {
            let Some((key, _)) = line.split_once(" = ") else {
                continue;
            };
            for value in STRANGE {
                let changed = format!("{key} = {value}");
                let mut all = lines.clone();
                all[index] = &changed;
                accepted += usize::from(survives(&all.join("\n")));
            }
        }
    }
    // some are harmless, such as another yaw; most must be refused
    assert!((1..400).contains(&accepted), "{accepted} accepted");
}

#[test]
fn single_characters_changed() {
    let replacements = [
        '[', ']', '"', '=', '.', '-', '9', 'e', '\n', '#', 'ß', '\u{0}',
    ];
    for text in texts() {
        for (count, (index, old)) in text.char_indices().enumerate() {
            let new = replacements[(count * 7 + index) % replacements.len()];
            let rest = &text[index + old.len_utf8()..];
            survives(&format!("{}{new}{rest}", &text[..index]));
        }
    }
}

#[test]
fn the_undamaged_texts_pass() {
    assert!(texts().into_iter().all(survives));
    assert!(read(VALID).is_ok());
}
