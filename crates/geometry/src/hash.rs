//! Order-free hashes of sets of triangle pairs.
//!
//! The hash of a set of pairs is the wrapping sum (`u64::wrapping_add`) of [`pair_term`] over its
//! members, 0 for the empty set. A sum does not know in which order, or in which parts, its terms
//! were found; but each pair must be counted once.

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

/// What the pair of A's triangle `a` and B's triangle `b` (source ids) adds to the hash of a set.
#[must_use]
pub const fn pair_term(a: u32, b: u32) -> u64 {
    splitmix64((a as u64) << 32 | b as u64)
}

#[cfg(test)]
mod tests;
