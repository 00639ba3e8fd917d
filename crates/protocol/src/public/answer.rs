//! The answer of the service, and the meaning of its numbers.

use super::{CANDIDATES_MAX, ModelSet, VERSION, checksum};
use bytemuck::{Pod, Zeroable};
use core::mem::offset_of;

/// Size of the text of an answer (bytes).
const TEXT: usize = 160;
/// Contacts of a candidate that an answer has room for: the first ones.
const CONTACTS: usize = 4;

/// Equal in every bit: what is not known is NaN, which no number equals.
macro_rules! equal_in_every_bit {
    ($($name:ty),+) => {$(
        impl PartialEq for $name {
            fn eq(&self, other: &Self) -> bool {
                bytemuck::bytes_of(self) == bytemuck::bytes_of(other)
            }
        }

        impl Eq for $name {}
    )+};
}

mod expected;

pub use expected::{WireExpected, WireMet};

/// The state of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
pub enum WireState {
    /// All work is done.
    Complete = 1,
    /// No open work can change the winner.
    Certified = 2,
    /// Open work could change the winner; the intervals are still valid.
    Degraded = 3,
    /// There is no ranking; [`WireAnswer::reason`] says why.
    Refused = 4,
    /// There is no ranking: the queue of the service is full. Ask again.
    Busy = 5,
}

impl WireState {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 5] =
        [Self::Complete, Self::Certified, Self::Degraded, Self::Refused, Self::Busy];

    /// The verdict with this number.
    #[must_use]
    pub fn from_number(number: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|verdict| *verdict as u32 == number)
    }

    /// The name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::Certified => "certified",
            Self::Degraded => "degraded",
            Self::Refused => "refused",
            Self::Busy => "busy",
        }
    }

    /// Whether there is a ranking.
    #[must_use]
    pub fn has_ranking(self) -> bool {
        !matches!(self, Self::Refused | Self::Busy)
    }
}

/// Why there is no ranking.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
pub enum Reason {
    /// There is one.
    None = 0,
    /// Another version, a count out of bounds, or an undefined flag or number.
    Malformed = 1,
    /// A party names a model that the deployment does not have.
    UnknownModel = 2,
    /// A value is not finite, or beyond its range.
    OutOfRange = 3,
    /// A party is unsuitable for its role: persons in a wall, a pedestrian as the ego.
    Misfit = 4,
    /// A party is of unknown kind, and no assumption is allowed.
    UnknownKind = 5,
    /// The model cannot assess any of these candidates.
    Unassessable = 6,
    /// The time was up before the work began.
    TooLate = 7,
    /// The queue is full.
    QueueFull = 8,
    /// No worker is left, and none can be started at once.
    NoWorkers = 9,
    /// The service is stopping.
    Stopping = 10,
    /// An internal error.
    Internal = 11,
    /// Set only by the client: no answer came in time.
    Silence = 12,
    /// Set only by the client: there is no service.
    NoService = 13,
    /// A bit was changed on the way: of the request, which the service says, or of the answer,
    /// which the client says. Ask again.
    Corrupt = 14,
    /// The service has other bodies than the request names.
    OtherModels = 15,
    /// Every candidate was assessed, as far as there was time, and none is acceptable under the
    /// policy, which then lets none be chosen.
    NoneAcceptable = 16,
}

impl Reason {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 17] = [
        Self::None,
        Self::Malformed,
        Self::UnknownModel,
        Self::OutOfRange,
        Self::Misfit,
        Self::UnknownKind,
        Self::Unassessable,
        Self::TooLate,
        Self::QueueFull,
        Self::NoWorkers,
        Self::Stopping,
        Self::Internal,
        Self::Silence,
        Self::NoService,
        Self::Corrupt,
        Self::OtherModels,
        Self::NoneAcceptable,
    ];

    /// The reason with this number.
    #[must_use]
    pub fn from_number(number: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|reason| *reason as u32 == number)
    }

    /// The name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Malformed => "malformed",
            Self::UnknownModel => "unknown-model",
            Self::OutOfRange => "out-of-range",
            Self::Misfit => "misfit",
            Self::UnknownKind => "unknown-kind",
            Self::Unassessable => "unassessable",
            Self::TooLate => "too-late",
            Self::QueueFull => "queue-full",
            Self::NoWorkers => "no-workers",
            Self::Stopping => "stopping",
            Self::Internal => "internal",
            Self::Silence => "silence",
            Self::NoService => "no-service",
            Self::Corrupt => "corrupt",
            Self::OtherModels => "other-models",
            Self::NoneAcceptable => "none-acceptable",
        }
    }
}

