//! What a problem tells the solver: variables, elements, rows, values and derivatives.

/// Rows of one element whose Jacobian is dense over a few columns.
#[derive(Debug, Clone)]
pub struct BlockStructure {
    /// First row of the block within the element.
    pub first_row: usize,
    /// Number of rows.
    pub n_rows: usize,
    /// Columns, as positions in [`ElementStructure::vars`].
    pub cols: Vec<usize>,
}

/// One element: the variables that it touches and its rows.
#[derive(Debug, Clone, Default)]
pub struct ElementStructure {
    /// Global indices of the variables. One may stand at several places: these are then the same unknown.
    pub vars: Vec<usize>,
    /// Lower bound per row; −∞ where there is none; equal to the upper one for an equality.
    pub row_lower: Vec<f64>,
    /// Upper bound per row; +∞ where there is none.
    pub row_upper: Vec<f64>,
    /// Jacobian blocks; every row belongs to exactly one.
    pub blocks: Vec<BlockStructure>,
}

impl ElementStructure {
    /// Number of rows.
    pub fn n_rows(&self) -> usize {
        self.row_lower.len()
    }
}

/// Sizes and sparsity of a problem; constant during a solve.
#[derive(Debug, Clone, Default)]
pub struct Structure {
    /// Number of variables (tangent coordinates).
    pub n_vars: usize,
    /// Lower bounds of the variables; −∞ where there is none.
    pub lower: Vec<f64>,
    /// Upper bounds of the variables; +∞ where there is none; equal to the lower one for a fixed variable.
    pub upper: Vec<f64>,
    /// The elements in the order in which they are eliminated.
    pub elements: Vec<ElementStructure>,
}

/// Bounds that no value meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contradiction {
    /// A row, counted through all elements.
    Row(usize),
    /// A variable.
    Variable(usize),
}

impl Structure {
    /// True of a variable whose bounds are equal.
    pub(crate) fn is_fixed(&self, v: usize) -> bool {
        self.lower
            .get(v)
            .zip(self.upper.get(v))
            .is_some_and(|(l, u)| l == u)
    }

    /// The first row, else the first variable, whose lower bound is not below or at its upper one.
    pub fn contradiction(&self) -> Option<Contradiction> {
        let crossed = |(l, u): (&f64, &f64)| l.is_nan() || u.is_nan() || l > u;
        let elements = self.elements.iter();
        let row = elements
            .flat_map(|e| e.row_lower.iter().zip(&e.row_upper))
            .position(crossed);
        let variable = || self.lower.iter().zip(&self.upper).position(crossed);
        row.map(Contradiction::Row)
            .or_else(|| variable().map(Contradiction::Variable))
    }
}

/// Values and derivatives of one element, buffers owned by the solver.
#[derive(Debug, Clone)]
pub struct ElementData {
    /// f_e.
    pub objective: f64,
    /// c_e, one per row.
    pub values: Vec<f64>,
    /// ∇f_e over the element's variables.
    pub gradient: Vec<f64>,
    /// Per block the Jacobian, column-major `n_rows × cols.len()`.
    pub jacobians: Vec<Vec<f64>>,
    /// Hessian of f_e + yᵀc_e, column-major `n × n` over the element's variables; the lower triangle counts.
    pub hessian: Vec<f64>,
}

impl ElementData {
    /// Buffers for one element, filled with NaN so that an unwritten entry shows.
    pub fn new(structure: &ElementStructure) -> Self {
        let n = structure.vars.len();
        Self {
            gradient: vec![f64::NAN; n],
            jacobians: structure
                .blocks
                .iter()
                .map(|b| vec![f64::NAN; b.n_rows * b.cols.len()])
                .collect(),
            hessian: vec![f64::NAN; n * n],
            ..Self::of_values(structure)
        }
    }

    /// Buffers for objective and row values alone, as [`Problem::evaluate`] needs.
    pub fn of_values(structure: &ElementStructure) -> Self {
        Self {
            objective: f64::NAN,
            values: vec![f64::NAN; structure.n_rows()],
            gradient: vec![],
            jacobians: vec![],
            hessian: vec![],
        }
    }
}

/// A stage-structured problem whose variables may live on a manifold.
///
/// The solver moves a point only by [`Problem::retract`] with tangent steps. Variables with finite bounds must be
/// plain numbers: their coordinate changes by exactly the step.
pub trait Problem {
    /// A point of the search space.
    type Point: Clone;

    /// Sizes, bounds and sparsity.
    fn structure(&self) -> &Structure;

    /// `out = x ⊕ step · dx`.
    fn retract(&self, x: &Self::Point, dx: &[f64], step: f64, out: &mut Self::Point);

    /// Current values of the variables that have bounds (others are ignored).
    fn coordinates(&self, x: &Self::Point, out: &mut [f64]);

    /// Writes `objective` and `values` of every element; for derivatives there may be no room.
    fn evaluate(&mut self, x: &Self::Point, out: &mut [ElementData]);

    /// Writes everything of every element; `multipliers` has one slice of row multipliers per element, in order of
    /// the rows, concatenated.
    fn linearise(&mut self, x: &Self::Point, multipliers: &[f64], out: &mut [ElementData]);

    /// Multiplies what the rows have in the Hessians by `factor`, which is below one: H becomes `factor` · H + (1 − `factor`) ∇²f.
    /// `x` is where `out` was linearised last; all else of it stays.
    fn scale_row_curvature(&mut self, x: &Self::Point, factor: f64, out: &mut [ElementData]) {
        let n_rows = out.iter().map(|data| data.values.len()).sum();
        let mut objective = out.to_vec();
        self.linearise(x, &vec![0.0; n_rows], &mut objective);
        for (data, objective) in out.iter_mut().zip(&objective) {
            for (h, f) in data.hessian.iter_mut().zip(&objective.hessian) {
                *h = f + factor * (*h - f);
            }
        }
    }
}
