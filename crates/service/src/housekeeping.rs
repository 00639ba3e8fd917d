//! The housekeeping thread: cleans up after dead clients, and writes files.
//!
//! The service hands it work through a queue of fixed length, and so never waits for a disk. A
//! decision that finds the queue full is lost, with a warning.

use crate::decisions::{Book, DecisionSigner};
use crate::deployment::{Decisions, Deployment};
use crate::metrics;
use crate::run::ServiceError;
use core::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use crossbeam::queue::ArrayQueue;
use protocol::public::{Ask, Health, WireAnswer};
use runtime::process::{Child, Spawn, spawn};
use runtime::{clock, output};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;
use transport::service::Housekeeper;

/// Capacity of the queue of decisions to write.
pub(crate) const WAITING: usize = 256;
/// Interval between cleanups after dead clients (ns): as often as a client may be replaced by hand.
const CLEAN_NS: u64 = 500_000_000;
/// How long one cleanup may take (ns) before its process is killed.
const CLEAN_LIMIT_NS: u64 = 2_000_000_000;
/// Interval between writes of files (ns).
const NAP_NS: u64 = 50_000_000;

/// A decision that is to be written: the bytes of its request that count, and its answer.
type Kept = Box<(Vec<u8>, WireAnswer)>;

#[derive(Debug)]
struct Shared {
    decisions: ArrayQueue<Kept>,
    /// Buffers are returned for reuse, so that keeping a decision allocates nothing, unless its
    /// request is larger than those before.
    empty: ArrayQueue<Kept>,
    health: ArrayQueue<Health>,
    lost: AtomicU64,
    stop: AtomicBool,
}

/// The service's end of the queue.
#[derive(Debug)]
pub(crate) struct Housekeeping {
    shared: Arc<Shared>,
    keeps_decisions: bool,
    thread: Option<JoinHandle<()>>,
}

impl Housekeeping {
    /// Starts the thread.
    pub(crate) fn start(
        deployment: &Deployment,
        signer: Option<&DecisionSigner>,
        housekeeper: Housekeeper,
        program: PathBuf,
    ) -> Result<Self, ServiceError> {
        let open = |kept: &Decisions| {
            let folder = kept.folder.display().to_string();
            let book = Book::open(kept, signer.cloned());
            book.map_err(|source| ServiceError::Files { folder, source })
        };
        let book = deployment.decisions.as_ref().map(open).transpose()?;
        let keeps_decisions = book.is_some();
        let shared = Arc::new(Shared {
            decisions: ArrayQueue::new(WAITING),
            empty: ArrayQueue::new(WAITING),
            health: ArrayQueue::new(1),
            lost: AtomicU64::new(0),
            stop: AtomicBool::new(false),
        });
        if keeps_decisions {
            for _ in 0..WAITING {
                let bytes = Vec::with_capacity(Ask::BYTES_MIN);
                let empty = (bytes, bytemuck::Zeroable::zeroed());
                let _full = shared.empty.push(Box::new(empty));
            }
        }
        let (theirs, deployment) = (shared.clone(), deployment.clone());
        let thread =
            std::thread::Builder::new().name("trolley-house".to_owned()).spawn(move || {
                let cleaning = Cleaning { program, housekeeper, child: None, begun_ns: 0 };
                housekeeping(&theirs, &deployment, book, cleaning);
            });
        let thread = thread.map_err(ServiceError::Thread)?;
        Ok(Self { shared, keeps_decisions, thread: Some(thread) })
    }

    /// Queues a decision for writing, if decisions are kept.
    pub(crate) fn record(&self, ask: &Ask, answer: &WireAnswer) {
        if !self.keeps_decisions {
            return;
        }
        let Some(mut entry) = self.shared.empty.pop() else {
            self.shared.lost.fetch_add(1, Ordering::Relaxed);
            return;
        };
        entry.0.clear();
        entry.0.extend_from_slice(ask.used());
        entry.1 = *answer;
        let _never_full = self.shared.decisions.push(entry);
    }

    /// Hands over the health of the service.
    pub(crate) fn tell(&self, health: &Health) {
        self.shared.health.force_push(*health);
    }
}

impl Drop for Housekeeping {
    /// Writes what is queued, then stops.
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _panicked = thread.join();
        }
    }
}