/// Bits of [`WireAnswer::flags`], [`WirePlace::flags`] and [`WireContact::flags`].
pub mod flag {
    /// Of an answer: a further stage of members, or the rest of the first, was not finished in
    /// time. Figures are those of as many members as it states; with 1, those of the scene as
    /// stated, and every place has [`STATED_ALONE`].
    pub const LATE: u32 = 1;
    /// Of an answer: `lead` and `lead_error` are valid.
    pub const LEAD: u32 = 2;
    /// Of an answer: the share of worlds that each candidate wins is valid.
    pub const WORLDS: u32 = 4;

    /// Of a place: the ego touches nobody from the start to the end of its way. Proven. Without
    /// this flag, [`OPEN`] and contacts, it is or may be in contact with somebody at the start, and
    /// they part.
    pub const TOUCHES_NOBODY: u32 = 1;
    /// According to the model it certainly comes before the next.
    pub const CERTAIN: u32 = 2;
    /// The model cannot distinguish it from the first; the first has this flag too.
    pub const TIED: u32 = 4;
    /// A contact has no figures: the bodies overlap at the start, and both stand still.
    pub const UNEVALUABLE: u32 = 8;
    /// What happens from `open_from_s` on is not known.
    pub const OPEN: u32 = 16;
    /// `nearest_party`, `nearest_m` and `nearest_s` are valid.
    pub const NEAREST: u32 = 32;
    /// The figures of the worst-off person are valid.
    pub const PERSON: u32 = 64;
    /// On a predicted path that was not followed, the ego would meet somebody.
    pub const ALTERNATIVE: u32 = 128;
    /// Of a place: members were followed, and [`super::WirePlace::expected`] says what they say.
    /// `work`, `range` and `worst` are means over members then, and all else is of the scene as
    /// stated; but [`TOUCHES_NOBODY`] holds in every member.
    pub const MEMBERS: u32 = 256;
    /// Of a place: nothing of any member is open, so its spread over members is valid.
    pub const SPREAD: u32 = 512;
    /// Of a place: members were asked for, and there was time for none. All is of the scene as
    /// stated, and what happens in members is not known: [`TOUCHES_NOBODY`] is never set.
    pub const STATED_ALONE: u32 = 1024;

    /// Of a contact: it is heavy, and the ego runs out from there; otherwise it drives on.
    pub const HEAVY: u32 = 1;
    /// Of a contact: the model range of the ego's change of velocity holds both.
    pub const MAY_BE_OTHER: u32 = 2;
    /// Of a contact: the bodies are in contact at the start.
    pub const AT_START: u32 = 4;
    /// Of a contact: triangles touch; otherwise they come as near as the resolution.
    pub const TOUCHES: u32 = 8;
    /// Of a contact: the party is fixed to the ground.
    pub const FIXED: u32 = 16;
}

