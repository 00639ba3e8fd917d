//! The dispatcher's events and effects, and the progress of the request.

use protocol::{Incarnation, JobId, RequestId, Section};

/// An event.
#[derive(Debug)]
pub enum Event<P> {
    /// Only time has passed: look for work.
    Poll,
    /// A worker is ready for jobs.
    Ready(Incarnation),
    /// One part of a result arrived.
    Part {
        /// The sender.
        from: Incarnation,
        /// The request it belongs to.
        request: RequestId,
        /// Its job.
        job: JobId,
        /// The attempt it belongs to.
        attempt: u8,
        /// Its number, from 0.
        part: u16,
        /// Whether it is the last one.
        last: bool,
        /// Its content.
        body: P,
    },
    /// A worker could not run a job, and is still alive.
    Failed {
        /// The reporting worker.
        from: Incarnation,
        /// The request it belongs to.
        request: RequestId,
        /// The job.
        job: JobId,
        /// The attempt.
        attempt: u8,
    },
    /// A worker is dead and its results are drained.
    Lost {
        /// The worker.
        who: Incarnation,
        /// The job and attempt that it had started.
        started: Option<(JobId, u8)>,
    },
    /// A batch could not be handed over: the queue was full.
    Unsent {
        /// The receiver.
        to: Incarnation,
        /// The number of the batch in [`Effect::Send`].
        batch: u32,
    },
    /// A worker has processed or rejected all batches below a number, and everything it sent for
    /// them was received: results of them that have not arrived never will.
    Answered {
        /// The worker.
        who: Incarnation,
        /// The number of the first batch it may still be working on.
        batches: u32,
    },
    /// A message of a worker was rejected because of its checksum. Whose result it was is unknown
    /// until [`Event::Answered`].
    Garbled {
        /// The worker whose channel it came from.
        from: Incarnation,
    },
    /// The time is up: what is open stays unknown.
    Expired,
}

/// An action to take.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Send these jobs as one batch.
    Send {
        /// The receiver.
        to: Incarnation,
        /// Its number: batches to one incarnation are numbered from 0.
        batch: u32,
        /// Jobs, in order, with their attempts.
        jobs: Vec<(JobId, u8)>,
        /// Sections that these jobs need and the core does not hold, in order of need: to be sent
        /// before, if sections are sent at all.
        fetch: Vec<Section>,
    },
    /// Kill this worker, which is no longer trusted. [`Event::Lost`] must follow.
    Kill {
        /// The worker.
        who: Incarnation,
        /// The reason.
        why: Why,
    },
}

/// Why a worker is no longer trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Why {
    /// Its messages were rejected.
    Garbled,
    /// It left jobs unanswered.
    Forgetful,
    /// Its queue stayed full.
    Full,
}

impl core::fmt::Display for Why {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Garbled => "its messages were rejected",
            Self::Forgetful => "it left jobs unanswered",
            Self::Full => "its queue stayed full",
        })
    }
}

/// An entry of the log from which the ledger can be recomputed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogEntry {
    /// A job was given to a worker.
    Assigned {
        /// The job.
        job: JobId,
        /// Its attempt.
        attempt: u8,
        /// The worker.
        who: Incarnation,
        /// The sections of A and of B, and their sizes (bytes).
        sections: [(Section, u64); 2],
    },
    /// A worker was lost with everything it held.
    Lost {
        /// The worker.
        who: Incarnation,
    },
}

/// The progress of the request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Jobs are pending or out.
    Working,
    /// Every job is closed and no more will come.
    Finished,
    /// Jobs are left, but no worker is alive to run them.
    Stranded,
    /// A section did not fit a memory without eviction, and the run is over.
    Thrashed,
}
