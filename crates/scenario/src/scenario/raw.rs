//! The form of a scenario over a horizon: what serde reads and what the JSON Schema describes.
//!
//! As in the older form nothing is checked here but names and types.

use super::SCHEMA;
use crate::engine::Overrides;
use crate::limit;
use crate::names;
use crate::raw::{Crush, Generate, Table};
use body::Seat;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// What to rank and how: the manoeuvres left to an automated vehicle, and where everybody else may
/// go until the horizon. Time 0 is now. Lengths are metres, x forward, y left, z up; angles are
/// degrees, applied as yaw, pitch, roll (Z·Y·X). Unknown keys are refused.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Trolley scenario over a horizon")]
pub(crate) struct Scenario {
    /// Name and version of this form.
    #[schemars(extend("const" = SCHEMA))]
    #[expect(dead_code, reason = "checked before the rest is read, and listed here for serde")]
    pub(crate) schema: String,
    /// What people call the scenario.
    #[schemars(length(min = limit::NAME_CHARS.least, max = limit::NAME_CHARS.most))]
    pub(crate) name: String,
    /// Name of a policy that ships (`trolley help policies`), or a file, relative to this file and
    /// in its folder (else: --allow-outside). Default: "default".
    #[schemars(length(min = limit::PATH_BYTES.least, max = limit::PATH_BYTES.most))]
    pub(crate) policy: Option<String>,
    /// Name of a set of injury risk curves that ships, or a file, relative to this file and in its
    /// folder. Default: "default".
    #[schemars(length(min = limit::PATH_BYTES.least, max = limit::PATH_BYTES.most))]
    pub(crate) curves: Option<String>,
    /// File of parameters of contact and dynamics, relative to this file and in its folder.
    /// Default: those of the program.
    #[schemars(length(min = limit::PATH_BYTES.least, max = limit::PATH_BYTES.most))]
    pub(crate) parameters: Option<String>,
    /// Time for the answer [ms], from the acceptance of the request. Default: none.
    #[schemars(range(min = limit::DEADLINE_MS.least, max = limit::DEADLINE_MS.most))]
    pub(crate) deadline_ms: Option<f64>,
    /// How far ahead contacts are looked for [s]. Default 5.
    #[schemars(range(min = limit::HORIZON_S.least, max = limit::HORIZON_S.most))]
    pub(crate) horizon_s: Option<f64>,
    /// Within this distance [m] contact that cannot be decided is possible and counts as contact.
    /// Default 0.001.
    #[schemars(range(min = limit::RESOLUTION_M.least, max = limit::RESOLUTION_M.most))]
    pub(crate) resolution_m: Option<f64>,
    /// In how many members of what is known only up to errors the candidates are followed; 1: in
    /// the scene as stated alone. Default 32.
    #[schemars(range(min = limit::MEMBERS.least, max = limit::MEMBERS.most))]
    pub(crate) members: Option<i64>,
    /// How many members there are at most: they are doubled while the best two candidates differ by
    /// less than the sampling error. Default 128, or members, if these are more.
    #[schemars(range(min = limit::MEMBERS.least, max = limit::MEMBERS.most))]
    pub(crate) members_max: Option<i64>,
    /// Which party is the automated vehicle. Default "ego".
    pub(crate) ego: Option<String>,
    #[serde(default)]
    pub(crate) engine: Table<Overrides>,
    /// The ego and up to 32 others, by name.
    #[schemars(extend("minProperties" = limit::PARTIES.least,
        "maxProperties" = limit::PARTIES.most))]
    pub(crate) parties: BTreeMap<String, Table<Party>>,
    /// The manoeuvres to choose from, 1 to 16.
    #[schemars(required, length(min = limit::CANDIDATES.least, max = limit::CANDIDATES.most))]
    pub(crate) candidates: Option<Vec<Table<Candidate>>>,
}

