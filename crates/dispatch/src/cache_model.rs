//! The ledger of logical section transfer: the bytes of sections that a job needed and its core did
//! not hold yet.
//!
//! Residency changes when a job is assigned, starts empty, persists across tasks and candidates,
//! and is lost with the worker. A core's [`Cache`] sets its capacity and what happens beyond it.
//!
//! # Invariants
//!
//! - A core never holds more than its capacity, and the sums equal their recomputation from the
//!   log: `cache_model/tests.rs`.

use protocol::Section;
use std::collections::BTreeMap;

/// The capacity of a core for sections of bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cache {
    /// Everything.
    #[default]
    Unlimited,
    /// This many bytes, evicting the least recently needed sections. A section larger than the
    /// capacity is transferred whenever it is needed.
    Recent(u64),
    /// This many bytes without eviction: the first section that does not fit ends the run
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
    /// Size of the section (bytes).
    pub bytes: u64,
    /// Bytes that the core held.
    pub held: u64,
    /// Capacity of the core (bytes).
    pub budget: u64,
}

/// What was transferred, as defined by the ledger, and what would have been without residency.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Transfer {
    /// Bytes of sections that were not resident when their job was assigned.
    pub section_bytes: u64,
    /// Bytes if every section were sent with every job.
    pub unshared_bytes: u64,
    /// Sections that were already resident.
    pub found: u64,
    /// Sections that were not resident.
    pub missed: u64,
    /// Sections that were evicted.
    pub evicted: u64,
}

/// The sections of one core.
#[derive(Clone, Debug, Default)]
struct Shelf {
    /// Per body: one bit per node, grown on demand. The only data read while a job is placed, once
    /// per core.
    bits: Vec<Vec<u64>>,
    bytes: u64,
    /// Only with eviction: the turn in which each section was last needed, and the reverse map.
    turns: BTreeMap<Section, u64>,
    order: BTreeMap<u64, (Section, u64)>,
}

/// Which sections each core holds.
#[derive(Clone, Debug, Default)]
pub struct CacheModel {
    cache: Cache,
    shelves: Vec<Shelf>,
    /// Counts the entries, which orders the uses.
    turn: u64,
    transfer: Transfer,
    thrash: Option<Thrash>,
}

impl CacheModel {
    /// Creates an empty ledger.
    #[must_use]
    pub fn new(cores: usize, cache: Cache) -> Self {
        Self { cache, shelves: vec![Shelf::default(); cores], ..Self::default() }
    }

    /// Clears the ledger, keeping its buffers.
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

    /// Bytes held by `core`.
    #[must_use]
    pub fn held_bytes(&self, core: usize) -> u64 {
        self.shelves.get(core).map_or(0, |shelf| shelf.bytes)
    }

    /// Records that a job on `core` needs `section` of `bytes` bytes. Returns whether it has to be
    /// transferred.
    ///
    /// # Panics
    ///
    /// There is no such core.
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

    /// Records that `core` lost everything it held.
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

    /// Marks a section as the most recently used.
    fn touch(&mut self, section: Section, bytes: u64, turn: u64) {
        if let Some(before) = self.turns.insert(section, turn) {
            self.order.remove(&before);
        }
        self.order.insert(turn, (section, bytes));
    }

    /// Evicts the least recently used section; `false` if there is none.
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
