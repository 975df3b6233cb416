//! Torques of some joints over time with their limits; two plans stand left and right on the same scale.

use super::contact_chart::label;
use super::phase_bands;
use super::svg::{Anchor, Drawing, FAINT, GRID, LIMIT, TEXT, fitted, tick_text, ticks};
use crate::ViewError;
use crate::motion::Motion;

const LEFT: f64 = 44.0;
const GAP: f64 = 22.0;
const RIGHT: f64 = 8.0;
const TITLE: f64 = 18.0;
const PANEL: f64 = 72.0;
const ABOVE: f64 = 13.0;
const TIMES: f64 = 22.0;
const WIDTH: f64 = 500.0;
const INK: &str = "#1f6fd0";

/// The figure for the named joints, or for the `most` loaded ones.
pub(crate) fn torque_chart(
    motions: &[Motion],
    names: &[&str],
    joints: &[String],
    most: usize,
) -> Result<Drawing, ViewError> {
    let joints = if joints.is_empty() {
        most_loaded(motions, most)
    } else {
        known(motions, joints)?
    };
    let columns = motions.len() as f64;
    let width = (WIDTH - LEFT - RIGHT - GAP * (columns - 1.0)) / columns;
    let mut drawing = Drawing::new(WIDTH, TITLE + joints.len() as f64 * (PANEL + ABOVE) + TIMES);
    for (row, joint) in joints.iter().enumerate() {
        let top = TITLE + row as f64 * (PANEL + ABOVE) + ABOVE;
        let range = range(motions, joint);
        for (column, motion) in motions.iter().enumerate() {
            let left = LEFT + column as f64 * (width + GAP);
            let panel = Panel {
                left,
                top,
                width,
                range,
            };
            panel.draw(&mut drawing, motion, joint, column == 0);
            if row + 1 == joints.len() {
                panel.times(&mut drawing, motion);
            }
        }
        drawing.text(
            [LEFT, top - 6.0],
            &label(joint.trim_end_matches("_joint")),
            8.0,
            TEXT,
            Anchor::Start,
        );
        drawing.upright_text([10.0, top + PANEL / 2.0], "torque [N m]", 7.5, FAINT);
    }
    for (column, name) in names.iter().enumerate().filter(|_| motions.len() > 1) {
        let middle = LEFT + column as f64 * (width + GAP) + width / 2.0;
        drawing.text(
            [middle, 9.0],
            &fitted(name, 9.0, width),
            9.0,
            TEXT,
            Anchor::Middle,
        );
    }
    Ok(drawing)
}

/// The place of one curve.
struct Panel {
    left: f64,
    top: f64,
    width: f64,
    range: [f64; 2],
}

impl Panel {
    fn y(&self, torque: f64) -> f64 {
        let [low, high] = self.range;
        self.top + PANEL * (high - torque) / (high - low)
    }

    fn draw(&self, drawing: &mut Drawing, motion: &Motion, joint: &str, is_first: bool) {
        let plan = motion.plan;
        let x = |t: usize| self.left + self.width * plan.time[t] / plan.duration();
        let right = self.left + self.width;
        phase_bands(drawing, plan, x, [self.top, self.top + PANEL]);
        for tick in ticks(self.range[0], self.range[1], 4.0) {
            let y = self.y(tick);
            drawing.line(&[[self.left, y], [right, y]], GRID, 0.6, false);
            if is_first {
                drawing.text(
                    [self.left - 4.0, y],
                    &tick_text(tick),
                    7.5,
                    FAINT,
                    Anchor::End,
                );
            }
        }
        if let Some((limit, enforced)) = limit(motion, joint) {
            let (ink, width) = if enforced { (LIMIT, 1.0) } else { (FAINT, 0.7) };
            for limit in [-limit, limit] {
                if (self.range[0]..=self.range[1]).contains(&limit) {
                    drawing.line(
                        &[[self.left, self.y(limit)], [right, self.y(limit)]],
                        ink,
                        width,
                        true,
                    );
                }
            }
            if !enforced {
                drawing.text(
                    [right - 2.0, self.y(limit) + 6.0],
                    "limit, not enforced",
                    6.5,
                    FAINT,
                    Anchor::End,
                );
            }
        }
        if let Some(j) = column(motion, joint) {
            let points: Vec<_> = (0..plan.tau.len())
                .map(|t| [x(t), self.y(plan.tau[t][j])])
                .collect();
            drawing.line(&points, INK, 1.1, false);
        }
    }

