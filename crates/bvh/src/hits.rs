//! Which triangles of one body were hit: a set of bits, emptied in as long as it took to fill.

use geometry::patch::{Places, ROOM, WORDS};
use std::array::from_fn;
use std::ops::Range;

const BITS: usize = u64::BITS as usize;

/// A set of triangle numbers within a range. Its room is allocated once.
#[derive(Clone, Debug)]
pub(crate) struct Hits {
    words: Vec<u64>,
    /// The words that are not 0: so many of these.
    used: Vec<u32>,
    count: usize,
    /// Number of the first bit: before the range, where places that are put in may begin.
    first: usize,
}

/// Words for a range of so many triangles, for places that begin before it, and for those that end
/// behind it.
fn words(triangles: usize) -> usize {
    (triangles + ROOM - 1).div_ceil(BITS) + WORDS
}

impl Hits {
    /// Room for ranges of `triangles` triangles.
    pub(crate) fn with_room(triangles: usize) -> Self {
        let words = words(triangles);
        Self { words: vec![0; words], used: vec![0; words + 1], count: 0, first: 0 }
    }

    /// Makes room for ranges of `triangles` triangles, and forgets everything.
    pub(crate) fn ensure_room(&mut self, triangles: usize) {
        if words(triangles) > self.words.len() {
            *self = Self::with_room(triangles);
        }
    }

    /// Empties the set and looks at `range` from now on. Takes time with what was in the set.
    ///
    /// # Panics
    ///
    /// If there is no room for the range.
    pub(crate) fn clear(&mut self, range: &Range<u32>) {
        for &word in &self.used[..self.count] {
            self.words[word as usize] = 0;
        }
        self.count = 0;
        self.first = (range.start as usize).saturating_sub(ROOM - 1);
        assert!(words(range.len()) <= self.words.len(), "no room for the triangles of this job");
    }

    /// Whether the triangle is in the set.
    pub(crate) fn has(&self, triangle: u32) -> bool {
        let (word, shift) = self.at(triangle as usize);
        self.words[word] >> shift & 1 == 1
    }

    /// Which triangles are in the set, counted from number `first` on.
    pub(crate) fn places(&self, first: u32) -> Places {
        Places::of(from_fn(|i| {
            let (word, shift) = self.at(first as usize + i * BITS);
            self.words[word] >> shift | self.words[word + 1] << 1 << (BITS - 1 - shift)
        }))
    }

    /// Puts the triangle in; whether it was not there before.
    pub(crate) fn insert(&mut self, triangle: u32) -> bool {
        let (word, shift) = self.at(triangle as usize);
        self.insert_word(word, 1 << shift) != 0
    }

    /// Puts triangles in, counted from number `first` on. Returns those that were not there.
    pub(crate) fn insert_places(&mut self, first: u32, places: &Places) -> Places {
        let words = places.words();
        Places::of(from_fn(|i| {
            let (bits, (word, shift)) = (words[i], self.at(first as usize + i * BITS));
            // Branches here would depend on where leaves begin, and nothing predicts that.
            let new = self.insert_word(word, bits << shift) >> shift;
            let over = self.insert_word(word + 1, bits >> 1 >> (BITS - 1 - shift));
            new | over << 1 << (BITS - 1 - shift)
        }))
    }

    /// The word of a number, and the bit in it.
    fn at(&self, number: usize) -> (usize, usize) {
        let at = number - self.first;
        (at / BITS, at % BITS)
    }

    fn insert_word(&mut self, at: usize, bits: u64) -> u64 {
        let word = &mut self.words[at];
        self.used[self.count] = at as u32;
        self.count += usize::from((*word == 0) & (bits != 0));
        let new = bits & !*word;
        *word |= bits;
        new
    }
}

#[cfg(test)]
impl Hits {
    /// Where the words are, and for how many there is room.
    pub(crate) fn place(&self) -> (*const u64, usize) {
        (self.words.as_ptr(), self.words.capacity())
    }
}

#[cfg(test)]
mod tests;
