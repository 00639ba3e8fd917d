//! Whoever helps, the results are those of one thread.

use super::*;

#[test]
fn what_is_shared_comes_back_in_order_however_many_help() {
    let here = affinity::allowed_cores()[0];
    // One core that nobody has: its helper runs anywhere.
    for cores in [&[][..], &[None], &[Some(here), None, Some(usize::MAX)]] {
        for count in [0, 1, 2, 1_000] {
            let mut scratch = 0_u64;
            let squares = IdleCores::of(cores, 2, false).map(&mut scratch, count, |used, k| {
                *used += 1;
                k * k
            });
            assert!(squares.iter().enumerate().all(|(k, square)| *square == k * k));
            assert_eq!(squares.len(), count);
            assert!(scratch <= count as u64);
        }
    }
    assert!(affinity::allowed_cores().contains(&here), "the caller stays where it was");
}

#[test]
fn nothing_comes_back_once_there_is_no_time() {
    let virtual_ones = IdleCores::virtual_ones((2, false), 0, Arc::default());
    for cores in [IdleCores::default(), IdleCores::of(&[None; 2], 2, false), virtual_ones] {
        for count in [0, 1, 2, 50] {
            for over_at in 0..=count + 1 {
                let mut asked = 0;
                let mut goes_on = || {
                    asked += 1;
                    asked <= over_at
                };
                let all = cores.map_while(&mut (), count, &mut goes_on, |(), k| k + 1);
                let is_done = over_at >= count;
                assert_eq!(all, is_done.then(|| (1..=count).collect()), "{over_at} of {count}");
                // Whoever does what, the clock is asked as often, so a replay ends at the same.
                assert_eq!(asked, if is_done { count } else { over_at + 1 });
            }
        }
    }
}

#[test]
fn nobody_helps_whose_worker_is_at_work() {
    let cores = IdleCores::of(&[None; 4], 3, true);
    let threads = |busy: usize| cores.without(busy).threads();
    assert_eq!([0, 1, 2, 3, 4, usize::MAX].map(threads), [4, 3, 2, 1, 1, 1]);
    assert_eq!(IdleCores::of(&[None; 2], 3, false).threads(), 3);
}

#[test]
fn a_panic_of_a_helper_is_one_of_the_caller() {
    let panics = std::panic::catch_unwind(|| {
        IdleCores::of(&[None], 1, false).map(&mut (), 100, |(), k| assert!(k < 50));
    });
    assert!(panics.is_err());
}

#[test]
fn virtual_helpers_spare_what_they_do_while_the_caller_works() {
    let help = |thread_ns: u64, threads: usize, took_ns: &[u64]| {
        let VirtualHelp { spared_ns, done_ns } =
            VirtualHelpers { thread_ns, helped: Arc::default() }.help(threads, took_ns);
        (spared_ns, done_ns.to_vec())
    };
    assert_eq!(help(0, 1, &[5, 5, 5]), (0, vec![]));
    assert_eq!(help(0, 3, &[5, 5, 5]), (10, vec![5, 5]));
    assert_eq!(help(0, 2, &[4, 1, 1, 1, 1]), (4, vec![4]));
    assert_eq!(help(2, 2, &[4, 4]), (2, vec![4]));
    // They are waited for, though all is done when they begin.
    assert_eq!(help(100, 4, &[5, 5]), (0, vec![0, 0, 0]));
    let helped = Arc::new(Mutex::new(VirtualHelp::default()));
    let cores = IdleCores::virtual_ones((2, true), 0, Arc::clone(&helped));
    assert_eq!((cores.threads(), cores.map(&mut (), 4, |(), k| 2 * k)), (2, vec![0, 2, 4, 6]));
}
