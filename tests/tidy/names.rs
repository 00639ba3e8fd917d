//! Names: no former ones, one public type per name, closures that a search finds; and an example
//! for every public item of the library.

use super::code::{code, words};
use super::tree::{Text, all_sources};
use std::collections::BTreeMap;

/// Names that stood for what the field calls otherwise: where (a prefix of paths; empty:
/// everywhere), the former name, the name to use.
const FORMER: &[(&str, &str, &str)] = &[
    ("", "Desk", "JobLoop, RequestQueue or a scratch"),
    ("", "Crew", "WorkerPool"),
    ("", "crew", "worker_pool or occupants"),
    ("", "Station", "WorkerHandle"),
    ("", "station", "worker_handle"),
    ("", "Team", "BuildPool or ServiceBackend"),
    ("", "team", "pool or backend"),
    ("", "Together", "Parallel"),
    ("", "together", "parallel"),
    ("", "here", "in_process"),
    ("", "Room", "RunBuffers"),
    ("", "room", "buffers"),
    ("", "Spare", "a pool"),
    ("", "Errand", "TaskState"),
    ("", "Errands", "TaskSource"),
    ("", "errand", "task"),
    ("", "Spec", "Job"),
    ("", "Work", "Interval, JobSource or RankingRun"),
    ("", "Misdeed", "InjectedFault"),
    ("", "misdeed", "fault"),
    ("", "Order", "FaultCommand or RankOrder"),
    ("crates/protocol/", "order", "fault"),
    ("", "Spoiled", "Corruption"),
    ("", "Spoilt", "Corruption"),
    ("", "spoil", "corrupt"),
    ("", "Parcel", "chunk"),
    ("", "Parcels", "Chunks"),
    ("", "parcel", "chunk"),
    ("", "Lack", "MissingRequirement"),
    ("", "Terms", "RequestLimits or WeightedRules"),
    ("", "terms", "request_limits"),
    ("", "Pursuit", "SearchOrder"),
    ("", "Brief", "AnswerView"),
    ("", "brief", "answer_view"),
    ("", "keep", "recording, store or retain"),
    ("", "Ledger", "JobHistory or CacheModel"),
    ("", "ledger", "job_history or cache_model"),
    ("", "Sight", "Observation"),
    ("crates/coordinator/", "see", "observe"),
    ("", "man", "spawn"),
    ("", "bury", "reap"),
    ("", "anew", "reset_for"),
    ("crates/coordinator/", "part", "terminate"),
    ("crates/service/", "part", "refuse_waiting"),
    ("", "lay_to_rest", "detach"),
    ("crates/coordinator/", "Case", "CandidateState"),
    ("crates/coordinator/", "case", "candidate_state"),
    ("", "Aim", "Purpose"),
    ("", "moot", "obsolete"),
    ("", "is_moot", "is_obsolete"),
    ("", "Attendant", "IdleHook"),
    ("", "bell", "wake_fd"),
    ("", "ring", "notify"),
    ("", "hush", "drain"),
    ("", "Yard", "ParallelBuild"),
    ("", "hurry", "apply_realtime"),
    ("", "Site", "ServiceConfig"),
    ("", "Word", "ChildMessage or Named"),
    ("", "Chance", "Rng"),
    ("", "Dice", "Rng"),
    ("", "Draw", "Rng or RngKey"),
    ("crates/bvh/src/build", "seed", "paper"),
    ("", "Inquiry", "RankingRequest"),
    ("", "Handing", "DispatchOptions"),
];

/// Former names of variants of enums.
const FORMER_VARIANTS: &[(&str, &str)] = &[
    ("Build::Seed", "Build::Paper"),
    ("StillBorn", "ExitedAtStart"),
    ("Mute", "HandshakeTimeout"),
];

/// Public types of one name that may stand in two crates, and why.
const TWICE: &[(&str, &str)] =
    &[("Scenario", "trolley's is scenario's with the texts that it names: policy and curves")];

/// Names of closures that no search can find among the words of the language.
const UNSEARCHABLE: [&str; 4] = ["of", "at", "one", "each"];

/// The keyword that defines something in this line of code, whether it is public, and the name.
fn defined(line: &str) -> Option<(&str, bool, &str)> {
    let mut words = words(line).skip_while(|word| matches!(*word, "crate" | "super" | "in"));
    let is_public = line.trim_start().starts_with("pub ");
    let keyword = words.find(|word| {
        !matches!(*word, "pub" | "crate" | "super" | "const" | "unsafe" | "async" | "extern")
    })?;
    let is_item = matches!(keyword, "struct" | "enum" | "union" | "trait" | "type" | "fn" | "mod");
    let name = words.next()?;
    is_item.then_some((keyword, is_public, name))
}

