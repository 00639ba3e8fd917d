//! Looks are handed out in parts for which there is memory, a few at a time, and what is no answer
//! leaves them open.

use super::*;
use crate::fixtures::body;
use crate::gather::{Part, Rest};
use body::{Body, Shape};
use dispatch::JobSource as _;
use executor::encounter::Ways;
use geometry::motion::{Orientation, State};
use protocol::Summary;
use protocol::result::{Last, WireSeen};

/// Towards the origin, with so many states.
fn path(states: u32) -> MotionPath {
    let state = |number: u32| State {
        time_s: f64::from(number) * 2.0 / f64::from(states - 1),
        position_m: [20.0 - 20.0 * f64::from(number) / f64::from(states - 1), 0.0, 0.0],
        orientation: Orientation::from_degrees(180.0, 0.0, 0.0),
    };
    MotionPath::new(&(0..states).map(state).collect::<Vec<_>>()).expect("sound")
}

fn asked<'p>(car: &'p Body, paths: [&'p MotionPath; 2]) -> AskedLook<'p> {
    let ways = Ways { bodies: [car.view(); 2], paths };
    let look = Look { ways, from_s: 0.0, end_s: 2.0, resolution_m: 1e-3, may_touch: false };
    AskedLook { models: [0, 0], look }
}

#[test]
fn paths_that_do_not_fit_together_go_one_after_the_other() {
    let car = body(Shape::Sedan, 900);
    let bodies = [(car.meta.clone(), car.view())];
    let still = MotionPath::still([0.0; 3], Orientation::IDENTITY, [0.0, 2.0]).expect("sound");
    let long = [30_000, 30_001, 30_002].map(path);
    let looks: Vec<_> = long.iter().map(|long| asked(&car, [&still, long])).collect();
    let mut idle = || false;
    let first = LookRun::of(&looks, &bodies, (3, None), &mut idle);
    assert_eq!(first.asked.len(), 2);
    // The path that they share is there once.
    assert_eq!(first.words.len(), (2 + 30_000 + 30_001) * STATE_WORDS);
    assert!(first.words.len() <= launch::PATHS_WORDS);
    let rest = LookRun::of(&looks[2..], &bodies, (3, None), &mut idle);
    assert_eq!((rest.asked.len(), rest.words.len()), (1, (2 + 30_002) * STATE_WORDS));
    assert!(looks.iter().all(AskedLook::fits));
    let longest = path(65_536);
    assert!(!asked(&car, [&still, &longest]).fits());
}

#[test]
fn what_is_no_answer_leaves_a_look_open() {
    let car = body(Shape::Sedan, 900);
    let bodies = [(car.meta.clone(), car.view())];
    let still = MotionPath::still([0.0; 3], Orientation::IDENTITY, [0.0, 2.0]).expect("sound");
    let moving = path(5);
    let looks = [asked(&car, [&still, &moving]); 5];
    let here = look_here(&looks, &mut Encounters::default(), None);
    let met = here.seen[0].expect("it was looked");
    assert!(matches!(met, LookOutcome::Contact(_)), "{met:?}");
    let mut idle = || false;
    let mut run = LookRun::of(&looks, &bodies, (3, None), &mut idle);
    let mut jobs = Vec::new();
    for _ in 0..9 {
        run.more(&mut jobs);
    }
    assert_eq!(jobs.len(), 3, "more would be given to some workers alone");
    let good = met.to_wire();
    let answers = [Some(good), Some(WireSeen { time_s: 9.0, ..good }), None];
    for (job, seen) in jobs.iter().zip(answers) {
        let last = Last { summary: Summary::default(), supports: None, seen, hits: &[] };
        run.fold(job, PartOf(Part { hits: &[], rest: Rest::NONE, last: Some(last) }));
        run.close(job, Closed::Done);
    }
    jobs.clear();
    run.more(&mut jobs);
    assert_eq!(jobs.len(), 1);
    assert_eq!(run.seen, [Some(met), None, None, None, None]);
}
