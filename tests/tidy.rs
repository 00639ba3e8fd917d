//! Checks that a compiler cannot make: dependencies between crates, which crates may contain
//! `unsafe` or use an external crate, what pure crates never touch, what is behind a feature, the
//! layout of files, and that files named in prose exist.
//!
//! A fault names file and line. The checks read text, and understand as much Rust as
//! `tidy/code.rs`.

#[path = "tidy/bounds.rs"]
mod bounds;
#[path = "tidy/circles.rs"]
mod circles;
#[path = "tidy/code.rs"]
mod code;
#[path = "tidy/faults.rs"]
mod faults;
#[path = "tidy/guards.rs"]
mod guards;
#[path = "tidy/names.rs"]
mod names;
#[path = "tidy/pure.rs"]
mod pure;
#[path = "../tools/src/aarch64/suites/pure_crates.rs"]
mod pure_crates;
#[path = "tidy/safety.rs"]
mod safety;
#[path = "tidy/tree.rs"]
mod tree;

use code::{calls, code, words};
use pure_crates::PURE;
use std::path::Path;
use tree::{Package, Text, all_sources, packages, root};

/// Crates from the bottom up; each may use only those before it.
const LAYERS: &[&str] = &[
    "diagnostic",
    "geometry",
    "protocol",
    "xml",
    "keys",
    "columns",
    "body",
    "shapes",
    "bvh",
    "damage",
    "scenario",
    "record",
    "dispatch",
    "executor",
    "traffic",
    "transport",
    "runtime",
    "mesh",
    "client",
    "simulate",
    "coordinator",
    "worker",
    "service",
    "trolley",
    "report",
    "lab",
    "study",
    "client-c",
    "cli",
    "python",
    "check",
    "tools",
];
/// Programs and libraries on top: they never use each other.
const SIBLINGS: &[&str] = &["report", "simulate", "coordinator", "worker", "client-c"];
/// Crates that may use only a few of the workspace's crates.
const ONLY: &[(&str, &[&str])] = &[
    // No importer; their tests are about shapes.
    ("bvh", &["diagnostic", "geometry", "body", "shapes"]),
    ("damage", &["diagnostic", "geometry", "body", "keys"]),
    ("record", &["diagnostic", "body", "scenario"]),
    ("dispatch", &["diagnostic", "protocol"]),
    ("simulate", &["diagnostic", "geometry", "dispatch", "protocol"]),
    ("executor", &["geometry", "protocol", "body", "bvh"]),
    ("transport", &["diagnostic", "protocol"]),
    ("runtime", &["diagnostic", "protocol"]),
    ("client", &["diagnostic", "protocol", "transport"]),
    ("client-c", &["client", "protocol", "transport"]),
    ("report", &["diagnostic", "geometry", "trolley"]),
    ("study", &["keys", "columns", "scenario", "runtime", "trolley", "report"]),
    ("columns", &["diagnostic"]),
    ("python", &["trolley", "study"]),
];
/// Workspace crates that the command line may use, its tests aside: it parses flags, calls a
/// library, and prints.
const COMMAND_LINE: &[&str] = &["scenario", "client", "trolley", "report", "lab", "study"];
/// Maximum number of lines of the command line.
const COMMAND_LINE_MAX: usize = 5_000;
/// External crates, with their companions, that only a few crates of the workspace may use.
const ALONE: &[(&str, &[&str])] = &[
    ("iceoryx2", &["transport"]),
    // transport: its test that kills at each system call.
    ("libc", &["runtime", "transport"]),
    ("bincode", &["body"]),
    ("ed25519-dalek", &["record"]),
    ("humantime", &["record"]),
    ("tobj", &["mesh"]),
    ("stl_io", &["mesh"]),
    ("ply-rs-bw", &["mesh"]),
    ("gltf", &["mesh"]),
    ("earcut", &["mesh"]),
    ("robust", &["geometry"]),
    ("clap", &["cli", "tools"]),
    ("kuva", &["lab"]),
    ("parquet", &["columns", "cli"]),
    ("glob", &["study"]),
    ("pyo3", &["python"]),
    ("numpy", &["python"]),
    ("arrow", &["python"]),
];
/// Crates that may contain `unsafe`.
const UNSAFE: &[&str] = &["transport", "runtime", "client-c"];
/// Crates that no vehicle build has, so that faults may be anywhere in them.
const FAULTY: &[&str] = &[faults::LAB, "tools"];
/// Longest line, in characters.
const COLUMNS_MAX: usize = 100;

