//! Traffic that others recorded or wrote down: from their files to a scenario that can be ranked.
//!
//! ```text
//! CommonRoad 2018b, 2020a, solutions ─┐
//! ASAM OSI: .osi, .mcap ──────────────┼─read─▶ Recording ─ scenario_text ─▶ scenario (TOML)
//! esmini's CSV ───────────────────────┘                        │
//!                             ego manoeuvres, library of bodies ┘
//! ```
//!
//! Everything lies in the ground plane, in metres, seconds and radians. A recording states where
//! every participant is and goes; a scenario has that, and arcs of the ego that friction allows.
//! Who meets whom is the engine's business. Texts come in and go out; no file is opened here.
//!
//! # Invariants
//!
//! - A file is read whole or refused with line, element and remedy; nothing is guessed in silence:
//!   what was taken for something else stands in [`Recording::notes`]. `commonroad/tests.rs`,
//!   `osi/tests.rs`, `esmini/tests.rs`.
//! - Outlines overlap exactly if they share a point, for any rectangles, circles and polygons:
//!   `outline/tests.rs`.
//! - No manoeuvre asks the tyres for more than [`Manoeuvres::grip_m_s2`]: `manoeuvre/tests.rs`.
//! - What is written is a scenario, in which everybody is where the recording says, at its times,
//!   to the last digit that is written: `scenario_text/tests.rs`.

mod commonroad;
mod error;
mod esmini;
mod library;
mod manoeuvre;
mod osi;
mod outline;
mod recording;
mod scenario_text;
mod trace;
mod write;
mod xml;

pub use error::{TrafficError, TrafficPlace};
pub use library::{DEFAULT_LIBRARY, Library};
pub use manoeuvre::{Manoeuvre, Manoeuvres};
pub use outline::{Outline, OutlinePart, Placed, overlap};
pub use recording::{Ego, Obstacle, Planned, Recording, StateSpread, TimedState};
pub use scenario_text::{ScenarioTextError, scenario_text};
pub use xml::TEXT_BYTES_MAX;

/// What the person at the terminal says about a file.
#[derive(Clone, Copy, Debug, Default)]
pub struct ReadOptions<'a> {
    /// Which obstacle, planning problem, object or entity is the ego, where the file leaves that
    /// open.
    pub ego: Option<&'a str>,
    /// Obstacles to leave out.
    pub without: &'a [String],
    /// Solutions of CommonRoad's planning problem: ways of the ego to rank beside others.
    pub solutions: &'a [NamedText<'a>],
}

/// A file beside the recording: its name in errors, and its text.
#[derive(Clone, Copy, Debug)]
pub struct NamedText<'a> {
    /// Name of the file.
    pub file: &'a str,
    /// What it says.
    pub text: &'a str,
}

/// The form of a trace that a simulator wrote.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TraceForm {
    /// Messages of ASAM OSI, each behind its length.
    Osi,
    /// Messages of ASAM OSI in a container.
    Mcap,
    /// What esmini writes with `--csv_logger`.
    Csv,
}

impl TraceForm {
    /// The form of files whose names end so, without the point: "osi".
    #[must_use]
    pub fn of_ending(ending: &str) -> Option<Self> {
        let known = [("osi", Self::Osi), ("mcap", Self::Mcap), ("csv", Self::Csv)];
        known.iter().find(|(end, _)| ending.eq_ignore_ascii_case(end)).map(|(_, form)| *form)
    }
}

/// Reads a text of XML: CommonRoad.
///
/// `file` is its name in errors.
///
/// # Errors
///
/// The first fault found, with line, element and remedy.
pub fn read(file: &str, text: &str, options: &ReadOptions<'_>) -> Result<Recording, TrafficError> {
    not_a_pointer(file, text.as_bytes())?;
    let document = xml::Document::parse(file, text)?;
    let root = document.root();
    match root.name() {
        "commonRoad" => commonroad::read(root, options),
        "OpenSCENARIO" => Err(root.fault(
            "a script, which says what is to happen and not where everybody is",
            "play it in esmini (esmini --osc FILE.xosc --csv_logger FILE.csv, or --osi_file \
             FILE.osi), then rank that trace",
        )),
        "CommonRoadSolution" => Err(root.fault(
            "a planner's solution, which says nothing of anybody but the ego",
            "give the scenario that it solves, and this file with --solution",
        )),
        _ => Err(root.fault(
            "not CommonRoad",
            "give a <commonRoad> file of version 2018b or 2020a, or a trace: .osi, .mcap, .csv",
        )),
    }
}

/// Reads a trace of a simulator.
///
/// `file` is its name in errors.
///
/// # Errors
///
/// The first fault found, with its place (line or message) and remedy; or this build does not have
/// the feature `mcap`.
pub fn read_trace(
    file: &str,
    bytes: &[u8],
    form: TraceForm,
    options: &ReadOptions<'_>,
) -> Result<Recording, TrafficError> {
    let failed =
        |what: &str, remedy: &str| trace::whole(file, (what.to_owned(), remedy.to_owned()));
    if !options.solutions.is_empty() {
        let remedy = "leave out --solution, or give the <commonRoad> file that it solves";
        return Err(failed("solutions are of CommonRoad's planning problems", remedy));
    }
    not_a_pointer(file, bytes)?;
    match form {
        TraceForm::Osi => osi::read(file, bytes, options),
        TraceForm::Csv => {
            let text = core::str::from_utf8(bytes).map_err(|error| {
                let what = format!("not UTF-8 from byte {} on", error.valid_up_to());
                failed(&what, "is this the right file?")
            })?;
            esmini::read(file, text, options)
        }
        #[cfg(feature = "mcap")]
        TraceForm::Mcap => osi::read_mcap(file, bytes, options),
        #[cfg(not(feature = "mcap"))]
        TraceForm::Mcap => Err(failed(
            "this build does not read MCAP",
            "build it with the feature mcap, or write the trace as .osi",
        )),
    }
}

/// Refuses what Git leaves in the place of a large file.
fn not_a_pointer(file: &str, bytes: &[u8]) -> Result<(), TrafficError> {
    if !bytes.starts_with(b"version https://git-lfs.github.com/spec/") {
        return Ok(());
    }
    let what = "a pointer of Git LFS, in the place of the file".to_owned();
    Err(trace::whole(file, (what, "bring the file itself: git lfs pull".to_owned())))
}
