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
