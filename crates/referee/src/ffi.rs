//! The part of IPOPT's C interface (`IpStdCInterface.h`) that is used here.

use std::ffi::{c_char, c_int, c_void};

/// `IpoptProblem`: an opaque handle.
pub type Handle = *mut c_void;
pub type EvalF = unsafe extern "C" fn(c_int, *mut f64, c_int, *mut f64, *mut c_void) -> c_int;
pub type EvalGradF = EvalF;
pub type EvalG =
    unsafe extern "C" fn(c_int, *mut f64, c_int, c_int, *mut f64, *mut c_void) -> c_int;
pub type EvalJacG = unsafe extern "C" fn(
    c_int,
    *mut f64,
    c_int,
    c_int,
    c_int,
    *mut c_int,
    *mut c_int,
    *mut f64,
    *mut c_void,
) -> c_int;
pub type EvalH = unsafe extern "C" fn(
    c_int,
    *mut f64,
    c_int,
    f64,
    c_int,
    *mut f64,
    c_int,
    c_int,
    *mut c_int,
    *mut c_int,
    *mut f64,
    *mut c_void,
) -> c_int;
pub type Intermediate = unsafe extern "C" fn(
    c_int,
    c_int,
    f64,
    f64,
    f64,
    f64,
    f64,
    f64,
    f64,
    f64,
    c_int,
    *mut c_void,
) -> c_int;

unsafe extern "C" {
    pub fn CreateIpoptProblem(
        n: c_int,
        x_lower: *mut f64,
        x_upper: *mut f64,
        m: c_int,
        g_lower: *mut f64,
        g_upper: *mut f64,
        n_jacobian: c_int,
        n_hessian: c_int,
        index_style: c_int,
        eval_f: EvalF,
        eval_g: EvalG,
        eval_grad_f: EvalGradF,
        eval_jac_g: EvalJacG,
        eval_h: EvalH,
    ) -> Handle;
    pub fn FreeIpoptProblem(problem: Handle);
    pub fn AddIpoptStrOption(problem: Handle, key: *mut c_char, value: *mut c_char) -> c_int;
    pub fn AddIpoptNumOption(problem: Handle, key: *mut c_char, value: f64) -> c_int;
    pub fn AddIpoptIntOption(problem: Handle, key: *mut c_char, value: c_int) -> c_int;
    pub fn SetIntermediateCallback(problem: Handle, callback: Intermediate) -> c_int;
    pub fn IpoptSolve(
        problem: Handle,
        x: *mut f64,
        g: *mut f64,
        objective: *mut f64,
        mult_g: *mut f64,
        mult_x_lower: *mut f64,
        mult_x_upper: *mut f64,
        user_data: *mut c_void,
    ) -> c_int;
}
