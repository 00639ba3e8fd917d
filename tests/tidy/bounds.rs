//! Every loop without a range and every call that may wait, in what a service and its workers are
//! made of, stands on a page that says what bounds it; and the page's figures are the source's.

use crate::code::{in_word, words};
use crate::faults::outside_marks;
use crate::pure::left_of;
use crate::tree::{Package, Text, root};
use std::collections::{BTreeMap, BTreeSet};

/// The page.
const PAGE: &str = "crates/coordinator/BOUNDS.md";
/// The crates that it is about: coordinator, worker and service, and what they wait in.
const CRATES: &[&str] = &["client", "coordinator", "runtime", "service", "transport", "worker"];
/// Loops that have no range of their own.
const LOOPS: &[&str] = &["while", "loop"];
/// Calls that may wait, or go on without end.
const CALLS: &[&str] = &[
    ".join()",
    ".lock()",
    "await_exec(",
    "await_greetings(",
    "blocking_remove_stale_resources(",
    "fallocate(",
    "flock(",
    "from_fn(",
    "idle(",
    "io::read(",
    "io::write(",
    "nanosleep(",
    "nap(",
    "nap_ns(",
    "poll(",
    "read_to_end(",
    "read_to_string(",
    "recv(",
    "sched_yield(",
    "send_to_addr(",
    "sleep(",
    "snooze(",
    "spin_loop(",
    "wait(",
    "wait_end(",
    "wait_ms(",
    "waitpid(",
];

/// A function with loops or waits: its file, below `crates`, and its name.
type Location = (String, String);

/// What in a line of code may take long.
fn long_in(line: &str) -> Vec<&'static str> {
    let keyword = |word: &&&'static str| words(line).any(|found| found == **word);
    let is_called = |call: &&&'static str| {
        line.match_indices(**call).any(|(at, _)| {
            let before = &line[..at];
            let is_word = call.starts_with(in_word) && before.ends_with(in_word);
            !is_word && !before.ends_with("fn ")
        })
    };
    LOOPS.iter().filter(keyword).chain(CALLS.iter().filter(is_called)).copied().collect()
}

/// What may take long in code, by function.
fn sites_in(path: &str, code: &str) -> BTreeMap<Location, BTreeSet<&'static str>> {
    let mut sites: BTreeMap<Location, BTreeSet<&'static str>> = BTreeMap::new();
    let mut function = String::new();
    for line in code.lines() {
        if let Some(name) = words(line).skip_while(|word| *word != "fn").nth(1) {
            name.clone_into(&mut function);
        }
        let found = long_in(line);
        if !found.is_empty() {
            sites.entry((path.to_owned(), function.clone())).or_default().extend(found);
        }
    }
    sites
}

fn sites(packages: &[Package]) -> BTreeMap<Location, BTreeSet<&'static str>> {
    let mut sites = BTreeMap::new();
    for package in packages.iter().filter(|package| CRATES.contains(&package.name.as_str())) {
        for (file, code) in left_of(package, outside_marks) {
            let path = file.path.strip_prefix("crates/").unwrap_or(&file.path);
            sites.extend(sites_in(path, &code));
        }
    }
    sites
}

/// A row of the page.
struct Row {
    line: usize,
    site: Location,
    found: BTreeSet<String>,
    bound: String,
    figures: Vec<String>,
}

/// What stands between backticks.
fn quoted(cell: &str) -> impl Iterator<Item = String> {
    cell.split('`').skip(1).step_by(2).map(str::to_owned)
}

fn rows(page: &Text) -> Vec<Row> {
    let mut rows = Vec::new();
    for (line, text) in page.text.lines().enumerate() {
        let cells: Vec<&str> = text.split('|').map(str::trim).collect();
        let [_, file, function, found, bound, figures, _] = cells[..] else { continue };
        let (Some(file), Some(function)) = (quoted(file).next(), quoted(function).next()) else {
            continue;
        };
        rows.push(Row {
            line,
            site: (file, function),
            found: quoted(found).collect(),
            bound: bound.to_owned(),
            figures: quoted(figures).collect(),
        });
    }
    rows
}

