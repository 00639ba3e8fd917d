//! Which triangles of one body were hit: a bit set that is cleared in time proportional to its
//! content.

use geometry::patch::{Places, ROOM, WORDS};
use std::array::from_fn;
use std::ops::Range;

const BITS: usize = u64::BITS as usize;

/// A set of triangle numbers within a range. Its buffer is allocated once.
#[derive(Clone, Debug)]
pub(crate) struct Hits {
    words: Vec<u64>,
    /// Indices of the words that are not 0; entries past the count are overwritten.
    used: Vec<u32>,
    count: usize,
    /// Number of the first bit: before the range, where inserted places may begin.
    first: usize,
}

/// Words for a range of `triangles` triangles, for places that begin before it, and for those that
/// end after it.
fn words(triangles: usize) -> usize {
    (triangles + ROOM - 1).div_ceil(BITS) + WORDS
}

impl Hits {
    /// Creates a set with capacity for ranges of `triangles` triangles.
    pub(crate) fn with_room(triangles: usize) -> Self {
        let words = words(triangles);
        Self { words: vec![0; words], used: vec![0; words + WORDS + 1], count: 0, first: 0 }
    }

    /// Ensures capacity for ranges of `triangles` triangles, and clears the set.
    pub(crate) fn ensure_room(&mut self, triangles: usize) {
        if words(triangles) > self.words.len() {
            *self = Self::with_room(triangles);
        }
    }

    /// Clears the set and moves it to `range`. Takes time proportional to the number of used words.
    ///
    /// # Panics
    ///
    /// The range exceeds the capacity.
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

    /// Which triangles are in the set, counted from number `first`.
    pub(crate) fn places(&self, first: u32) -> Places {
        Places::of(from_fn(|i| {
            let (word, shift) = self.at(first as usize + i * BITS);
            self.words[word] >> shift | self.words[word + 1] << 1 << (BITS - 1 - shift)
        }))
    }

    /// Inserts the triangle; returns whether it was absent.
    pub(crate) fn insert(&mut self, triangle: u32) -> bool {
        let (word, shift) = self.at(triangle as usize);
        self.insert_words(word, [1 << shift]) != [0]
    }

    /// Inserts triangles, counted from number `first`. Returns those that were absent.
    pub(crate) fn insert_places(&mut self, first: u32, places: &Places) -> Places {
        let (at, shift) = self.at(first as usize);
        // The end of one word and the start of the next share a place word. Branches here would
        // depend on where leaves begin, which is unpredictable.
        let [low, high] = places.words();
        let split = |bits: u64| (bits << shift, bits >> 1 >> (BITS - 1 - shift));
        let ((low, middle), (more, high)) = (split(low), split(high));
        let new = self.insert_words(at, [low, middle | more, high]);
        let join = |low: u64, high: u64| low >> shift | high << 1 << (BITS - 1 - shift);
        Places::of([join(new[0], new[1]), join(new[1], new[2])])
    }

    /// The word index of a number, and its bit.
    fn at(&self, number: usize) -> (usize, usize) {
        let at = number - self.first;
        (at / BITS, at % BITS)
    }

    /// Sets bits in the words from `at` on; returns the new ones.
    #[inline(always)]
    fn insert_words<const N: usize>(&mut self, at: usize, bits: [u64; N]) -> [u64; N] {
        let words = &mut self.words[at..at + N];
        let used = &mut self.used[self.count..self.count + N];
        let mut count = 0;
        let new = from_fn(|i| {
            // Never more than the words before this one, which the compiler cannot know.
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
    /// The address of the words, and the capacity.
    pub(crate) fn place(&self) -> (*const u64, usize) {
        (self.words.as_ptr(), self.words.capacity())
    }
}

#[cfg(test)]
mod tests;
