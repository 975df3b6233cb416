//! Torques of some joints over time with their limits; two plans stand left and right on the same scale.

use super::contact_chart::label;
use super::phase_bands;
use super::svg::{Anchor, Drawing, FAINT, GRID, LIMIT, TEXT, fitted, tick_text, ticks};
use crate::ViewError;
use crate::motion::Motion;
use crate::torques::TorqueLimits;

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
    let side = |motion| Side {
        motion,
        limits: TorqueLimits::new(motion),
    };
    let sides: Vec<_> = motions.iter().map(side).collect();
    let joints = if joints.is_empty() {
        most_loaded(&sides, most)
    } else {
        known(motions, joints)?
    };
    let columns = motions.len() as f64;
    let width = (WIDTH - LEFT - RIGHT - GAP * (columns - 1.0)) / columns;
    let mut drawing = Drawing::new(WIDTH, TITLE + joints.len() as f64 * (PANEL + ABOVE) + TIMES);
    for (row, joint) in joints.iter().enumerate() {
        let top = TITLE + row as f64 * (PANEL + ABOVE) + ABOVE;
        let range = range(&sides, joint);
        for (column, side) in sides.iter().enumerate() {
            let left = LEFT + column as f64 * (width + GAP);
            let panel = Panel {
                left,
                top,
                width,
                range,
            };
            panel.draw(&mut drawing, side, joint, column == 0);
            if row + 1 == joints.len() {
                panel.times(&mut drawing, side.motion);
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

/// A plan with its torque limits.
struct Side<'a> {
    motion: &'a Motion<'a>,
    limits: TorqueLimits,
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

    fn draw(&self, drawing: &mut Drawing, side: &Side, joint: &str, is_first: bool) {
        let plan = side.motion.plan;
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
        self.draw_limits(drawing, side, joint, &x);
        if let Some(j) = column(side, joint) {
            let points: Vec<_> = (0..plan.tau.len())
                .map(|t| [x(t), self.y(plan.tau[t][j])])
                .collect();
            drawing.line(&points, INK, 1.1, false);
        }
    }

    /// Both limits; where the joint gives less at speed, the one on the side to which it drives.
    fn draw_limits(
        &self,
        drawing: &mut Drawing,
        side: &Side,
        joint: &str,
        x: &impl Fn(usize) -> f64,
    ) {
        let (Some(j), Some((largest, enforced))) = (column(side, joint), limit(side, joint)) else {
            return;
        };
        let (ink, width) = if enforced { (LIMIT, 1.0) } else { (FAINT, 0.7) };
        let tau = &side.motion.plan.tau;
        for sign in [-1.0, 1.0] {
            let at = |t: usize| {
                let here = side
                    .limits
                    .at(side.motion, j, t)
                    .filter(|_| tau[t][j] * sign > 0.0);
                [x(t), self.y(sign * here.unwrap_or(largest))]
            };
            let mut points: Vec<_> = (0..tau.len()).map(at).collect();
            points.push([x(tau.len()), self.y(sign * largest)]);
            drawing.line(&points, ink, width, true);
        }
        if !enforced {
            let place = [self.left + self.width - 2.0, self.y(largest) + 6.0];
            drawing.text(place, "limit, not enforced", 6.5, FAINT, Anchor::End);
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
fn column(side: &Side, joint: &str) -> Option<usize> {
    side.motion
        .plan
        .robot
        .joints
        .iter()
        .position(|x| x == joint)
}

/// The largest torque that a joint may give and whether the plan enforces that.
fn limit(side: &Side, joint: &str) -> Option<(f64, bool)> {
    side.limits.largest[column(side, joint)?]
}

/// The joints with the largest shares of their limits in any plan.
fn most_loaded(sides: &[Side], count: usize) -> Vec<String> {
    let joints = &sides[0].motion.plan.robot.joints;
    let largest = |side: &Side, joint: &String| {
        let j = column(side, joint)?;
        let shares = (0..side.motion.plan.tau.len()).map(|t| side.limits.share(side.motion, j, t));
        shares.reduce(f64::max)
    };
    let share = |joint: &String| {
        sides
            .iter()
            .filter_map(|side| largest(side, joint))
            .fold(0.0, f64::max)
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

/// What torques and limits of all plans need.
fn range(sides: &[Side], joint: &str) -> [f64; 2] {
    let most = |side: &Side| {
        let j = column(side, joint)?;
        let torque = side
            .motion
            .plan
            .tau
            .iter()
            .map(|row| row[j].abs())
            .fold(0.0, f64::max);
        Some(limit(side, joint).map_or(torque, |(limit, _)| torque.max(limit)))
    };
    let reach = 1.12 * sides.iter().filter_map(most).fold(1e-3, f64::max);
    [-reach, reach]
}
