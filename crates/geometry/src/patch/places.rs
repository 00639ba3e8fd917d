//! A set of places: which triangles of a leaf are meant, counted from its first.

use super::ROOM;

/// Bits of a word.
const BITS: usize = u64::BITS as usize;

/// Words of a set.
pub const WORDS: usize = ROOM / BITS;

/// Places below [`ROOM`], a bit each.
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
    /// There are not so many.
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

    /// Whether there is none.
    #[must_use]
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.0.iter().fold(0, |any, word| any | word) == 0
    }

    /// Adds a place, if it is one.
    #[inline]
    pub fn insert(&mut self, place: usize) {
        self.insert_from(place / BITS, place % BITS, 1);
    }

    /// Adds places of a word, a bit each, from this one of the word on.
    ///
    /// All words are looked at: so they stay in registers, where a number would have them stored.
    #[inline(always)]
    pub fn insert_from(&mut self, word: usize, place: usize, bits: u64) {
        for (number, here) in self.0.iter_mut().enumerate() {
            *here |= if number == word { bits << place } else { 0 };
        }
    }

    /// Whether all of them are among the others.
    #[must_use]
    #[inline]
    pub fn is_within(&self, others: &Self) -> bool {
        self.without(others).is_empty()
    }

    /// Those that are not among the others.
    #[must_use]
    #[inline]
    pub fn without(&self, others: &Self) -> Self {
        Self(core::array::from_fn(|word| self.0[word] & !others.0[word]))
    }

    /// Those that are in both.
    #[must_use]
    #[inline]
    pub fn and(&self, other: &Self) -> Self {
        Self(core::array::from_fn(|word| self.0[word] & other.0[word]))
    }
}

#[cfg(test)]
mod tests;
