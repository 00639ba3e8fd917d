//! One worker of the simulated world: what it holds, what it does, how it looks from outside.

use crate::faults::work::SimulatedJob;
use dispatch::{Liveness, Patience, Pulse, Watch};
use protocol::{Incarnation, JobId, RequestId};
use std::collections::VecDeque;

/// A batch on its way.
#[derive(Clone)]
pub(super) struct Mail {
    pub(super) number: u32,
    pub(super) request: RequestId,
    /// Slot, attempt, name within the request, and what there is to do.
    pub(super) jobs: Vec<(JobId, u8, u64, SimulatedJob)>,
    pub(super) is_garbled: bool,
}

/// What is wrong with it in the current job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ill {
    None,
    Hung,
    Stopped,
    Slow,
    Starved,
}

/// What it reports after a turn.
#[derive(Default)]
pub(super) struct Notes {
    pub(super) answered: Option<u32>,
}

/// A job with its request, slot, attempt and name.
type HandedJob = (RequestId, JobId, u8, u64, SimulatedJob);

/// A process.
pub(super) struct Actor {
    pub(super) who: Incarnation,
    pub(super) is_alive: bool,
    /// It has greeted.
    pub(super) is_ready: bool,
    /// The coordinator knows that it is dead.
    pub(super) is_reaped: bool,
    pub(super) queue: VecDeque<Mail>,
    hand: Option<(Mail, usize)>,
    is_at_work: bool,
    begun_ns: u64,
    /// Tells its steps apart.
    pub(super) turn: u64,
    pub(super) ill: Ill,
    pub(super) has_lost_mail: bool,
    pub(super) started: Option<(RequestId, JobId, u8)>,
    answered: u32,
    beat: u64,
    cpu_ns: u64,
    watch: Watch,
}

impl Actor {
    pub(super) fn new(who: Incarnation) -> Self {
        Self {
            who,
            is_alive: true,
            is_ready: false,
            is_reaped: false,
            queue: VecDeque::new(),
            hand: None,
            is_at_work: false,
            begun_ns: 0,
            turn: 0,
            ill: Ill::None,
            has_lost_mail: false,
            started: None,
            answered: 0,
            beat: 0,
            cpu_ns: 0,
            watch: Watch::default(),
        }
    }

    /// The next job, unless there is a current one; notes what was answered on the way.
    pub(super) fn next_job(&mut self, now_ns: u64, notes: &mut Notes) -> Option<HandedJob> {
        if self.is_at_work {
            return None;
        }
        loop {
            if let Some((mail, at)) = &mut self.hand {
                if let Some((job, attempt, name, work)) = mail.jobs.get(*at).copied() {
                    *at += 1;
                    self.started = Some((mail.request, job, attempt));
                    self.beat += 1;
                    self.begun_ns = now_ns;
                    return Some((mail.request, job, attempt, name, work));
                }
                self.answered = self.answered.max(mail.number + 1);
                notes.answered = Some(self.answered);
                self.hand = None;
            }
            let mail = self.queue.pop_front()?;
            if mail.is_garbled {
                self.answered += 1;
                notes.answered = Some(self.answered);
            } else {
                self.hand = Some((mail, 0));
            }
        }
    }

    /// Begins the job; the number of the step that ends it.
    pub(super) fn start(&mut self, ill: Ill, now_ns: u64) -> u64 {
        self.is_at_work = true;
        self.ill = ill;
        self.begun_ns = now_ns;
        self.turn += 1;
        self.turn
    }

    /// Ends the current job.
    pub(super) fn finish(&mut self, now_ns: u64) -> Option<(RequestId, JobId, u8, SimulatedJob)> {
        let (mail, at) = self.hand.as_ref().filter(|_| self.is_at_work)?;
        let (job, attempt, _, work) = mail.jobs.get(at.checked_sub(1)?).copied()?;
        let request = mail.request;
        self.beat += self.beats(now_ns);
        self.cpu_ns += work.time_ns;
        self.is_at_work = false;
        self.ill = Ill::None;
        self.started = None;
        Some((request, job, attempt, work))
    }

    /// Beats since the job began: one in each millisecond of work.
    fn beats(&self, now_ns: u64) -> u64 {
        match self.ill {
            Ill::None | Ill::Slow => (now_ns - self.begun_ns) / 1_000_000,
            Ill::Hung | Ill::Stopped | Ill::Starved => 0,
        }
    }

    /// What the coordinator sees of it and concludes.
    pub(super) fn look(&mut self, busy: bool, now_ns: u64, patience: &Patience) -> Liveness {
        let spent_ns = match self.ill {
            Ill::Hung => now_ns - self.begun_ns,
            _ => 0,
        };
        let beats = if self.is_at_work { self.beats(now_ns) } else { 0 };
        let pulse = Pulse {
            beat: self.beat + beats,
            cpu_ns: self.cpu_ns + spent_ns,
            stopped: self.ill == Ill::Stopped,
            busy,
        };
        self.watch.look(pulse, now_ns, patience)
    }
}
