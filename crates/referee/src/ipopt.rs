//! One solve with IPOPT: the callbacks, the options, the result.
//!
//! No panic leaves a callback: it is caught, the solve is stopped, and the panic goes on afterwards.

use crate::ffi;
use crate::triplets::Triplets;
use nalgebra::Matrix6;
use solver::{ElementData, Problem, Structure};
use std::any::Any;
use std::ffi::{CString, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// MUMPS keeps global state: one solve at a time, tests run in threads.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// Bound beyond which IPOPT sees none.
const INFINITE: f64 = 1e20;

/// Options of one solve.
#[derive(Debug, Clone)]
pub struct IpoptOptions {
    /// Most iterations.
    pub max_iterations: i32,
    /// IPOPT's `tol`: optimality, violation and complementarity, of the unscaled problem.
    pub tolerance: f64,
    /// Processor time limit [s].
    pub time_limit: f64,
    /// Distance that the start is kept from bounds (`bound_push`, `bound_frac` and those of the slacks).
    pub bound_push: f64,
    /// First barrier parameter; first bound multipliers follow it.
    pub first_barrier: f64,
}

impl Default for IpoptOptions {
    fn default() -> Self {
        Self {
            max_iterations: 500,
            tolerance: 1e-6,
            time_limit: 120.0,
            bound_push: 1e-2,
            first_barrier: 0.1,
        }
    }
}

impl IpoptOptions {
    /// For a start that is a solution: stays close to it.
    pub fn from_solution() -> Self {
        Self {
            bound_push: 1e-7,
            first_barrier: 1e-6,
            ..Self::default()
        }
    }
}

/// How IPOPT ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IpoptStatus {
    /// All tolerances are met.
    Solved,
    /// IPOPT's acceptable level: tolerances a hundred times wider.
    Acceptable,
    /// It found the problem locally infeasible.
    Infeasible,
    /// The iteration limit was reached.
    IterationLimit,
    /// The time limit was reached.
    TimeLimit,
    /// Anything else, with IPOPT's return code.
    Failed(i32),
}

impl IpoptStatus {
    fn of(code: c_int) -> Self {
        match code {
            0 => Self::Solved,
            1 => Self::Acceptable,
            2 => Self::Infeasible,
            -1 => Self::IterationLimit,
            -4 => Self::TimeLimit,
            other => Self::Failed(other),
        }
    }
}

/// What IPOPT found, beside the point.
#[derive(Debug, Clone)]
pub struct IpoptReport {
    /// How it ended.
    pub status: IpoptStatus,
    /// Iterations.
    pub iterations: usize,
    /// Objective at the point.
    pub objective: f64,
    /// Largest violation of a row or variable bound at the point, in the problem's units.
    pub violation: f64,
    /// IPOPT's dual infeasibility of the last iteration.
    pub dual: f64,
    /// Wall time [s].
    pub seconds: f64,
}

/// What the callbacks work with.
struct Session<'a, P: Problem> {
    problem: &'a mut P,
    structure: Structure,
    triplets: Triplets,
    base: P::Point,
    point: P::Point,
    values: Vec<ElementData>,
    values_at: Vec<f64>,
    linear: Vec<ElementData>,
    linear_at: Vec<f64>,
    hessian: Vec<ElementData>,
    charts: Vec<Matrix6<f64>>,
    no_multipliers: Vec<f64>,
    iterations: usize,
    dual: f64,
    panic: Option<Box<dyn Any + Send>>,
}

