//! What the dispatcher hears, what it asks for, and how far the request is.

use protocol::{Incarnation, JobId, Section};

/// What happened.
#[derive(Debug)]
pub enum Event<'p, P> {
    /// Nothing but time: look for work.
    Poll,
    /// A worker takes jobs from now on.
    Ready(Incarnation),
    /// One part of a result arrived.
    Part {
        /// Who sent it.
        from: Incarnation,
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
    /// A batch could not be handed over.
    Unsent {
        /// To whom.
        to: Incarnation,
        /// What.
        jobs: &'p [JobId],
    },
}

/// What to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Send these jobs as one batch.
    Send {
        /// To whom.
        to: Incarnation,
        /// Jobs, in order, with their attempts.
        jobs: Vec<(JobId, u8)>,
        /// Sections that these need and the core does not hold, in the order of need: what has to
        /// be shipped before, where sections are shipped at all.
        fetch: Vec<Section>,
    },
}

/// One line of the log from which the ledger can be recomputed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
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
