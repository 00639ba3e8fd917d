//! Traffic files as scenarios: CommonRoad 2018b and 2020a, and traces of simulators: ASAM OSI 3
//! (`.osi`, `.mcap`), and what esmini writes with `--csv_logger` (`.csv`).
//!
//! Everybody becomes a party with its way, and the manoeuvres that friction allows the ego become
//! candidates, whether or not they meet anybody.
//!
//! ```
//! # let folder = std::env::temp_dir().join(format!("trolley-traffic-{}", std::process::id()));
//! # std::fs::create_dir_all(&folder).ok();
//! # let path = folder.join("crossing.xml");
//! # let state = |x: f64, more: &str| format!(
//! #     "<initialState><position><point><x>{x}</x><y>0</y></point></position><orientation>\
//! #      <exact>0</exact></orientation><time><exact>0</exact></time>{more}</initialState>"
//! # );
//! # let text = format!(
//! #     "<commonRoad commonRoadVersion=\"2020a\" timeStepSize=\"0.1\" benchmarkID=\"Test\">\
//! #      <staticObstacle id=\"7\"><type>parkedVehicle</type>\
//! #      <shape><rectangle><length>4</length>\
//! #      <width>1.8</width></rectangle></shape>{}</staticObstacle>\
//! #      <planningProblem id=\"1\">{}</planningProblem></commonRoad>",
//! #     state(25.0, ""),
//! #     state(0.0, "<velocity><exact>15</exact></velocity>"),
//! # );
//! # trolley::files::replace(&path, text.as_bytes())?;
//! use trolley::{Scenario, traffic};
//!
//! let imported = traffic::import(&path, &traffic::TrafficOptions::default())?;
//! println!("{}", imported.summary());
//! let scenario = Scenario::parse("crossing.toml", &imported.text)?;
//! assert_eq!(scenario.parsed().candidates.len(), 15);
//! # std::fs::remove_dir_all(&folder).ok();
//! # Ok::<(), trolley::Failure>(())
//! ```

use crate::Failure;
use crate::files::{self, InputKind};
use crate::references::References;
use std::path::{Path, PathBuf};
use traffic::{DEFAULT_LIBRARY, Library, Manoeuvres, NamedText, ReadOptions, Recording, TraceForm};

mod document;

pub use document::ImportDocument;

/// If the recorded ego overlaps somebody only after the horizon, manoeuvres begin this long before
/// (s): a driver's reaction.
const BEFORE_S: f64 = 1.0;

/// How to read a traffic file, and which manoeuvres to try.
///
/// ```
/// use trolley::traffic::TrafficOptions;
///
/// let brakes_m_s2 = Some(vec![4.0, 8.0]);
/// let options = TrafficOptions { at_s: Some(1.5), brakes_m_s2, ..TrafficOptions::default() };
/// ```
#[derive(Clone, Debug, Default)]
pub struct TrafficOptions {
    /// Which obstacle, planning problem, object or entity is the ego, if the file leaves that open.
    pub ego: Option<String>,
    /// Obstacles to leave out.
    pub without: Vec<String>,
    /// When manoeuvres begin, after the ego's start (s); until then it moves as recorded.
    pub at_s: Option<f64>,
    /// How far to look ahead (s).
    pub horizon_s: Option<f64>,
    /// Decelerations to try (m/s²).
    pub brakes_m_s2: Option<Vec<f64>>,
    /// Lateral accelerations to try, left positive (m/s²).
    pub laterals_m_s2: Option<Vec<f64>>,
    /// Greatest acceleration that the tyres allow (m/s²).
    pub grip_m_s2: Option<f64>,
    /// Library of bodies by type; `None` means generated ones.
    pub bodies: Option<PathBuf>,
    /// Solutions of CommonRoad planners: ways of the ego that are candidates, too.
    pub solutions: Vec<PathBuf>,
    /// Which model files the library of bodies may name.
    pub references: References,
}

impl TrafficOptions {
    fn manoeuvres(&self) -> Result<Manoeuvres, Failure> {
        let usual = Manoeuvres::default();
        let manoeuvres = Manoeuvres {
            brakes_m_s2: self.brakes_m_s2.clone().unwrap_or(usual.brakes_m_s2),
            laterals_m_s2: self.laterals_m_s2.clone().unwrap_or(usual.laterals_m_s2),
            grip_m_s2: self.grip_m_s2.unwrap_or(usual.grip_m_s2),
            horizon_s: self.horizon_s.unwrap_or(usual.horizon_s),
            after_s: self.at_s.unwrap_or(usual.after_s),
            ..usual
        };
        if let Some(brake) =
            manoeuvres.brakes_m_s2.iter().find(|brake| **brake > manoeuvres.grip_m_s2)
        {
            let fault = format!("--brakes: {brake} m/s² is more than the tyres give");
            let help = format!("--grip is {} m/s²", manoeuvres.grip_m_s2);
            return Err(Failure::setting(fault).with_remedy(help));
        }
        Ok(manoeuvres)
    }

