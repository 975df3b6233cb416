//! The figures of a paper: contact sequence, torques, snapshots, and the motion as an animated picture.

mod animation;
mod contact_chart;
mod strip;
mod svg;
mod torque_chart;

use crate::motion::Motion;
use crate::{Meshes, Named, ViewError};
use plan::Plan;
use svg::{BAND, Drawing};

/// Pixels per point of PNG figures: 300 per inch.
const PNG_SCALE: f64 = 300.0 / 72.0;

/// What to draw.
#[derive(Debug, Clone)]
pub struct FigureOptions {
    /// Joints of the torque figure; empty: the most loaded ones.
    pub joints: Vec<String>,
    /// So many most loaded joints.
    pub most_loaded: usize,
    /// Snapshots of each plan.
    pub snapshots: usize,
    /// Whether the animated picture is made.
    pub animation: bool,
}

impl Default for FigureOptions {
    fn default() -> Self {
        Self {
            joints: Vec::new(),
            most_loaded: 4,
            snapshots: 6,
            animation: true,
        }
    }
}

/// A file that was made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Figure {
    /// Its name, with the ending that says what it is.
    pub file: String,
    /// What is in it.
    pub bytes: Vec<u8>,
}

/// Draws the figures of one plan, or of two for comparison: `contacts` and `torques` and `snapshots` as SVG and PNG, and
/// `motion.gif`. Robots are drawn with `meshes`, where these have theirs. The same plans and meshes give the same files.
///
/// # Errors
/// A plan contradicts itself, its robot cannot be read, or a wanted joint does not exist.
pub fn figures(
    plans: &[Named],
    meshes: &Meshes,
    options: &FigureOptions,
) -> Result<Vec<Figure>, ViewError> {
    let motions: Vec<_> = plans
        .iter()
        .map(|named| Motion::new(named.plan, named.name))
        .collect::<Result<_, _>>()?;
    let names: Vec<_> = plans.iter().map(|named| named.name).collect();
    let drawings = [
        ("contacts", contact_chart::contact_chart(&motions, &names)),
        (
            "torques",
            torque_chart::torque_chart(&motions, &names, &options.joints, options.most_loaded)?,
        ),
        (
            "snapshots",
            strip::strip(&motions, meshes, &names, options.snapshots)?,
        ),
    ];
    let mut figures = Vec::new();
    for (name, drawing) in &drawings {
        figures.push(Figure {
            file: format!("{name}.svg"),
            bytes: drawing.svg().into_bytes(),
        });
        figures.push(Figure {
            file: format!("{name}.png"),
            bytes: drawing.png(PNG_SCALE)?,
        });
    }
    if options.animation {
        figures.push(Figure {
            file: "motion.gif".into(),
            bytes: animation::animation(&motions, meshes)?,
        });
    }
    Ok(figures)
}

/// Shades every other phase between two heights; `x` is the place of a node.
fn phase_bands(
    drawing: &mut Drawing,
    plan: &Plan,
    x: impl Fn(usize) -> f64,
    [top, bottom]: [f64; 2],
) {
    for nodes in plan.phase_starts().windows(2).skip(1).step_by(2) {
        let [from, to] = [x(nodes[0]), x(nodes[1])];
        drawing.rect([from, top], [to - from, bottom - top], BAND, 0.0);
    }
}