/// Whether a file is there for tests alone.
fn is_test(file: &Text) -> bool {
    ["tests/", "/tests/", "/tests.rs", "/benches/", "/examples/"]
        .iter()
        .any(|part| file.path.starts_with("tests/") || file.path.contains(part))
}

/// Definitions under a former name.
pub(crate) fn former() -> Vec<String> {
    let mut faults = Vec::new();
    let mut seen = 0;
    for file in &all_sources() {
        for (number, line) in code(&file.text).lines().enumerate() {
            if let Some((_, _, name)) = defined(line) {
                seen += 1;
                let known = FORMER
                    .iter()
                    .find(|(at, known, _)| *known == name && file.path.starts_with(at));
                if let Some((_, _, now)) = known {
                    faults.push(file.fault(number, &format!("{name} is called {now}")));
                }
            }
            for (variant, now) in FORMER_VARIANTS {
                let is_there = match variant.split_once("::") {
                    Some(_) => line.contains(variant),
                    None => words(line).any(|word| word == *variant),
                };
                if is_there {
                    faults.push(file.fault(number, &format!("{variant} is called {now}")));
                }
            }
        }
    }
    assert!(seen > 3_000, "only {seen} definitions: does this still read Rust?");
    faults
}

/// Public types that share their name with another one.
pub(crate) fn doubles() -> Vec<String> {
    let mut all: BTreeMap<String, Vec<(String, usize)>> = BTreeMap::new();
    for file in all_sources().iter().filter(|file| !is_test(file)) {
        for (number, line) in code(&file.text).lines().enumerate() {
            let Some((keyword, true, name)) = defined(line) else { continue };
            // Of a trait, `type` is what each implementation has for itself.
            let is_nested = keyword == "type" && line.starts_with(' ');
            if !matches!(keyword, "fn" | "mod") && !is_nested {
                all.entry(name.to_owned()).or_default().push((file.path.clone(), number));
            }
        }
    }
    assert!(all.len() > 300, "only {} public types: does this still read Rust?", all.len());
    let unused = TWICE.iter().filter(|(name, _)| all.get(*name).is_none_or(|at| at.len() < 2));
    let unused: Vec<String> =
        unused.map(|(name, _)| format!("{name} stands once: take it out of TWICE")).collect();
    let may = |name: &str| TWICE.iter().any(|(known, _)| *known == name);
    let doubles = all.iter().filter(|(name, at)| at.len() > 1 && !may(name));
    let fault = |(name, at): (&String, &Vec<(String, usize)>)| {
        let places: Vec<String> =
            at.iter().map(|(path, number)| format!("{path}:{}", number + 1)).collect();
        format!("{name} is several types: {}", places.join(", "))
    };
    doubles.map(fault).chain(unused).collect()
}

/// Closures called like words of every sentence.
pub(crate) fn unsearchable() -> Vec<String> {
    let mut faults = Vec::new();
    for file in &all_sources() {
        for (number, line) in code(&file.text).lines().enumerate() {
            let Some(rest) = line.trim_start().strip_prefix("let ") else { continue };
            let rest = rest.strip_prefix("mut ").unwrap_or(rest);
            let Some((name, value)) = rest.split_once(" = ") else { continue };
            let is_closure = value.starts_with(['|']) || value.starts_with("move |");
            if is_closure && UNSEARCHABLE.contains(&name) {
                faults.push(file.fault(number, &format!("a closure called {name}")));
            }
        }
    }
    faults
}

/// Public items and methods of the library without an example.
pub(crate) fn without_example() -> Vec<String> {
    let (mut faults, mut seen) = (Vec::new(), 0);
    for file in all_sources().iter().filter(|file| !is_test(file)) {
        if !file.path.starts_with("crates/trolley/src/") {
            continue;
        }
        let mut has_example = false;
        for (number, line) in file.text.lines().enumerate() {
            let line = line.trim_start();
            let is_documentation = line.starts_with("///");
            if is_documentation || line.starts_with("#[") {
                has_example |= is_documentation && line.contains("```");
                continue;
            }
            // A field is documented with its type, a module in its own file.
            if let Some((keyword, true, name)) = defined(line)
                && keyword != "mod"
            {
                seen += 1;
                if !has_example {
                    faults.push(file.fault(number, &format!("{name} has no example")));
                }
            }
            has_example = false;
        }
    }
    assert!(seen > 100, "only {seen} public items: does this still read Rust?");
    faults
}