impl<P: Problem> Session<'_, P> {
    fn move_to(&mut self, d: &[f64]) {
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

    fn objective(&mut self, d: &[f64]) -> f64 {
        self.evaluate(d);
        self.values.iter().map(|e| e.objective).sum()
    }

    fn rows(&mut self, d: &[f64], out: &mut [f64]) {
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

unsafe extern "C" fn eval_f<P: Problem>(
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

unsafe extern "C" fn eval_grad_f<P: Problem>(
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

unsafe extern "C" fn eval_g<P: Problem>(
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

unsafe extern "C" fn eval_jac_g<P: Problem>(
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

unsafe extern "C" fn eval_h<P: Problem>(
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

unsafe extern "C" fn observe<P: Problem>(
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

/// IPOPT's handle, freed when it goes.
struct Handle(ffi::Handle);

impl Drop for Handle {
    fn drop(&mut self) {
        // SAFETY: made by `CreateIpoptProblem`, not null, freed once.
        unsafe { ffi::FreeIpoptProblem(self.0) }
    }
}

impl Handle {
    fn text(&self, key: &str, value: &str) {
        let (k, v) = (c_string(key), c_string(value));
        // SAFETY: IPOPT copies both strings and does not write to them.
        let fine =
            unsafe { ffi::AddIpoptStrOption(self.0, k.as_ptr().cast_mut(), v.as_ptr().cast_mut()) };
        assert!(fine != 0, "IPOPT refuses {key} = {value}");
    }

    fn number(&self, key: &str, value: f64) {
        let k = c_string(key);
        // SAFETY: as in `text`.
        let fine = unsafe { ffi::AddIpoptNumOption(self.0, k.as_ptr().cast_mut(), value) };
        assert!(fine != 0, "IPOPT refuses {key} = {value}");
    }

    fn integer(&self, key: &str, value: c_int) {
        let k = c_string(key);
        // SAFETY: as in `text`.
        let fine = unsafe { ffi::AddIpoptIntOption(self.0, k.as_ptr().cast_mut(), value) };
        assert!(fine != 0, "IPOPT refuses {key} = {value}");
    }

    fn set(&self, options: &IpoptOptions) {
        self.text("sb", "yes");
        self.integer("print_level", 0);
        self.text("mu_strategy", "adaptive");
        // The problems scale their rows themselves; so IPOPT's tolerances mean what ours mean.
        self.text("nlp_scaling_method", "none");
        self.number("tol", options.tolerance);
        self.number("constr_viol_tol", options.tolerance);
        self.integer("max_iter", options.max_iterations);
        self.number("max_cpu_time", options.time_limit);
        self.number("mu_init", options.first_barrier);
        self.text("bound_mult_init_method", "mu-based");
        for key in [
            "bound_push",
            "bound_frac",
            "slack_bound_push",
            "slack_bound_frac",
        ] {
            self.number(key, options.bound_push);
        }
    }
}

fn c_string(text: &str) -> CString {
    CString::new(text).expect("no zero byte in an option")
}

fn count(n: usize) -> c_int {
    c_int::try_from(n).expect("a problem that IPOPT's indices can count")
}

/// Minimises from `start` with IPOPT and MUMPS; `floating` are the first variables of the floating bodies.
///
/// # Panics
/// If IPOPT refuses the problem or an option, or the problem itself panics.
pub fn solve_with_ipopt<P: Problem>(
    problem: &mut P,
    start: &P::Point,
    floating: &[usize],
    options: &IpoptOptions,
) -> (P::Point, IpoptReport) {
    let _alone = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let begin = Instant::now();
    let structure = problem.structure().clone();
    let n = structure.n_vars;
    let triplets = Triplets::new(&structure, floating);
    let data: Vec<_> = structure.elements.iter().map(ElementData::new).collect();
    let row_bounds = |pick: fn(&solver::ElementStructure) -> &Vec<f64>| -> Vec<f64> {
        structure
            .elements
            .iter()
            .flat_map(|e| pick(e).iter().map(|b| b.clamp(-INFINITE, INFINITE)))
            .collect()
    };
    let (mut g_lower, mut g_upper) = (row_bounds(|e| &e.row_lower), row_bounds(|e| &e.row_upper));
    let m = g_lower.len();
    let mut at = vec![0.0; n];
    problem.coordinates(start, &mut at);
    let about = |bounds: &[f64]| -> Vec<f64> {
        let finite = |b: f64, x: f64| if b.is_finite() { b - x } else { b };
        bounds
            .iter()
            .zip(&at)
            .map(|(&b, &x)| finite(b, x).clamp(-INFINITE, INFINITE))
            .collect()
    };
    let (mut x_lower, mut x_upper) = (about(&structure.lower), about(&structure.upper));

    // SAFETY: the arrays have n and m entries and are copied; the callbacks are those of P.
    let raw = unsafe {
        ffi::CreateIpoptProblem(
            count(n),
            x_lower.as_mut_ptr(),
            x_upper.as_mut_ptr(),
            count(m),
            g_lower.as_mut_ptr(),
            g_upper.as_mut_ptr(),
            count(triplets.jacobian.len()),
            count(triplets.hessian.len()),
            0,
            eval_f::<P>,
            eval_g::<P>,
            eval_grad_f::<P>,
            eval_jac_g::<P>,
            eval_h::<P>,
        )
    };
    assert!(!raw.is_null(), "IPOPT refuses the problem");
    let handle = Handle(raw);
    handle.set(options);
    let mut session = Session {
        problem,
        structure,
        triplets,
        base: start.clone(),
        point: start.clone(),
        values: data.clone(),
        values_at: Vec::new(),
        linear: data.clone(),
        linear_at: Vec::new(),
        hessian: data,
        charts: Vec::new(),
        no_multipliers: vec![0.0; m],
        iterations: 0,
        dual: f64::NAN,
        panic: None,
    };
    let mut d = vec![0.0; n];
    let null = std::ptr::null_mut;
    // SAFETY: `d` has n entries; the user pointer is the session of P, to which no other reference is used meanwhile.
    let code = unsafe {
        ffi::SetIntermediateCallback(handle.0, observe::<P>);
        ffi::IpoptSolve(
            handle.0,
            d.as_mut_ptr(),
            null(),
            null(),
            null(),
            null(),
            null(),
            std::ptr::from_mut(&mut session).cast(),
        )
    };
    if let Some(payload) = session.panic.take() {
        resume_unwind(payload);
    }
    let objective = session.objective(&d);
    let mut rows = vec![0.0; m];
    session.rows(&d, &mut rows);
    let outside = |x: &[f64], l: &[f64], u: &[f64]| {
        (0..x.len()).fold(0.0_f64, |worst, i| worst.max(l[i] - x[i]).max(x[i] - u[i]))
    };
    let violation = outside(&rows, &g_lower, &g_upper).max(outside(&d, &x_lower, &x_upper));
    session.move_to(&d);
    let report = IpoptReport {
        status: IpoptStatus::of(code),
        iterations: session.iterations,
        objective,
        violation,
        dual: session.dual,
        seconds: begin.elapsed().as_secs_f64(),
    };
    (session.point, report)
}
