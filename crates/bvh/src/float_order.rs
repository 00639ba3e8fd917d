//! Whole numbers in the order of floats: they are sorted and compared without branches.

/// The sign of a float.
const SIGN: u32 = 1 << 31;

/// A number that orders as [`f32::total_cmp`] does: IEEE 754 sorts as sign and magnitude.
#[inline]
pub(crate) fn ordinal(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits & SIGN == 0 { bits | SIGN } else { !bits }
}

/// The float of an [`ordinal`].
#[inline]
pub(crate) fn of_ordinal(ordinal: u32) -> f32 {
    f32::from_bits(if ordinal & SIGN == 0 { !ordinal } else { ordinal & !SIGN })
}
