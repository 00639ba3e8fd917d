//! Runs all jobs in this process, one after the other: no workers, no channels.

use crate::gather::{Part, Rest};
use crate::work::{PartOf, TaskSource};
use crate::worker_pool::IdleHook;
use body::{BodyView, Meta};
use bvh::{NodePair, Sink};
use core::ops::ControlFlow;
use dispatch::{Closed, Job};
use executor::{Executor, JobInput, NotDone, hit};
use protocol::Summary;
use protocol::result::Last;
use runtime::clock;

/// Interval between calls of the idle hook (ns), as with workers.
const LOOK_NS: u64 = 20_000_000;

/// Hits of a job, which stops when the answer is due.
#[derive(Debug)]
struct Hits<'h> {
    hits: &'h mut Vec<u32>,
    due_ns: Option<u64>,
}

impl Sink for Hits<'_> {
    fn hit(&mut self, side: bvh::Side, triangle: u32) -> ControlFlow<()> {
        self.hits.push(hit(side, triangle));
        ControlFlow::Continue(())
    }

    fn beat(&mut self, _: u64) -> ControlFlow<()> {
        match self.due_ns {
            Some(due_ns) if clock::now_ns() >= due_ns => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        }
    }
}

/// Runs jobs in this process. It holds scratch memory only, so it can be kept across requests,
/// whatever their bodies; once its buffers are large enough it does not allocate.
#[derive(Debug)]
pub struct InProcessExecutor {
    executor: Executor,
    hits: Vec<u32>,
    jobs: Vec<Job>,
    /// Called while a request is worked on.
    idle_hook: Option<IdleHook>,
}

/// Runs a request in this process, to its end or as far as its limits ask. Returns the number of
/// jobs.
pub fn run_in_process<W: TaskSource>(work: &mut W, bodies: &[(Meta, BodyView<'_>)]) -> u64 {
    run_watched(work, bodies, |_, _| {})
}

/// [`run_in_process`], calling `watch` with each job's own counts before it is folded.
pub fn run_watched<W: TaskSource>(
    work: &mut W,
    bodies: &[(Meta, BodyView<'_>)],
    watch: impl FnMut(&Job, &Summary),
) -> u64 {
    InProcessExecutor::with_room_for(bodies).work_off_watched(work, watch)
}

impl InProcessExecutor {
    /// An executor with buffers for jobs of these bodies.
    #[must_use]
    pub fn with_room_for(bodies: &[(Meta, BodyView<'_>)]) -> Self {
        let executor = Executor::with_room_for(bodies);
        Self { executor, hits: Vec::new(), jobs: Vec::new(), idle_hook: None }
    }

    /// Calls this hook between jobs, some 20 ms apart.
    #[must_use]
    pub fn with_idle_hook(self, idle_hook: IdleHook) -> Self {
        Self { idle_hook: Some(idle_hook), ..self }
    }

    /// What [`with_idle_hook`](Self::with_idle_hook) was given.
    pub(crate) fn idle_hook(&self) -> Option<&IdleHook> {
        self.idle_hook.as_ref()
    }

    /// Sizes the buffers for jobs of other bodies; allocates only if these are larger.
    pub fn make_room_for(&mut self, bodies: &[(Meta, BodyView<'_>)]) {
        self.executor.make_room_for(bodies);
    }

    /// Runs a request to its end, or as far as its limits ask. Returns the number of jobs.
    pub fn work_off<W: TaskSource>(&mut self, work: &mut W) -> u64 {
        self.work_off_watched(work, |_, _| {})
    }

    fn work_off_watched<W: TaskSource>(
        &mut self,
        work: &mut W,
        mut watch: impl FnMut(&Job, &Summary),
    ) -> u64 {
        let mut jobs = std::mem::take(&mut self.jobs);
        let mut count = 0;
        let mut looked_ns = clock::now_ns();
        work.accept(looked_ns);
        'work: loop {
            jobs.clear();
            work.more(&mut jobs);
            if jobs.is_empty() {
                break;
            }
            for job in &jobs {
                let now_ns = clock::now_ns();
                if work.is_over(now_ns) {
                    break 'work;
                }
                if now_ns - looked_ns >= LOOK_NS {
                    looked_ns = now_ns;
                    self.idle_hook.iter().for_each(IdleHook::call);
                }
                count += 1;
                if work.is_obsolete(job) {
                    work.close(job, Closed::Cut);
                    continue;
                }
                self.run(work, job, &mut watch);
            }
        }
        self.jobs = jobs;
        count
    }

    /// Runs one job, unless the answer is due before it ends: then it stays open.
    pub(crate) fn run<W: TaskSource>(
        &mut self,
        work: &mut W,
        job: &Job,
        watch: &mut impl FnMut(&Job, &Summary),
    ) {
        let begun_ns = clock::now_ns();
        let Some(task) = work.task(job.task) else { return };
        let start = NodePair { a: job.a.node, b: job.b.node };
        let asked = JobInput { start, budget: work.budget() };
        self.hits.clear();
        let mut sink = Hits { hits: &mut self.hits, due_ns: work.deadline_ns() };
        let done = match self.executor.execute(task, |model| work.body(model), asked, &mut sink) {
            Ok(done) => done,
            Err(NotDone::Stopped) => return,
            // It cannot be run, so its result stays unknown.
            Err(NotDone::Unknown) => return work.close(job, Closed::Abandoned),
        };
        let summary = done.summary(self.hits.len() as u32, clock::now_ns() - begun_ns);
        watch(job, &summary);
        let supports = done.supports();
        let last = Some(Last { summary, supports, seen: None, hits: &self.hits });
        let rest = Rest::Pairs(self.executor.rest());
        work.fold(job, PartOf(Part { hits: &self.hits, rest, last }));
        work.close(job, Closed::Done);
    }
}
