//! Threads that build one tree together. The result does not depend on which thread did what.
//!
//! They are started once. A thread started for a single step may be placed on the core of the
//! thread that started it and wait there for milliseconds, although another core is idle: on a
//! two-core virtual machine this happened to up to 4 threads of 10. Nor do they sleep between
//! steps: there, waking one took up to 4 ms, as long as a tenth of a tree of 100,000 triangles.

use super::grow::worth_starting;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Fewer small items are not worth another thread.
const SHARE_MIN: usize = 1024;

/// Runs `work` in one of as many threads as are worth starting for `count` triangles, of at most
/// `threads`: what it makes of a body, its outlines and its tree, is made by all of them. Without
/// threads where one is enough, or the system does not grant them; in the caller's pool if it is in
/// one.
pub fn in_threads<R: Send>(threads: usize, count: usize, work: impl FnOnce() -> R + Send) -> R {
    in_pool(worth_starting(threads, count), work)
}

/// Runs `work` in one of so many threads: those of the caller's current pool, or new ones; without
/// any if one is enough, or the system does not grant them.
fn in_pool<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    if threads < 2 || rayon::current_thread_index().is_some() {
        return work();
    }
    let Ok(pool) = ThreadPoolBuilder::new().num_threads(threads).build() else { return work() };
    pool.install(work)
}

/// Threads of one rayon pool, or only the caller. It exists only inside [`BuildPool::with`], where
/// it is the current pool of rayon's functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct BuildPool {
    threads: usize,
}

impl BuildPool {
    /// The caller alone.
    pub(super) const ALONE: Self = Self { threads: 1 };

    /// Runs `work` as [`in_pool`] does while the other threads stay awake, so that parallel steps
    /// start without a thread switch.
    pub(super) fn with<R: Send>(threads: usize, work: impl FnOnce(&Self) -> R + Send) -> R {
        if threads < 2 {
            return work(&Self::ALONE);
        }
        in_pool(threads, || match rayon::current_thread_index() {
            Some(_) => Self { threads: rayon::current_num_threads() }.awake(work),
            None => work(&Self::ALONE),
        })
    }

    /// Runs `work` in this thread of the pool while the others stay awake.
    fn awake<R: Send>(self, work: impl FnOnce(&Self) -> R + Send) -> R {
        let lead = rayon::current_thread_index();
        let is_done = AtomicBool::new(false);
        rayon::in_place_scope(|scope| {
            // Only the end of the scope waits for these. The lead may pick up its own while it
            // waits for a step, and must not stay there.
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

    /// Number of threads, at least 1.
    pub(super) fn threads(&self) -> usize {
        self.threads
    }

    /// Whether only the caller works.
    pub(super) fn is_alone(&self) -> bool {
        self.threads == 1
    }

    /// The maximum number of `count` items per thread.
    pub(super) fn share(&self, count: usize) -> usize {
        count.div_ceil(self.threads()).max(1)
    }

    /// Runs both closures, in parallel if possible.
    pub(super) fn both<R: Send, Q: Send>(
        &self,
        one: impl FnOnce() -> R + Send,
        other: impl FnOnce() -> Q + Send,
    ) -> (R, Q) {
        if self.is_alone() { (one(), other()) } else { rayon::join(one, other) }
    }

    /// Runs every task on any idle thread; returns the results in order.
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

    /// Maps each item by `of`, in order, into `place`, which is empty. The thread that writes
    /// memory is the first to touch it.
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

    /// Returns `count` copies of `value`. The first thread writes the first ones.
    pub(super) fn copies<T: Copy + Send + Sync>(&self, value: T, count: usize) -> Vec<T> {
        if self.is_alone() {
            return vec![value; count];
        }
        rayon::iter::repeat_n(value, count).with_min_len(SHARE_MIN).collect()
    }

    /// [`BuildPool::each`] for three tasks. Allocates nothing.
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

/// Signals the end of the work when dropped, even if the work panics, since the scope waits for its
/// threads even then.
struct Done<'a>(&'a AtomicBool);

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests;
