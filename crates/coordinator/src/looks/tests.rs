//! Looks are handed out as far as there is memory for their paths, a few at a time; what is no
//! answer leaves them open, and what one shows may ask for others.

use super::*;
use crate::fixtures::body;
use crate::gather::{Part, Rest};
use body::{Body, Shape};
use dispatch::JobSource as _;
use executor::encounter::{Encounters, Ways};
use geometry::motion::{MotionPath, Orientation, STATE_WORDS, State};
use protocol::result::{Last, WireSeen};
use protocol::{Summary, launch};

/// Towards the origin, with so many states.
fn path(states: u32) -> MotionPath {
    let state = |number: u32| State {
        time_s: f64::from(number) * 2.0 / f64::from(states - 1),
        position_m: [20.0 - 20.0 * f64::from(number) / f64::from(states - 1), 0.0, 0.0],
        orientation: Orientation::from_degrees(180.0, 0.0, 0.0),
    };
    MotionPath::new(&(0..states).map(state).collect::<Vec<_>>()).expect("sound")
}

fn still() -> MotionPath {
    MotionPath::still([0.0; 3], Orientation::IDENTITY, [0.0, 2.0]).expect("sound")
}

/// A car that stands, and others that come; the last ones are asked for when the first is learnt.
struct Cars<'c> {
    car: &'c Body,
    still: &'c MotionPath,
    paths: &'c [MotionPath],
    next: usize,
    later: usize,
    seen: Vec<Option<Option<LookOutcome>>>,
    encounters: Encounters,
}

impl<'c> Cars<'c> {
    fn new(car: &'c Body, still: &'c MotionPath, paths: &'c [MotionPath], later: usize) -> Self {
        let seen = vec![None; paths.len()];
        Self { car, still, paths, next: 0, later, seen, encounters: Encounters::default() }
    }
}

impl LookSource for Cars<'_> {
    type Id = usize;

    fn next(&mut self) -> Option<usize> {
        let is_there = self.next + self.later < self.paths.len();
        is_there.then(|| {
            self.next += 1;
            self.next - 1
        })
    }

    fn asked(&self, id: usize) -> AskedLook<'_> {
        let ways = Ways { bodies: [self.car.view(); 2], paths: [self.still, &self.paths[id]] };
        let look = Look { ways, from_s: 0.0, end_s: 2.0, resolution_m: 1e-3, may_touch: false };
        AskedLook { models: [0, 0], look }
    }

    fn look(&mut self, id: usize, watch: QueryWatch<'_>) -> Option<(LookOutcome, Counters)> {
        let ways = Ways { bodies: [self.car.view(); 2], paths: [self.still, &self.paths[id]] };
        let look = Look { ways, from_s: 0.0, end_s: 2.0, resolution_m: 1e-3, may_touch: false };
        self.encounters.look(&look, watch).ok()
    }

    fn learn(&mut self, id: usize, seen: Option<LookOutcome>) {
        assert_eq!(self.seen[id], None, "learnt twice");
        self.seen[id] = Some(seen);
        self.later = 0;
    }

    fn use_spare_time(&mut self) -> bool {
        false
    }
}

fn memory() -> WrittenWords {
    WrittenWords::create("test", launch::PATHS_WORDS).expect("there is memory")
}

/// What a worker that looks would send.
fn answer(seen: Option<WireSeen>) -> Last<'static> {
    Last { summary: Summary::default(), supports: None, seen, hits: &[] }
}

fn close<S: LookSource>(run: &mut LookRun<'_, S>, job: &Job, seen: Option<WireSeen>) {
    run.fold(job, PartOf(Part { hits: &[], rest: Rest::NONE, last: Some(answer(seen)) }));
    run.close(job, Closed::Done);
}

