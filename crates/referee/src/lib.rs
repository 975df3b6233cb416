//! A second opinion: IPOPT on the problems that [`solver`] solves.
//!
//! IPOPT works in ℝⁿ, our problems on manifolds. So IPOPT moves the tangent coordinates d about a fixed base point,
//! x = base ⊕ d. A problem's derivatives are by increments *at x*; [`Chart`] turns them into exact derivatives by d.
//! The feature `ipopt` links the library and adds `solve_with_ipopt`; everything else builds without it.
//!
//! Source: Wächter and Biegler 2006; C interface of IPOPT 3.11 to 3.14 (`IpStdCInterface.h`).

#[cfg(feature = "ipopt")]
#[allow(unsafe_code, reason = "calls of a C library and callbacks from it")]
mod callbacks;
mod chart;
#[cfg(feature = "ipopt")]
#[allow(unsafe_code, reason = "calls of a C library and callbacks from it")]
mod ffi;
#[cfg(feature = "ipopt")]
#[allow(unsafe_code, reason = "calls of a C library and callbacks from it")]
mod ipopt;
mod triplets;

pub use chart::Chart;
#[cfg(feature = "ipopt")]
pub use ipopt::{IpoptOptions, IpoptReport, IpoptStatus, solve_with_ipopt};
pub use triplets::Triplets;
