//! What the processes of a deployment take at most: memory, descriptors, threads, shared memory.
//!
//! Everything is computed from limits that the code keeps, so that the machine can be sized before
//! anything runs. What things take one by one was measured where no limit states it, with a margin;
//! `cargo x bounds` holds the sums against services at their limits.

use crate::deployment::Deployment;
use crate::housekeeping::WAITING;
use coordinator::{FILES, FILES_PER_WORKER, HELPER_STACK_BYTES, RequestExtent, link_sizes};
use protocol::StatusPage;
use protocol::launch::PATHS_WORDS;
use protocol::public::{Ask, CANDIDATES_MAX, PARTIES_MAX, STATES_MAX, WireAnswer};
use serde::Serialize;
use transport::Sizes;
use transport::service::{shared_bytes, shared_segments};

/// The bodies of a deployment, as they are sealed, and the program that serves them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SealedModels {
    /// Bytes of the store.
    pub store_bytes: usize,
    /// Bytes of the largest model in it.
    pub largest_bytes: usize,
    /// Triangles of all bodies.
    pub triangles: usize,
    /// Triangles of the largest one.
    pub largest_triangles: usize,
    /// Bytes of the program.
    pub program_bytes: usize,
    /// Threads that build trees at the start: as many as the machine grants cores.
    pub cores: usize,
}

/// What one process takes at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ProcessBound {
    /// What it does.
    pub process: &'static str,
    /// How many of them there are.
    pub count: usize,
    /// Heap, stacks and what it maps of shared memory: resident at the peak (bytes).
    pub own_bytes: usize,
    /// The program and its libraries: resident at the peak (bytes). All processes share them.
    pub program_bytes: usize,
    /// Open descriptors.
    pub descriptors: u64,
    /// Threads.
    pub threads: usize,
}

/// What a deployment takes at most.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ResourceBounds {
    /// Its processes: the service, and its workers.
    pub processes: Vec<ProcessBound>,
    /// What a request takes from the heap (bytes): of what `own_bytes` of the service has.
    pub request_bytes: usize,
    /// Named segments in the service's folder.
    pub segments: usize,
    /// Bytes of all files in that folder, and of what is held back for a successor.
    pub folder_bytes: usize,
    /// Bytes of shared memory without a name: models, status page, paths.
    pub unnamed_bytes: usize,
    /// All memory together (bytes): what is shared counts once.
    pub total_bytes: usize,
}

/// Libraries of the C world that the program loads (bytes): measured 4 MiB with GNU's.
const LIBRARIES_BYTES: usize = 6 << 20;
/// What a service has on its heap before anything is asked (bytes): measured 7 MiB, with models of
/// 40,000 triangles.
const SERVICE_BYTES: usize = 8 << 20;
/// What a worker has on heap and stack besides what grows with bodies (bytes): measured 2.3 MiB.
/// Kernel and encounters hold at most 2¹⁸ pairs each.
const WORKER_BYTES: usize = 6 << 20;
/// Threads of a service: it answers in the first; guard and housekeeping have one each.
const SERVICE_THREADS: usize = 3;
/// Stack of a thread (bytes): all of it is resident where memory is locked.
const STACK_BYTES: usize = 2 << 20;
/// What a thread that builds trees touches of its stack and heap besides the tree (bytes).
const BUILDER_BYTES: usize = 512 << 10;
/// What the heap of a further thread begins with (bytes): 132 KiB of glibc's, with a margin.
const ARENA_BYTES: usize = 256 << 10;
/// Bytes that building a tree takes for each triangle, besides the result (`bvh::build`).
const BUILD_BYTES: usize = 96;
/// How often a model is in memory while it is made: body, encoded, aligned, hashed.
const MODEL_COPIES: usize = 4;
/// Bytes that a service keeps for each triangle: its shell.
const SHELL_BYTES: usize = 8;
/// Descriptors of a worker: measured 19.
const WORKER_FILES: u64 = 24;

