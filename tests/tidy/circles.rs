//! Which file of a crate refers to which other, and whether the references are circular.

use crate::code::{braces, in_word};
use crate::pure::outside_tests_of;
use crate::tree::Package;
use std::collections::{BTreeMap, BTreeSet};

/// Files of a crate by the paths of their modules, with the modules that each names; the crate's
/// root is the empty path.
pub(crate) type Names = BTreeMap<String, BTreeSet<String>>;

/// Who names whom in a package. What is only there for tests does not count.
pub(crate) fn names(package: &Package) -> Names {
    let modules = outside_tests_of(package).into_iter().map(|(file, code)| {
        let (_, path) = file.path.split_once("/src/").expect("a file below src");
        let path = path.strip_suffix(".rs").expect("a file of Rust").replace('/', "::");
        (if path == "main" || path == "lib" { String::new() } else { path }, code)
    });
    names_in(&modules.collect())
}

/// Who names whom among modules with this code.
pub(crate) fn names_in(modules: &BTreeMap<String, String>) -> Names {
    let nearest = |mut path: &str| {
        while !modules.contains_key(path) {
            path = path.rsplit_once("::").map_or("", |(above, _)| above);
        }
        path.to_owned()
    };
    let named = |(module, code): (&String, &String)| {
        let mut named: BTreeSet<String> =
            paths(module, code).iter().map(|path| nearest(path)).collect();
        named.remove(module);
        (module.clone(), named)
    };
    modules.iter().map(named).collect()
}

/// The modules that are part of a circle, or lie between two.
pub(crate) fn circles(mut names: Names) -> BTreeSet<String> {
    loop {
        let named: BTreeSet<String> = names.values().flatten().cloned().collect();
        let before = names.len();
        names.retain(|module, names| named.contains(module) && !names.is_empty());
        let left: BTreeSet<String> = names.keys().cloned().collect();
        names.values_mut().for_each(|names| names.retain(|name| left.contains(name)));
        if names.len() == before {
            return left;
        }
    }
}

/// The paths in a module's code that begin with `crate`, `super` or `mod`, from the root.
fn paths(module: &str, code: &str) -> Vec<String> {
    let below = |above: &str, path: String| match above {
        "" => path,
        above => format!("{above}::{path}"),
    };
    let mut paths = Vec::new();
    for (start, rest) in behind(code, "crate::") {
        if !code[..start].ends_with("$") {
            paths.extend(expanded(rest));
        }
    }
    for (start, mut rest) in behind(code, "super::") {
        if code[..start].ends_with("super::") {
            continue;
        }
        let mut above = module.rsplit_once("::").map_or("", |(above, _)| above);
        while let Some(further) = rest.strip_prefix("super::") {
            (above, rest) = (above.rsplit_once("::").map_or("", |(above, _)| above), further);
        }
        paths.extend(expanded(rest).into_iter().map(|path| below(above, path)));
    }
    for (_, rest) in behind(code, "mod ") {
        let name: String = rest.chars().take_while(|c| in_word(*c)).collect();
        if rest[name.len()..].starts_with(';') {
            paths.push(below(module, name));
        }
    }
    paths
}

/// Where a word stands in code, and what follows it.
fn behind<'c>(code: &'c str, word: &'c str) -> impl Iterator<Item = (usize, &'c str)> {
    let found = code.match_indices(word).filter(|(at, _)| !code[..*at].ends_with(in_word));
    found.map(|(at, _)| (at, &code[at + word.len()..]))
}

/// The paths that text begins with: one, or those of a list in braces.
fn expanded(text: &str) -> Vec<String> {
    let text = text.trim_start();
    if text.starts_with('{') {
        let mut depth = 0;
        let items = text[1..braces(text) - 1].split(|c| {
            depth += i32::from(c == '{') - i32::from(c == '}');
            c == ',' && depth == 0
        });
        return items.filter(|item| !item.trim().is_empty()).flat_map(expanded).collect();
    }
    let name: String = text.chars().take_while(|c| in_word(*c)).collect();
    match text[name.len()..].strip_prefix("::") {
        Some(rest) => expanded(rest).into_iter().map(|path| format!("{name}::{path}")).collect(),
        None => vec![name],
    }
}
