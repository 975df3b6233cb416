//! The contact sequence: a row per interface of robot and objects, a bar while it touches, coloured by its partner.

use super::phase_bands;
use super::svg::{Anchor, Drawing, FAINT, GRID, TEXT, fitted, tick_text, ticks};
use crate::motion::{Carrier, Motion};
use crate::palette;
use std::collections::BTreeSet;

const LEFT: f64 = 96.0;
const RIGHT: f64 = 10.0;
const ROW: f64 = 15.0;
const TITLE: f64 = 16.0;
const PHASES: f64 = 13.0;
const TIMES: f64 = 24.0;
const WIDTH: f64 = 500.0;

/// A bar in the row of interface `own`, from node to node.
struct Bar {
    own: usize,
    partner: usize,
    nodes: [usize; 2],
}

/// The charts of all plans, one below another, over the same time.
pub(crate) fn contact_chart(motions: &[Motion], names: &[&str]) -> Drawing {
    let heights: Vec<_> = motions.iter().map(height).collect();
    let mut drawing = Drawing::new(WIDTH, heights.iter().sum());
    let longest = motions
        .iter()
        .map(|m| m.plan.duration())
        .fold(0.0, f64::max);
    let mut top = 0.0;
    for ((motion, name), height) in motions.iter().zip(names).zip(heights) {
        let title = if motions.len() > 1 { *name } else { "" };
        draw(&mut drawing, motion, title, top, longest);
        top += height;
    }
    drawing
}

fn height(motion: &Motion) -> f64 {
    TITLE + PHASES + rows(motion).len() as f64 * ROW + TIMES
}

fn draw(drawing: &mut Drawing, motion: &Motion, title: &str, top: f64, longest: f64) {
    let plan = motion.plan;
    let scale = (WIDTH - LEFT - RIGHT) / longest;
    let x = |t: usize| LEFT + scale * plan.time[t];
    let rows = rows(motion);
    let first = top + TITLE + PHASES;
    let bottom = first + rows.len() as f64 * ROW;
    drawing.text([LEFT, top + 9.0], title, 9.0, TEXT, Anchor::Start);
    phase_bands(drawing, plan, x, [top + TITLE, bottom]);
    for (k, starts) in plan.phase_starts().windows(2).enumerate() {
        let [from, to] = [x(starts[0]), x(starts[1])];
        let number = (k + 1).to_string();
        let text = fitted(&number, 6.5, to - from + 3.0);
        drawing.text(
            [f64::midpoint(from, to), first - 6.0],
            &text,
            6.5,
            FAINT,
            Anchor::Middle,
        );
    }
    for (row, own) in rows.iter().enumerate() {
        let y = first + (row as f64 + 0.5) * ROW;
        let name = label(&plan.interfaces[*own].name);
        drawing.text(
            [LEFT - 6.0, y],
            &fitted(&name, 8.0, LEFT - 6.0),
            8.0,
            TEXT,
            Anchor::End,
        );
        drawing.line(&[[LEFT, y], [x(plan.time.len() - 1), y]], GRID, 0.6, false);
    }
    for bar in bars(motion) {
        let Some(row) = rows.iter().position(|own| *own == bar.own) else {
            continue;
        };
        let partner = &plan.interfaces[bar.partner];
        let [from, to] = bar.nodes.map(x);
        let y = first + row as f64 * ROW;
        drawing.rect(
            [from + 0.4, y + 2.0],
            [to - from - 0.8, ROW - 4.0],
            &palette::of_interface(plan, partner),
            2.0,
        );
        let text = fitted(&label(&partner.name), 7.0, to - from - 9.0);
        drawing.text(
            [from + 4.0, y + ROW / 2.0],
            &text,
            7.0,
            "#ffffff",
            Anchor::Start,
        );
    }
    for time in ticks(0.0, plan.duration(), 8.0) {
        let at = LEFT + scale * time;
        drawing.line(&[[at, bottom], [at, bottom + 3.0]], FAINT, 0.6, false);
        let text = if time == 0.0 {
            "0 s".to_owned()
        } else {
            tick_text(time)
        };
        drawing.text([at, bottom + 9.0], &text, 7.5, FAINT, Anchor::Middle);
    }
}

/// Interfaces of robot and objects that ever touch, robot first; static bodies are only partners.
fn rows(motion: &Motion) -> Vec<usize> {
    let contacts = motion.plan.phases.iter().flat_map(|phase| &phase.contacts);
    let used: BTreeSet<usize> = contacts
        .flat_map(|x| [&x.a, &x.b].map(|name| motion.interfaces[name.as_str()]))
        .collect();
    let on = |wanted: fn(&Carrier) -> bool| {
        let all = used.iter().copied();
        all.filter(move |i| wanted(&motion.carriers[*i]))
    };
    let robot = on(|carrier| matches!(carrier, Carrier::Frame(_)));
    robot
        .chain(on(|carrier| matches!(carrier, Carrier::Object(_))))
        .collect()
}

/// All bars of both partners; a contact that lasts over several phases is one bar.
fn bars(motion: &Motion) -> Vec<Bar> {
    let mut bars: Vec<Bar> = Vec::new();
    for (phase, nodes) in motion
        .plan
        .phases
        .iter()
        .zip(motion.plan.phase_starts().windows(2))
    {
        for contact in &phase.contacts {
            let [a, b] = [&contact.a, &contact.b].map(|name| motion.interfaces[name.as_str()]);
            for (own, partner) in [(a, b), (b, a)] {
                let same =
                    |x: &&mut Bar| (x.own, x.partner, x.nodes[1]) == (own, partner, nodes[0]);
                match bars.iter_mut().find(same) {
                    Some(bar) => bar.nodes[1] = nodes[1],
                    None => bars.push(Bar {
                        own,
                        partner,
                        nodes: [nodes[0], nodes[1]],
                    }),
                }
            }
        }
    }
    bars
}

/// A name for people.
pub(crate) fn label(name: &str) -> String {
    name.replace('_', " ")
}
