//! The dispatcher against a seeded world that loses, repeats, splits and kills.

use super::*;
use crate::{BestMatchLoad, Matching, RoundRobin};
use proptest::prelude::*;
use protocol::TaskId;
use std::collections::{BTreeMap, BTreeSet};

mod faults;
mod queues;

/// The request of these tests.
const NOW: RequestId = RequestId(7);

/// Work whose jobs come in waves: a wave is released when the previous one is closed.
#[derive(Default)]
struct Waves {
    left: Vec<u32>,
    open: u32,
    next: u32,
    folded: BTreeMap<(u32, u16), u32>,
    closed: BTreeMap<u32, Vec<Closed>>,
    obsolete: Option<u32>,
}

impl JobSource for Waves {
    type Part<'p> = u16;

    fn more(&mut self, jobs: &mut Vec<Job>) {
        if self.open > 0 {
            return;
        }
        let Some(count) = self.left.pop() else { return };
        for _ in 0..count {
            let node = self.next;
            let section = |model| Section { model, node: node % 7 };
            jobs.push(Job { task: TaskId(node), a: section(0), b: section(1) });
            self.next += 1;
            self.open += 1;
        }
    }
    fn is_obsolete(&self, job: &Job) -> bool {
        self.obsolete.is_some_and(|every| job.task.0 % every == 1)
    }
    fn fold(&mut self, job: &Job, part: u16) {
        *self.folded.entry((job.task.0, part)).or_default() += 1;
    }
    fn close(&mut self, job: &Job, how: Closed) {
        self.open -= 1;
        self.closed.entry(job.task.0).or_default().push(how);
    }
    fn weight(&self, _: Section) -> u64 {
        60
    }
}

/// A message on its way, or waiting in a worker's queue.
type Held = (Incarnation, JobId, u8);

struct World {
    dispatcher: Dispatcher<Box<dyn MatchScheme>>,
    now_ns: u64,
    work: Waves,
    queues: BTreeMap<Incarnation, Vec<Held>>,
    late: Vec<Held>,
    inc: u32,
    queues_max: u32,
    /// The last batch sent to each worker.
    batches: BTreeMap<Incarnation, u32>,
    doomed: Vec<u8>,
}

impl World {
    fn carry_out(&mut self, effects: Vec<Effect>) {
        for effect in effects {
            let Effect::Send { to, batch, jobs, .. } = effect else {
                // A worker that loses too much is killed: its jobs go to the others.
                let Effect::Kill { who, .. } = effect else { continue };
                self.doomed.push(who.worker);
                continue;
            };
            self.batches.insert(to, batch);
            let queue = self.queues.entry(to).or_default();
            queue.extend(jobs.into_iter().map(|(job, attempt)| (to, job, attempt)));
            assert!(queue.len() <= self.queues_max as usize, "a queue overflowed");
        }
    }

    fn step(&mut self, event: Event<u16>) -> Progress {
        let mut effects = Vec::new();
        self.now_ns += 1;
        let progress = self.dispatcher.step(self.now_ns, event, &mut self.work, &mut effects);
        self.carry_out(effects);
        // Who waits until then and polls would poll for ever otherwise.
        let due_ns = self.dispatcher.due_ns();
        assert!(due_ns.is_none_or(|due| due > self.now_ns), "{due_ns:?}, at {}", self.now_ns);
        progress
    }

    fn answer(&mut self, (from, job, attempt): Held, parts: &[(u16, bool)]) -> Progress {
        let mut progress = Progress::Working;
        for &(part, last) in parts {
            progress =
                self.step(Event::Part { from, request: NOW, job, attempt, part, last, body: part });
        }
        progress
    }

