//! A trajectory's evaluation allocates nothing.

// The other tests build their programs with the same scenes.
#[path = "main/scenes.rs"]
mod scenes;

use ocp::{Grid, Preset};
use scenes::program;
use solver::{ElementData, Problem};

#[test]
fn moving_and_evaluating_allocate_nothing() {
    for grid in [Grid::Motion, Grid::Path, Grid::Keyframes, Grid::State] {
        for preset in [Preset::Default, Preset::Paper] {
            let (mut trajectory, x) = program(3, grid, preset);
            let structure = trajectory.structure().clone();
            let labels = &trajectory.program.labels;
            let has_clearances = labels.iter().any(|l| l.category == "clearance");
            assert_eq!(has_clearances, preset == Preset::Default);
            let mut data: Vec<_> = structure.elements.iter().map(ElementData::new).collect();
            let n_rows = data.iter().map(|d| d.values.len()).sum();
            let (step, y) = (vec![0.01; structure.n_vars], vec![0.3; n_rows]);
            let mut coordinates = vec![0.0; structure.n_vars];
            let mut moved = x.clone();
            let info = allocation_counter::measure(|| {
                trajectory.retract(&x, &step, 0.5, &mut moved);
                trajectory.coordinates(&moved, &mut coordinates);
                trajectory.evaluate(&moved, &mut data);
                trajectory.linearise(&moved, &y, &mut data);
            });
            let bytes = info.bytes_total;
            assert_eq!(info.count_total, 0, "{grid:?}, {preset:?}: {bytes} bytes");
        }
    }
}
