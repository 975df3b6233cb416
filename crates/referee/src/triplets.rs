//! A problem's Jacobian and Hessian as lists of (row, column, value) for a sparse solver, by the coordinates of a [`Chart`].
//!
//! Hessian entries lie in the lower triangle; entries of one place add up.

use crate::chart::{Chart, six};
use nalgebra::Matrix6;
use solver::{ElementData, Structure};

/// A column by d and the columns by increments at x that it gathers.
#[derive(Debug, Clone)]
struct Column {
    var: usize,
    /// Position and variable of each source.
    from: Vec<(usize, usize)>,
}

/// The places of all entries; constant during a solve.
#[derive(Debug, Clone)]
pub struct Triplets {
    /// Which variables form floating bodies.
    pub chart: Chart,
    /// Row and column of each Jacobian entry.
    pub jacobian: Vec<(usize, usize)>,
    /// Row and column of each Hessian entry, row ≥ column.
    pub hessian: Vec<(usize, usize)>,
    /// Columns per element and block.
    block_columns: Vec<Vec<Vec<Column>>>,
    /// Columns per element.
    element_columns: Vec<Vec<Column>>,
}

impl Triplets {
    /// Lists the places of a structure; `floating` as in [`Chart::new`].
    ///
    /// # Panics
    /// As [`Chart::new`].
    pub fn new(structure: &Structure, floating: &[usize]) -> Self {
        let chart = Chart::new(structure.n_vars, floating);
        let (mut jacobian, mut hessian) = (Vec::new(), Vec::new());
        let (mut block_columns, mut element_columns) = (Vec::new(), Vec::new());
        let mut first_row = 0;
        for element in &structure.elements {
            let mut per_block = Vec::new();
            for block in &element.blocks {
                let columns = columns(&chart, block.cols.iter().map(|&c| element.vars[c]));
                let first = first_row + block.first_row;
                for column in &columns {
                    jacobian.extend((first..first + block.n_rows).map(|row| (row, column.var)));
                }
                per_block.push(columns);
            }
            block_columns.push(per_block);
            first_row += element.n_rows();
            let columns = columns(&chart, element.vars.iter().copied());
            for (j, b) in columns.iter().enumerate() {
                for a in &columns[j..] {
                    hessian.push((a.var.max(b.var), a.var.min(b.var)));
                }
            }
            element_columns.push(columns);
        }
        for &first in floating {
            for j in 0..6 {
                hessian.extend((j..6).map(|i| (first + i, first + j)));
            }
        }
        Self {
            chart,
            jacobian,
            hessian,
            block_columns,
            element_columns,
        }
    }

    /// Entry of Jr: how much an increment of `from` at x moves with the coordinate `var`.
    fn weight(&self, jacobians: &[Matrix6<f64>], from: usize, var: usize) -> f64 {
        match (self.chart.place(from), self.chart.place(var)) {
            (Some((body, i)), Some((_, j))) => jacobians[body][(i, j)],
            _ => 1.0,
        }
    }

    /// Writes the Jacobian's values, in the order of [`Triplets::jacobian`].
    ///
    /// # Panics
    /// If `out` has fewer entries.
    pub fn jacobian_values(
        &self,
        structure: &Structure,
        jacobians: &[Matrix6<f64>],
        data: &[ElementData],
        out: &mut [f64],
    ) {
        let mut next = out.iter_mut();
        for (e, element) in structure.elements.iter().enumerate() {
            for (b, block) in element.blocks.iter().enumerate() {
                let local = &data[e].jacobians[b];
                for column in &self.block_columns[e][b] {
                    for row in 0..block.n_rows {
                        let value = column
                            .from
                            .iter()
                            .map(|&(c, var)| {
                                local[c * block.n_rows + row]
                                    * self.weight(jacobians, var, column.var)
                            })
                            .sum();
                        *next.next().expect("one value per place") = value;
                    }
                }
            }
        }
    }

    /// Adds `factor` times the elements' Hessians to values in the order of [`Triplets::hessian`].
    ///
    /// # Panics
    /// If `out` has fewer entries.
    pub fn add_hessian(
        &self,
        factor: f64,
        jacobians: &[Matrix6<f64>],
        data: &[ElementData],
        out: &mut [f64],
    ) {
        let mut next = out.iter_mut();
        for (columns, data) in self.element_columns.iter().zip(data) {
            let n = data.gradient.len();
            let entry = |i: usize, j: usize| data.hessian[i.min(j) * n + i.max(j)];
            for (j, b) in columns.iter().enumerate() {
                for a in &columns[j..] {
                    let mut value = 0.0;
                    for &(i, var_i) in &a.from {
                        let w = factor * self.weight(jacobians, var_i, a.var);
                        for &(k, var_k) in &b.from {
                            value += w * entry(i, k) * self.weight(jacobians, var_k, b.var);
                        }
                    }
                    *next.next().expect("one value per place") += value;
                }
            }
        }
    }

    /// Adds the chart's curvature at `d`, contracted with the Lagrangian's gradient by increments at x.
    ///
    /// # Panics
    /// If `out` has fewer entries than [`Triplets::hessian`].
    pub fn add_curvature(&self, d: &[f64], gradient: &[f64], out: &mut [f64]) {
        let n_bodies = self.chart.floating().len();
        let mut next = out[self.hessian.len() - 21 * n_bodies..].iter_mut();
        for &first in self.chart.floating() {
            let m = Chart::curvature(&six(d, first), &six(gradient, first));
            for j in 0..6 {
                for i in j..6 {
                    *next.next().expect("one value per place") += m[(i, j)];
                }
            }
        }
    }
}

/// The columns by d of a list of variables: plain ones as they are, once each, all six of a floating body if one of them is
/// there.
fn columns(chart: &Chart, vars: impl Iterator<Item = usize>) -> Vec<Column> {
    let mut columns: Vec<Column> = Vec::new();
    for (position, var) in vars.enumerate() {
        let Some((body, _)) = chart.place(var) else {
            match columns.iter_mut().find(|c| c.var == var) {
                Some(column) => column.from.push((position, var)),
                None => columns.push(Column {
                    var,
                    from: vec![(position, var)],
                }),
            }
            continue;
        };
        let first = chart.floating()[body];
        if !columns.iter().any(|c| c.var == first) {
            columns.extend((first..first + 6).map(|var| Column {
                var,
                from: Vec::new(),
            }));
        }
        for column in &mut columns {
            if (first..first + 6).contains(&column.var) {
                column.from.push((position, var));
            }
        }
    }
    columns
}