/// A body from a model file or generated, exactly one of the two; the persons in it; and, unless it
/// is the ego, exactly one of place, state and paths.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{"required": ["file"]}, {"required": ["generate"]}], "allOf" = [
    {"not": {"required": ["place", "state"]}}, {"not": {"required": ["place", "paths"]}},
    {"not": {"required": ["state", "paths"]}}, {"not": {"required": ["persons", "empty"]}}]))]
pub(crate) struct Party {
    /// Model file, relative to this file and in its folder.
    #[schemars(length(min = limit::PATH_BYTES.least, max = limit::PATH_BYTES.most))]
    pub(crate) file: Option<String>,
    pub(crate) generate: Option<Table<Generate>>,
    /// Only "unknown": nobody knows what this is, and the body is its shape alone. Such a scenario
    /// is refused unless the command line says what to assume.
    #[schemars(extend("const" = "unknown"))]
    pub(crate) kind: Option<String>,
    /// Size [m] to which the body is stretched, its middle put on the origin: length and width,
    /// with the height kept; length, width and height; or the longer side in plan alone. Default:
    /// as it is.
    #[schemars(length(min = 1, max = 3),
        inner(range(min = limit::SIZE_M.least, max = limit::SIZE_M.most)))]
    pub(crate) size_m: Option<Vec<f64>>,
    /// Mass [kg]. Default: that of the model.
    #[schemars(range(min = limit::MASS_KG.least, max = limit::MASS_KG.most))]
    pub(crate) mass_kg: Option<f64>,
    /// Who is inside: at most 9 in a car, 3 in a truck, 90 in a bus or a group on foot, 2 on a
    /// motorcycle or bicycle. Default: what is usual for its kind, with a range from nobody to
    /// everybody whom it can hold.
    #[schemars(length(min = limit::OCCUPANTS.least, max = limit::OCCUPANTS.most))]
    pub(crate) persons: Option<Vec<Table<Person>>>,
    /// Only true: nobody is inside.
    #[schemars(extend("const" = true))]
    pub(crate) empty: Option<bool>,
    /// Share of responsibility that the planner ascribes to the party's persons, 0 to 1. Default 0.
    #[schemars(range(min = limit::SHARE.least, max = limit::SHARE.most))]
    pub(crate) responsibility: Option<f64>,
    pub(crate) crush: Option<Table<Crush>>,
    pub(crate) errors: Option<Table<Errors>>,
    pub(crate) place: Option<Table<Place>>,
    pub(crate) state: Option<Table<State>>,
    /// Where it may go, 1 to 3 paths; their probabilities sum to 1. All begin at 0 s at one pose.
    #[schemars(length(min = limit::PREDICTIONS.least, max = limit::PREDICTIONS.most))]
    pub(crate) paths: Option<Vec<Table<Prediction>>>,
}

/// Persons. Where they are, how many, and nothing else: age, sex and condition are not an input.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Person {
    /// Where the person sits. Left out for a person on foot, or on some seat.
    #[schemars(extend("enum" = names::all::<Seat>()))]
    pub(crate) seat: Option<String>,
    /// How many persons, 1 on a given seat. Default 1.
    #[schemars(range(min = limit::OCCUPANTS.least, max = limit::OCCUPANTS.most))]
    pub(crate) count: Option<i64>,
}

/// How well a party is known: standard deviations, of which members are drawn. Of what is fixed to
/// the ground only its position is drawn.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Errors {
    /// To its left [m]. Default 0.2.
    #[schemars(range(min = limit::ERROR_M.least, max = limit::ERROR_M.most))]
    pub(crate) lateral_m: Option<f64>,
    /// Along its x axis [m]. Default 0.3.
    #[schemars(range(min = limit::ERROR_M.least, max = limit::ERROR_M.most))]
    pub(crate) longitudinal_m: Option<f64>,
    /// Correlation of these two. Default 0.
    #[schemars(range(min = limit::CORRELATION.least, max = limit::CORRELATION.most))]
    pub(crate) correlation: Option<f64>,
    /// Yaw [degrees]. Default 2.
    #[schemars(range(min = limit::ERROR_YAW_DEG.least, max = limit::ERROR_YAW_DEG.most))]
    pub(crate) yaw_deg: Option<f64>,
    /// Share of its speed. Default 0.05 of the ego, 0.1 of others.
    #[schemars(range(min = limit::ERROR_SPEED_SHARE.least, max = limit::ERROR_SPEED_SHARE.most))]
    pub(crate) speed_share: Option<f64>,
}

