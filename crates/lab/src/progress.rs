//! Progress of long work: counted here, reported to the caller.

use std::sync::atomic::{AtomicU64, Ordering};

/// Called with the work done and the total, from any thread.
pub type SyncProgress<'p> = &'p (dyn Fn(u64, u64) + Sync);

/// Counts the work done.
pub(crate) struct Progress<'p> {
    total: u64,
    done: AtomicU64,
    told: SyncProgress<'p>,
}

impl<'p> Progress<'p> {
    /// Starts at 0 of `total`.
    pub(crate) fn new(total: u64, told: SyncProgress<'p>) -> Self {
        Self { total, done: AtomicU64::new(0), told }
    }

    /// Adds `more` to the work done.
    pub(crate) fn add(&self, more: u64) {
        let done = self.done.fetch_add(more, Ordering::Relaxed) + more;
        (self.told)(done, self.total);
    }
}
