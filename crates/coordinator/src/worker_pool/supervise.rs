//! Supervision of workers: greetings, heartbeats, ends, and what an ended worker leaves.
//!
//! Within a request a worker's last results are taken before its jobs go to the others. Whether its
//! core gets a successor is decided elsewhere.

use super::worker_handle::WorkerHandle;
use super::{Observation, WorkerPool, WorkerPoolError};
use crate::work::TaskSource;
use dispatch::{Effect, Event, Liveness, Progress};
use protocol::{Incarnation, JobId, MessageKind, launch};
use runtime::{Exit, SealedMemory, clock};
use transport::UseError;

impl WorkerPool {
    /// Waits until every worker has greeted or ended; one greeting is enough. With a store, a
    /// worker that is lost on the way is replaced, once.
    pub(super) fn await_greetings(
        &mut self,
        store: Option<&SealedMemory>,
    ) -> Result<(), WorkerPoolError> {
        let mut failed = None;
        let begun_ns = clock::now_ns();
        let mut replaced = 0_u32;
        while self.workers.iter().any(WorkerHandle::is_starting) {
            for number in 0..self.workers.len() {
                let Some((error, may_help)) = self.lost_at_start(number, begun_ns)? else {
                    continue;
                };
                tracing::warn!(worker = number, %error, "lost a worker at start-up");
                failed.get_or_insert(error);
                if let (Some(store), 0, true) = (store, replaced >> number & 1, may_help) {
                    replaced |= 1 << number;
                    let who = self.workers[number].who;
                    let successor = Incarnation { inc: who.inc.wrapping_add(1), ..who };
                    self.workers[number] = self.spawn(successor, store)?;
                }
            }
            self.sleep(1_000_000)?;
        }
        match failed {
            Some(error) if !self.workers.iter().any(WorkerHandle::is_ready) => Err(error),
            _ => Ok(()),
        }
    }

    /// Takes a worker's greeting; if it is lost instead, why, and whether another might fare
    /// better.
    fn lost_at_start(
        &mut self,
        number: usize,
        begun_ns: u64,
    ) -> Result<Option<(WorkerPoolError, bool)>, WorkerPoolError> {
        let id = number as u8;
        let worker = &mut self.workers[number];
        if let Ok(Some(Ok(head))) = worker.take(&self.status, &mut self.scratch) {
            worker.has_greeted |= head.kind == MessageKind::Hello as u8;
        }
        if !worker.is_starting() {
            return Ok(None);
        }
        if let Some(exit) = worker.exit()? {
            let error = worker.exec_error();
            self.miss(number)?;
            self.workers[number].report.lost = Some(format!("{exit} at start-up"));
            let may_help = matches!(exit, Exit::Signal(_));
            let exited = WorkerPoolError::ExitedAtStart { worker: id, exit };
            return Ok(Some((error.map_or(exited, WorkerPoolError::System), may_help)));
        }
        let now = clock::now_ns();
        // A successor has what is left of the time of both.
        let is_late = now.saturating_sub(begun_ns) >= self.options.start_patience.longest_ns;
        let verdict = worker.start_pulse(now, &self.options.start_patience);
        let Some(verdict) = verdict.or(is_late.then_some(Liveness::Hung)) else { return Ok(None) };
        worker.kill(&format!("did not greet: {}", verdict.name()));
        self.miss(number)?;
        let ms = now.saturating_sub(begun_ns) / 1_000_000;
        let how = verdict.name();
        Ok(Some((WorkerPoolError::HandshakeTimeout { worker: id, how, ms }, !is_late)))
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
            if worker.is_starting()
                && let Some(verdict) = worker.start_pulse(now, &self.options.start_patience)
            {
                worker.kill(&format!("did not greet: {}", verdict.name()));
                self.observe(self.workers[number].who, Observation::StoodStill(verdict));
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
        // It is dead: what its channel holds is all that there is.
        let mut left = 0..launch::RESULTS;
        while left.next().is_some() && self.take_one(number, work, effects).is_some() {}
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
            let start = match worker.is_starting() && !has_ended {
                true => worker.start_pulse(now, &self.options.start_patience),
                false => None,
            };
            if let Some(verdict) = start {
                worker.kill(&format!("did not greet: {}", verdict.name()));
                self.observe(self.workers[number].who, Observation::StoodStill(verdict));
            }
            if has_ended || start.is_some() || self.kill_if_still(number, now) {
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
        self.leave_core_of(number);
        self.restarts.note(number as u8, clock::now_ns());
    }
}
