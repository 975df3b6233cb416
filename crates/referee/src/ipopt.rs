//! One solve with IPOPT: the options, the result.

use crate::callbacks::{Session, count, eval_f, eval_g, eval_grad_f, eval_h, eval_jac_g, observe};
use crate::ffi;
use crate::triplets::Triplets;
use solver::{ElementData, Problem};
use std::ffi::{CString, c_int};
use std::panic::resume_unwind;
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
