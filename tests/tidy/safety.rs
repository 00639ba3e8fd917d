//! The tables of `tools/safety`, held against tests, kinds of faults, `trolley doctor` and what the
//! campaign of faults measured.

use crate::tree::{Text, all_sources, root};
use std::collections::{BTreeMap, BTreeSet};
use toml::{Table, Value};

/// What stands above a test that verifies a requirement.
const TAG: &str = "// verifies ";

/// A table of `tools/safety`: its entries by id.
type Entries = BTreeMap<String, Table>;

fn entries(file: &str, kind: &str, faults: &mut Vec<String>) -> Entries {
    let text = Text::read(&root().join("tools/safety").join(file)).text;
    let table: Table = toml::from_str(&text).unwrap_or_else(|error| panic!("{file}: {error}"));
    let mut entries = Entries::new();
    for entry in table[kind].as_array().expect("a list of tables") {
        let entry = entry.as_table().expect("a list of tables").clone();
        let id = string(&entry, "id").expect("each entry has an id").to_owned();
        if entries.insert(id.clone(), entry).is_some() {
            faults.push(format!("{file}: {id} stands twice"));
        }
    }
    entries
}

fn string<'t>(entry: &'t Table, key: &str) -> Option<&'t str> {
    entry.get(key).and_then(Value::as_str).filter(|text| !text.is_empty())
}

fn strings<'t>(entry: &'t Table, key: &str) -> Vec<&'t str> {
    let list = entry.get(key).and_then(Value::as_array);
    list.into_iter().flatten().filter_map(Value::as_str).collect()
}

/// All faults of the tables.
pub(crate) fn faults() -> Vec<String> {
    let mut faults = Vec::new();
    let requirements = entries("requirements.toml", "requirement", &mut faults);
    let assumptions = entries("assumptions.toml", "assumption", &mut faults);
    let rows = entries("fmea.toml", "row", &mut faults);
    let tests = tests();
    tags(&requirements, &tests, &mut faults);
    checks(&assumptions, &tests, &mut faults);
    let known: BTreeSet<&String> = requirements.keys().chain(assumptions.keys()).collect();
    failures(&rows, &known, &mut faults);
    let used: BTreeSet<&str> = rows.values().flat_map(|row| strings(row, "mitigated_by")).collect();
    let idle = requirements.keys().filter(|id| !used.contains(id.as_str()));
    faults.extend(idle.map(|id| format!("{id}: mitigates no row of fmea.toml")));
    faults
}

/// Test functions as `FILE::NAME`, with the requirements that they verify.
fn tests() -> BTreeMap<String, BTreeSet<String>> {
    let mut tests = BTreeMap::new();
    for file in &all_sources() {
        let (mut tags, mut is_test) = (BTreeSet::new(), false);
        for line in file.text.lines() {
            if let Some(id) = line.trim().strip_prefix(TAG) {
                tags.insert(id.to_owned());
            } else if line.trim() == "#[test]" {
                is_test = true;
            } else if let Some(rest) = line.trim().strip_prefix("fn ") {
                let name = rest.split(['(', '<']).next().unwrap_or_default();
                let tags = std::mem::take(&mut tags);
                // A tag at what is no test verifies nothing, and is found as such.
                let key = format!("{}::{name}", file.path);
                if std::mem::take(&mut is_test) {
                    tests.insert(key, tags);
                } else if !tags.is_empty() {
                    tests.insert(format!("{key} (no test)"), tags);
                }
            }
        }
    }
    tests
}

/// Each test that a requirement names is there and has its tag, and the other way round.
fn tags(
    requirements: &Entries,
    tests: &BTreeMap<String, BTreeSet<String>>,
    faults: &mut Vec<String>,
) {
    for (id, entry) in requirements {
        let named = strings(entry, "tests");
        if named.is_empty() || string(entry, "text").is_none() {
            faults.push(format!("{id}: has no text, or names no test"));
        }
        for test in named {
            match tests.get(test) {
                None => faults.push(format!("{id}: there is no test {test}")),
                Some(tags) if !tags.contains(id) => {
                    faults.push(format!("{id}: {test} has no line \"{TAG}{id}\""));
                }
                Some(_) => {}
            }
        }
    }
    for (test, tags) in tests {
        for id in tags {
            let named = requirements.get(id).map(|entry| strings(entry, "tests"));
            if !named.is_some_and(|named| named.contains(&test.as_str())) {
                faults.push(format!("{test}: verifies {id}, which does not name it"));
            }
        }
    }
}

