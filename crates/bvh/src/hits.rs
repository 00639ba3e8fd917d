//! Which triangles of one body were hit: a set of bits, emptied in as long as it took to fill.

use geometry::patch::{Places, ROOM, WORDS};
use std::array::from_fn;
use std::ops::Range;

const BITS: usize = u64::BITS as usize;

/// A set of triangle numbers within a range. Its room is allocated once.
#[derive(Clone, Debug)]
pub(crate) struct Hits {
    words: Vec<u64>,
    /// The words that are not 0: so many of these. What follows is overwritten.
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
        Self { words: vec![0; words], used: vec![0; words + WORDS + 1], count: 0, first: 0 }
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
        self.insert_words(word, [1 << shift]) != [0]
    }

    /// Puts triangles in, counted from number `first` on. Returns those that were not there.
    pub(crate) fn insert_places(&mut self, first: u32, places: &Places) -> Places {
        let (at, shift) = self.at(first as usize);
        // What places begin with and what they go on with share a word. Branches here would depend
        // on where leaves begin, and nothing predicts that.
        let [low, high] = places.words();
        let split = |bits: u64| (bits << shift, bits >> 1 >> (BITS - 1 - shift));
        let ((low, middle), (more, high)) = (split(low), split(high));
        let new = self.insert_words(at, [low, middle | more, high]);
        let join = |low: u64, high: u64| low >> shift | high << 1 << (BITS - 1 - shift);
        Places::of([join(new[0], new[1]), join(new[1], new[2])])
    }

    /// The word of a number, and the bit in it.
    fn at(&self, number: usize) -> (usize, usize) {
        let at = number - self.first;
        (at / BITS, at % BITS)
    }

    /// Puts bits into the words from `at` on; returns the new ones.
    #[inline(always)]
    fn insert_words<const N: usize>(&mut self, at: usize, bits: [u64; N]) -> [u64; N] {
        let words = &mut self.words[at..at + N];
        let used = &mut self.used[self.count..self.count + N];
        let mut count = 0;
        let new = from_fn(|i| {
            // No more than the words before this one, which the compiler cannot know.
            used[count.min(i)] = (at + i) as u32;
            count += usize::from((words[i] == 0) & (bits[i] != 0));
            let new = bits[i] & !words[i];
            words[i] |= bits[i];
            new
        });
        self.count += count;
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
