//! A small deterministic generator for tests, random restarts and benchmarks.
//!
//! Source: Steele, Lea, Flood, *Fast Splittable Pseudorandom Number Generators* (2014), the mixer of SplitMix64.

/// Stream of pseudo-random numbers; the same seed gives the same stream on every machine.
#[derive(Debug, Clone)]
pub struct Random {
    state: u64,
}

impl Random {
    /// Stream number `seed`.
    pub fn new(seed: u64) -> Self {
        // Mixed once, so that neighbouring seeds do not give shifted copies of one stream.
        let mut raw = Self { state: seed };
        Self {
            state: raw.next_u64() ^ 0x5DEE_CE66_D1CE_4E5B,
        }
    }

    /// Next 64 random bits.
    pub fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in [`lower`, `upper`).
    pub fn uniform(&mut self, lower: f64, upper: f64) -> f64 {
        let unit = (self.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        lower + (upper - lower) * unit
    }

    /// Uniform index below `count`; zero if `count` is zero.
    pub fn index(&mut self, count: usize) -> usize {
        if count == 0 {
            0
        } else {
            (self.next_u64() % count as u64) as usize
        }
    }

    /// Unit quaternion `[x, y, z, w]`, uniform on the sphere.
    pub fn unit_quaternion(&mut self) -> [f64; 4] {
        loop {
            let quat = [0; 4].map(|_| self.uniform(-1.0, 1.0));
            let norm_squared: f64 = quat.iter().map(|x| x * x).sum();
            if (0.01..=1.0).contains(&norm_squared) {
                return quat.map(|x| x / norm_squared.sqrt());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_repeat_with_the_seed_and_differ_between_seeds() {
        let draw = |seed| Random::new(seed).next_u64();
        assert_eq!(draw(3), draw(3));
        assert_ne!(draw(3), draw(4));
    }

    #[test]
    fn uniform_numbers_fill_their_interval() {
        let mut random = Random::new(1);
        let draws: Vec<f64> = (0..10_000).map(|_| random.uniform(-2.0, 4.0)).collect();
        let mean = draws.iter().sum::<f64>() / 1e4;
        assert!(draws.iter().all(|x| (-2.0..4.0).contains(x)));
        assert!((mean - 1.0).abs() < 0.1, "mean {mean}");
    }
}
