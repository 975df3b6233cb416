//! Cost and false rejections of the keyframe checks: `keyframe_checks FOLDER VARIANTS [FILTER]`.
//!
//! Every state, transition and beginning of every sequence of a folder, in its scene and in variants of it
//! ([`Scene::perturbed`]). Where a sequence that is not known to be infeasible is rejected, the optimiser tries it all the
//! same: a plan shows a false rejection.

use locotamp::Preset;
use multibody::Kinematics;
use ocp::collision::CollisionModel;
use ocp::{Keyframes, Phase, Planner, Settings};
use scene::{Expectation, Perturbation, Scene, SequenceFile};
use std::path::Path;

/// Overlap at the start from which on a variant is left out [m].
const START_OVERLAP: f64 = 0.005;

#[derive(Default)]
struct Times {
    possible: Vec<f64>,
    impossible: Vec<f64>,
}

impl Times {
    fn add(&mut self, keyframes: &Keyframes, start: f64) -> bool {
        let list = if keyframes.possible {
            &mut self.possible
        } else {
            &mut self.impossible
        };
        list.push(1e3 * (processor_time() - start));
        keyframes.possible
    }

    fn print(&mut self, name: &str) {
        for (what, list) in [
            ("possible", &mut self.possible),
            ("impossible", &mut self.impossible),
        ] {
            list.sort_by(f64::total_cmp);
            if !list.is_empty() {
                let at = |share: f64| list[((list.len() - 1) as f64 * share) as usize];
                let mean = list.iter().sum::<f64>() / list.len() as f64;
                println!(
                    "{name} {what}: {} checks, mean {mean:.2} ms, median {:.2} ms, 95 % {:.2} ms",
                    list.len(),
                    at(0.5),
                    at(0.95)
                );
            }
        }
    }
}

#[derive(Default)]
struct Totals {
    states: Times,
    transitions: Times,
    beginnings: Times,
    longer: Times,
    sequences: Times,
    checks: usize,
    rejected: usize,
    false_rejections: usize,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let paths = SequenceFile::find(Path::new(&arguments[1]))?;
    let variants: u64 = arguments[2].parse()?;
    let mut totals = Totals::default();
    for path in paths {
        let name = path.display().to_string();
        if arguments
            .get(3)
            .is_some_and(|filter| !name.contains(filter))
        {
            continue;
        }
        let file = SequenceFile::load(&path)?;
        let mut scene = file.load_scene()?;
        let sequence = file.resolve(&scene)?;
        if let Some(goal) = &sequence.goal {
            scene.goal_contacts.clone_from(&goal.contacts);
            scene.goal_regions.clone_from(&goal.regions);
        }
        let phase = |p: &scene::SequencePhase| Phase {
            state: p.state.clone(),
            steps: p.steps,
        };
        let phases: Vec<Phase> = sequence.phases.iter().map(phase).collect();
        let known = !matches!(sequence.expect, Some(Expectation::Feasible));
        for variant in 0..=variants {
            let scene = if variant == 0 {
                scene.clone()
            } else {
                scene.perturbed(&Perturbation::default(), variant)
            };
            totals.judge(&format!("{name} {variant}"), &scene, &phases, known)?;
        }
    }
    totals.states.print("states");
    totals.transitions.print("transitions");
    totals.beginnings.print("beginnings");
    totals.longer.print("beginnings from shorter ones");
    totals.sequences.print("sequences");
    println!(
        "{} checks of sequences not known to be infeasible, {} rejected, of sequences with a plan {}",
        totals.checks, totals.rejected, totals.false_rejections
    );
    Ok(())
}

impl Totals {
    fn judge(
        &mut self,
        name: &str,
        scene: &Scene,
        phases: &[Phase],
        infeasible: bool,
    ) -> Result<(), Box<dyn std::error::Error>> {
        let planner = Planner::new(scene)?;
        let settings = Settings::new(Preset::Default, &scene.optimiser);
        if starts_in_collision(scene, &planner) {
            return Ok(());
        }
        let mut rejected = Vec::new();
        let mut known: Option<Vec<Vec<f64>>> = None;
        for k in 0..phases.len() {
            let start = processor_time();
            let found = planner.state(&phases[k].state, &settings);
            if !self.states.add(&found, start) {
                rejected.push(format!("state {}", k + 1));
            }
            if k > 0 {
                let start = processor_time();
                let found = planner.transition(&phases[k - 1].state, &phases[k].state, &settings);
                if !self.transitions.add(&found, start) {
                    rejected.push(format!("transition to {}", k + 1));
                }
            }
            let start = processor_time();
            let found = planner.keyframes_of_prefix(&phases[..=k], &settings);
            if !self.beginnings.add(&found, start) {
                rejected.push(format!(
                    "beginning of {}, {:?}",
                    k + 1,
                    found
                        .worst
                        .map(|w| (w.label.category, w.label.subject, w.phase, w.amount))
                ));
            }
            let shorter = known.take();
            known = found.possible.then_some(found.nodes);
            let Some(shorter) = shorter else {
                continue;
            };
            let start = processor_time();
            let found =
                planner.keyframes_of_longer(&shorter, &phases[..=k], &settings, &mut || None);
            if self.longer.add(&found, start) {
                known = Some(found.nodes);
            } else {
                rejected.push(format!("longer beginning of {}", k + 1));
            }
        }
        let start = processor_time();
        let found = planner.keyframes(phases, &settings);
        if !self.sequences.add(&found, start) {
            rejected.push("sequence".into());
        }
        if infeasible {
            return Ok(());
        }
        self.checks += 4 * phases.len() - 1;
        if !rejected.is_empty() {
            let motion = planner.motion(phases, &settings, &found.nodes, &mut |i| i.number < 100);
            self.rejected += rejected.len();
            self.false_rejections += if motion.feasible { rejected.len() } else { 0 };
            let plan = if motion.feasible {
                "has a plan"
            } else {
                "no plan found"
            };
            println!(
                "{name}: {plan}; rejected {}; {:?}",
                rejected.join(", "),
                found.worst
            );
        }
        Ok(())
    }
}

/// Processor time of this process as Linux tells it [s]; zero elsewhere.
fn processor_time() -> f64 {
    let text = std::fs::read_to_string("/proc/self/schedstat").unwrap_or_default();
    let nanoseconds = text
        .split_whitespace()
        .next()
        .and_then(|t| t.parse::<f64>().ok());
    nanoseconds.unwrap_or(0.0) * 1e-9
}

fn starts_in_collision(scene: &Scene, planner: &Planner<'_>) -> bool {
    let model = &planner.system.model;
    let mut kinematics = Kinematics::new(model);
    kinematics.update(model, &planner.system.start(scene));
    let touches = CollisionModel::start_touches(scene, &planner.system);
    let deepest = planner
        .collisions
        .deepest(&kinematics, &|a, b| touches.contains(&(a, b)));
    deepest.is_some_and(|d| d.0 > START_OVERLAP)
}