#[test]
fn paths_that_do_not_fit_together_go_one_after_the_other() {
    let car = body(Shape::Sedan, 900);
    let bodies = [(car.meta.clone(), car.view())];
    let (still, memory) = (still(), memory());
    let paths = [30_000, 30_001, 30_002, 65_536, 20_000].map(path);
    let mut cars = Cars::new(&car, &still, &paths, 0);
    let mut run = LookRun::of(&mut cars, &bodies, (&memory, 1, None));
    let mut jobs = Vec::new();
    for _ in 0..9 {
        run.more(&mut jobs);
    }
    assert_eq!(jobs.len(), 2, "there is no room for a third");
    // The path that they share is there once.
    assert_eq!(run.memory.used, (2 + 30_000 + 30_001) * STATE_WORDS);
    assert!(run.memory.used <= launch::PATHS_WORDS);
    close(&mut run, &jobs[0], None);
    run.more(&mut jobs);
    assert_eq!(jobs.len(), 2, "the other one may still read its path");
    close(&mut run, &jobs[1], None);
    run.more(&mut jobs);
    assert_eq!((jobs.len(), run.memory.used), (3, (2 + 30_002) * STATE_WORDS));
    run.more(&mut jobs);
    assert_eq!(jobs.len(), 3);
    close(&mut run, &jobs[2], None);
    // No memory is long enough for the fourth path: it is looked at here.
    run.more(&mut jobs);
    assert_eq!((jobs.len(), run.memory.used), (4, (2 + 20_000) * STATE_WORDS));
    run.leave();
    assert!(matches!(cars.seen[3], Some(Some(LookOutcome::Contact(_)))), "{:?}", cars.seen[3]);
    assert_eq!([0, 1, 2, 4].map(|at: usize| cars.seen[at]), [Some(None); 4]);
}

#[test]
fn what_is_no_answer_leaves_a_look_open_and_answers_ask_for_more() {
    let car = body(Shape::Sedan, 900);
    let bodies = [(car.meta.clone(), car.view())];
    let (still, memory) = (still(), memory());
    let paths: [MotionPath; 6] = core::array::from_fn(|_| path(5));
    let mut here = Cars::new(&car, &still, &paths, 1);
    look_here(&mut here, |cars, id| look_until(cars, id, &|| false));
    let met = here.seen[0].flatten().expect("it was looked");
    assert!(matches!(met, LookOutcome::Contact(_)), "{met:?}");
    assert_eq!(here.seen, [Some(Some(met)); 6], "the last one was asked for by the first");
    let mut cars = Cars::new(&car, &still, &paths, 1);
    let mut run = LookRun::of(&mut cars, &bodies, (&memory, 1, None));
    let mut jobs = Vec::new();
    for _ in 0..9 {
        run.more(&mut jobs);
    }
    assert_eq!(jobs.len(), 3, "more would be given to some workers alone");
    let good = met.to_wire();
    let answers = [Some(good), Some(WireSeen { time_s: 9.0, ..good }), None];
    for (job, seen) in jobs.iter().zip(answers) {
        close(&mut run, job, seen);
    }
    // A part that comes twice changes nothing.
    run.fold(&jobs[0], PartOf(Part { hits: &[], rest: Rest::NONE, last: Some(answer(None)) }));
    jobs.clear();
    for _ in 0..9 {
        run.more(&mut jobs);
    }
    assert_eq!(jobs.len(), 3, "two that were left, and the one that was asked for later");
    run.close(&jobs[0], Closed::Abandoned);
    run.leave();
    assert_eq!(cars.seen[0], Some(Some(met)));
    assert_eq!(cars.seen[1..], [Some(None); 5]);
}

#[test]
fn workers_have_as_many_looks_as_last_for_a_while() {
    let out = |took_ns: &[u64]| {
        let mut times = LookTimes::default();
        took_ns.iter().for_each(|took_ns| times.add(*took_ns));
        times.out_per_worker() as u64
    };
    assert_eq!(out(&[]), OUT_LEAST);
    assert_eq!(out(&[0]), OUT_MOST);
    assert_eq!(out(&[OUT_NS / 8; 5]), 8);
    assert_eq!(out(&[OUT_NS / 8, OUT_NS / 8, 2 * OUT_NS / 8]), 6);
    assert_eq!(out(&[u64::MAX, 1]), OUT_LEAST);
}
