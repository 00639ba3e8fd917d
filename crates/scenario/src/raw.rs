//! The form of a scenario file: what serde reads and what the JSON Schema describes.
//!
//! Nothing is checked here but names and types; ranges are stated for the schema and enforced by
//! `check`. Whole numbers are read signed, so that −1 gets an answer in the scenario's own words;
//! points as lists of any length, since serde reads `[0, 0, 0, 9]` as three numbers and says
//! nothing.

use crate::limit;
use crate::names;
use body::Shape;
use schemars::JsonSchema;
use serde::Deserialize;

mod table;

pub(crate) use table::Table;

/// Stiffness of a body for a check of the depth: force per width = A + B times crush. No value is
/// built in; it never changes a ranking.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Crush {
    /// A [N/m]: force per width at which permanent crush begins.
    #[schemars(range(min = limit::CRUSH_A.least, max = limit::CRUSH_A.most))]
    pub(crate) a_n_m: f64,
    /// B [N/m²]: what each metre of crush adds to it.
    #[schemars(range(min = limit::CRUSH_B.least, max = limit::CRUSH_B.most))]
    pub(crate) b_n_m2: f64,
}

/// A body of the built-in generator.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Generate {
    /// What it is.
    #[schemars(extend("enum" = names::all::<Shape>()))]
    pub(crate) shape: String,
    /// How many triangles.
    #[schemars(range(min = limit::TRIANGLES.least, max = limit::TRIANGLES.most))]
    pub(crate) triangles: i64,
    /// Seed of its small variations. Default 0.
    #[schemars(range(min = limit::SEED.least, max = limit::SEED.most))]
    pub(crate) seed: Option<i64>,
}
