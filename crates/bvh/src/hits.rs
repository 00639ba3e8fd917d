//! Which triangles of one body were hit: a set of bits, emptied in as long as it took to fill.

use std::ops::Range;

const BITS: usize = u64::BITS as usize;

/// A set of triangle numbers within a range. Its room is allocated once.
#[derive(Clone, Debug)]
pub(crate) struct Hits {
    words: Vec<u64>,
    /// The words that are not 0.
    used: Vec<u32>,
    /// First triangle of the range.
    first: usize,
}

impl Hits {
    /// Room for ranges of `triangles` triangles.
    pub(crate) fn with_room(triangles: usize) -> Self {
        let words = triangles.div_ceil(BITS);
        Self { words: vec![0; words], used: Vec::with_capacity(words), first: 0 }
    }

    /// Makes room for ranges of `triangles` triangles, and forgets everything.
    pub(crate) fn ensure_room(&mut self, triangles: usize) {
        if triangles.div_ceil(BITS) > self.words.len() {
            *self = Self::with_room(triangles);
        }
    }

    /// Empties the set and looks at `range` from now on. Takes time with what was in the set.
    ///
    /// # Panics
    ///
    /// If there is no room for the range.
    pub(crate) fn clear(&mut self, range: &Range<u32>) {
        for word in self.used.drain(..) {
            self.words[word as usize] = 0;
        }
        self.first = range.start as usize;
        assert!(range.len() <= self.words.len() * BITS, "no room for the triangles of this job");
    }

    /// Whether the triangle is in the set.
    pub(crate) fn has(&self, triangle: u32) -> bool {
        let at = triangle as usize - self.first;
        self.words[at / BITS] >> (at % BITS) & 1 == 1
    }

    /// Puts the triangles in; returns those that were not there before, in order.
    ///
    /// About every second one is new, so they are gathered at the front instead of guessed.
    pub(crate) fn insert<'t>(&mut self, triangles: &'t mut [u32]) -> &'t [u32] {
        let mut count = 0;
        for i in 0..triangles.len() {
            let triangle = triangles[i];
            let at = triangle as usize - self.first;
            let (word, bit) = (&mut self.words[at / BITS], 1 << (at % BITS));
            if *word == 0 {
                self.used.push((at / BITS) as u32);
            }
            triangles[count] = triangle;
            count += usize::from(*word & bit == 0);
            *word |= bit;
        }
        &triangles[..count]
    }
}

#[cfg(test)]
impl Hits {
    /// Where the words are, and for how many there is room.
    pub(crate) fn place(&self) -> (*const u64, usize) {
        (self.words.as_ptr(), self.words.capacity())
    }
}
