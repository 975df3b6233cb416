//! Actions in words, for people.

use super::ground::GroundAction;
use super::syntax::DomainFile;
use super::vocabulary::ScenePart;
use crate::domain::Domain;

/// Labels of ground actions: those of the built-in domain read like sentences (`grasp red_box with left_hand`), others
/// are the action's name and its arguments.
///
/// Where two actions of the built-in domain would read alike, the surfaces are named too.
pub(crate) fn labels(
    file: &DomainFile,
    domain: &Domain,
    names: &[(String, usize)],
    parts: &[ScenePart],
    actions: &[GroundAction],
) -> Vec<String> {
    let name = |n: usize| match parts[n] {
        ScenePart::Interface(id) => domain.interface(id).name.as_str(),
        ScenePart::Object(object) => domain.objects()[object].as_str(),
        ScenePart::Constant => names[n].0.as_str(),
    };
    let plain = |ground: &GroundAction| {
        let words = ground.arguments.iter().map(|&n| name(n));
        std::iter::once(file.actions[ground.action].name.as_str())
            .chain(words)
            .collect::<Vec<_>>()
            .join(" ")
    };
    if !file.is_builtin() {
        return actions.iter().map(plain).collect();
    }
    let sentence = |ground: &GroundAction| {
        let words: Vec<&str> = ground.arguments.iter().map(|&n| name(n)).collect();
        match (file.actions[ground.action].name.as_str(), words.as_slice()) {
            ("grasp", [h, o, s]) => (format!("grasp {o} with {h}"), format!(" at {s}")),
            ("squeeze", [o, s1, s2, h1, h2]) => {
                // the hands in the order of the scene
                let swap = ground.arguments[3] > ground.arguments[4];
                let [h1, s1, h2, s2] = if swap {
                    [h2, s2, h1, s1]
                } else {
                    [h1, s1, h2, s2]
                };
                let short = format!("grasp {o} with {h1} and {h2}");
                (short, format!(" at {s1} and {s2}"))
            }
            ("lift", [o]) => (format!("lift {o}"), String::new()),
            ("place", [o, s, t]) => (format!("place {o} on {t}"), format!(" by {s}")),
            ("attach", [o, s, t]) => (format!("attach {o} to {t}"), format!(" by {s}")),
            ("release", [_, o, _]) | ("let-go", [o, ..]) => (format!("release {o}"), String::new()),
            _ => (plain(ground), String::new()),
        }
    };
    let sentences: Vec<(String, String)> = actions.iter().map(sentence).collect();
    let alike = |short: &str| sentences.iter().filter(|(other, _)| other == short).count() > 1;
    let label = |(short, more): &(String, String)| {
        if alike(short) {
            format!("{short}{more}")
        } else {
            short.clone()
        }
    };
    sentences.iter().map(label).collect()
}
