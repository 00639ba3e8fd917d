//! What clients of the service send and receive: plain structs of fixed size, the same in every
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
//! values are validated where they are used. A changed layout gets a new name: `v2`.

use bytemuck::{Pod, Zeroable};

pub use answer::{Reason, WireAnswer, WirePlace, WireState, flag};
pub use health::{Condition, Health, LatencyStage, WorkerHealth};

mod answer;
mod health;

/// Version of these layouts: the first word of each.
pub const VERSION: u32 = 1;
/// Maximum number of candidates in a request.
pub const CANDIDATES_MAX: usize = 16;
/// Maximum number of parties in a request: the ego, and another one for each candidate.
pub const PARTIES_MAX: usize = 17;
/// Maximum number of persons in a request.
pub const PERSONS_MAX: usize = 64;
/// Maximum number of simultaneous clients of a service.
pub const CLIENTS_MAX: usize = 16;

/// The request–response service.
pub const RANK: &str = "trolley/rank/v1";
/// The event service that a client notifies after sending, to wake a sleeping service.
pub const WAKE: &str = "trolley/wake/v1";
/// Every answer, for any listener.
pub const RANKING: &str = "trolley/ranking/v1";
/// The state of the service, for any listener.
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
    /// The client's own number, returned in the answer. A client starts at a random number:
    /// iceoryx2 may hand it the answer to a client that was killed and had its slot before, which
    /// only this number reveals.
    pub sequence: u64,
    /// The time after which the answer is useless, on CLOCK_MONOTONIC (ns); 0: never.
    pub answer_by_ns: u64,
    /// [`Ask::UNKNOWN_IS_FIXED`], or 0.
    pub flags: u32,
    /// Number of the party that is the automated vehicle.
    pub ego: u32,
    /// Parties that may be hit, and the ego.
    pub parties: [WireParty; PARTIES_MAX],
    /// Persons of the parties that [`WireParty::PERSONS`] marks.
    pub persons: [Person; PERSONS_MAX],
    /// The collisions to choose from.
    pub candidates: [WireCandidate; CANDIDATES_MAX],
}

/// A physical body that may be hit. It is listed once, however many candidates name it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct WireParty {
    /// Id of its model in the deployment file.
    pub model: u32,
    /// Which of the fields below are used: [`WireParty::PERSONS`], [`WireParty::MASS`],
    /// [`WireParty::UNKNOWN`], [`WireParty::CRUSH`].
    pub flags: u32,
    /// Mass (kg), overriding the model's.
    pub mass_kg: f64,
    /// Share of responsibility of its persons, 0 to 1.
    pub responsibility: f64,
    /// Stiffness A (N/m) and B (N/m²) for the depth check.
    pub crush: [f64; 2],
}

/// A person in or on a party.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Person {
    /// Number of the party.
    pub party: u32,
    /// 0: on foot; 1 front left, 2 front right, 3 rear left, 4 rear middle, 5 rear right, 6 rider,
    /// 7 pillion.
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

/// The pose and velocity of a body.
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
    /// Flag: parties of unknown kind may be assumed to be fixed to the ground, with no persons in
    /// them.
    pub const UNKNOWN_IS_FIXED: u32 = 1;

    /// An empty request.
    #[must_use]
    pub fn new(sequence: u64) -> Self {
        Self { version: VERSION, sequence, ..Self::zeroed() }
    }

    /// Adds a party and returns its number. `None` if there is no capacity.
    pub fn add_party(&mut self, party: WireParty) -> Option<u32> {
        *self.parties.get_mut(self.party_count as usize)? = party;
        self.party_count += 1;
        Some(self.party_count - 1)
    }

    /// Adds a person; `None` if there is no capacity. Also mark the party with
    /// [`WireParty::PERSONS`].
    pub fn add_person(&mut self, person: Person) -> Option<()> {
        *self.persons.get_mut(self.person_count as usize)? = person;
        self.person_count += 1;
        Some(())
    }

    /// Adds a candidate and returns its number. `None` if there is no capacity.
    pub fn add_candidate(&mut self, candidate: WireCandidate) -> Option<u32> {
        *self.candidates.get_mut(self.candidate_count as usize)? = candidate;
        self.candidate_count += 1;
        Some(self.candidate_count - 1)
    }
}

impl WireParty {
    /// Flag: its persons are exactly those listed, possibly none; otherwise the model's.
    pub const PERSONS: u32 = 1;
    /// Flag: `mass_kg` is used.
    pub const MASS: u32 = 2;
    /// Flag: its kind is unknown; only the shape of its body is known.
    pub const UNKNOWN: u32 = 4;
    /// Flag: `crush` is used.
    pub const CRUSH: u32 = 8;

    /// A party with the values of its model.
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
