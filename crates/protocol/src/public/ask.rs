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
    /// In how many members of what is known only up to errors the candidates are followed, up to
    /// 1,024; 1: in the scene as stated alone; 0: as many as the service usually does.
    pub members: u32,
    /// How long everybody is followed from now (s), up to 30.
    pub horizon_s: f64,
    /// Bodies that come as near as this (m), 1e-5 to 0.1, count as touching where it cannot be
    /// decided; 0: 1 mm.
    pub resolution_m: f64,
    /// The bodies that the client knows the service to have ([`super::Health::model_set`]): a
    /// service with others refuses. Zeros: not compared.
    pub model_set: ModelSet,
    /// How many members there are at most, as they are doubled while the best two candidates are
    /// too close to call: at least `members`, up to 1,024. 0: as a scenario that says nothing, 128
    /// or `members`, if these are more; or with `members` 0, too, as the service usually does.
    pub members_max: u32,
    /// 0.
    pub spare: u32,
    /// 0.
    pub room: u64,
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
    /// [`WireParty::UNKNOWN`], [`WireParty::CRUSH`], and one for each of its errors, which are 0
    /// without theirs: see [`WireParty::with_errors`].
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
    /// With [`WireParty::LATERAL`]: standard deviation of its place to its left (m), 0 to 10.
    pub lateral_m: f64,
    /// With [`WireParty::LONGITUDINAL`]: standard deviation along its x axis (m), 0 to 10.
    pub longitudinal_m: f64,
    /// With [`WireParty::CORRELATION`]: correlation of the two, -1 to 1.
    pub correlation: f64,
    /// With [`WireParty::YAW`]: standard deviation of its yaw (degrees), 0 to 90.
    pub yaw_deg: f64,
    /// With [`WireParty::SPEED`]: standard deviation of the logarithm of a factor on its speed, 0
    /// to 0.5.
    pub speed_share: f64,
    /// 0.
    pub room: u64,
}

/// How well a party is known: standard deviations, each `None` where the usual one applies.
///
/// They count where a request is followed in members. Usual are 0.2 m to the left, 0.3 m along,
/// no correlation, 2°, and 0.1 of the speed, of the ego 0.05.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartyErrors {
    /// To its left (m), 0 to 10.
    pub lateral_m: Option<f64>,
    /// Along its x axis (m), 0 to 10.
    pub longitudinal_m: Option<f64>,
    /// Correlation of the two, -1 to 1.
    pub correlation: Option<f64>,
    /// Yaw (degrees), 0 to 90.
    pub yaw_deg: Option<f64>,
    /// Share of its speed, 0 to 0.5.
    pub speed_share: Option<f64>,
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

    /// Asks for expected harm over so many members, and at most so many; 0: see [`Ask::members`]
    /// and [`Ask::members_max`].
    pub fn set_members(&mut self, members: u32, members_max: u32) {
        (self.members, self.members_max) = (members, members_max);
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
    /// Flag: `lateral_m` is used; otherwise the usual error, as for the four below.
    pub const LATERAL: u32 = 16;
    /// Flag: `longitudinal_m` is used.
    pub const LONGITUDINAL: u32 = 32;
    /// Flag: `correlation` is used.
    pub const CORRELATION: u32 = 64;
    /// Flag: `yaw_deg` is used.
    pub const YAW: u32 = 128;
    /// Flag: `speed_share` is used.
    pub const SPEED: u32 = 256;
    /// The flags of all errors.
    pub const ERRORS: u32 =
        Self::LATERAL | Self::LONGITUDINAL | Self::CORRELATION | Self::YAW | Self::SPEED;

    /// A party with the values of its model, and no path yet.
    #[must_use]
    pub fn of_model(model: u32) -> Self {
        Self { model, ..Self::zeroed() }
    }

    /// The party with these errors in place of all that it had.
    #[must_use]
    pub fn with_errors(mut self, errors: &PartyErrors) -> Self {
        let PartyErrors { lateral_m, longitudinal_m, correlation, yaw_deg, speed_share } = *errors;
        let flags = [
            (Self::LATERAL, lateral_m),
            (Self::LONGITUDINAL, longitudinal_m),
            (Self::CORRELATION, correlation),
            (Self::YAW, yaw_deg),
            (Self::SPEED, speed_share),
        ];
        let flags = flags.iter().filter(|(_, error)| error.is_some());
        self.flags = flags.fold(self.flags & !Self::ERRORS, |all, (flag, _)| all | flag);
        self.lateral_m = lateral_m.unwrap_or(0.0);
        self.longitudinal_m = longitudinal_m.unwrap_or(0.0);
        self.correlation = correlation.unwrap_or(0.0);
        self.yaw_deg = yaw_deg.unwrap_or(0.0);
        self.speed_share = speed_share.unwrap_or(0.0);
        self
    }

    /// Its errors, as far as they are used.
    #[must_use]
    pub fn errors(&self) -> PartyErrors {
        let used = |flag: u32, value: f64| (self.flags & flag != 0).then_some(value);
        PartyErrors {
            lateral_m: used(Self::LATERAL, self.lateral_m),
            longitudinal_m: used(Self::LONGITUDINAL, self.longitudinal_m),
            correlation: used(Self::CORRELATION, self.correlation),
            yaw_deg: used(Self::YAW, self.yaw_deg),
            speed_share: used(Self::SPEED, self.speed_share),
        }
    }
}

impl WirePersons {
    /// The name of a seat by its number; `None`: on foot, or on some seat.
    #[must_use]
    pub fn seat_name(seat: u32) -> Option<&'static str> {
        const NAMES: [&str; 7] = [
            "front-left",
            "front-right",
            "rear-left",
            "rear-middle",
            "rear-right",
            "rider",
            "pillion",
        ];
        NAMES.get((seat as usize).checked_sub(1)?).copied()
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
    assert!(offset_of!(WireParty, lateral_m) == 72 && offset_of!(WireParty, room) == 112);
    assert!(offset_of!(Ask, members) == 60);
    assert!(offset_of!(Ask, horizon_s) == 64);
    assert!(offset_of!(Ask, model_set) == 80);
    assert!(offset_of!(Ask, members_max) == 112 && offset_of!(Ask, room) == 120);
    assert!(offset_of!(Ask, parties) == 128);
    assert!(offset_of!(Ask, persons) == 3_968);
    assert!(offset_of!(Ask, candidates) == 8_064);
    assert!(offset_of!(Ask, reactions) == 8_320);
    assert!(offset_of!(Ask, paths) == 9_344);
    assert!(offset_of!(Ask, states) == 17_536);
};
