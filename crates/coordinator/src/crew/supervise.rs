//! Who greets, who stands still, who has ended; and what is left of those.
//!
//! Within a request a worker's last results are taken before its jobs go to the others. Whether its
//! core gets a successor is not decided here.

use super::station::Station;
use super::{Crew, CrewError, GREETING_NS, Sight};
use crate::work::Errands;
use dispatch::{Effect, Event, Progress};
use protocol::{Incarnation, JobId, Kind};
use runtime::clock;
use transport::UseError;

impl Crew {
    /// Waits until every worker has greeted or is gone; one that greeted is enough.
    pub(super) fn await_greetings(&mut self) -> Result<(), CrewError> {
        let mut failed = None;
        loop {
            let now = clock::now_ns();
            for number in 0..self.stations.len() {
                let station = &mut self.stations[number];
                if let Ok(Some(Ok(head))) = station.take(&self.status, &mut self.scratch) {
                    station.has_greeted |= head.kind == Kind::Hello as u8;
                }
                if !station.is_starting() {
                    continue;
                }
                let worker = number as u8;
                if let Some(exit) = station.exit()? {
                    failed.get_or_insert(CrewError::StillBorn { worker, exit });
                    tracing::warn!(worker, %exit, "a worker ended at start-up");
                    self.miss(number)?;
                    self.stations[number].report.lost = Some(format!("{exit} at start-up"));
                } else if now > station.mute_ns {
                    let seconds = GREETING_NS / 1_000_000_000;
                    failed.get_or_insert(CrewError::Mute { worker, seconds });
                    station.kill("did not greet");
                    self.miss(number)?;
                }
            }
            if !self.stations.iter().any(Station::is_starting) {
                break;
            }
            self.sleep(1_000_000)?;
        }
        match failed {
            Some(error) if !self.stations.iter().any(Station::is_ready) => Err(error),
            _ => Ok(()),
        }
    }

    /// Looks at every worker's pulse, and kills who stands still.
    pub(super) fn look_after<W: Errands>(
        &mut self,
        now: u64,
        work: &mut W,
        effects: &mut Vec<Effect>,
        mut progress: Progress,
    ) -> Result<Progress, CrewError> {
        for number in 0..self.stations.len() {
            let station = &mut self.stations[number];
            if station.is_starting() && now > station.mute_ns {
                station.kill("did not greet");
                progress = self.bury(number, work, effects)?;
                continue;
            }
            if self.kill_if_still(number, now) {
                progress = self.bury(number, work, effects)?;
            }
        }
        Ok(progress)
    }

    /// Feels a pulse, and kills who stands still while it has something to do.
    fn kill_if_still(&mut self, number: usize, now: u64) -> bool {
        let station = &mut self.stations[number];
        let Some(verdict) = station.pulse(&self.status, now, &self.options.patience) else {
            return false;
        };
        tracing::warn!(worker = number, ?verdict, "killing a worker that stands still");
        station.kill(verdict.name());
        self.see(self.stations[number].who, Sight::StoodStill(verdict));
        true
    }

    /// Takes leave of a worker that has ended: its last results first, then its jobs to the others.
    pub(super) fn bury<W: Errands>(
        &mut self,
        number: usize,
        work: &mut W,
        effects: &mut Vec<Effect>,
    ) -> Result<Progress, CrewError> {
        if !self.stations[number].is_alive() || self.stations[number].wait_end()?.is_none() {
            return Ok(self.step(Event::Poll, work, effects));
        }
        while self.take_one(number, work, effects).is_some() {}
        let (who, started) = self.stations[number].bury(&self.status, self.request);
        self.lay_to_rest(number);
        let lost = self.stations[number].report.lost.clone().unwrap_or_default();
        tracing::warn!(worker = number, %lost, "lost a worker; its jobs go to the others");
        Ok(self.step(Event::Lost { who, started }, work, effects))
    }

    /// Buries a worker whose job channel broke: says who it was, and what it had started. One that
    /// was buried before has not died twice.
    pub(super) fn give_up(
        &mut self,
        number: usize,
        error: UseError,
    ) -> (Incarnation, Option<(JobId, u8)>) {
        let station = &mut self.stations[number];
        let was_alive = station.is_alive();
        if was_alive {
            station.kill(&format!("its job channel broke ({error})"));
        }
        let gone = station.bury(&self.status, self.request);
        if was_alive {
            self.lay_to_rest(number);
        }
        gone
    }

    /// Buries those who have ended since the last request, or stand still at what it left them.
    pub(super) fn notice_the_dead(&mut self) -> Result<(), CrewError> {
        self.sleep(0)?;
        let now = clock::now_ns();
        self.ended.clear();
        for number in 0..self.stations.len() {
            let station = &mut self.stations[number];
            let has_ended = station.is_alive() && station.exit()?.is_some();
            if has_ended || self.kill_if_still(number, now) {
                self.miss(number)?;
            }
        }
        Ok(())
    }

    /// Buries a worker that has ended, or was killed, while no request was open.
    pub(super) fn miss(&mut self, number: usize) -> Result<(), CrewError> {
        let station = &mut self.stations[number];
        let _exit = station.wait_end()?;
        let (who, _started) = station.bury(&self.status, self.request);
        self.dispatcher.dismiss(who);
        self.see(who, Sight::Ended);
        self.lay_to_rest(number);
        Ok(())
    }

    /// Forgets what is watched of a worker, and counts its death.
    pub(super) fn lay_to_rest(&mut self, number: usize) {
        self.poller.remove_process(number as u32);
        self.poller.remove_event(number as u32);
        self.restarts.note(number as u8, clock::now_ns());
    }
}
