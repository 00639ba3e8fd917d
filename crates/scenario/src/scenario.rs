//! A scenario as values: where everybody is now, where they may go, and what the ego could do.
//!
//! ```text
//! text (TOML) --ScenarioDraft::parse--> draft --files--> the CSV files that it names
//!                                        |
//! texts of these files --------------finish--> Scenario: one MotionPath per motion
//! ```
//!
//! Time 0 is now. Each motion is a [`MotionPath`] from 0 to [`Scenario::horizon_s`], from
//! the body frame to the world: metres, x forward, y left, z up. All motions of a party begin at
//! one pose, within 1 mm and 0.1°: where it is now. Who touches whom, and when, is for others to
//! find out; nothing here compares the motions of two parties.
//!
//! # From states to a path
//!
//! Between two states position is linear in time and orientation turns at a constant rate, the
//! shorter way: a [`MotionPath`]. What is before 0 or after the horizon is cut off. A path that
//! ends earlier goes straight on: with the velocity that its last state gives, else with that of
//! its last piece; vertically always as in the last piece; its orientation stays. The end is kept
//! in [`Motion::ends_s`]. A velocity of another state is only compared with the pieces
//! beside it, since one in km/h or in the body frame shows there.
//!
//! A party whose `state` has a yaw rate moves on a circle. It becomes pieces that are within
//! [`CIRCLE_ERROR_M`] of it at every time: over δ seconds a chord is off by at most v ω δ²/8.

use crate::document::TextPosition;
use crate::engine::EngineSettings;
use crate::error::{Misfit, ScenarioError};
use crate::limit;
use crate::members::{Errors, Members};
use crate::rules;
use body::{BodyKind, Fit, Seat, Shape};
use geometry::motion::MotionPath;
use std::time::Duration;

mod begin;
mod check;
mod csv;
mod draft;
pub(crate) mod path;
pub(crate) mod raw;

pub(crate) use check::DEFAULT_RESOLUTION_M;
pub use draft::ScenarioDraft;

/// Name and version of the form, the value of the key `schema`.
pub const SCHEMA: &str = "trolley.scenario/2";

/// Longer texts are refused unread. 32 parties with three paths of 64 states, each with every key
/// in full precision, need 1.2 MB, and 16 candidates to each of which 12 parties react so 2.6 MB.
/// More belongs into CSV files.
pub const TEXT_BYTES_MAX: usize = 4 << 20;

/// How many parties a scenario has at most, the ego among them.
pub const PARTIES_MAX: usize = limit::PARTIES.most;

/// How many states a path has at most that stands in the scenario itself.
pub const PATH_STATES_MAX: usize = limit::PATH_STATES.most;

/// The greatest distance between a circle and the path that stands for it, at equal times (m).
pub const CIRCLE_ERROR_M: f64 = 0.001;

/// How many candidates a scenario has at most.
pub const CANDIDATES_MAX: usize = limit::CANDIDATES.most;

/// A name; copies of it take nothing from the heap.
pub type Name = smol_str::SmolStr;

/// Number of a party in [`Scenario::parties`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PartyIndex(pub usize);

/// A path as written, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileRef {
    /// The path, relative to the scenario's file unless it is absolute. Whoever opens it makes sure
    /// that it does not lead out of the scenario's folder, unless the user allows that.
    pub path: String,
    /// Where it was written, for the error if it cannot be opened.
    pub place: TextPosition,
}

/// Where a body's triangles come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// A model file.
    File(FileRef),
    /// The built-in generator.
    Generate {
        /// What it is.
        shape: Shape,
        /// How many triangles, 500 to 1,000,000.
        triangles: u32,
        /// Seed of its small variations.
        seed: u64,
    },
}

/// What to rank and how, until the horizon.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// What people call it.
    pub name: String,
    /// The policy; `None`: the one that comes with the program.
    pub policy: Option<FileRef>,
    /// The injury risk curves; `None`: those of the program.
    pub curves: Option<FileRef>,
    /// The parameters of contact and dynamics; `None`: those of the program.
    pub parameters: Option<FileRef>,
    /// Time for the answer from the acceptance of the request; `None`: no deadline.
    pub deadline: Option<Duration>,
    /// How the engine works.
    pub engine: EngineSettings,
    /// The automated vehicle.
    pub ego: PartyIndex,
    /// The time at which all motions end (s), in (0, 30]; they begin at 0.
    pub horizon_s: f64,
    /// Within this distance (m), from 1e-5 to 0.1, contact that cannot be decided is possible and
    /// counts as contact.
    pub resolution_m: f64,
    /// How many members are followed; `None`: nothing is said, so [`Members::USUAL`], or in a
    /// service as many as it usually does.
    pub members: Option<Members>,
    /// All bodies, sorted by name; 2 to 33.
    pub parties: Vec<Party>,
    /// The manoeuvres to choose from, in the file's order; 1 to 16, names unique.
    pub candidates: Vec<Candidate>,
}

