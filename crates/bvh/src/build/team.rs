//! Threads that build one tree together. What comes out does not depend on who did what.
//!
//! They are started once, and wait between steps. A thread that is started anew for a step may find
//! itself on the core of the one that started it, and wait there for milliseconds, though another
//! core is idle: on a two-core virtual machine that was so for up to 4 threads of 10.

use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// The caller, or threads of its own for which the caller waits.
#[derive(Debug)]
pub(super) struct Team(Option<ThreadPool>);

impl Team {
    /// The caller.
    pub(super) const ALONE: Self = Self(None);

    /// So many threads; just the caller if the system does not grant them, or one is enough.
    pub(super) fn of(threads: usize) -> Self {
        let several = ThreadPoolBuilder::new().num_threads(threads);
        Self(if threads < 2 { None } else { several.build().ok() })
    }

    /// How many there are, at least 1.
    pub(super) fn threads(&self) -> usize {
        self.0.as_ref().map_or(1, ThreadPool::current_num_threads)
    }

    /// The threads, unless it is the caller alone.
    pub(super) fn pool(&self) -> Option<&ThreadPool> {
        self.0.as_ref()
    }

    /// How many of `count` things each gets, at most.
    pub(super) fn share(&self, count: usize) -> usize {
        count.div_ceil(self.threads()).max(1)
    }

    /// Does something in one of the threads. Steps of it that are for all of them then begin
    /// without a change of threads.
    pub(super) fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.0 {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// Does both.
    pub(super) fn both<R: Send, Q: Send>(
        &self,
        one: impl FnOnce() -> R + Send,
        other: impl FnOnce() -> Q + Send,
    ) -> (R, Q) {
        match &self.0 {
            Some(pool) => pool.join(one, other),
            None => (one(), other()),
        }
    }

    /// Does every task, in whichever thread is free; returns what each gave, in order.
    pub(super) fn each<T: Send, R: Send>(
        &self,
        tasks: Vec<T>,
        run: impl Fn(T) -> R + Send + Sync,
    ) -> Vec<R> {
        match &self.0 {
            Some(pool) => pool.install(|| tasks.into_par_iter().with_max_len(1).map(run).collect()),
            None => tasks.into_iter().map(run).collect(),
        }
    }

    /// [`Team::each`] of three. Nothing is allocated.
    pub(super) fn three<T: Send, R: Send>(
        &self,
        tasks: [T; 3],
        run: impl Fn(T) -> R + Send + Sync,
    ) -> [R; 3] {
        let Some(pool) = &self.0 else { return tasks.map(run) };
        let ([x, y, z], run) = (tasks, &run);
        let (x, (y, z)) = pool.join(|| run(x), || rayon::join(|| run(y), || run(z)));
        [x, y, z]
    }
}
