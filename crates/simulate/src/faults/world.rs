//! The world: workers, channels, time; and the coordinator's loop, as it is in `coordinator`.

use super::draw::Draw;
use super::kind::{Fault, Faults};
use super::work::{Answer, Part, Request};
use core::fmt;
use dispatch::{
    Cache, Dispatcher, Effect, Event, Intensity, Leave, Matching, Patience, Progress, Queues,
    Restarts, Scheme, Verdict,
};
use protocol::{Incarnation, JobId, RequestId};
use std::collections::BTreeMap;

mod actor;

use actor::{Actor, Ill, Mail, Notes};

/// How long a message flies (ns).
const FLIGHT_NS: u64 = 800;
/// From a death to the moment when it is noticed (ns): 0.4 to 0.6 ms as measured.
const NOTICE_NS: u64 = 500_000;
/// From the start of a process to its greeting (ns).
const START_NS: u64 = 15_000_000;
/// How often pulses are looked at (ns).
const LOOK_NS: u64 = 20_000_000;
/// A request without deadline that takes longer is a hang (ns).
const FOR_EVER_NS: u64 = 120_000_000_000;
/// How many workers one job may take down, where batches come in order. One that is overtaken is
/// taken for lost, and its jobs are then in two places.
const POISON_MAX: u64 = 2;

/// What may strike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Kinds that may.
    pub kinds: Faults,
    /// How many in all: the first ones.
    pub most: u64,
    /// Requests in one world.
    pub requests: u64,
    /// The mistake that the dispatcher makes.
    #[cfg(test)]
    pub(crate) flaw: Option<dispatch::Flaw>,
}

impl Default for Limits {
    /// Everything, in four requests.
    fn default() -> Self {
        Self {
            kinds: Faults::ALL,
            most: u64::MAX,
            requests: 4,
            #[cfg(test)]
            flaw: None,
        }
    }
}

/// What was counted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tally {
    /// Requests.
    pub requests: u64,
    /// Requests in which a fault struck.
    pub disturbed: u64,
    /// Jobs.
    pub jobs: u64,
    /// Complete answers.
    pub complete: u64,
    /// Degraded answers.
    pub degraded: u64,
    /// Refusals.
    pub refused: u64,
    /// Faults that struck, in the order of [`Fault::ALL`].
    pub struck: Vec<u64>,
    /// Leases that ended without a result.
    pub reissued: u64,
    /// Jobs given up because they took workers down or failed.
    pub abandoned: u64,
    /// Parts turned away by the fence.
    pub fenced: u64,
    /// Workers that died, of whatever.
    pub deaths: u64,
    /// Workers that were killed by the coordinator.
    pub killed: u64,
}

impl Default for Tally {
    fn default() -> Self {
        Self {
            requests: 0,
            disturbed: 0,
            jobs: 0,
            complete: 0,
            degraded: 0,
            refused: 0,
            struck: vec![0; Fault::ALL.len()],
            reissued: 0,
            abandoned: 0,
            fenced: 0,
            deaths: 0,
            killed: 0,
        }
    }
}

impl Tally {
    /// All faults that struck.
    #[must_use]
    pub fn faults(&self) -> u64 {
        self.struck.iter().sum()
    }

    /// Includes another one.
    pub fn add(&mut self, other: &Self) {
        let pairs = [
            (&mut self.requests, other.requests),
            (&mut self.disturbed, other.disturbed),
            (&mut self.jobs, other.jobs),
            (&mut self.complete, other.complete),
            (&mut self.degraded, other.degraded),
            (&mut self.refused, other.refused),
            (&mut self.reissued, other.reissued),
            (&mut self.abandoned, other.abandoned),
            (&mut self.fenced, other.fenced),
            (&mut self.deaths, other.deaths),
            (&mut self.killed, other.killed),
        ];
        for (sum, more) in pairs {
            *sum += more;
        }
        for (sum, more) in self.struck.iter_mut().zip(&other.struck) {
            *sum += more;
        }
    }
}

/// A law was broken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// In which world.
    pub seed: u64,
    /// In which of its requests, from 1.
    pub request: u64,
    /// How.
    pub what: String,
    /// What struck until then.
    pub struck: Vec<u64>,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "seed {}, request {}: {}", self.seed, self.request, self.what)
    }
}

