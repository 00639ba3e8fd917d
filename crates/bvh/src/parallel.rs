//! One task on several threads of this process.
//!
//! Work is neither distributed in advance nor estimated. The calling thread starts with all of both
//! bodies, and idle threads announce themselves. The others check for this between two tests: while
//! no pairs are open, one of them stops its job and publishes the rest as open pairs. So work is
//! split where the contact is, only on demand, and a small task is not split at all. This is work
//! stealing in which the victim gives: Acar, Charguéraud and Rainey, *Scheduling Parallel Programs
//! by Work Stealing with Private Deques* (PPoPP 2013).
//!
//! ```text
//! run ── roots ──▶ job ── complete ──▶ the largest open pair; if there is none, wait
//!                   │                              ▲
//!                   └─ a thread waits: what remains ──▶ open pairs ──▶ its job
//! ```
//!
//! A waiting thread spins, then yields, then sleeps: if the next task comes soon, it finds the
//! thread awake, and idle threads cost nothing.
//!
//! # Invariants
//!
//! - The outcome of a task, except its counters, and the triangles hit are the same for any number
//!   of threads: jobs merge by sum, union and maximum. `parallel/tests.rs`.
//! - The work terminates: a stopped job leaves smaller pairs, or is repeated without interruption.
//! - No thread waits for one that panicked: the panic resumes in the calling thread.

use crate::hits::Hits;
use crate::{Counters, End, Kernel, NodePair, Outcome, Question, Side, Sink, Task};
use crossbeam::utils::{Backoff, CachePadded};
use geometry::Supports;
use std::any::Any;
use std::mem;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

/// Minimum number of tests before a job is stopped for others: stopping, waking a thread and
/// restarting take as long as a few thousand tests.
const TESTS_MIN: u64 = 4 * crate::kernel::BEAT_TESTS;

/// How often a waiting thread yields its core before it sleeps: for a fraction of a millisecond,
/// much longer than a task's last jobs or the gap between two tasks.
const YIELDS_MAX: u32 = 1000;

/// Threads that run tasks together; created by [`with`].
#[derive(Debug)]
pub struct Parallel<'c, 't> {
    shared: &'c Shared<'t>,
    own: Own,
    /// Results of the last task.
    found: Found,
    seen: Hits,
}

/// State shared by the threads.
#[derive(Debug, Default)]
struct Shared<'t> {
    state: Mutex<State<'t>>,
    changed: Condvar,
    /// Counts the events that threads wait for: open pairs, the end of a task, shutdown. Changes
    /// only under the lock.
    changes: CachePadded<AtomicU64>,
    /// Number of waiting threads in excess of open pairs.
    wanting: CachePadded<AtomicUsize>,
    /// Whether [`Question::Touches`] is answered.
    is_answered: CachePadded<AtomicBool>,
}

#[derive(Debug, Default)]
struct State<'t> {
    task: Option<Task<'t>>,
    /// Pairs that no thread works on; the first of a stopped job, the largest, comes last.
    open: Vec<NodePair>,
    working: usize,
    waiting: usize,
    sleeping: usize,
    /// Merged results of the threads that have stopped working.
    found: Found,
    panic: Option<Box<dyn Any + Send>>,
    is_over: bool,
}

/// Results of jobs.
#[derive(Debug)]
struct Found {
    outcome: Outcome,
    /// Of A and of B; each triangle at most once per job.
    hits: [Vec<u32>; 2],
    jobs: u64,
}

/// Buffers of one thread.
#[derive(Debug)]
struct Own {
    kernel: Kernel,
    found: Found,
}

/// The sink of a job: collects hits and checks whether threads are waiting.
struct JobSink<'e, 't> {
    shared: &'e Shared<'t>,
    /// Where hits go; `None` if they are not needed.
    hits: Option<&'e mut [Vec<u32>; 2]>,
    question: Question,
    /// Whether the job may be stopped for waiting threads.
    shares: bool,
}

/// Calls `ask` with a pool of this many threads, including the calling one; 0 counts as 1.
///
/// `kernel` creates the kernel of each thread. It must have capacity for the bodies of all tasks,
/// see [`Kernel::run`].
///
/// # Panics
///
/// If `ask` does, if a job does, or if a thread cannot be started.
pub fn with<'t, R>(
    threads: usize,
    kernel: impl Fn() -> Kernel,
    ask: impl FnOnce(&mut Parallel<'_, 't>) -> R,
) -> R {
    let shared = Shared::default();
    let own = || Own { kernel: kernel(), found: Found::default() };
    thread::scope(|scope| {
        // Dropping it ends the other threads, so it must be dropped on every exit path.
        let mut parallel = Parallel {
            shared: &shared,
            own: own(),
            found: Found::default(),
            seen: Hits::with_room(0),
        };
        for _ in 1..threads {
            let (shared, own) = (&shared, own());
            scope.spawn(move || shared.help(own));
        }
        ask(&mut parallel)
    })
}

