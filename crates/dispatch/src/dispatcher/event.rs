//! What the dispatcher hears, what it asks for, and how far the request is.

use protocol::{Incarnation, JobId, RequestId, Section};

/// What happened.
#[derive(Debug)]
pub enum Event<P> {
    /// Nothing but time: look for work.
    Poll,
    /// A worker takes jobs from now on.
    Ready(Incarnation),
    /// One part of a result arrived.
    Part {
        /// Who sent it.
        from: Incarnation,
        /// The request that it belongs to.
        request: RequestId,
        /// Its job.
        job: JobId,
        /// The attempt that it belongs to.
        attempt: u8,
        /// Its number, from 0.
        part: u16,
        /// Whether it is the last one.
        last: bool,
        /// What it carries.
        body: P,
    },
    /// A worker could not run a job, and lives.
    Failed {
        /// Who says so.
        from: Incarnation,
        /// The request that it belongs to.
        request: RequestId,
        /// The job.
        job: JobId,
        /// The attempt.
        attempt: u8,
    },
    /// A worker is dead and its results are drained.
    Lost {
        /// Who.
        who: Incarnation,
        /// The job and attempt it had started.
        started: Option<(JobId, u8)>,
    },
    /// A batch could not be handed over: the queue was full.
    Unsent {
        /// To whom.
        to: Incarnation,
        /// Which one: [`Effect::Send`]'s number.
        batch: u32,
    },
    /// A worker has worked off all batches below a number, or turned them away, and everything that
    /// it sent for them was taken: what has not come of them will not come.
    Answered {
        /// Who.
        who: Incarnation,
        /// The number of the first batch that it may still be working on.
        batches: u32,
    },
    /// A message of a worker was turned away: its checksum did not fit. Whose result it was is not
    /// known; [`Event::Answered`] will tell.
    Garbled {
        /// On whose channel.
        from: Incarnation,
    },
    /// The time is up: what is open stays unknown.
    Expired,
}

/// What to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Send these jobs as one batch.
    Send {
        /// To whom.
        to: Incarnation,
        /// Its number: batches to one incarnation are numbered from 0.
        batch: u32,
        /// Jobs, in order, with their attempts.
        jobs: Vec<(JobId, u8)>,
        /// Sections that these need and the core does not hold, in the order of need: what has to
        /// be shipped before, where sections are shipped at all.
        fetch: Vec<Section>,
    },
    /// End this worker: it can no longer be trusted. [`Event::Lost`] is to follow.
    Kill {
        /// Whom.
        who: Incarnation,
        /// Why.
        why: Why,
    },
}

/// Why a worker is no longer trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Why {
    /// Its messages were turned away.
    Garbled,
    /// It left jobs unanswered.
    Forgetful,
    /// Its queue stayed full.
    Full,
}

impl core::fmt::Display for Why {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Garbled => "its messages were turned away",
            Self::Forgetful => "it left jobs unanswered",
            Self::Full => "its queue stayed full",
        })
    }
}

/// One line of the log from which the ledger can be recomputed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogEntry {
    /// A job was given to a worker.
    Assigned {
        /// The job.
        job: JobId,
        /// Its attempt.
        attempt: u8,
        /// To whom.
        who: Incarnation,
        /// The sections of A and of B, and what they weigh (bytes).
        sections: [(Section, u64); 2],
    },
    /// A worker was lost with all that it held.
    Lost {
        /// Who.
        who: Incarnation,
    },
}

/// How far the request is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Jobs are pending or out.
    Working,
    /// Every job is closed and no more are to come.
    Finished,
    /// Jobs are left, and nobody lives to take them.
    Stranded,
    /// A section did not fit a memory without eviction, and the run is over.
    Thrashed,
}
