//! Vectors of one interval's second derivatives, one entry per increment of a node.

/// Buffers of the last step of the chain rule.
#[derive(Default)]
pub(super) struct Vectors {
    /// Gradients of the Lagrangian by v and v⁺.
    pub gv: Vec<f64>,
    pub gp: Vec<f64>,
    /// Gradients of the costs by v and v⁺.
    pub cv: Vec<f64>,
    pub cp: Vec<f64>,
    /// Diagonal of the Hessian by v and v, v and v⁺, v⁺ and v⁺.
    pub vv: Vec<f64>,
    pub vp: Vec<f64>,
    pub pp: Vec<f64>,
    /// ∂v/∂dt and ∂v⁺/∂dt⁺.
    pub vd: Vec<f64>,
    pub pd: Vec<f64>,
    /// Second derivatives by q, v, v⁺ and dt.
    pub q_dt: Vec<f64>,
    pub v_dt: Vec<f64>,
    pub p_dt: Vec<f64>,
    /// Second derivatives by q, v, v⁺ and dt⁺.
    pub q_next: Vec<f64>,
    pub v_next: Vec<f64>,
    pub p_next: Vec<f64>,
    /// What is chained to a node.
    pub chained: Vec<f64>,
    /// Per row of the equations of motion.
    pub inverse_scale: Vec<f64>,
}

impl Vectors {
    /// For `nv` increments per node.
    pub fn new(nv: usize) -> Self {
        let v = || vec![f64::NAN; nv];
        Self {
            gv: v(),
            gp: v(),
            cv: v(),
            cp: v(),
            vv: v(),
            vp: v(),
            pp: v(),
            vd: v(),
            pd: v(),
            q_dt: v(),
            v_dt: v(),
            p_dt: v(),
            q_next: v(),
            v_next: v(),
            p_next: v(),
            chained: v(),
            inverse_scale: v(),
        }
    }
}
