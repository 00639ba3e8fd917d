//! The random number generator of this workspace: seeded, small, the same on every machine.
//!
//! SplitMix64 (G. Steele, D. Lea, C. Flood, *Fast Splittable Pseudorandom Number Generators*,
//! OOPSLA 2014). For tests, campaigns and random requests; nothing here is secret.

use crate::hash::splitmix64;

/// A stream of random numbers. Equal seeds give equal streams.
///
/// ```
/// use trolley_geometry::rng::Rng;
///
/// let (mut one, mut other) = (Rng::new(7), Rng::new(7));
/// assert_eq!(one.below(100), other.below(100));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rng {
    state: u64,
}

impl Rng {
    /// Creates the stream of a seed.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self { state: splitmix64(seed) }
    }

    /// Returns the next 64 bits.
    pub const fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        splitmix64(self.state)
    }

    /// Returns a number below `end`, which must be above 0. The product takes the top bits: no
    /// number is more likely than another by more than `end` / 2⁶⁴.
    pub fn below(&mut self, end: u64) -> u64 {
        ((u128::from(self.bits()) * u128::from(end)) >> 64) as u64
    }

    /// Returns a number in `[from, to)`.
    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * (self.below(1 << 53) as f64 / (1_u64 << 53) as f64)
    }
}

#[cfg(test)]
mod tests {
    //! Results stay in range, and every value of a small range occurs.
    use super::Rng;

    #[test]
    fn numbers_stay_in_their_range_and_fill_it() {
        let mut rng = Rng::new(3);
        let mut seen = [0_u32; 7];
        for _ in 0..7000 {
            seen[rng.below(7) as usize] += 1;
            assert!((-2.0..5.0).contains(&rng.between(-2.0, 5.0)));
        }
        assert!(seen.iter().all(|count| (800..1200).contains(count)), "{seen:?}");
    }

    #[test]
    fn seeds_tell_streams_apart() {
        let stream = |seed| {
            let mut rng = Rng::new(seed);
            [rng.bits(), rng.bits(), rng.bits()]
        };
        assert_ne!(stream(0), stream(1));
        assert_eq!(stream(1), stream(1));
    }
}
