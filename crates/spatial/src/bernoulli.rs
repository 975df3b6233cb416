//! The scalar function d(u) = (1 − (θ/2) cot(θ/2)) / θ² of u = θ², and its derivatives.
//!
//! It carries all of the inverse Jacobians of exp: Jr⁻¹ = I + ½[ω]× + d [ω]×² on SO(3). Its series has the Bernoulli
//! numbers, d(u) = Σ_{k≥1} |B_2k|/(2k)! u^(k−1), and a pole at θ = 2π.

/// |B_2k| / (2k)! for k = 1..12.
const COEFFICIENTS: [f64; 12] = [
    1.0 / 12.0,
    1.0 / 720.0,
    1.0 / 30_240.0,
    1.0 / 1_209_600.0,
    1.0 / 47_900_160.0,
    691.0 / 1_307_674_368_000.0,
    1.0 / 74_724_249_600.0,
    3_617.0 / 10_670_622_842_880_000.0,
    43_867.0 / 5_109_094_217_170_944_000.0,
    174_611.0 / 802_857_662_698_291_200_000.0,
    77_683.0 / 14_101_100_039_391_805_440_000.0,
    236_364_091.0 / 1_693_824_136_731_743_669_452_800_000.0,
];

/// The series is used below this u: twelve terms leave (1.5/39.5)^12 ≈ 1e-17 of the value.
const SERIES_BELOW: f64 = 1.5;

/// d, d′ and d″ at u = θ², where ′ is the derivative by θ divided by θ (= 2 d/du); valid for θ < 2π.
#[inline]
pub(crate) fn bernoulli(u: f64) -> (f64, f64, f64) {
    if u < SERIES_BELOW {
        let (mut d, mut first, mut second) = (0.0, 0.0, 0.0);
        // Horner for a polynomial and its first two derivatives (the second one halved)
        for c in COEFFICIENTS.iter().rev() {
            second = second * u + first;
            first = first * u + d;
            d = d * u + c;
        }
        return (d, 2.0 * first, 8.0 * second);
    }
    // With g = (θ/2) cot(θ/2): θ g_θ = g − g² − u/4, hence 2 dg/du = (g − g² − u/4)/u.
    let half = 0.5 * u.sqrt();
    let g = half / half.tan();
    let g1 = (g - g * g - 0.25 * u) / u;
    let g2 = ((1.0 - 2.0 * g) * g1 - 0.5 - 2.0 * g1) / u;
    let d = (1.0 - g) / u;
    let d1 = (-g1 - 2.0 * d) / u;
    let d2 = (-g2 - 4.0 * d1) / u;
    (d, d1, d2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn value_at_a_half_turn_is_one_over_pi_squared() {
        let u = std::f64::consts::PI.powi(2);
        assert!((bernoulli(u).0 - 1.0 / u).abs() < 1e-16);
    }

    #[test]
    fn series_and_closed_form_agree_where_they_meet() {
        let (below, above) = (
            bernoulli(SERIES_BELOW * (1.0 - 1e-14)),
            bernoulli(SERIES_BELOW),
        );
        assert!((below.0 / above.0 - 1.0).abs() < 1e-14);
        assert!((below.1 / above.1 - 1.0).abs() < 1e-12);
        assert!((below.2 / above.2 - 1.0).abs() < 1e-9);
    }

    #[test]
    fn derivatives_match_central_differences() {
        for u in [0.0, 0.3, 1.0, 2.0, 5.0, 12.0] {
            let h = 1e-4;
            let (plus, minus, here) = (bernoulli(u + h), bernoulli(u - h), bernoulli(u));
            assert!(((plus.0 - minus.0) / h - here.1).abs() < 1e-8 * here.1);
            assert!(((plus.1 - minus.1) / h - here.2).abs() < 1e-7 * here.2);
        }
    }
}
