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
//! - Whatever [`HorizonDraft`] returns is in range: finite, known, unique, consistent. Every single
//!   value of a scenario, made wrong, is refused at its own line: `horizon/tests.rs`.
//! - No text makes it panic, and text beyond [`HORIZON_TEXT_BYTES_MAX`] is refused unread:
//!   `horizon/tests/texts.rs`, `horizon/csv/tests.rs`.
//! - Whatever it accepts, [`schema`] accepts too: `horizon/tests/texts.rs`.
//! - Every motion of a [`HorizonScenario`] lasts from 0 to its horizon, and those of one party
//!   begin at one pose: `horizon/tests/rules.rs`. A turn is within [`CIRCLE_ERROR_M`] of its
//!   circle: `horizon/path/tests.rs`.
//! - Persons carry a seat, or how many they are, and nothing else. Age, sex and condition are
//!   refused by the schema.
//!
//! # Examples
//!
//! ```
//! let text = include_str!("../config/scenarios/crossing.toml");
//! let scenario = trolley_scenario::HorizonScenario::parse("crossing.toml", text)?;
//! assert_eq!(scenario.candidates.len(), 3);
//!
//! let wrong = text.replace("shape = \"sedan\"", "shape = \"sedam\"");
//! let error = trolley_scenario::HorizonScenario::parse("crossing.toml", &wrong).unwrap_err();
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
mod horizon;
mod limit;
pub mod live;
mod names;
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
pub use horizon::{
    CIRCLE_ERROR_M, GivenMotion, GivenState, HORIZON_PARTIES_MAX, HORIZON_SCHEMA,
    HORIZON_TEXT_BYTES_MAX, HorizonCandidate, HorizonDraft, HorizonMotion, HorizonParty,
    HorizonScenario, Occupancy, OccupantGroup, PATH_STATES_MAX, Prediction, Reaction,
    is_horizon_text,
};
pub use rules::capacity;
pub use scenario::{CANDIDATES_MAX, FileRef, Name, PartyIndex, Source};
pub use schema::schema;