/// Fails with all faults, if there are any.
#[track_caller]
fn none(faults: &[String]) {
    assert!(faults.is_empty(), "\n\n{}\n", faults.join("\n"));
}

/// The place of a crate in [`LAYERS`].
fn rank(name: &str) -> Option<usize> {
    LAYERS.iter().position(|layer| *layer == name)
}

#[test]
fn arrows_between_crates_point_downwards() {
    let mut faults = Vec::new();
    for package in &packages() {
        let name = package.name.as_str();
        let Some(own) = rank(name) else {
            faults.push(package.manifest.fault(0, &format!("{name} has no place in LAYERS")));
            continue;
        };
        let only = ONLY.iter().find(|(of, _)| *of == name).map(|(_, only)| *only);
        for (used, line) in package.uses() {
            let Some(below) = rank(&used) else { continue };
            let siblings = SIBLINGS.contains(&name) && SIBLINGS.contains(&used.as_str());
            if below >= own || siblings {
                faults.push(package.manifest.fault(line, &format!("{name} must not use {used}")));
            } else if only.is_some_and(|only| !only.contains(&used.as_str())) {
                let fault = format!("{name} must not use {used}: see ONLY");
                faults.push(package.manifest.fault(line, &fault));
            }
        }
    }
    none(&faults);
}

#[test]
fn the_command_line_names_the_library_and_no_engine_crate() {
    let packages = packages();
    let cli = packages.iter().find(|package| package.name == "cli").expect("the command line");
    let is_ours = |name: &String| packages.iter().any(|package| package.name == *name);
    let used = cli.uses_as(&["dependencies", "build-dependencies"]).into_iter();
    let others = used.filter(|(used, _)| is_ours(used) && !COMMAND_LINE.contains(&used.as_str()));
    let fault = |(used, line): (String, usize)| {
        cli.manifest.fault(line, &format!("cli must not use {used}: see COMMAND_LINE"))
    };
    none(&others.map(fault).collect::<Vec<_>>());
}

#[test]
fn the_command_line_is_short() {
    let files = tree::sources(&root().join("crates/cli/src"));
    let lines: usize = files.iter().map(|file| file.text.lines().count()).sum();
    assert!(lines <= COMMAND_LINE_MAX, "crates/cli/src: {lines} lines, not {COMMAND_LINE_MAX}");
}

#[test]
fn no_files_of_the_upper_floors_name_each_other_in_a_circle() {
    let packages = packages();
    let cli = packages.iter().find(|package| package.name == "cli").expect("the command line");
    let names = circles::names(cli);
    assert!(names[""].contains("args") && names["args"].contains("rank"), "{names:?}");
    for name in ["cli", "lab"] {
        let package = packages.iter().find(|package| package.name == name).expect("a package");
        let circles = circles::circles(circles::names(package));
        assert!(circles.is_empty(), "{name}: files name each other in a circle: {circles:?}");
    }
}

#[test]
fn outside_crates_with_one_owner_are_named_by_it_alone() {
    let mut faults = Vec::new();
    for package in &packages() {
        for (used, line) in package.uses() {
            let belongs = |outside: &str| {
                used.strip_prefix(outside)
                    .is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
            };
            let owners = ALONE.iter().find(|(outside, _)| belongs(outside)).map(|(_, of)| *of);
            if owners.is_some_and(|owners| !owners.contains(&package.name.as_str())) {
                let fault = format!("{} must not name {used}", package.name);
                faults.push(package.manifest.fault(line, &fault));
            }
        }
    }
    none(&faults);
}