    /// Replaces a worker: its jobs are lost, and their results may arrive late.
    fn kill(&mut self, worker: u8, started: bool) -> Progress {
        let Some(who) = self.queues.keys().find(|who| who.worker == worker).copied() else {
            return self.step(Event::Poll);
        };
        let held = self.queues.remove(&who).unwrap_or_default();
        let started = started.then(|| held.first().map(|(_, job, attempt)| (*job, *attempt)));
        self.late.extend(held);
        self.step(Event::Lost { who, started: started.flatten() });
        self.inc += 1;
        let next = Incarnation { worker, inc: self.inc };
        self.queues.insert(next, Vec::new());
        self.step(Event::Ready(next))
    }
}

fn matchings() -> impl Strategy<Value = Matching> {
    prop_oneof![
        (0.0..=1.0).prop_map(Matching::BestMatchLoad),
        any::<u64>().prop_map(Matching::RandomMatch),
        Just(Matching::LowestMatch),
        Just(Matching::RoundRobin),
    ]
}

fn caches() -> impl Strategy<Value = Cache> {
    prop_oneof![Just(Cache::Unlimited), (0_u64..600).prop_map(Cache::Recent)]
}

/// The transfer recomputed from the log alone: a list of sections per core, most recent last.
fn recomputed(
    dispatcher: &Dispatcher<Box<dyn MatchScheme>>,
    cache: Cache,
    cores: usize,
) -> Transfer {
    let mut held: Vec<Vec<(Section, u64)>> = vec![Vec::new(); cores];
    let mut sum = Transfer::default();
    for entry in dispatcher.log() {
        let (who, sections) = match entry {
            LogEntry::Lost { who } => {
                held[usize::from(who.worker)].clear();
                continue;
            }
            LogEntry::Assigned { who, sections, .. } => (who, sections),
        };
        let list = &mut held[usize::from(who.worker)];
        for section in sections {
            sum.unshared_bytes += section.1;
            if let Some(at) = list.iter().position(|known| known == section) {
                sum.found += 1;
                list.remove(at);
            } else {
                sum.missed += 1;
                sum.section_bytes += section.1;
            }
            list.push(*section);
            let Cache::Recent(most) = cache else { continue };
            if section.1 > most {
                list.pop();
                continue;
            }
            while list.iter().map(|known| known.1).sum::<u64>() > most {
                list.remove(0);
                sum.evicted += 1;
            }
        }
    }
    sum
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    // verifies REQ-ONCE
    #[test]
    fn every_job_is_closed_exactly_once_whatever_happens(
        waves in prop::collection::vec(1_u32..40, 1..4),
        workers in 1_u8..5,
        (capacity, batch, linger_ns) in (1_u32..12, 1_u32..6, 0_u64..20),
        (matching, cache) in (matchings(), caches()),
        obsolete in prop::option::of(2_u32..6),
        dice in prop::collection::vec((0_u8..14, any::<prop::sample::Index>()), 0..250),
    ) {
        let queues = Queues { capacity, batch, linger_ns };
        let jobs: u32 = waves.iter().sum();
        let cores = usize::from(workers);
        let mut world = World {
            dispatcher: Dispatcher::new(matching.scheme(), queues, cache, cores),
            now_ns: 0,
            work: Waves { left: waves, obsolete, ..Waves::default() },
            queues: BTreeMap::new(),
            late: Vec::new(),
            inc: 0,
            queues_max: capacity,
            batches: BTreeMap::new(),
            doomed: Vec::new(),
        };
        world.dispatcher.keep_log();
        world.dispatcher.begin(NOW);
        let mut progress = Progress::Working;
        for worker in 0..workers {
            let who = Incarnation { worker, inc: 0 };
            world.queues.insert(who, Vec::new());
            progress = world.step(Event::Ready(who));
        }
        let mut kills = 0;
        let mut dice = dice.into_iter();
        while progress != Progress::Finished {
            if let Some(worker) = world.doomed.pop() {
                progress = world.kill(worker, false);
                continue;
            }
            let busy: Vec<Incarnation> = world.queues.iter()
                .filter(|(_, queue)| !queue.is_empty()).map(|(who, _)| *who).collect();
            if busy.is_empty() {
                // A batch may linger, but not longer than configured.
                let due_ns = world.dispatcher.due_ns();
                prop_assert!(due_ns.is_some(), "jobs are open and nobody holds one");
                world.now_ns = due_ns.unwrap();
                progress = world.step(Event::Poll);
                continue;
            }
            let Some((what, which)) = dice.next() else {
                let held = world.queues.get_mut(&busy[0]).unwrap().remove(0);
                progress = world.answer(held, &[(0, true)]);
                continue;
            };
            let who = busy[which.index(busy.len())];
            let mut pop = || world.queues.get_mut(&who).unwrap().remove(0);
            progress = match what {
                0 => { kills += 1; world.kill(who.worker, false) }
                1 => { kills += 1; world.kill(who.worker, true) }
                2 => { let held = pop(); world.answer(held, &[(0, false), (1, false), (2, true)]) }
                3 => { let held = pop(); world.answer(held, &[(0, true), (0, true)]) }
                4 => { let held = pop(); world.answer(held, &[(0, false), (2, true)]) }
                5 => {
                    let (from, job, attempt) = pop();
                    world.step(Event::Failed { from, request: NOW, job, attempt })
                }
                6 => {
                    // The worker reports at the end which batches it has processed or lost.
                    let batches = world.batches[&who] + 1;
                    for held in std::mem::take(world.queues.get_mut(&who).unwrap()) {
                        if which.index(3) > 0 { world.answer(held, &[(0, true)]); }
                    }
                    world.step(Event::Answered { who, batches })
                }
                8 => world.step(Event::Garbled { from: who }),
                7 if !world.late.is_empty() => {
                    let late = world.late.swap_remove(which.index(world.late.len()));
                    let before = world.dispatcher.counts().done;
                    let progress = world.answer(late, &[(0, true)]);
                    prop_assert_eq!(world.dispatcher.counts().done, before, "a dead worker's job");
                    progress
                }
                _ => { let held = pop(); world.answer(held, &[(0, true)]) }
            };
        }
        prop_assert_eq!(world.dispatcher.transfer(), recomputed(&world.dispatcher, cache, cores));
        let counts = world.dispatcher.counts();
        prop_assert_eq!(counts.jobs, u64::from(jobs));
        prop_assert_eq!(counts.done + counts.cut + counts.abandoned, counts.jobs);
        prop_assert_eq!(world.work.closed.len(), jobs as usize);
        for (job, closings) in &world.work.closed {
            prop_assert_eq!(closings.len(), 1, "job {} after {} kills", job, kills);
            let folded = world.work.folded.contains_key(&(*job, 0));
            prop_assert!(closings[0] != Closed::Done || folded, "done without a result");
        }
    }
}

