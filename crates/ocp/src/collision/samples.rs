//! Scenes and sequences of the repository for tests.

use crate::program::Phase;
use scene::{Scene, SequenceFile, SequencePhase};
use std::path::Path;

/// The G1 on the ground, with more in TOML.
pub fn scene(more: &str) -> Scene {
    let text = format!(
        "name = \"s\"\nrobot = \"g1\"\n[[static]]\nname = \"ground\"\nplane = true\n{more}\n[objective]\nkind = \"base_height\"\n"
    );
    Scene::from_toml(&text, "s.toml", Path::new(".")).unwrap()
}

/// A sequence with its scene.
pub struct Sequence {
    pub scene: Scene,
    pub phases: Vec<Phase>,
}

impl Sequence {
    /// From a file in the folder of sequences.
    pub fn load(name: &str) -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/sequences");
        let file = SequenceFile::load(folder.join(name)).unwrap();
        let scene = file.load_scene().unwrap();
        Self::of(scene, &file)
    }

    /// In a scene, from the text of a file.
    pub fn in_scene(scene: Scene, text: &str) -> Self {
        let file = SequenceFile::from_toml(text, "sequence.toml", Path::new(".")).unwrap();
        Self::of(scene, &file)
    }

    fn of(scene: Scene, file: &SequenceFile) -> Self {
        let phase = |p: &SequencePhase| Phase {
            state: p.state.clone(),
            steps: p.steps,
        };
        let sequence = file.resolve(&scene).unwrap();
        let phases = sequence.phases.iter().map(phase).collect();
        Self { scene, phases }
    }

    /// The same with so many intervals in every phase.
    pub fn with_steps(name: &str, steps: usize) -> Self {
        let mut sequence = Self::load(name);
        for phase in &mut sequence.phases {
            phase.steps = steps;
        }
        sequence
    }
}
