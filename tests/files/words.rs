//! The command line's words: names of flags, the standard input, full disks, little memory.

use crate::support::{Place, run, text, trolley};
use std::process::{Command, Stdio};

#[test]
fn flags_are_named_as_they_are_written() {
    for (cores, says, help) in [
        ("9", "--cores lists 1 of them for 4 workers", "--cores none"),
        ("a,b", "--cores a,b: not a list of core numbers", "--cores 0,1,2,3"),
        ("0,9999,1,2", "9999", "--cores"),
    ] {
        let refused = run(&["demo", "--cores", cores]);
        let error = text(&refused.stderr);
        assert_eq!(refused.status.code(), Some(78), "{error}");
        assert!(error.contains(says) && error.contains(help), "{error}");
        assert!(!error.contains("cores = ["), "{error}");
    }
}

#[test]
fn a_key_that_stands_twice_is_named() {
    let place = Place::new();
    let twice = "schema = \"trolley.scenario/2\"\nname = \"a\"\nname = \"b\"\n";
    let file = place.write("twice.toml", twice);
    let error = text(&run(&["rank", file.to_str().unwrap()]).stderr);
    assert!(error.contains("twice.toml:3:1: \"name\" stands here a second time"), "{error}");
    let file = place.write("policy.toml", "schema = 1\nname = \"a\"\nname = \"b\"\n");
    let checked = trolley().args(["policy", "check"]).arg(file).output().unwrap();
    let error = text(&checked.stderr);
    assert!(error.contains("policy.toml:3:1: \"name\" stands here a second time"), "{error}");
}

#[test]
fn a_scenario_comes_on_the_standard_input() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/examples/crash.toml");
    let ranked = |file: &str, input: Stdio| {
        let args = ["rank", file, "--in-process", "--json"];
        let output = trolley().args(args).stdin(input).output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        crate::support::answer(&output)
    };
    let piped = ranked("-", std::fs::File::open(file).unwrap().into());
    assert_eq!(piped, ranked(file, Stdio::null()));

    let refused = trolley().args(["rank", "-"]).output().unwrap();
    let error = text(&refused.stderr);
    assert_eq!(refused.status.code(), Some(65), "{error}");
    assert!(error.contains("-:1:1: schema is missing"), "{error}");
}

#[test]
fn help_on_a_full_disk_is_an_error() {
    for args in [&["--help"][..], &["--version"], &["rank", "--help"], &["help", "keys"]] {
        let full = std::fs::File::create("/dev/full").unwrap();
        let ended = trolley().args(args).stdout(full).output().unwrap();
        let error = text(&ended.stderr);
        assert_eq!(ended.status.code(), Some(71), "{args:?}: {error}");
        assert!(error.contains("cannot write the output"), "{error}");
    }
}

/// Wherever the limit of memory lies, it ends with an answer, or with an exit code that says why.
#[test]
fn little_memory_is_no_abort() {
    let program = env!("CARGO_BIN_EXE_trolley");
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/examples/crash.toml");
    let limited = |kilobytes: u32, args: &str| {
        let script = format!("ulimit -v {kilobytes}; exec {program} {args}");
        Command::new("bash").args(["-c", &script]).output().unwrap()
    };
    // Below, the system cannot even start the program.
    let starts = |kilobytes: &u32| limited(*kilobytes, "--version").status.success();
    let least = (20_000..200_000).step_by(1_000).find(starts).unwrap();
    let mut refused = 0;
    for kilobytes in (least..least + 10_000).step_by(1_000) {
        let ended = limited(kilobytes, &format!("rank {file} --in-process"));
        let error = text(&ended.stderr);
        let code = ended.status.code();
        assert!(matches!(code, Some(0 | 69 | 71)), "{kilobytes} kB: {:?} {error}", ended.status);
        assert!(code == Some(0) || error.starts_with("error: "), "{kilobytes} kB: {error}");
        refused += usize::from(code != Some(0));
    }
    assert!(refused > 0, "no limit was too low");
}

#[test]
fn shipped_policies_have_names_wherever_the_program_is() {
    let place = Place::new();
    let text_of = |policy: &str| {
        trolley::init::scenario(None).replace("# policy = \"worst-off-first\"", policy)
    };
    for name in trolley::policy_names() {
        let file = place.write("named.toml", &text_of(&format!("policy = \"{name}\"")));
        let ranked = run(&["rank", file.to_str().unwrap(), "--in-process"]);
        let table = text(&ranked.stdout);
        assert!(table.contains(&format!("policy \"{name}\"")), "{table}{}", text(&ranked.stderr));
    }
    let file = place.write("unknown.toml", &text_of("policy = \"worst-of-first\""));
    let refused = run(&["rank", file.to_str().unwrap(), "--in-process"]);
    let error = text(&refused.stderr);
    assert_eq!(refused.status.code(), Some(65), "{error}");
    assert!(
        error.contains("unknown.toml:6:10: no policy of the name \"worst-of-first\""),
        "{error}"
    );
    assert!(error.contains("worst-off-first"), "{error}");
}

#[test]
fn init_ranks_at_once_and_replaces_nothing() {
    let place = Place::new();
    let own = |args: &[&str]| trolley().args(args).current_dir(place.path()).output().unwrap();
    let made = own(&["init", "crash.toml"]);
    assert!(made.status.success(), "{}", text(&made.stderr));
    let file = place.path().join("crash.toml");
    let ranked = run(&["rank", file.to_str().unwrap(), "--in-process", "--strict"]);
    assert!(ranked.status.success(), "{}", text(&ranked.stderr));
    assert!(text(&ranked.stdout).contains("Every way hits somebody"), "{}", text(&ranked.stdout));

    let again = own(&["init", "crash.toml"]);
    assert_eq!(again.status.code(), Some(78), "{}", text(&again.stderr));
    assert!(text(&again.stderr).contains("help: "), "{}", text(&again.stderr));

    let body = own(&["model", "generate", "suv", "--triangles", "600", "-o", "mine.trolley"]);
    assert!(body.status.success(), "{}", text(&body.stderr));
    let made = own(&["init", "own.toml", "--body", "mine.trolley"]);
    assert!(made.status.success(), "{}", text(&made.stderr));
    let file = place.path().join("own.toml");
    assert!(std::fs::read_to_string(&file).unwrap().contains("\nfile = \"mine.trolley\"\n"));
    let ranked = run(&["rank", file.to_str().unwrap(), "--in-process"]);
    assert!(ranked.status.success(), "{}", text(&ranked.stderr));
}

/// Every command has a man page, and every page is about its own command.
#[test]
fn every_command_has_a_man_page() {
    let place = Place::new();
    let folder = place.path().to_str().unwrap();
    let made = trolley().args(["man", "--out", folder]).output().unwrap();
    assert!(made.status.success(), "{}", text(&made.stderr));
    let mut count = 0;
    for entry in std::fs::read_dir(place.path()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let page = std::fs::read_to_string(&path).unwrap();
        assert!(page.contains(&format!(".TH {name} 1")), "{name}: {}", &page[..200]);
        count += 1;
    }
    assert!(count > 25, "{count} pages");
    let one = trolley().args(["man", "model", "import"]).output().unwrap();
    assert!(text(&one.stdout).contains("trolley\\-model\\-import"), "{}", text(&one.stdout));
}
