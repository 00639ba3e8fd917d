//! Traffic that others recorded or wrote down: from their files to a scenario that can be ranked.
//!
//! ```text
//! CommonRoad 2018b, 2020a ─┐                     ego manoeuvres       library of bodies
//! OpenSCENARIO (in part) ──┴─read─▶ Recording ─ sweep ─▶ Meetings ─ write ─▶ scenario (TOML)
//!                                       └───── horizon_text ─────▶ scenario over a horizon (TOML)
//! ```
//!
//! Everything lies in the ground plane, in metres, seconds and radians. A recording states where
//! every participant is and goes; the sweep drives the ego along arcs that friction allows and says
//! whom it meets first, as their outlines in plan overlap; triangles are the engine's business.
//! A scenario over a horizon needs no sweep: it has all manoeuvres, and where everybody goes. Texts
//! come in and go out; no file is opened here.
//!
//! # Invariants
//!
//! - A file is read whole or refused with line, element and remedy; nothing is guessed in silence:
//!   what was taken for something else stands in [`Recording::notes`]. `commonroad/tests.rs`.
//! - Outlines overlap exactly if they share a point, for any rectangles, circles and polygons:
//!   `outline/tests.rs`.
//! - No manoeuvre asks the tyres for more than [`ManoeuvreSweep::grip_m_s2`]: `sweep/tests.rs`.
//! - What is written is a scenario: `write/tests.rs`, `horizon_text/tests.rs`. Over a horizon
//!   everybody is where the recording says, at its times, to the last digit that is written.

mod commonroad;
mod error;
mod horizon_text;
mod library;
mod openscenario;
mod outline;
mod recording;
mod sweep;
mod write;
mod xml;

pub use error::TrafficError;
pub use horizon_text::{HorizonTextError, horizon_text};
pub use library::{DEFAULT_LIBRARY, Library};
pub use outline::{Outline, OutlinePart, Placed, overlap};
pub use recording::{Ego, Obstacle, Recording, TimedState};
pub use sweep::{Conflict, Manoeuvre, ManoeuvreSweep, Swept};
pub use write::scenario_text;
pub use xml::TEXT_BYTES_MAX;

/// What the person at the terminal says about a file.
#[derive(Clone, Copy, Debug, Default)]
pub struct ReadOptions<'a> {
    /// Which obstacle, planning problem or entity is the ego, where the file leaves that open.
    pub ego: Option<&'a str>,
    /// Obstacles to leave out.
    pub without: &'a [String],
    /// Catalogues of OpenSCENARIO.
    pub catalogs: &'a [Catalog<'a>],
}

/// A catalogue: its name in errors, and its text.
#[derive(Clone, Copy, Debug)]
pub struct Catalog<'a> {
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
        "commonRoad" => commonroad::read(root, options.ego, options.without),
        "OpenSCENARIO" => openscenario::read(root, options),
        other => Err(root.fault(
            format!("this is <{other}>, neither CommonRoad nor OpenSCENARIO"),
            "give a <commonRoad> file of version 2018b or 2020a, or an <OpenSCENARIO> file",
        )),
    }
}
