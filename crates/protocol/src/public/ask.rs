//! A request: who is around, where everybody may go, and what the ego could do.

use super::{
    CANDIDATES_MAX, ModelSet, PARTIES_MAX, PATHS_MAX, PERSONS_MAX, REACTIONS_MAX, STATES_MAX,
    STATES_PER_PATH_MAX, VERSION, checksum,
};
use bytemuck::{Pod, Zeroable};
use core::mem::offset_of;

/// A request: which of these manoeuvres does least harm?
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Ask {
    /// [`VERSION`].
    pub version: u32,
    /// [`Ask::UNKNOWN_IS_FIXED`], or 0.
    pub flags: u32,
    /// The client's own number, returned in the answer. A client starts at a random number:
    /// iceoryx2 may hand it the answer to a client that was killed and had its slot before, which
    /// only this number reveals.
    pub sequence: u64,
    /// The time after which the answer is useless, on CLOCK_MONOTONIC (ns); 0: never.
    pub answer_by_ns: u64,
    /// See [`Ask::seal`].
    pub checksum: u64,
    /// Number of the party that is the automated vehicle.
    pub ego: u32,
    /// Parties that are filled in, 2 to 32.
    pub party_count: u32,
    /// Rows of persons that are filled in, 0 to 256.
    pub person_count: u32,
    /// Candidates that are filled in, 1 to 16.
    pub candidate_count: u32,
    /// Paths that are filled in, 1 to 256.
    pub path_count: u32,
    /// Reactions that are filled in, 0 to 128.
    pub reaction_count: u32,
    /// States that are filled in, 1 to 7,168.
    pub state_count: u32,
    /// 0.
    pub spare: u32,
    /// How long everybody is followed from now (s), up to 30.
    pub horizon_s: f64,
    /// Bodies that come as near as this (m), 1e-5 to 0.1, count as touching where it cannot be
    /// decided; 0: 1 mm.
    pub resolution_m: f64,
    /// The bodies that the client knows the service to have ([`super::Health::model_set`]): a
    /// service with others refuses. Zeros: not compared.
    pub model_set: ModelSet,
    /// 0.
    pub room: [u64; 2],
    /// Everybody around, and the ego.
    pub parties: [WireParty; PARTIES_MAX],
    /// Persons of the parties that [`WireParty::PERSONS`] marks.
    pub persons: [WirePersons; PERSONS_MAX],
    /// The manoeuvres to choose from.
    pub candidates: [WireCandidate; CANDIDATES_MAX],
    /// Who moves otherwise than predicted in some candidate.
    pub reactions: [WireReaction; REACTIONS_MAX],
    /// All paths.
    pub paths: [WirePath; PATHS_MAX],
    /// The states of all paths, one path after the other.
    pub states: [WirePathState; STATES_MAX],
}

/// A physical body that may be hit.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct WireParty {
    /// Id of its model in the deployment file.
    pub model: u32,
    /// Which of the fields below are used: [`WireParty::PERSONS`], [`WireParty::MASS`],
    /// [`WireParty::UNKNOWN`], [`WireParty::CRUSH`].
    pub flags: u32,
    /// Number of its first predicted path; of the ego 0.
    pub first_path: u32,
    /// How many paths are predicted of it, 1 to 3, which follow each other; of the ego 0, since its
    /// motion is in the candidates.
    pub path_count: u32,
    /// Mass (kg), overriding the model's.
    pub mass_kg: f64,
    /// Share of responsibility of its persons, 0 to 1.
    pub responsibility: f64,
    /// Stiffness A (N/m) and B (N/m²) for the depth check.
    pub crush: [f64; 2],
    /// Room for a size to which the body is stretched (m): 0, this version has bodies as they are.
    pub size_m: [f64; 3],
    /// Room for the covariance of the position in its own frame (m²), row by row: 0, this version
    /// takes poses as exact.
    pub position_covariance_m2: [f64; 4],
    /// Room for the variance of the yaw (degrees²): 0.
    pub yaw_variance_deg2: f64,
    /// Room for the variance of a factor of the speed: 0.
    pub speed_variance: f64,
}

/// Persons in or on a party.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct WirePersons {
    /// Number of the party.
    pub party: u32,
    /// 0: on foot, or on some seat; 1 front left, 2 front right, 3 rear left, 4 rear middle, 5 rear
    /// right, 6 rider, 7 pillion.
    pub seat: u32,
    /// How many, 1 to 90; on a seat 1.
    pub count: u32,
    /// 0.
    pub spare: u32,
}

