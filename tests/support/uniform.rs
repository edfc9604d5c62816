//! A small seeded source of numbers for tests that must give the same answer every time.

/// Linear congruential generator, 64 bits (constants of D. E. Knuth's MMIX).
pub(crate) struct Uniform(pub(crate) u64);

impl Uniform {
    /// The next 64 bits; the low ones of the state, which hardly change, are folded into the high ones.
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 32) ^ self.0.rotate_left(17)
    }

    /// Between `low` and `high`.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.bits() >> 11) as f64 / (1_u64 << 53) as f64)
    }

    /// Between -`half` and `half`.
    pub(crate) fn within(&mut self, half: f64) -> f64 {
        self.between(-half, half)
    }
}
