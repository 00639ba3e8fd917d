//! Order-free hashes of sets of triangle pairs.
//!
//! The hash of a set of pairs is the wrapping sum (`u64::wrapping_add`) of [`pair_term`] over its
//! members, 0 for the empty set. The sum does not depend on the order or the grouping in which
//! terms are added, but each pair must be counted exactly once.

/// The finaliser of SplitMix64, including its increment: a bijection that spreads every bit.
///
/// G. Steele, D. Lea, C. Flood, *Fast Splittable Pseudorandom Number Generators*, OOPSLA 2014, in
/// the form of S. Vigna's `splitmix64.c`: the first output of the generator seeded with `x`.
#[must_use]
pub const fn splitmix64(x: u64) -> u64 {
    let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

/// The term that the pair of A's triangle `a` and B's triangle `b` (source ids) adds to a set's
/// hash.
#[must_use]
pub const fn pair_term(a: u32, b: u32) -> u64 {
    splitmix64((a as u64) << 32 | b as u64)
}

#[cfg(test)]
mod tests;