/// Where a body stands still until the horizon.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Place {
    /// Origin of the body in the world [m]: x, y, z.
    #[schemars(length(equal = 3),
        inner(range(min = limit::POSITION_M.least, max = limit::POSITION_M.most)))]
    pub(crate) position_m: Vec<f64>,
    /// Turn about z, from x towards y [degrees]. Default 0.
    #[schemars(range(min = limit::YAW_DEG.least, max = limit::YAW_DEG.most))]
    pub(crate) yaw_deg: Option<f64>,
    /// Turn about y, nose down positive [degrees]. Default 0.
    #[schemars(range(min = limit::PITCH_DEG.least, max = limit::PITCH_DEG.most))]
    pub(crate) pitch_deg: Option<f64>,
    /// Turn about x, left side up positive [degrees]. Default 0.
    #[schemars(range(min = limit::ROLL_DEG.least, max = limit::ROLL_DEG.most))]
    pub(crate) roll_deg: Option<f64>,
}

/// Where a body is now, and the motion in which it goes on until the horizon: speed along the
/// heading, or velocity in the world, one of the two.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{"required": ["speed_m_s"]}, {"required": ["velocity_m_s"]}]))]
pub(crate) struct State {
    /// Origin of the body in the world [m]: x, y, z.
    #[schemars(length(equal = 3),
        inner(range(min = limit::POSITION_M.least, max = limit::POSITION_M.most)))]
    pub(crate) position_m: Vec<f64>,
    /// Turn about z, from x towards y [degrees]. Default 0.
    #[schemars(range(min = limit::YAW_DEG.least, max = limit::YAW_DEG.most))]
    pub(crate) yaw_deg: Option<f64>,
    /// Turn about y, nose down positive [degrees]. Default 0.
    #[schemars(range(min = limit::PITCH_DEG.least, max = limit::PITCH_DEG.most))]
    pub(crate) pitch_deg: Option<f64>,
    /// Turn about x, left side up positive [degrees]. Default 0.
    #[schemars(range(min = limit::ROLL_DEG.least, max = limit::ROLL_DEG.most))]
    pub(crate) roll_deg: Option<f64>,
    /// Speed along the heading, in the ground plane [m/s]; negative: backwards.
    #[schemars(range(min = limit::PATH_SPEED_M_S.least, max = limit::PATH_SPEED_M_S.most))]
    pub(crate) speed_m_s: Option<f64>,
    /// Velocity in the world, in the ground plane [m/s]: x, y.
    #[schemars(length(equal = 2),
        inner(range(min = limit::PATH_SPEED_M_S.least, max = limit::PATH_SPEED_M_S.most)))]
    pub(crate) velocity_m_s: Option<Vec<f64>>,
    /// Rate at which body and velocity turn about z, from x towards y [degrees/s]. Default 0.
    #[schemars(range(min = limit::TURN_RATE_DEG_S.least, max = limit::TURN_RATE_DEG_S.most))]
    pub(crate) yaw_rate_deg_s: Option<f64>,
}

/// States of a body in time, here or in a CSV file, exactly one of the two. The first is at 0 or
/// before; after the last one the body goes straight on.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{"required": ["states"]}, {"required": ["csv"]}]))]
pub(crate) struct Path {
    /// States at rising times, 1 to 64; position is linear between them.
    #[schemars(length(min = limit::PATH_STATES.least, max = limit::PATH_STATES.most))]
    pub(crate) states: Option<Vec<Table<PathState>>>,
    /// File of up to 4096 states, relative to this file and in its folder: columns t_s, x_m, y_m,
    /// yaw_deg, and optionally z_m, pitch_deg, roll_deg, vx_m_s, vy_m_s.
    #[schemars(length(min = limit::PATH_BYTES.least, max = limit::PATH_BYTES.most))]
    pub(crate) csv: Option<String>,
}

