//! What a page of a ranking shows as one JSON document, for notebooks and dashboards, and its JSON
//! Schema, which is generated from the types.

use crate::plan::{self, PlanPage};
use crate::work::WorkDone;
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::Serialize;
use trolley::plan::PlanScene;
use trolley::{Answer, Failure};

/// The form of the document.
pub const SCHEMA: &str = "trolley.page/1";

/// What a page of a ranking shows, without the bodies.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(title = "Page of a ranking", rename = "Page")]
pub struct PageDocument<'a> {
    /// The form of this document.
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    /// Name of the scenario.
    scenario: &'a str,
    /// What the page says of the candidate that it opens on.
    title: String,
    /// Whether the first candidate does least harm for all that is known: nothing open can change
    /// it, the model tells it from all others, and neither chance nor what the model does not know
    /// would often have another one first.
    is_least_harm: bool,
    /// The answer, as in `trolley rank --json`: a pure function of the input.
    answer: &'a Answer,
    /// Who is where and when, seen from above. Distances in metres, times in seconds.
    scene: &'a PlanScene,
    /// How the work was done.
    work: &'a WorkDone,
}

/// The document of a page, as indented JSON.
///
/// # Errors
///
/// If it cannot be encoded.
pub fn document(page: &PlanPage<'_>) -> Result<String, Failure> {
    let (title, is_least_harm) = plan::verdict(page.answer);
    let document = PageDocument {
        schema: SCHEMA,
        scenario: page.scenario,
        title,
        is_least_harm,
        answer: page.answer,
        scene: page.scene,
        work: page.work,
    };
    let text = serde_json::to_string_pretty(&document);
    text.map(|text| text + "\n")
        .map_err(|error| Failure::internal(format!("cannot encode the page's document: {error}")))
}

/// The JSON Schema of [`PageDocument`], as indented JSON.
#[must_use]
pub fn schema() -> String {
    // As it is written, not as it would be read: keys that are always there are required.
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let schema = settings.into_generator().into_root_schema_for::<PageDocument<'_>>();
    format!("{:#}\n", schema.as_value())
}

#[cfg(test)]
mod tests;
