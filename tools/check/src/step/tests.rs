//! Closing lines are found and added up; a step that fails passes its exit code on.

use super::*;

#[test]
fn closing_lines_and_nothing_else_are_counted() {
    let said = "\
     Running unittests src/lib.rs (target/debug/deps/bvh-0123456789abcdef)

running 4 tests
test a::test result: ok ... ok
test result: ok. 3 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.00s
test result: FAILED. 10 passed; 2 failed; 0 ignored; 0 measured; 5 filtered out; finished in 1.2s
test result: I made this up
";
    let mut sum = TestTally::default();
    for tally in said.lines().filter_map(TestTally::of) {
        sum.add(&tally);
    }
    assert_eq!(sum, TestTally { runners: 2, passed: 13, failed: 2, ignored: 1 });
    assert_eq!(sum.to_string(), "2 runners: 13 passed, 2 failed, 1 ignored");
}

#[test]
fn a_good_step_is_one_line() -> Result<()> {
    let step = CheckStep::cargo("version", &["--version"]);
    let mut out = Vec::new();
    assert!(step.run(&mut out)?.failure().is_none());
    let said = String::from_utf8(out)?;
    assert!(said.starts_with("version cargo --version ... ok "), "{said}");
    assert!(said.ends_with(" s\n") && said.lines().count() == 1, "{said}");
    Ok(())
}

#[test]
fn a_bad_step_shows_what_was_said_and_passes_its_exit_code_on() -> Result<()> {
    let step = CheckStep::cargo("bad", &["no-such-command-as-this"]);
    let mut out = Vec::new();
    let failure = step.run(&mut out)?.failure();
    // Cargo's own exit code for whatever it cannot do.
    assert_eq!(format!("{failure:?}"), format!("{:?}", Some(ExitCode::from(101))));
    let said = String::from_utf8(out)?;
    assert!(said.contains("FAILED"), "{said}");
    assert!(said.contains("\nerror: no such command"), "{said}");
    Ok(())
}

/// A cargo that finds the target directory locked says so on a line of its own.
#[test]
fn a_step_that_waits_for_another_cargo_says_so() -> Result<()> {
    let package = tempfile::tempdir()?;
    std::fs::create_dir(package.path().join("src"))?;
    std::fs::write(package.path().join("src/lib.rs"), "")?;
    let manifest = "[package]\nname = \"empty\"\nversion = \"0.1.0\"\n[workspace]\n";
    std::fs::write(package.path().join("Cargo.toml"), manifest)?;
    let target = package.path().join("target");
    let in_package = |command: &mut Command| {
        command.current_dir(package.path()).env("CARGO_TARGET_DIR", &target);
    };
    let step = CheckStep::cargo("check", &["check", "--offline"]);
    let mut out = Vec::new();
    assert!(step.run_with(in_package, &mut out)?.failure().is_none());
    assert!(!String::from_utf8(out)?.contains("waits"), "nobody holds the lock");

    // As another cargo holds it.
    let lock = std::fs::File::open(target.join("debug/.cargo-lock"))?;
    lock.lock()?;
    let (reader, mut writer) = io::pipe()?;
    let held = std::thread::scope(|scope| {
        let stepped = scope.spawn(move || step.run_with(in_package, &mut writer).map(drop));
        let mut said = String::new();
        let mut lines = BufReader::new(reader);
        while !said.contains("waits for another cargo") && lines.read_line(&mut said)? > 0 {}
        lock.unlock()?;
        lines.read_line(&mut said)?;
        stepped.join().expect("no panic").map(|()| said)
    })?;
    assert!(held.contains("waits for another cargo, which holds the lock of the "), "{held}");
    assert!(held.lines().last().is_some_and(|line| line.starts_with("check   ok ")), "{held}");
    Ok(())
}

#[test]
fn a_step_sees_its_own_environment_beside_ours() -> Result<()> {
    // A wrong setting of cargo makes it fail, so it must have arrived.
    let step =
        CheckStep { env: &[("CARGO_TERM_COLOR", "mauve")], ..CheckStep::cargo("env", &["help"]) };
    let mut out = Vec::new();
    assert!(step.run(&mut out)?.failure().is_some());
    assert!(String::from_utf8(out)?.contains("mauve"));
    Ok(())
}

#[test]
fn what_a_test_leaves_out_is_found_wherever_its_line_begins() {
    assert_eq!(skipped("SKIPPED: a browser\n"), Some("SKIPPED: a browser\n"));
    assert_eq!(skipped("test a::b ... SKIPPED: a browser\n"), Some("SKIPPED: a browser\n"));
    assert_eq!(skipped("test nothing_is_skipped ... ok\n"), None);
}
