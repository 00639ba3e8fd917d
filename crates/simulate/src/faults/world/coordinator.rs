//! The coordinator of the simulated world: its loop, as it is in `coordinator`, around the same
//! dispatcher.
//!
//! Faults of batches strike here, as they leave. A worker that the coordinator kills must have had
//! a fault: this is checked against the worker's true state, which decides nothing.

use super::actor::{Actor, Ill, Mail};
use super::{FLIGHT_NS, FOR_EVER_NS, Happening, LOOK_NS, START_NS, World};
use crate::faults::kind::SimulatedFault;
use crate::faults::work::{Answer, Part, Request};
use dispatch::{Effect, Event, Leave, Liveness, Progress};
use protocol::{Incarnation, JobId, RequestId};

impl World<'_> {
    /// Answers one request, and judges the answer.
    pub(super) fn answer(&mut self, number: RequestId) -> Result<(), String> {
        let key = self.key.at(20).at(number.0);
        self.number = number;
        self.request = Request::random(key);
        self.poisoned.clear();
        let begun_ns = self.now_ns;
        self.say(|| format!("request {} begins", number.0));
        self.dispatcher.begin(number);
        let deadline_ns = if self.strikes(SimulatedFault::Deadline, key) {
            Some(100_000 + key.at(9).below(5_000_000))
        } else {
            key.at(10).once_in(2).then_some(30_000_000_000)
        };
        if let Some(after_ns) = deadline_ns {
            self.after(after_ns, Happening::Deadline(number));
        }
        for actor in self.actors.iter().filter(|actor| actor.is_ready && !actor.is_reaped) {
            self.dispatcher.admit(actor.who);
        }
        self.step(Event::Poll);
        while self.is_working() && self.wrong.is_none() {
            let next_ns = self.events.first_key_value().map(|(at, _)| at.0);
            match (self.dispatcher.due_ns(), next_ns) {
                (Some(due_ns), next_ns) if next_ns.is_none_or(|next_ns| due_ns <= next_ns) => {
                    self.now_ns = self.now_ns.max(due_ns);
                    self.step(Event::Poll);
                }
                (_, Some(_)) => self.next(),
                (_, None) => return Err("nothing will ever happen again".to_owned()),
            }
            if self.now_ns - begun_ns > FOR_EVER_NS {
                return Err("still no answer after two minutes".to_owned());
            }
        }
        let took_ns = self.now_ns - begun_ns;
        if deadline_ns.is_some_and(|most_ns| took_ns > most_ns + LOOK_NS) {
            return Err(format!("answered after {took_ns} ns, by {deadline_ns:?} at the latest"));
        }
        let mut counts = self.dispatcher.counts();
        if self.progress == Progress::Stranded {
            // No worker is left or coming: what is open stays unknown.
            self.step(Event::Expired);
            counts = self.dispatcher.counts();
        }
        let answer = self.request.judge(&counts)?;
        self.say(|| format!("request {} is {answer:?}", number.0));
        let tally = &mut self.tally;
        tally.requests += 1;
        tally.jobs += counts.jobs;
        tally.reissued += counts.reissued;
        tally.abandoned += counts.abandoned;
        tally.fenced += counts.fence.sum();
        match answer {
            Answer::Complete => tally.complete += 1,
            Answer::Degraded => tally.degraded += 1,
            Answer::Refused => tally.refused += 1,
        }
        Ok(())
    }

    fn is_working(&self) -> bool {
        let is_starting = |actor: &Actor| !actor.is_reaped && !actor.is_ready;
        match self.progress {
            Progress::Working => true,
            Progress::Stranded => self.actors.iter().any(is_starting),
            Progress::Finished | Progress::Thrashed => false,
        }
    }

    /// One event for the dispatcher, and everything that follows.
    pub(super) fn step(&mut self, event: Event<Part>) {
        let mut effects = Vec::new();
        self.progress = self.dispatcher.step(self.now_ns, event, &mut self.request, &mut effects);
        let mut refused = 0_u32;
        while !effects.is_empty() {
            let event = match effects.remove(0) {
                Effect::Kill { who, why } => {
                    self.say(|| format!("kill {who:?}: {why}"));
                    if self.actor(who).is_some() {
                        self.tally.killed += 1;
                        self.die(who);
                    }
                    continue;
                }
                Effect::Send { to, batch, .. } if refused >> to.worker & 1 == 1 => {
                    Some(Event::Unsent { to, batch })
                }
                Effect::Send { to, batch, jobs, .. } => self.send(to, batch, &jobs),
            };
            let Some(event) = event else { continue };
            if let Event::Unsent { to, .. } = event {
                refused |= 1 << to.worker;
            }
            self.progress =
                self.dispatcher.step(self.now_ns, event, &mut self.request, &mut effects);
        }
    }

    /// Sends a batch; returns the event for the dispatcher if that fails.
    fn send(&mut self, to: Incarnation, batch: u32, jobs: &[(JobId, u8)]) -> Option<Event<Part>> {
        if self.actors[usize::from(to.worker)].who != to
            || self.actors[usize::from(to.worker)].is_reaped
        {
            return Some(Event::Lost { who: to, started: None });
        }
        self.say(|| format!("batch {batch} to {}.{}: {jobs:?}", to.worker, to.inc));
        let place = self.place(to).at(2).at(batch.into());
        if self.strikes(SimulatedFault::Full, place) {
            return Some(Event::Unsent { to, batch });
        }
        let table = |(job, attempt): &(JobId, u8)| {
            let spec = self.dispatcher.spec(*job)?;
            Some((*job, *attempt, Request::name_of(spec), *self.request.job(Some(spec))?))
        };
        let jobs = jobs.iter().filter_map(table).collect();
        let mut mail = Mail { number: batch, request: self.number, jobs, is_garbled: false };
        if self.strikes(SimulatedFault::LoseBatch, place) {
            self.actors[usize::from(to.worker)].has_lost_mail = true;
            return None;
        }
        mail.is_garbled = self.strikes(SimulatedFault::GarbleBatch, place);
        let mut flight_ns = FLIGHT_NS;
        if self.strikes(SimulatedFault::DelayBatch, place) {
            flight_ns += place.at(4).below(3_000_000);
            // Out of order and then garbled, a batch may go unnoticed until its worker is silent.
            self.actors[usize::from(to.worker)].has_lost_mail = true;
        }
        if self.strikes(SimulatedFault::RepeatBatch, place) {
            self.after(flight_ns + place.at(5).below(400_000), Happening::Batch(to, mail.clone()));
        }
        self.after(flight_ns, Happening::Batch(to, mail));
        None
    }

    /// Judges every heartbeat, as the coordinator does.
    pub(super) fn look(&mut self) {
        for number in 0..self.actors.len() {
            let busy = self.dispatcher.is_busy(number as u8);
            let (now_ns, patience) = (self.now_ns, self.patience);
            let actor = &mut self.actors[number];
            if !actor.is_alive || !actor.is_ready {
                continue;
            }
            let verdict = actor.look(busy, now_ns, &patience);
            if verdict == Liveness::Alive {
                continue;
            }
            let (who, ill, lost) = (actor.who, actor.ill, actor.has_lost_mail);
            self.say(|| format!("{who:?} is {verdict:?}"));
            if !lost && !matches!(ill, Ill::Hung | Ill::Stopped) {
                self.wrong = Some(format!("{who:?} is well ({ill:?}), and was found {verdict:?}"));
            }
            self.tally.killed += 1;
            self.die(who);
        }
    }

    pub(super) fn reap(&mut self, who: Incarnation) {
        self.actors[usize::from(who.worker)].is_reaped = true;
        self.restarts.note(who.worker, self.now_ns);
    }

    /// Starts successors between requests.
    pub(super) fn mend(&mut self) {
        for number in 0..self.actors.len() {
            let actor = &self.actors[number];
            let who = actor.who;
            if actor.is_alive {
                continue;
            }
            if !actor.is_reaped {
                self.reap(who);
                self.dispatcher.dismiss(who);
            }
            if self.restarts.leave(who.worker, self.now_ns) != Leave::Granted {
                continue;
            }
            let next = Incarnation { inc: who.inc + 1, ..who };
            self.actors[number] = Actor::new(next);
            let place = self.place(next);
            if self.strikes(SimulatedFault::ExitedAtStart, place) {
                self.after(START_NS / 2, Happening::Dies(next));
            } else {
                self.after(START_NS / 2 + place.at(7).below(START_NS), Happening::Hello(next));
            }
        }
    }
}