#[test]
fn without_workers_the_request_is_stranded_and_a_late_worker_saves_it() {
    let queues = Queues { capacity: 4, batch: 2, linger_ns: 0 };
    let scheme = BestMatchLoad { alpha: 0.5 };
    let mut dispatcher = Dispatcher::new(scheme, queues, Cache::Unlimited, 2);
    let mut work = Waves { left: vec![3], ..Waves::default() };
    let mut effects = Vec::new();
    dispatcher.begin(NOW);
    assert_eq!(dispatcher.step(0, Event::Poll, &mut work, &mut effects), Progress::Stranded);
    assert!(effects.is_empty());
    let who = Incarnation { worker: 1, inc: 3 };
    assert_eq!(dispatcher.step(0, Event::Ready(who), &mut work, &mut effects), Progress::Working);
    assert_eq!(effects.len(), 2, "{effects:?}");
}

#[test]
fn a_worker_that_says_twice_that_it_is_ready_keeps_its_jobs() {
    let queues = Queues { capacity: 2, batch: 2, linger_ns: 0 };
    let mut dispatcher = Dispatcher::new(RoundRobin::default(), queues, Cache::Unlimited, 1);
    let who = Incarnation { worker: 0, inc: 0 };
    let mut effects = Vec::new();
    for batches in 1..=2 {
        dispatcher.begin(NOW);
        let mut work = Waves { left: vec![5], ..Waves::default() };
        dispatcher.step(0, Event::Poll, &mut work, &mut effects);
        dispatcher.step(0, Event::Ready(who), &mut work, &mut effects);
        dispatcher.step(0, Event::Ready(who), &mut work, &mut effects);
        assert_eq!(effects.len(), 1, "{effects:?}");
        // The request ends early, and the worker finishes what it has.
        dispatcher.step(0, Event::Expired, &mut work, &mut effects);
        dispatcher.step(0, Event::Answered { who, batches }, &mut work, &mut effects);
        effects.clear();
    }
}

