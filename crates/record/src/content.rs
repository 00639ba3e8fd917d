//! The content of a record. Plain values, whose meaning is defined by the crates that they come
//! from.

use crate::named;
use body::Build;
use scenario::Scheme;
use serde::{Deserialize, Serialize};

/// A text that a person wrote.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordedText {
    /// Its name, as it was given.
    pub name: String,
    /// BLAKE3 of the text, hexadecimal.
    pub hash: String,
    /// The text itself.
    pub text: String,
}

/// Where a body came from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RecordedSource {
    /// A model file.
    File {
        /// Its path, as the scenario gives it.
        path: String,
        /// Content hash of that file.
        hash: String,
    },
    /// The built-in generator, called as the scenario says.
    Generated,
}

/// The body of one party.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordedBody {
    /// The party.
    pub party: String,
    /// Where it came from.
    pub source: RecordedSource,
    /// Content hash of the body with the tree that was used.
    pub hash: String,
}

/// What runs the jobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mode {
    /// Worker processes.
    Workers,
    /// The coordinator's own process.
    InProcess,
}

impl Mode {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Workers, Self::InProcess];

    /// Its name in records and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Workers => "workers",
            Self::InProcess => "in-process",
        }
    }
}

/// How the work was divided. Workers and channels are listed for the reader: no answer depends on
/// them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// What ran the jobs.
    #[serde(with = "named")]
    pub mode: Mode,
    /// Worker processes.
    pub workers: u32,
    /// Distribution depth.
    pub depth: u32,
    /// Tree of the bodies.
    #[serde(with = "named")]
    pub tree: Build,
    /// Triangles per leaf at most.
    pub leaf_size: u32,
    /// Match scheme.
    #[serde(with = "named")]
    pub scheme: Scheme,
    /// Its weight of held sections.
    pub alpha: f64,
    /// Jobs per message.
    pub batch: u32,
    /// Maximum number of jobs in flight to one worker.
    pub queue: u32,
    /// Seed of every choice that is called random.
    pub seed: u64,
    /// Parties of unknown kind were taken as fixed to the ground.
    pub unknown_is_fixed: bool,
    /// In how many members candidates were followed; 1: in the scene as stated alone.
    pub members: u32,
    /// In how many at most.
    pub members_max: u32,
}

/// A question about one pose of one contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseQuestion {
    /// Number of the contact in its round.
    pub candidate: u32,
    /// Travel along the relative path from first contact on (m).
    pub travel_m: f64,
}

/// How a job ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RecordedEnd {
    /// Its result was folded in.
    Done,
    /// It was not needed.
    Cut,
    /// Given up: what it would have found is not known.
    Abandoned,
}

/// A job of a round. Jobs that are not in it were open when the answer was given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordedJob {
    /// Number in [`RecordedRound::places`].
    pub place: u32,
    /// Node of the ego's tree.
    pub a: u32,
    /// Node of the other's tree.
    pub b: u32,
    /// How it ended.
    pub end: RecordedEnd,
}

/// A round of contacts: those that come next in the candidates, whose hit sets are surveyed
/// together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RecordedRound {
    /// Questions that were asked by the time of the answer, in that order. One without jobs was
    /// answered by its traversal: nothing was near enough.
    pub places: Vec<PoseQuestion>,
    /// Jobs, in the order in which they were closed.
    pub jobs: Vec<RecordedJob>,
}

/// When the work was to stop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum RecordedUntil {
    /// When all work was done.
    #[default]
    Complete,
    /// When no open work could change the order.
    Ordered,
    /// When no open work could change the winner.
    Certified,
}

/// Where a request was out of time, apart from its jobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordedSearch {
    /// The work between jobs looks at the clock at points that follow from the scene alone. This is
    /// the point, from 0, at which time was over; `None`: it never was.
    pub over_at: Option<u64>,
}

/// A step of the search for contacts that was not done, as there was no time or it was given up: a
/// look, or what comes of looks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct OpenStep {
    /// The number of the candidate, plus that of all candidates for each member before; the scene
    /// as stated comes first.
    pub course: u32,
    /// Its number among the steps of that, from 0: their order follows from the scene and from what
    /// was found so far.
    pub number: u32,
}

/// A job on a worker.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordedSpan {
    /// The worker.
    pub worker: u8,
    /// When it began, from the beginning of the first (ns).
    pub from_ns: u64,
    /// When its result was taken (ns).
    pub to_ns: u64,
}

/// Messages from one process to another.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Edge {
    /// Who sent.
    pub from: String,
    /// Who received.
    pub to: String,
    /// Messages.
    pub messages: u64,
    /// Bytes of these messages, headers included.
    pub bytes: u64,
}

/// How long a stage took.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordedStage {
    /// Its name.
    pub name: String,
    /// Its length (ms).
    pub ms: f64,
}

/// Everything about one request.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordContent {
    /// Name of the build that answered.
    pub build: String,
    /// The scenario.
    pub scenario: RecordedText,
    /// The policy.
    pub policy: RecordedText,
    /// The injury curves.
    pub curves: RecordedText,
    /// The parameters of contact and dynamics.
    pub parameters: RecordedText,
    /// The other texts that the scenario names, as it names them: paths as CSV.
    pub files: Vec<RecordedText>,
    /// How the work was cut.
    pub settings: Settings,
    /// Bodies, in the order of the scenario's parties.
    pub bodies: Vec<RecordedBody>,
    /// Questions and jobs by round.
    pub rounds: Vec<RecordedRound>,
    /// When work was to stop.
    pub until: RecordedUntil,
    /// Where the request was out of time; `None`: it had no deadline.
    pub search: Option<RecordedSearch>,
    /// Steps of the search that were not done, ascending.
    pub open_steps: Vec<OpenStep>,
    /// Jobs on workers; empty without workers. No answer depends on it.
    pub spans: Vec<RecordedSpan>,
    /// Messages by edge.
    pub edges: Vec<Edge>,
    /// Stages and their times.
    pub stages: Vec<RecordedStage>,
    /// Lost workers and other faults.
    pub faults: Vec<String>,
    /// The answer, JSON as it was decided.
    pub answer: String,
    /// Its explanation, JSON.
    pub explanation: String,
}

impl RecordContent {
    /// The jobs of all rounds.
    pub fn all_jobs(&self) -> impl Iterator<Item = &RecordedJob> {
        self.rounds.iter().flat_map(|round| &round.jobs)
    }
}

/// BLAKE3 of a text, hexadecimal.
#[must_use]
pub fn hash_of_text(text: &str) -> String {
    blake3::hash(text.as_bytes()).to_hex().to_string()
}

impl RecordedText {
    /// A text with its hash.
    #[must_use]
    pub fn new(name: &str, text: &str) -> Self {
        Self { name: name.to_owned(), hash: hash_of_text(text), text: text.to_owned() }
    }
}