#[test]
fn every_package_is_named_after_its_folder_and_keeps_the_lints() {
    let mut faults = Vec::new();
    for package in &packages() {
        let name = package.value(&["package", "name"]).and_then(|name| name.as_str());
        if name != Some(&package.published_as()) {
            let fault = format!("the package is not called {}", package.published_as());
            faults.push(package.manifest.fault(0, &fault));
        }
        if package.value(&["lints", "workspace"]).and_then(|kept| kept.as_bool()) != Some(true) {
            faults.push(package.manifest.fault(0, "needs [lints] workspace = true"));
        }
    }
    none(&faults);
}

#[test]
fn unsafe_code_stays_in_the_crates_at_the_edge() {
    let mut faults = Vec::new();
    let mut opted_out = 0;
    for file in &all_sources() {
        let owner = file.path.strip_prefix("crates/").and_then(|path| path.split('/').next());
        let may = owner.is_some_and(|owner| UNSAFE.contains(&owner));
        let is_root = owner.is_some_and(|owner| file.path == format!("crates/{owner}/src/lib.rs"));
        let code = code(&file.text);
        let opts_out =
            |line: &str| line.starts_with("#![") && words(line).any(|word| word == "unsafe_code");
        if may && is_root {
            match code.lines().filter(|line| opts_out(line)).count() {
                1 => opted_out += 1,
                n => faults.push(file.fault(0, &format!("{n} opt-outs of unsafe_code, not one"))),
            }
        }
        for (number, line) in code.lines().enumerate() {
            if !may && words(line).any(|word| word == "unsafe") {
                faults.push(file.fault(number, "unsafe outside of the crates in UNSAFE"));
            }
            let names_lint = words(line).any(|word| word == "unsafe_code");
            if names_lint && !(may && opts_out(line)) {
                let fault = "unsafe_code is opted out for whole targets of crates in UNSAFE alone";
                faults.push(file.fault(number, fault));
            }
        }
    }
    none(&faults);
    let there = packages().iter().filter(|p| UNSAFE.contains(&p.name.as_str())).count();
    assert_eq!(opted_out, there, "each crate in UNSAFE has a lib.rs that says so");
}

#[test]
fn pure_crates_touch_no_file_network_process_or_clock() {
    let mut faults = Vec::new();
    let packages = packages();
    for package in packages.iter().filter(|package| PURE.contains(&package.name.as_str())) {
        for (file, code) in &pure::inside(package) {
            faults.extend(pure::impurities(code, &package.name).into_iter().map(|(line, what)| {
                file.fault(line, &format!("{what}: {} is pure", package.name))
            }));
        }
    }
    none(&faults);
}

#[test]
fn orders_to_misbehave_and_deliberate_flaws_stand_behind_a_feature() {
    let (mut all, mut gated) = (Vec::new(), 0);
    for package in packages().iter().filter(|package| !FAULTY.contains(&package.name.as_str())) {
        let (faults, there) = faults::ungated(package);
        all.extend(faults);
        gated += there;
    }
    none(&all);
    assert!(gated > 100, "only {gated} names: are they called something else by now?");
}

#[test]
fn every_loop_and_wait_stands_on_the_page_of_bounds() {
    none(&bounds::faults(&packages()));
}

#[test]
fn the_lab_alone_turns_on_faults_and_all_of_them() {
    let packages = packages();
    none(&faults::turned_on(&packages, &Text::read(&root().join("Cargo.toml"))));
    let on = faults::of_the_lab(&packages);
    let with_feature = faults::with_feature(&packages);
    assert!(with_feature.len() >= 5, "only {} crates with faults", with_feature.len());
    let off = with_feature.iter().filter(|package| !on.contains(&package.name));
    let fault =
        |package: &&Package| package.manifest.fault(0, "the lab does not turn its faults on");
    none(&off.map(fault).collect::<Vec<_>>());
}

#[test]
fn nothing_is_defined_under_a_former_name() {
    none(&names::former());
}

#[test]
fn a_public_type_has_its_name_for_itself() {
    none(&names::doubles());
}

#[test]
fn every_public_item_of_the_library_has_an_example() {
    none(&names::without_example());
}

#[test]
fn closures_have_names_that_a_search_finds() {
    none(&names::unsearchable());
}

