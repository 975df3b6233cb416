//! What IPOPT calls: values and derivatives of a problem at steps from its start.
//!
//! No panic leaves a callback: it is caught, the solve is stopped, and the panic goes on afterwards.

use crate::triplets::Triplets;
use nalgebra::Matrix6;
use solver::{ElementData, Problem, Structure};
use std::any::Any;
use std::ffi::{c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What the callbacks work with.
pub(crate) struct Session<'a, P: Problem> {
    pub problem: &'a mut P,
    pub structure: Structure,
    pub triplets: Triplets,
    pub base: P::Point,
    pub point: P::Point,
    pub values: Vec<ElementData>,
    pub values_at: Vec<f64>,
    pub linear: Vec<ElementData>,
    pub linear_at: Vec<f64>,
    pub hessian: Vec<ElementData>,
    pub charts: Vec<Matrix6<f64>>,
    pub no_multipliers: Vec<f64>,
    pub iterations: usize,
    pub dual: f64,
    pub panic: Option<Box<dyn Any + Send>>,
}

impl<P: Problem> Session<'_, P> {
    pub fn move_to(&mut self, d: &[f64]) {
        self.problem.retract(&self.base, d, 1.0, &mut self.point);
    }

    fn evaluate(&mut self, d: &[f64]) {
        if self.values_at != d {
            self.move_to(d);
            self.problem.evaluate(&self.point, &mut self.values);
            self.values_at = d.to_vec();
        }
    }

    fn linearise(&mut self, d: &[f64]) {
        if self.linear_at != d {
            self.move_to(d);
            self.problem
                .linearise(&self.point, &self.no_multipliers, &mut self.linear);
            self.charts = self.triplets.chart.jacobians(d);
            self.linear_at = d.to_vec();
        }
    }

    pub fn objective(&mut self, d: &[f64]) -> f64 {
        self.evaluate(d);
        self.values.iter().map(|e| e.objective).sum()
    }

    pub fn rows(&mut self, d: &[f64], out: &mut [f64]) {
        self.evaluate(d);
        let rows = self.values.iter().flat_map(|e| &e.values);
        out.iter_mut().zip(rows).for_each(|(o, c)| *o = *c);
    }

    fn gradient(&mut self, d: &[f64], out: &mut [f64]) {
        self.linearise(d);
        out.fill(0.0);
        for (element, data) in self.structure.elements.iter().zip(&self.linear) {
            for (&v, g) in element.vars.iter().zip(&data.gradient) {
                out[v] += g;
            }
        }
        self.triplets.chart.pull_back(&self.charts, out);
    }

    fn jacobian(&mut self, d: &[f64], out: &mut [f64]) {
        self.linearise(d);
        self.triplets
            .jacobian_values(&self.structure, &self.charts, &self.linear, out);
    }

    /// ∇²(σ f + λᵀc) by d: the problem knows f + yᵀc only, so y = λ/σ, and without σ the objective is taken off.
    fn hessian(&mut self, d: &[f64], sigma: f64, lambda: &[f64], out: &mut [f64]) {
        self.linearise(d);
        self.move_to(d);
        out.fill(0.0);
        let (factor, y) = if sigma == 0.0 {
            (1.0, lambda.to_vec())
        } else {
            (sigma, lambda.iter().map(|l| l / sigma).collect())
        };
        self.problem.linearise(&self.point, &y, &mut self.hessian);
        let (charts, triplets) = (&self.charts, &self.triplets);
        triplets.add_hessian(factor, charts, &self.hessian, out);
        if sigma == 0.0 {
            triplets.add_hessian(-1.0, charts, &self.linear, out);
        }
        let mut gradient = vec![0.0; d.len()];
        let mut first_row = 0;
        for (element, data) in self.structure.elements.iter().zip(&self.linear) {
            for (&v, g) in element.vars.iter().zip(&data.gradient) {
                gradient[v] += sigma * g;
            }
            for (block, jacobian) in element.blocks.iter().zip(&data.jacobians) {
                let weights = &lambda[first_row + block.first_row..][..block.n_rows];
                for (k, &c) in block.cols.iter().enumerate() {
                    let column = &jacobian[k * block.n_rows..][..block.n_rows];
                    gradient[element.vars[c]] +=
                        column.iter().zip(weights).map(|(a, b)| a * b).sum::<f64>();
                }
            }
            first_row += element.n_rows();
        }
        triplets.add_curvature(d, &gradient, out);
    }

    /// Runs a callback's body; 0 tells IPOPT that it failed, as a panic or a value that is not finite does.
    fn guard(&mut self, body: impl FnOnce(&mut Self) -> bool) -> c_int {
        if self.panic.is_some() {
            return 0;
        }
        match catch_unwind(AssertUnwindSafe(|| body(self))) {
            Ok(fine) => c_int::from(fine),
            Err(payload) => {
                self.panic = Some(payload);
                0
            }
        }
    }
}

fn finite(values: &[f64]) -> bool {
    values.iter().all(|v| v.is_finite())
}

/// A slice that C gave as a pointer and a length.
///
/// # Safety
/// `len` numbers at `data`, not written to meanwhile; `data` is not looked at if `len` is 0.
unsafe fn slice<'a>(data: *mut f64, len: c_int) -> &'a [f64] {
    if len == 0 {
        return &[];
    }
    // SAFETY: the caller's promise.
    unsafe { std::slice::from_raw_parts(data, len as usize) }
}