impl<'t> Parallel<'_, 't> {
    /// Runs `task` and returns the merge of all jobs below the roots. Allocates only if more pairs
    /// are open, or more triangles are hit, than ever before.
    ///
    /// # Panics
    ///
    /// As [`Kernel::run`], in any of the threads.
    pub fn run(&mut self, task: &Task<'t>) -> Outcome {
        self.found.clear();
        self.shared.begin(task);
        let mut next = Some(NodePair::ROOTS);
        while let Some(pair) = next {
            self.shared.work(&mut self.own, task, pair);
            next = self.shared.wait_for_the_rest(&mut self.found);
        }
        if self.found.jobs > 1 {
            for hits in &mut self.found.hits {
                let numbers = hits.iter().max().map_or(0, |most| most + 1);
                self.seen.ensure_room(numbers as usize);
                self.seen.clear(&(0..numbers));
                hits.retain(|triangle| self.seen.insert(*triangle));
            }
        }
        let Outcome { pairs, .. } = self.found.outcome;
        let is_one = task.question == Question::Touches;
        Outcome { pairs: if is_one { pairs.min(1) } else { pairs }, ..self.found.outcome }
    }

    /// The triangles of one body that the last task hit, by number in leaf order: each once, in no
    /// particular order. Recorded only for [`Question::Sets`].
    #[must_use]
    pub fn hits(&self, side: Side) -> &[u32] {
        &self.found.hits[side as usize]
    }

    /// Number of jobs of the last task: 1 if it was not split. It depends on which threads were
    /// idle.
    #[must_use]
    pub fn jobs(&self) -> u64 {
        self.found.jobs
    }
}

impl Drop for Parallel<'_, '_> {
    fn drop(&mut self) {
        let mut state = self.shared.lock();
        state.is_over = true;
        state.open.clear();
        self.shared.tell(&state);
    }
}

impl<'t> Shared<'t> {
    /// Every update completes under one lock, so a panic leaves the state consistent.
    fn lock(&self) -> MutexGuard<'_, State<'t>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn begin(&self, task: &Task<'t>) {
        let mut state = self.lock();
        state.task = Some(*task);
        state.working = 1;
        self.is_answered.store(false, Ordering::Relaxed);
    }

    /// The main loop of all threads except the calling one.
    fn help(&self, mut own: Own) {
        while let Some((task, pair)) = self.wait(State::job_or_end) {
            // Scratch left behind by a panic is not used again: this thread ends.
            let worked = catch_unwind(AssertUnwindSafe(|| self.work(&mut own, &task, pair)));
            if let Err(panic) = worked {
                let mut state = self.lock();
                state.panic = Some(panic);
                self.tell(&state);
                return;
            }
        }
    }

    /// Works on `pair`, then on any open pairs; hands in its results when there are none.
    fn work(&self, own: &mut Own, task: &Task<'t>, mut pair: NodePair) {
        loop {
            own.run(self, task, pair);
            let mut state = self.lock();
            let rest = own.kernel.remaining();
            if self.is_answered.load(Ordering::Relaxed) {
                state.open.clear();
            } else if !rest.is_empty() {
                state.open.extend(rest.iter().rev());
                self.tell(&state);
            }
            if let Some(next) = state.open.pop() {
                self.count(&state);
                pair = next;
                continue;
            }
            state.found.take(&mut own.found);
            state.working -= 1;
            if state.working == 0 {
                self.tell(&state);
            }
            return;
        }
    }

    /// For the calling thread: returns an open pair, or `None` with the merged results once no
    /// thread is working.
    fn wait_for_the_rest(&self, found: &mut Found) -> Option<NodePair> {
        let next = self.wait(|state| {
            if let Some(panic) = state.panic.take() {
                return Some(Err(panic));
            }
            if let Some((_, pair)) = state.job() {
                return Some(Ok(Some(pair)));
            }
            (state.working == 0).then(|| {
                mem::swap(found, &mut state.found);
                Ok(None)
            })
        });
        next.unwrap_or_else(|panic| resume_unwind(panic))
    }

