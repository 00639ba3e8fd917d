//! Threads that build one tree together. What comes out does not depend on who did what.
//!
//! They are started once. A thread that is started anew for a step may find itself on the core of
//! the one that started it, and wait there for milliseconds, though another core is idle: on a
//! two-core virtual machine that was so for up to 4 threads of 10. Nor do they sleep between steps:
//! there it took up to 4 ms to wake one, as long as a tenth of a tree of 100,000 triangles.

use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Fewer small things are not worth another thread.
const SHARE_MIN: usize = 1024;

/// Threads of one rayon pool, or the caller alone. There is none outside of [`BuildPool::with`]: inside,
/// the pool is the one that rayon's functions mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct BuildPool {
    threads: usize,
}

impl BuildPool {
    /// The caller.
    pub(super) const ALONE: Self = Self { threads: 1 };

    /// Does something with so many threads, in one of them, while the others stay awake: steps of
    /// it that are for all of them then begin without a change of threads. The threads are those of
    /// the pool that the caller is in, or new ones; it is the caller alone if the system does not
    /// grant them, or one is enough.
    pub(super) fn with<R: Send>(threads: usize, work: impl FnOnce(&Self) -> R + Send) -> R {
        if threads < 2 {
            return work(&Self::ALONE);
        }
        if rayon::current_thread_index().is_some() {
            return Self { threads: rayon::current_num_threads() }.awake(work);
        }
        match ThreadPoolBuilder::new().num_threads(threads).build() {
            Ok(pool) => pool.install(|| Self { threads }.awake(work)),
            Err(_) => work(&Self::ALONE),
        }
    }

    /// Does something in this thread of the pool, while the others stay awake.
    fn awake<R: Send>(self, work: impl FnOnce(&Self) -> R + Send) -> R {
        let lead = rayon::current_thread_index();
        let is_done = AtomicBool::new(false);
        rayon::in_place_scope(|scope| {
            // Nobody waits for these but the end of the scope. The lead may come by its own
            // while it waits for a step, and must not stay there.
            scope.spawn_broadcast(|_, context| {
                while Some(context.index()) != lead && !is_done.load(Ordering::Relaxed) {
                    if rayon::yield_now() != Some(rayon::Yield::Executed) {
                        std::thread::yield_now();
                    }
                }
            });
            let _done = Done(&is_done);
            work(&self)
        })
    }

    /// How many there are, at least 1.
    pub(super) fn threads(&self) -> usize {
        self.threads
    }

    /// Whether it is the caller alone.
    pub(super) fn is_alone(&self) -> bool {
        self.threads == 1
    }

    /// How many of `count` things each gets, at most.
    pub(super) fn share(&self, count: usize) -> usize {
        count.div_ceil(self.threads()).max(1)
    }

    /// Does both.
    pub(super) fn both<R: Send, Q: Send>(
        &self,
        one: impl FnOnce() -> R + Send,
        other: impl FnOnce() -> Q + Send,
    ) -> (R, Q) {
        if self.is_alone() { (one(), other()) } else { rayon::join(one, other) }
    }

    /// Does every task, in whichever thread is free; returns what each gave, in order.
    pub(super) fn each<T: Send, R: Send>(
        &self,
        tasks: Vec<T>,
        run: impl Fn(T) -> R + Send + Sync,
    ) -> Vec<R> {
        if self.is_alone() {
            return tasks.into_iter().map(run).collect();
        }
        tasks.into_par_iter().with_max_len(1).map(run).collect()
    }

    /// Puts what `of` makes of each item, in order, into `place`, which is empty. Who writes memory
    /// is the first to touch it.
    pub(super) fn map<T: Sync, R: Send>(
        &self,
        items: &[T],
        of: impl Fn(&T) -> R + Send + Sync,
        place: &mut Vec<R>,
    ) {
        if self.is_alone() {
            return place.extend(items.iter().map(of));
        }
        items.par_iter().with_min_len(SHARE_MIN).map(of).collect_into_vec(place);
    }

    /// So many copies. The first thread writes the first ones.
    pub(super) fn copies<T: Copy + Send + Sync>(&self, value: T, count: usize) -> Vec<T> {
        if self.is_alone() {
            return vec![value; count];
        }
        rayon::iter::repeat_n(value, count).with_min_len(SHARE_MIN).collect()
    }

    /// [`BuildPool::each`] of three. Nothing is allocated.
    pub(super) fn three<T: Send, R: Send>(
        &self,
        tasks: [T; 3],
        run: impl Fn(T) -> R + Send + Sync,
    ) -> [R; 3] {
        if self.is_alone() {
            return tasks.map(run);
        }
        let ([x, y, z], run) = (tasks, &run);
        let (x, (y, z)) = rayon::join(|| run(x), || rayon::join(|| run(y), || run(z)));
        [x, y, z]
    }
}

/// Says that the work is done when it is dropped: also where the work panics, since the scope waits
/// for its threads even then.
struct Done<'a>(&'a AtomicBool);

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests;