impl ResourceBounds {
    /// Computes what a deployment takes, with workers or, `in_process`, without.
    #[must_use]
    pub fn of(deployment: &Deployment, models: &SealedModels, in_process: bool) -> Self {
        let engine = &deployment.engine;
        let workers = if in_process { 0 } else { engine.workers };
        let sizes: Sizes = link_sizes(engine.batch, engine.queue);
        let request_bytes = RequestExtent {
            candidates: CANDIDATES_MAX,
            parties: PARTIES_MAX,
            states: STATES_MAX,
            members: deployment.members_limit as usize,
            triangles: models.largest_triangles,
        }
        .heap_bytes();
        let decision = size_of::<Ask>() + size_of::<WireAnswer>();
        let decisions = deployment.decisions.as_ref().map_or(0, |_| WAITING * decision);
        let waiting = (deployment.queue + 1) * size_of::<Ask>();

        // The heap at the start, while bodies are made, and at work: what is freed is used again.
        let start = models.store_bytes
            + MODEL_COPIES * models.largest_bytes
            + BUILD_BYTES * models.largest_triangles;
        let work = (deployment.realtime.heap_mib << 20).max(request_bytes);
        let heap = start.max(work) + SHELL_BYTES * models.triangles + decisions + waiting;
        // Pieces that fit nothing: the same requests one after the other were seen to add 8 %.
        let heap = SERVICE_BYTES + heap + heap / 8;
        // Trees are built at the start; later a thread for each worker that waits may help.
        let helpers = workers * (HELPER_STACK_BYTES + ARENA_BYTES);
        let helpers = helpers.max(models.cores * BUILDER_BYTES);
        let stacks = SERVICE_THREADS * STACK_BYTES + helpers;
        let in_worker = WORKER_BYTES + 2 * models.largest_triangles;

        let links = workers * sizes.link_bytes();
        let paths = if workers == 0 { 0 } else { PATHS_WORDS * 8 + size_of::<StatusPage>() };
        let unnamed = models.store_bytes + paths;
        let reserve = if workers == 0 { 0 } else { sizes.link_bytes() };
        let folder = shared_bytes() + links + reserve;
        // A private copy of the code's own data, which is written once.
        let program = models.program_bytes + LIBRARIES_BYTES;
        let service = ProcessBound {
            process: "service",
            count: 1,
            own_bytes: heap + stacks + unnamed + shared_bytes() + links,
            program_bytes: program,
            descriptors: FILES + FILES_PER_WORKER * workers as u64,
            threads: SERVICE_THREADS + models.cores.max(workers),
        };
        let worker = ProcessBound {
            process: "worker",
            count: workers,
            own_bytes: in_worker + unnamed + sizes.link_bytes(),
            program_bytes: program,
            descriptors: WORKER_FILES,
            threads: 1,
        };
        Self {
            request_bytes,
            segments: shared_segments() + workers * Sizes::SEGMENTS,
            folder_bytes: folder,
            unnamed_bytes: unnamed,
            total_bytes: heap + stacks + workers * in_worker + unnamed + folder + program,
            processes: [service, worker].into_iter().filter(|bound| bound.count > 0).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    //! What a deployment allows more of takes more.
    use super::*;

    const MINIMAL: &str = include_str!("../config/deployments/minimal.toml");
    const MODELS: SealedModels = SealedModels {
        store_bytes: 2 << 20,
        largest_bytes: 1 << 20,
        triangles: 24_000,
        largest_triangles: 20_000,
        program_bytes: 16 << 20,
        cores: 4,
    };

    fn of(more: &str) -> ResourceBounds {
        let text = MINIMAL.replacen("[engine]", more, 1);
        ResourceBounds::of(&Deployment::parse("d.toml", &text).unwrap(), &MODELS, false)
    }

    #[test]
    fn every_setting_that_takes_memory_counts() {
        let least = of("members_limit = 128\n[engine]");
        assert!(least.request_bytes > 0 && least.total_bytes > least.folder_bytes);
        for more in [
            "members_limit = 129\n[engine]",
            "members_limit = 128\n[decisions]\nfolder = \"d\"\n[engine]",
            "members_limit = 128\n[realtime]\nheap_mib = 1000\n[engine]",
            "members_limit = 128\n[engine]\nqueue = 999",
        ] {
            assert!(of(more).total_bytes > least.total_bytes, "{more}");
        }
        let long_queues = of("members_limit = 128\n[engine]\nqueue = 999");
        let large_batches = of("members_limit = 128\n[engine]\nqueue = 999\nbatch = 200");
        assert!(large_batches.total_bytes > long_queues.total_bytes);
        let fewer = of("members_limit = 128\nqueue = 1\n[engine]");
        assert!(fewer.total_bytes < least.total_bytes);
    }

    #[test]
    fn without_workers_there_is_one_process_and_no_link() {
        let deployment = Deployment::parse("d.toml", MINIMAL).unwrap();
        let alone = ResourceBounds::of(&deployment, &MODELS, true);
        let both = ResourceBounds::of(&deployment, &MODELS, false);
        assert_eq!((alone.processes.len(), both.processes[1].count), (1, 2));
        assert_eq!(both.segments - alone.segments, 2 * Sizes::SEGMENTS);
        assert!(alone.total_bytes < both.total_bytes);
        assert!(alone.processes[0].descriptors < both.processes[0].descriptors);
    }

    #[test]
    fn what_is_shared_counts_once() {
        let both = of("[engine]");
        let each: usize = both.processes.iter().map(|bound| bound.count * bound.own_bytes).sum();
        assert!(both.total_bytes < each + both.processes[0].program_bytes + both.folder_bytes);
    }
}