/// A physical body, who is inside, and where it may go.
#[derive(Clone, Debug, PartialEq)]
pub struct Party {
    /// Its name, unique in the scenario.
    pub name: Name,
    /// The position of its table.
    pub place: TextPosition,
    /// Where its triangles come from.
    pub source: Source,
    /// Size to which the body is stretched; `None`: as it is.
    pub size: Option<Fit>,
    /// Mass instead of the model's, in kg.
    pub mass_kg: Option<f64>,
    /// Who is inside.
    pub occupancy: Occupancy,
    /// Share of responsibility of its persons, 0 to 1.
    pub responsibility: f64,
    /// Its kind is unknown: its body is its shape alone.
    pub is_unknown: bool,
    /// Stiffness A (N/m) and B (N/m²) for the check of depth.
    pub crush: Option<[f64; 2]>,
    /// How well it is known.
    pub errors: Errors,
    /// Where it may go, 1 to 3 motions in the file's order, with probabilities that sum to 1 within
    /// 1e-6; of the ego none, since its motion is in the candidates.
    pub predictions: Vec<Prediction>,
}

/// What is known about the persons of a party.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Occupancy {
    /// These persons, at least one and at most as many as its kind can hold ([`crate::capacity`]);
    /// at most 256 in a scenario.
    Stated(Vec<OccupantGroup>),
    /// Nobody is inside.
    Empty,
    /// Nothing is said: the default of its kind, whether it moves or not, with a range from nobody
    /// to everybody whom it can hold ([`crate::capacity`]); on foot one person.
    Default,
}

/// Persons of a party who are alike in what is known about them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OccupantGroup {
    /// The seat, which nobody else in the party has; `None`: on foot, or on some seat.
    pub seat: Option<Seat>,
    /// How many, 1 to 90; on a given seat 1.
    pub count: u32,
}

/// One of the motions that are expected of a party.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// Probability that the party moves like this, 0 to 1.
    pub probability: f64,
    /// The motion.
    pub motion: Motion,
}

/// The motion of one body until the horizon.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Where it is written in the scenario: the position of its `place`, `state`, `path` or item of
    /// `paths`.
    pub place: TextPosition,
    /// What was said of it.
    pub given: GivenMotion,
    /// Body frame to world, from 0 to exactly [`Scenario::horizon_s`].
    pub path: MotionPath,
    /// When the states that were given end (s), if that is before the horizon, and not before 0:
    /// from then on the path goes straight on. `None` for what stands still or is given as a state
    /// that goes on.
    pub ends_s: Option<f64>,
}

/// A motion as it is given.
#[derive(Clone, Debug, PartialEq)]
pub enum GivenMotion {
    /// The body stands.
    Place {
        /// Position of the body frame's origin (m).
        position_m: [f64; 3],
        /// Yaw, pitch, roll (degrees).
        angles_deg: [f64; 3],
    },
    /// The body goes on as it moves at time 0.
    Onward {
        /// Position of the body frame's origin (m).
        position_m: [f64; 3],
        /// Yaw, pitch, roll (degrees).
        angles_deg: [f64; 3],
        /// Velocity in the ground plane (m/s).
        velocity_m_s: [f64; 2],
        /// Rate at which the velocity and the body turn (degrees/s).
        yaw_rate_deg_s: f64,
    },
    /// The body goes through these states.
    States(Vec<GivenState>),
}

/// Where a body is at one time, as it is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GivenState {
    /// The time, from now (s).
    pub time_s: f64,
    /// Position of the body frame's origin (m).
    pub position_m: [f64; 3],
    /// Yaw, pitch, roll (degrees).
    pub angles_deg: [f64; 3],
    /// Velocity in the ground plane (m/s).
    pub velocity_m_s: Option<[f64; 2]>,
}

/// What the ego could do.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// What people call it.
    pub name: Name,
    /// Its position in the file.
    pub place: TextPosition,
    /// How the ego moves.
    pub ego: Motion,
    /// Who moves otherwise than predicted if the ego does this: sorted by party, each at most once.
    pub reactions: Vec<Reaction>,
}

/// The motion of a party in one candidate, instead of all that are predicted.
#[derive(Clone, Debug, PartialEq)]
pub struct Reaction {
    /// Who reacts; never the ego, never what is fixed to the ground.
    pub party: PartyIndex,
    /// How it moves then.
    pub motion: Motion,
}

impl Scenario {
    /// How many members are followed where nothing else is asked for.
    #[must_use]
    pub fn members(&self) -> Members {
        self.members.unwrap_or(Members::USUAL)
    }

