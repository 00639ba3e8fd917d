//! What workers do in their turn, and the faults that strike them then.
//!
//! An [`Actor`](super::actor::Actor) is what a worker holds; the flight of its messages and the
//! notice of its end are events of the world.

use super::actor::{Ill, Notes};
use super::{FLIGHT_NS, Happening, NOTICE_NS, POISON_MAX, World};
use crate::faults::kind::SimulatedFault;
use protocol::Incarnation;

impl World<'_> {
    /// What a worker does next: the current job, the next batch, or nothing.
    pub(super) fn turn(&mut self, who: Incarnation) {
        let now_ns = self.now_ns;
        let mut notes = Notes::default();
        let Some(actor) = self.actor(who) else { return };
        let Some((request, job, attempt, name, work)) = actor.next_job(now_ns, &mut notes) else {
            self.tell_answered(who, &notes);
            return;
        };
        self.tell_answered(who, &notes);
        let whole = self.key.at(40).at(request.0).at(name);
        let place = self.place(who).at(3).at(request.0).at(job.0.into()).at(attempt.into());
        let mut time_ns = work.time_ns;
        let mut ill = Ill::None;
        if self.strikes(SimulatedFault::Poison, whole) {
            let deaths = self.poisoned.entry(name).or_default();
            *deaths += u32::from(request == self.number);
            let overtaken = self.tally.struck[SimulatedFault::DelayBatch as usize];
            if u64::from(*deaths) > POISON_MAX + overtaken {
                self.wrong = Some(format!("job {name} has taken {deaths} workers down"));
            }
            self.after(time_ns / 2, Happening::Dies(who));
        } else if self.strikes(SimulatedFault::Crash, place) {
            self.after(place.at(8).below(time_ns), Happening::Dies(who));
        } else if self.strikes(SimulatedFault::Hang, place) {
            ill = Ill::Hung;
        } else if self.strikes(SimulatedFault::Stop, place) {
            ill = Ill::Stopped;
        } else if self.strikes(SimulatedFault::Slow, place) {
            ill = Ill::Slow;
            time_ns *= 10;
        } else if self.strikes(SimulatedFault::Starve, place) {
            ill = Ill::Starved;
            time_ns += 50_000_000 + place.at(9).below(1_450_000_000);
        }
        let Some(actor) = self.actor(who) else { return };
        let turn = actor.start(ill, now_ns);
        if !matches!(ill, Ill::Hung | Ill::Stopped) {
            self.after(time_ns, Happening::Turn { who, turn });
        }
    }

    /// Ends the current job: its result is sent.
    pub(super) fn finish_job(&mut self, who: Incarnation) {
        let now_ns = self.now_ns;
        let Some(done) = self.actor(who).and_then(|actor| actor.finish(now_ns)) else { return };
        let (request, job, attempt, work) = done;
        let place = self.place(who).at(4).at(request.0).at(job.0.into()).at(attempt.into());
        if self.strikes(SimulatedFault::Nack, place) {
            self.after(FLIGHT_NS, Happening::Nack { from: who, request, job, attempt });
            return;
        }
        for number in 0..work.parts {
            let place = place.at(10 + u64::from(number));
            let last = number + 1 == work.parts;
            let part = (number, last, work.part(number));
            let message = || Happening::Part { from: who, request, job, attempt, part };
            if self.strikes(SimulatedFault::LoseResult, place) {
                continue;
            }
            if self.strikes(SimulatedFault::GarbleResult, place) {
                self.after(FLIGHT_NS, Happening::Garbled(who));
                continue;
            }
            let mut flight_ns = FLIGHT_NS;
            if self.strikes(SimulatedFault::DelayResult, place) {
                flight_ns += place.at(4).below(2_000_000);
            }
            if self.strikes(SimulatedFault::RepeatResult, place) {
                self.after(flight_ns + place.at(5).below(900_000), message());
            }
            if self.strikes(SimulatedFault::Zombie, place) {
                // That it started the job is the last that is known of it.
                if let Some(actor) = self.actor(who) {
                    actor.started = Some((request, job, attempt));
                }
                flight_ns += NOTICE_NS * 2 + place.at(6).below(40_000_000);
                self.after(flight_ns, message());
                self.die(who);
                return;
            }
            self.after(flight_ns, message());
        }
        if self.strikes(SimulatedFault::CrashIdle, place) {
            self.after(FLIGHT_NS, Happening::Dies(who));
        }
    }

    /// Reports the batches that a worker has answered.
    fn tell_answered(&mut self, who: Incarnation, notes: &Notes) {
        if let Some(batches) = notes.answered {
            self.after(FLIGHT_NS, Happening::Answered { who, batches });
        }
    }

    /// A worker's process ends; that is noticed a little later.
    pub(super) fn die(&mut self, who: Incarnation) {
        let Some(actor) = self.actor(who) else { return };
        actor.is_alive = false;
        actor.queue.clear();
        self.tally.deaths += 1;
        self.say(|| format!("{who:?} dies"));
        let jitter_ns = self.place(who).at(6).below(NOTICE_NS);
        self.after(NOTICE_NS / 2 + jitter_ns, Happening::Died(who));
    }
}
