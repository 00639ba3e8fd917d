//! Errors of the TOML reader in the scenario's own terms.
//!
//! The reader's messages are for programmers ("unknown field `suvv`, expected one of `a`, `b`").
//! Their first words and the names between backticks are used; a message that is not understood is
//! passed on as it is, so that nothing is lost if the wording changes. `scenario/tests.rs` holds
//! the wording.

use crate::document::{Objection, Path};
use crate::engine::EngineSettings;
use crate::limit;
use crate::names::{choices, quoted};

/// Words for what a person is. None of them is an input, wherever they are written.
const TRAITS: &[&str] = &[
    "age",
    "age_years",
    "sex",
    "gender",
    "race",
    "ethnicity",
    "nationality",
    "religion",
    "health",
    "condition",
    "disability",
    "fitness",
    "income",
    "status",
    "occupation",
    "pregnant",
    "child",
    "height_m",
    "weight_kg",
];

/// Fault and remedy of an objection.
pub(crate) fn explain(objection: &Objection) -> (String, String) {
    let message = one_line(&objection.message);
    let Some(path) = &objection.path else {
        let help = if message.contains(" stands here a second time") {
            keys::Twice::REMEDY
        } else {
            "a scenario is TOML: key = value lines under [table] headers, text in quotes"
        };
        return (shortened(&message), help.to_owned());
    };
    if message.starts_with("unknown field") {
        return unknown_key(path, &message);
    }
    if let Some(key) = message.strip_prefix("missing field ") {
        let key = key.trim_matches('`');
        let place = if path.0.is_empty() { String::new() } else { format!(" in {path}") };
        return (format!("{key:?} is missing{place}"), format!("add {key} = …; {SEE_SCHEMA}"));
    }
    let subject = path.last_key().map_or_else(String::new, |key| format!("{}: ", quoted(key)));
    let help = match path.last_key() {
        Some("candidates") => {
            "each candidate is a table of its own under [[candidates]]".to_owned()
        }
        // Earlier versions read "auto".
        Some("depth") => format!(
            "write a number of levels, {}; the default is {}",
            limit::DEPTH.range(),
            EngineSettings::DEFAULT.depth
        ),
        _ => SEE_SCHEMA.to_owned(),
    };
    (shortened(&format!("{subject}{}", in_plain_words(&message))), help)
}

const SEE_SCHEMA: &str = "`trolley schema` prints every key with its type, unit and range";

/// A key that is unknown at its place.
fn unknown_key(path: &Path, message: &str) -> (String, String) {
    let key = path.last_key().unwrap_or_default();
    let known = backticked(message.rsplit_once(", expected ").map_or("", |(_, known)| known));
    if path.passes("persons") || TRAITS.contains(&key) {
        let fault = format!("{} of a person is not an input", quoted(key));
        let carried = if known.contains(&"count") { "seat and count" } else { "a seat" };
        let help =
            format!("persons carry {carried} only: who somebody is never weighs in a ranking");
        return (fault, help);
    }
    let parent = Path(path.0[..path.0.len().saturating_sub(1)].to_vec());
    let place = if parent.0.is_empty() { String::new() } else { format!(" in {parent}") };
    let list = format!("keys known here: {}", known.join(", "));
    (format!("key {} is not known{place}", quoted(key)), choices(&list, &known, key))
}

/// The names between backticks.
fn backticked(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).collect()
}

/// Types by the names that people use.
fn in_plain_words(message: &str) -> String {
    message
        .replace("invalid type: ", "found ")
        .replace("invalid value: ", "found ")
        .replace("invalid length ", "found a list of length ")
        .replace("` as i128", "`")
        .replace("expected f64", "expected a number")
        .replace("expected i64", "expected a whole number")
        .replace("expected a string", "expected text in quotes")
        .replace("expected a map", "expected a table")
        .replace("expected a sequence", "expected a list")
        .replace("floating point `", "the number `")
        .replace("integer `", "the number `")
        .replace("boolean `", "`")
        .replace(": string \"", ": \"")
        .replace("found string \"", "found \"")
        .replace("found sequence", "found a list")
        .replace("found map", "found a table")
        .replace("an array of length", "a list of length")
}

/// Several lines as one, without control characters.
fn one_line(message: &str) -> String {
    let lines: Vec<&str> = message.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    lines.join(", ").chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

/// What fits two lines of a terminal: a message may quote a value of any length.
fn shortened(message: &str) -> String {
    const SHOWN: usize = 160;
    match message.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &message[..end]),
        None => message.to_owned(),
    }
}
