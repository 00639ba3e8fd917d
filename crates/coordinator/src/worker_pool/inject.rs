//! Commanded faults, for fault injection only: of workers, and of the channels to them.
//!
//! All of this is behind the feature `faults`. No answer may depend on it: commanded faults are
//! detected like any others.

use super::WorkerPool;
use core::sync::atomic::Ordering;
use protocol::{FaultCommand, Head};
use runtime::{Child, OsError, Spawn, process};
use transport::{OpenMessage, UseError};

/// What is done to a batch on its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Corruption {
    /// This bit, modulo the batch's length, is flipped after sealing.
    Garbled(u32),
    /// The batch is refused, as if the queue were full.
    Refused,
}

/// Sends a batch, corrupted if so commanded.
pub(super) fn send(
    corruption: Option<Corruption>,
    message: OpenMessage<'_>,
    head: Head,
    used: usize,
) -> Result<(), UseError> {
    match corruption {
        None => message.send(head, used),
        Some(Corruption::Refused) => Err(UseError::Full),
        Some(Corruption::Garbled(bit)) => message.send_corrupted(head, used, |head, words| {
            let bit = bit as usize % (words.len().max(1) * 64);
            match words.get_mut(bit / 64) {
                Some(word) => *word ^= 1 << (bit % 64),
                None => head.hits ^= 1,
            }
        }),
    }
}

/// How the next worker is started: some stop themselves before exec.
pub(super) fn how_to_spawn(stopped: &mut u32) -> fn(Spawn<'_>) -> Result<Child, OsError> {
    let stops = *stopped > 0;
    *stopped = stopped.saturating_sub(1);
    if stops { process::spawn_stopped } else { process::spawn }
}

impl WorkerPool {
    /// Lets this many of the next workers stop themselves before exec.
    pub fn stop_next_starts(&mut self, count: u32) {
        self.stopped_starts = count;
    }

    /// Commands a fault of a worker, which must have been started with `obeys`.
    pub fn command_fault(&self, worker: u8, order: Option<FaultCommand>) {
        let line = self.status.page().coordinator.get(usize::from(worker));
        if let Some(line) = line {
            line.fault_command.store(order.map_or(0, FaultCommand::to_word), Ordering::SeqCst);
        }
    }

    /// When a worker last obeyed a command (ns, monotonic); 0: never.
    #[must_use]
    pub fn obeyed_ns(&self, worker: u8) -> u64 {
        let line = self.status.page().workers.get(usize::from(worker));
        line.map_or(0, |line| line.obeyed_ns.load(Ordering::SeqCst))
    }

    /// Flips one bit of the two lines of a worker on the status page; which one, `bit` says.
    pub fn flip_status(&self, worker: u8, bit: u64) {
        self.status.page().flip(usize::from(worker), bit);
    }

    /// Corrupts the next batch to a worker: for fault injection.
    pub fn corrupt_next(&mut self, worker: u8, how: Corruption) {
        if let Some(worker) = self.workers.get_mut(usize::from(worker)) {
            worker.corruption = Some(how);
        }
    }
}
