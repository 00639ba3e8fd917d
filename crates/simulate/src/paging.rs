//! Virtual memory: what a core holds beyond its memory lies on a slower medium.
//!
//! A core keeps every section that it was sent. The most recently needed ones are in memory; one
//! that is needed and is not there comes in, and what arrives when memory is full pushes out as
//! much, which is written once. A section larger than the memory never stays in it.

use dispatch::{Cache, CacheModel};
use protocol::Section;

/// The memory of a core, and what a byte beyond it costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paging {
    /// Bytes of sections that are in memory at most.
    pub memory_bytes: u64,
    /// Time per byte that comes in or is pushed out (ns).
    pub byte_ns: f64,
}

/// Which of the sections of every core are in memory.
#[derive(Debug)]
pub(crate) struct Pager {
    paging: Paging,
    present: CacheModel,
    moved_bytes: u64,
}

impl Pager {
    pub(crate) fn new(cores: usize, paging: Paging) -> Self {
        let present = CacheModel::new(cores, Cache::Recent(paging.memory_bytes));
        Self { paging, present, moved_bytes: 0 }
    }

    /// A job on `core` needs these sections, some of which have just been sent: `fresh`. Returns
    /// how long the core waits (ns).
    pub(crate) fn need(
        &mut self,
        core: usize,
        sections: [(Section, u64); 2],
        fresh: &[Section],
    ) -> f64 {
        let mut moved = 0;
        for (section, bytes) in sections {
            let before = self.present.held_bytes(core);
            if !self.present.need(core, section, bytes) {
                continue;
            }
            let has_arrived = fresh.contains(&section);
            // Pages that leave to make room for others that return were written when first pushed
            // out.
            let pushed_out = before + bytes - self.present.held_bytes(core);
            moved += if has_arrived { pushed_out } else { bytes };
        }
        self.moved_bytes += moved;
        moved as f64 * self.paging.byte_ns
    }

    pub(crate) fn moved_bytes(&self) -> u64 {
        self.moved_bytes
    }

    pub(crate) fn moved_ns(&self) -> f64 {
        self.moved_bytes as f64 * self.paging.byte_ns
    }
}

#[cfg(test)]
mod tests;
