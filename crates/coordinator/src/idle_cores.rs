//! Work of the coordinator's own, shared with the cores of workers that wait for the next jobs.

use runtime::affinity;
use smallvec::SmallVec;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Stack of a helper (bytes): all of it is resident where memory is locked.
pub const HELPER_STACK_BYTES: usize = 256 << 10;

/// Cores whose workers wait: one thread each may help while none of them is given work.
///
/// Helpers may run on all of these, and where the caller may: who finds a core taken by something
/// else goes to another one, so nobody waits for a core.
#[derive(Clone, Debug, Default)]
pub(crate) struct IdleCores {
    helpers: usize,
    cores: SmallVec<[usize; 8]>,
}

impl IdleCores {
    /// `None`: a worker that the system puts wherever it likes.
    pub(crate) fn of(workers: &[Option<usize>]) -> Self {
        Self { helpers: workers.len(), cores: workers.iter().flatten().copied().collect() }
    }

    /// How many threads share the work: the caller's, and one for each of these cores.
    pub(crate) fn threads(&self) -> usize {
        self.helpers + 1
    }

    /// What `of` gives for each of the numbers below `count`, in their order. Every thread has
    /// scratch of its own; which one does what changes nothing.
    ///
    /// Where a thread cannot be started, the others do its part.
    pub(crate) fn map<S: Default + Send, T: Send>(
        &self,
        scratch: &mut S,
        count: usize,
        of: impl Fn(&mut S, usize) -> T + Sync,
    ) -> Vec<T> {
        let most = self.helpers.min(count.saturating_sub(1));
        if most == 0 {
            return (0..count).map(|number| of(scratch, number)).collect();
        }
        let next = AtomicUsize::new(0);
        let (next, of) = (&next, &of);
        let work = move |scratch: &mut S| {
            let mut done = Vec::with_capacity(count);
            // Each number goes to one thread, whatever the order: nothing else is shared.
            let numbers = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
            done.extend(numbers.take_while(|k| *k < count).map(|k| (k, of(scratch, k))));
            done
        };
        let mut all = thread::scope(|scope| {
            let help = || {
                // Where none of them is allowed, it runs where the caller may.
                let _elsewhere = affinity::widen_self(&self.cores);
                work(&mut S::default())
            };
            let start = |_| {
                let thread = thread::Builder::new().name("trolley-helper".to_owned());
                thread.stack_size(HELPER_STACK_BYTES).spawn_scoped(scope, help).ok()
            };
            let helpers: SmallVec<[_; 8]> = (0..most).filter_map(start).collect();
            let mut all = work(scratch);
            for helper in helpers {
                match helper.join() {
                    Ok(done) => all.extend(done),
                    Err(panicked) => std::panic::resume_unwind(panicked),
                }
            }
            all
        });
        all.sort_unstable_by_key(|(k, _)| *k);
        all.into_iter().map(|(_, found)| found).collect()
    }
}

#[cfg(test)]
mod tests;