/// What happens, and when.
enum Happening {
    Batch(Incarnation, Mail),
    Part {
        from: Incarnation,
        request: RequestId,
        job: JobId,
        attempt: u8,
        part: (u16, bool, Part),
    },
    Garbled(Incarnation),
    Nack {
        from: Incarnation,
        request: RequestId,
        job: JobId,
        attempt: u8,
    },
    Answered {
        who: Incarnation,
        batches: u32,
    },
    Hello(Incarnation),
    /// The worker's own next step.
    Turn {
        who: Incarnation,
        turn: u64,
    },
    Dies(Incarnation),
    Died(Incarnation),
    Look,
    Deadline(RequestId),
}

struct World<'l> {
    draw: Draw,
    /// Rate of each kind: once in so many places; 0: never.
    rates: Vec<u64>,
    now_ns: u64,
    events: BTreeMap<(u64, u64), Happening>,
    made: u64,
    actors: Vec<Actor>,
    dispatcher: Dispatcher<Box<dyn Scheme>>,
    restarts: Restarts,
    patience: Patience,
    request: Request,
    number: RequestId,
    progress: Progress,
    tally: Tally,
    limits: &'l Limits,
    wrong: Option<String>,
    /// Workers that each job has taken down, in this request.
    poisoned: BTreeMap<u64, u32>,
    log: Option<&'l mut Vec<String>>,
}

/// Runs the world of a seed. `log`, if given, is told all that happens.
///
/// # Errors
///
/// The first law that was broken.
pub fn run(seed: u64, limits: &Limits, log: Option<&mut Vec<String>>) -> Result<Tally, Violation> {
    let mut world = World::new(seed, limits, log);
    for number in 1..=limits.requests {
        let before = world.tally.faults();
        let end = world.answer(RequestId(number));
        let wrong = world.wrong.take().map_or(end, Err);
        if let Err(what) = wrong {
            let struck = world.tally.struck.clone();
            return Err(Violation { seed, request: number, what, struck });
        }
        world.tally.disturbed += u64::from(world.tally.faults() > before);
        world.mend();
        world.now_ns += world.draw.at(70).at(number).below(3 * START_NS);
    }
    Ok(world.tally)
}

impl<'l> World<'l> {
    fn new(seed: u64, limits: &'l Limits, log: Option<&'l mut Vec<String>>) -> Self {
        let draw = Draw::new(seed);
        let workers = [1, 2, 2, 3, 4, 4, 4, 4][draw.at(1).below(8) as usize];
        let capacity = 1 + draw.at(2).below(16) as u32;
        let queues = Queues {
            capacity,
            batch: 1 + draw.at(3).below(capacity.min(6).into()) as u32,
            linger_ns: if draw.at(4).once_in(4) { 50_000 } else { 0 },
        };
        let matching = match draw.at(5).below(4) {
            0 => Matching::RandomMatch(draw.at(6).bits()),
            1 => Matching::LowestMatch,
            2 => Matching::RoundRobin,
            _ => Matching::BestMatchLoad(draw.at(6).below(3) as f64 / 2.0),
        };
        let intensity =
            if draw.at(7).once_in(2) { Intensity::default() } else { Intensity::UNLIMITED };
        // Of each kind, most worlds have none or few: crowds hide what one alone would show.
        let rate = |fault: &Fault| {
            let draw = draw.at(8).at(*fault as u64);
            let rare = [0, 0, 0, 0, 0, 8, 40, 200][draw.below(8) as usize];
            if limits.kinds.has(*fault) { rare } else { 0 }
        };
        #[cfg_attr(not(test), expect(unused_mut, reason = "tests spoil it"))]
        let mut dispatcher = Dispatcher::new(matching.scheme(), queues, Cache::Unlimited, workers);
        #[cfg(test)]
        dispatcher.spoil(limits.flaw);
        let actors = (0..workers as u8).map(|worker| Actor::new(Incarnation { worker, inc: 0 }));
        let mut world = Self {
            draw,
            rates: Fault::ALL.iter().map(rate).collect(),
            now_ns: 1,
            events: BTreeMap::new(),
            made: 0,
            actors: actors.collect(),
            dispatcher,
            restarts: Restarts::new(intensity),
            patience: Patience::default(),
            request: Request::default(),
            number: RequestId(0),
            progress: Progress::Finished,
            tally: Tally::default(),
            limits,
            wrong: None,
            poisoned: BTreeMap::new(),
            log,
        };
        world.actors.iter_mut().for_each(|actor| actor.is_ready = true);
        world.after(LOOK_NS, Happening::Look);
        world
    }

