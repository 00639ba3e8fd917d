//! What clients of the service send and receive: plain structs of fixed size, the same in every
//! language.
//!
//! | struct | bytes | service | who writes |
//! |---|--:|---|---|
//! | [`Ask`] | 590,976 | `trolley/rank/v3`, request | a client |
//! | [`WireAnswer`] | 10,016 | `trolley/rank/v3`, response; `trolley/ranking/v3` | the service |
//! | [`Health`] | 840 | `trolley/health/v3` | the service |
//!
//! Numbers are little-endian as on the machine, lengths in metres, angles in degrees, speeds in
//! m/s, times of requests in seconds from now, others in nanoseconds on CLOCK_MONOTONIC. No byte is
//! padding, every bit pattern is a value; values are validated where they are used. A changed
//! layout gets a new name: `v4`.
//!
//! The states of all paths stand at the end of an [`Ask`], so only [`Ask::used_bytes`] of it
//! travel. From end to end request and answer carry a CRC-64/NVME over all bytes that count: where
//! one was changed on the way, a request is refused ([`Reason::Corrupt`]) and an answer is not
//! believed.

pub use answer::{
    Reason, WireAnswer, WireContact, WireExpected, WireMet, WirePlace, WireState, flag,
};
pub use ask::{
    Ask, PartyErrors, WireCandidate, WireParty, WirePath, WirePathKind, WirePathState, WirePersons,
    WireReaction,
};
pub use health::{Condition, Health, LatencyStage, WorkerHealth};

mod answer;
mod ask;
mod health;

/// Version of these layouts: the first word of each.
pub const VERSION: u32 = 3;
/// Maximum number of candidates in a request.
pub const CANDIDATES_MAX: usize = 16;
/// Maximum number of parties in a request, the ego among them.
pub const PARTIES_MAX: usize = 32;
/// Maximum number of rows of persons in a request, and of persons.
pub const PERSONS_MAX: usize = 256;
/// Maximum number of states of a path.
pub const STATES_PER_PATH_MAX: usize = 64;
/// Maximum number of predicted paths of a party.
pub const PATHS_PER_PARTY_MAX: usize = 3;
/// Maximum number of paths in a request: three of each other party, one of each candidate, and 147
/// of reactions.
pub const PATHS_MAX: usize = 256;
/// Maximum number of reactions in a request.
pub const REACTIONS_MAX: usize = 128;
/// Maximum number of states in a request: of three paths of 64 for each other party and one for
/// each candidate there are 6,976.
pub const STATES_MAX: usize = 7168;
/// Maximum number of simultaneous clients of a service.
pub const CLIENTS_MAX: usize = 16;

/// The request–response service.
pub const RANK: &str = "trolley/rank/v3";
/// The event service that a client notifies after sending, to wake a sleeping service.
pub const WAKE: &str = "trolley/wake/v3";
/// Every answer, for any listener.
pub const RANKING: &str = "trolley/ranking/v3";
/// The state of the service, for any listener.
pub const HEALTH: &str = "trolley/health/v3";

/// Identity of the bodies of a service: a hash of their ids, kinds, masses, persons and triangles.
pub type ModelSet = [u8; 32];

/// The checksum of bytes, with zeros in place of the eight at `place`.
fn checksum(bytes: &[u8], place: usize) -> u64 {
    let mut digest = crc_fast::Digest::new(crc_fast::CrcAlgorithm::Crc64Nvme);
    digest.update(&bytes[..place]);
    digest.update(&[0; 8]);
    digest.update(&bytes[place + 8..]);
    digest.finalize()
}

#[cfg(test)]
mod tests;