/// The answer to an [`super::Ask`].
///
/// What is not known is NaN, and a flag says so. Two answers are equal if all their bits are.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct WireAnswer {
    /// [`VERSION`].
    pub version: u32,
    /// A [`WireState`].
    pub verdict: u32,
    /// A [`Reason`].
    pub reason: u32,
    /// Places that are filled in; 0 without a ranking.
    pub place_count: u32,
    /// The client's own number.
    pub sequence: u64,
    /// The service's number of the request, from 1 since it started; 0 if it was not processed.
    pub request: u64,
    /// From receipt until work began (ns).
    pub queued_ns: u64,
    /// From then until this answer (ns).
    pub worked_ns: u64,
    /// See [`WireAnswer::sealed`].
    pub checksum: u64,
    /// Bits of [`flag`].
    pub flags: u32,
    /// The number of members that harm is the mean of; 1: it is that of the scene as stated; 0:
    /// there is no ranking.
    pub members: u32,
    /// How many members there might have been: as `members`, if nothing was drawn.
    pub members_max: u32,
    /// How many draws were replaced, as the ego overlapped somebody at time 0.
    pub replaced: u32,
    /// How many worlds were drawn: 0 without [`flag::WORLDS`].
    pub worlds: u32,
    /// 0.
    pub spare: u32,
    /// By how much the leading measure of the second place is more than that of the first, in the
    /// mean over members, with [`flag::LEAD`]; else NaN.
    pub lead: f64,
    /// Its sampling error, of the paired difference, with [`flag::LEAD`]; else NaN. The two are too
    /// close to call where it is more than the size of `lead`.
    pub lead_error: f64,
    /// The bodies of the service; zeros if it was not asked.
    pub model_set: ModelSet,
    /// What is wrong, or which assumption was made: UTF-8, zero-terminated.
    pub text: [u8; TEXT],
    /// Candidates, least harm first.
    pub places: [WirePlace; CANDIDATES_MAX],
}

/// One ranked candidate. Two are equal if all their bits are.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct WirePlace {
    /// Number of the candidate in the request.
    pub candidate: u32,
    /// Bits of [`flag`].
    pub flags: u32,
    /// The policy's leading measure, over the work interval: lo, hi.
    pub work: [f64; 2],
    /// The policy's leading measure, over the model range: low, high.
    pub range: [f64; 2],
    /// How many contacts the candidate has; the first four are listed below.
    pub contact_count: u32,
    /// Party of the person worst off.
    pub worst_party: u32,
    /// Seat of that person, as in [`super::WirePersons`].
    pub worst_seat: u32,
    /// The party that comes nearest, of those that are not touched.
    pub nearest_party: u32,
    /// Probability of injury of the person worst off, over all contacts: lo, hi.
    pub worst: [f64; 2],
    /// From when on it is not known what happens (s), with [`flag::OPEN`].
    pub open_from_s: f64,
    /// How near the nearest party comes, in plan (m).
    pub nearest_m: f64,
    /// And when (s).
    pub nearest_s: f64,
    /// Whom the ego meets, in the order of time.
    pub contacts: [WireContact; CONTACTS],
    /// What members say, with [`flag::MEMBERS`].
    pub expected: WireExpected,
}

/// One contact of a candidate.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct WireContact {
    /// The party that is met.
    pub party: u32,
    /// Bits of [`flag`].
    pub flags: u32,
    /// When the bodies touch (s).
    pub time_s: f64,
    /// Closing speed (m/s).
    pub closing_m_s: f64,
    /// Change of velocity of the ego, nominal: lo, hi (m/s).
    pub ego_delta_v_m_s: [f64; 2],
    /// Change of velocity of the party (m/s).
    pub other_delta_v_m_s: [f64; 2],
}

impl WireAnswer {
    /// Creates an answer without a ranking.
    #[must_use]
    pub fn without_ranking(sequence: u64, verdict: WireState, reason: Reason, text: &str) -> Self {
        let mut answer = Self {
            version: VERSION,
            verdict: verdict as u32,
            reason: reason as u32,
            sequence,
            lead: f64::NAN,
            lead_error: f64::NAN,
            ..Self::zeroed()
        };
        answer.say(text);
        answer
    }

    /// Sets the text, truncated at a character boundary.
    pub fn say(&mut self, text: &str) {
        self.text = [0; TEXT];
        let end = text.floor_char_boundary(TEXT);
        self.text[..end].copy_from_slice(&text.as_bytes()[..end]);
    }

    /// The verdict; an undefined number is read as refused.
    #[must_use]
    pub fn verdict(&self) -> WireState {
        WireState::from_number(self.verdict).unwrap_or(WireState::Refused)
    }

