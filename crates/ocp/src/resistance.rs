//! Where a program without a solution resists: violations and multipliers by constraint.
//!
//! At a point of least violation the multipliers y of what is violated and of what holds it there balance, Jᵀy ≈ 0 (the
//! lemma of Farkas, linearised), so their sizes say what pulls.

use crate::program::{Grid, Program, RowLabel, Subject};
use solver::Report;

/// A problem's worst row in words.
#[derive(Debug, Clone, PartialEq)]
pub struct Worst {
    /// Where the row comes from.
    pub label: RowLabel,
    /// Phase.
    pub phase: usize,
    /// Interval.
    pub interval: usize,
    /// Violation in the label's unit.
    pub amount: f64,
}

/// All multipliers of one constraint in one phase.
#[derive(Debug, Clone, PartialEq)]
pub struct Pull {
    /// Constraint and subject.
    pub label: RowLabel,
    /// Phase.
    pub phase: usize,
    /// Part of the sum of all multipliers, 0 to 1.
    pub share: f64,
}

/// Multipliers of rows and of the variables' bounds, summed by constraint, subject and phase, the largest first. Dimensionless:
/// of scaled rows and variables.
pub fn pulls(program: &Program, report: &Report) -> Vec<Pull> {
    let mut all: Vec<Pull> = Vec::new();
    let mut add = |label: &RowLabel, phase: usize, size: f64| {
        if size == 0.0 || !size.is_finite() {
            return;
        }
        let same = |p: &&mut Pull| {
            let (one, other) = (&p.label, label);
            p.phase == phase && one.category == other.category && one.subject == other.subject
        };
        match all.iter_mut().find(same) {
            Some(pull) => pull.share += size,
            None => all.push(Pull {
                label: label.clone(),
                phase,
                share: size,
            }),
        }
    };
    let mut row = 0;
    for (t, element) in program.structure.elements.iter().enumerate() {
        for _ in 0..element.n_rows() {
            let size = report.multipliers[row].abs();
            add(&program.labels[row], program.phase_of(t), size);
            row += 1;
        }
    }
    for (variable, label, phase) in bounded_variables(program) {
        add(&label, phase, report.bound_multipliers[variable].abs());
    }
    let sum: f64 = all.iter().map(|p| p.share).sum();
    for pull in &mut all {
        pull.share /= sum;
    }
    all.sort_by(|a, b| b.share.total_cmp(&a.share));
    all
}

/// Variables with bounds that mean something: joint positions, contact forces and durations, each with its label and phase.
fn bounded_variables(program: &Program) -> Vec<(usize, RowLabel, usize)> {
    let label = |category, subject, scale, unit| RowLabel {
        category,
        subject,
        scale,
        unit,
    };
    let mut out = Vec::new();
    let last = program.n_intervals() - 1;
    for (t, node) in program.nodes.iter().enumerate() {
        let own = node.var.as_ref().filter(|_| program.master_node(t) == t);
        let Some(vars) = own else { continue };
        for joint in program.system.actuated() {
            let subject = Subject::Coordinate(joint.idx_v);
            let range = label("joint range", subject, 1.0, "rad");
            out.push((
                vars.robot + joint.idx_v,
                range,
                program.phase_of(t.min(last)),
            ));
        }
    }
    for interval in &program.intervals {
        for force in &interval.forces {
            for i in 0..force.n.min(3) {
                let subject = Subject::Contact(force.contact);
                let limit = label("contact force", subject, force.scale[i], "N");
                out.push((interval.wrench_var + force.first + i, limit, interval.phase));
            }
        }
    }
    if program.grid == Grid::Motion {
        for k in 0..program.steps.len() {
            let duration = label("phase duration", Subject::Duration, 1.0, "s");
            out.push((program.duration_var + k, duration, k));
        }
    }
    out
}

/// The most violated row of every constraint and subject, in units of the labels, by scaled violation, the worst first; before
/// them variables whose bounds cross.
pub fn violations(program: &Program, report: &Report, least: f64) -> Vec<Worst> {
    let mut all: Vec<(f64, Worst)> = Vec::new();
    let mut row = 0;
    for (t, element) in program.structure.elements.iter().enumerate() {
        for (l, u) in element.row_lower.iter().zip(&element.row_upper) {
            let (value, label) = (report.rows[row], &program.labels[row]);
            let scaled = (l - value).max(value - u);
            row += 1;
            if scaled <= least {
                continue;
            }
            let worst = Worst {
                label: label.clone(),
                phase: program.phase_of(t),
                interval: t,
                amount: scaled * label.scale,
            };
            let same = |w: &&mut (f64, Worst)| {
                let other = &w.1.label;
                other.category == label.category && other.subject == label.subject
            };
            match all.iter_mut().find(same) {
                Some(known) if known.0 >= scaled => {}
                Some(known) => *known = (scaled, worst),
                None => all.push((scaled, worst)),
            }
        }
    }
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut out = crossed_variables(program);
    out.extend(all.into_iter().map(|(_, worst)| worst));
    out
}

fn crossed_variables(program: &Program) -> Vec<Worst> {
    let structure = &program.structure;
    let crossing = |v: usize| structure.lower[v] - structure.upper[v];
    let crossed = bounded_variables(program).into_iter();
    let crossed = crossed.filter(|(v, ..)| crossing(*v) > 0.0);
    crossed
        .map(|(v, label, phase)| Worst {
            amount: crossing(v) * label.scale,
            interval: program.steps[..phase].iter().sum(),
            label,
            phase,
        })
        .collect()
}

/// The most violated row of a report, in units of its label; `None` if no scaled violation exceeds `least`.
pub fn worst_row(program: &Program, report: &Report, least: f64) -> Option<Worst> {
    let mut worst: Option<Worst> = None;
    let mut row = 0;
    for (t, element) in program.structure.elements.iter().enumerate() {
        for (l, u) in element.row_lower.iter().zip(&element.row_upper) {
            let amount = (l - report.rows[row]).max(report.rows[row] - u);
            let label = &program.labels[row];
            if amount > worst.as_ref().map_or(least, |w| w.amount / w.label.scale) {
                let amount = amount * label.scale;
                worst = Some(Worst {
                    label: label.clone(),
                    phase: program.phase_of(t),
                    interval: t,
                    amount,
                });
            }
            row += 1;
        }
    }
    worst
}

/// The inequality row with the largest multiplier, and its violation (zero if it is none).
pub fn hardest_limit(program: &Program, report: &Report) -> Option<Worst> {
    let mut hardest: Option<(f64, Worst)> = None;
    let mut row = 0;
    for (t, element) in program.structure.elements.iter().enumerate() {
        for (l, u) in element.row_lower.iter().zip(&element.row_upper) {
            let pull = report.multipliers[row].abs();
            if l < u && pull > hardest.as_ref().map_or(0.0, |h| h.0) {
                let label = program.labels[row].clone();
                let value = report.rows[row];
                let worst = Worst {
                    phase: program.phase_of(t),
                    interval: t,
                    amount: (l - value).max(value - u).max(0.0) * label.scale,
                    label,
                };
                hardest = Some((pull, worst));
            }
            row += 1;
        }
    }
    hardest.map(|h| h.1)
}
