//! Looks at bodies on their ways: which of them touch first, and when; in workers or in this
//! process.
//!
//! A look is a job without nodes: it goes through the same dispatcher, batches and faults as any
//! other. The paths that it needs are written into memory that the workers read.

use crate::work::{PartOf, TaskSource};
use crate::worker_pool::{WorkerPool, WorkerPoolError};
use crate::workspace::Backend;
use body::{BodyView, Meta};
use bvh::Counters;
use bytemuck::Zeroable as _;
use core::ops::ControlFlow;
use dispatch::{Closed, Job};
use executor::encounter::{Encounters, Look, LookOutcome};
use executor::motion;
use geometry::hash::splitmix64;
use geometry::motion::{MotionPath, STATE_WORDS};
use protocol::{Section, TaskId, WireLook, WireQuestion, WireTask, launch};
use std::collections::BTreeMap;

/// Looks that a worker has at once: one at work, and the next ones. More would leave some workers
/// with all the long ones.
const OUT_PER_WORKER: usize = 3;

/// A look, and the numbers of its bodies in the store.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AskedLook<'p> {
    pub(crate) models: [u32; 2],
    pub(crate) look: Look<'p>,
}

impl AskedLook<'_> {
    /// Whether there is memory for its paths.
    fn fits(&self) -> bool {
        let states: usize = self.look.ways.paths.iter().map(|path| path.states().len()).sum();
        states * STATE_WORDS <= launch::PATHS_WORDS
    }
}

/// What looks show, in their order, and what they took; `None`: it was not looked, and all is open.
#[derive(Debug, Default)]
pub(crate) struct Looked {
    pub(crate) seen: Vec<Option<LookOutcome>>,
    pub(crate) counters: Counters,
    /// Whether workers looked.
    pub(crate) by_workers: bool,
}

