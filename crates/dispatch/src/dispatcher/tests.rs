//! The dispatcher against a seeded world that loses, repeats, splits and kills.

use super::*;
use crate::BestMatchLoad;
use proptest::prelude::*;
use std::collections::BTreeMap;

/// Work whose jobs come in waves: a wave is handed out when the one before it is closed.
#[derive(Default)]
struct Waves {
    left: Vec<u32>,
    open: u32,
    next: u32,
    folded: BTreeMap<(u32, u16), u32>,
    closed: BTreeMap<u32, Vec<Closed>>,
    moot: Option<u32>,
}

impl Work for Waves {
    type Part<'p> = u16;

    fn more(&mut self, jobs: &mut Vec<Spec>) {
        if self.open > 0 {
            return;
        }
        let Some(count) = self.left.pop() else { return };
        for _ in 0..count {
            let node = self.next;
            let section = |model| Section { model, node: node % 7 };
            jobs.push(Spec { task: TaskId(node), a: section(0), b: section(1) });
            self.next += 1;
            self.open += 1;
        }
    }
    fn is_moot(&self, task: TaskId) -> bool {
        self.moot.is_some_and(|every| task.0 % every == 1)
    }
    fn fold(&mut self, job: &Spec, part: u16) {
        *self.folded.entry((job.task.0, part)).or_default() += 1;
    }
    fn close(&mut self, job: &Spec, how: Closed) {
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
    dispatcher: Dispatcher<BestMatchLoad>,
    work: Waves,
    queues: BTreeMap<Incarnation, Vec<Held>>,
    late: Vec<Held>,
    inc: u32,
    queues_max: u32,
}

impl World {
    fn carry_out(&mut self, effects: Vec<Effect>) {
        for Effect::Send { to, jobs } in effects {
            let queue = self.queues.entry(to).or_default();
            queue.extend(jobs.into_iter().map(|(job, attempt)| (to, job, attempt)));
            assert!(queue.len() <= self.queues_max as usize, "a queue overflowed");
        }
    }

    fn step(&mut self, event: Event<'_, u16>) -> Progress {
        let mut effects = Vec::new();
        let progress = self.dispatcher.step(event, &mut self.work, &mut effects);
        self.carry_out(effects);
        progress
    }

    fn answer(&mut self, (from, job, attempt): Held, parts: &[(u16, bool)]) -> Progress {
        let mut progress = Progress::Working;
        for &(part, last) in parts {
            progress = self.step(Event::Part { from, job, attempt, part, last, body: part });
        }
        progress
    }

    /// Replaces a worker: what it held is lost, and may come back late.
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

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn every_job_is_closed_exactly_once_whatever_happens(
        waves in prop::collection::vec(1_u32..40, 1..4),
        workers in 1_u8..5,
        (capacity, batch) in (1_u32..12, 1_u32..6),
        moot in prop::option::of(2_u32..6),
        dice in prop::collection::vec((0_u8..12, any::<prop::sample::Index>()), 0..250),
    ) {
        let queues = Queues { capacity, batch };
        let scheme = BestMatchLoad { alpha: 0.5 };
        let jobs: u32 = waves.iter().sum();
        let mut world = World {
            dispatcher: Dispatcher::new(scheme, queues, usize::from(workers)),
            work: Waves { left: waves, moot, ..Waves::default() },
            queues: BTreeMap::new(),
            late: Vec::new(),
            inc: 0,
            queues_max: capacity,
        };
        world.dispatcher.begin();
        let mut progress = Progress::Working;
        for worker in 0..workers {
            let who = Incarnation { worker, inc: 0 };
            world.queues.insert(who, Vec::new());
            progress = world.step(Event::Ready(who));
        }
        let mut kills = 0;
        let mut dice = dice.into_iter();
        while progress != Progress::Finished {
            let busy: Vec<Incarnation> = world.queues.iter()
                .filter(|(_, queue)| !queue.is_empty()).map(|(who, _)| *who).collect();
            prop_assert!(!busy.is_empty(), "jobs are open and nobody holds one");
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
                    world.step(Event::Failed { from, job, attempt })
                }
                6 => {
                    let (to, job, _) = world.queues.get_mut(&who).unwrap().pop().unwrap();
                    world.step(Event::Unsent { to, jobs: &[job] })
                }
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
    let queues = Queues { capacity: 4, batch: 2 };
    let mut dispatcher = Dispatcher::new(BestMatchLoad { alpha: 0.5 }, queues, 2);
    let mut work = Waves { left: vec![3], ..Waves::default() };
    let mut effects = Vec::new();
    dispatcher.begin();
    assert_eq!(dispatcher.step(Event::Poll, &mut work, &mut effects), Progress::Stranded);
    assert!(effects.is_empty());
    let who = Incarnation { worker: 1, inc: 3 };
    assert_eq!(dispatcher.step(Event::Ready(who), &mut work, &mut effects), Progress::Working);
    assert_eq!(effects.len(), 2, "{effects:?}");
}

#[test]
fn a_job_that_takes_two_workers_down_is_abandoned_and_no_other() {
    let queues = Queues { capacity: 4, batch: 4 };
    let mut dispatcher = Dispatcher::new(BestMatchLoad { alpha: 0.0 }, queues, 1);
    let mut work = Waves { left: vec![4], ..Waves::default() };
    dispatcher.begin();
    let mut effects = Vec::new();
    for inc in 0..3 {
        let who = Incarnation { worker: 0, inc };
        dispatcher.step(Event::Ready(who), &mut work, &mut effects);
        let started = Some((JobId(2), inc as u8));
        dispatcher.step(Event::Lost { who, started }, &mut work, &mut effects);
    }
    assert_eq!(dispatcher.counts().abandoned, 1);
    assert_eq!(work.closed, BTreeMap::from([(2, vec![Closed::Abandoned])]));
}
