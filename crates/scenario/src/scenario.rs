//! A scenario as values: checked, in SI units, in world coordinates.
//!
//! Values made by [`Scenario::parse`] are in range and consistent. Paths are as written, relative
//! to the scenario's own file.

use crate::check;
use crate::document::TextPosition;
use crate::engine::EngineSettings;
use crate::error::{Misfit, ScenarioError};
use crate::limit;
use crate::rules;
use body::{BodyKind, Fit, Shape, meta::Occupant};
use geometry::{DVec3, Pose};
use std::time::Duration;

/// Name and version of the form, the value of the key `schema`.
pub const SCHEMA: &str = "trolley.scenario/1";

/// Longer texts are refused unread: 16 candidates and 17 parties, each with every key, need 20 kB.
pub const TEXT_BYTES_MAX: usize = 1 << 20;

/// How many candidates a scenario of either form has at most.
pub const CANDIDATES_MAX: usize = limit::CANDIDATES.most;

/// What to rank and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// What people call it.
    pub name: String,
    /// The policy; `None`: the one that comes with the program.
    pub policy: Option<FileRef>,
    /// The injury risk curves; `None`: those of the program.
    pub curves: Option<FileRef>,
    /// Time for the answer from the acceptance of the request; `None`: no deadline.
    pub deadline: Option<Duration>,
    /// How the engine works.
    pub engine: EngineSettings,
    /// The automated vehicle.
    pub ego: PartyIndex,
    /// All bodies, sorted by name; 2 to 17.
    pub parties: Vec<Party>,
    /// The collisions to choose from, in the file's order; 1 to 16, names unique.
    pub candidates: Vec<Candidate>,
}

/// A name; copies of it take nothing from the heap.
pub type Name = smol_str::SmolStr;

/// Persons of one party; the list takes nothing from the heap up to the most there may be.
pub type Occupants = smallvec::SmallVec<[Occupant; limit::PERSONS_MAX]>;

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

/// A physical body that may be hit, and who is inside. It exists once, however many candidates name
/// it, so its persons count once.
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
    /// Persons instead of the model's; an empty list: nobody.
    pub persons: Option<Occupants>,
    /// Share of responsibility of its persons, 0 to 1.
    pub responsibility: f64,
    /// Its kind is unknown: its body is its shape alone.
    pub is_unknown: bool,
    /// Stiffness A (N/m) and B (N/m²) for the check of depth.
    pub crush: Option<[f64; 2]>,
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

/// One collision that may be chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// What people call it.
    pub name: Name,
    /// Its position in the file.
    pub place: TextPosition,
    /// Probability that the collision happens if this candidate is chosen, 0 to 1.
    pub probability: f64,
    /// The ego at predicted impact.
    pub ego: MotionState,
    /// The other side at predicted impact.
    pub other: Opponent,
}

/// The opposing body of a candidate: exactly one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opponent {
    /// Which party; never the ego.
    pub party: PartyIndex,
    /// Where it is and how it moves.
    pub state: MotionState,
}

/// Where a body is and how it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionState {
    /// Yaw, pitch and roll as they were written (degrees): `pose` follows from them.
    pub angles_deg: [f64; 3],
    /// Body frame to world.
    pub pose: Pose,
    /// Velocity of the body in m/s, world frame, in the ground plane: z is +0.0.
    pub velocity_m_s: DVec3,
}

impl Scenario {
    /// Reads a scenario. `file` is its name in errors; nothing is opened.
    ///
    /// # Errors
    ///
    /// The first fault found, with its place and what to do about it.
    pub fn parse(file: &str, text: &str) -> Result<Self, ScenarioError> {
        if text.len() > TEXT_BYTES_MAX {
            let fault = format!("{} bytes are too many for a scenario", text.len());
            let help =
                format!("a scenario has at most {TEXT_BYTES_MAX} bytes; is this the right file?");
            return Err(ScenarioError::new(file, TextPosition::START, fault, help));
        }
        check::scenario(file, text)
    }

    /// Whether every party of unknown kind can be taken for something fixed to the ground.
    ///
    /// # Errors
    ///
    /// The first that moves: nothing can be assumed of it.
    pub fn check_fixed(&self, file: &str) -> Result<(), ScenarioError> {
        for candidate in &self.candidates {
            let moves = candidate.other.state.velocity_m_s != DVec3::ZERO;
            if moves && self.parties[candidate.other.party.0].is_unknown {
                let fault = "a party of unknown kind that moves cannot be taken as fixed";
                let help = "say what it is, or leave this candidate out";
                return Err(ScenarioError::new(file, candidate.place, fault, help));
            }
        }
        Ok(())
    }

    /// Whether the bodies that were opened can play their parts; `kinds[i]` is that of
    /// `parties[i]`.
    ///
    /// The kind of a model file is known only when it is open, so the caller who opens it checks
    /// here: the ego must be a vehicle, persons must have seats that there are, and a fixed object
    /// has neither mass nor persons nor speed. For generated bodies [`Scenario::parse`] has checked
    /// all this.
    ///
    /// # Errors
    ///
    /// The first body that does not fit, at its party or at the candidate that moves it.
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
            let persons = party.persons.as_deref().unwrap_or_default();
            for (index, person) in persons.iter().enumerate() {
                rules::person_fits(Some(*kind), *person, &persons[..index]).map_err(&broken)?;
            }
        }
        for candidate in &self.candidates {
            if let Some(kind) = kinds.get(candidate.other.party.0) {
                rules::stands_still(*kind, candidate.other.state.velocity_m_s)
                    .map_err(error_at(candidate.place))?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
