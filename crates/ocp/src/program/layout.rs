//! Durations, the variables of every element and the columns of every block.

use std::collections::BTreeSet;

use super::{Builder, Force, Grid, Interval, Program, Variables};
use solver::ElementStructure;

impl Builder<'_> {
    /// Lists the variables of every element and the columns of every block, now that all terms are known.
    #[allow(clippy::too_many_lines)] // one expression or layout, written down in its own order
    pub(super) fn layout(&mut self) {
        let p = &mut self.program;
        let (n, nv) = (p.intervals.len(), p.system.model.nv);
        let (motion, states) = (p.grid == Grid::Motion, p.has_velocities());
        p.duration_var = p.structure.n_vars;
        if motion {
            for longest in &p.longest {
                p.structure.n_vars += 1;
                p.structure
                    .lower
                    .push(p.settings.min_duration.min(*longest));
                p.structure
                    .upper
                    .push(p.settings.max_duration.min(*longest));
            }
        }
        for t in 0..n {
            let mut vars: Vec<usize> = Vec::new();
            let (moves, still) = (p.moves(t), p.still_var.unwrap_or(usize::MAX));
            let i = &mut p.intervals[t];
            vars.extend(i.wrench_var..i.wrench_var + i.n_wrench);
            let place = |vars: &mut Vec<usize>, new: Option<&Variables>| -> Option<usize> {
                let new = new?;
                if let Some(at) = vars.iter().position(|&v| v == new.robot) {
                    return Some(at);
                }
                vars.extend((0..nv).map(|k| new.get(k).unwrap_or(still)));
                Some(vars.len() - nv)
            };
            let of = |node: usize, wanted: bool| p.nodes[node].var.as_ref().filter(|_| wanted);
            let velocity_of = |node: usize| p.nodes[node].velocity_var.as_ref();
            i.a = place(&mut vars, of(t, true));
            i.velocity = place(&mut vars, velocity_of(t));
            i.velocity_next = place(&mut vars, velocity_of(t + 1));
            i.b = place(&mut vars, of(t + 1, !states && (moves || i.v_next)));
            i.c = place(&mut vars, of((t + 2).min(n), !states && i.v_next));
            if motion && !states && (i.v || i.v_next) {
                i.time = Some(vars.len());
                vars.push(p.duration_var + i.phase);
                if i.v_next {
                    let next = phase_of_next(&p.steps, i.phase, t);
                    i.time_next = if next == i.phase {
                        i.time
                    } else {
                        vars.push(p.duration_var + next);
                        Some(vars.len() - 1)
                    };
                }
            } else if motion {
                // The duration costs in every interval of its phase, so that it always has an element.
                i.time = Some(vars.len());
                vars.push(p.duration_var + i.phase);
            }
            // The equations of motion touch all but the configuration of the next node, if velocities are unknowns.
            let in_motion = vars.len();
            if let Some(next) = of(t + 1, states && moves) {
                i.b = Some(in_motion);
                vars.extend((0..nv).map(|k| next.get(k).unwrap_or(still)));
            }
            if states && t + 1 < n {
                Self::changes(&mut p.intervals[t..=t + 1], &mut vars);
            }
            p.structure.elements[t].vars = vars;
            if p.intervals[t].dynamics {
                Self::motion_columns(p, t, in_motion);
            }
            let i = &p.intervals[t];
            let e = &mut p.structure.elements[t];
            if i.velocity_rows.is_some() {
                for (k, joint) in p.system.actuated().enumerate() {
                    let nodes = [i.a, i.b]
                        .into_iter()
                        .flatten()
                        .map(|first| first + joint.idx_v);
                    e.blocks[i.velocity_block + k].cols = nodes.chain(i.time).collect();
                }
            }
            let at =
                |first: usize, frame: usize| p.frames[frame].cols.iter().map(move |c| first + c);
            for stick in &i.sticks {
                let frame = p.nodes[t].frames[stick.slot_a];
                let cols = [i.a, i.b]
                    .into_iter()
                    .flatten()
                    .flat_map(|first| at(first, frame))
                    .collect();
                e.blocks[stick.block].cols = cols;
            }
            for passage in &i.passages {
                for term in &passage.terms {
                    let nodes = [i.a, i.b].into_iter().flatten();
                    let frame = passage.frames[term.slot];
                    e.blocks[term.block].cols = nodes.flat_map(|first| at(first, frame)).collect();
                }
            }
            for touch in &i.touches {
                let frame = p.nodes[t].frames[touch.slot];
                let nodes = [i.a, i.velocity].into_iter().flatten();
                e.blocks[touch.block].cols = nodes.flat_map(|first| at(first, frame)).collect();
            }
            if let Some(rows) = i.integrator {
                for (k, joint) in p.system.model.joints.iter().enumerate() {
                    let nodes = [i.a, i.b, i.velocity, i.velocity_next];
                    let cols = nodes.into_iter().flatten().flat_map(|first| {
                        let first = first + joint.idx_v;
                        first..first + joint.kind.nv()
                    });
                    e.blocks[rows.first_block + k].cols = cols.chain(i.time).collect();
                }
            }
            for slip in &i.slips {
                let frame = p.nodes[t].frames[slip.slot];
                let nodes = [i.a, i.b]
                    .into_iter()
                    .flatten()
                    .flat_map(|first| at(first, frame));
                e.blocks[slip.block].cols = nodes.chain(i.time).collect();
            }
            for force in &i.forces {
                for rows in &force.rows {
                    let mut cols: Vec<usize> = (force.first..force.first + force.n).collect();
                    if let (true, Some(first)) = (rows.term.uses_pose(), i.a) {
                        cols.extend(at(first, force.frame));
                    }
                    e.blocks[rows.block].cols = cols;
                }
            }
            for node in t..=(t + 1).min(n) {
                let Some(first) = (if node == t { i.a } else { i.b }) else {
                    continue;
                };
                if node == t + 1 && (motion || node != n) {
                    continue;
                }
                for term in &p.nodes[node].terms {
                    e.blocks[term.block].cols =
                        at(first, p.nodes[node].frames[term.slot]).collect();
                }
            }
        }
    }
}