/// A manoeuvre that may be chosen.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct WireCandidate {
    /// Number of the ego's path.
    pub path: u32,
    /// Number of its first reaction.
    pub first_reaction: u32,
    /// How many parties react, which follow each other.
    pub reaction_count: u32,
    /// 0.
    pub spare: u32,
}

/// The motion of a party in one candidate, instead of all that are predicted.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct WireReaction {
    /// Who reacts.
    pub party: u32,
    /// Number of its path then.
    pub path: u32,
}

/// How a body moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
pub enum WirePathKind {
    /// It stands: one state, whose place and orientation count.
    Place = 1,
    /// It goes on as it moves now: one state with its velocity, and the path's yaw rate.
    Onward = 2,
    /// It goes through 1 to 64 states, in the order of their times; one at least is at or before
    /// time 0.
    States = 3,
}

/// A path: consecutive states, and how they are meant.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct WirePath {
    /// A [`WirePathKind`].
    pub kind: u32,
    /// Number of its first state.
    pub first_state: u32,
    /// How many states it has.
    pub state_count: u32,
    /// 0.
    pub spare: u32,
    /// Of a predicted path: how probable it is, 0 to 1. Those of a party sum to 1. Else 0.
    pub probability: f64,
    /// Of [`WirePathKind::Onward`]: rate at which the velocity turns (degrees/s). Else 0.
    pub yaw_rate_deg_s: f64,
}

/// Where a body is at one time.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct WirePathState {
    /// The time, from now (s).
    pub t_s: f64,
    /// Position of the body frame's origin in the world (m).
    pub position_m: [f64; 3],
    /// Yaw, pitch, roll, applied in the order Z·Y·X (degrees).
    pub angles_deg: [f64; 3],
    /// Velocity in the ground plane of the world (m/s), if [`WirePathState::VELOCITY`] is set.
    pub velocity_m_s: [f64; 2],
    /// [`WirePathState::VELOCITY`], or 0.
    pub flags: u64,
}

impl Ask {
    /// Flag: parties of unknown kind may be assumed to be fixed to the ground, with no persons in
    /// them.
    pub const UNKNOWN_IS_FIXED: u32 = 1;

    /// The bytes before the states: the fewest that travel.
    pub const BYTES_MIN: usize = offset_of!(Self, states);

    /// An empty request that looks this far ahead (s).
    #[must_use]
    pub fn new(horizon_s: f64) -> Box<Self> {
        let mut ask: Box<Self> = bytemuck::allocation::zeroed_box();
        ask.version = VERSION;
        ask.horizon_s = horizon_s;
        ask
    }

    /// Adds a party and returns its number. `None` if there is no capacity.
    pub fn add_party(&mut self, party: WireParty) -> Option<u32> {
        *self.parties.get_mut(self.party_count as usize)? = party;
        self.party_count += 1;
        Some(self.party_count - 1)
    }

    /// Adds a party with one predicted path, which is added too, and returns the party's number.
    /// `None` if there is no capacity.
    pub fn add_party_on(
        &mut self,
        party: WireParty,
        path: WirePath,
        states: &[WirePathState],
    ) -> Option<u32> {
        let path = WirePath { probability: 1.0, ..path };
        let first_path = self.add_path(path, states)?;
        self.add_party(WireParty { first_path, path_count: 1, ..party })
    }

    /// Adds persons; `None` if there is no capacity. Also mark the party with
    /// [`WireParty::PERSONS`].
    pub fn add_persons(&mut self, persons: WirePersons) -> Option<()> {
        *self.persons.get_mut(self.person_count as usize)? = persons;
        self.person_count += 1;
        Some(())
    }

    /// Adds a path through these states and returns its number: where they stand is set here.
    /// `None` if there is no capacity.
    pub fn add_path(&mut self, path: WirePath, states: &[WirePathState]) -> Option<u32> {
        if states.len() > STATES_PER_PATH_MAX {
            return None;
        }
        let first = self.state_count as usize;
        let room = self.states.get_mut(first..first + states.len())?;
        let (first_state, state_count) = (self.state_count, states.len() as u32);
        *self.paths.get_mut(self.path_count as usize)? =
            WirePath { first_state, state_count, ..path };
        room.copy_from_slice(states);
        self.state_count += state_count;
        self.path_count += 1;
        Some(self.path_count - 1)
    }

