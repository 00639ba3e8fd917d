//! A complete answer is a pure function of bodies, scenario, policy and curves: the same bytes for
//! any number of workers, scheme, depth, build, leaf size, buffers and cache, and without workers;
//! by the program and by the library.

use crate::support::{self, Place, answer, builder, json, library_answer, overrides, run, ways};
use trolley::dispatch_options::{DispatchOptions, TransferMode};
use trolley::{Engine, EngineBuilder, Limits, Scenario};

/// Ranks a file with these options.
fn ranked(path: &str, args: &[&str]) -> std::process::Output {
    let mut all = vec!["rank", path, "--json"];
    all.extend(args);
    let output = run(&all);
    assert!(output.status.success(), "{args:?}: {}", support::text(&output.stderr));
    output
}

// verifies REQ-SAME-ANSWER
#[test]
fn the_answer_does_not_depend_on_how_the_work_was_done() {
    let place = Place::new();
    let path = place.write("ways.toml", &ways(2000));
    let path = path.to_str().unwrap();
    let answer_of = |args: &[&str]| ranked(path, args);
    let reference = answer_of(&["--in-process"]);
    let document = json(&reference);
    let reference = answer(&reference);
    assert!(reference.contains("\"pairs\""), "nothing was hit: {reference}");
    let ways: &[&[&str]] = &[
        &["--workers", "1"],
        &["--workers", "3"],
        &["--workers", "4"],
        &["--depth", "0"],
        &["--depth", "12"],
        &["--budget", "38000", "--depth", "2"],
        &["--build", "sah"],
        &["--build", "literal"],
        &["--leaf-size", "1"],
        &["--batch", "1", "--queue", "1"],
        &["--in-process", "--depth", "0", "--build", "sah"],
    ];
    for way in ways {
        assert_eq!(answer(&answer_of(way)), reference, "{way:?}");
    }
    // As text as well: parsing a number may round it.
    let scenario = Scenario::open(path).unwrap();
    let mut engine = Engine::builder().in_process().build().unwrap();
    let by_library = library_answer(&mut engine, &scenario, &Limits::default());
    let read: serde_json::Value = serde_json::from_str(&by_library).unwrap();
    assert_eq!(read, document["answer"], "the library and the program");
}

#[test]
fn the_answer_to_an_example_does_not_depend_on_how_the_work_was_done() {
    let place = Place::new();
    let crossing = "../../config/scenarios/crossing.toml";
    let text = std::fs::read_to_string(crossing).unwrap();
    let path = place.write("crossing.toml", &text.replace("0000", "000"));
    let path = path.to_str().unwrap();
    let answer_of = |args: &[&str]| ranked(path, args);
    let reference = answer_of(&["--in-process"]);
    let document = json(&reference);
    let reference = answer(&reference);
    assert!(reference.contains("\"excluded_before_s\""), "nobody was met: {reference}");
    let ways: &[&[&str]] = &[
        &["--workers", "1"],
        &["--workers", "2"],
        &["--workers", "4"],
        &["--depth", "1"],
        &["--depth", "8"],
        &["--build", "sah"],
        &["--build", "literal"],
        &["--leaf-size", "1"],
        &["--leaf-size", "64"],
        &["--batch", "1", "--queue", "1"],
        &["--deadline-ms", "60000"],
        &["--in-process", "--depth", "0", "--build", "sah"],
    ];
    for way in ways {
        assert_eq!(answer(&answer_of(way)), reference, "{way:?}");
    }
    // As text as well: parsing a number may round it.
    let scenario = Scenario::open(path).unwrap();
    let mut engine = Engine::builder().in_process().build().unwrap();
    for _ in 0..2 {
        let ranking = engine.rank(&scenario, &Limits::default()).unwrap();
        let by_library = serde_json::to_value(&ranking.answer).unwrap();
        assert_eq!(by_library, document["answer"], "the library and the program");
    }
}

#[test]
fn the_librarys_answer_does_not_depend_on_how_jobs_were_handed_out() {
    let place = Place::new();
    let path = place.write("ways.toml", &ways(2000));
    let scenario = Scenario::open(path).unwrap();
    let answer_of = |builder: EngineBuilder| {
        library_answer(&mut builder.build().unwrap(), &scenario, &Limits::default())
    };
    let reference = answer_of(Engine::builder().in_process());
    let scheme = |name: &str, alpha: f64, queue: i64| {
        builder().overrides(overrides(|all| {
            (all.scheme, all.alpha) = (Some(name.to_owned()), Some(alpha));
            (all.batch, all.queue) = (Some(queue.min(3)), Some(queue));
            all.seed = Some(7);
        }))
    };
    let copy = |memory_budget| DispatchOptions {
        transfer: TransferMode::Copy,
        memory_budget: Some(memory_budget),
        ..DispatchOptions::default()
    };
    let linger = |linger_us| DispatchOptions { linger_us, ..DispatchOptions::default() };
    let cache = DispatchOptions { cache_bytes: Some(100_000), ..DispatchOptions::default() };
    let ways = [
        ("load alone, unpinned", scheme("best-match-load", 0.0, 16)),
        ("match alone", scheme("best-match-load", 1.0, 16)),
        ("best", scheme("best-match", 0.5, 16)),
        ("random", scheme("random-match", 0.5, 16)),
        ("lowest, lingering", scheme("lowest-match", 0.5, 16).dispatch_options(linger(200))),
        ("in turn, lingering", scheme("round-robin", 0.5, 5).dispatch_options(linger(50))),
        ("a small cache", builder().dispatch_options(cache)),
        ("copies", builder().dispatch_options(copy(9_000_000))),
        ("copies, lowest", scheme("lowest-match", 0.5, 16).dispatch_options(copy(9_000_000))),
        ("copies, two workers", builder().workers(2).depth(3).dispatch_options(copy(9_000_000))),
    ];
    for (name, way) in ways {
        assert_eq!(answer_of(way), reference, "{name}");
    }
}

// verifies REQ-SAME-ANSWER
#[test]
fn an_engine_that_is_kept_answers_as_a_new_one_does() {
    let place = Place::new();
    let scenarios = [ways(1200), ways(900), ways(1200)].map(|text| {
        let path = place.write("next.toml", &text);
        Scenario::open(path).unwrap()
    });
    let limits = Limits::default();
    let new = || Engine::builder().in_process().build().unwrap();
    let expected = scenarios.each_ref().map(|one| library_answer(&mut new(), one, &limits));
    let workers = builder().workers(2);
    for mut kept in [new(), workers.build().unwrap()] {
        for (scenario, expected) in scenarios.iter().zip(&expected) {
            // Twice: the second time bodies, workers and workspace are those of the first.
            for turn in 0..2 {
                assert_eq!(library_answer(&mut kept, scenario, &limits), *expected, "{turn}");
            }
        }
    }
}

/// Workers without work call the thread that ranks to their cores, where it has none for itself.
#[test]
fn a_thread_that_ranks_may_run_afterwards_where_it_could_before() {
    let place = Place::new();
    let scenario = Scenario::open(place.write("next.toml", &ways(1200))).unwrap();
    let cores = runtime::affinity::allowed_cores();
    let mut engine = builder().workers(cores.len()).build().unwrap();
    for turn in 0..5 {
        engine.rank(&scenario, &Limits::default()).unwrap();
        // The last call may not be over yet.
        let end_ns = runtime::clock::now_ns() + 5_000_000_000;
        while runtime::affinity::allowed_cores() != cores {
            assert!(runtime::clock::now_ns() < end_ns, "turn {turn}");
        }
    }
}
