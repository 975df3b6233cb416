//! Second step of the chain rule: gradient of the costs and Hessian of the Lagrangian over the node variables and durations.

use super::vectors::Vectors;
use super::{Chain, Layout, Motion};
use crate::difference::Difference;
use nalgebra::DMatrix;

impl Chain {
    /// Adds the cost gradient and the Hessian of the Lagrangian to the element.
    #[allow(clippy::too_many_lines)] // one block of the derivation after the other, as in the module's text
    pub fn finish(
        &mut self,
        here: Option<&Difference>,
        next: Option<&Difference>,
        layout: &Layout,
        gradient: &mut [f64],
        hessian: &mut [f64],
    ) {
        let n = gradient.len();
        let Motion {
            v,
            v_next,
            a,
            dt,
            dt_next,
            steps,
            steps_next,
        } = &self.motion;
        let (dt, dt_next, steps, steps_next) = (*dt, *dt_next, *steps, *steps_next);
        let nv = v.len();
        let (da, ga) = (&self.da, &self.by_a_gradient);
        let Vectors {
            gv,
            gp,
            cv,
            cp,
            chained,
            ..
        } = &mut self.vectors;
        for i in 0..nv {
            gp[i] = ga[i] / dt;
            gv[i] = self.by_v_gradient[i] - gp[i];
            cp[i] = self.cost_a[i] / dt;
            cv[i] = self.cost_v[i] - cp[i];
        }

        // Cost gradient.
        let mut add_vector = |first: Option<usize>,
                              difference: Option<&Difference>,
                              x: &[f64],
                              by_b: bool,
                              s: f64| {
            if let (Some(first), Some(difference)) = (first, difference) {
                chained.copy_from_slice(x);
                difference.chain_vector(chained, by_b);
                for i in 0..nv {
                    gradient[first + i] += s * chained[i];
                }
            }
        };
        add_vector(layout.a, here, cv, false, 1.0 / dt);
        add_vector(layout.b, here, cv, true, 1.0 / dt);
        add_vector(layout.b, next, cp, false, 1.0 / dt_next);
        add_vector(layout.c, next, cp, true, 1.0 / dt_next);
        if let Some(time) = layout.time {
            let by_dt: f64 = (0..nv).map(|i| -cv[i] * v[i] - self.cost_a[i] * a[i]).sum();
            gradient[time] += by_dt / (dt * steps);
        }
        if let Some(time) = layout.time_next {
            let by_dt: f64 = (0..nv).map(|i| -cp[i] * v_next[i]).sum();
            gradient[time] += by_dt / (dt_next * steps_next);
        }

        // (q, v, a) → (q, v, v⁺): Hqv − Hqa/dt, Hqa/dt, Hvv + da/dt², −da/dt², da/dt².
        let vv = &mut self.vv;
        for i in 0..nv {
            vv[(i, i)] += da[i] / (dt * dt);
        }
        let mut put = |first_row: usize, first_col: usize, m: &DMatrix<f64>, s: f64| {
            for c in 0..nv {
                for r in (if first_row == first_col { c } else { 0 })..nv {
                    hessian[(first_col + c) * n + first_row + r] += s * m[(r, c)];
                }
            }
        };
        let [qv, work, other] = &mut self.work;
        qv.copy_from(&self.qv);
        qv.zip_apply(&self.qa, |x, y| *x -= y / dt);
        if let Some(first_a) = layout.a {
            if self.dynamics {
                put(first_a, first_a, &self.qq, 1.0);
            }
            if let Some(here) = here {
                // P = Hqv V_A; E = Hvv V_A; U = Hqvᵀ + E
                work.copy_from(qv);
                here.chain_columns(work, false);
                *work /= dt;
                put(first_a, first_a, work, 1.0);
                work.transpose_mut();
                put(first_a, first_a, work, 1.0);
                work.copy_from(vv);
                here.chain_columns(work, false);
                *work /= dt;
                other.copy_from(work);
                here.chain_rows(other, false);
                put(first_a, first_a, other, 1.0 / dt);
                if let Some(first_b) = layout.b {
                    for c in 0..nv {
                        for r in 0..nv {
                            work[(r, c)] += qv[(c, r)];
                        }
                    }
                    here.chain_rows(work, true);
                    put(first_b, first_a, work, 1.0 / dt);
                }
            }
            if let Some(next) = next {
                // W = Hqp ᵀ + Hpv V_A, rows v⁺, columns A
                for c in 0..nv {
                    for r in 0..nv {
                        work[(r, c)] = self.qa[(c, r)] / dt;
                    }
                }
                if let Some(here) = here {
                    other.fill(0.0);
                    for i in 0..nv {
                        other[(i, i)] = -da[i] / (dt * dt);
                    }
                    here.chain_columns(other, false);
                    work.zip_apply(other, |x, y| *x += y / dt);
                }
                if let Some(first_b) = layout.b {
                    other.copy_from(work);
                    next.chain_rows(other, false);
                    put(first_b, first_a, other, 1.0 / dt_next);
                }
                if let Some(first_c) = layout.c {
                    next.chain_rows(work, true);
                    put(first_c, first_a, work, 1.0 / dt_next);
                }
            }
        }
        if let Some(first_b) = layout.b {
            if let Some(here) = here {
                work.copy_from(vv);
                here.chain_columns(work, true);
                here.chain_rows(work, true);
                put(first_b, first_b, work, 1.0 / (dt * dt));
            }
            if let Some(next) = next {
                // Hpv V_B and Hpp V⁺_B, rows v⁺, columns B
                work.fill(0.0);
                other.fill(0.0);
                for i in 0..nv {
                    work[(i, i)] = -da[i] / (dt * dt);
                    other[(i, i)] = da[i] / (dt * dt);
                }
                next.chain_columns(other, false);
                *other /= dt_next;
                if let Some(here) = here {
                    here.chain_columns(work, true);
                    *work /= dt;
                    qv.copy_from(work);
                    next.chain_rows(qv, false);
                    *qv /= dt_next;
                    put(first_b, first_b, qv, 1.0);
                    qv.transpose_mut();
                    put(first_b, first_b, qv, 1.0);
                    if let Some(first_c) = layout.c {
                        next.chain_rows(work, true);
                        put(first_c, first_b, work, 1.0 / dt_next);
                    }
                }
                if let Some(first_c) = layout.c {
                    qv.copy_from(other);
                    next.chain_rows(qv, true);
                    put(first_c, first_b, qv, 1.0 / dt_next);
                }
                next.chain_rows(other, false);
                put(first_b, first_b, other, 1.0 / dt_next);
            }
        }
        if let (Some(first_c), Some(next)) = (layout.c, next) {
            work.fill(0.0);
            for i in 0..nv {
                work[(i, i)] = da[i] / (dt * dt);
            }
            next.chain_columns(work, true);
            next.chain_rows(work, true);
            put(first_c, first_c, work, 1.0 / (dt_next * dt_next));
        }

        // Curvature of the differences.
        if let Some(here) = here {
            let firsts = [layout.a, layout.b];
            for (w, g) in chained.iter_mut().zip(&*gv) {
                *w = g / dt;
            }
            here.curvature(chained, |br, i, bc, j, value| {
                add_curvature(hessian, n, firsts, (br, i), (bc, j), value);
            });
        }
        if let Some(next) = next {
            let firsts = [layout.b, layout.c];
            for (w, g) in chained.iter_mut().zip(&*gp) {
                *w = g / dt_next;
            }
            next.curvature(chained, |br, i, bc, j, value| {
                add_curvature(hessian, n, firsts, (br, i), (bc, j), value);
            });
        }
        let Some(time) = layout.time else { return };
        self.time_blocks(here, next, layout, time, hessian, n);
    }

