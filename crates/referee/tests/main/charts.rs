//! Derivatives by the coordinates of a chart, on a problem with a floating body.

use nalgebra::{DMatrix, Matrix3, Matrix6, RowVector6, Vector3, Vector6};
use referee::{Chart, Triplets};
use solver::{BlockStructure, ElementData, ElementStructure, Problem, Structure};
use spatial::Pose;

const INF: f64 = f64::INFINITY;

/// Moves a body's marks onto those of a target: min Σ ½|p_k − t_k|² + ½(s − 2)² with s · p_z = 1, p a mark on its z axis.
///
/// Variables: 0 s, 1–6 the body's increments.
pub struct Marks {
    structure: Structure,
    target: Pose,
}

/// A point: the body's pose and s.
#[derive(Clone, Debug)]
pub struct Placed {
    /// Where the body is.
    pub world_from_body: Pose,
    /// The plain number.
    pub s: f64,
}

const MARKS: [Vector3<f64>; 3] = [
    Vector3::new(0.4, 0.0, 0.1),
    Vector3::new(0.0, -0.3, 0.2),
    Vector3::new(0.1, 0.2, -0.5),
];
const AXIS_MARK: Vector3<f64> = Vector3::new(0.0, 0.0, 0.3);

fn skew(v: Vector3<f64>) -> Matrix3<f64> {
    v.cross_matrix()
}

/// Gradient of u · (pose · x) by body increments.
fn mark_gradient(pose: &Pose, x: Vector3<f64>, u: Vector3<f64>) -> Vector6<f64> {
    let u = pose.rotate_inverse(u);
    let m = x.cross(&u);
    Vector6::new(u.x, u.y, u.z, m.x, m.y, m.z)
}

/// Second derivative of u · (pose · exp(ξ) x) at ξ = 0: from exp(ξ)x = x + v + ω×x + ½ω×(v + ω×x) + ….
fn mark_hessian(pose: &Pose, x: Vector3<f64>, u: Vector3<f64>) -> Matrix6<f64> {
    let u = pose.rotate_inverse(u);
    let mut h = Matrix6::zeros();
    let mixed = 0.5 * skew(u);
    h.fixed_view_mut::<3, 3>(0, 3).copy_from(&mixed);
    h.fixed_view_mut::<3, 3>(3, 0).copy_from(&mixed.transpose());
    let bend = 0.5 * (u * x.transpose() + x * u.transpose()) - Matrix3::identity() * u.dot(&x);
    h.fixed_view_mut::<3, 3>(3, 3).copy_from(&bend);
    h
}

impl Marks {
    /// With the marks of a body at `target`.
    pub fn new(target: Pose) -> Self {
        let element = |vars: Vec<usize>, rows: usize, cols: &[usize]| ElementStructure {
            vars,
            row_lower: vec![1.0; rows],
            row_upper: vec![1.0; rows],
            blocks: (0..rows)
                .map(|first_row| BlockStructure {
                    first_row,
                    n_rows: 1,
                    cols: cols.to_vec(),
                })
                .collect(),
        };
        // The row's gradient lacks the turn about the body's z axis, variable 6; its columns are out of order.
        let elements = vec![
            element((1..7).collect(), 0, &[]),
            element(vec![3, 0, 1, 5, 6, 2, 4], 1, &[3, 1, 2, 0, 6, 5]),
        ];
        Self {
            structure: Structure {
                n_vars: 7,
                lower: vec![0.5, -INF, -INF, -INF, -INF, -INF, -INF],
                upper: vec![INF; 7],
                elements,
            },
            target,
        }
    }
}

impl Problem for Marks {
    type Point = Placed;

    fn structure(&self) -> &Structure {
        &self.structure
    }

    fn retract(&self, x: &Placed, dx: &[f64], step: f64, out: &mut Placed) {
        let xi = Vector6::from_column_slice(&dx[1..7]) * step;
        out.world_from_body = x.world_from_body.plus(&xi);
        out.s = x.s + step * dx[0];
    }

    fn coordinates(&self, x: &Placed, out: &mut [f64]) {
        out[0] = x.s;
    }

    fn evaluate(&mut self, x: &Placed, out: &mut [ElementData]) {
        let apart = MARKS.map(|m| x.world_from_body.act(m) - self.target.act(m));
        out[0].objective = apart.iter().map(|a| 0.5 * a.norm_squared()).sum();
        out[1].objective = 0.5 * (x.s - 2.0).powi(2);
        out[1].values[0] = x.s * x.world_from_body.act(AXIS_MARK).z;
    }

    fn linearise(&mut self, x: &Placed, y: &[f64], out: &mut [ElementData]) {
        self.evaluate(x, out);
        let pose = &x.world_from_body;
        let (mut g, mut h) = (Vector6::zeros(), Matrix6::zeros());
        for mark in MARKS {
            let apart = pose.act(mark) - self.target.act(mark);
            g += mark_gradient(pose, mark, apart);
            h += mark_hessian(pose, mark, apart);
            for axis in 0..3 {
                let j = mark_gradient(pose, mark, Vector3::ith(axis, 1.0));
                h += j * j.transpose();
            }
        }
        out[0].gradient.copy_from_slice(g.as_slice());
        out[0].hessian.copy_from_slice(h.as_slice());
        let z = pose.act(AXIS_MARK).z;
        let g = mark_gradient(pose, AXIS_MARK, Vector3::z());
        let h = mark_hessian(pose, AXIS_MARK, Vector3::z());
        let vars = &self.structure.elements[1].vars;
        let by = |v: usize| if v == 0 { z } else { x.s * g[v - 1] };
        let data = &mut out[1];
        for (j, &b) in vars.iter().enumerate() {
            data.gradient[j] = if b == 0 { x.s - 2.0 } else { 0.0 };
            for (i, &a) in vars.iter().enumerate() {
                data.hessian[j * vars.len() + i] = match (a, b) {
                    (0, 0) => 1.0,
                    (0, v) | (v, 0) => y[0] * g[v - 1],
                    (a, b) => y[0] * x.s * h[(a - 1, b - 1)],
                };
            }
        }
        for (k, &c) in self.structure.elements[1].blocks[0].cols.iter().enumerate() {
            data.jacobians[0][k] = by(vars[c]);
        }
    }
}

