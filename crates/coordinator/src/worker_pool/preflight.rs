//! What a worker pool requires of the machine, checked before anything is created: what is missing,
//! why it matters, and what helps.

use super::Options;
use core::fmt;
use diagnostic::{Diagnostic, FailureKind};
use runtime::machine;
use std::borrow::Cow;
use transport::Sizes;

/// A requirement that the machine does not meet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingRequirement {
    /// What is missing.
    pub what: String,
    /// What helps.
    pub remedy: String,
    /// Whether a worker pool cannot be started without it.
    pub is_fatal: bool,
}

impl fmt::Display for MissingRequirement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)
    }
}

impl core::error::Error for MissingRequirement {}

impl Diagnostic for MissingRequirement {
    fn kind(&self) -> FailureKind {
        FailureKind::Resources
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        Some(self.remedy.as_str().into())
    }
}

/// File descriptors that the coordinator needs besides those of its workers.
pub const FILES: u64 = 48;
/// File descriptors for each worker, more than one was seen to use (see
/// `tests/processes/inject.rs`).
pub const FILES_PER_WORKER: u64 = 40;
/// Shared memory for each worker besides its messages (bytes): iceoryx2's own segments.
const SHM_PER_WORKER: u64 = 512 << 10;

/// All unmet requirements, the fatal ones first.
#[must_use]
pub fn preflight(options: &Options) -> Vec<MissingRequirement> {
    let workers = options.cores.len() as u64;
    let mut missing = Vec::new();
    let mut require = |is_fatal, what: String, remedy: String| {
        missing.push(MissingRequirement { what, remedy, is_fatal });
    };
    let files = FILES + FILES_PER_WORKER * workers;
    match machine::files_max() {
        Some(most) if most < files => require(
            true,
            format!("{workers} workers take {files} file descriptors, and {most} are allowed"),
            format!("raise the limit: ulimit -n {}", files.next_power_of_two()),
        ),
        _ => {}
    }
    let launch_sizes = sizes(options);
    let reserve = launch_sizes.link_bytes() as u64;
    let bytes = workers * (launch_sizes.pool_bytes() as u64 + SHM_PER_WORKER) + reserve;
    let folder = options.folder.clone().unwrap_or_else(transport::default_folder);
    // The folder itself may not exist yet.
    let shared = folder.ancestors().find(|above| above.exists()).unwrap_or(&folder);
    let shown = shared.display();
    match machine::free_bytes(&shown.to_string()) {
        Err(error) => require(
            true,
            format!("{shown} cannot be inspected: {error}"),
            format!("mount a tmpfs there: mount -t tmpfs -o size=64m tmpfs {shown}"),
        ),
        Ok(free) if free < bytes => require(
            true,
            format!("messages take {bytes} bytes of {shown}, and {free} are free"),
            format!(
                "make it larger: mount -o remount,size={}m {shown}; in a container, --shm-size",
                (bytes >> 20) + 64
            ),
        ),
        Ok(_) => {}
    }
    let allowed = runtime::affinity::allowed_cores();
    if let Some(core) = options.cores.iter().flatten().find(|core| !allowed.contains(core)) {
        require(
            true,
            format!("core {core} does not exist or is not allowed: allowed cores are {allowed:?}"),
            "name others with --cores, or none with --cores none".to_owned(),
        );
    }
    if options.cores.len() > allowed.len() {
        require(
            false,
            format!("{workers} workers share {} cores", allowed.len()),
            "they take turns; --workers N with fewer is as quick".to_owned(),
        );
    }
    missing.sort_by_key(|missing| !missing.is_fatal);
    missing
}

/// What the channels of a worker hold.
pub(super) fn sizes(options: &Options) -> Sizes {
    let sizes = link_sizes(options.queues.batch as usize, options.queues.capacity as usize);
    let chunk = if options.copies { protocol::launch::CHUNK_WORDS } else { 0 };
    Sizes { job_words: sizes.job_words.max(chunk), ..sizes }
}

/// What the channels of a worker hold, with batches of so many jobs and so many jobs on their way,
/// where nothing is copied.
#[must_use]
pub fn link_sizes(batch: usize, queue: usize) -> Sizes {
    Sizes {
        job_words: protocol::job::batch_words(batch, batch),
        job_queue: queue,
        result_words: protocol::launch::RESULT_WORDS,
        result_queue: protocol::launch::RESULTS,
    }
}