/// As [`slice`], for writing.
///
/// # Safety
/// As [`slice`], and nobody else reads or writes there meanwhile.
unsafe fn slice_mut<'a>(data: *mut f64, len: c_int) -> &'a mut [f64] {
    if len == 0 {
        return &mut [];
    }
    // SAFETY: the caller's promise.
    unsafe { std::slice::from_raw_parts_mut(data, len as usize) }
}

/// The session behind IPOPT's user pointer.
///
/// # Safety
/// `user` comes from `solve_with_ipopt::<P>`, which holds no reference during `IpoptSolve`; IPOPT calls one at a time.
unsafe fn session<'a, 'b, P: Problem>(user: *mut c_void) -> &'a mut Session<'b, P> {
    // SAFETY: the caller's promise.
    unsafe { &mut *user.cast::<Session<'b, P>>() }
}

pub(crate) unsafe extern "C" fn eval_f<P: Problem>(
    n: c_int,
    x: *mut f64,
    _new: c_int,
    out: *mut f64,
    user: *mut c_void,
) -> c_int {
    // SAFETY: pointers and lengths as IPOPT's interface promises.
    let (x, out, session) = unsafe { (slice(x, n), slice_mut(out, 1), session::<P>(user)) };
    session.guard(|s| {
        out[0] = s.objective(x);
        finite(out)
    })
}

pub(crate) unsafe extern "C" fn eval_grad_f<P: Problem>(
    n: c_int,
    x: *mut f64,
    _new: c_int,
    out: *mut f64,
    user: *mut c_void,
) -> c_int {
    // SAFETY: as in `eval_f`.
    let (x, out, session) = unsafe { (slice(x, n), slice_mut(out, n), session::<P>(user)) };
    session.guard(|s| {
        s.gradient(x, out);
        finite(out)
    })
}

pub(crate) unsafe extern "C" fn eval_g<P: Problem>(
    n: c_int,
    x: *mut f64,
    _new: c_int,
    m: c_int,
    out: *mut f64,
    user: *mut c_void,
) -> c_int {
    // SAFETY: as in `eval_f`.
    let (x, out, session) = unsafe { (slice(x, n), slice_mut(out, m), session::<P>(user)) };
    session.guard(|s| {
        s.rows(x, out);
        finite(out)
    })
}

pub(crate) unsafe extern "C" fn eval_jac_g<P: Problem>(
    n: c_int,
    x: *mut f64,
    _new: c_int,
    _m: c_int,
    n_entries: c_int,
    rows: *mut c_int,
    columns: *mut c_int,
    values: *mut f64,
    user: *mut c_void,
) -> c_int {
    // SAFETY: as in `eval_f`; IPOPT asks for places (values null) or for values (places null, x given).
    let session = unsafe { session::<P>(user) };
    if values.is_null() {
        // SAFETY: `rows` and `columns` have one entry per triplet.
        return unsafe { write_places(&session.triplets.jacobian, rows, columns) };
    }
    // SAFETY: as above.
    let (x, out) = unsafe { (slice(x, n), slice_mut(values, n_entries)) };
    session.guard(|s| {
        s.jacobian(x, out);
        finite(out)
    })
}

pub(crate) unsafe extern "C" fn eval_h<P: Problem>(
    n: c_int,
    x: *mut f64,
    _new: c_int,
    sigma: f64,
    m: c_int,
    lambda: *mut f64,
    _new_lambda: c_int,
    n_entries: c_int,
    rows: *mut c_int,
    columns: *mut c_int,
    values: *mut f64,
    user: *mut c_void,
) -> c_int {
    // SAFETY: as in `eval_jac_g`.
    let session = unsafe { session::<P>(user) };
    if values.is_null() {
        // SAFETY: as in `eval_jac_g`.
        return unsafe { write_places(&session.triplets.hessian, rows, columns) };
    }
    // SAFETY: as in `eval_jac_g`.
    let (x, lambda, out) = unsafe { (slice(x, n), slice(lambda, m), slice_mut(values, n_entries)) };
    session.guard(|s| {
        s.hessian(x, sigma, lambda, out);
        finite(out)
    })
}

/// Writes the places of triplets.
///
/// # Safety
/// `rows` and `columns` have room for all of them.
unsafe fn write_places(places: &[(usize, usize)], rows: *mut c_int, columns: *mut c_int) -> c_int {
    for (k, &(i, j)) in places.iter().enumerate() {
        // SAFETY: the caller's promise.
        unsafe {
            *rows.add(k) = count(i);
            *columns.add(k) = count(j);
        }
    }
    1
}

pub(crate) unsafe extern "C" fn observe<P: Problem>(
    _mode: c_int,
    iteration: c_int,
    _objective: f64,
    _violation: f64,
    dual: f64,
    _barrier: f64,
    _step: f64,
    _regularisation: f64,
    _alpha_dual: f64,
    _alpha: f64,
    _trials: c_int,
    user: *mut c_void,
) -> c_int {
    // SAFETY: as in `eval_f`.
    let session = unsafe { session::<P>(user) };
    session.iterations = iteration as usize;
    session.dual = dual;
    c_int::from(session.panic.is_none())
}

/// A size as IPOPT counts.
pub(crate) fn count(n: usize) -> c_int {
    c_int::try_from(n).expect("a problem that IPOPT's indices can count")
}
