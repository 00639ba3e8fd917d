//! What clients of the service send and get: plain structs of fixed size, the same in every
//! language.
//!
//! | struct | bytes | service | who writes |
//! |---|--:|---|---|
//! | [`Ask`] | 3,536 | `trolley/rank/v1`, request | a client |
//! | [`WireAnswer`] | 2,016 | `trolley/rank/v1`, response; `trolley/ranking/v1` | the service |
//! | [`Health`] | 808 | `trolley/health/v1` | the service |
//!
//! Numbers are little-endian as on the machine, lengths in metres, angles in degrees, speeds in
//! m/s, times in nanoseconds on CLOCK_MONOTONIC. No byte is padding, every bit pattern is a value;
//! what it means is checked where it is used. A change of a layout is a new name: `v2`.

use bytemuck::{Pod, Zeroable};

pub use answer::{Reason, WireAnswer, WirePlace, WireState, flag};
pub use health::{Condition, Health, LatencyStage, WorkerHealth};

mod answer;
mod health;

/// Version of these layouts: the first word of each.
pub const VERSION: u32 = 1;
/// Most candidates of a request.
pub const CANDIDATES_MAX: usize = 16;
/// Most parties of a request: the ego, and another one for each candidate.
pub const PARTIES_MAX: usize = 17;
/// Most persons that a request names.
pub const PERSONS_MAX: usize = 64;
/// Most clients of a service at the same time.
pub const CLIENTS_MAX: usize = 16;

/// The request–response service.
pub const RANK: &str = "trolley/rank/v1";
/// The event service that a client notifies after sending: it wakes a service that sleeps.
pub const WAKE: &str = "trolley/wake/v1";
/// Every answer, for whoever listens.
pub const RANKING: &str = "trolley/ranking/v1";
/// How the service is, for whoever listens.
pub const HEALTH: &str = "trolley/health/v1";

/// A request: which of these collisions does least harm?
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Ask {
    /// [`VERSION`].
    pub version: u32,
    /// Candidates that are filled in, 1 to 16.
    pub candidate_count: u32,
    /// Parties that are filled in, 2 to 17.
    pub party_count: u32,
    /// Persons that are filled in, 0 to 64.
    pub person_count: u32,
    /// The client's own number; the answer carries it. A client begins at random: iceoryx2 may
    /// hand it the answer to one that was killed in its place, which it knows by this alone.
    pub sequence: u64,
    /// When the answer is of no more use, on CLOCK_MONOTONIC (ns); 0: never.
    pub answer_by_ns: u64,
    /// [`Ask::UNKNOWN_IS_FIXED`], or 0.
    pub flags: u32,
    /// Number of the party that is the automated vehicle.
    pub ego: u32,
    /// Whoever may be hit, and the ego.
    pub parties: [WireParty; PARTIES_MAX],
    /// Persons of the parties that [`WireParty::PERSONS`] marks.
    pub persons: [Person; PERSONS_MAX],
    /// The collisions to choose from.
    pub candidates: [WireCandidate; CANDIDATES_MAX],
}

/// A physical body that may be hit. It exists once, however many candidates name it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct WireParty {
    /// Id of its model in the deployment file.
    pub model: u32,
    /// Which of the fields below count: [`WireParty::PERSONS`], [`WireParty::MASS`], [`WireParty::UNKNOWN`],
    /// [`WireParty::CRUSH`].
    pub flags: u32,
    /// Mass instead of the model's (kg).
    pub mass_kg: f64,
    /// Share of responsibility of its persons, 0 to 1.
    pub responsibility: f64,
    /// Stiffness A (N/m) and B (N/m²) for the check of depth.
    pub crush: [f64; 2],
}

/// A person in or on a party.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Person {
    /// Number of the party.
    pub party: u32,
    /// 0: on foot; 1 front left, 2 front right, 3 rear left, 4 rear middle, 5 rear right, 6 rider.
    pub seat: u32,
}

/// A collision that may be chosen.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct WireCandidate {
    /// Number of the opposing party; not the ego.
    pub party: u32,
    /// 0.
    pub spare: u32,
    /// Probability that the collision happens if this candidate is chosen, 0 to 1.
    pub probability: f64,
    /// The ego at predicted impact.
    pub ego: Motion,
    /// The opposing party at predicted impact.
    pub other: Motion,
}

/// Where a body is and how it moves.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Motion {
    /// Position of the body frame's origin in the world (m).
    pub position_m: [f64; 3],
    /// Yaw, pitch, roll, applied in the order Z·Y·X (degrees).
    pub angles_deg: [f64; 3],
    /// Velocity in the ground plane of the world (m/s).
    pub velocity_m_s: [f64; 2],
}

impl Ask {
    /// Flag: parties of unknown kind may be taken as fixed to the ground, with nobody in them.
    pub const UNKNOWN_IS_FIXED: u32 = 1;

    /// Nothing asked yet.
    #[must_use]
    pub fn new(sequence: u64) -> Self {
        Self { version: VERSION, sequence, ..Self::zeroed() }
    }

    /// Adds a party; its number. `None` if there is no room.
    pub fn add_party(&mut self, party: WireParty) -> Option<u32> {
        *self.parties.get_mut(self.party_count as usize)? = party;
        self.party_count += 1;
        Some(self.party_count - 1)
    }

    /// Adds a person; `None` if there is no room. Mark the party with [`WireParty::PERSONS`], too.
    pub fn add_person(&mut self, person: Person) -> Option<()> {
        *self.persons.get_mut(self.person_count as usize)? = person;
        self.person_count += 1;
        Some(())
    }

    /// Adds a candidate; its number. `None` if there is no room.
    pub fn add_candidate(&mut self, candidate: WireCandidate) -> Option<u32> {
        *self.candidates.get_mut(self.candidate_count as usize)? = candidate;
        self.candidate_count += 1;
        Some(self.candidate_count - 1)
    }
}

impl WireParty {
    /// Flag: its persons are those that are listed, which may be nobody; else the model's.
    pub const PERSONS: u32 = 1;
    /// Flag: `mass_kg` counts.
    pub const MASS: u32 = 2;
    /// Flag: nobody knows what it is: its body is its shape alone.
    pub const UNKNOWN: u32 = 4;
    /// Flag: `crush` counts.
    pub const CRUSH: u32 = 8;

    /// A party that is as its model says.
    #[must_use]
    pub fn of_model(model: u32) -> Self {
        Self { model, ..Self::zeroed() }
    }
}

const _: () = {
    use core::mem::offset_of;
    assert!(size_of::<Motion>() == 64 && size_of::<WireCandidate>() == 144);
    assert!(size_of::<WireParty>() == 40 && size_of::<Person>() == 8);
    assert!(size_of::<Ask>() == 3536 && align_of::<Ask>() == 8);
    assert!(offset_of!(Ask, parties) == 40);
    assert!(offset_of!(Ask, persons) == 720);
    assert!(offset_of!(Ask, candidates) == 1232);
};
