//! Times keyframes: `keyframe_times FOLDER [FILTER]`.
use ocp::{Phase, Planner, Preset, Settings};
use scene::SequenceFile;
use std::path::{Path, PathBuf};
use std::time::Instant;

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

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let mut paths = vec![];
    collect(Path::new(&arguments[1]), &mut paths);
    paths.sort();
    for path in paths {
        if arguments
            .get(2)
            .is_some_and(|f| !path.display().to_string().contains(f))
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
                steps: p.steps,
            })
            .collect();
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        let planner = Planner::new(&scene).unwrap();
        let start = Instant::now();
        let k = planner.keyframes(&phases, &settings);
        let s = start.elapsed().as_secs_f64();
        let t = k.report.timing;
        println!(
            "{:32} {:3} phases {} {:?} {:.1e} it {} fac {}  {:.0} ms (last round lin {:.0} fac {:.0} sol {:.0} ev {:.0} total {:.0}) {:?}",
            path.display().to_string().replace("scenes/sequences/", ""),
            phases.len(),
            k.possible,
            k.report.status,
            k.report.violation,
            k.iterations,
            k.report.factorisations,
            s * 1e3,
            t.linearise.as_secs_f64() * 1e3,
            t.factorise.as_secs_f64() * 1e3,
            t.solve.as_secs_f64() * 1e3,
            t.evaluate.as_secs_f64() * 1e3,
            t.total.as_secs_f64() * 1e3,
            k.worst.as_ref().filter(|_| !k.possible).map(|w| (
                w.label.category,
                w.phase,
                w.interval,
                w.amount,
                w.label.subject,
                k.nodes.last().map(|q| q[36..].to_vec())
            ))
        );
        if std::env::var("LONE").is_ok() {
            for (n, pair) in phases.windows(2).enumerate() {
                for what in ["state", "transition"] {
                    let start = Instant::now();
                    let k = if what == "state" {
                        planner.state(&pair[1].state, &settings)
                    } else {
                        planner.transition(&pair[0].state, &pair[1].state, &settings)
                    };
                    let s = start.elapsed().as_secs_f64();
                    println!(
                        "   {what} {} {} it {} fac {} {:?} {:.1e} {:.1} ms (solver {:.1}) {:?}",
                        n + 1,
                        k.possible,
                        k.iterations,
                        k.report.factorisations,
                        k.report.status,
                        k.report.violation,
                        s * 1e3,
                        k.report.timing.total.as_secs_f64() * 1e3,
                        k.worst.as_ref().filter(|_| !k.possible).map(|w| (
                            w.label.category,
                            w.phase,
                            w.interval,
                            w.amount,
                            w.label.subject,
                            k.nodes.last().map(|q| q[36..].to_vec())
                        ))
                    );
                }
            }
        }
    }
}
