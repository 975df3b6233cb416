//! Durations, the variables of every element and the columns of every block.

use super::{Builder, Force, Grid, Interval};

impl Builder<'_> {
    /// Lists the variables of every element and the columns of every block, now that all terms are known.
    #[allow(clippy::too_many_lines)] // one expression or layout, written down in its own order
    pub(super) fn layout(&mut self) {
        let p = &mut self.program;
        let (n, nv) = (p.intervals.len(), p.system.model.nv);
        let (motion, states) = (p.grid == Grid::Motion, p.has_velocities());
        p.duration_var = p.structure.n_vars;
        if motion {
            for &steps in &p.steps {
                let longest = steps as f64 * p.settings.max_step;
                p.structure.n_vars += 1;
                p.structure.lower.push(p.settings.min_duration.min(longest));
                p.structure.upper.push(p.settings.max_duration.min(longest));
            }
        }
        for t in 0..n {
            let mut vars: Vec<usize> = Vec::new();
            let moves = p.moves(t);
            let i = &mut p.intervals[t];
            vars.extend(i.wrench_var..i.wrench_var + i.n_wrench);
            let mut place = |var: Option<usize>, wanted: bool| -> Option<usize> {
                let first = var.filter(|_| wanted)?;
                if let Some(at) = vars.iter().position(|&v| v == first) {
                    return Some(at);
                }
                vars.extend(first..first + nv);
                Some(vars.len() - nv)
            };
            i.a = place(p.nodes[t].var, true);
            i.velocity = place(p.nodes[t].velocity_var, true);
            i.velocity_next = place(p.nodes[t + 1].velocity_var, true);
            i.b = place(p.nodes[t + 1].var, !states && (moves || i.v_next));
            i.c = if i.v_next && !states {
                place(p.nodes[t + 2].var, true)
            } else {
                None
            };
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
            if let (true, Some(first)) = (states && moves, p.nodes[t + 1].var) {
                i.b = Some(in_motion);
                vars.extend(first..first + nv);
            }
            if states && t + 1 < n {
                Self::changes(&mut p.intervals[t..=t + 1], &mut vars);
            }
            let i = &p.intervals[t];
            let e = &mut p.structure.elements[t];
            e.vars = vars;
            if i.dynamics {
                e.blocks[0].cols = (0..in_motion).collect();
            }
            if let Some(block) = i.torque_speed.block {
                e.blocks[block].cols = (0..in_motion).collect();
            }
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
    /// Appends the wrench variables of the next interval whose contacts are those of this one, if they bear as much: with
    /// another scale, what they bear changes anyway.
    fn changes(pair: &mut [Interval], vars: &mut Vec<usize>) {
        let [here, next] = pair else { return };
        for force in &here.forces {
            let same = |f: &&Force| f.contact == force.contact && f.scale == force.scale;
            let Some(same) = next.forces.iter().find(same) else {
                continue;
            };
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
