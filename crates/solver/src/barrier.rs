//! The barrier terms of one set of bounded quantities (variables or row slacks), and the choice of μ.
//!
//! Legend: s the quantity, l and u its bounds, zl and zu their multipliers.
//! Source: Wächter and Biegler 2006, sections 2.1–2.2; Nocedal, Wächter, Waltz 2009 (LOQO rule, equation 3.6).

/// Multiplier safeguard κ_Σ.
const KAPPA_SIGMA: f64 = 1e10;

/// Quantities with lower and upper bounds; ±∞ where there is none.
#[derive(Debug, Clone, Default)]
pub struct Bounded {
    /// l.
    pub lower: Vec<f64>,
    /// u.
    pub upper: Vec<f64>,
    /// s, strictly between.
    pub value: Vec<f64>,
    /// Multiplier of the lower bound, zero where there is none.
    pub z_lower: Vec<f64>,
    /// Multiplier of the upper bound, zero where there is none.
    pub z_upper: Vec<f64>,
}

/// Moves `x` strictly between its bounds: Wächter and Biegler 2006, section 3.6.
pub fn push_inside(x: f64, l: f64, u: f64, push: f64) -> f64 {
    let range = u - l;
    let gap = |bound: f64| (push * bound.abs().max(1.0)).min(push.max(0.01) * range.min(1e20));
    let mut x = x;
    if l.is_finite() {
        x = x.max(l + gap(l));
    }
    if u.is_finite() {
        x = x.min(u - gap(u));
    }
    if l.is_finite() && u.is_finite() && !(l < x && x < u) {
        0.5 * (l + u)
    } else {
        x
    }
}

impl Bounded {
    /// No values yet; multipliers set by [`Bounded::start`].
    pub fn new(lower: &[f64], upper: &[f64]) -> Self {
        let n = lower.len();
        Self {
            lower: lower.to_vec(),
            upper: upper.to_vec(),
            value: vec![0.0; n],
            z_lower: vec![0.0; n],
            z_upper: vec![0.0; n],
        }
    }

    /// First multipliers for the present values.
    pub fn start(&mut self, mu: f64) {
        for i in 0..self.value.len() {
            let (l, u, s) = (self.lower[i], self.upper[i], self.value[i]);
            self.z_lower[i] = if l.is_finite() {
                (mu / (s - l)).min(1e3)
            } else {
                0.0
            };
            self.z_upper[i] = if u.is_finite() {
                (mu / (u - s)).min(1e3)
            } else {
                0.0
            };
        }
    }

    /// Σ = zl/(s−l) + zu/(u−s), zero for free quantities.
    pub fn sigma(&self, i: usize) -> f64 {
        let mut sum = 0.0;
        if self.lower[i].is_finite() {
            sum += self.z_lower[i] / (self.value[i] - self.lower[i]);
        }
        if self.upper[i].is_finite() {
            sum += self.z_upper[i] / (self.upper[i] - self.value[i]);
        }
        sum
    }

    /// Derivative of the barrier −μ Σ ln: −μ/(s−l) + μ/(u−s).
    pub fn barrier_gradient(&self, i: usize, mu: f64) -> f64 {
        let mut sum = 0.0;
        if self.lower[i].is_finite() {
            sum -= mu / (self.value[i] - self.lower[i]);
        }
        if self.upper[i].is_finite() {
            sum += mu / (self.upper[i] - self.value[i]);
        }
        sum
    }

    /// The barrier's value −μ Σ ln at `s = value + alpha · step`.
    pub fn barrier(&self, mu: f64, step: &[f64], alpha: f64) -> f64 {
        let mut sum = 0.0;
        for i in 0..self.value.len() {
            let s = self.value[i] + alpha * step[i];
            if self.lower[i].is_finite() {
                sum -= (s - self.lower[i]).ln();
            }
            if self.upper[i].is_finite() {
                sum -= (self.upper[i] - s).ln();
            }
        }
        mu * sum
    }

