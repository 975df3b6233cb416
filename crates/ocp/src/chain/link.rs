//! How the velocities of an interval follow its nodes: ∂v/∂node = slope · X, with X of [`Difference`].

use super::{Chain, Layout};
use crate::difference::{Difference, End};

/// One of ∂v/∂A, ∂v/∂B, ∂v⁺/∂B, ∂v⁺/∂C.
#[derive(Clone, Copy)]
pub(super) struct Link<'a> {
    /// First local variable of the node.
    pub first: usize,
    /// The difference whose velocity moves.
    pub difference: &'a Difference,
    /// Which of its ends the node is.
    pub end: End,
    /// ±1/dt.
    pub slope: f64,
    /// True for v⁺.
    pub next: bool,
}

impl Chain {
    /// The links whose node is variable and whose velocity is not at rest, in the order of the nodes.
    pub(super) fn links<'a>(
        &self,
        here: Option<&'a Difference>,
        next: Option<&'a Difference>,
        layout: &Layout,
    ) -> [Option<Link<'a>>; 4] {
        let link = |first: Option<usize>, difference: Option<&'a Difference>, end: End, next| {
            let dt = if next {
                self.motion.dt_next
            } else {
                self.motion.dt
            };
            Some(Link {
                first: first?,
                difference: difference?,
                end,
                slope: end.sign() / dt,
                next,
            })
        };
        [
            link(layout.a, here, End::A, false),
            link(layout.b, here, End::B, false),
            link(layout.b, next, End::A, true),
            link(layout.c, next, End::B, true),
        ]
    }
}
