//! Looks at bodies on their ways: which of them touch first, and when; in workers or in this
//! process.
//!
//! ```text
//! source --next--> look --> worker, or this process --learn--> source: further looks, or none
//!    ^                                                           |
//!    +------- while workers look: a little of what else there is +
//! ```
//!
//! A look is a job without nodes: it goes through the same dispatcher, batches and faults as any
//! other. The paths that it needs are written into memory that the workers read. What a look shows
//! may ask for the next one, so that nobody waits until all looks of some kind are done.

use crate::path_memory::PathMemory;
use crate::work::{PartOf, TaskSource};
use crate::worker_pool::{WorkerPool, WorkerPoolError};
use crate::workspace::Backend;
use body::{BodyView, Meta};
use bvh::Counters;
use bvh::query::QueryWatch;
use bytemuck::Zeroable as _;
use core::ops::ControlFlow;
use dispatch::{Closed, Job};
use executor::encounter::{Look, LookOutcome};
use geometry::hash::splitmix64;
use protocol::{Section, TaskId, WireLook, WireQuestion, WireTask};
use runtime::{WrittenWords, clock};
use std::collections::VecDeque;
use std::rc::Rc;

/// Looks that a worker has at once, at least and at most: one at work, and the next ones. The most
/// is what its queue takes, if nothing else is set.
const OUT_LEAST: u64 = 3;
pub(crate) const OUT_MOST: u64 = 16;

/// How long these last (ns), within these limits: as long as the coordinator may assemble contacts,
/// or wait for the core of a worker itself. Longer ones would leave some workers with looks when
/// others have none.
const OUT_NS: u64 = 2_000_000;

/// How long looks of a search have taken.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LookTimes {
    looks: u64,
    took_ns: u64,
}

impl LookTimes {
    /// Adds a look that took so long.
    pub(crate) fn add(&mut self, took_ns: u64) {
        self.looks += 1;
        self.took_ns = self.took_ns.saturating_add(took_ns);
    }

    /// How many looks a worker has at once.
    pub(crate) fn out_per_worker(&self) -> usize {
        let in_time = OUT_NS.saturating_mul(self.looks) / self.took_ns.max(1);
        in_time.clamp(OUT_LEAST, OUT_MOST) as usize
    }
}

/// A look, and the numbers of its bodies in the store.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AskedLook<'p> {
    pub(crate) models: [u32; 2],
    pub(crate) look: Look<'p>,
}

/// Supplies looks, and takes what they show.
pub(crate) trait LookSource {
    /// What tells looks apart.
    type Id: Copy;

    /// The next look, if there is one by now. The paths of looks stay where they are.
    fn next(&mut self) -> Option<Self::Id>;
    /// A look that was not learnt yet.
    fn asked(&self, id: Self::Id) -> AskedLook<'_>;
    /// Looks in this process; `None` if `watch` ended it.
    fn look(&mut self, id: Self::Id, watch: QueryWatch<'_>) -> Option<(LookOutcome, Counters)>;
    /// Takes what a look showed, once; `None`: it was not done, and all is open.
    fn learn(&mut self, id: Self::Id, seen: Option<LookOutcome>);
    /// Does a little of what else is to be done; `false` if there is nothing by now.
    fn use_spare_time(&mut self) -> bool;
}

/// What looks took.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LookEffort {
    pub(crate) counters: Counters,
    /// Looks handed to workers.
    pub(crate) jobs: u64,
}

