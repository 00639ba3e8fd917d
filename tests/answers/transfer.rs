//! The transfer ledger of a real run equals what follows from its job log, recomputed here with a
//! plain list per core; and the log names each job's sections with the weight that its trees give.

use crate::support::{Place, builder, overrides, ways};
use coordinator::Hardware;
use std::collections::BTreeMap;
use trolley::dispatch_options::{DispatchOptions, log_csv};
use trolley::{Limits, Scenario};

/// Bytes transferred, bytes if nothing were held, sections evicted.
type Sums = (u64, u64, u64);

/// A section: body, node, and what it weighs (bytes).
type Section = (u64, u64, u64);

fn recomputed(log: &str, capacity: u64) -> Sums {
    let read = |field: &str| field.parse::<u64>().expect("a number");
    let mut held: BTreeMap<u64, Vec<Section>> = BTreeMap::new();
    let (mut moved, mut unshared, mut evicted) = (0, 0, 0);
    for line in log.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |at: usize| read(fields[at]);
        let list = held.entry(number(3)).or_default();
        match fields[0] {
            "lost" => list.clear(),
            "assigned" => {
                for at in [5, 8] {
                    let section = (number(at), number(at + 1), number(at + 2));
                    unshared += section.2;
                    match list.iter().position(|known| *known == section) {
                        Some(at) => drop(list.remove(at)),
                        None => moved += section.2,
                    }
                    list.push(section);
                    while list.iter().map(|known| known.2).sum::<u64>() > capacity {
                        list.remove(0);
                        evicted += 1;
                    }
                }
            }
            other => panic!("{other}"),
        }
    }
    (moved, unshared, evicted)
}

#[test]
fn the_ledger_equals_its_recomputation_from_the_job_log() {
    let place = Place::new();
    // So short that no way has a second contact: the log is that of the last round of contacts.
    let text = ways(2000).replacen("horizon_s = 3", "horizon_s = 1.3", 1);
    let scenario = Scenario::open(place.write("ways.toml", &text)).unwrap();
    let dispatch_options = |linger_us, cache_bytes| DispatchOptions {
        linger_us,
        cache_bytes,
        log: true,
        ..DispatchOptions::default()
    };
    let ways = [
        ("best-match-load", 4, dispatch_options(0, None)),
        ("lowest-match", 3, dispatch_options(0, None)),
        ("best-match", 4, dispatch_options(0, Some(90_000))),
        ("random-match", 4, dispatch_options(20, Some(70_000))),
    ];
    for (scheme, workers, dispatch_options) in ways {
        let settings = overrides(|all| {
            all.scheme = Some(scheme.to_owned());
            (all.workers, all.depth) = (Some(workers), Some(6));
        });
        let mut engine =
            builder().overrides(settings).dispatch_options(dispatch_options).build().unwrap();
        let run = engine.rank(&scenario, &Limits::default()).unwrap().run;
        let ledger = (run.section_bytes, run.section_bytes_unshared, run.sections_evicted);
        let log = log_csv(engine.job_log());
        let capacity = dispatch_options.cache_bytes.unwrap_or(u64::MAX);
        assert_eq!(ledger, recomputed(&log, capacity), "{scheme}");
        assert!(ledger.0 > 0 && ledger.0 < ledger.1, "{scheme}: {ledger:?}");
        assert_eq!(ledger.2 > 0, capacity < u64::MAX, "{scheme}: {ledger:?}");
        for worker in &run.workers {
            let is_told = match &worker.hardware {
                Hardware::Counted { instructions, .. } => *instructions > 0,
                Hardware::NotAvailable(why) => why.starts_with("not available: "),
            };
            assert!(is_told, "{worker:?}");
        }
        let assigned = log.lines().filter(|line| line.starts_with("assigned")).count() as u64;
        assert_eq!(assigned, run.jobs - run.jobs_cut + run.jobs_reissued, "{scheme}");
    }
}
