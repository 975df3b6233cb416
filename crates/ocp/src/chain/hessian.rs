//! Second step of the chain rule: gradient of the costs and Hessian of the Lagrangian over the node variables and durations.
//!
//! By (q, v, v⁺) with a = (v⁺ − v)/dt the blocks are: qq; q with v: qv − qa/dt; q with v⁺: qa/dt; v with v: vv and
//! diagonal; v with v⁺ and v⁺ with v⁺: diagonal. q is node A itself; v and v⁺ follow the nodes by [`Link`]s.

use super::link::Link;
use super::vectors::Vectors;
use super::{Chain, Layout};
use crate::difference::Difference;
use multibody::RneaHessian;
use nalgebra::DMatrix;

impl Chain {
    /// Adds the cost gradient and the Hessian of the Lagrangian to the element; `dynamics` as given to
    /// [`Chain::start`], if it was.
    pub fn finish(
        &mut self,
        dynamics: Option<&RneaHessian>,
        here: Option<&Difference>,
        next: Option<&Difference>,
        layout: &Layout,
        gradient: &mut [f64],
        hessian: &mut [f64],
    ) {
        let n = gradient.len();
        self.weights();
        let links = self.links(here, next, layout);
        for link in links.iter().flatten() {
            self.cost_gradient(link, gradient);
        }
        for x in links.iter().flatten() {
            for y in links.iter().flatten().filter(|y| y.first <= x.first) {
                self.diagonal(x, y, n, hessian);
            }
        }
        if let Some(dynamics) = dynamics {
            self.dynamics(dynamics, &links, layout, n, hessian);
        }
        self.curvature(here, next, layout, n, hessian);
        if let Some(time) = layout.time {
            self.durations(dynamics, &links, layout, time, gradient, hessian);
        }
    }

    /// Gradients by (v, v⁺) from those by (v, a), and the diagonal of the Hessian.
    fn weights(&mut self) {
        let dt = self.motion.dt;
        let Vectors {
            gv,
            gp,
            cv,
            cp,
            vv,
            vp,
            pp,
            ..
        } = &mut self.vectors;
        for i in 0..gv.len() {
            gp[i] = self.by_a_gradient[i] / dt;
            gv[i] = self.by_v_gradient[i] - gp[i];
            cp[i] = self.cost_a[i] / dt;
            cv[i] = self.cost_v[i] - cp[i];
            pp[i] = self.da[i] / (dt * dt);
            vp[i] = -pp[i];
            vv[i] = self.dv[i] + pp[i];
        }
    }

    fn cost_gradient(&mut self, link: &Link, gradient: &mut [f64]) {
        let Vectors {
            cv, cp, chained, ..
        } = &mut self.vectors;
        chained.copy_from_slice(if link.next { cp } else { cv });
        link.difference.recombine(chained, link.end);
        for (g, c) in gradient[link.first..].iter_mut().zip(chained) {
            *g += link.slope * *c;
        }
    }

    /// The diagonal of the Hessian by two of v and v⁺, at rows of `x` and columns of `y`, which is no later node.
    fn diagonal(&self, x: &Link, y: &Link, n: usize, hessian: &mut [f64]) {
        let Vectors { vv, vp, pp, .. } = &self.vectors;
        let weights = match (x.next, y.next) {
            (false, false) => vv,
            (true, true) => pp,
            _ => vp,
        };
        let (same, slope) = (x.first == y.first, x.slope * y.slope);
        let other = (y.difference, y.end);
        x.difference
            .weighted_product(x.end, other, weights, !same, |row, column, value| {
                hessian[(y.first + column) * n + x.first + row] += slope * value;
            });
    }

    /// What comes from the equations of motion, the durations apart.
    fn dynamics(
        &mut self,
        dynamics: &RneaHessian,
        links: &[Option<Link>; 4],
        layout: &Layout,
        n: usize,
        hessian: &mut [f64],
    ) {
        let dt = self.motion.dt;
        let [by_v, by_next, work, other] = &mut self.work;
        // v and v⁺ with q, rows v.
        self.qv.transpose_to(by_v);
        dynamics.hessian_qa().transpose_to(by_next);
        *by_next /= dt;
        *by_v -= &*by_next;
        if let Some(first) = layout.a {
            add_lower(hessian, n, first, &self.qq, 1.0);
            for link in links.iter().flatten() {
                work.copy_from(if link.next { by_next } else { by_v });
                link.difference.recombine_rows(work, link.end);
                if link.first == first {
                    add_lower(hessian, n, first, work, link.slope);
                    work.transpose_to(other);
                    add_lower(hessian, n, first, other, link.slope);
                } else {
                    add(hessian, n, (link.first, first), work, link.slope);
                }
            }
        }
        // v with v.
        for y in links.iter().flatten().filter(|link| !link.next) {
            other.copy_from(dynamics.hessian_vv());
            y.difference.recombine_columns(other, y.end);
            for x in links.iter().flatten() {
                if x.next || x.first < y.first {
                    continue;
                }
                work.copy_from(other);
                x.difference.recombine_rows(work, x.end);
                if x.first == y.first {
                    add_lower(hessian, n, x.first, work, x.slope * y.slope);
                } else {
                    add(hessian, n, (x.first, y.first), work, x.slope * y.slope);
                }
            }
        }
    }

    /// Curvature of the differences of floating bodies.
    fn curvature(
        &mut self,
        here: Option<&Difference>,
        next: Option<&Difference>,
        layout: &Layout,
        n: usize,
        hessian: &mut [f64],
    ) {
        let Vectors {
            gv, gp, chained, ..
        } = &mut self.vectors;
        let sides = [
            (here, [layout.a, layout.b], gv, self.motion.dt),
            (next, [layout.b, layout.c], gp, self.motion.dt_next),
        ];
        for (difference, firsts, gradient, dt) in sides {
            let Some(difference) = difference else {
                continue;
            };
            for (w, g) in chained.iter_mut().zip(&*gradient) {
                *w = g / dt;
            }
            difference.curvature(chained, |block_row, i, block_col, j, value| {
                if let (Some(r), Some(c)) = (firsts[block_row], firsts[block_col]) {
                    let (row, col) = (r + i, c + j);
                    hessian[row.min(col) * n + row.max(col)] += value;
                }
            });
        }
    }
}

/// Adds `s · m` at rows and columns that begin at `firsts`.
fn add(hessian: &mut [f64], n: usize, firsts: (usize, usize), m: &DMatrix<f64>, s: f64) {
    let columns = hessian[firsts.1 * n..].chunks_exact_mut(n);
    for (out, column) in columns.zip(m.as_slice().chunks_exact(m.nrows())) {
        for (o, x) in out[firsts.0..].iter_mut().zip(column) {
            *o += s * x;
        }
    }
}

/// Adds the lower triangle of `s · m` on the diagonal.
fn add_lower(hessian: &mut [f64], n: usize, first: usize, m: &DMatrix<f64>, s: f64) {
    let columns = hessian[first * n..].chunks_exact_mut(n);
    for (c, (out, column)) in columns
        .zip(m.as_slice().chunks_exact(m.nrows()))
        .enumerate()
    {
        for (o, x) in out[first + c..].iter_mut().zip(&column[c..]) {
            *o += s * x;
        }
    }
}