// verifies REQ-ONCE
#[test]
fn a_job_that_takes_two_workers_down_is_abandoned_and_no_other() {
    let queues = Queues { capacity: 4, batch: 4, linger_ns: 0 };
    let scheme = BestMatchLoad { alpha: 0.0 };
    let mut dispatcher = Dispatcher::new(scheme, queues, Cache::Unlimited, 1);
    let mut work = Waves { left: vec![4], ..Waves::default() };
    dispatcher.begin(NOW);
    let mut effects = Vec::new();
    for inc in 0..3 {
        let who = Incarnation { worker: 0, inc };
        dispatcher.step(0, Event::Ready(who), &mut work, &mut effects);
        let started = Some((JobId(2), inc as u8));
        dispatcher.step(0, Event::Lost { who, started }, &mut work, &mut effects);
    }
    assert_eq!(dispatcher.counts().abandoned, 1);
    assert_eq!(work.closed, BTreeMap::from([(2, vec![Closed::Abandoned])]));
    // Jobs without a key are not known again.
    let mut work = Waves { left: vec![4], ..Waves::default() };
    dispatcher.begin(NOW);
    let who = Incarnation { worker: 0, inc: 3 };
    dispatcher.step(0, Event::Ready(who), &mut work, &mut effects);
    assert_eq!((dispatcher.counts().abandoned, dispatcher.counts().jobs), (0, 4));
}

/// Jobs in which each section of A meets each of B, as in one contact.
struct Grid {
    left: u32,
    weights: Vec<u64>,
}

impl JobSource for Grid {
    type Part<'p> = ();

    fn more(&mut self, jobs: &mut Vec<Job>) {
        let side = self.weights.len() as u32;
        let section = |model, node| Section { model, node };
        for at in 0..std::mem::take(&mut self.left) {
            let at = at % (side * side);
            let (a, b) = (section(0, at / side), section(1, at % side));
            jobs.push(Job { task: TaskId(0), a, b });
        }
    }
    fn is_obsolete(&self, _: &Job) -> bool {
        false
    }
    fn fold(&mut self, _: &Job, (): ()) {}
    fn close(&mut self, _: &Job, _: Closed) {}
    fn weight(&self, section: Section) -> u64 {
        self.weights[section.node as usize]
    }
}

