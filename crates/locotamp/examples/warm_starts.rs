//! Cold and warm starts: `warm_starts FOLDER [FILTER]`.
use ocp::{Motion, Phase, Planner, Preset, Settings};
use scene::{Scene, SequenceFile};
use std::path::{Path, PathBuf};

fn collect(folder: &Path, paths: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, paths);
        } else {
            paths.push(path);
        }
    }
}

fn cold(scene: &Scene, phases: &[Phase], settings: &Settings) -> Option<Motion> {
    let planner = Planner::new(scene).unwrap();
    let k = planner.keyframes(phases, settings);
    if !k.possible {
        println!("   no keyframes: {:?}", k.worst);
    }
    k.possible
        .then(|| planner.motion(phases, settings, &k.nodes, &mut |_| true))
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let mut paths = vec![];
    collect(Path::new(&arguments[1]), &mut paths);
    paths.sort();
    for path in paths {
        if arguments
            .get(2)
            .is_some_and(|f| !f.split(',').any(|f| path.display().to_string().contains(f)))
        {
            continue;
        }
        let file = SequenceFile::load(&path).unwrap();
        let mut scene = file.load_scene().unwrap();
        let sequence = file.resolve(&scene).unwrap();
        if let Some(goal) = &sequence.goal {
            scene.goal_contacts.clone_from(&goal.contacts);
            scene.goal_regions.clone_from(&goal.regions);
        }
        let phases: Vec<Phase> = sequence
            .phases
            .iter()
            .map(|p| Phase {
                state: p.state.clone(),
                steps: 8,
            })
            .collect();
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let name = path.display().to_string().replace("scenes/sequences/", "");
        let Some(own) = cold(&scene, &phases, &settings) else {
            continue;
        };
        println!(
            "{name} cold: {} {} it cost {:.3}",
            own.feasible, own.iterations, own.report.objective
        );
        if !own.feasible {
            continue;
        }
        // The same in a changed scene.
        let mut moved = scene.clone();
        for o in &mut moved.objects {
            let mut p = o.world_from_start.to_xyzquat();
            p[0] += 0.02;
            o.world_from_start = spatial::Pose::from_xyzquat(&p);
        }
        if !moved.objects.is_empty() {
            report(&format!("{name} moved"), &moved, &phases, &settings, &own);
        }
        for less in [1, 2] {
            if phases.len() < less + 2 {
                continue;
            }
            let mut open = scene.clone();
            open.goal_regions.clear();
            let Some(shorter) = cold(&open, &phases[..phases.len() - less], &settings) else {
                continue;
            };
            if !shorter.feasible {
                println!("   shorter fails");
                continue;
            }
            report_with(
                &format!("{name} +{less}"),
                &scene,
                &phases,
                &settings,
                &shorter,
                Some(&own),
            );
        }
    }
}

fn report(name: &str, scene: &Scene, phases: &[Phase], settings: &Settings, relative: &Motion) {
    report_with(name, scene, phases, settings, relative, None);
}

fn report_with(
    name: &str,
    scene: &Scene,
    phases: &[Phase],
    settings: &Settings,
    relative: &Motion,
    known: Option<&Motion>,
) {
    let planner = Planner::new(scene).unwrap();
    let own;
    let cold = match known {
        Some(m) => m,
        None => match cold(scene, phases, settings) {
            Some(m) => {
                own = m;
                &own
            }
            None => return,
        },
    };
    let warm = planner.motion_from(phases, settings, &relative.relative(), &mut |_| true);
    println!(
        "   {name}: cold {} {} it cost {:.3}; warm {:?}",
        cold.feasible,
        cold.iterations,
        cold.report.objective,
        warm.map(|w| (
            w.feasible,
            w.iterations,
            w.report.iterations,
            w.report.objective
        ))
    );
}
