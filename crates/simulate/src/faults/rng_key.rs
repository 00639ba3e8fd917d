//! Random numbers as a function of a seed and the name of the place that draws: a counter-based
//! generator (Salmon et al., *Parallel random numbers: as easy as 1, 2, 3*, SC 2011), so that
//! leaving one fault out changes no other.

use geometry::hash::splitmix64;

/// The key of one place.
#[derive(Clone, Copy, Debug)]
pub(super) struct RngKey(u64);

impl RngKey {
    pub(super) fn new(seed: u64) -> Self {
        Self(splitmix64(seed))
    }

    /// The key of a place within this one.
    pub(super) fn at(self, place: u64) -> Self {
        Self(splitmix64(self.0 ^ splitmix64(place)))
    }

    /// 64 random bits.
    pub(super) fn bits(self) -> u64 {
        self.0
    }

    /// A number below `end`, which is not 0: the product takes the top bits.
    pub(super) fn below(self, end: u64) -> u64 {
        ((u128::from(self.0) * u128::from(end)) >> 64) as u64
    }

    /// `true` once in `times`.
    pub(super) fn once_in(self, times: u64) -> bool {
        self.below(times) == 0
    }
}
