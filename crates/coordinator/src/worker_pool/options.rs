//! How a worker pool is started: with which program, on which cores, with which queues.

use dispatch::{Cache, Intensity, Matching, Patience, Queues, StartPatience};
use scenario::EngineSettings;
use std::path::PathBuf;

/// How workers are started.
#[derive(Clone, Debug)]
pub struct Options {
    /// The program that runs as worker: `program worker WORD`.
    pub program: PathBuf,
    /// Name of the instance, part of every shared name.
    pub instance: String,
    /// The private folder of shared files; `None`: the default one.
    pub folder: Option<PathBuf>,
    /// Build id: both ends must have the same one.
    pub build: String,
    /// The core of each worker; `None`: left to the scheduler.
    pub cores: Vec<Option<usize>>,
    /// How jobs are matched to workers.
    pub matching: Matching,
    /// Jobs per message, jobs in flight to one worker at most, and how long a message waits.
    pub queues: Queues,
    /// How much a worker is taken to hold in the transfer account.
    pub cache: Cache,
    /// Whether workers get copies of sections instead of reading the store in place.
    pub copies: bool,
    /// Whether to log which worker got which job.
    pub log: bool,
    /// How long a busy worker may make no progress.
    pub patience: Patience,
    /// How long a worker may take to greet.
    pub start_patience: StartPatience,
    /// How often workers are replaced.
    pub intensity: Intensity,
    /// Whether workers obey fault commands: for fault injection only.
    #[cfg(feature = "faults")]
    pub obeys: bool,
    /// How many of the first workers stop themselves before exec: for fault injection only.
    #[cfg(feature = "faults")]
    pub stopped_starts: u32,
}

impl Options {
    /// The engine's default queues and batches.
    pub const QUEUES: Queues = Queues {
        capacity: EngineSettings::DEFAULT.queue as u32,
        batch: EngineSettings::DEFAULT.batch as u32,
        linger_ns: 0,
    };

    /// One worker per core, each run by this program itself, with the engine's default matching and
    /// queues. Nothing is copied or logged.
    #[must_use]
    pub fn new(
        instance: impl Into<String>,
        build: impl Into<String>,
        cores: Vec<Option<usize>>,
    ) -> Self {
        Self {
            program: runtime::process::self_exe().to_owned(),
            instance: instance.into(),
            folder: None,
            build: build.into(),
            cores,
            matching: Matching::BestMatchLoad(EngineSettings::DEFAULT.alpha),
            queues: Self::QUEUES,
            cache: Cache::Unlimited,
            copies: false,
            log: false,
            patience: Patience::default(),
            start_patience: StartPatience::default(),
            intensity: Intensity::default(),
            #[cfg(feature = "faults")]
            obeys: false,
            #[cfg(feature = "faults")]
            stopped_starts: 0,
        }
    }
}
