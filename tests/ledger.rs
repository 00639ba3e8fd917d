//! The transfer ledger of a real run equals what follows from its job log, recomputed here with a
//! plain list per core; and the log names each job's sections with the weight that its trees give.

mod support;

use std::collections::BTreeMap;
use support::{Place, json, run, six, text};

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
    let path = place.write("six.toml", &six(2000));
    let log = place.path().join("log.csv");
    let ways: &[(&[&str], u64)] = &[
        (&[], u64::MAX),
        (&["--scheme", "lowest-match", "--workers", "3"], u64::MAX),
        (&["--scheme", "best-match", "--cache-bytes", "90000"], 90_000),
        (&["--scheme", "random-match", "--cache-bytes", "70000", "--linger", "20"], 70_000),
    ];
    for (way, capacity) in ways {
        let mut args = vec!["rank", path.to_str().unwrap(), "--json", "--depth", "6"];
        args.extend(["--job-log", log.to_str().unwrap()]);
        args.extend(*way);
        let output = run(&args);
        assert!(output.status.success(), "{way:?}: {}", text(&output.stderr));
        let document = json(&output);
        let sum = |key: &str| document["run"][key].as_u64().unwrap();
        let ledger = (sum("section_bytes"), sum("section_bytes_unshared"), sum("sections_evicted"));
        let log = std::fs::read_to_string(&log).unwrap();
        assert_eq!(ledger, recomputed(&log, *capacity), "{way:?}");
        assert!(ledger.0 > 0 && ledger.0 < ledger.1, "{way:?}: {ledger:?}");
        assert_eq!(ledger.2 > 0, *capacity < u64::MAX, "{way:?}: {ledger:?}");
        for worker in document["run"]["workers"].as_array().unwrap() {
            let hardware = &worker["hardware"];
            let counted = hardware["instructions"].as_u64().is_some_and(|n| n > 0);
            let says_why = hardware.as_str().is_some_and(|why| why.starts_with("not available: "));
            assert!(counted || says_why, "{worker}");
        }
        let assigned = log.lines().filter(|line| line.starts_with("assigned")).count() as u64;
        let ran = sum("jobs") - sum("jobs_cut") + sum("jobs_reissued");
        assert_eq!(assigned, ran, "{way:?}");
    }
}
