//! Invariants of parallel threads: they find what one kernel finds, however often they are
//! interrupted, and never hang.

use super::*;
use crate::fixtures::{
    Found as Truth, Gathered, any_build, body_of, brute_force, directions, kernel_for, named,
    options, pose, soup, task, torus,
};
use body::{Body, Build};
use geometry::{Pose, RelativePose};
use proptest::prelude::*;
use std::cell::Cell;

const QUESTIONS: [Question; 3] = [Question::Touches, Question::Sets, Question::Pairs];

/// What all threads found, in the form used for one kernel.
fn truth(parallel: &Parallel<'_, '_>, task: &Task<'_>, outcome: &Outcome) -> Truth {
    assert_eq!(outcome.end, End::Complete);
    let mut gathered = Gathered::default();
    gathered.add(outcome);
    let heard: Vec<(Side, u32)> = [Side::A, Side::B]
        .into_iter()
        .flat_map(|side| parallel.hits(side).iter().map(move |triangle| (side, *triangle)))
        .collect();
    gathered.hits = named(task, &heard);
    gathered.finish()
}

/// The part of the truth that a question asks for.
fn asked(question: Question, mut truth: Truth) -> Truth {
    let nothing = Gathered::default().finish();
    match question {
        Question::Touches => Truth { pairs: truth.pairs.min(1), ..nothing },
        Question::Sets => Truth { hits: truth.hits, zones: truth.zones, ..nothing },
        Question::Pairs => {
            (truth.hits, truth.listed) = (nothing.hits, nothing.listed);
            truth
        }
    }
}

/// Two interlocked tori and their relative pose: 400 times the tests of [`TESTS_MIN`].
fn chain() -> (Body, Body, RelativePose) {
    let tori = [torus(96, 48, 0.4), torus(80, 40, 0.37)];
    let [a, b] = tori.map(|corners| body_of(&corners, &options(Build::Sah, 4)));
    let turned = Pose::from_degrees(90.0, 70.0, 5.0, [0.6, 0.1, 0.2]);
    (a, b, RelativePose::between(&Pose::IDENTITY, &turned))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn any_number_of_threads_finds_what_brute_force_finds(
        seed in any::<u32>(), size in 0.05_f32..1.5, built in any_build(), leaf_size in 1_u32..65,
        pose in pose(), threads in 0_usize..5,
    ) {
        let soup_body = |seed| body_of(&soup(300, size, seed), &options(built, leaf_size));
        let (a, b) = (soup_body(u64::from(seed)), soup_body(u64::from(seed) + 1));
        let all = brute_force(&a.view(), &b.view(), &pose);
        let directions = directions();
        with(threads, || kernel_for(&a, &b), |parallel| {
            // One question after the other: nothing remains from the previous one.
            for question in QUESTIONS.into_iter().cycle().take(7) {
                let task = task(&a, &b, pose, question, &directions);
                let outcome = parallel.run(&task);
                let found = truth(parallel, &task, &outcome);
                prop_assert_eq!(found, asked(question, all.clone()), "{:?}", question);
            }
            Ok(())
        })?;
    }
}

#[test]
fn who_waits_gets_a_part_and_the_answer_stays_the_same() {
    let (a, b, pose) = chain();
    let directions = directions();
    for question in [Question::Sets, Question::Pairs] {
        let task = task(&a, &b, pose, question, &directions);
        let one = with(
            1,
            || kernel_for(&a, &b),
            |parallel| {
                let outcome = parallel.run(&task);
                assert_eq!(parallel.jobs(), 1);
                truth(parallel, &task, &outcome)
            },
        );
        assert!(one.zones.0 > 0 && one.zones.1 > 0, "they do not meet");
        with(
            3,
            || kernel_for(&a, &b),
            |parallel| {
                let mut parted = 0;
                // When a thread first gets a core is unpredictable.
                for round in 0..100_000 {
                    let outcome = parallel.run(&task);
                    assert_eq!(truth(parallel, &task, &outcome), one, "round {round}");
                    parted += usize::from(parallel.jobs() > 1);
                    if parted == 20 {
                        return;
                    }
                }
                panic!("the work was parted in {parted} of 100000 rounds");
            },
        );
    }
}

#[test]
#[should_panic(expected = "no room for the triangles")]
fn a_panic_of_the_thread_that_asks_ends_all_threads() {
    let (a, b, pose) = chain();
    let directions = directions();
    let task = task(&a, &b, pose, Question::Pairs, &directions);
    with(3, || Kernel::with_room(64, 64, 1, 1), |parallel| parallel.run(&task));
}

#[test]
#[should_panic(expected = "no room for the triangles")]
fn a_panic_of_another_thread_goes_on_in_the_one_that_asks() {
    let (a, b, pose) = chain();
    let directions = directions();
    let task = task(&a, &b, pose, Question::Pairs, &directions);
    let made = Cell::new(0);
    let kernel = || {
        made.set(made.get() + 1);
        // The first is that of the calling thread.
        let triangles = if made.get() == 1 { a.corners.len() } else { 1 };
        Kernel::with_room(64, 64, triangles, triangles)
    };
    with(2, kernel, |parallel| {
        for _ in 0..100_000 {
            parallel.run(&task);
        }
    });
}
