//! Work of the coordinator's own, shared with the cores of workers that wait for the next jobs.

use runtime::{affinity, clock};
use smallvec::SmallVec;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

/// Stack of a helper (bytes): all of it is resident where memory is locked.
pub const HELPER_STACK_BYTES: usize = 256 << 10;

/// Cores whose workers wait: one thread each may help while they are given no work.
///
/// Helpers may run on all of these, and where the caller may: who finds a core taken by something
/// else goes to another one, so nobody waits for a core.
#[derive(Clone, Debug, Default)]
pub(crate) struct IdleCores {
    helpers: usize,
    cores: SmallVec<[usize; 8]>,
    /// Whether the caller's own core is one of them.
    is_shared: bool,
    /// If there are no such cores: what they would have spared.
    virtual_ones: Option<VirtualHelpers>,
}

/// Helpers on virtual cores.
#[derive(Clone, Debug)]
struct VirtualHelpers {
    /// From the start of one to its first work (ns).
    thread_ns: u64,
    helped: Arc<Mutex<VirtualHelp>>,
}

/// What helpers on virtual cores have done.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct VirtualHelp {
    /// What the caller was spared (ns).
    pub(crate) spared_ns: u64,
    /// What each of them has done (ns).
    pub(crate) done_ns: SmallVec<[u64; 8]>,
}

impl VirtualHelp {
    fn add(&mut self, other: &Self) {
        self.spared_ns += other.spared_ns;
        self.done_ns.resize(self.done_ns.len().max(other.done_ns.len()), 0);
        self.done_ns.iter_mut().zip(&other.done_ns).for_each(|(sum, done)| *sum += done);
    }
}

impl VirtualHelpers {
    /// Does all of it here, unless a piece is not made, and adds what so many threads would have
    /// done of it.
    fn map<T>(
        &self,
        threads: usize,
        count: usize,
        mut make: impl FnMut(usize) -> Option<T>,
    ) -> Option<Vec<T>> {
        let mut took_ns = Vec::with_capacity(count);
        let timed = |number| {
            let begun_ns = clock::now_ns();
            let made = make(number);
            took_ns.push(clock::now_ns() - begun_ns);
            made
        };
        let made = (0..count).map(timed).collect();
        let help = self.help(threads, &took_ns);
        self.helped.lock().unwrap_or_else(PoisonError::into_inner).add(&help);
        made
    }

    /// What helpers do where whoever is free first takes the next of these pieces.
    fn help(&self, threads: usize, took_ns: &[u64]) -> VirtualHelp {
        // When each is free: the caller begins at once, and waits for all helpers.
        let mut free_ns = vec![self.thread_ns; threads];
        free_ns[0] = 0;
        for took_ns in took_ns {
            if let Some(first) = free_ns.iter_mut().min() {
                *first = first.saturating_add(*took_ns);
            }
        }
        let shared_ns = free_ns.iter().copied().max().unwrap_or(0);
        VirtualHelp {
            spared_ns: took_ns.iter().sum::<u64>().saturating_sub(shared_ns),
            done_ns: free_ns[1..].iter().map(|free_ns| free_ns - self.thread_ns).collect(),
        }
    }
}

impl IdleCores {
    /// The cores of these workers, and so many helpers at most. `None`: a worker that the system
    /// puts wherever it likes. `is_shared`: the caller has no core of its own.
    pub(crate) fn of(workers: &[Option<usize>], most: usize, is_shared: bool) -> Self {
        let cores = workers.iter().flatten().copied().collect();
        Self { helpers: workers.len().min(most), cores, is_shared, virtual_ones: None }
    }

    /// The cores of so many workers that there are not, and the caller's, unless it shares one of
    /// theirs. What is done on them is added to `helped`.
    pub(crate) fn virtual_ones(
        (workers, is_shared): (usize, bool),
        thread_ns: u64,
        helped: Arc<Mutex<VirtualHelp>>,
    ) -> Self {
        let virtual_ones = Some(VirtualHelpers { thread_ns, helped });
        let helpers = workers.saturating_sub(usize::from(is_shared));
        Self { helpers, cores: SmallVec::new(), is_shared, virtual_ones }
    }

    /// Whether the caller has no core of its own: while it works, a worker does not.
    pub(crate) fn is_shared(&self) -> bool {
        self.is_shared
    }

    /// All but so many of these, whose workers are at work.
    pub(crate) fn without(&self, busy: usize) -> Self {
        Self { helpers: self.helpers.saturating_sub(busy), ..self.clone() }
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
        self.map_while(scratch, count, &mut || true, of).unwrap_or_default()
    }

    /// [`map`](Self::map) as long as `goes_on`; `None` if it did not. The caller's thread asks
    /// that, between two numbers: in the end once for each of them.
    pub(crate) fn map_while<S: Default + Send, T: Send>(
        &self,
        scratch: &mut S,
        count: usize,
        goes_on: &mut dyn FnMut() -> bool,
        of: impl Fn(&mut S, usize) -> T + Sync,
    ) -> Option<Vec<T>> {
        let most = self.helpers.min(count.saturating_sub(1));
        if let Some(helpers) = self.virtual_ones.as_ref().filter(|_| most > 0) {
            return helpers.map(most + 1, count, |k| goes_on().then(|| of(scratch, k)));
        }
        if most == 0 {
            return (0..count).map(|k| goes_on().then(|| of(scratch, k))).collect();
        }
        let (next, is_over) = (AtomicUsize::new(0), AtomicBool::new(false));
        let (next, is_over, of) = (&next, &is_over, &of);
        // Each number goes to one thread, whatever the order: nothing else is shared.
        let take = move || {
            let number = next.fetch_add(1, Ordering::Relaxed);
            (number < count && !is_over.load(Ordering::Relaxed)).then_some(number)
        };
        let help = || {
            // Where none of them is allowed, it runs where the caller may.
            let _elsewhere = affinity::widen_self(&self.cores);
            let mut scratch = S::default();
            let numbers = std::iter::from_fn(take);
            numbers.map(|number| (number, of(&mut scratch, number))).collect::<Vec<_>>()
        };
        let mut asked = 0;
        let mut all = thread::scope(|scope| {
            let start = |_| {
                let thread = thread::Builder::new().name("trolley-helper".to_owned());
                thread.stack_size(HELPER_STACK_BYTES).spawn_scoped(scope, help).ok()
            };
            let helpers: SmallVec<[_; 8]> = (0..most).filter_map(start).collect();
            let mut all = Vec::with_capacity(count);
            for number in std::iter::from_fn(take) {
                asked += 1;
                if !goes_on() {
                    is_over.store(true, Ordering::Relaxed);
                    break;
                }
                all.push((number, of(scratch, number)));
            }
            for helper in helpers {
                match helper.join() {
                    Ok(done) => all.extend(done),
                    Err(panicked) => std::panic::resume_unwind(panicked),
                }
            }
            all
        });
        if is_over.load(Ordering::Relaxed) || (asked..count).any(|_| !goes_on()) {
            return None;
        }
        all.sort_unstable_by_key(|(number, _)| *number);
        Some(all.into_iter().map(|(_, found)| found).collect())
    }
}

#[cfg(test)]
mod tests;
