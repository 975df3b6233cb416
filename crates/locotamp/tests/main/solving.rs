//! Given sequences.

use locotamp::{Request, solve};
use scene::SequenceFile;
use std::path::Path;

/// All at once, the keyframes of these twelve phases end in a local minimum.
#[test]
#[cfg_attr(debug_assertions, ignore = "slow without optimisation")]
fn a_long_sequence_has_keyframes_beginning_by_beginning() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/sequences");
    let file = SequenceFile::load(folder.join("climb/carry_and_climb.toml")).expect("a file");
    let scene = file.load_scene().expect("its scene");
    let sequence = file.resolve(&scene).expect("a sequence of the scene");
    let request = Request {
        time_limit: 0.0,
        explain: false,
        refinement: None,
        ..Request::default()
    };
    let solved = solve(&scene, &sequence, &request, &mut |_| true).expect("a planning problem");
    assert!(solved.keyframes.possible, "{:?}", solved.reason);
    assert!(!solved.feasible, "no time for a motion");
}
