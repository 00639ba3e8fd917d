//! A set of places: which triangles of a leaf are selected, counted from its first.

use super::ROOM;

/// Bits of a word.
const BITS: usize = u64::BITS as usize;

/// Words of a set.
pub const WORDS: usize = ROOM / BITS;

/// Places below [`ROOM`], one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Places([u64; WORDS]);

impl Places {
    /// Bit i of word w is place 64w + i.
    #[must_use]
    #[inline]
    pub const fn of(words: [u64; WORDS]) -> Self {
        Self(words)
    }

    /// The first `count` places.
    ///
    /// # Panics
    ///
    /// `count` exceeds [`ROOM`].
    #[must_use]
    pub fn first(count: usize) -> Self {
        assert!(count <= ROOM, "a patch of {count} triangles");
        let word = |w: usize| match count.saturating_sub(w * BITS) {
            0 => 0,
            some => u64::MAX >> (BITS - some.min(BITS)),
        };
        Self(core::array::from_fn(word))
    }

    /// The words, as in [`Places::of`].
    #[must_use]
    #[inline]
    pub const fn words(&self) -> [u64; WORDS] {
        self.0
    }

    /// Whether the set is empty.
    #[must_use]
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.0.iter().fold(0, |any, word| any | word) == 0
    }

    /// Adds a place if it is below [`ROOM`].
    #[inline]
    pub fn insert(&mut self, place: usize) {
        self.insert_from(place / BITS, place % BITS, 1);
    }

    /// Adds places from a word, one bit each, starting at this bit of the word.
    ///
    /// Loops over all words, so they stay in registers; an index would force them into memory.
    #[inline(always)]
    pub fn insert_from(&mut self, word: usize, place: usize, bits: u64) {
        for (number, here) in self.0.iter_mut().enumerate() {
            *here |= if number == word { bits << place } else { 0 };
        }
    }

    /// Whether this is a subset of the other set.
    #[must_use]
    #[inline]
    pub fn is_within(&self, others: &Self) -> bool {
        self.without(others).is_empty()
    }

    /// The difference: places that are not in the other set.
    #[must_use]
    #[inline]
    pub fn without(&self, others: &Self) -> Self {
        Self(core::array::from_fn(|word| self.0[word] & !others.0[word]))
    }

    /// The intersection of both sets.
    #[must_use]
    #[inline]
    pub fn and(&self, other: &Self) -> Self {
        Self(core::array::from_fn(|word| self.0[word] & other.0[word]))
    }
}

#[cfg(test)]
mod tests;
