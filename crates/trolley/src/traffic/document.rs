//! What an import says: as documents for JSON, and in words.

use super::ImportedTraffic;
use crate::Failure;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::Path;
use traffic::{Conflict, Manoeuvre};

/// A meeting in the JSON document.
#[derive(Serialize)]
struct MeetingRow<'a> {
    manoeuvre: String,
    after_s: f64,
    ego_m: [f64; 2],
    ego_yaw_rad: f64,
    ego_speed_m_s: f64,
    other: &'a str,
    kind: &'a str,
    other_m: [f64; 2],
    other_yaw_rad: f64,
    other_speed_m_s: f64,
}

/// The JSON document of an import, from [`ImportedTraffic::document`].
///
/// ```
/// # let folder = std::env::temp_dir().join(format!("trolley-document-{}", std::process::id()));
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
/// use trolley::traffic::{TrafficOptions, import};
///
/// let imported = import(&path, &TrafficOptions::default())?;
/// let json = serde_json::to_string(&imported.document(&path));
/// assert!(json.is_ok_and(|json| json.contains("trolley.scenario-import/1")));
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Serialize)]
pub struct Document<'a> {
    schema: &'static str,
    file: String,
    name: &'a str,
    scenario: Option<&'a str>,
    meetings: Vec<MeetingRow<'a>>,
    /// Manoeuvres that do not collide.
    free: Vec<String>,
    horizon_s: f64,
    notes: &'a [String],
}

/// The JSON document of an import over a horizon, from [`ImportedTraffic::horizon_document`].
///
/// ```
/// use trolley::traffic::{HorizonDocument, ImportedTraffic};
///
/// fn text(imported: &ImportedTraffic) -> Result<&str, trolley::Failure> {
///     let document: HorizonDocument<'_> = imported.horizon_document("crossing.xml".as_ref())?;
///     Ok(document.scenario)
/// }
/// ```
#[derive(Debug, Serialize)]
pub struct HorizonDocument<'a> {
    /// Its form.
    pub schema: &'static str,
    /// The traffic file.
    pub file: String,
    /// The name that the file gives itself.
    pub name: &'a str,
    /// The scenario's text.
    pub scenario: &'a str,
    /// Until when everybody is followed (s).
    pub horizon_s: f64,
    /// What was assumed or left out, in whole sentences without full stops.
    pub notes: Vec<&'a String>,
}

impl ImportedTraffic {
    fn row(&self, meeting: &Conflict) -> MeetingRow<'_> {
        let other = &self.recording.others[meeting.whom];
        MeetingRow {
            manoeuvre: meeting.manoeuvre.name(),
            after_s: meeting.ego.time_s - self.swept.began_s,
            ego_m: meeting.ego.place.at,
            ego_yaw_rad: meeting.ego.place.yaw,
            ego_speed_m_s: meeting.ego.speed_m_s,
            other: &other.id,
            kind: &other.kind,
            other_m: meeting.other.place.at,
            other_yaw_rad: meeting.other.place.yaw,
            other_speed_m_s: meeting.other.speed_m_s,
        }
    }

    /// Returns the import as a document for JSON; `path` is the traffic file.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join(format!("trolley-to-json-{}", std::process::id()));
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
    /// let json = serde_json::to_value(imported.document(&path));
    /// assert!(json.is_ok_and(|json| json["name"] == "Test"));
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn document(&self, path: &Path) -> Document<'_> {
        Document {
            schema: "trolley.scenario-import/1",
            file: path.display().to_string(),
            name: &self.recording.name,
            scenario: self.text.as_deref(),
            meetings: self.swept.meetings.iter().map(|meeting| self.row(meeting)).collect(),
            free: self.swept.free.iter().map(Manoeuvre::name).collect(),
            horizon_s: self.horizon_s,
            notes: &self.notes,
        }
    }

    /// Returns the import as a scenario over a horizon, as a document for JSON; `path` is the
    /// traffic file.
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
    /// assert_eq!(imported.horizon_document(&path)?.schema, "trolley.scenario-import/2");
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If there is no such scenario: that of [`Self::horizon_text`].
    pub fn horizon_document(&self, path: &Path) -> Result<HorizonDocument<'_>, Failure> {
        Ok(HorizonDocument {
            schema: "trolley.scenario-import/2",
            file: path.display().to_string(),
            name: &self.recording.name,
            scenario: self.horizon_text.as_deref().map_err(Clone::clone)?,
            horizon_s: self.horizon_s,
            notes: self.notes.iter().chain(&self.horizon_notes).collect(),
        })
    }

    /// Returns in words what the scenario over a horizon is made from: one fact a line.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join(format!("trolley-said-{}", std::process::id()));
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
    /// assert!(imported.horizon_summary().starts_with("Test: 1 obstacle"));
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn horizon_summary(&self) -> String {
        let count = self.recording.others.len();
        let plural = if count == 1 { "" } else { "s" };
        let (name, horizon_s) = (&self.recording.name, self.horizon_s);
        let mut text = format!("{name}: {count} obstacle{plural}, followed over {horizon_s} s");
        for note in self.notes.iter().chain(&self.horizon_notes) {
            let _w = write!(text, "\nNote: {note}.");
        }
        text
    }

    /// Returns what was found in words: one fact a line.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join(format!("trolley-summary-{}", std::process::id()));
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
    /// assert!(imported.summary().starts_with("Test: "));
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    pub fn summary(&self) -> String {
        let (meet, free) = (self.swept.meetings.len(), self.swept.free.len());
        let mut text = format!(
            "{}: {} obstacles; {meet} of {} manoeuvres meet somebody within {} s",
            self.recording.name,
            self.recording.others.len(),
            meet + free,
            self.horizon_s
        );
        if free > 0 && meet > 0 {
            let names: Vec<String> = self.swept.free.iter().take(4).map(Manoeuvre::name).collect();
            let more = if free > 4 { "; …" } else { "" };
            let _w = write!(text, "\nfree of any: {}{more}", names.join("; "));
        }
        for note in &self.notes {
            let _w = write!(text, "\nNote: {note}.");
        }
        text
    }
}