/// Each assumption names one of: a subject of `trolley doctor`, a test, what is left to others.
fn checks(
    assumptions: &Entries,
    tests: &BTreeMap<String, BTreeSet<String>>,
    faults: &mut Vec<String>,
) {
    let doctor = Text::read(&root().join("crates/trolley/src/doctor.rs")).text;
    for (id, entry) in assumptions {
        let ways = ["doctor", "test", "integrator"].map(|key| string(entry, key));
        if ways.iter().flatten().count() != 1 || string(entry, "text").is_none() {
            faults.push(format!("{id}: names not one of doctor, test, integrator; or has no text"));
        }
        if ways[0].is_some_and(|subject| !doctor.contains(&format!("\"{subject}\""))) {
            faults.push(format!("{id}: trolley doctor looks at no such subject"));
        }
        if let Some(test) = ways[1].filter(|test| !tests.contains_key(*test)) {
            faults.push(format!("{id}: there is no test {test}"));
        }
    }
}

/// Each kind of fault is in one row, each row has kinds or says why not, and no bound on detection
/// is below what was measured.
fn failures(rows: &Entries, known: &BTreeSet<&String>, faults: &mut Vec<String>) {
    let kinds = kinds();
    let measured = measured();
    assert!(kinds.len() > 30 && measured.len() > 30, "the kinds or the campaign were not found");
    let mut placed: BTreeMap<&str, &str> = BTreeMap::new();
    for (id, row) in rows {
        for key in ["element", "mode", "effect", "detection"] {
            if string(row, key).is_none() {
                faults.push(format!("{id}: has no {key}"));
            }
        }
        let own = strings(row, "kinds");
        if own.is_empty() == string(row, "untried").is_none() {
            faults.push(format!("{id}: has kinds, or says in `untried` why not"));
        }
        let bound_ms = row.get("detected_ms").and_then(Value::as_integer);
        if bound_ms.is_none() == string(row, "unseen").is_none() {
            faults.push(format!("{id}: has detected_ms, or says in `unseen` why not"));
        }
        for kind in own {
            if !kinds.contains(kind) {
                faults.push(format!("{id}: there is no kind of fault {kind}"));
            }
            if let Some(other) = placed.insert(kind, id) {
                faults.push(format!("{kind}: is in {other} and {id}"));
            }
            let p99 = measured.get(kind).copied().flatten();
            if let (Some(bound), Some(p99)) = (bound_ms, p99)
                && (bound as f64) < p99
            {
                faults.push(format!("{id}: {kind} was seen after {p99} ms, not {bound}"));
            }
            if bound_ms.is_none() && p99.is_some() {
                faults.push(format!("{id}: {kind} was seen, so it has a bound"));
            }
        }
        let means = strings(row, "mitigated_by");
        if means.is_empty() {
            faults.push(format!("{id}: nothing mitigates it"));
        }
        let unknown = means.into_iter().filter(|mean| !known.contains(&(*mean).to_owned()));
        faults.extend(unknown.map(|mean| format!("{id}: there is no {mean}")));
    }
    let lost = kinds.iter().filter(|kind| !placed.contains_key(kind.as_str()));
    faults.extend(lost.map(|kind| format!("{kind}: this kind of fault is in no row of fmea.toml")));
}

/// The kinds of faults of `trolley inject`, as lines `Name = "kind",` list them.
fn kinds() -> BTreeSet<String> {
    let text = Text::read(&root().join("crates/lab/src/inject/kind.rs")).text;
    let line = |line: &str| {
        let (_, kind) = line.strip_prefix("    ")?.split_once(" = \"")?;
        kind.strip_suffix("\",").map(str::to_owned)
    };
    text.lines().filter_map(line).collect()
}

/// How long after the deed each kind was noticed in the longest campaign: the 99th percentile (ms),
/// or nothing where it never was.
fn measured() -> BTreeMap<String, Option<f64>> {
    let page = Text::read(&root().join("tools/results/faults.md")).text;
    let mut columns: Option<(usize, usize)> = None;
    let mut measured = BTreeMap::new();
    for line in page.lines() {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        if cells.get(1) == Some(&"fault") {
            let seen = cells.iter().position(|cell| cell.starts_with("seen after"));
            columns = seen.map(|seen| (1, seen + 1)).filter(|(_, p99)| cells[*p99] == "p99");
        } else if let Some((name, p99)) = columns
            && cells.len() > p99
        {
            // The first campaign on the page has all kinds.
            let value = cells[p99].replace(',', "").parse().ok();
            measured.entry(cells[name].to_owned()).or_insert(value);
        } else {
            columns = None;
        }
    }
    measured
}
