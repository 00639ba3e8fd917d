//! The command line's words: names of flags, the standard input, full disks, little memory.

use crate::support::{Place, run, text, trolley, ways};
use crate::traffic::crossing;
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

/// In every file that a person writes, whichever reads it: the key, both lines, and the remedy.
#[test]
fn a_key_that_stands_twice_is_named_with_both_its_lines() {
    let place = Place::new();
    let name = |name: &str| place.path().join(name).to_str().unwrap().to_owned();
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 5\nf 1 2 3\nf 1 2 4\nf 1 3 4\n";
    place.write("body.obj", mesh);
    place.write("true.toml", &ways(600));
    place.write("crossing.xml", &crossing(0.5, "parkedVehicle"));
    let test = "[{\"id\": \"a\", \"group\": \"g\",\n\"mass_kg\": 1000,\n\"mass_kg\": 1000}]";
    place.write("tests.json", test);
    let toml = |schema: &str| format!("schema = \"{schema}\"\nmass_kg = 1\nmass_kg = 2\n");
    let files: [(&str, &str, &[&str]); 8] = [
        ("scenario.toml", "trolley.scenario/2", &["rank", "?"]),
        ("policy.toml", "trolley.policy/1", &["policy", "check", "?"]),
        ("curves.toml", "trolley.curves/1", &["policy", "check", "config", "--curves", "?"]),
        ("deployment.toml", "trolley.deployment/1", &["query", "?", "true.toml"]),
        ("library.toml", "trolley.bodies/1", &["rank", "crossing.xml", "--bodies", "?"]),
        ("body.toml", "", &["model", "import", "body.obj", "--kind", "pole", "-o", "out.trolley"]),
        ("plan.toml", "trolley.faults/1", &["inject", "?"]),
        ("orderings.toml", "trolley.orderings/1", &["validate", "?"]),
    ];
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/policies/default.toml");
    for (file, schema, args) in files {
        place.write(file, &toml(schema));
        let word = |word: &&str| match *word {
            "?" => name(file),
            "config" => config.to_owned(),
            other if other.contains('.') => name(other),
            other => other.to_owned(),
        };
        let args: Vec<String> = args.iter().map(word).collect();
        assert_twice(&args, &format!("{file}:3"), 2);
    }
    assert_twice(&["validate".to_owned(), name("tests.json")], "tests.json:3", 2);
    // What a scenario names.
    for key in ["policy", "curves", "parameters"] {
        place.write("named.toml", &toml("x"));
        let head = "schema = \"trolley.scenario/2\"\n";
        let scenario = ways(600).replace(head, &format!("{head}{key} = \"named.toml\"\n"));
        place.write("naming.toml", &scenario);
        assert_twice(&["rank".to_owned(), name("naming.toml")], "named.toml:3", 2);
    }
}

/// Runs a command that must name the second place, the first line and a remedy.
fn assert_twice(args: &[String], place: &str, first: usize) {
    let refused = trolley().args(args).output().expect("it can be started");
    let error = text(&refused.stderr) + &text(&refused.stdout);
    assert!(matches!(refused.status.code(), Some(65 | 78)), "{args:?}: {error}");
    assert!(error.contains(place), "{args:?}: {error}");
    let says = format!("\"mass_kg\" stands here a second time: it is in line {first} already");
    assert!(error.contains(&says), "{args:?}: {error}");
    assert!(error.contains("leave one of them out"), "{args:?}: {error}");
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
        // The C library may have had its say before.
        let says = error.lines().any(|line| line.starts_with("error: "));
        assert!(code == Some(0) || says, "{kilobytes} kB: {error}");
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
        // A line may break between the two words.
        let said = table.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(said.contains(&format!("policy \"{name}\"")), "{table}{}", text(&ranked.stderr));
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

/// Regression: a file of another kind was refused for its bytes or its keys, with remedies that led
/// nowhere, and `init` wrote a scenario that could not be ranked.
#[test]
fn a_file_of_another_kind_is_told_and_so_is_the_way() {
    let place = Place::new();
    let name = |name: &str| place.path().join(name).to_str().unwrap().to_owned();
    let mesh = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/examples/car.stl");
    std::fs::copy(mesh, name("car.stl")).unwrap();
    place.write("scenario.toml", &ways(600));
    let (mesh, model, scenario) = (name("car.stl"), name("car.trolley"), name("scenario.toml"));
    let made = trolley()
        .args(["model", "import", &mesh, "--unit", "cm", "--up", "z", "--forward", "-y"])
        .args(["--kind", "sedan", "-o", &model, "--json"])
        .output()
        .unwrap();
    assert!(made.status.success(), "{}", text(&made.stderr));
    let cases: [(&[&str], i32, &str, &str); 6] = [
        (&["rank", &mesh], 65, "car.stl: it is a mesh, and no scenario", "help tutorial"),
        (
            &["rank", &model],
            65,
            "car.trolley: it is a model file, and no scenario",
            "help tutorial",
        ),
        (&["init", &name("a.toml"), "--body", &mesh], 65, "it is no model file", "model import"),
        (
            &["serve", &scenario],
            65,
            "scenario.toml:1:1: schema \"trolley.scenario/2\" is not that of a deployment",
            "is it the right file?",
        ),
        (&["query", &scenario, &scenario], 65, "is not that of a deployment", "deployment/1"),
        (&["model", "import", &mesh, "-o", &name("b.trolley")], 65, "was not said", "model info "),
    ];
    for (args, code, says, help) in cases {
        let refused = trolley().args(args).output().unwrap();
        let error = text(&refused.stderr);
        let kinds = [Some(code), Some(78)];
        assert!(kinds.contains(&refused.status.code()), "{args:?}: {error}");
        assert!(error.contains(says), "{args:?}: {error}");
        let remedy = error.split("help: ").nth(1).unwrap_or_default();
        assert!(remedy.contains(help), "{args:?}: {error}");
    }
    assert!(!place.path().join("a.toml").exists());

    // What a mesh is offered as is what an import makes of it.
    let info = trolley().args(["model", "info", &mesh, "--json"]).output().unwrap();
    let offered = crate::support::json(&info);
    let (offered, made) = (&offered["readings"][0], crate::support::json(&made));
    assert_eq!(offered["kind"], "sedan", "{offered}");
    assert_eq!(offered["mass_kg"], made["body"]["mass_kg"], "{offered}");
}