const MULTIPLIER: f64 = 0.7;
const D: [f64; 7] = [0.3, 0.4, -0.2, 0.5, -0.9, 0.7, 1.1];

fn start() -> Placed {
    Placed {
        world_from_body: Pose::random(3),
        s: 1.3,
    }
}

/// Objective and row at base ⊕ d.
fn at(d: &[f64]) -> [f64; 2] {
    let mut problem = Marks::new(Pose::random(8));
    let mut data: Vec<_> = problem
        .structure
        .elements
        .iter()
        .map(ElementData::new)
        .collect();
    let mut x = start();
    problem.retract(&start(), d, 1.0, &mut x);
    problem.evaluate(&x, &mut data);
    [data[0].objective + data[1].objective, data[1].values[0]]
}

/// Gradient of the objective, row of the Jacobian and Hessian of the Lagrangian by d.
fn by_chart(d: &[f64]) -> (Vec<f64>, RowVector6<f64>, f64, DMatrix<f64>) {
    let mut problem = Marks::new(Pose::random(8));
    let structure = problem.structure.clone();
    let mut data: Vec<_> = structure.elements.iter().map(ElementData::new).collect();
    let mut x = start();
    problem.retract(&start(), d, 1.0, &mut x);
    problem.linearise(&x, &[MULTIPLIER], &mut data);
    let triplets = Triplets::new(&structure, &[1]);
    let jacobians = triplets.chart.jacobians(d);

    let (mut gradient, mut lagrangian) = (vec![0.0; 7], vec![0.0; 7]);
    for (element, data) in structure.elements.iter().zip(&data) {
        for (&v, g) in element.vars.iter().zip(&data.gradient) {
            gradient[v] += g;
        }
    }
    lagrangian.copy_from_slice(&gradient);
    let block = &structure.elements[1].blocks[0];
    for (&c, j) in block.cols.iter().zip(&data[1].jacobians[0]) {
        lagrangian[structure.elements[1].vars[c]] += MULTIPLIER * j;
    }
    triplets.chart.pull_back(&jacobians, &mut gradient);

    let mut values = vec![f64::NAN; triplets.jacobian.len()];
    triplets.jacobian_values(&structure, &jacobians, &data, &mut values);
    let mut row = [0.0; 7];
    for (&(r, c), v) in triplets.jacobian.iter().zip(&values) {
        assert_eq!(r, 0);
        row[c] += v;
    }
    let mut values = vec![0.0; triplets.hessian.len()];
    triplets.add_hessian(1.0, &jacobians, &data, &mut values);
    triplets.add_curvature(d, &lagrangian, &mut values);
    let mut hessian = DMatrix::zeros(7, 7);
    for (&(r, c), v) in triplets.hessian.iter().zip(&values) {
        assert!(r >= c, "lower triangle");
        hessian[(r, c)] += v;
    }
    hessian.fill_upper_triangle_with_lower_triangle();
    (
        gradient,
        RowVector6::from_column_slice(&row[1..]),
        row[0],
        hessian,
    )
}

#[test]
fn gradient_and_row_match_finite_differences_far_from_the_base() {
    let (gradient, row, row_by_s, _) = by_chart(&D);
    let mut jacobian = vec![0.0; 14];
    for v in 0..7 {
        jacobian[2 * v] = gradient[v];
        jacobian[2 * v + 1] = if v == 0 { row_by_s } else { row[v - 1] };
    }
    derivcheck::assert_jacobian(|d| at(d).to_vec(), &D, &jacobian, 1e-8);
}

#[test]
fn hessian_matches_finite_differences_far_from_the_base() {
    let lagrangian_gradient = |d: &[f64]| {
        let (mut g, row, row_by_s, _) = by_chart(d);
        g[0] += MULTIPLIER * row_by_s;
        for v in 1..7 {
            g[v] += MULTIPLIER * row[v - 1];
        }
        g
    };
    let (_, _, _, hessian) = by_chart(&D);
    derivcheck::assert_jacobian(lagrangian_gradient, &D, hessian.as_slice(), 1e-7);
}

#[test]
fn a_chart_is_flat_at_its_base() {
    let g = Vector6::new(0.3, -0.2, 0.9, 0.4, 0.1, -0.7);
    assert!(Chart::curvature(&Vector6::zeros(), &g).amax() < 1e-9);
    assert!(Chart::curvature(&Vector6::new(0.1, 0.2, 0.3, 0.4, 0.5, 0.6), &g).amax() > 1e-2);
}

#[test]
#[should_panic(expected = "floating bodies overlap")]
fn overlapping_bodies_are_refused() {
    let _ = Chart::new(20, &[0, 5]);
}