impl Builder<'_> {
    /// What the equations of motion of interval `t` depend on, body by body: its own motion, the wrenches of its contacts, and
    /// where what touches it is. The robot's, and those of torque at speed, have all columns: few are zero, and in one piece they
    /// are multiplied faster.
    fn motion_columns(p: &mut Program, t: usize, in_motion: usize) {
        let i = &p.intervals[t];
        let configurations = [i.a, i.b.filter(|_| !p.has_velocities()), i.c];
        let nodes = configurations
            .into_iter()
            .chain([i.velocity, i.velocity_next]);
        let nodes: Vec<usize> = nodes.flatten().collect();
        let ElementStructure { vars, blocks, .. } = &mut p.structure.elements[t];
        for (block, rows) in p.system.motion_blocks().enumerate().skip(1) {
            if i.idle.contains(&(block - 1)) {
                continue;
            }
            let own = nodes
                .iter()
                .flat_map(|&first| first + rows.start..first + rows.end);
            let mut cols: BTreeSet<usize> = own.chain(i.time).chain(i.time_next).collect();
            for force in &i.forces {
                let touched = &p.frames[force.frame].cols;
                if touched.iter().any(|col| rows.contains(col)) {
                    cols.extend(force.first..force.first + force.n);
                    if let Some(first) = i.a {
                        cols.extend(touched.iter().map(|c| first + c));
                    }
                }
            }
            let moves = |c: &usize| Some(vars[*c]) != p.still_var;
            blocks[block].cols = cols.into_iter().filter(moves).collect();
        }
        for block in [0].into_iter().chain(i.torque_speed.block) {
            blocks[block].cols = (0..in_motion).collect();
        }
    }

    /// Appends the wrench variables of the next interval whose contacts are those of this one, if they bear as much: with
    /// another scale, what they bear changes anyway.
    fn changes(pair: &mut [Interval], vars: &mut Vec<usize>) {
        let [here, next] = pair else { return };
        for force in &here.forces {
            let same = |f: &&Force| f.contact == force.contact && f.scale == force.scale;
            let Some(same) = next.forces.iter().find(same) else {
                continue;
            };
            if force.known && same.known {
                continue;
            }
            for k in 0..force.n {
                here.changes.push((force.first + k, vars.len()));
                vars.push(next.wrench_var + same.first + k);
            }
        }
    }
}

/// Phase of the interval after `t`.
fn phase_of_next(steps: &[usize], phase: usize, t: usize) -> usize {
    let end: usize = steps[..=phase].iter().sum();
    if t + 1 < end { phase } else { phase + 1 }
}