    fn library(&self) -> Result<Library, Failure> {
        let Some(path) = &self.bodies else {
            let shipped = Library::parse("config/bodies/default.toml", DEFAULT_LIBRARY);
            return shipped.map_err(Failure::internal);
        };
        let text = files::text(path, InputKind::BodyLibrary)?;
        let library = Library::parse(&path.display().to_string(), &text).map_err(|fault| {
            Failure::input(fault).with_remedy("see config/bodies/default.toml for the form")
        })?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let folder = std::path::absolute(folder.join("x"))
            .ok()
            .and_then(|inside| inside.parent().map(Path::to_owned))
            .unwrap_or_else(|| folder.to_owned());
        let mut refused = Ok(());
        let library = library.with_files(|file| {
            let checked = self.references.check(path, &path.display().to_string(), file.as_ref());
            refused = core::mem::replace(&mut refused, Ok(())).and(checked);
            folder.join(file).display().to_string()
        });
        refused.map(|()| library)
    }
}

/// A traffic file as a scenario.
///
/// ```
/// # let folder = std::env::temp_dir().join(format!("trolley-imported-{}", std::process::id()));
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
/// assert!(imported.text.starts_with("# From ") && imported.notes.is_empty());
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub struct ImportedTraffic {
    recording: Recording,
    horizon_s: f64,
    /// The scenario: where everybody goes, and every manoeuvre.
    pub text: String,
    /// What was assumed or left out, in whole sentences without full stops.
    pub notes: Vec<String>,
}

/// Returns whether a file is traffic rather than a scenario, by its name or its first character.
///
/// ```
/// use trolley::traffic::is_traffic;
///
/// assert!(is_traffic("crossing.xml".as_ref()) && is_traffic("cut-in.osi".as_ref()));
/// assert!(!is_traffic("../../config/scenarios/small.toml".as_ref()));
/// ```
#[must_use]
pub fn is_traffic(path: &Path) -> bool {
    let end = path.extension().map(|end| end.to_string_lossy().to_ascii_lowercase());
    if trace_form(path).is_some() || matches!(end.as_deref(), Some("xml" | "xosc" | "pb")) {
        return true;
    }
    let mut head = [0; 64];
    let length = runtime::input::start(path, &mut head);
    let head = &head[..length];
    let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    head.iter().find(|byte| !byte.is_ascii_whitespace()) == Some(&b'<')
}

/// The form of a trace of a simulator, by its name.
fn trace_form(path: &Path) -> Option<TraceForm> {
    TraceForm::of_ending(&path.extension()?.to_string_lossy())
}

/// Reads a traffic file and makes a scenario of it.
///
/// ```
/// # let folder = std::env::temp_dir().join(format!("trolley-import-{}", std::process::id()));
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
/// let options = TrafficOptions { horizon_s: Some(4.0), ..TrafficOptions::default() };
/// let text = import(&path, &options)?.text;
/// assert!(text.contains("horizon_s = 4.0\n") && text.contains("[[candidates]]"));
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// If a file cannot be read or is not valid, nobody but the ego is there, a type has no body in the
/// library, more obstacles can be reached than a scenario holds, or somebody moves as no body can.
pub fn import(path: &Path, options: &TrafficOptions) -> Result<ImportedTraffic, Failure> {
    let name = path.display().to_string();
    if path.extension().is_some_and(|end| end.eq_ignore_ascii_case("pb")) {
        let fault = format!("{name}: CommonRoad in protobuf is not read");
        return Err(Failure::input(fault).with_remedy("write it as XML with commonroad-io"));
    }
    let mut manoeuvres = options.manoeuvres()?;
    let library = options.library()?;
    if !options.solutions.is_empty() && options.at_s.is_some_and(|at_s| at_s > 0.0) {
        let fault = "--at: a solution begins where the ego starts";
        let help = "leave out --at, or rank without --solution";
        return Err(Failure::setting(fault).with_remedy(help));
    }
    let texts = |paths: &[PathBuf]| -> Result<Vec<(String, String)>, Failure> {
        let text = |path: &PathBuf| {
            Ok((path.display().to_string(), files::text(path, InputKind::Traffic)?))
        };
        paths.iter().map(text).collect()
    };
    let solutions = texts(&options.solutions)?;
    let read = ReadOptions {
        ego: options.ego.as_deref(),
        without: &options.without,
        solutions: &named(&solutions),
    };
    let recording = match trace_form(path) {
        Some(form) => {
            let bytes = files::bytes(path, InputKind::Trace)?;
            let mut recording = traffic::read_trace(&name, &bytes, form, &read)?;
            // A trace gives itself the name of its format.
            if let Some(stem) = path.file_stem() {
                recording.name = format!("{} ({})", stem.to_string_lossy(), recording.name);
            }
            recording
        }
        None => traffic::read(&name, &files::text(path, InputKind::Traffic)?, &read)?,
    };
    let mut notes = recording.notes.clone();
    if options.at_s.is_none()
        && solutions.is_empty()
        && let Some(meets_s) = recording.recorded_meeting_s(manoeuvres.step_s)
        && meets_s > manoeuvres.horizon_s
    {
        manoeuvres.after_s = meets_s - BEFORE_S;
        notes.push(format!(
            "as recorded, the ego meets somebody after {meets_s:.2} s: manoeuvres begin \
             {BEFORE_S} s before; --at changes that"
        ));
    }
    let (text, more) = traffic::scenario_text(&name, &recording, &manoeuvres, &library)?;
    notes.extend(more);
    Ok(ImportedTraffic { recording, horizon_s: manoeuvres.horizon_s, text, notes })
}

fn named(texts: &[(String, String)]) -> Vec<NamedText<'_>> {
    texts.iter().map(|(file, text)| NamedText { file, text }).collect()
}