    /// Waits until `ready` returns a value; it is called again after every change.
    fn wait<T>(&self, mut ready: impl FnMut(&mut State<'t>) -> Option<T>) -> T {
        let mut state = self.lock();
        state.waiting += 1;
        loop {
            if let Some(value) = ready(&mut state) {
                state.waiting -= 1;
                self.count(&state);
                return value;
            }
            self.count(&state);
            let seen = self.changes.load(Ordering::Relaxed);
            drop(state);
            let backoff = Backoff::new();
            for _ in 0..YIELDS_MAX {
                if self.changes.load(Ordering::Relaxed) != seen {
                    break;
                }
                backoff.snooze();
            }
            state = self.lock();
            while self.changes.load(Ordering::Relaxed) == seen {
                state.sleeping += 1;
                state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
                state.sleeping -= 1;
            }
        }
    }

    /// Wakes all waiting threads to check again.
    fn tell(&self, state: &State<'t>) {
        self.count(state);
        self.changes.fetch_add(1, Ordering::Relaxed);
        if state.sleeping > 0 {
            self.changed.notify_all();
        }
    }

    /// Recounts the waiting threads without a pair. Call after every change of `open` or `waiting`,
    /// under the lock.
    fn count(&self, state: &State<'t>) {
        let wanting = state.waiting.saturating_sub(state.open.len());
        self.wanting.store(wanting, Ordering::Relaxed);
    }
}

impl<'t> State<'t> {
    /// The next job for a waiting thread, which counts as working from now on.
    fn job(&mut self) -> Option<(Task<'t>, NodePair)> {
        let job = (self.task?, self.open.pop()?);
        self.working += 1;
        Some(job)
    }

    /// The next job, or `None` on shutdown.
    fn job_or_end(&mut self) -> Option<Option<(Task<'t>, NodePair)>> {
        if self.is_over { Some(None) } else { self.job().map(Some) }
    }
}

impl Own {
    /// Runs the job below `pair`; what remains of it is never just `pair` itself.
    fn run(&mut self, shared: &Shared<'_>, task: &Task<'_>, pair: NodePair) {
        // Where two large leaves meet, a job may be stopped before it makes progress.
        for shares in [true, false] {
            let hits = (task.question == Question::Sets).then_some(&mut self.found.hits);
            let mut sink = JobSink { shared, hits, question: task.question, shares };
            let outcome = self.kernel.run(task, pair, u64::MAX, &mut sink);
            self.found.add(&outcome, 1);
            if self.kernel.remaining() != [pair] {
                return;
            }
        }
    }
}

impl Sink for JobSink<'_, '_> {
    fn hit(&mut self, side: Side, triangle: u32) -> ControlFlow<()> {
        if let Some(hits) = &mut self.hits {
            hits[side as usize].push(triangle);
        }
        if self.question == Question::Touches {
            self.shared.is_answered.store(true, Ordering::Relaxed);
        }
        ControlFlow::Continue(())
    }

    fn beat(&mut self, tests: u64) -> ControlFlow<()> {
        let is_wanted =
            self.shares && tests >= TESTS_MIN && self.shared.wanting.load(Ordering::Relaxed) > 0;
        if is_wanted || self.shared.is_answered.load(Ordering::Relaxed) {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}

impl Default for Found {
    fn default() -> Self {
        Self { outcome: NOTHING, hits: Default::default(), jobs: 0 }
    }
}

/// The outcome of no job.
const NOTHING: Outcome = Outcome {
    end: End::Complete,
    counters: Counters { nb: 0, np: 0 },
    pairs: 0,
    hash: 0,
    zones_a: 0,
    zones_b: 0,
    supports: Supports::EMPTY,
};

impl Found {
    fn clear(&mut self) {
        self.hits.iter_mut().for_each(Vec::clear);
        self.jobs = 0;
    }

    /// Takes over the results of `other`, leaving it empty.
    fn take(&mut self, other: &mut Self) {
        self.add(&other.outcome, other.jobs);
        for (hits, more) in self.hits.iter_mut().zip(&mut other.hits) {
            hits.append(more);
        }
        other.clear();
    }

    /// Adds the outcome of `jobs` jobs, at least one. Pairs they left open belong to other jobs.
    fn add(&mut self, other: &Outcome, jobs: u64) {
        let is_first = self.jobs == 0;
        self.jobs += jobs;
        if is_first {
            // Most tasks are one job, which needs no merging.
            self.outcome = Outcome { end: End::Complete, ..*other };
            return;
        }
        let all = &mut self.outcome;
        all.counters.add(&other.counters);
        all.pairs += other.pairs;
        all.hash = all.hash.wrapping_add(other.hash);
        all.zones_a |= other.zones_a;
        all.zones_b |= other.zones_b;
        all.supports.merge(&other.supports);
    }
}

#[cfg(test)]
mod tests;
