//! The form of a scenario file: what serde reads and what the JSON Schema describes.
//!
//! Nothing is checked here but names and types; ranges are stated for the schema and enforced by
//! `check`. Whole numbers are read signed, so that −1 gets an answer in the scenario's own words;
//! points as lists of any length, since serde reads `[0, 0, 0, 9]` as three numbers and says
//! nothing.

use crate::engine::Overrides;
use crate::limit;
use crate::names;
use crate::scenario::SCHEMA;
use body::{Seat, Shape};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

mod table;

pub(crate) use table::Table;

/// What to rank and how: the collisions that are left to an automated vehicle, each at its
/// predicted impact. Lengths are metres, x forward, y left, z up; angles are degrees, applied as
/// yaw, pitch, roll (Z·Y·X). Unknown keys are refused.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Trolley scenario")]
pub(crate) struct Scenario {
    /// Name and version of this form.
    #[schemars(extend("const" = SCHEMA))]
    #[expect(dead_code, reason = "checked before the rest is read, and listed here for serde")]
    pub(crate) schema: String,
    /// What people call the scenario.
    #[schemars(length(min = limit::NAME_CHARS.least, max = limit::NAME_CHARS.most))]
    pub(crate) name: String,
    /// Policy file, relative to this file and in its folder (else: --allow-outside). Default: the
    /// policy that comes with the program.
    #[schemars(length(min = limit::PATH_BYTES.least, max = limit::PATH_BYTES.most))]
    pub(crate) policy: Option<String>,
    /// File of injury risk curves, relative to this file and in its folder. Default: the curves of
    /// the program.
    #[schemars(length(min = limit::PATH_BYTES.least, max = limit::PATH_BYTES.most))]
    pub(crate) curves: Option<String>,
    /// Time for the answer [ms], from the acceptance of the request. Default: none.
    #[schemars(range(min = limit::DEADLINE_MS.least, max = limit::DEADLINE_MS.most))]
    pub(crate) deadline_ms: Option<f64>,
    /// Which party is the automated vehicle. Default "ego".
    pub(crate) ego: Option<String>,
    #[serde(default)]
    pub(crate) engine: Table<Overrides>,
    /// Bodies that may be hit, by name. A party exists once, however many candidates name it: its
    /// persons count once.
    #[schemars(extend("minProperties" = limit::PARTIES.least,
        "maxProperties" = limit::PARTIES.most))]
    pub(crate) parties: BTreeMap<String, Table<Party>>,
    /// The collisions to choose from, 1 to 16.
    #[schemars(required, length(min = limit::CANDIDATES.least, max = limit::CANDIDATES.most))]
    pub(crate) candidates: Option<Vec<Table<Candidate>>>,
}

/// A body with the persons in it: from a model file or generated, exactly one of the two.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{"required": ["file"]}, {"required": ["generate"]}]))]
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
    /// Who is inside, by seat; an empty list: nobody. Default: what the model says.
    #[schemars(length(max = limit::PERSONS_MAX))]
    pub(crate) persons: Option<Vec<Table<Person>>>,
    /// Share of responsibility that the planner ascribes to the party's persons, 0 to 1. Default 0.
    #[schemars(range(min = limit::SHARE.least, max = limit::SHARE.most))]
    pub(crate) responsibility: Option<f64>,
    pub(crate) crush: Option<Table<Crush>>,
}

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

/// A person. Seat and nothing else: age, sex and condition are not an input.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Person {
    /// Where the person sits. Left out for a person on foot.
    #[schemars(extend("enum" = names::all::<Seat>()))]
    pub(crate) seat: Option<String>,
}

/// One collision that may be chosen: where both bodies are and how they move at predicted impact.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Candidate {
    /// What people call it; no two alike.
    #[schemars(length(min = limit::NAME_CHARS.least, max = limit::NAME_CHARS.most))]
    pub(crate) name: String,
    /// Probability that the collision happens if the candidate is chosen, 0 to 1. Default 1.
    #[schemars(range(min = limit::SHARE.least, max = limit::SHARE.most))]
    pub(crate) probability: Option<f64>,
    pub(crate) ego: Table<Ego>,
    pub(crate) other: Table<Other>,
}

/// Pose and velocity of the ego: speed along the heading, or velocity in the world, one of the two.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{"required": ["speed_m_s"]}, {"required": ["velocity_m_s"]}]))]
pub(crate) struct Ego {
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
    #[schemars(range(min = limit::SPEED_M_S.least, max = limit::SPEED_M_S.most))]
    pub(crate) speed_m_s: Option<f64>,
    /// Velocity in the world, in the ground plane [m/s]: x, y.
    #[schemars(length(equal = 2),
        inner(range(min = limit::SPEED_M_S.least, max = limit::SPEED_M_S.most)))]
    pub(crate) velocity_m_s: Option<Vec<f64>>,
}

/// The opposing body: which party, and its pose and velocity.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{"required": ["speed_m_s"]}, {"required": ["velocity_m_s"]}]))]
pub(crate) struct Other {
    /// Name of the party; not the ego.
    pub(crate) party: String,
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
    #[schemars(range(min = limit::SPEED_M_S.least, max = limit::SPEED_M_S.most))]
    pub(crate) speed_m_s: Option<f64>,
    /// Velocity in the world, in the ground plane [m/s]: x, y.
    #[schemars(length(equal = 2),
        inner(range(min = limit::SPEED_M_S.least, max = limit::SPEED_M_S.most)))]
    pub(crate) velocity_m_s: Option<Vec<f64>>,
}

impl Other {
    /// Party and state apart. (Serde cannot both flatten a table and refuse unknown keys in it.)
    pub(crate) fn split(self) -> (String, Ego) {
        let Self { party, position_m, yaw_deg, pitch_deg, roll_deg, speed_m_s, velocity_m_s } =
            self;
        let state = Ego { position_m, yaw_deg, pitch_deg, roll_deg, speed_m_s, velocity_m_s };
        (party, state)
    }
}
