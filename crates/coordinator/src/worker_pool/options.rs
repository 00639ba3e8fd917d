//! How a worker pool is started: who plays the workers, on which cores, with which queues.

use dispatch::{Cache, Intensity, Matching, Patience, Queues};
use scenario::EngineSettings;
use std::path::PathBuf;

/// How workers are started.
#[derive(Clone, Debug)]
pub struct Options {
    /// The program that plays the worker: `program worker WORD`.
    pub program: PathBuf,
    /// Name of the instance, part of every shared name.
    pub instance: String,
    /// Build id: both ends must have the same.
    pub build: String,
    /// The core of each worker; `None`: wherever the system puts it.
    pub cores: Vec<Option<usize>>,
    /// Who gets which job.
    pub matching: Matching,
    /// Jobs per message, on their way to one worker at most, and how long a message waits.
    pub queues: Queues,
    /// How much the ledger says that a worker holds.
    pub cache: Cache,
    /// Whether workers get copies of sections, and do not read the store in place.
    pub copies: bool,
    /// Whether to write down who got which job.
    pub log: bool,
    /// How long a busy worker may stand still.
    pub patience: Patience,
    /// How often workers are replaced.
    pub intensity: Intensity,
    /// Whether workers misbehave on order: for fault injection alone.
    #[cfg(feature = "faults")]
    pub obeys: bool,
}

impl Options {
    /// Queues and batches as the engine has them where nothing is said.
    pub const QUEUES: Queues = Queues {
        capacity: EngineSettings::DEFAULT.queue as u32,
        batch: EngineSettings::DEFAULT.batch as u32,
        linger_ns: 0,
    };

    /// A worker per core, each played by this program itself; whom to give a job to and how many
    /// as the engine has it where nothing is said. Nothing is copied or written down.
    #[must_use]
    pub fn new(
        instance: impl Into<String>,
        build: impl Into<String>,
        cores: Vec<Option<usize>>,
    ) -> Self {
        Self {
            program: runtime::process::self_exe().to_owned(),
            instance: instance.into(),
            build: build.into(),
            cores,
            matching: Matching::BestMatchLoad(EngineSettings::DEFAULT.alpha),
            queues: Self::QUEUES,
            cache: Cache::Unlimited,
            copies: false,
            log: false,
            patience: Patience::default(),
            intensity: Intensity::default(),
            #[cfg(feature = "faults")]
            obeys: false,
        }
    }
}