    fn times(&self, drawing: &mut Drawing, motion: &Motion) {
        let (bottom, duration) = (self.top + PANEL, motion.plan.duration());
        for time in ticks(0.0, duration, 6.0) {
            let at = self.left + self.width * time / duration;
            drawing.line(&[[at, bottom], [at, bottom + 3.0]], FAINT, 0.6, false);
            let text = if time == 0.0 {
                "0 s".to_owned()
            } else {
                tick_text(time)
            };
            drawing.text([at, bottom + 9.0], &text, 7.5, FAINT, Anchor::Middle);
        }
    }
}

/// Column of a joint in the plan's torques.
fn column(motion: &Motion, joint: &str) -> Option<usize> {
    motion.plan.robot.joints.iter().position(|x| x == joint)
}

/// The torque limit of a joint and whether the plan enforced it.
fn limit(motion: &Motion, joint: &str) -> Option<(f64, bool)> {
    let j = column(motion, joint)?;
    let enforced = motion
        .plan
        .robot
        .torque_limits
        .as_ref()
        .and_then(|limits| limits[j]);
    let rated = motion
        .model
        .joint_id(joint)
        .map(|id| motion.model.joints[id].torque_limit);
    let rated = rated
        .filter(|limit| limit.is_finite())
        .map(|limit| (limit, false));
    enforced.map(|limit| (limit, true)).or(rated)
}

fn largest(motion: &Motion, joint: &str) -> f64 {
    let column = column(motion, joint);
    let torques = motion
        .plan
        .tau
        .iter()
        .filter_map(|row| Some(row[column?].abs()));
    torques.fold(0.0, f64::max)
}

/// The joints with the largest shares of their limits in any plan.
fn most_loaded(motions: &[Motion], count: usize) -> Vec<String> {
    let joints = &motions[0].plan.robot.joints;
    let share = |joint: &String| {
        let of = |motion: &Motion| Some(largest(motion, joint) / limit(motion, joint)?.0);
        motions.iter().filter_map(of).fold(0.0, f64::max)
    };
    let mut shares: Vec<_> = joints.iter().map(|joint| (share(joint), joint)).collect();
    shares.sort_by(|x, y| y.0.total_cmp(&x.0));
    shares
        .into_iter()
        .take(count)
        .map(|(_, joint)| joint.clone())
        .collect()
}

/// The wanted joints by their whole names; `_joint` may be left out.
fn known(motions: &[Motion], wanted: &[String]) -> Result<Vec<String>, ViewError> {
    let joints = &motions[0].plan.robot.joints;
    let find = |name: &String| {
        let found = joints
            .iter()
            .find(|x| *x == name || x.strip_suffix("_joint") == Some(name));
        found.cloned().ok_or_else(|| ViewError::NoSuchJoint {
            joint: name.clone(),
            known: joints.join(", "),
        })
    };
    wanted.iter().map(find).collect()
}

/// Both limits if a torque comes near them, else what the torques need.
fn range(motions: &[Motion], joint: &str) -> [f64; 2] {
    let largest = motions
        .iter()
        .map(|x| largest(x, joint))
        .fold(0.0, f64::max);
    let limit = motions
        .iter()
        .filter_map(|x| Some(limit(x, joint)?.0))
        .fold(0.0, f64::max);
    let reach = 1.12 * largest.max(limit).max(1e-3);
    [-reach, reach]
}
