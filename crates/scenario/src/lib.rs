//! Scenarios: what to rank and how, as a person writes it down.
//!
//! ```text
//! text (TOML) --Document--> raw tables with places --check--> values: plain values, SI units
//!                                                    |
//! command line --Overrides---------------------------+--> EngineSettings::apply: the same rules
//! ```
//!
//! Text goes in, values come out. This crate opens no file: the paths that a scenario names are
//! returned with their [`TextPosition`], so that the caller who opens them can report where the
//! name was written, and refuse files outside of the scenario's folder. It names a policy and does
//! not read it; it knows no mesh, no contact and no harm.
//!
//! # Invariants
//!
//! - Whatever [`ScenarioDraft`] returns is in range: finite, known, unique, consistent. Every
//!   single value of a scenario, made wrong, is refused at its own line: `scenario/tests.rs`.
//! - No text makes it panic, and text beyond [`TEXT_BYTES_MAX`] is refused unread:
//!   `scenario/tests/texts.rs`, `scenario/csv/tests.rs`.
//! - Whatever it accepts, [`schema`] accepts too: `scenario/tests/texts.rs`.
//! - Every motion of a [`Scenario`] lasts from 0 to its horizon, and those of one party
//!   begin at one pose: `scenario/tests/rules.rs`. A turn is within [`CIRCLE_ERROR_M`] of its
//!   circle: `scenario/path/tests.rs`.
//! - What is usual is never called implausible, and what is far beyond always is:
//!   `plausibility/tests.rs`.
//! - Persons carry a seat, or how many they are, and nothing else. Age, sex and condition are
//!   refused by the schema.
//!
//! # Examples
//!
//! ```
//! let text = include_str!("../config/scenarios/crossing.toml");
//! let scenario = trolley_scenario::Scenario::parse("crossing.toml", text)?;
//! assert_eq!(scenario.candidates.len(), 3);
//!
//! let wrong = text.replace("shape = \"sedan\"", "shape = \"sedam\"");
//! let error = trolley_scenario::Scenario::parse("crossing.toml", &wrong).unwrap_err();
//! assert!(error.remedy.contains("Did you mean \"sedan\"?"));
//! # Ok::<(), trolley_scenario::ScenarioError>(())
//! ```

mod decimal;
mod document;
mod engine;
mod error;
mod explain;
mod fault;
mod fields;
mod key_reference;
mod limit;
pub mod live;
pub mod members;
mod names;
pub mod plausibility;
mod raw;
mod rules;
mod scenario;
mod schema;
#[cfg(test)]
mod testing;

pub use decimal::decimal;
pub use document::TextPosition;
pub use engine::{Cores, EngineSettings, Overrides, Scheme};
pub use error::{Misfit, ScenarioError};
pub use key_reference::key_reference;
pub use members::{Errors, MemberDraw, MemberSequence, Members, PartyDraw, Worlds};
pub use plausibility::{Implausible, LoadedBody, implausible, unmet};
pub use rules::capacity;
pub use scenario::{
    CANDIDATES_MAX, CIRCLE_ERROR_M, Candidate, FileRef, GivenMotion, GivenState, Motion, Name,
    Occupancy, OccupantGroup, PARTIES_MAX, PATH_STATES_MAX, Party, PartyIndex, Prediction,
    Reaction, SCHEMA, Scenario, ScenarioDraft, Source, TEXT_BYTES_MAX,
};
pub use schema::schema;
