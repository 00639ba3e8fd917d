//! A dry run counts the jobs that there will be, and a pair that is known is not run again.

use super::*;
use crate::fixtures::with;

/// Hashes of the bodies.
fn hashes() -> [String; 4] {
    ["ego", "pole", "suv", "person"].map(str::to_owned)
}

#[test]
fn a_pair_runs_dry_once_and_another_body_again() {
    with(|request, bodies| {
        let mut runs = DryRuns::default();
        let first: Vec<DryPair> =
            runs.of(request, bodies, &hashes()).iter().map(|c| c.pair.clone()).collect();
        // The third candidate passes by; it has no work.
        assert_eq!((first.len(), runs.len()), (3, 3));
        let again = runs.of(request, bodies, &hashes());
        assert!(again.iter().zip(&first).all(|(again, first)| again.pair == first));
        assert_eq!(runs.len(), 3);
        let mut other = hashes();
        other[2] = "another".to_owned();
        assert_eq!(runs.of(request, bodies, &other).len(), 3);
        assert_eq!(runs.len(), 4);
    });
}

#[test]
fn a_dry_run_counts_the_jobs_of_the_deepest_pose() {
    with(|request, bodies| {
        let mut runs = DryRuns::default();
        for candidate in runs.of(request, bodies, &hashes()) {
            let jobs: Vec<u64> = candidate.pair.descents.iter().map(|d| d.jobs).collect();
            // Deeper boxes fit better, so there may be fewer of them in the end.
            assert!(jobs[0] == 1 && jobs[5] > 8, "{jobs:?}");
            let shares: Vec<f64> = candidate.pair.descents.iter().map(|d| d.largest).collect();
            assert!(shares[0] == 1.0 && shares.is_sorted_by(|a, b| a >= b), "{shares:?}");
            assert!(shares[5] * jobs[5] as f64 - 1.0 < 1e-9, "{shares:?}");
            assert!(candidate.stops > 1 && candidate.probes > 1);
        }
    });
}
