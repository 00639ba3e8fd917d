//! Whoever helps, the results are those of one thread.

use super::*;

#[test]
fn what_is_shared_comes_back_in_order_however_many_help() {
    let here = affinity::allowed_cores()[0];
    // One core that nobody has: its helper runs anywhere.
    for cores in [&[][..], &[None], &[Some(here), None, Some(usize::MAX)]] {
        for count in [0, 1, 2, 1_000] {
            let mut scratch = 0_u64;
            let squares = IdleCores::of(cores).map(&mut scratch, count, |used, k| {
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
fn a_panic_of_a_helper_is_one_of_the_caller() {
    let panics = std::panic::catch_unwind(|| {
        IdleCores::of(&[None]).map(&mut (), 100, |(), k| assert!(k < 50));
    });
    assert!(panics.is_err());
}

#[test]
fn virtual_helpers_spare_what_they_do_while_the_caller_works() {
    let spared = |thread_ns: u64, threads: usize, took_ns: &[u64]| {
        VirtualHelpers { thread_ns, spared_ns: Arc::default() }.spared_ns(threads, took_ns)
    };
    assert_eq!(spared(0, 1, &[5, 5, 5]), 0);
    assert_eq!(spared(0, 3, &[5, 5, 5]), 10);
    assert_eq!(spared(0, 2, &[4, 1, 1, 1, 1]), 4);
    assert_eq!(spared(2, 2, &[4, 4]), 2);
    // They are waited for, though all is done when they begin.
    assert_eq!(spared(100, 4, &[5, 5]), 0);
    let spared_ns = Arc::new(AtomicU64::new(0));
    let cores = IdleCores::virtual_ones(2, 0, Arc::clone(&spared_ns));
    assert_eq!((cores.threads(), cores.map(&mut (), 4, |(), k| 2 * k)), (2, vec![0, 2, 4, 6]));
}
