//! What a crew needs of the machine, looked at before anything is made: what is missing, what that
//! means, and what helps.

use super::Options;
use core::fmt;
use diagnostic::{Diagnostic, Kind};
use runtime::machine;
use std::borrow::Cow;
use transport::Sizes;

/// Something that the machine lacks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lack {
    /// What is missing.
    pub what: String,
    /// What helps.
    pub remedy: String,
    /// Whether a crew cannot be started without it.
    pub is_fatal: bool,
}

impl fmt::Display for Lack {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)
    }
}

impl core::error::Error for Lack {}

impl Diagnostic for Lack {
    fn kind(&self) -> Kind {
        Kind::Resources
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        Some(self.remedy.as_str().into())
    }
}

/// File descriptors that the coordinator needs beside those of its workers.
const FILES: u64 = 48;
/// File descriptors for each worker, more than were counted for one (see
/// `tests/processes/inject.rs`).
const FILES_PER_WORKER: u64 = 40;
/// Shared memory for each worker beside its messages (bytes): iceoryx2's own segments.
const SHM_PER_WORKER: u64 = 512 << 10;

/// All that is missing, the fatal first.
#[must_use]
pub fn preflight(options: &Options) -> Vec<Lack> {
    let workers = options.cores.len() as u64;
    let mut lacks = Vec::new();
    let mut lack = |is_fatal, what: String, remedy: String| {
        lacks.push(Lack { what, remedy, is_fatal });
    };
    let files = FILES + FILES_PER_WORKER * workers;
    match machine::files_max() {
        Some(most) if most < files => lack(
            true,
            format!("{workers} workers take {files} file descriptors, and {most} are allowed"),
            format!("raise the limit: ulimit -n {}", files.next_power_of_two()),
        ),
        _ => {}
    }
    let launch_sizes = sizes(options);
    let bytes = workers * (launch_sizes.pool_bytes() as u64 + SHM_PER_WORKER);
    match machine::free_bytes("/dev/shm") {
        Err(error) => lack(
            true,
            format!("/dev/shm cannot be looked at: {error}"),
            "mount a tmpfs there: mount -t tmpfs -o size=64m tmpfs /dev/shm".to_owned(),
        ),
        Ok(free) if free < bytes => lack(
            true,
            format!("messages take {bytes} bytes of /dev/shm, and {free} are free"),
            format!(
                "make it larger: mount -o remount,size={}m /dev/shm; in a container, --shm-size",
                (bytes >> 20) + 64
            ),
        ),
        Ok(_) => {}
    }
    let allowed = runtime::affinity::allowed_cores();
    if let Some(core) = options.cores.iter().flatten().find(|core| !allowed.contains(core)) {
        lack(
            true,
            format!("core {core} is not there, or not allowed: cores {allowed:?} are"),
            "name others with --cores, or none with --cores none".to_owned(),
        );
    }
    if options.cores.len() > allowed.len() {
        lack(
            false,
            format!("{workers} workers share {} cores", allowed.len()),
            "they take turns; --workers N with fewer is as quick".to_owned(),
        );
    }
    lacks.sort_by_key(|lack| !lack.is_fatal);
    lacks
}

fn sizes(options: &Options) -> Sizes {
    let batch = options.queues.batch as usize;
    let words = protocol::job::batch_words(batch, batch);
    let parcel = if options.copies { protocol::launch::PARCEL_WORDS } else { 0 };
    Sizes {
        job_words: words.max(parcel),
        job_queue: options.queues.capacity as usize,
        result_words: protocol::launch::RESULT_WORDS,
        result_queue: protocol::launch::RESULTS,
    }
}
