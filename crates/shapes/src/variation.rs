//! Small differences between bodies of one shape, from a seed.

/// A stream of numbers in [-1, 1], all zero for seed 0.
///
/// SplitMix64 (G. Steele, D. Lea, C. Flood, Fast splittable pseudorandom number generators, 2014).
#[derive(Clone, Debug)]
pub(super) struct Variation {
    state: u64,
    nominal: bool,
}

impl Variation {
    /// The stream of a seed.
    pub(super) fn new(seed: u64) -> Self {
        Self { state: seed, nominal: seed == 0 }
    }

    /// The next number, times `amount`.
    pub(super) fn next(&mut self, amount: f64) -> f64 {
        if self.nominal {
            return 0.0;
        }
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        // The upper 53 bits as a fraction of 2^52, minus one: exact.
        amount * ((z >> 11) as f64 / 4_503_599_627_370_496.0 - 1.0)
    }
}
