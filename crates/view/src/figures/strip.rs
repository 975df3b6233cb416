//! Snapshots of the motion in a row, each with its time and what happens.

use super::contact_chart::label;
use super::svg::{Anchor, Drawing, FAINT, TEXT, fitted, png_of};
use crate::ViewError;
use crate::meshes::Meshes;
use crate::motion::Motion;
use crate::render::Scenery;

const WIDTH: f64 = 500.0;
const GAP: f64 = 4.0;
const CAPTION: f64 = 31.0;
const TITLE: f64 = 14.0;

/// Height of a snapshot [pixels].
const PIXELS: usize = 420;

/// At most so many in a row.
const PER_ROW: usize = 6;

/// The snapshots of all plans, `count` of each.
pub(crate) fn strip(
    motions: &[Motion],
    meshes: &Meshes,
    names: &[&str],
    count: usize,
) -> Result<Drawing, ViewError> {
    let sceneries: Vec<_> = motions.iter().map(|x| Scenery::new(x, meshes)).collect();
    let cameras: Vec<_> = sceneries.iter().map(|x| x.camera([0.62, 1.5])).collect();
    let columns = count.min(PER_ROW);
    let rows = count.div_ceil(columns);
    let width = (WIDTH - GAP * (columns as f64 - 1.0)) / columns as f64;
    let title = if motions.len() > 1 { TITLE } else { 0.0 };
    let heights: Vec<_> = cameras.iter().map(|x| width / x.aspect + CAPTION).collect();
    let total = heights.iter().map(|x| x * rows as f64 + title).sum();
    let mut drawing = Drawing::new(WIDTH, total);
    let mut top = 0.0;
    for (i, motion) in motions.iter().enumerate() {
        if motions.len() > 1 {
            drawing.text([0.0, top + TITLE / 2.0], names[i], 9.0, TEXT, Anchor::Start);
        }
        top += title;
        for (place, time) in times(motion, count).into_iter().enumerate() {
            let left = (place % columns) as f64 * (width + GAP);
            let y = top + (place / columns) as f64 * heights[i];
            let picture = sceneries[i].picture(time, &cameras[i], PIXELS);
            drawing.image([left, y], [width, heights[i] - CAPTION], &png_of(&picture)?);
            let middle = left + width / 2.0;
            let caption = y + heights[i] - CAPTION;
            drawing.text(
                [middle, caption + 6.0],
                &format!("{time:.2} s"),
                7.0,
                FAINT,
                Anchor::Middle,
            );
            for (line, text) in two_lines(&action(motion, time), width).iter().enumerate() {
                let y = caption + 14.5 + 8.5 * line as f64;
                drawing.text([middle, y], text, 7.0, TEXT, Anchor::Middle);
            }
        }
        top += heights[i] * rows as f64;
    }
    Ok(drawing)
}

/// The beginning, the end, and ends of phases between, evenly chosen; where phases do not suffice, evenly in time.
fn times(motion: &Motion, count: usize) -> Vec<f64> {
    let plan = motion.plan;
    let starts = plan.phase_starts();
    let inner = &starts[1..starts.len() - 1];
    let places = count.saturating_sub(1).max(1);
    let at_ends = inner.len() + 1 >= places;
    let time = |i: usize| {
        if at_ends && i > 0 && i < places {
            let share = (i as f64 - 0.5) / (places as f64 - 1.0);
            plan.time[inner[(share * inner.len() as f64) as usize]]
        } else {
            plan.duration() * i as f64 / places as f64
        }
    };
    (0..count).map(time).collect()
}

/// A text broken between words so that it fits a width, the second line shortened if it must be.
fn two_lines(text: &str, width: f64) -> [String; 2] {
    let mut first = String::new();
    let mut words = text.split(' ').peekable();
    while let Some(word) = words.peek() {
        let longer = format!("{first} {word}").trim_start().to_owned();
        if !first.is_empty() && fitted(&longer, 7.0, width) != longer {
            break;
        }
        first = longer;
        words.next();
    }
    let rest: Vec<_> = words.collect();
    [
        fitted(&first, 7.0, width),
        fitted(&rest.join(" "), 7.0, width),
    ]
}

/// What happens up to a time: the action of the phase that ends there or that it is in.
fn action(motion: &Motion, time: f64) -> String {
    let plan = motion.plan;
    let ends = plan.phase_starts();
    let k = ends[1..]
        .iter()
        .position(|end| plan.time[*end] >= time - 1e-9);
    label(&plan.phases[k.unwrap_or(plan.phases.len() - 1)].action)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_actions_are_broken_between_words() {
        let lines = two_lines("place red box on table b top", 70.0);
        assert_eq!(
            lines,
            ["place red box on".to_owned(), "table b top".to_owned()]
        );
        assert_eq!(two_lines("lift", 70.0), ["lift".to_owned(), String::new()]);
    }
}
