//! The ledger of logical section transfer: bytes of sections that a job needed and its core did not
//! hold yet.
//!
//! Residency changes when a job is assigned, starts empty, lives across tasks and candidates, and
//! is lost with the worker. It has no capacity limit yet: nothing is evicted.

use protocol::Section;

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
}

/// Which sections each core holds.
#[derive(Clone, Debug, Default)]
pub struct Ledger {
    /// Per core, per body: one bit per node. Grown as nodes are named.
    resident: Vec<Vec<Vec<u64>>>,
    transfer: Transfer,
}

impl Ledger {
    /// An empty ledger.
    #[must_use]
    pub fn new(cores: usize) -> Self {
        Self { resident: vec![Vec::new(); cores], transfer: Transfer::default() }
    }

    /// Whether `core` holds `section`.
    #[must_use]
    pub fn holds(&self, core: usize, section: Section) -> bool {
        let words = self.resident.get(core).and_then(|bodies| bodies.get(section.model as usize));
        let word = words.and_then(|words| words.get(section.node as usize / 64));
        word.is_some_and(|word| word >> (section.node % 64) & 1 == 1)
    }

    /// Books that a job on `core` needs `section`, which weighs `bytes`.
    ///
    /// # Panics
    ///
    /// If there is no such core.
    pub fn need(&mut self, core: usize, section: Section, bytes: u64) {
        self.transfer.unshared_bytes += bytes;
        if self.holds(core, section) {
            self.transfer.found += 1;
            return;
        }
        self.transfer.missed += 1;
        self.transfer.section_bytes += bytes;
        let bodies = &mut self.resident[core];
        let model = section.model as usize;
        if bodies.len() <= model {
            bodies.resize(model + 1, Vec::new());
        }
        let word = section.node as usize / 64;
        if bodies[model].len() <= word {
            bodies[model].resize(word + 1, 0);
        }
        bodies[model][word] |= 1 << (section.node % 64);
    }

    /// Books that `core` lost all it held.
    pub fn lose(&mut self, core: usize) {
        if let Some(bodies) = self.resident.get_mut(core) {
            bodies.clear();
        }
    }

    /// The sums so far.
    #[must_use]
    pub fn transfer(&self) -> Transfer {
        self.transfer
    }
}

#[cfg(test)]
mod tests;