#[test]
fn every_file_says_what_it_is() {
    let silent = |file: &&Text| !file.text.starts_with("//! ");
    let fault = |file: &Text| file.fault(0, "begins without //! and what it is");
    none(&all_sources().iter().filter(silent).map(fault).collect::<Vec<_>>());
}

#[test]
fn tables_of_safety_name_tests_faults_and_probes_that_exist() {
    none(&safety::faults());
}

#[test]
fn no_line_is_too_long() {
    let mut faults = Vec::new();
    for file in &all_sources() {
        for (number, line) in file.text.lines().enumerate() {
            let columns = line.chars().count();
            if columns > COLUMNS_MAX {
                faults.push(file.fault(number, &format!("{columns} columns, not {COLUMNS_MAX}")));
            }
        }
    }
    none(&faults);
}

#[test]
fn nothing_is_left_unfinished() {
    // In one piece, these would be found here.
    let notes = [concat!("FIX", "ME"), concat!("XX", "X")];
    let macros = ["todo", "unimplemented", "dbg"];
    let mut faults = Vec::new();
    for file in &all_sources() {
        let code = code(&file.text);
        for (number, (line, code)) in file.text.lines().zip(code.lines()).enumerate() {
            let noted = notes.iter().filter(|note| words(line).any(|word| word == **note));
            let called = macros.iter().filter(|name| calls(code, name));
            faults.extend(noted.chain(called).map(|what| file.fault(number, what)));
        }
    }
    none(&faults);
}

#[test]
fn every_file_that_architecture_names_exists() {
    let page = Text::read(&root().join("ARCHITECTURE.md"));
    let mut faults = Vec::new();
    let mut named = 0;
    for (number, line) in page.text.lines().enumerate() {
        for path in rust_files_in(line) {
            named += 1;
            if ![root(), root().join("crates")].iter().any(|from| from.join(path).is_file()) {
                let fault = format!("there is no {path}, from here or from crates/");
                faults.push(page.fault(number, &fault));
            }
        }
    }
    none(&faults);
    assert!(named > 0, "{}: names no test at all", page.path);
}

#[test]
fn every_invariant_of_architecture_names_its_test() {
    let page = Text::read(&root().join("ARCHITECTURE.md"));
    let mut items: Vec<(usize, String)> = Vec::new();
    let mut among_invariants = false;
    for (number, line) in page.text.lines().enumerate() {
        if line.starts_with('#') {
            among_invariants = line.contains("Invariants");
        } else if among_invariants && line.starts_with("- ") {
            items.push((number, line.to_owned()));
        } else if let Some((_, item)) = items.last_mut().filter(|_| line.starts_with("  ")) {
            item.push_str(line);
        }
    }
    assert!(!items.is_empty(), "{}: no list of invariants", page.path);
    let untested = items.iter().filter(|(_, item)| rust_files_in(item).is_empty());
    none(&untested.map(|(line, _)| page.fault(*line, "names no test")).collect::<Vec<_>>());
}

#[test]
fn every_file_that_a_header_names_exists() {
    let root = root();
    let mut faults = Vec::new();
    for file in &all_sources() {
        let path = Path::new(&file.path);
        let package = path.ancestors().find(|at| root.join(at).join("Cargo.toml").is_file());
        let package = package.expect("the root has a manifest");
        // From its crate's src, its crate, its own modules, its folder, crates/, the root.
        let from = [
            package.join("src"),
            package.to_owned(),
            path.with_extension(""),
            path.with_file_name(""),
            "crates".into(),
            "".into(),
        ];
        let header = file.text.lines().enumerate().take_while(|(_, line)| line.starts_with("//!"));
        for (number, line) in header {
            for name in rust_files_in(line) {
                if !from.iter().any(|from| root.join(from).join(name).is_file()) {
                    faults.push(file.fault(number, &format!("there is no {name}")));
                }
            }
        }
    }
    none(&faults);
}

/// The names of Rust files between backticks in a line of prose.
fn rust_files_in(line: &str) -> Vec<&str> {
    let quoted = line.split('`').skip(1).step_by(2);
    quoted.filter(|name| name.ends_with(".rs") && !name.contains([' ', '*', '<'])).collect()
}
