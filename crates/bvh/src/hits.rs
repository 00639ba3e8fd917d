//! Which triangles of one body were hit: a set of bits, emptied in as long as it took to fill.

use std::ops::Range;

const BITS: usize = u64::BITS as usize;

/// A set of triangle numbers within a range. Its room is allocated once.
#[derive(Clone, Debug)]
pub(crate) struct Hits {
    words: Vec<u64>,
    /// The words that are not 0: so many of these.
    used: Vec<u32>,
    count: usize,
    /// Number of the first bit: 63 before the range, where a word that is put in may begin.
    first: usize,
}

/// Words for a range of so many triangles, and one behind them.
fn words(triangles: usize) -> usize {
    (triangles + BITS - 1).div_ceil(BITS) + 1
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
        self.first = (range.start as usize).saturating_sub(BITS - 1);
        assert!(words(range.len()) <= self.words.len(), "no room for the triangles of this job");
    }

    /// Whether the triangle is in the set.
    pub(crate) fn has(&self, triangle: u32) -> bool {
        let at = triangle as usize - self.first;
        self.words[at / BITS] >> (at % BITS) & 1 == 1
    }

    /// Which of 64 triangles are in the set: bit i for number `first` + i.
    pub(crate) fn bits(&self, first: u32) -> u64 {
        let at = first as usize - self.first;
        let (word, shift) = (at / BITS, at % BITS);
        self.words[word] >> shift | self.words[word + 1] << 1 << (BITS - 1 - shift)
    }

    /// Puts the triangle in; whether it was not there before.
    pub(crate) fn insert(&mut self, triangle: u32) -> bool {
        self.insert_bits(triangle, 1) != 0
    }

    /// Puts triangles in: bit i is for number `first` + i. Returns those that were not there.
    pub(crate) fn insert_bits(&mut self, first: u32, bits: u64) -> u64 {
        let at = first as usize - self.first;
        let (word, shift) = (at / BITS, at % BITS);
        // Branches here would depend on where leaves begin, and nothing predicts that.
        let new = self.insert_word(word, bits << shift) >> shift;
        new | self.insert_word(word + 1, bits >> 1 >> (BITS - 1 - shift)) << 1 << (BITS - 1 - shift)
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
