//! Supervision of workers: greetings, heartbeats, ends, and what an ended worker leaves.
//!
//! Within a request a worker's last results are taken before its jobs go to the others. Whether its
//! core gets a successor is decided elsewhere.

use super::worker_handle::WorkerHandle;
use super::{GREETING_NS, Observation, WorkerPool, WorkerPoolError};
use crate::work::TaskSource;
use dispatch::{Effect, Event, Progress};
use protocol::{Incarnation, JobId, MessageKind};
use runtime::clock;
use transport::UseError;

impl WorkerPool {
    /// Waits until every worker has greeted or ended; one greeting is enough.
    pub(super) fn await_greetings(&mut self) -> Result<(), WorkerPoolError> {
        let mut failed = None;
        loop {
            let now = clock::now_ns();
            for number in 0..self.workers.len() {
                let worker = &mut self.workers[number];
                if let Ok(Some(Ok(head))) = worker.take(&self.status, &mut self.scratch) {
                    worker.has_greeted |= head.kind == MessageKind::Hello as u8;
                }
                if !worker.is_starting() {
                    continue;
                }
                let id = number as u8;
                if let Some(exit) = worker.exit()? {
                    failed.get_or_insert(WorkerPoolError::ExitedAtStart { worker: id, exit });
                    tracing::warn!(worker = id, %exit, "a worker ended at start-up");
                    self.miss(number)?;
                    self.workers[number].report.lost = Some(format!("{exit} at start-up"));
                } else if now > worker.handshake_deadline_ns {
                    let seconds = GREETING_NS / 1_000_000_000;
                    failed.get_or_insert(WorkerPoolError::HandshakeTimeout { worker: id, seconds });
                    worker.kill("did not greet");
                    self.miss(number)?;
                }
            }
            if !self.workers.iter().any(WorkerHandle::is_starting) {
                break;
            }
            self.sleep(1_000_000)?;
        }
        match failed {
            Some(error) if !self.workers.iter().any(WorkerHandle::is_ready) => Err(error),
            _ => Ok(()),
        }
    }

    /// Checks every worker's heartbeat, and kills workers that make no progress.
    pub(super) fn look_after<W: TaskSource>(
        &mut self,
        now: u64,
        work: &mut W,
        effects: &mut Vec<Effect>,
        mut progress: Progress,
    ) -> Result<Progress, WorkerPoolError> {
        for number in 0..self.workers.len() {
            let worker = &mut self.workers[number];
            if worker.is_starting() && now > worker.handshake_deadline_ns {
                worker.kill("did not greet");
                progress = self.reap(number, work, effects)?;
                continue;
            }
            if self.kill_if_still(number, now) {
                progress = self.reap(number, work, effects)?;
            }
        }
        Ok(progress)
    }

    /// Checks a heartbeat, and kills the worker if it makes no progress while it has work.
    fn kill_if_still(&mut self, number: usize, now: u64) -> bool {
        let worker = &mut self.workers[number];
        worker.restore(&self.status, self.cancelled);
        if let Some(why) = worker.impossible(&self.status) {
            tracing::warn!(worker = number, why, "killing a worker whose status is impossible");
            worker.kill(why);
            self.observe(self.workers[number].who, Observation::Impossible);
            return true;
        }
        let Some(verdict) = worker.pulse(&self.status, now, &self.options.patience) else {
            return false;
        };
        tracing::warn!(worker = number, ?verdict, "killing a worker that makes no progress");
        worker.kill(verdict.name());
        self.observe(self.workers[number].who, Observation::StoodStill(verdict));
        true
    }

    /// Reaps a worker that has ended: takes its last results, then gives its jobs to the others.
    pub(super) fn reap<W: TaskSource>(
        &mut self,
        number: usize,
        work: &mut W,
        effects: &mut Vec<Effect>,
    ) -> Result<Progress, WorkerPoolError> {
        if !self.workers[number].is_alive() || self.workers[number].wait_end()?.is_none() {
            return Ok(self.step(Event::Poll, work, effects));
        }
        while self.take_one(number, work, effects).is_some() {}
        let (who, started) = self.workers[number].close(&self.status, self.request);
        self.detach(number);
        let lost = self.workers[number].report.lost.clone().unwrap_or_default();
        tracing::warn!(worker = number, %lost, "lost a worker; its jobs go to the others");
        Ok(self.step(Event::Lost { who, started }, work, effects))
    }

    /// Reaps a worker whose job channel broke: returns which it was, and what it had started. A
    /// worker that was reaped before is not counted again.
    pub(super) fn give_up(
        &mut self,
        number: usize,
        error: UseError,
    ) -> (Incarnation, Option<(JobId, u8)>) {
        let worker = &mut self.workers[number];
        let was_alive = worker.is_alive();
        if was_alive {
            worker.kill(&format!("its job channel broke ({error})"));
        }
        let gone = worker.close(&self.status, self.request);
        if was_alive {
            self.detach(number);
        }
        gone
    }

    /// Reaps workers that have ended since the last request, or make no progress on what it left
    /// them.
    pub(super) fn notice_the_dead(&mut self) -> Result<(), WorkerPoolError> {
        self.sleep(0)?;
        let now = clock::now_ns();
        self.ended.clear();
        for number in 0..self.workers.len() {
            let worker = &mut self.workers[number];
            let has_ended = worker.is_alive() && worker.exit()?.is_some();
            if has_ended || self.kill_if_still(number, now) {
                self.miss(number)?;
            }
        }
        Ok(())
    }

    /// Reaps a worker that has ended, or was killed, while no request was open.
    pub(super) fn miss(&mut self, number: usize) -> Result<(), WorkerPoolError> {
        let worker = &mut self.workers[number];
        let _exit = worker.wait_end()?;
        let (who, _started) = worker.close(&self.status, self.request);
        self.dispatcher.dismiss(who);
        self.observe(who, Observation::Ended);
        self.detach(number);
        Ok(())
    }

    /// Stops watching a worker, and counts its death.
    pub(super) fn detach(&mut self, number: usize) {
        self.poller.remove_process(number as u32);
        self.poller.remove_event(number as u32);
        self.restarts.note(number as u8, clock::now_ns());
    }
}