impl Backend {
    /// Looks, as far as there is time: until `due_ns` (monotonic), or until `is_due`, which is
    /// asked by looks in this process.
    pub(crate) fn look(
        &mut self,
        source: &mut impl LookSource,
        bodies: &[(Meta, BodyView<'_>)],
        (due_ns, is_due): (Option<u64>, Option<&dyn Fn() -> bool>),
    ) -> Result<LookEffort, WorkerPoolError> {
        let is_due = || is_due.is_some_and(|is_due| is_due());
        match self {
            // Bodies that are copied are so for the sections of jobs.
            Self::Workers(pool) if !pool.copies() => pool.look(source, bodies, (due_ns, &is_due)),
            Self::Virtual(cores) => Ok(cores.look(source)),
            Self::Workers(_) | Self::InProcess(_) => {
                Ok(look_here(source, |source, id| look_until(source, id, &is_due)))
            }
        }
    }
}

/// What a look showed, and what it took; `None`: it was not done.
pub(crate) type Seen = Option<(LookOutcome, Counters)>;

/// Looks in this process, one after the other, by `see`.
pub(crate) fn look_here<S: LookSource>(
    source: &mut S,
    mut see: impl FnMut(&mut S, S::Id) -> Seen,
) -> LookEffort {
    let mut effort = LookEffort::default();
    loop {
        while source.use_spare_time() {}
        let Some(id) = source.next() else { return effort };
        let seen = see(source, id);
        effort.learn(source, id, seen);
    }
}

/// One look in this process, unless `is_due`.
fn look_until<S: LookSource>(source: &mut S, id: S::Id, is_due: &dyn Fn() -> bool) -> Seen {
    let mut watch = |_| if is_due() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    if is_due() { None } else { source.look(id, &mut watch) }
}

impl LookEffort {
    /// Tells the source what a look in this process showed.
    pub(crate) fn learn<S: LookSource>(&mut self, source: &mut S, id: S::Id, seen: Seen) {
        if let Some((_, counters)) = &seen {
            self.counters.add(counters);
        }
        source.learn(id, seen.map(|(seen, _)| seen));
    }
}

/// Whether it is as late as `due_ns` (monotonic).
fn is_past(due_ns: Option<u64>) -> bool {
    due_ns.is_some_and(|due_ns| due_ns <= clock::now_ns())
}

impl WorkerPool {
    /// Has workers look.
    fn look<S: LookSource>(
        &mut self,
        source: &mut S,
        bodies: &[(Meta, BodyView<'_>)],
        (due_ns, is_due): (Option<u64>, &dyn Fn() -> bool),
    ) -> Result<LookEffort, WorkerPoolError> {
        let mut effort = LookEffort::default();
        let mut times = LookTimes::default();
        while let Some(first) = source.next() {
            // A single look is done sooner here, and none is begun after the deadline.
            let second = if is_past(due_ns) { None } else { source.next() };
            let Some(second) = second else {
                let seen = look_until(source, first, is_due);
                effort.learn(source, first, seen);
                continue;
            };
            let paths = Rc::clone(self.paths());
            let mut run = LookRun::of(source, bodies, (&paths, self.size(), due_ns));
            run.times = times;
            run.begun.extend([first, second]);
            let done = self.work_off_unlogged(&mut run);
            run.leave();
            effort.counters.add(&run.effort.counters);
            effort.jobs += run.effort.jobs;
            times = run.times;
            done?;
        }
        Ok(effort)
    }
}

/// Looks as the work of one request.
struct LookRun<'r, S: LookSource> {
    source: &'r mut S,
    bodies: &'r [(Meta, BodyView<'r>)],
    /// Looks that the source gave, and that are no jobs yet.
    begun: VecDeque<S::Id>,
    tasks: Vec<WireTask>,
    /// By task: its look until it is learnt, and what it showed.
    looks: Vec<Option<S::Id>>,
    seen: Vec<Option<LookOutcome>>,
    memory: PathMemory<'r>,
    effort: LookEffort,
    /// Looks handed out and not closed.
    out: usize,
    workers: usize,
    times: LookTimes,
    due_ns: Option<u64>,
}

impl<'r, S: LookSource> LookRun<'r, S> {
    fn of(
        source: &'r mut S,
        bodies: &'r [(Meta, BodyView<'r>)],
        (memory, workers, due_ns): (&'r WrittenWords, usize, Option<u64>),
    ) -> Self {
        Self {
            source,
            bodies,
            begun: VecDeque::new(),
            tasks: Vec::new(),
            looks: Vec::new(),
            seen: Vec::new(),
            memory: PathMemory::over(memory),
            effort: LookEffort::default(),
            out: 0,
            workers,
            times: LookTimes::default(),
            due_ns,
        }
    }