    /// Rows and columns of the two durations.
    #[allow(clippy::too_many_arguments)] // continues `finish`
    #[allow(clippy::too_many_lines)] // one expression or layout, written down in its own order
    fn time_blocks(
        &mut self,
        here: Option<&Difference>,
        next: Option<&Difference>,
        layout: &Layout,
        time: usize,
        hessian: &mut [f64],
        n: usize,
    ) {
        let Motion {
            v,
            v_next,
            a,
            dt,
            dt_next,
            steps,
            steps_next,
        } = &self.motion;
        let nv = v.len();
        let (da, ga) = (&self.da, &self.by_a_gradient);
        let Vectors {
            gv,
            gp,
            vd,
            pd,
            q_dt,
            v_dt,
            p_dt,
            q_next,
            v_next: v_by_next,
            p_next: p_by_next,
            chained,
            ..
        } = &mut self.vectors;
        // Hessian times −v/dt (self.vv already holds + da/dt²), by rows q, v, v⁺; and the direct terms of dt.
        for i in 0..nv {
            vd[i] = -v[i] / dt;
            pd[i] = -v_next[i] / dt_next;
        }
        for sum in [&mut *q_dt, v_dt, p_dt, q_next] {
            sum.fill(0.0);
        }
        for k in 0..nv {
            for i in 0..nv {
                let (qv, qa) = (self.qv[(i, k)] - self.qa[(i, k)] / dt, self.qa[(i, k)]);
                q_dt[i] += qv * vd[k] - qa * a[k] / dt;
                q_next[i] += qa / dt * pd[k];
                v_dt[i] += self.vv[(i, k)] * vd[k];
            }
        }
        let (mut dt_dt, mut dt_next_dt, mut next_next) = (0.0, 0.0, 0.0);
        for i in 0..nv {
            let direct = da[i] * a[i] / (dt * dt) + ga[i] / (dt * dt);
            dt_dt += 2.0 * direct * vd[i]
                + da[i] * a[i] * a[i] / (dt * dt)
                + 2.0 * ga[i] * a[i] / (dt * dt);
            dt_dt += vd[i] * v_dt[i] + 2.0 * gv[i] * v[i] / (dt * dt);
            v_dt[i] += direct - gv[i] / dt;
            p_dt[i] += -direct - da[i] / (dt * dt) * vd[i];
            v_by_next[i] = -da[i] / (dt * dt) * pd[i];
            p_by_next[i] = da[i] / (dt * dt) * pd[i] - gp[i] / dt_next;
            dt_next_dt += p_dt[i] * pd[i];
            next_next +=
                da[i] / (dt * dt) * pd[i] * pd[i] + 2.0 * gp[i] * v_next[i] / (dt_next * dt_next);
        }
        let mut add = |column: usize,
                       first: Option<usize>,
                       by: Option<(&Difference, bool)>,
                       x: &[f64],
                       s: f64| {
            let Some(first) = first else { return };
            chained.copy_from_slice(x);
            if let Some((difference, by_b)) = by {
                difference.chain_vector(chained, by_b);
            }
            for i in 0..nv {
                hessian[(first + i) * n + column] += s * chained[i];
            }
        };
        add(time, layout.a, None, q_dt, 1.0 / steps);
        if let Some(here) = here {
            let s = 1.0 / (dt * steps);
            add(time, layout.a, Some((here, false)), v_dt, s);
            add(time, layout.b, Some((here, true)), v_dt, s);
        }
        if let Some(next) = next {
            let s = 1.0 / (dt_next * steps);
            add(time, layout.b, Some((next, false)), p_dt, s);
            add(time, layout.c, Some((next, true)), p_dt, s);
        }
        if let Some(time_next) = layout.time_next {
            add(time_next, layout.a, None, q_next, 1.0 / steps_next);
            if let Some(here) = here {
                let s = 1.0 / (dt * steps_next);
                add(time_next, layout.a, Some((here, false)), v_by_next, s);
                add(time_next, layout.b, Some((here, true)), v_by_next, s);
            }
            if let Some(next) = next {
                let s = 1.0 / (dt_next * steps_next);
                add(time_next, layout.b, Some((next, false)), p_by_next, s);
                add(time_next, layout.c, Some((next, true)), p_by_next, s);
            }
            let cross = dt_next_dt / (steps * steps_next);
            if time_next == time {
                hessian[time * n + time] += 2.0 * cross;
            } else {
                hessian[time.min(time_next) * n + time.max(time_next)] += cross;
            }
            hessian[time_next * n + time_next] += next_next / (steps_next * steps_next);
        }
        hessian[time * n + time] += dt_dt / (steps * steps);
    }
}

/// Adds one entry of a difference's curvature, where both of its nodes are variable.
fn add_curvature(
    hessian: &mut [f64],
    n: usize,
    firsts: [Option<usize>; 2],
    (block_row, i): (usize, usize),
    (block_col, j): (usize, usize),
    value: f64,
) {
    if let (Some(r), Some(c)) = (firsts[block_row], firsts[block_col]) {
        let (row, col) = (r + i, c + j);
        hessian[row.min(col) * n + row.max(col)] += value;
    }
}
