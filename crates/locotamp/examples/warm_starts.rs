//! Iterations from keyframes and from relatives: `warm_starts FOLDER [FILTER,FILTER…]`, eight intervals per phase.
//!
//! Relatives: the same sequence with all objects moved by 2 cm, and the beginnings that are one and two phases shorter.

use locotamp::Preset;
use ocp::{Motion, Phase, Planner, Settings};
use scene::{Scene, SequenceFile};
use spatial::Pose;
use std::path::Path;

/// Intervals per phase.
const STEPS: usize = 8;
/// What the objects are moved by [m].
const SHIFT: f64 = 0.02;

type Fault = Box<dyn std::error::Error>;

fn main() -> Result<(), Fault> {
    let arguments: Vec<String> = std::env::args().collect();
    for path in SequenceFile::find(Path::new(&arguments[1]))? {
        let name = path.display().to_string();
        let wanted = |filters: &String| filters.split(',').any(|f| name.contains(f));
        if arguments.get(2).is_none_or(wanted) {
            compare(&name, &SequenceFile::load(&path)?)?;
        }
    }
    Ok(())
}

fn compare(name: &str, file: &SequenceFile) -> Result<(), Fault> {
    let mut scene = file.load_scene()?;
    let sequence = file.resolve(&scene)?;
    if let Some(goal) = &sequence.goal {
        scene.goal_contacts.clone_from(&goal.contacts);
        scene.goal_regions.clone_from(&goal.regions);
    }
    let phase = |p: &scene::SequencePhase| Phase {
        state: p.state.clone(),
        steps: STEPS,
    };
    let phases: Vec<Phase> = sequence.phases.iter().map(phase).collect();
    let Some(own) = from_keyframes(&scene, &phases)?.filter(|m| m.feasible) else {
        println!("{name}: no motion");
        return Ok(());
    };
    if !scene.objects.is_empty() {
        let mut moved = scene.clone();
        for object in &mut moved.objects {
            let shift = Pose::from_translation(SHIFT, 0.0, 0.0);
            object.world_from_start = shift * object.world_from_start;
        }
        if let Some(cold) = from_keyframes(&moved, &phases)? {
            report(&format!("{name}, moved"), &moved, &phases, &own, &cold)?;
        }
    }
    let mut open = scene.clone();
    open.goal_regions.clear();
    for less in 1..=2 {
        let Some(beginning) = phases.len().checked_sub(less).filter(|&n| n > 1) else {
            continue;
        };
        if let Some(shorter) = from_keyframes(&open, &phases[..beginning])?.filter(|m| m.feasible) {
            let name = format!("{name}, {less} phases longer");
            report(&name, &scene, &phases, &shorter, &own)?;
        }
    }
    Ok(())
}

fn from_keyframes(scene: &Scene, phases: &[Phase]) -> Result<Option<Motion>, Fault> {
    let planner = Planner::new(scene)?;
    let settings = Settings::new(Preset::Default, &scene.optimiser);
    let keyframes = planner.keyframes(phases, &settings);
    let motion = || planner.motion(phases, &settings, &keyframes.nodes, &mut |_| true);
    Ok(keyframes.possible.then(motion))
}

fn report(
    name: &str,
    scene: &Scene,
    phases: &[Phase],
    relative: &Motion,
    cold: &Motion,
) -> Result<(), Fault> {
    let planner = Planner::new(scene)?;
    let settings = Settings::new(Preset::Default, &scene.optimiser);
    let warm = planner.motion_from(phases, &settings, &relative.relative(), &mut |_| true);
    let text = |m: &Motion| {
        format!(
            "{} iterations, cost {:.3}",
            m.iterations, m.report.objective
        )
    };
    let warm = warm.map_or_else(|| "no motion".into(), |m| text(&m));
    println!("{name}: keyframes {}, relative {warm}", text(cold));
    Ok(())
}
