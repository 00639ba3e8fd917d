//! The page: a row per collection, and every reason of a refusal with one example.

use super::collection::{Collection, Sort};
use super::watched::Bounds;
use super::{Fate, Outcome};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Longer examples are cut (characters).
const EXAMPLE_MAX: usize = 240;

pub(super) fn text(
    collections: &[Collection],
    outcomes: &[Outcome],
    limits: Bounds,
    commit: &str,
) -> String {
    let mut page = format!(
        "# Files of others\n\n\
         Written by `cargo x inputs FOLDER... --out tools/results/inputs.md`, commit {commit}: the \
         program as built for release,\nonce for each file of the collections below, which are \
         checkouts of public repositories (each folder is called\nOWNER+NAME). Models are made of \
         meshes (`model import`), scenarios of recordings and traces\n(`scenario import`). \
         Scripts of OpenSCENARIO and files of other forms are to be refused, with the way to go.\n\
         Nothing is sorted out: many of these collections hold files that are damaged \
         on purpose. Where the folder is\n`written-by-osi-python`, `tools/traces/convert.py` wrote \
         the traces, with a library of OSI that is not ours, of\nrecordings of the other \
         collections.\n\n\
         *Added*: loaded once the user said what the message asks for: which obstacle is the ego, \
         or in what unit the mesh is. *Fell*:\na panic, a signal, or an exit code that is none of \
         a refusal. A file may take {} s, and all processes for it together {} MiB\nof resident \
         memory: the sum of their peaks, looked at every 5 ms.\n\n",
        limits.time.as_secs(),
        limits.mib
    );
    for sort in Sort::ALL {
        let of_sort: Vec<&Outcome> = outcomes.iter().filter(|one| one.sort == sort).collect();
        if !of_sort.is_empty() {
            section(&mut page, sort, collections, &of_sort);
        }
    }
    page
}

fn section(page: &mut String, sort: Sort, collections: &[Collection], outcomes: &[&Outcome]) {
    let title = sort.plural();
    let first = title[..1].to_uppercase();
    let _w = writeln!(page, "## {first}{}\n", &title[1..]);
    *page += "| collection | commit | files | loaded | of them added | refused | fell | over \
              memory | over time | most MiB | longest s |\n";
    *page += "|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    for (number, collection) in collections.iter().enumerate() {
        let of: Vec<&Outcome> =
            outcomes.iter().copied().filter(|one| one.collection == number).collect();
        if !of.is_empty() {
            let commit = collection.commit.as_deref().unwrap_or("");
            row(page, &collection.name, commit, &of);
        }
    }
    row(page, "**all**", "", outcomes);
    let mut reasons: BTreeMap<String, Vec<(&Outcome, &str)>> = BTreeMap::new();
    for one in outcomes {
        if let Fate::Refused(text) = &one.fate {
            let text = text.strip_prefix(&one.name).unwrap_or(text);
            reasons.entry(reason(text)).or_default().push((one, text));
        }
    }
    let mut reasons: Vec<_> = reasons.into_values().collect();
    reasons.sort_by_key(|all| core::cmp::Reverse(all.len()));
    if !reasons.is_empty() {
        *page += "\nRefused, by reason:\n\n| files | for example | message |\n|--:|---|---|\n";
        for all in reasons {
            let (one, text) = all[0];
            let _w = writeln!(
                page,
                "| {} | {}: {} | {} |",
                all.len(),
                collections[one.collection].name,
                cell(&one.name),
                cell(text.trim_start_matches([':', ' ']))
            );
        }
    }
    let faults: Vec<_> = outcomes
        .iter()
        .filter(|one| !matches!(one.fate, Fate::Loaded | Fate::Refused(_)))
        .collect();
    if !faults.is_empty() {
        *page += "\nFaults:\n\n";
        for one in faults {
            let _w = writeln!(page, "- {}: {}", cell(&one.name), cell(&format!("{:?}", one.fate)));
        }
    }
    page.push('\n');
}

fn row(page: &mut String, name: &str, commit: &str, outcomes: &[&Outcome]) {
    let count = |is: &dyn Fn(&Outcome) -> bool| outcomes.iter().filter(|one| is(one)).count();
    let longest = outcomes.iter().map(|one| one.seconds).fold(0.0, f64::max);
    let most = outcomes.iter().map(|one| one.peak_mib).max().unwrap_or(0);
    let _w = writeln!(
        page,
        "| {name} | {commit} | {} | {} | {} | {} | {} | {} | {} | {most} | {longest:.1} |",
        outcomes.len(),
        count(&|one| one.fate == Fate::Loaded),
        count(&|one| one.fate == Fate::Loaded && one.added.is_some()),
        count(&|one| matches!(one.fate, Fate::Refused(_))),
        count(&|one| matches!(one.fate, Fate::Fell(_))),
        count(&|one| one.fate == Fate::TooMuch),
        count(&|one| one.fate == Fate::TooSlow),
    );
}

/// A message without its place, numbers and names: what messages of one reason have in common.
fn reason(text: &str) -> String {
    let mut out = String::new();
    let mut quoted = false;
    for c in text.split(" — ").next().unwrap_or(text).chars() {
        match c {
            '"' => {
                quoted = !quoted;
                out.push('"');
            }
            _ if quoted || c.is_ascii_digit() => {}
            _ => out.push(c),
        }
    }
    // A list of what is there is of this file.
    out.split("here: ").next().unwrap_or_default().to_owned()
}

/// A text in a cell of a table, on one line, not too long.
fn cell(text: &str) -> String {
    let mut out: String = text.replace(['\n', '\r'], " ").replace('|', "\\|");
    if out.chars().count() > EXAMPLE_MAX {
        out = out.chars().take(EXAMPLE_MAX).collect::<String>() + "…";
    }
    // A lone backtick would begin code.
    out.replace('<', "&lt;").replace('`', "'")
}
