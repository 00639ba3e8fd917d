//! The ledger of logical section transfer: bytes of sections that a job needed and its core did not
//! hold yet.
//!
//! Residency changes when a job is assigned, starts empty, lives across tasks and candidates, and
//! is lost with the worker. How much a core may hold, and what happens beyond, is its [`Cache`].
//!
//! # Invariants
//!
//! - A core never holds more than its capacity, and the sums equal their recomputation from the log
//!   of what was booked: `ledger/tests.rs`.

use protocol::Section;
use std::collections::BTreeMap;

/// How much of the bodies a core may hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cache {
    /// Everything.
    #[default]
    Unlimited,
    /// So many bytes; the least recently needed sections make room. A section that is larger than
    /// all of it is transferred whenever it is needed.
    Recent(u64),
    /// So many bytes, and nothing is ever evicted: the first section that does not fit is the end
    /// ([`Thrash`]), as in the paper's system.
    Fixed(u64),
}

/// A section that did not fit a [`Cache::Fixed`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Thrash {
    /// The core.
    pub core: usize,
    /// The section.
    pub section: Section,
    /// What the section weighs (bytes).
    pub bytes: u64,
    /// What the core held (bytes).
    pub held: u64,
    /// What it may hold (bytes).
    pub budget: u64,
}

/// What was transferred, by definition of the ledger, and what would have been without residency.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Transfer {
    /// Bytes of sections that were not resident when their job was assigned.
    pub section_bytes: u64,
    /// Bytes if every section travelled with every job.
    pub unshared_bytes: u64,
    /// Sections that were resident already.
    pub found: u64,
    /// Sections that were not.
    pub missed: u64,
    /// Sections that made room for others.
    pub evicted: u64,
}

/// What one core holds.
#[derive(Clone, Debug, Default)]
struct Shelf {
    /// Per body: one bit per node. Grown as nodes are named. All that is ever asked while a job is
    /// placed, once per core.
    bits: Vec<Vec<u64>>,
    bytes: u64,
    /// Only where something may be evicted: when a section was needed last, and the reverse.
    turns: BTreeMap<Section, u64>,
    order: BTreeMap<u64, (Section, u64)>,
}

/// Which sections each core holds.
#[derive(Clone, Debug, Default)]
pub struct CacheModel {
    cache: Cache,
    shelves: Vec<Shelf>,
    /// Counts what was booked: the order of needs.
    turn: u64,
    transfer: Transfer,
    thrash: Option<Thrash>,
}

impl CacheModel {
    /// An empty ledger.
    #[must_use]
    pub fn new(cores: usize, cache: Cache) -> Self {
        Self { cache, shelves: vec![Shelf::default(); cores], ..Self::default() }
    }

    /// Empties it again, in its own room.
    pub fn begin(&mut self) {
        for shelf in &mut self.shelves {
            shelf.bits.iter_mut().for_each(|words| words.fill(0));
            shelf.bytes = 0;
            shelf.turns.clear();
            shelf.order.clear();
        }
        (self.turn, self.transfer, self.thrash) = (0, Transfer::default(), None);
    }

    /// Whether `core` holds `section`.
    #[must_use]
    pub fn holds(&self, core: usize, section: Section) -> bool {
        self.shelves.get(core).is_some_and(|shelf| shelf.holds(section))
    }

    /// Bytes that `core` holds.
    #[must_use]
    pub fn held_bytes(&self, core: usize) -> u64 {
        self.shelves.get(core).map_or(0, |shelf| shelf.bytes)
    }

    /// Books that a job on `core` needs `section`, which weighs `bytes`. Says whether it has to be
    /// transferred.
    ///
    /// # Panics
    ///
    /// If there is no such core.
    pub fn need(&mut self, core: usize, section: Section, bytes: u64) -> bool {
        self.turn += 1;
        self.transfer.unshared_bytes += bytes;
        let shelf = &mut self.shelves[core];
        let is_limited = matches!(self.cache, Cache::Recent(_));
        if shelf.holds(section) {
            self.transfer.found += 1;
            if is_limited {
                shelf.touch(section, bytes, self.turn);
            }
            return false;
        }
        self.transfer.missed += 1;
        self.transfer.section_bytes += bytes;
        match self.cache {
            Cache::Unlimited => {}
            Cache::Recent(capacity) if bytes > capacity => return true,
            Cache::Recent(capacity) => {
                while shelf.bytes + bytes > capacity && shelf.evict() {
                    self.transfer.evicted += 1;
                }
            }
            Cache::Fixed(budget) if shelf.bytes + bytes > budget => {
                let thrash = Thrash { core, section, bytes, held: shelf.bytes, budget };
                self.thrash.get_or_insert(thrash);
                return true;
            }
            Cache::Fixed(_) => {}
        }
        shelf.bytes += bytes;
        shelf.set(section, true);
        if is_limited {
            shelf.touch(section, bytes, self.turn);
        }
        true
    }

    /// Books that `core` lost all it held.
    pub fn lose(&mut self, core: usize) {
        if let Some(shelf) = self.shelves.get_mut(core) {
            *shelf = Shelf::default();
        }
    }

    /// The sums so far.
    #[must_use]
    pub fn transfer(&self) -> Transfer {
        self.transfer
    }

    /// The first section that did not fit.
    #[must_use]
    pub fn thrash(&self) -> Option<Thrash> {
        self.thrash
    }
}

impl Shelf {
    fn holds(&self, section: Section) -> bool {
        let words = self.bits.get(section.model as usize);
        let word = words.and_then(|words| words.get(section.node as usize / 64));
        word.is_some_and(|word| word >> (section.node % 64) & 1 == 1)
    }

    fn set(&mut self, section: Section, held: bool) {
        let (model, word) = (section.model as usize, section.node as usize / 64);
        if self.bits.len() <= model {
            self.bits.resize(model + 1, Vec::new());
        }
        let words = &mut self.bits[model];
        if words.len() <= word {
            words.resize(word + 1, 0);
        }
        let bit = 1 << (section.node % 64);
        words[word] = if held { words[word] | bit } else { words[word] & !bit };
    }

    /// Makes a section the most recent one.
    fn touch(&mut self, section: Section, bytes: u64, turn: u64) {
        if let Some(before) = self.turns.insert(section, turn) {
            self.order.remove(&before);
        }
        self.order.insert(turn, (section, bytes));
    }

    /// Drops the least recent section; `false` if there is none.
    fn evict(&mut self) -> bool {
        let Some((_, (section, bytes))) = self.order.pop_first() else { return false };
        self.turns.remove(&section);
        self.set(section, false);
        self.bytes -= bytes;
        true
    }
}

#[cfg(test)]
mod tests;
