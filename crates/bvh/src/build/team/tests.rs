//! Laws of teams: everything is done once, in order, and nobody stays behind.

use super::Team;
use std::panic::{AssertUnwindSafe, catch_unwind};

#[test]
fn a_team_does_everything_once_and_in_order() {
    for threads in [0, 1, 2, 3, 8] {
        let team = Team::of(threads);
        assert_eq!(team.threads(), threads.max(1));
        // The steps of a build, many times over: a lead that waits for itself would hang.
        for round in 0..200_u64 {
            let sum = team.run(|| {
                let each: Vec<u64> = team.each((0..20).collect(), |i: u64| i * i + round);
                assert!(each.iter().copied().eq((0..20).map(|i| i * i + round)));
                let items: Vec<u64> = (0..3 * round * round).collect();
                let mut mapped = Vec::new();
                team.map(&items, |i| i + round, &mut mapped);
                assert!(mapped.into_iter().eq(round..round + 3 * round * round));
                assert_eq!(team.copies(round, items.len()), vec![round; items.len()]);
                let (one, [x, y, z]) = team.both(|| 1, || team.three([2, 3, 4], |i| i));
                each.iter().sum::<u64>() + one + 100 * x + 10 * y + z
            });
            assert_eq!(sum, 2470 + 20 * round + 1 + 234);
        }
    }
}

#[test]
fn a_panic_ends_the_work_and_nothing_else() {
    for threads in [1, 2, 3] {
        let team = Team::of(threads);
        for _ in 0..20 {
            let caught = catch_unwind(AssertUnwindSafe(|| team.run(|| panic!("of the test"))));
            assert!(caught.is_err());
            let caught = catch_unwind(AssertUnwindSafe(|| {
                team.run(|| team.each(vec![1, 2, 3], |i| assert_ne!(i, 2, "of the test")))
            }));
            assert!(caught.is_err());
            assert_eq!(team.run(|| team.each(vec![1, 2, 3], |i| 2 * i)), [2, 4, 6]);
        }
    }
}
