//! Invariants of build pools: everything is done once, in order, and no thread is left behind.

use super::{BuildPool, in_threads};
use rayon::ThreadPoolBuilder;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The steps of a build.
fn steps(pool: &BuildPool, round: u64) {
    let each: Vec<u64> = pool.each((0..20).collect(), |i: u64| i * i + round);
    assert!(each.iter().copied().eq((0..20).map(|i| i * i + round)));
    let items: Vec<u64> = (0..3 * round * round).collect();
    let mut mapped = Vec::new();
    pool.map(&items, |i| i + round, &mut mapped);
    assert!(mapped.into_iter().eq(round..round + 3 * round * round));
    assert_eq!(pool.copies(round, items.len()), vec![round; items.len()]);
    let (one, three) = pool.both(|| 1, || pool.three([2, 3, 4], |i| i));
    assert_eq!((one, three), (1, [2, 3, 4]));
}

#[test]
fn a_build_pool_does_everything_once_and_in_order() {
    for threads in [0, 1, 2, 3, 8] {
        // Repeated, since a lead that waits for itself would hang.
        for round in 0..200 {
            BuildPool::with(threads, |pool| {
                assert_eq!(pool.threads(), threads.max(1));
                steps(pool, round);
            });
        }
    }
}

#[test]
fn a_build_pool_is_the_pool_that_it_is_asked_for_in() {
    for threads in [1, 2, 3] {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        for round in 0..200 {
            pool.install(|| {
                BuildPool::with(1, |pool| assert_eq!(pool, &BuildPool::ALONE));
                BuildPool::with(2, |pool| {
                    assert_eq!(pool.threads(), threads);
                    steps(pool, round);
                });
            });
        }
    }
}

#[test]
fn a_panic_ends_the_work_and_nothing_else() {
    let pool = ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    for threads in [1, 2, 3] {
        for _ in 0..20 {
            let fails: [&(dyn Fn() + Sync); 2] =
                [&|| BuildPool::with(threads, |_| assert_eq!(threads, 0, "of the test")), &|| {
                    let check = |i| assert_ne!(i, 2, "of the test");
                    BuildPool::with(threads, |pool| drop(pool.each(vec![1, 2, 3], check)));
                }];
            for work in fails {
                assert!(catch_unwind(AssertUnwindSafe(work)).is_err());
                assert!(catch_unwind(AssertUnwindSafe(|| pool.install(work))).is_err());
            }
            let doubled = || BuildPool::with(threads, |pool| pool.each(vec![1, 2, 3], |i| 2 * i));
            assert_eq!(doubled(), [2, 4, 6]);
            assert_eq!(pool.install(doubled), [2, 4, 6]);
        }
    }
}

#[test]
fn work_is_done_in_as_many_threads_as_are_worth_starting() {
    let threads = || rayon::current_thread_index().map_or(1, |_| rayon::current_num_threads());
    assert_eq!(in_threads(3, 1_000_000, threads), 3);
    assert_eq!(in_threads(3, 10, threads), 1);
    assert_eq!(in_threads(1, 1_000_000, threads), 1);
    // The pool that is there already does it.
    assert_eq!(in_threads(2, 1_000_000, || in_threads(3, 1_000_000, threads)), 2);
}