    fn after(&mut self, delay_ns: u64, what: Happening) {
        self.made += 1;
        self.events.insert((self.now_ns + delay_ns, self.made), what);
    }

    fn say(&mut self, what: impl FnOnce() -> String) {
        let now = self.now_ns as f64 / 1e6;
        if let Some(log) = &mut self.log {
            log.push(format!("{now:12.4} ms  {}", what()));
        }
    }

    /// Whether a fault strikes at a place.
    fn strikes(&mut self, fault: Fault, place: Draw) -> bool {
        let rate = self.rates[fault as usize];
        if rate == 0
            || !place.at(1000 + fault as u64).once_in(rate)
            || self.tally.faults() >= self.limits.most
        {
            return false;
        }
        self.tally.struck[fault as usize] += 1;
        self.say(|| format!("FAULT {fault}"));
        true
    }

    /// Answers one request, and judges the answer.
    fn answer(&mut self, number: RequestId) -> Result<(), String> {
        let draw = self.draw.at(20).at(number.0);
        self.number = number;
        self.request = Request::draw(draw);
        self.poisoned.clear();
        let begun_ns = self.now_ns;
        self.say(|| format!("request {} begins", number.0));
        self.dispatcher.begin(number);
        let deadline_ns = if self.strikes(Fault::Deadline, draw) {
            Some(100_000 + draw.at(9).below(5_000_000))
        } else {
            draw.at(10).once_in(2).then_some(30_000_000_000)
        };
        if let Some(after_ns) = deadline_ns {
            self.after(after_ns, Happening::Deadline(number));
        }
        for actor in self.actors.iter().filter(|actor| actor.is_ready && !actor.is_buried) {
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
            // Nobody is left, and nobody is coming: what is open stays unknown.
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
        let is_starting = |actor: &Actor| !actor.is_buried && !actor.is_ready;
        match self.progress {
            Progress::Working => true,
            Progress::Stranded => self.actors.iter().any(is_starting),
            Progress::Finished | Progress::Thrashed => false,
        }
    }

    /// One event for the dispatcher, and everything that follows.
    fn step(&mut self, event: Event<Part>) {
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

    /// Puts a batch on its way; what the dispatcher is to be told if that fails.
    fn send(&mut self, to: Incarnation, batch: u32, jobs: &[(JobId, u8)]) -> Option<Event<Part>> {
        if self.actors[usize::from(to.worker)].who != to
            || self.actors[usize::from(to.worker)].is_buried
        {
            return Some(Event::Lost { who: to, started: None });
        }
        self.say(|| format!("batch {batch} to {}.{}: {jobs:?}", to.worker, to.inc));
        let place = self.place(to).at(2).at(batch.into());
        if self.strikes(Fault::Full, place) {
            return Some(Event::Unsent { to, batch });
        }
        let table = |(job, attempt): &(JobId, u8)| {
            let spec = self.dispatcher.spec(*job)?;
            Some((*job, *attempt, Request::name_of(spec), *self.request.job(Some(spec))?))
        };
        let jobs = jobs.iter().filter_map(table).collect();
        let mut mail = Mail { number: batch, request: self.number, jobs, is_garbled: false };
        if self.strikes(Fault::LoseBatch, place) {
            self.actors[usize::from(to.worker)].has_lost_mail = true;
            return None;
        }
        mail.is_garbled = self.strikes(Fault::GarbleBatch, place);
        let mut flight_ns = FLIGHT_NS;
        if self.strikes(Fault::DelayBatch, place) {
            flight_ns += place.at(4).below(3_000_000);
            // Out of order and then garbled, a batch may go unnoticed until its worker is silent.
            self.actors[usize::from(to.worker)].has_lost_mail = true;
        }
        if self.strikes(Fault::RepeatBatch, place) {
            self.after(flight_ns + place.at(5).below(400_000), Happening::Batch(to, mail.clone()));
        }
        self.after(flight_ns, Happening::Batch(to, mail));
        None
    }

    fn place(&self, who: Incarnation) -> Draw {
        self.draw.at(30).at(who.worker.into()).at(who.inc.into())
    }

    /// A worker's process, if it lives.
    fn actor(&mut self, who: Incarnation) -> Option<&mut Actor> {
        self.actors.get_mut(usize::from(who.worker)).filter(|a| a.who == who && a.is_alive)
    }

    /// Takes the next event off the list, and lets it happen.
    fn next(&mut self) {
        let Some(((at_ns, _), what)) = self.events.pop_first() else { return };
        self.now_ns = self.now_ns.max(at_ns);
        match what {
            Happening::Batch(to, mail) => {
                if let Some(actor) = self.actor(to) {
                    actor.queue.push_back(mail);
                    self.turn(to);
                }
            }
            Happening::Turn { who, turn } => {
                if self.actor(who).is_some_and(|actor| actor.turn == turn) {
                    self.finish_job(who);
                    self.turn(who);
                }
            }
            Happening::Part { from, request, job, attempt, part: (part, last, body) } => {
                self.say(|| format!("part {part} of {job:?}.{attempt} from {from:?}"));
                self.step(Event::Part { from, request, job, attempt, part, last, body });
            }
            Happening::Garbled(from) => self.step(Event::Garbled { from }),
            Happening::Nack { from, request, job, attempt } => {
                self.step(Event::Failed { from, request, job, attempt });
            }
            Happening::Answered { who, batches } => {
                if !self.actors[usize::from(who.worker)].is_buried {
                    self.step(Event::Answered { who, batches });
                }
            }
            Happening::Hello(who) => {
                if let Some(actor) = self.actor(who) {
                    actor.is_ready = true;
                    self.step(Event::Ready(who));
                }
            }
            Happening::Dies(who) => self.die(who),
            Happening::Died(who) => {
                let actor = &mut self.actors[usize::from(who.worker)];
                if actor.who == who && !actor.is_buried {
                    self.bury(who);
                    let started = self.actors[usize::from(who.worker)].started;
                    let started = started.filter(|(request, ..)| *request == self.number);
                    let started = started.map(|(_, job, attempt)| (job, attempt));
                    self.say(|| format!("lost {who:?}, which had started {started:?}"));
                    self.step(Event::Lost { who, started });
                }
            }
            Happening::Look => {
                self.look();
                self.after(LOOK_NS, Happening::Look);
            }
            Happening::Deadline(request) => {
                if request == self.number {
                    self.step(Event::Expired);
                    if self.progress != Progress::Finished {
                        self.wrong = Some(format!("{:?} after the deadline", self.progress));
                    }
                }
            }
        }
    }

    /// A worker's process ends; that is noticed a little later.
    fn die(&mut self, who: Incarnation) {
        let Some(actor) = self.actor(who) else { return };
        actor.is_alive = false;
        actor.queue.clear();
        self.tally.deaths += 1;
        self.say(|| format!("{who:?} dies"));
        let jitter_ns = self.place(who).at(6).below(NOTICE_NS);
        self.after(NOTICE_NS / 2 + jitter_ns, Happening::Died(who));
    }

    fn bury(&mut self, who: Incarnation) {
        self.actors[usize::from(who.worker)].is_buried = true;
        self.restarts.note(who.worker, self.now_ns);
    }

    /// Judges every pulse, as the coordinator does.
    fn look(&mut self) {
        for number in 0..self.actors.len() {
            let busy = self.dispatcher.is_busy(number as u8);
            let (now_ns, patience) = (self.now_ns, self.patience);
            let actor = &mut self.actors[number];
            if !actor.is_alive || !actor.is_ready {
                continue;
            }
            let verdict = actor.look(busy, now_ns, &patience);
            if verdict == Verdict::Alive {
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

    /// Starts successors between requests.
    fn mend(&mut self) {
        for number in 0..self.actors.len() {
            let actor = &self.actors[number];
            let who = actor.who;
            if actor.is_alive {
                continue;
            }
            if !actor.is_buried {
                self.bury(who);
                self.dispatcher.dismiss(who);
            }
            if self.restarts.leave(who.worker, self.now_ns) != Leave::Granted {
                continue;
            }
            let next = Incarnation { inc: who.inc + 1, ..who };
            self.actors[number] = Actor::new(next);
            let place = self.place(next);
            if self.strikes(Fault::StillBorn, place) {
                self.after(START_NS / 2, Happening::Dies(next));
            } else {
                self.after(START_NS / 2 + place.at(7).below(START_NS), Happening::Hello(next));
            }
        }
    }

    /// What a worker does next: the job at hand, the next batch, or nothing.
    fn turn(&mut self, who: Incarnation) {
        let now_ns = self.now_ns;
        let mut notes = Notes::default();
        let Some(actor) = self.actor(who) else { return };
        let Some((request, job, attempt, name, work)) = actor.next_job(now_ns, &mut notes) else {
            self.tell_answered(who, &notes);
            return;
        };
        self.tell_answered(who, &notes);
        let whole = self.draw.at(40).at(request.0).at(name);
        let place = self.place(who).at(3).at(request.0).at(job.0.into()).at(attempt.into());
        let mut time_ns = work.time_ns;
        let mut ill = Ill::None;
        if self.strikes(Fault::Poison, whole) {
            let deaths = self.poisoned.entry(name).or_default();
            *deaths += u32::from(request == self.number);
            let overtaken = self.tally.struck[Fault::DelayBatch as usize];
            if u64::from(*deaths) > POISON_MAX + overtaken {
                self.wrong = Some(format!("job {name} has taken {deaths} workers down"));
            }
            self.after(time_ns / 2, Happening::Dies(who));
        } else if self.strikes(Fault::Crash, place) {
            self.after(place.at(8).below(time_ns), Happening::Dies(who));
        } else if self.strikes(Fault::Hang, place) {
            ill = Ill::Hung;
        } else if self.strikes(Fault::Stop, place) {
            ill = Ill::Stopped;
        } else if self.strikes(Fault::Slow, place) {
            ill = Ill::Slow;
            time_ns *= 10;
        } else if self.strikes(Fault::Starve, place) {
            ill = Ill::Starved;
            time_ns += 50_000_000 + place.at(9).below(1_450_000_000);
        }
        let Some(actor) = self.actor(who) else { return };
        let turn = actor.start(ill, now_ns);
        if !matches!(ill, Ill::Hung | Ill::Stopped) {
            self.after(time_ns, Happening::Turn { who, turn });
        }
    }

    /// The job at hand is done: its result is put on its way.
    fn finish_job(&mut self, who: Incarnation) {
        let now_ns = self.now_ns;
        let Some(done) = self.actor(who).and_then(|actor| actor.finish(now_ns)) else { return };
        let (request, job, attempt, work) = done;
        let place = self.place(who).at(4).at(request.0).at(job.0.into()).at(attempt.into());
        if self.strikes(Fault::Nack, place) {
            self.after(FLIGHT_NS, Happening::Nack { from: who, request, job, attempt });
            return;
        }
        for number in 0..work.parts {
            let place = place.at(10 + u64::from(number));
            let last = number + 1 == work.parts;
            let part = (number, last, work.part(number));
            let message = || Happening::Part { from: who, request, job, attempt, part };
            if self.strikes(Fault::LoseResult, place) {
                continue;
            }
            if self.strikes(Fault::GarbleResult, place) {
                self.after(FLIGHT_NS, Happening::Garbled(who));
                continue;
            }
            let mut flight_ns = FLIGHT_NS;
            if self.strikes(Fault::DelayResult, place) {
                flight_ns += place.at(4).below(2_000_000);
            }
            if self.strikes(Fault::RepeatResult, place) {
                self.after(flight_ns + place.at(5).below(900_000), message());
            }
            if self.strikes(Fault::Zombie, place) {
                // Its word that the job is started is the last that is known of it.
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
        if self.strikes(Fault::CrashIdle, place) {
            self.after(FLIGHT_NS, Happening::Dies(who));
        }
    }

    /// What a worker says of the batches that it has answered.
    fn tell_answered(&mut self, who: Incarnation, notes: &Notes) {
        if let Some(batches) = notes.answered {
            self.after(FLIGHT_NS, Happening::Answered { who, batches });
        }
    }
}
