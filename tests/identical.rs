//! A complete answer is a pure function of bodies, scenario, policy and curves: the same bytes for
//! any number of workers, scheme, depth, build, leaf size, buffers and cache, and without workers.

mod support;

use support::{Place, answer, run, six};

#[test]
fn the_answer_does_not_depend_on_how_the_work_was_done() {
    let place = Place::new();
    let path = place.write("six.toml", &six(2000));
    let path = path.to_str().unwrap();
    let of = |args: &[&str]| {
        let mut all = vec!["rank", path, "--json"];
        all.extend(args);
        let output = run(&all);
        assert!(output.status.success(), "{args:?}: {}", support::text(&output.stderr));
        answer(&output)
    };
    let reference = of(&["--in-process"]);
    assert!(reference.contains("\"pairs\""), "nothing was hit: {reference}");
    let ways: &[&[&str]] = &[
        &["--workers", "1"],
        &["--workers", "2"],
        &["--workers", "3"],
        &["--workers", "4"],
        &["--depth", "0"],
        &["--depth", "4"],
        &["--depth", "12"],
        &["--pursuit", "deciding"],
        &["--budget", "38000", "--depth", "2"],
        &["--build", "sah"],
        &["--build", "literal"],
        &["--leaf-size", "1"],
        &["--batch", "1", "--queue", "1"],
        &["--alpha", "1"],
        &["--scheme", "best-match", "--queue", "16"],
        &["--scheme", "random-match", "--seed", "7"],
        &["--scheme", "lowest-match", "--linger", "200"],
        &["--scheme", "round-robin", "--batch", "3", "--queue", "5", "--linger", "50"],
        &["--cache-bytes", "100000"],
        &["--transfer", "copy", "--memory-budget", "9000000"],
        &["--transfer", "copy", "--memory-budget", "9000000", "--scheme", "lowest-match"],
        &["--transfer", "copy", "--memory-budget", "9000000", "--depth", "3", "--queue", "16"],
        &["--alpha", "0", "--cores", "none"],
        &["--in-process", "--depth", "0", "--build", "sah"],
    ];
    for way in ways {
        assert_eq!(of(way), reference, "{way:?}");
    }
}
