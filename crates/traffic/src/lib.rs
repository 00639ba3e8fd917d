//! Traffic that others recorded or wrote down: from their files to a scenario that can be ranked.
//!
//! ```text
//! CommonRoad 2018b, 2020a, solutions ─┐
//! OpenSCENARIO (in part) ─────────────┴─read─▶ Recording ─ scenario_text ─▶ scenario (TOML)
//!                                     ego manoeuvres, library of bodies ┘
//! ```
//!
//! Everything lies in the ground plane, in metres, seconds and radians. A recording states where
//! every participant is and goes; a scenario has that, and arcs of the ego that friction allows.
//! Who meets whom is the engine's business. Texts come in and go out; no file is opened here.
//!
//! # Invariants
//!
//! - A file is read whole or refused with line, element and remedy; nothing is guessed in silence:
//!   what was taken for something else stands in [`Recording::notes`]. `commonroad/tests.rs`.
//! - Outlines overlap exactly if they share a point, for any rectangles, circles and polygons:
//!   `outline/tests.rs`.
//! - No manoeuvre asks the tyres for more than [`Manoeuvres::grip_m_s2`]: `manoeuvre/tests.rs`.
//! - What is written is a scenario, in which everybody is where the recording says, at its times,
//!   to the last digit that is written: `scenario_text/tests.rs`.

mod commonroad;
mod error;
mod library;
mod manoeuvre;
mod openscenario;
mod outline;
mod recording;
mod scenario_text;
mod write;
mod xml;

pub use error::TrafficError;
pub use library::{DEFAULT_LIBRARY, Library};
pub use manoeuvre::{Manoeuvre, Manoeuvres};
pub use outline::{Outline, OutlinePart, Placed, overlap};
pub use recording::{Ego, Obstacle, Planned, Recording, TimedState};
pub use scenario_text::{ScenarioTextError, scenario_text};
pub use xml::TEXT_BYTES_MAX;

/// What the person at the terminal says about a file.
#[derive(Clone, Copy, Debug, Default)]
pub struct ReadOptions<'a> {
    /// Which obstacle, planning problem or entity is the ego, where the file leaves that open.
    pub ego: Option<&'a str>,
    /// Obstacles to leave out.
    pub without: &'a [String],
    /// Catalogues of OpenSCENARIO.
    pub catalogs: &'a [NamedText<'a>],
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

/// Reads a file of any known form; which one, its first element says.
///
/// `file` is its name in errors.
///
/// # Errors
///
/// The first fault found, with line, element and remedy.
pub fn read(file: &str, text: &str, options: &ReadOptions<'_>) -> Result<Recording, TrafficError> {
    let document = xml::Document::parse(file, text)?;
    let root = document.root();
    match root.name() {
        "commonRoad" => commonroad::read(root, options),
        "OpenSCENARIO" if options.solutions.is_empty() => openscenario::read(root, options),
        "OpenSCENARIO" => Err(root.fault(
            "solutions are of CommonRoad's planning problems",
            "leave out --solution, or give the <commonRoad> file that it solves",
        )),
        other => Err(root.fault(
            format!("this is <{other}>, neither CommonRoad nor OpenSCENARIO"),
            "give a <commonRoad> file of version 2018b or 2020a, or an <OpenSCENARIO> file",
        )),
    }
}
