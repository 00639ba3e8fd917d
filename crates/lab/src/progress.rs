//! How far long work is: counted here, told to whoever asked for the work.

use std::sync::atomic::{AtomicU64, Ordering};

/// Told how much of how much is done, from any thread.
pub type SyncProgress<'p> = &'p (dyn Fn(u64, u64) + Sync);

/// Counts what is done.
pub(crate) struct Progress<'p> {
    total: u64,
    done: AtomicU64,
    told: SyncProgress<'p>,
}

impl<'p> Progress<'p> {
    /// Nothing done yet of `total` things.
    pub(crate) fn new(total: u64, told: SyncProgress<'p>) -> Self {
        Self { total, done: AtomicU64::new(0), told }
    }

    /// `more` things are done.
    pub(crate) fn add(&self, more: u64) {
        let done = self.done.fetch_add(more, Ordering::Relaxed) + more;
        (self.told)(done, self.total);
    }
}