fn housekeeping(
    shared: &Shared,
    deployment: &Deployment,
    mut book: Option<Book>,
    mut cleaning: Cleaning,
) {
    let (mut written_ns, mut said) = (0, 0);
    let every_ns = deployment.metrics.as_ref().map_or(0, |m| m.every_s * 1_000_000_000);
    loop {
        let is_last = shared.stop.load(Ordering::Acquire);
        // No more than the queue holds: however fast decisions come, the rest is done as well.
        for _ in 0..WAITING {
            let Some(entry) = shared.decisions.pop() else { break };
            if let Some(open) = &mut book
                && let Err(error) = open.add(&entry.0, &entry.1)
            {
                tracing::error!(%error, "decisions cannot be written; no more are kept");
                book = None;
            }
            let _never_full = shared.empty.push(entry);
        }
        if let Some(open) = &mut book
            && let Err(error) = open.mark(is_last)
        {
            tracing::error!(%error, "the head of the decisions cannot be written");
        }
        let lost = shared.lost.load(Ordering::Relaxed);
        if lost > said {
            tracing::warn!(lost, "decisions were not kept: the disk is too slow");
            said = lost;
        }
        let now_ns = clock::now_ns();
        if !is_last {
            cleaning.turn(now_ns);
        }
        if let Some(settings) = &deployment.metrics
            && (now_ns - written_ns > every_ns || is_last)
            && let Some(health) = shared.health.pop()
        {
            written_ns = now_ns;
            let text = metrics::text(&health, &deployment.instance);
            if let Err(error) = output::publish(&settings.file, text.as_bytes()) {
                tracing::warn!(error = diagnostic::chain(&error), "metrics cannot be written");
            }
        }
        if is_last {
            return;
        }
        runtime::clock::nap_ns(NAP_NS);
    }
}

/// Cleaning up after dead clients, in a child: it opens memory that they wrote, and may fail or
/// hang on it.
struct Cleaning {
    program: PathBuf,
    housekeeper: Housekeeper,
    child: Option<Child>,
    /// When the last child was started, or looked for (ns).
    begun_ns: u64,
}

impl Cleaning {
    /// Starts a child if a client has died, and ends one that takes too long. Does not wait.
    fn turn(&mut self, now_ns: u64) {
        let age_ns = now_ns - self.begun_ns;
        if let Some(child) = &mut self.child {
            match child.try_wait() {
                Ok(None) if age_ns < CLEAN_LIMIT_NS => {}
                Ok(None) => {
                    tracing::warn!("cleaning up after dead clients takes too long; trying again");
                    self.child = None;
                }
                Ok(Some(_)) | Err(_) => self.child = None,
            }
            return;
        }
        if age_ns < CLEAN_NS {
            return;
        }
        self.begun_ns = now_ns;
        let Some(place) = self.housekeeper.needs_cleaning() else { return };
        let args = ["worker".to_owned(), worker_word(place)];
        let spawned = spawn(Spawn { program: &self.program, args: &args, fds: &[], core: None });
        match spawned {
            Ok(child) => self.child = Some(child),
            Err(error) => tracing::warn!(%error, "cannot clean up after dead clients"),
        }
    }
}

fn worker_word(place: &Path) -> String {
    protocol::launch::clean_word(&place.display().to_string())
}

#[cfg(test)]
mod tests {
    //! However much there is to write, the rest is done as well.
    use super::*;
    use transport::{Address, Server};

    const DEPLOYMENT: &str = include_str!("../config/deployments/minimal.toml");
    /// In which the metrics must be written (ns).
    const PATIENCE_NS: u64 = 10_000_000_000;

    /// Decisions come faster than a disk takes them, from before the health is told until the
    /// metrics are there.
    #[test]
    fn decisions_without_end_do_not_keep_the_metrics_from_being_written() {
        let folder = tempfile::Builder::new().prefix("h").tempdir_in("/dev/shm").unwrap();
        let address = Address::new(Some(folder.path()), "house").unwrap();
        let server = Server::open(&address).unwrap();
        let metrics = folder.path().join("metrics.prom");
        let kept = format!(
            "[metrics]\nfile = {metrics:?}\n[decisions]\nfolder = {:?}\nper_file = 100\n\
             files = 2\n[engine]",
            folder.path().join("decisions")
        );
        let text = DEPLOYMENT.replacen("[engine]", &kept, 1);
        let deployment = Deployment::parse("minimal.toml", &text).unwrap();
        let program = PathBuf::from("/bin/true");
        let house = Housekeeping::start(&deployment, None, server.housekeeper(), program).unwrap();
        let (ask, answer) = (Ask::new(1.0), bytemuck::Zeroable::zeroed());
        let health: Health = bytemuck::Zeroable::zeroed();
        let begun_ns = clock::now_ns();
        let mut is_told = false;
        let mut was_full = false;
        while !metrics.exists() && clock::now_ns() - begun_ns < PATIENCE_NS {
            house.record(&ask, &answer);
            was_full |= house.shared.lost.load(Ordering::Relaxed) > 0;
            if was_full && !is_told {
                house.tell(&health);
                is_told = true;
            }
        }
        let took_ns = clock::now_ns() - begun_ns;
        drop(house);
        assert!(was_full, "decisions came faster than they were written");
        assert!(took_ns < PATIENCE_NS, "nothing was written for {took_ns} ns");
    }
}
