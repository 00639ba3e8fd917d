//! The JSON Schema of a scenario, for editors and for other programs that write scenarios.
//!
//! It says what a schema can say: names, types, ranges, units. That a party is defined or that no
//! two candidates have one name it cannot say; so the parser is stricter, never laxer.

use crate::scenario::raw;
use schemars::{Schema, generate::SchemaSettings, transform::RecursiveTransform};

/// JSON Schema (draft 2020-12) of a scenario file, indented.
///
/// ```
/// let schema = trolley_scenario::schema();
/// assert!(schema.contains("\"horizon_s\""));
/// ```
#[must_use]
pub fn schema() -> String {
    format!("{:#}\n", value().as_value())
}

/// The schema as a value.
pub(crate) fn value() -> Schema {
    let settings = SchemaSettings::draft2020_12().with_transform(RecursiveTransform(tidy));
    settings.into_generator().into_root_schema_for::<raw::Scenario>()
}

/// Descriptions on one line; no null, since TOML leaves out what is optional.
fn tidy(schema: &mut Schema) {
    let Some(object) = schema.as_object_mut() else { return };
    if let Some(text) = object.get_mut("description")
        && let Some(line) = text.as_str().map(|lines| lines.replace('\n', " "))
    {
        *text = line.into();
    }
    if let Some(types) = object.get_mut("type")
        && let Some(list) = types.as_array_mut()
    {
        list.retain(|name| name != "null");
        if let [only] = list.as_slice() {
            *types = only.clone();
        }
    }
    // An optional table is `anyOf: [reference, null]`.
    if let Some(choices) = object.get_mut("anyOf").and_then(|any| any.as_array_mut()) {
        choices.retain(|choice| choice.get("type").is_none_or(|name| name != "null"));
        if let [only] = choices.as_slice()
            && let Some(only) = only.as_object().cloned()
        {
            object.remove("anyOf");
            object.extend(only);
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