    /// Adds a candidate whose ego takes this path, and returns its number. `None` if there is no
    /// capacity.
    pub fn add_candidate(&mut self, path: u32, reactions: &[WireReaction]) -> Option<u32> {
        let (first, count) = (self.reaction_count as usize, reactions.len());
        let room = self.reactions.get_mut(first..first + count)?;
        *self.candidates.get_mut(self.candidate_count as usize)? = WireCandidate {
            path,
            first_reaction: first as u32,
            reaction_count: count as u32,
            spare: 0,
        };
        room.copy_from_slice(reactions);
        self.reaction_count += count as u32;
        self.candidate_count += 1;
        Some(self.candidate_count - 1)
    }

    /// How many bytes from the beginning count: all but the states that are not filled in.
    #[must_use]
    pub fn used_bytes(&self) -> usize {
        let states = (self.state_count as usize).min(STATES_MAX);
        Self::BYTES_MIN + states * size_of::<WirePathState>()
    }

    /// The bytes that count.
    #[must_use]
    pub fn used(&self) -> &[u8] {
        &bytemuck::bytes_of(self)[..self.used_bytes()]
    }

    /// Copies a request from its [used](Ask::used) bytes; `None` if they are none. What is beyond
    /// keeps its bytes, and does not count.
    pub fn fill(&mut self, used: &[u8]) -> Option<()> {
        let room = bytemuck::bytes_of_mut(self).get_mut(..used.len())?;
        let head = used.len().checked_sub(Self::BYTES_MIN)?;
        room.copy_from_slice(used);
        let states = (self.state_count as usize).min(STATES_MAX);
        (head == states * size_of::<WirePathState>()).then_some(())
    }

    /// Writes the checksum of all bytes that count: a sender's last step.
    pub fn seal(&mut self) {
        self.checksum = checksum(self.used(), offset_of!(Self, checksum));
    }

    /// Whether every bit that counts is as it was when it was [sealed](Ask::seal).
    #[must_use]
    pub fn is_intact(&self) -> bool {
        self.checksum == checksum(self.used(), offset_of!(Self, checksum))
    }
}

impl WireParty {
    /// Flag: its persons are exactly those listed, possibly none; otherwise those of its model, or
    /// if that names none those that are usual for its kind.
    pub const PERSONS: u32 = 1;
    /// Flag: `mass_kg` is used.
    pub const MASS: u32 = 2;
    /// Flag: its kind is unknown; only the shape of its body is known.
    pub const UNKNOWN: u32 = 4;
    /// Flag: `crush` is used.
    pub const CRUSH: u32 = 8;

    /// A party with the values of its model, and no path yet.
    #[must_use]
    pub fn of_model(model: u32) -> Self {
        Self { model, ..Self::zeroed() }
    }
}

impl WirePath {
    /// A path of this kind, for [`Ask::add_path`].
    #[must_use]
    pub fn of_kind(kind: WirePathKind) -> Self {
        Self { kind: kind as u32, ..Self::zeroed() }
    }
}

impl WirePathKind {
    /// The kind with this number.
    #[must_use]
    pub fn from_number(number: u32) -> Option<Self> {
        [Self::Place, Self::Onward, Self::States].into_iter().find(|kind| *kind as u32 == number)
    }
}

impl WirePathState {
    /// Flag: the velocity is given.
    pub const VELOCITY: u64 = 1;

    /// A state in the ground plane: position (m) and yaw (degrees), without a velocity.
    #[must_use]
    pub fn at(t_s: f64, [x, y]: [f64; 2], yaw_deg: f64) -> Self {
        Self { t_s, position_m: [x, y, 0.0], angles_deg: [yaw_deg, 0.0, 0.0], ..Self::default() }
    }

    /// The state with this velocity in the ground plane of the world (m/s).
    #[must_use]
    pub fn with_velocity(self, velocity_m_s: [f64; 2]) -> Self {
        Self { velocity_m_s, flags: Self::VELOCITY, ..self }
    }
}

const _: () = {
    assert!(size_of::<WireParty>() == 120 && size_of::<WirePersons>() == 16);
    assert!(size_of::<WireCandidate>() == 16 && size_of::<WireReaction>() == 8);
    assert!(size_of::<WirePath>() == 32 && size_of::<WirePathState>() == 80);
    assert!(size_of::<Ask>() == 590_976 && align_of::<Ask>() == 8);
    assert!(offset_of!(Ask, checksum) == 24);
    assert!(offset_of!(Ask, horizon_s) == 64);
    assert!(offset_of!(Ask, model_set) == 80);
    assert!(offset_of!(Ask, parties) == 128);
    assert!(offset_of!(Ask, persons) == 3_968);
    assert!(offset_of!(Ask, candidates) == 8_064);
    assert!(offset_of!(Ask, reactions) == 8_320);
    assert!(offset_of!(Ask, paths) == 9_344);
    assert!(offset_of!(Ask, states) == 17_536);
};