    /// Steps of the two multipliers of entry `i` for the value step `ds`.
    fn multiplier_steps(&self, i: usize, ds: f64, mu: f64) -> (f64, f64) {
        let mut steps = (0.0, 0.0);
        if self.lower[i].is_finite() {
            let gap = self.value[i] - self.lower[i];
            steps.0 = (mu - self.z_lower[i] * ds) / gap - self.z_lower[i];
        }
        if self.upper[i].is_finite() {
            let gap = self.upper[i] - self.value[i];
            steps.1 = (mu + self.z_upper[i] * ds) / gap - self.z_upper[i];
        }
        steps
    }

    /// Largest steps (primal, dual) that keep a fraction 1 − τ of every distance.
    pub fn longest_steps(&self, step: &[f64], mu: f64, tau: f64) -> (f64, f64) {
        let (mut primal, mut dual) = (1.0_f64, 1.0_f64);
        for i in 0..self.value.len() {
            let (l, u) = (self.lower[i], self.upper[i]);
            if step[i] < 0.0 && l.is_finite() {
                primal = primal.min(-tau * (self.value[i] - l) / step[i]);
            }
            if step[i] > 0.0 && u.is_finite() {
                primal = primal.min(tau * (u - self.value[i]) / step[i]);
            }
            if l.is_finite() || u.is_finite() {
                let (a, b) = self.multiplier_steps(i, step[i], mu);
                if a < 0.0 {
                    dual = dual.min(-tau * self.z_lower[i] / a);
                }
                if b < 0.0 {
                    dual = dual.min(-tau * self.z_upper[i] / b);
                }
            }
        }
        (primal, dual)
    }

    /// Takes the multiplier step belonging to `step`, before the values move.
    pub fn step_multipliers(&mut self, step: &[f64], mu: f64, alpha_dual: f64) {
        for i in 0..self.value.len() {
            let (a, b) = self.multiplier_steps(i, step[i], mu);
            self.z_lower[i] += alpha_dual * a;
            self.z_upper[i] += alpha_dual * b;
        }
    }

    /// Keeps multipliers within a factor κ_Σ of μ/gap.
    pub fn safeguard(&mut self, mu: f64) {
        for i in 0..self.value.len() {
            if self.lower[i].is_finite() {
                let z = mu / (self.value[i] - self.lower[i]);
                self.z_lower[i] = self.z_lower[i].clamp(z / KAPPA_SIGMA, z * KAPPA_SIGMA);
            }
            if self.upper[i].is_finite() {
                let z = mu / (self.upper[i] - self.value[i]);
                self.z_upper[i] = self.z_upper[i].clamp(z / KAPPA_SIGMA, z * KAPPA_SIGMA);
            }
        }
    }

    /// Adds sum, count and smallest of the complementarity products.
    pub fn complementarity(&self, total: &mut Complementarity) {
        for i in 0..self.value.len() {
            if self.lower[i].is_finite() {
                total.add(self.z_lower[i] * (self.value[i] - self.lower[i]));
            }
            if self.upper[i].is_finite() {
                total.add(self.z_upper[i] * (self.upper[i] - self.value[i]));
            }
        }
    }
}

/// Sum, count and extremes of complementarity products.
#[derive(Debug, Clone, Copy)]
pub struct Complementarity {
    sum: f64,
    count: usize,
    min: f64,
    /// Largest product.
    pub max: f64,
}

impl Default for Complementarity {
    fn default() -> Self {
        Self {
            sum: 0.0,
            count: 0,
            min: f64::INFINITY,
            max: 0.0,
        }
    }
}

impl Complementarity {
    fn add(&mut self, product: f64) {
        self.sum += product;
        self.count += 1;
        self.min = self.min.min(product);
        self.max = self.max.max(product);
    }

    /// Mean product; 0 without bounds.
    pub fn average(&self) -> f64 {
        if self.count == 0 {
            0.0
        } else {
            self.sum / self.count as f64
        }
    }

    /// μ of the LOQO rule: small when all products are alike and small.
    pub fn loqo(&self) -> f64 {
        let average = self.average();
        if average == 0.0 {
            return 0.0;
        }
        let xi = (self.min / average).clamp(1e-12, 1.0);
        0.1 * (0.05 * (1.0 - xi) / xi).min(2.0).powi(3) * average
    }
}