    /// The reason; an undefined number is read as an internal error.
    #[must_use]
    pub fn reason(&self) -> Reason {
        Reason::from_number(self.reason).unwrap_or(Reason::Internal)
    }

    /// The text, up to the first byte that is not UTF-8.
    #[must_use]
    pub fn text(&self) -> &str {
        let end = self.text.iter().position(|byte| *byte == 0).unwrap_or(TEXT);
        let said = self.text.get(..end).unwrap_or_default();
        let sound = |error: core::str::Utf8Error| said.get(..error.valid_up_to());
        core::str::from_utf8(said).unwrap_or_else(|error| {
            sound(error).and_then(|said| core::str::from_utf8(said).ok()).unwrap_or_default()
        })
    }

    /// The answer with the checksum of all its bytes: a sender's last step.
    #[must_use]
    pub fn sealed(mut self) -> Self {
        self.checksum = checksum(bytemuck::bytes_of(&self), offset_of!(Self, checksum));
        self
    }

    /// Whether every bit is as it was when it was [sealed](WireAnswer::sealed).
    #[must_use]
    pub fn is_intact(&self) -> bool {
        self.checksum == checksum(bytemuck::bytes_of(self), offset_of!(Self, checksum))
    }

    /// Whether a further stage of members, or the rest of the first, was not finished in time.
    #[must_use]
    pub fn is_late(&self) -> bool {
        self.flags & flag::LATE != 0
    }

    /// Whether it says in how many worlds each candidate wins.
    #[must_use]
    pub fn has_worlds(&self) -> bool {
        self.flags & flag::WORLDS != 0
    }

    /// By how much the second place has more harm than the first in the mean over members, and the
    /// sampling error of that; `None` where it is not known, or nothing was drawn.
    #[must_use]
    pub fn lead(&self) -> Option<(f64, f64)> {
        (self.flags & flag::LEAD != 0).then_some((self.lead, self.lead_error))
    }

    /// The places that are filled in, least harm first.
    #[must_use]
    pub fn ranking(&self) -> &[WirePlace] {
        self.places.get(..self.place_count as usize).unwrap_or(&self.places)
    }
}

impl Default for WirePlace {
    /// A place of which nothing is filled in.
    fn default() -> Self {
        Self { expected: WireExpected::UNKNOWN, ..Self::zeroed() }
    }
}

impl WirePlace {
    /// The contacts that are listed.
    #[must_use]
    pub fn listed(&self) -> &[WireContact] {
        self.contacts.get(..self.contact_count as usize).unwrap_or(&self.contacts)
    }

    /// What members say; `None`: none were drawn.
    #[must_use]
    pub fn expected(&self) -> Option<&WireExpected> {
        (self.flags & flag::MEMBERS != 0).then_some(&self.expected)
    }

    /// Whether its spread over members is known.
    #[must_use]
    pub fn has_spread(&self) -> bool {
        self.flags & flag::SPREAD != 0
    }

    /// Whether the ego hits nobody, in any member, though it may be in contact with somebody at the
    /// start.
    #[must_use]
    pub fn hits_nobody(&self) -> bool {
        let in_members = |expected: &WireExpected| self.has_spread() && expected.contact == 0.0;
        let is_known = self.expected().is_none_or(in_members);
        let open = flag::OPEN | flag::STATED_ALONE;
        is_known && self.contact_count == 0 && self.flags & open == 0
    }
}

equal_in_every_bit!(WireAnswer, WirePlace);

const _: () = {
    assert!(size_of::<WireContact>() == 56 && size_of::<WirePlace>() == 608);
    assert!(size_of::<WireAnswer>() == 10_016 && align_of::<WireAnswer>() == 8);
    assert!(offset_of!(WireAnswer, checksum) == 48);
    assert!(offset_of!(WireAnswer, lead) == 80);
    assert!(offset_of!(WireAnswer, model_set) == 96);
    assert!(offset_of!(WireAnswer, text) == 128);
    assert!(offset_of!(WireAnswer, places) == 288);
    assert!(offset_of!(WirePlace, contacts) == 96);
    assert!(offset_of!(WirePlace, expected) == 320);
};