    /// Reads a scenario that names no CSV file. `file` is its name in errors; nothing is opened.
    /// [`ScenarioDraft`] reads those that do.
    ///
    /// # Errors
    ///
    /// The first fault found, with its place and what to do about it; one is a CSV file.
    pub fn parse(file: &str, text: &str) -> Result<Self, ScenarioError> {
        ScenarioDraft::parse(file, text)?.finish(|csv| {
            let fault = "a path in a file of its own cannot be read from here";
            Err(ScenarioError::new(file, csv.place, fault, "write states = [{ … }] instead"))
        })
    }

    /// Whether all motions of each party begin where it is now: at one pose, within 1 mm and 0.1°.
    /// What [`Scenario::parse`] returns does.
    ///
    /// # Errors
    ///
    /// The first motion that does not.
    pub fn check_begin(&self, file: &str) -> Result<(), ScenarioError> {
        begin::check(file, self)
    }

    /// Whether every party of unknown kind can be taken for something fixed to the ground.
    ///
    /// # Errors
    ///
    /// The first that moves or reacts, at that motion: nothing can be assumed of it.
    pub fn check_fixed(&self, file: &str) -> Result<(), ScenarioError> {
        let broken = |motion: &Motion, fault: &str| {
            let help = "say what it is, or leave it out";
            Err(ScenarioError::new(file, motion.place, fault, help))
        };
        let unknown = self.parties.iter().filter(|party| party.is_unknown);
        for Prediction { motion, .. } in unknown.flat_map(|party| &party.predictions) {
            if motion.moves() {
                return broken(
                    motion,
                    "a party of unknown kind that moves cannot be taken as fixed",
                );
            }
        }
        for Reaction { party, motion } in self.candidates.iter().flat_map(|way| &way.reactions) {
            if self.parties[party.0].is_unknown {
                let fault = "a party of unknown kind that reacts cannot be taken as fixed";
                return broken(motion, fault);
            }
        }
        Ok(())
    }

    /// Whether the bodies that were opened can play their parts; `kinds[i]` is that of
    /// `parties[i]`.
    ///
    /// The kind of a model file is known only when it is open, so the caller who opens it checks
    /// here: the ego must be a vehicle, persons must have seats that there are and be no more than
    /// the kind can hold, and a fixed object has neither mass nor persons, and neither moves nor
    /// reacts. For generated bodies this was
    /// checked when the scenario was read.
    ///
    /// # Errors
    ///
    /// The first body that does not fit, at its party or at the motion that it cannot have.
    pub fn check_kinds(&self, file: &str, kinds: &[BodyKind]) -> Result<(), ScenarioError> {
        let error_at = |place: TextPosition| {
            move |misfit: Misfit| ScenarioError::new(file, place, misfit.what, misfit.remedy)
        };
        for (index, (party, kind)) in self.parties.iter().zip(kinds).enumerate() {
            let broken = error_at(party.place);
            if PartyIndex(index) == self.ego {
                rules::ego_fits(*kind).map_err(&broken)?;
            }
            rules::mass_fits(*kind, party.mass_kg).map_err(&broken)?;
            rules::occupancy_fits(*kind, &party.occupancy).map_err(&broken)?;
            for Prediction { motion, .. } in &party.predictions {
                rules::motion_fits(*kind, motion).map_err(error_at(motion.place))?;
            }
        }
        for Reaction { party, motion } in self.candidates.iter().flat_map(|way| &way.reactions) {
            if let Some(kind) = kinds.get(party.0) {
                rules::can_react(*kind).map_err(error_at(motion.place))?;
            }
        }
        Ok(())
    }
}

impl Motion {
    /// Whether the body is ever elsewhere, or turned otherwise, than at 0.
    #[must_use]
    pub fn moves(&self) -> bool {
        // Angles beyond a full turn give the same orientation up to rounding.
        const SAME_RAD: f64 = 1e-9;
        self.path.states().windows(2).any(|pair| {
            let turn = pair[0].orientation.angle_to(&pair[1].orientation);
            pair[0].position_m != pair[1].position_m || turn > SAME_RAD
        })
    }

    /// Whether the body stands from when the states that were given end, before the horizon.
    #[must_use]
    pub fn stands_at_end(&self) -> bool {
        // From there to the horizon it is one piece.
        let stands =
            matches!(self.path.states(), [.., last, end] if last.position_m == end.position_m);
        self.ends_s.is_some() && stands
    }
}

impl Occupancy {
    /// How many persons there are, if that is said.
    #[must_use]
    pub fn count(&self) -> Option<u32> {
        match self {
            Self::Stated(groups) => Some(groups.iter().map(|group| group.count).sum()),
            Self::Empty => Some(0),
            Self::Default => None,
        }
    }
}

#[cfg(test)]
mod tests;
