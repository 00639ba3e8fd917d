//! What chance decides, as a function of the seed and the name of the place.

/// The seed of one world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Draw(u64);

/// splitmix64's output function (Steele, Lea and Flood, OOPSLA 2014).
fn mix(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

impl Draw {
    pub(super) fn new(seed: u64) -> Self {
        Self(mix(seed))
    }

    /// The draws of a place within this one.
    pub(super) fn at(self, place: u64) -> Self {
        Self(mix(self.0 ^ mix(place)))
    }

    /// All bits.
    pub(super) fn bits(self) -> u64 {
        self.0
    }

    /// Below `end`, which is not 0: the product takes the top bits.
    pub(super) fn below(self, end: u64) -> u64 {
        ((u128::from(self.0) * u128::from(end)) >> 64) as u64
    }

    /// Once in so many.
    pub(super) fn once_in(self, times: u64) -> bool {
        self.below(times) == 0
    }
}
