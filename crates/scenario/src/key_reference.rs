//! The reference of all keys, for people: made from the schema, so that both say the same.

use crate::schema;
use serde_json::{Map, Value};
use std::fmt::Write as _;

/// Width of the text, in characters.
const COLUMNS: usize = 100;

/// All keys of a scenario with type, range and meaning, as Markdown: a section for each table, in
/// the order in which a scenario leads to them.
///
/// ```
/// let reference = trolley_scenario::key_reference();
/// assert!(reference.contains("- `horizon_s`: number, 0.001 to 30"));
/// ```
#[must_use]
pub fn key_reference() -> String {
    let schema = schema::value();
    let root = schema.as_value();
    let about = "Made from `trolley schema`: all keys with type, range and meaning. A key is \
                 optional unless it is called required. Units stand in the names: `_m` metres, \
                 `_s` seconds, `_deg` degrees.";
    let mut text = format!("# Keys of a scenario\n\n{}\n", wrapped(about, 0));
    section(&mut text, "The scenario", root);
    let mut named = referred(root);
    let mut next = 0;
    // Ends: each name is added once, and there are finitely many.
    while let Some(name) = named.get(next).cloned() {
        let table = &root["$defs"][&name];
        section(&mut text, &name, table);
        for found in referred(table) {
            if !named.contains(&found) {
                named.push(found);
            }
        }
        next += 1;
    }
    text
}

/// A table: what it is, and its keys.
fn section(text: &mut String, name: &str, table: &Value) {
    let about = table["description"].as_str().unwrap_or_default();
    // Writing to a text cannot fail.
    let _written = write!(text, "\n## {name}\n\n{}\n", wrapped(about, 0));
    let required: Vec<&str> =
        table["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    for (key, value) in table["properties"].as_object().into_iter().flatten() {
        let needed = if required.contains(&key.as_str()) { ", required" } else { "" };
        let line = format!("`{key}`: {}{needed}. {}", kind(value), meaning(value));
        let _written = write!(text, "\n- {}", wrapped(line.trim_end(), 2));
    }
    text.push('\n');
}

/// What a key means, in its own words.
fn meaning(value: &Value) -> &str {
    value["description"].as_str().unwrap_or_default()
}

/// The names of the tables that the keys of a table lead to.
fn referred(table: &Value) -> Vec<String> {
    let mut names = Vec::new();
    for value in table["properties"].as_object().into_iter().flat_map(Map::values) {
        let found = [value, &value["items"], &value["additionalProperties"]].map(reference);
        for name in found.into_iter().flatten() {
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    names
}

/// The table that a value refers to.
fn reference(value: &Value) -> Option<String> {
    value["$ref"].as_str()?.strip_prefix("#/$defs/").map(str::to_owned)
}

/// Type and range of a value: "number, 0 to 1", "list of Candidate, 1 to 16".
fn kind(value: &Value) -> String {
    if let Some(name) = reference(value) {
        return format!("table, see {name}");
    }
    if let Some(known) = value.get("const") {
        return known.to_string();
    }
    if let Some(known) = value["enum"].as_array() {
        let known: Vec<String> = known.iter().map(Value::to_string).collect();
        return format!("one of {}", known.join(", "));
    }
    let range = |least: &str, most: &str| match (&value[least], &value[most]) {
        (Value::Null, Value::Null) => String::new(),
        (least, Value::Null) => format!(", {} at least", number(least)),
        (Value::Null, most) => format!(", {} at most", number(most)),
        (least, most) => format!(", {} to {}", number(least), number(most)),
    };
    match value["type"].as_str().unwrap_or_default() {
        "string" => format!("text{}", range("minLength", "maxLength")),
        "number" => format!("number{}", range("minimum", "maximum")),
        "integer" => format!("whole number{}", range("minimum", "maximum")),
        "boolean" => "true or false".to_owned(),
        "array" => {
            let item = &value["items"];
            let of = reference(item).unwrap_or_else(|| kind(item));
            format!("list of {}{}", of, range("minItems", "maxItems"))
        }
        "object" => {
            let of = reference(&value["additionalProperties"]).unwrap_or_default();
            format!("table by name, of {of}")
        }
        _ => "value".to_owned(),
    }
}

/// A number without a needless ".0".
fn number(value: &Value) -> String {
    let text = value.to_string();
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// A line broken at spaces; those after the first are indented.
fn wrapped(line: &str, indent: usize) -> String {
    let mut text = String::new();
    let mut column = indent;
    for word in line.split(' ') {
        let width = word.chars().count();
        if !text.is_empty() && column + 1 + width > COLUMNS {
            text.push('\n');
            text.push_str(&" ".repeat(indent));
            column = indent;
        } else if !text.is_empty() {
            text.push(' ');
            column += 1;
        }
        text.push_str(word);
        column += width;
    }
    text
}

#[cfg(test)]
mod tests {
    //! Every key is there, with a meaning.

    use super::*;

    #[test]
    fn every_key_of_the_schema_is_described() {
        let reference = key_reference();
        let schema = schema::value();
        let root = schema.as_value();
        let tables = root["$defs"].as_object().expect("tables").values().chain([root]);
        let mut count = 0;
        for table in tables {
            assert!(!meaning(table).is_empty(), "a table without a meaning");
            for (key, value) in table["properties"].as_object().into_iter().flatten() {
                let is_told = !meaning(value).is_empty() || reference_is_told(root, value);
                assert!(is_told, "{key} has no meaning");
                assert!(
                    reference.contains(&format!("\n- `{key}`: {}", &kind(value)[..4])),
                    "{key}"
                );
                count += 1;
            }
        }
        assert!(count > 60, "{count} keys");
        assert!(reference.lines().all(|line| line.chars().count() <= COLUMNS));
    }

    /// A key that is a table of its own has the meaning of that table.
    fn reference_is_told(root: &Value, value: &Value) -> bool {
        super::reference(value).is_some_and(|name| !meaning(&root["$defs"][&name]).is_empty())
    }

    #[test]
    fn the_page_is_what_the_program_prints() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/keys.md");
        // A package by itself has no pages.
        let Ok(page) = std::fs::read_to_string(path) else { return };
        assert!(page == key_reference(), "run: trolley help keys > docs/keys.md");
    }
}