    /// A look as a task; `None`: there is no room for its paths.
    fn task_of(&mut self, id: S::Id) -> Option<WireTask> {
        let AskedLook { models, look } = self.source.asked(id);
        let places = self.memory.place(look.ways.paths).or_else(|| {
            if self.out > 0 {
                return None;
            }
            self.memory.clear();
            self.memory.place(look.ways.paths)
        })?;
        let wire = WireLook {
            model_a: models[0],
            model_b: models[1],
            question: WireQuestion::Look as u32,
            task: self.tasks.len() as u32,
            paths: places.map(|(place, _)| place),
            sums: places.map(|(_, sum)| sum),
            from_s: look.from_s,
            end_s: look.end_s,
            resolution_m: look.resolution_m,
            may_touch: u64::from(look.may_touch),
            ..WireLook::zeroed()
        };
        Some(wire.task())
    }

    /// Tells the source that nothing more is done.
    fn leave(&mut self) {
        for id in self.looks.iter_mut().filter_map(Option::take) {
            self.source.learn(id, None);
        }
        for id in self.begun.drain(..) {
            self.source.learn(id, None);
        }
    }
}

impl<S: LookSource> TaskSource for LookRun<'_, S> {
    fn task(&self, task: TaskId) -> Option<&WireTask> {
        self.tasks.get(task.0 as usize)
    }

    fn body(&self, model: u32) -> Option<BodyView<'_>> {
        self.bodies.get(model as usize).map(|(_, body)| *body)
    }

    fn deadline_ns(&self) -> Option<u64> {
        self.due_ns
    }

    fn is_over(&self, now_ns: u64) -> bool {
        self.due_ns.is_some_and(|due_ns| due_ns <= now_ns)
    }

    fn use_spare_time(&mut self) -> bool {
        self.source.use_spare_time()
    }
}

impl<S: LookSource> dispatch::JobSource for LookRun<'_, S> {
    type Part<'p> = PartOf<'p>;

    fn more(&mut self, jobs: &mut Vec<Job>) {
        while self.out < self.times.out_per_worker() * self.workers {
            let Some(id) = self.begun.pop_front().or_else(|| self.source.next()) else { return };
            match self.task_of(id) {
                Some(task) => {
                    let node = self.tasks.len() as u32;
                    self.tasks.push(task);
                    self.looks.push(Some(id));
                    self.seen.push(None);
                    // No two looks share a section, so that workers get them by their load alone.
                    let [a, b] = [0, 1].map(|model| Section { model, node });
                    jobs.push(Job { task: TaskId(node), a, b });
                    self.out += 1;
                    self.effort.jobs += 1;
                    return;
                }
                // There is room once those that are out are done.
                None if self.out > 0 => return self.begun.push_front(id),
                None => {
                    let due_ns = self.due_ns;
                    let seen = look_until(self.source, id, &|| is_past(due_ns));
                    self.effort.learn(self.source, id, seen);
                }
            }
        }
    }

    fn is_obsolete(&self, _: &Job) -> bool {
        false
    }

    fn fold(&mut self, job: &Job, part: PartOf<'_>) {
        let Some(last) = part.0.last else { return };
        let number = job.task.0 as usize;
        let Some(Some(id)) = self.looks.get(number) else { return };
        self.effort.counters.add(&Counters { nb: last.summary.nb, np: last.summary.np });
        self.times.add(last.summary.wall_ns);
        let look = self.source.asked(*id).look;
        self.seen[number] = last.seen.and_then(|seen| LookOutcome::from_wire(&seen, &look));
    }

    fn close(&mut self, job: &Job, _: Closed) {
        self.out -= 1;
        let number = job.task.0 as usize;
        if let Some(id) = self.looks.get_mut(number).and_then(Option::take) {
            self.source.learn(id, self.seen[number]);
        }
    }

    /// No section is sent, nor is a tree cut.
    fn weight(&self, _: Section) -> u64 {
        0
    }

    fn key(&self, job: &Job) -> Option<u64> {
        let look = WireLook::of(self.tasks.get(job.task.0 as usize)?)?;
        let numbers = [look.model_a, look.model_b, look.question].map(u64::from);
        let times = [look.from_s, look.end_s, look.resolution_m].map(f64::to_bits);
        let all = numbers.into_iter().chain(times).chain(look.sums).chain([look.may_touch]);
        Some(all.fold(0, |hash, next| splitmix64(hash ^ next)))
    }
}

#[cfg(test)]
mod tests;
