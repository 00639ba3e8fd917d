//! Fault orders and deliberate flaws: code that refers to them is behind a feature, and only one
//! crate enables it.

use crate::code::{braces, code, words};
use crate::pure::left_of;
use crate::tree::{Package, Text, workspace_dependencies};
use std::collections::BTreeSet;
use toml::{Table, Value};

/// The feature of a crate that holds them.
const FEATURE: &str = "faults";
/// The package that is there for them, and turns them on in others.
pub(crate) const LAB: &str = "lab";
/// The package that brings it, and the feature that does so, as its default alone does.
const BINARY: (&str, &str) = ("cli", "lab");
/// What stands before an item that not every build has.
const MARKS: [&str; 4] = [
    "#[cfg(feature = \"faults\")]",
    "#[cfg(any(test, feature = \"faults\"))]",
    "#[cfg(feature = \"lab\")]",
    "#[cfg(test)]",
];
/// Names that contain one of these exist for faults.
const STEMS: [&str; 6] = ["injectedfault", "faultcommand", "misbehav", "corrupt", "flaw", "obey"];
/// Words that every build has, so that all have the same layouts.
const RESERVED: [&str; 2] = ["obeyed_ns", "Corrupt"];

/// The packages that have the feature.
pub(crate) fn with_feature(packages: &[Package]) -> Vec<&Package> {
    let has = |package: &&Package| package.value(&["features", FEATURE]).is_some();
    packages.iter().filter(has).collect()
}

/// Where a package's faults are named by what every build has, and how often they are named by the
/// rest.
pub(crate) fn ungated(package: &Package) -> (Vec<String>, usize) {
    let naming = |text: &str| -> Vec<(usize, String)> {
        let lines = text.lines().enumerate();
        lines.flat_map(|(line, code)| named(code).map(move |word| (line, word))).collect()
    };
    let mut faults = Vec::new();
    for (file, left) in left_of(package, outside_marks) {
        let found = naming(&left);
        faults.extend(found.into_iter().map(|(line, word)| {
            file.fault(line, &format!("{word} stands behind no feature: see MARKS"))
        }));
    }
    let all = left_of(package, |text| (code(text), Vec::new()));
    let all: usize = all.iter().map(|(_, code)| naming(code).len()).sum();
    let gated = all.saturating_sub(faults.len());
    (faults, gated)
}

/// The words of a line of code that are there for faults.
fn named(line: &str) -> impl Iterator<Item = String> {
    words(line)
        .filter(|word| !RESERVED.contains(word))
        .filter(|word| STEMS.iter().any(|stem| word.to_lowercase().contains(stem)))
        .map(str::to_owned)
}

/// What is left of a file's code once every item behind one of [`MARKS`] is blanked, and the
/// modules among these that have a file of their own.
pub(crate) fn outside_marks(text: &str) -> (String, Vec<String>) {
    let code = code(text);
    let (mut left, mut modules) = (String::new(), Vec::new());
    // Where what is not blanked goes on, and where the line begins.
    let (mut from, mut start) = (0, 0);
    for (line, blank) in text.lines().zip(code.split_inclusive('\n')) {
        let end = start + blank.len();
        if start >= from && MARKS.contains(&line.trim()) {
            let (length, module) = item(&code[end..]);
            modules.extend(module);
            left.push_str(&code[from..start]);
            from = end + length;
            left.extend(code[start..from].matches('\n'));
        }
        start = end;
    }
    left.push_str(&code[from..]);
    (left, modules)
}

/// The length of the item, field, arm or statement that code begins with, or of less: up to the
/// first of its braces that closes. And its name, if it is a module in another file.
fn item(code: &str) -> (usize, Option<String>) {
    let mut depth = 0;
    for (at, c) in code.char_indices() {
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' if depth > 0 => depth -= 1,
            '{' if depth == 0 => return (at + braces(&code[at..]), None),
            ')' | ']' | '}' if depth == 0 => return (at, None),
            // One within a line stands between parameters of a type.
            ',' if depth == 0 && code[at..].starts_with(",\n") => return (at + 1, None),
            ';' if depth == 0 => {
                let mut names = words(&code[..at]).skip_while(|word| *word != "mod");
                return (at + 1, names.nth(1).map(str::to_owned));
            }
            _ => {}
        }
    }
    (code.len(), None)
}

/// What turns the feature on that must not, in the manifests of the packages and of the workspace.
pub(crate) fn turned_on(packages: &[Package], workspace: &Text) -> Vec<String> {
    let mut faults = Vec::new();
    let is = |entry: &str, feature: &str| {
        entry == feature || entry.rsplit_once('/').is_some_and(|(_, name)| name == feature)
    };
    for package in packages {
        let features = package.value(&["features"]).and_then(Value::as_table);
        for (feature, list) in features.into_iter().flatten() {
            let by = (package.name.as_str(), feature.as_str());
            for entry in strings(list) {
                let may_be_on = feature == FEATURE;
                let may_be_lab = by == (BINARY.0, "default");
                let brings = entry == "dep:lab" && by != BINARY;
                if (is(entry, FEATURE) && !may_be_on)
                    || (is(entry, BINARY.1) && !may_be_lab)
                    || brings
                {
                    let fault = format!("{feature} turns on {entry}");
                    faults.push(package.manifest.fault(0, &fault));
                }
            }
        }
        for (name, entry) in package.built_with() {
            let is_on = features_of(entry).any(|feature| feature == FEATURE);
            let is_optional = entry.get("optional").and_then(Value::as_bool) == Some(true);
            if package.name != LAB && (is_on || (name == LAB && !is_optional)) {
                let fault = format!("{name} with {FEATURE}, in every build");
                faults.push(package.manifest.fault(0, &fault));
            }
        }
    }
    for (name, entry) in &workspace_dependencies() {
        if features_of(entry).any(|feature| feature == FEATURE) {
            faults.push(workspace.fault(0, &format!("{name} with {FEATURE}, for everybody")));
        }
    }
    faults
}

/// The packages whose faults the lab turns on, directly or by those of another.
pub(crate) fn of_the_lab(packages: &[Package]) -> BTreeSet<String> {
    let list = |package: &str, feature: &str| -> Vec<String> {
        let package = packages.iter().find(|known| known.name == package);
        let list = package.and_then(|package| package.value(&["features", feature]));
        let on = list.into_iter().flat_map(strings).filter_map(|entry| {
            let (package, feature) = entry.split_once('/')?;
            (feature == FEATURE).then(|| package.to_owned())
        });
        on.collect()
    };
    let lab = packages.iter().find(|package| package.name == LAB);
    let direct = lab.into_iter().flat_map(Package::built_with);
    let direct = direct.filter(|(_, entry)| features_of(entry).any(|feature| feature == FEATURE));
    let mut open: Vec<String> = direct.map(|(name, _)| name.to_owned()).collect();
    let mut on = BTreeSet::new();
    while let Some(next) = open.pop() {
        if on.insert(next.clone()) {
            open.extend(list(&next, FEATURE));
        }
    }
    on
}

fn strings(list: &Value) -> impl Iterator<Item = &str> {
    list.as_array().into_iter().flatten().filter_map(Value::as_str)
}

fn features_of(dependency: &Value) -> impl Iterator<Item = &str> {
    dependency
        .as_table()
        .and_then(|table: &Table| table.get("features"))
        .into_iter()
        .flat_map(strings)
}
