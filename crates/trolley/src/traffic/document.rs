//! What an import says: as a document for JSON, and in words.

use super::ImportedTraffic;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::Path;

/// The JSON document of an import, from [`ImportedTraffic::document`].
///
/// ```
/// # let folder = std::env::temp_dir().join(format!("trolley-made-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let path = folder.join("crossing.xml");
/// # let state = |x: f64, more: &str| format!(
/// #     "<initialState><position><point><x>{x}</x><y>0</y></point></position><orientation>\
/// #      <exact>0</exact></orientation><time><exact>0</exact></time>{more}</initialState>"
/// # );
/// # let text = format!(
/// #     "<commonRoad commonRoadVersion=\"2020a\" timeStepSize=\"0.1\" benchmarkID=\"Test\">\
/// #      <staticObstacle id=\"7\"><type>parkedVehicle</type>\
/// #      <shape><rectangle><length>4</length>\
/// #      <width>1.8</width></rectangle></shape>{}</staticObstacle>\
/// #      <planningProblem id=\"1\">{}</planningProblem></commonRoad>",
/// #     state(25.0, ""),
/// #     state(0.0, "<velocity><exact>15</exact></velocity>"),
/// # );
/// # trolley::files::replace(&path, text.as_bytes())?;
/// # use trolley::traffic::{TrafficOptions, import};
/// let imported = import(&path, &TrafficOptions::default())?;
/// assert_eq!(imported.document(&path).schema, "trolley.scenario-import/2");
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Debug, Serialize)]
pub struct ImportDocument<'a> {
    /// Name and version of this form.
    pub schema: &'static str,
    /// The traffic file.
    pub file: String,
    /// The name that it gives itself.
    pub name: &'a str,
    /// The scenario, as TOML.
    pub scenario: &'a str,
    /// Until when everybody is followed (s).
    pub horizon_s: f64,
    /// What was assumed or left out, in whole sentences without full stops.
    pub notes: &'a [String],
}

impl ImportedTraffic {
    /// Returns the import as a document for JSON; `path` is the traffic file.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join(format!("trolley-made-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let path = folder.join("crossing.xml");
    /// # let state = |x: f64, more: &str| format!(
    /// #     "<initialState><position><point><x>{x}</x><y>0</y></point></position><orientation>\
    /// #      <exact>0</exact></orientation><time><exact>0</exact></time>{more}</initialState>"
    /// # );
    /// # let text = format!(
    /// #     "<commonRoad commonRoadVersion=\"2020a\" timeStepSize=\"0.1\" benchmarkID=\"Test\">\
    /// #      <staticObstacle id=\"7\"><type>parkedVehicle</type>\
    /// #      <shape><rectangle><length>4</length>\
    /// #      <width>1.8</width></rectangle></shape>{}</staticObstacle>\
    /// #      <planningProblem id=\"1\">{}</planningProblem></commonRoad>",
    /// #     state(25.0, ""),
    /// #     state(0.0, "<velocity><exact>15</exact></velocity>"),
    /// # );
    /// # trolley::files::replace(&path, text.as_bytes())?;
    /// # use trolley::traffic::{TrafficOptions, import};
    /// let imported = import(&path, &TrafficOptions::default())?;
    /// assert_eq!(imported.document(&path).schema, "trolley.scenario-import/2");
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn document(&self, path: &Path) -> ImportDocument<'_> {
        ImportDocument {
            schema: "trolley.scenario-import/2",
            file: path.display().to_string(),
            name: &self.recording.name,
            scenario: &self.text,
            horizon_s: self.horizon_s,
            notes: &self.notes,
        }
    }

    /// Returns in words what the scenario is made from: one fact a line.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join(format!("trolley-made-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let path = folder.join("crossing.xml");
    /// # let state = |x: f64, more: &str| format!(
    /// #     "<initialState><position><point><x>{x}</x><y>0</y></point></position><orientation>\
    /// #      <exact>0</exact></orientation><time><exact>0</exact></time>{more}</initialState>"
    /// # );
    /// # let text = format!(
    /// #     "<commonRoad commonRoadVersion=\"2020a\" timeStepSize=\"0.1\" benchmarkID=\"Test\">\
    /// #      <staticObstacle id=\"7\"><type>parkedVehicle</type>\
    /// #      <shape><rectangle><length>4</length>\
    /// #      <width>1.8</width></rectangle></shape>{}</staticObstacle>\
    /// #      <planningProblem id=\"1\">{}</planningProblem></commonRoad>",
    /// #     state(25.0, ""),
    /// #     state(0.0, "<velocity><exact>15</exact></velocity>"),
    /// # );
    /// # trolley::files::replace(&path, text.as_bytes())?;
    /// # use trolley::traffic::{TrafficOptions, import};
    /// let imported = import(&path, &TrafficOptions::default())?;
    /// assert!(imported.summary().starts_with("Test: 1 obstacle"));
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn summary(&self) -> String {
        let count = self.recording.others.len();
        let plural = if count == 1 { "" } else { "s" };
        let (name, horizon_s) = (&self.recording.name, self.horizon_s);
        let mut text = format!("{name}: {count} obstacle{plural}, followed over {horizon_s} s");
        for note in &self.notes {
            let _w = write!(text, "\nNote: {note}.");
        }
        text
    }
}