proptest! {
    #[test]
    fn residency_never_costs_and_no_memory_is_exceeded(
        weights in prop::collection::vec(1_u64..100, 2..7),
        matching in matchings(),
        (cores, capacity, batch) in (1_usize..5, 1_u32..9, 1_u32..4),
        budget in prop::option::of(1_u64..900),
    ) {
        let side = weights.len() as u32;
        let all: u64 = 2 * weights.iter().sum::<u64>();
        let mut work = Grid { left: 3 * side * side, weights };
        let queues = Queues { capacity, batch, linger_ns: 0 };
        let cache = budget.map_or(Cache::Unlimited, Cache::Fixed);
        let mut dispatcher = Dispatcher::new(matching.scheme(), queues, cache, cores);
        dispatcher.keep_log();
        dispatcher.begin(NOW);
        let mut effects = Vec::new();
        for worker in 0..cores {
            let who = Incarnation { worker: worker as u8, inc: 0 };
            dispatcher.step(0, Event::Ready(who), &mut work, &mut effects);
        }
        let (mut sent, mut shipped) = (VecDeque::from(std::mem::take(&mut effects)), Vec::new());
        let mut progress = Progress::Working;
        while let Some(Effect::Send { to, jobs, fetch, .. }) = sent.pop_front() {
            shipped.extend(fetch.into_iter().map(|section| (to, section)));
            for (job, attempt) in jobs {
                let event = Event::Part {
                    from: to, request: NOW, job, attempt, part: 0, last: true, body: (),
                };
                progress = dispatcher.step(0, event, &mut work, &mut effects);
                sent.extend(effects.drain(..));
            }
        }
        let transfer = dispatcher.transfer();
        prop_assert!(transfer.section_bytes <= transfer.unshared_bytes);
        if let Some(thrash) = dispatcher.thrash() {
            prop_assert_eq!(progress, Progress::Thrashed);
            prop_assert!(thrash.held <= thrash.budget);
            prop_assert!(thrash.held + thrash.bytes > thrash.budget);
            return Ok(());
        }
        prop_assert_eq!(progress, Progress::Finished);
        // Nothing is evicted and no worker dies, so each core gets each section at most once.
        prop_assert!(transfer.section_bytes <= cores as u64 * all);
        let once: BTreeSet<_> = shipped.iter().collect();
        prop_assert_eq!(once.len(), shipped.len());
        prop_assert_eq!(shipped.len() as u64, transfer.missed);
        prop_assert_eq!(dispatcher.log().len() as u64, dispatcher.counts().jobs);
    }
}

/// Found by `cargo mutants`: nobody had asked whom it dismisses, and who is busy.
#[test]
fn whoever_is_dismissed_gets_no_job_and_a_successor_is_not_dismissed_for_it() {
    let queues = Queues { capacity: 2, batch: 2, linger_ns: 0 };
    let incarnation = |inc| Incarnation { worker: 0, inc };
    for (gone, batches) in [(incarnation(1), 0), (incarnation(0), 1)] {
        let mut dispatcher = Dispatcher::new(RoundRobin::default(), queues, Cache::Unlimited, 1);
        dispatcher.admit(incarnation(1));
        dispatcher.dismiss(gone);
        dispatcher.begin(NOW);
        let (mut work, mut effects) = (Waves { left: vec![2], ..Waves::default() }, Vec::new());
        dispatcher.step(0, Event::Poll, &mut work, &mut effects);
        assert_eq!(effects.len(), batches, "{gone:?}: {effects:?}");
        assert_eq!(dispatcher.is_busy(0), batches > 0);
    }
}

#[test]
fn a_log_that_is_exchanged_is_given_back() {
    let queues = Queues { capacity: 4, batch: 4, linger_ns: 0 };
    let mut dispatcher = Dispatcher::new(RoundRobin::default(), queues, Cache::Unlimited, 1);
    assert_eq!(dispatcher.exchange_log(None), None);
    dispatcher.keep_log();
    dispatcher.begin(NOW);
    let (mut work, mut effects) = (Waves { left: vec![3], ..Waves::default() }, Vec::new());
    let who = Incarnation { worker: 0, inc: 0 };
    dispatcher.step(0, Event::Ready(who), &mut work, &mut effects);
    let written = dispatcher.log().to_vec();
    assert_eq!(written.len(), 3);
    assert_eq!(dispatcher.exchange_log(None), Some(written.clone()));
    assert_eq!((dispatcher.log().len(), dispatcher.exchange_log(Some(written.clone()))), (0, None));
    assert_eq!(dispatcher.log(), written);
}
