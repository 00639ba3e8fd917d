//! What a pure crate must not name outside its tests.

use crate::code::{braces, code, outside_tests, words};
use crate::tree::{Package, Text, sources};
use std::path::Path;

/// The one pure crate that may start threads, because it waits for them and its trees do not depend
/// on their number.
const BUILDS_IN_PARALLEL: &str = "bvh";

/// The module of a pure crate that touches the machine so that the others need not, and the crate
/// of ours that it does so with. The others name neither.
pub(crate) const EDGES: &[(&str, &str, &str)] = &[("mesh", "reader", "runtime")];

/// The sources of a package and their code, without what is only there for tests.
pub(crate) fn outside_tests_of(package: &Package) -> Vec<(Text, String)> {
    left_of(package, |text| outside_tests(&code(text)))
}

/// The sources of a package and what is left of them: `leave` says what is left of a text, and
/// which modules with files of their own are not.
pub(crate) fn left_of(
    package: &Package,
    leave: impl Fn(&str) -> (String, Vec<String>),
) -> Vec<(Text, String)> {
    let mut left_out = Vec::new();
    let mut files = Vec::new();
    for file in sources(&package.folder.join("src")) {
        let (left, modules) = leave(&file.text);
        let path = Path::new(&file.path);
        let is_root = path.ends_with("lib.rs") || path.ends_with("main.rs");
        // `x.rs` keeps its modules in the folder `x`, and lib.rs beside itself.
        let below = if is_root { path.with_file_name("") } else { path.with_extension("") };
        left_out.extend(modules.iter().map(|module| below.join(module)));
        files.push((file, left));
    }
    files.retain(|(file, _)| {
        let path = Path::new(&file.path).with_extension("");
        !left_out.iter().any(|gone| path.starts_with(gone))
    });
    assert!(!files.is_empty(), "{} has no code", package.name);
    files
}

/// As [`outside_tests_of`], without the module that the crate has at its edge.
pub(crate) fn inside(package: &Package) -> Vec<(Text, String)> {
    let mut files = outside_tests_of(package);
    for (_, edge, _) in EDGES.iter().filter(|(of, ..)| *of == package.name) {
        let edge = Path::new("crates").join(&package.name).join("src").join(edge);
        let before = files.len();
        files.retain(|(file, _)| !Path::new(&file.path).with_extension("").starts_with(&edge));
        assert!(files.len() < before, "there is no {}", edge.display());
    }
    files
}

/// What a pure crate must not name, and on which lines it is named, counted from 0.
pub(crate) fn impurities(code: &str, package: &str) -> Vec<(usize, String)> {
    let banned = |module: &str| match module {
        "fs" | "net" | "process" | "env" | "os" => true,
        "thread" => package != BUILDS_IN_PARALLEL,
        _ => false,
    };
    // An exit code is a number: to name it starts and ends nothing.
    let is_number = |at: usize| code[at..].starts_with("process::ExitCode");
    let used = modules_of_std(code).into_iter();
    let used = used.filter(|(at, module)| banned(module) && !is_number(*at));
    let mut found: Vec<_> = used
        .map(|(at, module)| (code[..at].matches('\n').count(), format!("std::{module}")))
        .collect();
    let edges = EDGES.iter().filter(|(of, ..)| *of == package);
    let ways: Vec<String> =
        edges.flat_map(|(_, edge, with)| [format!("{with}::"), format!("::{edge}::")]).collect();
    for (number, line) in code.lines().enumerate() {
        let out = ways.iter().filter(|way| line.contains(way.as_str()));
        found.extend(out.map(|way| (number, way.clone())));
        let clocks = words(line).filter(|word| ["Instant", "SystemTime"].contains(word));
        found.extend(clocks.map(|clock| (number, clock.to_owned())));
        let waits =
            ["thread::sleep", "thread::spawn"].into_iter().filter(|call| line.contains(call));
        found.extend(waits.map(|wait| (number, wait.to_owned())));
    }
    found
}

/// The modules of std that are named, by path or in a list, and where.
fn modules_of_std(code: &str) -> Vec<(usize, &str)> {
    const STD: &str = "std::";
    let mut items = Vec::new();
    for (at, _) in code.match_indices(STD) {
        let from = at + STD.len();
        if !code[from..].starts_with('{') {
            items.push(from);
            continue;
        }
        let mut depth = 0;
        for (offset, c) in code[from..from + braces(&code[from..])].char_indices() {
            depth += i32::from(c == '{') - i32::from(c == '}');
            // The list's own items, not those of lists in it.
            if depth == 1 && matches!(c, '{' | ',') {
                items.push(from + offset + 1);
            }
        }
    }
    let first_word = |at: usize| {
        let item = code[at..].trim_start();
        Some((code.len() - item.len(), words(item).next()?))
    };
    items.into_iter().filter_map(first_word).collect()
}
