//! Laws of advice: small work stays in one piece, large work is cut, and no advised time is longer
//! than that of any dry run.

use super::*;
use proptest::prelude::*;

fn costs() -> Costs {
    Costs {
        job_ns: 600.0,
        send_ns: 1_000.0,
        task_ns: 1_000.0,
        descent_ns: 45.0,
        batch_ns: 1_600.0,
        place_ns: 400.0,
        take_ns: 700.0,
        fold_hit_ns: 12.0,
        flight_ns: 340.0,
        ..Costs::default()
    }
}

/// Workers and a coordinator with a core of its own.
fn team(workers: usize) -> Team {
    Team { workers, cores: workers + 1, queues: Queues { capacity: 16, batch: 4, linger_ns: 0 } }
}

/// Work that falls into four times as many jobs every two levels.
fn dry(depth: u32, kernel_ns: f64) -> DryRun {
    let jobs = 16.0 * 2.0_f64.powi(depth as i32);
    DryRun {
        depth,
        tasks: 16.0,
        jobs,
        descent_nb: 4.0 * jobs,
        kernel_ns: kernel_ns + 600.0 * jobs,
        largest_ns: 4.0 * kernel_ns / jobs,
        hits: 100.0,
    }
}

proptest! {
    #[test]
    fn advice_is_the_best_of_what_is_predicted(
        kernel_ns in 1e3..1e9, workers in 1_usize..9, deepest in 4_u32..12,
    ) {
        let runs = [0, 2, 4].map(|depth| dry(depth, kernel_ns));
        let advice = advise(&runs, &costs(), &team(workers), 0..=deepest).unwrap();
        prop_assert!(advice.depth <= deepest);
        for run in runs {
            let ns = run.time_ns(&costs(), &team(workers));
            prop_assert!(advice.predicted_ns <= ns * 1.000_001, "{advice:?} {ns}");
        }
        prop_assert_eq!(advice.distribute, advice.predicted_ns < advice.whole_ns);
    }

    #[test]
    fn no_team_is_quicker_than_its_work_shared_evenly_nor_slower_than_one_after_the_other(
        depth in 0_u32..8, kernel_ns in 1e3..1e9, workers in 1_usize..9, spare in 0_usize..2,
    ) {
        let (run, costs) = (dry(depth, kernel_ns), costs());
        let team = Team { cores: workers + spare, ..team(workers) };
        let ns = run.time_ns(&costs, &team);
        let alone = Team { workers: 1, cores: 1, ..team };
        prop_assert!(ns >= run.kernel_ns / workers as f64);
        prop_assert!(ns <= run.time_ns(&costs, &alone) * 1.000_001);
    }

    #[test]
    fn leaves_are_counted_between_the_last_descent_and_all_pairs(
        jobs in prop::collection::vec(1_u64..5_000, 2..6), levels in 0.0..20.0,
    ) {
        let descent = |(at, jobs): (usize, &u64)| Descent {
            depth: 2 * at as u32, nb: 0, jobs: *jobs, largest: 1.0,
        };
        let descents: Vec<_> = jobs.iter().enumerate().map(descent).collect();
        let found = leaf_pairs(&descents, levels);
        let (last, deepest) = (jobs[jobs.len() - 1] as f64, 2.0 * (jobs.len() as f64 - 1.0));
        let below = (levels - deepest).max(0.0);
        prop_assert!(found >= last && found <= last * 4.0_f64.powf(below) * 1.000_001);
    }

    #[test]
    fn more_work_is_not_cut_coarser(kernel_ns in 1e4..1e8) {
        let depth = |kernel_ns: f64| {
            let runs = [0, 4, 8].map(|depth| dry(depth, kernel_ns));
            advise(&runs, &costs(), &team(4), 0..=10).unwrap().depth
        };
        prop_assert!(depth(kernel_ns) <= depth(8.0 * kernel_ns));
    }
}

#[test]
fn a_little_work_stays_in_one_piece_and_much_is_cut() {
    let advice = |kernel_ns: f64| {
        let one = |depth: u32| DryRun { tasks: 1.0, ..dry(depth, kernel_ns) };
        let piece = DryRun { jobs: 1.0, kernel_ns, largest_ns: kernel_ns, ..one(0) };
        advise(&[piece, one(3), one(6)], &costs(), &team(4), 0..=8).unwrap()
    };
    assert!(!advice(2_000.0).distribute);
    let much = advice(1e8);
    assert!(much.distribute && much.depth > 0 && much.predicted_ns < 0.4 * much.whole_ns);
    assert_eq!(advise(&[dry(0, 1e6)], &costs(), &team(4), 0..=8), None);
}