/// Whether a file gives a constant, or a field of a default, this value.
fn gives(text: &str, name: &str, value: &str) -> bool {
    text.lines().any(|line| {
        let constant = line.trim_start().trim_start_matches("pub(super) ");
        let constant = constant.trim_start_matches("pub(crate) ").trim_start_matches("pub ");
        let rest = constant.strip_prefix("const ").and_then(|rest| rest.strip_prefix(name));
        if let Some(rest) = rest.filter(|rest| rest.starts_with(':')) {
            return rest.ends_with(&format!("= {value};"));
        }
        let field = format!("{name}: {value}");
        line.match_indices(&field).any(|(at, _)| {
            !line[..at].ends_with(in_word) && !line[at + field.len()..].starts_with(in_word)
        })
    })
}

/// What is wrong with a figure of the page, if anything is.
fn misstated(row: &Row, figure: &str) -> Option<String> {
    let (file, rest) = figure.split_once(": ").unwrap_or((row.site.0.as_str(), figure));
    let Some((name, value)) = rest.split_once(" = ") else {
        return Some(format!("{figure}: write NAME = VALUE, or FILE: NAME = VALUE"));
    };
    let path = root().join("crates").join(file);
    if !path.is_file() {
        return Some(format!("there is no {file}"));
    }
    (!gives(&Text::read(&path).text, name, value)).then(|| format!("{file} has no {rest}"))
}

/// What the page lacks, names in vain or misstates.
pub(crate) fn faults(packages: &[Package]) -> Vec<String> {
    let page = Text::read(&root().join(PAGE));
    let (sites, rows) = (sites(packages), rows(&page));
    let mut faults = Vec::new();
    for row in &rows {
        let (file, function) = &row.site;
        let found = sites.get(&row.site);
        if found.is_none_or(|found| !found.iter().copied().eq(row.found.iter())) {
            let found: Vec<_> = found.into_iter().flatten().collect();
            let what = format!("{function} of {file} has {found:?}, not {:?}", row.found);
            faults.push(page.fault(row.line, &what));
        }
        if row.bound.is_empty() {
            faults.push(page.fault(row.line, "says no bound"));
        }
        let misstated = row.figures.iter().filter_map(|figure| misstated(row, figure));
        faults.extend(misstated.map(|what| page.fault(row.line, &what)));
    }
    for ((file, function), found) in &sites {
        let listed = rows.iter().filter(|row| row.site == (file.clone(), function.clone())).count();
        if listed != 1 {
            let found: Vec<String> = found.iter().map(|what| format!("`{what}`")).collect();
            let row = format!("| `{file}` | `{function}` | {} | | |", found.join(" "));
            faults.push(format!("{PAGE}: {listed} rows instead of one: {row}"));
        }
    }
    faults
}

#[test]
fn loops_and_waits_are_found_and_nothing_else() {
    let code = "impl A {\n fn wait(&self) {\n  while x {}\n }\n fn b(&self) {\n  a.wait(1);\n  \
                path.join(c); thread.join();\n  nowait(2); for x in y {}\n }\n}\n\
                fn c() { loop {} }\n";
    let found = sites_in("x.rs", code);
    let found: Vec<_> = found.iter().map(|((_, f), what)| (f.as_str(), what.clone())).collect();
    let set = |list: &[&'static str]| list.iter().copied().collect::<BTreeSet<_>>();
    let expected =
        [("b", set(&[".join()", "wait("])), ("c", set(&["loop"])), ("wait", set(&["while"]))];
    assert_eq!(found, expected);
}

#[test]
fn figures_are_compared_with_constants_and_defaults() {
    let text =
        "const NAP_NS: u64 = 20;\n    Self { a_ns: 5, longest_ns: 7 }\npub const N: u8 = 2 * M;";
    for (name, value, is_given) in [
        ("NAP_NS", "20", true),
        ("NAP_NS", "2", false),
        ("NAP", "20", false),
        ("longest_ns", "7", true),
        ("longest_ns", "70", false),
        ("ns", "5", false),
        ("N", "2 * M", true),
    ] {
        assert_eq!(gives(text, name, value), is_given, "{name} = {value}");
    }
}
