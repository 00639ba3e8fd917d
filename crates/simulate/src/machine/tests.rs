//! Laws of the machine: the same twice, between its bounds, and every job once.

use super::*;
use crate::trace::TaskTrace;
use proptest::prelude::*;
use protocol::Section;

fn traces() -> impl Strategy<Value = Trace> {
    let job = (0_u32..20, 0_u32..20, 0_u64..2_000, 0_u64..500, 0_u64..50).prop_map(
        |(a, b, nb, np, hits)| {
            let section = |model, node| (Section { model, node }, 100 + 60 * u64::from(node));
            JobTrace { a: section(0, a), b: section(1, b), nb, np, hits }
        },
    );
    let task = (0_u64..500, prop::collection::vec(job, 0..40))
        .prop_map(|(descent_nb, jobs)| TaskTrace { descent_nb, jobs });
    prop::collection::vec(task, 0..8).prop_map(|tasks| Trace { tasks })
}

fn setups() -> impl Strategy<Value = Setup> {
    let matching = prop_oneof![
        (0.0..=1.0).prop_map(Matching::BestMatchLoad),
        any::<u64>().prop_map(Matching::RandomMatch),
        Just(Matching::LowestMatch),
        Just(Matching::RoundRobin),
    ];
    let home = prop_oneof![Just(Home::Own), Just(Home::Shared)];
    let paging = prop::option::of(
        (0_u64..8_000).prop_map(|memory_bytes| Paging { memory_bytes, byte_ns: 0.5 }),
    );
    (1_u8..6, home, matching, (1_u32..80, 1_u32..20, 0_u64..5_000), paging).prop_map(
        |(workers, home, matching, (capacity, batch, linger_ns), paging)| Setup {
            workers,
            home,
            matching,
            queues: Queues { capacity, batch, linger_ns },
            cache: Cache::Unlimited,
            copies: linger_ns % 2 == 0,
            paging,
        },
    )
}

const COSTS: Costs = Costs {
    job_ns: 500.0,
    box_ns: 2.0,
    triangle_ns: 30.0,
    hit_ns: 5.0,
    leaves_ns: 200.0,
    send_ns: 400.0,
    section_byte_ns: 0.05,
    section_ns: 80.0,
    ship_byte_ns: 0.1,
    ship_section_ns: 60.0,
    task_ns: 1_000.0,
    descent_ns: 20.0,
    batch_ns: 500.0,
    place_ns: 40.0,
    take_ns: 300.0,
    fold_hit_ns: 3.0,
    flight_ns: 100.0,
};

proptest! {
    #[test]
    fn time_lies_between_its_bounds_and_comes_out_the_same_twice(
        trace in traces(), setup in setups(),
    ) {
        let outcome = run(&trace, &COSTS, &setup);
        prop_assert_eq!(&outcome, &run(&trace, &COSTS, &setup));
        let jobs = trace.jobs().count() as u64;
        prop_assert_eq!((outcome.counts.jobs, outcome.counts.done), (jobs, jobs));
        let busy: f64 = outcome.busy_ns.iter().sum();
        let kernel: f64 = trace.jobs().map(|j| COSTS.kernel_ns(j.nb, j.np, j.hits)).sum();
        prop_assert!(busy >= kernel * 0.999_999);
        prop_assert!(outcome.time_ns >= busy / f64::from(setup.workers) * 0.999_999);
        prop_assert!(outcome.time_ns >= outcome.coordinator_ns);
        // One after the other, with every message in flight and every batch lingering.
        let waits = 2.0 * jobs as f64 * (COSTS.flight_ns + setup.queues.linger_ns as f64);
        prop_assert!(outcome.time_ns <= busy + outcome.coordinator_ns + waits + 1.0);
    }

    #[test]
    fn what_travels_does_not_grow_with_fewer_cores(trace in traces(), setup in setups()) {
        // One core gets each section once, whatever the scheme.
        let alone = run(&trace, &COSTS, &Setup { workers: 1, ..setup });
        let outcome = run(&trace, &COSTS, &setup);
        prop_assert!(alone.transfer.section_bytes <= outcome.transfer.section_bytes);
        prop_assert!(outcome.transfer.section_bytes <= outcome.transfer.unshared_bytes);
    }
}

proptest! {
    #[test]
    fn memory_that_suffices_changes_nothing_and_less_costs_what_is_swapped(
        trace in traces(), setup in setups(), memory_bytes in 0_u64..8_000,
    ) {
        let ample = run(&trace, &COSTS, &Setup { paging: None, ..setup });
        let most = ample.received.iter().copied().max().unwrap_or(0);
        let paging = |memory_bytes| Some(Paging { memory_bytes, byte_ns: 0.5 });
        let enough = run(&trace, &COSTS, &Setup { paging: paging(most), ..setup });
        prop_assert_eq!(&enough, &ample);
        let short = run(&trace, &COSTS, &Setup { paging: paging(memory_bytes), ..setup });
        let most = short.received.iter().copied().max().unwrap_or(0);
        prop_assert_eq!(short.swapped_bytes > 0, most > memory_bytes);
        prop_assert!((short.swapped_ns - 0.5 * short.swapped_bytes as f64).abs() < 1e-6);
        let sent: u64 = short.received.iter().sum();
        prop_assert_eq!(sent, short.transfer.section_bytes);
    }

    #[test]
    fn a_hard_stop_comes_exactly_where_a_core_would_hold_more(
        trace in traces(), setup in setups(), memory_bytes in 0_u64..8_000,
    ) {
        let ample = run(&trace, &COSTS, &Setup { paging: None, ..setup });
        let cache = Cache::Fixed(memory_bytes);
        let stopped = run(&trace, &COSTS, &Setup { cache, paging: None, ..setup });
        let most = ample.received.iter().copied().max().unwrap_or(0);
        prop_assert_eq!(stopped.thrash.is_some(), most > memory_bytes);
        if stopped.thrash.is_none() {
            prop_assert_eq!(stopped, ample);
        }
    }
}
