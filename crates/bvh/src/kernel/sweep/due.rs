//! Work that is due at a travel, in the order in which it is to be done.

use crate::float_order::{of_ordinal, ordinal};

/// Two numbers and a travel, in one number: the earliest is the least, and of those of the same
/// travel that with the least numbers. So a heap compares without branches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Due(u128);

impl Due {
    /// `travel_m` is not NaN.
    #[inline]
    pub(super) fn new(travel_m: f32, [a, b]: [u32; 2]) -> Self {
        Self(u128::from(ordinal(travel_m)) << 64 | u128::from(a) << 32 | u128::from(b))
    }

    /// The travel (m).
    #[inline]
    pub(super) fn travel_m(self) -> f32 {
        of_ordinal((self.0 >> 64) as u32)
    }

    /// The numbers.
    #[inline]
    pub(super) fn numbers(self) -> [u32; 2] {
        [(self.0 >> 32) as u32, self.0 as u32]
    }
}

#[cfg(test)]
mod tests;
