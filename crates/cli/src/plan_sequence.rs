//! The contact sequence of a plan file, to be solved again from its configurations.

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
    let sequence = SequenceFile::from_toml(&toml(&plan), &name, folder)?.resolve(scene)?;
    Ok(Sequence {
        configurations: configurations(&plan, scene).unwrap_or_default(),
        ..sequence
    })
}

/// Configurations at the phase boundaries of a plan; `None` if its robot has other joints than that of the scene, or it does not
/// know an object.
fn configurations(plan: &Plan, scene: &Scene) -> Option<Vec<Vec<f64>>> {
    let joints = scene.robot.model.joints.iter();
    let joints = joints.filter(|joint| joint.kind.nv() == 1);
    if !joints.map(|joint| &joint.name).eq(&plan.robot.joints) {
        return None;
    }
    let of_objects: Option<Vec<_>> = (scene.objects.iter())
        .map(|object| plan.object_states.get(&object.name))
        .collect();
    let of_objects = of_objects?;
    let at = |node: usize| {
        let mut q = plan.q.get(node)?.clone();
        for states in &of_objects {
            q.extend(states.pose.get(node)?);
        }
        Some(q)
    };
    let ends = plan.phases.iter().scan(0, |node, phase| {
        *node += phase.steps;
        Some(*node)
    });
    std::iter::once(0).chain(ends).map(at).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use locotamp::Request;

    #[test]
    fn configurations_are_those_between_the_phases_with_the_objects() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../scenes/sequences/boxes/pick_place.toml");
        let file = SequenceFile::load(path).expect("a file");
        let mut scene = file.load_scene().expect("its scene");
        let sequence = file.resolve(&scene).expect("a sequence of the scene");
        let request = Request {
            time_limit: 0.0,
            explain: false,
            ..Request::default()
        };
        let solved = locotamp::solve(&scene, &sequence, &request, &mut |_| true);
        let plan = solved
            .expect("a planning problem")
            .best
            .expect("a motion")
            .plan;
        let found = configurations(&plan, &scene).expect("the same robot and object");
        let box_at = |node: usize| plan.object_states["red_box"].pose[node];
        assert_eq!(found.len(), plan.phases.len() + 1);
        assert_eq!(found[0], [&plan.q[0][..], &box_at(0)].concat());
        let end = plan.q.len() - 1;
        assert_eq!(
            found[plan.phases.len()],
            [&plan.q[end][..], &box_at(end)].concat()
        );
        let first = plan.phases[0].steps;
        assert_eq!(found[1], [&plan.q[first][..], &box_at(first)].concat());
        scene.objects[0].name = "blue_box".into();
        assert_eq!(configurations(&plan, &scene), None);
    }
}