impl Backend {
    /// Looks, as far as there is time: until `due_ns` (monotonic), or until `is_due`, which is
    /// asked by looks in this process. `meanwhile` is called while workers look, and has nothing to
    /// do any more once it returns `false`.
    pub(crate) fn look(
        &mut self,
        asked: &[AskedLook<'_>],
        bodies: &[(Meta, BodyView<'_>)],
        encounters: &mut Encounters,
        (due_ns, is_due): (Option<u64>, Option<&dyn Fn() -> bool>),
        meanwhile: &mut dyn FnMut() -> bool,
    ) -> Result<Looked, WorkerPoolError> {
        // A single look is done sooner here.
        let is_for_workers = asked.len() > 1 && asked.iter().all(AskedLook::fits);
        match self {
            // Bodies that are copied are so for the sections of jobs.
            Self::Workers(pool) if is_for_workers && !pool.copies() => {
                pool.look(asked, bodies, due_ns, meanwhile)
            }
            Self::Workers(_) | Self::InProcess(_) => Ok(look_here(asked, encounters, is_due)),
        }
    }
}

/// Looks in this process until `is_due`.
pub(crate) fn look_here(
    asked: &[AskedLook<'_>],
    encounters: &mut Encounters,
    is_due: Option<&dyn Fn() -> bool>,
) -> Looked {
    let is_over = || is_due.is_some_and(|is_due| is_due());
    let mut watch = |_| if is_over() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let mut looked = Looked::default();
    for AskedLook { look, .. } in asked {
        if is_over() {
            break;
        }
        let seen = encounters.look(look, &mut watch).ok().map(|(seen, counters)| {
            looked.counters.add(&counters);
            seen
        });
        looked.seen.push(seen);
    }
    looked.seen.resize(asked.len(), None);
    looked
}

impl WorkerPool {
    /// Has workers look, as many at a time as there is memory for their paths.
    fn look(
        &mut self,
        asked: &[AskedLook<'_>],
        bodies: &[(Meta, BodyView<'_>)],
        due_ns: Option<u64>,
        meanwhile: &mut dyn FnMut() -> bool,
    ) -> Result<Looked, WorkerPoolError> {
        let mut looked = Looked { by_workers: true, ..Looked::default() };
        let mut left = asked;
        while !left.is_empty() {
            let most_out = OUT_PER_WORKER * self.size();
            let mut run = LookRun::of(left, bodies, (most_out, due_ns), meanwhile);
            self.write_paths(&run.words);
            left = &left[run.asked.len()..];
            self.work_off_unlogged(&mut run)?;
            looked.seen.append(&mut run.seen);
            looked.counters.add(&run.counters);
        }
        Ok(looked)
    }
}

/// Looks as the work of one request.
struct LookRun<'r, 'p> {
    asked: &'r [AskedLook<'p>],
    bodies: &'r [(Meta, BodyView<'r>)],
    tasks: Vec<WireTask>,
    /// The paths.
    words: Vec<u64>,
    seen: Vec<Option<LookOutcome>>,
    counters: Counters,
    /// The next look to hand out.
    next: usize,
    /// Looks handed out and not closed, and the most of these.
    out: usize,
    most_out: usize,
    due_ns: Option<u64>,
    meanwhile: &'r mut dyn FnMut() -> bool,
}

/// Where a path lies in memory, its length (words), and the sum over its words.
type Place = ([u32; 2], u64);

impl<'r, 'p> LookRun<'r, 'p> {
    /// As many of the first looks as there is memory for: at least one.
    fn of(
        asked: &'r [AskedLook<'p>],
        bodies: &'r [(Meta, BodyView<'r>)],
        (most_out, due_ns): (usize, Option<u64>),
        meanwhile: &'r mut dyn FnMut() -> bool,
    ) -> Self {
        let mut words = Vec::new();
        // Paths of this run, all of which live as long as it: their addresses tell them apart.
        let mut places: BTreeMap<*const MotionPath, Place> = BTreeMap::new();
        let mut tasks: Vec<WireTask> = Vec::new();
        for AskedLook { models, look } in asked {
            let known = words.len();
            let placed = look.ways.paths.map(|path| {
                *places.entry(path).or_insert_with(|| {
                    let first = words.len();
                    motion::write(path, &mut words);
                    let count = words.len() - first;
                    ([first as u32, count as u32], motion::sum(&words[first..]))
                })
            });
            if words.len() > launch::PATHS_WORDS && !tasks.is_empty() {
                words.truncate(known);
                break;
            }
            let wire = WireLook {
                model_a: models[0],
                model_b: models[1],
                question: WireQuestion::Look as u32,
                task: tasks.len() as u32,
                paths: placed.map(|(place, _)| place),
                sums: placed.map(|(_, sum)| sum),
                from_s: look.from_s,
                end_s: look.end_s,
                resolution_m: look.resolution_m,
                may_touch: u64::from(look.may_touch),
                ..WireLook::zeroed()
            };
            tasks.push(wire.task());
        }
        let asked = &asked[..tasks.len()];
        let seen = vec![None; asked.len()];
        let (next, out) = (0, 0);
        let counters = Counters::default();
        Self { asked, bodies, tasks, words, seen, counters, next, out, most_out, due_ns, meanwhile }
    }
}

impl TaskSource for LookRun<'_, '_> {
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
        (self.meanwhile)()
    }
}

impl dispatch::JobSource for LookRun<'_, '_> {
    type Part<'p> = PartOf<'p>;

    fn more(&mut self, jobs: &mut Vec<Job>) {
        if self.next < self.tasks.len() && self.out < self.most_out {
            let node = self.next as u32;
            // No two looks share a section, so that workers get them by their load alone.
            let [a, b] = [0, 1].map(|model| Section { model, node });
            jobs.push(Job { task: TaskId(node), a, b });
            self.next += 1;
            self.out += 1;
        }
    }

    fn is_obsolete(&self, _: &Job) -> bool {
        false
    }

    fn fold(&mut self, job: &Job, part: PartOf<'_>) {
        let Some(last) = part.0.last else { return };
        let number = job.task.0 as usize;
        let Some(asked) = self.asked.get(number) else { return };
        self.counters.add(&Counters { nb: last.summary.nb, np: last.summary.np });
        self.seen[number] = last.seen.and_then(|seen| LookOutcome::from_wire(&seen, &asked.look));
    }

    fn close(&mut self, _: &Job, _: Closed) {
        self.out -= 1;
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