/// A path that is expected of a body, and how probable it is.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{"required": ["states"]}, {"required": ["csv"]}]))]
pub(crate) struct Prediction {
    /// Probability of this path, 0 to 1. Default 1, if there is no other path.
    #[schemars(range(min = limit::SHARE.least, max = limit::SHARE.most))]
    pub(crate) probability: Option<f64>,
    /// States at rising times, 1 to 64; position is linear between them.
    #[schemars(length(min = limit::PATH_STATES.least, max = limit::PATH_STATES.most))]
    pub(crate) states: Option<Vec<Table<PathState>>>,
    /// File of up to 4096 states, relative to this file and in its folder: columns t_s, x_m, y_m,
    /// yaw_deg, and optionally z_m, pitch_deg, roll_deg, vx_m_s, vy_m_s.
    #[schemars(length(min = limit::PATH_BYTES.least, max = limit::PATH_BYTES.most))]
    pub(crate) csv: Option<String>,
}

/// Where a body is at one time.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PathState {
    /// The time [s]; 0 is now.
    #[schemars(range(min = limit::PATH_TIME_S.least, max = limit::PATH_TIME_S.most))]
    pub(crate) t_s: f64,
    /// Origin of the body in the world [m]: x, y, z.
    #[schemars(length(equal = 3),
        inner(range(min = limit::POSITION_M.least, max = limit::POSITION_M.most)))]
    pub(crate) position_m: Vec<f64>,
    /// Turn about z, from x towards y [degrees]. Default 0.
    #[schemars(range(min = limit::YAW_DEG.least, max = limit::YAW_DEG.most))]
    pub(crate) yaw_deg: Option<f64>,
    /// Turn about y, nose down positive [degrees]. Default 0.
    #[schemars(range(min = limit::PITCH_DEG.least, max = limit::PITCH_DEG.most))]
    pub(crate) pitch_deg: Option<f64>,
    /// Turn about x, left side up positive [degrees]. Default 0.
    #[schemars(range(min = limit::ROLL_DEG.least, max = limit::ROLL_DEG.most))]
    pub(crate) roll_deg: Option<f64>,
    /// Velocity in the world, in the ground plane [m/s]: x, y. In the last state: how the body goes
    /// on. In the others it is only compared with the positions. Default: that of the last two
    /// positions.
    #[schemars(length(equal = 2),
        inner(range(min = limit::PATH_SPEED_M_S.least, max = limit::PATH_SPEED_M_S.most)))]
    pub(crate) velocity_m_s: Option<Vec<f64>>,
}

/// Something that the ego could do: a path, or a state that goes on, one of the two.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{"required": ["path"]}, {"required": ["state"]}]))]
pub(crate) struct Candidate {
    /// What people call it; no two alike.
    #[schemars(length(min = limit::NAME_CHARS.least, max = limit::NAME_CHARS.most))]
    pub(crate) name: String,
    pub(crate) path: Option<Table<Path>>,
    pub(crate) state: Option<Table<State>>,
    /// Who moves otherwise if the ego does this, by name: instead of all that is expected of them.
    #[serde(default)]
    pub(crate) reactions: BTreeMap<String, Table<Reaction>>,
}

/// How a party moves in one candidate: exactly one of the three.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [
    {"required": ["path"]}, {"required": ["state"]}, {"required": ["place"]}]))]
pub(crate) struct Reaction {
    pub(crate) path: Option<Table<Path>>,
    pub(crate) state: Option<Table<State>>,
    pub(crate) place: Option<Table<Place>>,
}

impl Prediction {
    /// Probability and path apart. (Serde cannot both flatten a table and refuse unknown keys.)
    pub(crate) fn split(self) -> (Option<f64>, Path) {
        let Self { probability, states, csv } = self;
        (probability, Path { states, csv })
    }
}
