//! The world: events in order of time, and faults that strike at random. Equal seeds give equal
//! worlds. What workers and the coordinator do in their turn is in their own files.

use super::kind::{Faults, SimulatedFault};
use super::rng_key::RngKey;
use super::tally::Tally;
use super::work::{Part, Request};
use core::fmt;
use dispatch::{
    Cache, Dispatcher, Event, Intensity, MatchScheme, Matching, Patience, Progress, Queues,
    Restarts,
};
use protocol::{Incarnation, JobId, RequestId};
use std::collections::BTreeMap;

mod actor;
mod coordinator;
mod worker;

use actor::{Actor, Mail};

/// How long a message is in flight (ns).
const FLIGHT_NS: u64 = 800;
/// From a death to the moment when it is noticed (ns): 0.4 to 0.6 ms as measured.
const NOTICE_NS: u64 = 500_000;
/// From the start of a process to its greeting (ns).
const START_NS: u64 = 15_000_000;
/// How often heartbeats are checked (ns).
const LOOK_NS: u64 = 20_000_000;
/// A request without deadline that takes longer is a hang (ns).
const FOR_EVER_NS: u64 = 120_000_000_000;
/// How many workers one job may take down, where batches come in order. One that is overtaken
/// counts as lost, and its jobs are then in two places.
const POISON_MAX: u64 = 2;

/// What may strike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaultLimits {
    /// Kinds that may.
    pub kinds: Faults,
    /// How many in all: the first ones.
    pub most: u64,
    /// Requests in one world.
    pub requests: u64,
    /// The deliberate flaw of the dispatcher.
    #[cfg(test)]
    pub(crate) flaw: Option<dispatch::DispatcherFlaw>,
}

impl Default for FaultLimits {
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
    key: RngKey,
    /// Rate of each kind: once in so many places; 0: never.
    rates: Vec<u64>,
    now_ns: u64,
    events: BTreeMap<(u64, u64), Happening>,
    made: u64,
    actors: Vec<Actor>,
    dispatcher: Dispatcher<Box<dyn MatchScheme>>,
    restarts: Restarts,
    patience: Patience,
    request: Request,
    number: RequestId,
    progress: Progress,
    tally: Tally,
    limits: &'l FaultLimits,
    wrong: Option<String>,
    /// Workers that each job has taken down, in this request.
    poisoned: BTreeMap<u64, u32>,
    log: Option<&'l mut Vec<String>>,
}

/// Runs the world of a seed. `log`, if given, receives all events.
///
/// # Errors
///
/// The first law that was broken.
pub fn run(
    seed: u64,
    limits: &FaultLimits,
    log: Option<&mut Vec<String>>,
) -> Result<Tally, Violation> {
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
        world.now_ns += world.key.at(70).at(number).below(3 * START_NS);
    }
    Ok(world.tally)
}

impl<'l> World<'l> {
    fn new(seed: u64, limits: &'l FaultLimits, log: Option<&'l mut Vec<String>>) -> Self {
        let key = RngKey::new(seed);
        let workers = [1, 2, 2, 3, 4, 4, 4, 4][key.at(1).below(8) as usize];
        let capacity = 1 + key.at(2).below(16) as u32;
        let queues = Queues {
            capacity,
            batch: 1 + key.at(3).below(capacity.min(6).into()) as u32,
            linger_ns: if key.at(4).once_in(4) { 50_000 } else { 0 },
        };
        let matching = match key.at(5).below(4) {
            0 => Matching::RandomMatch(key.at(6).bits()),
            1 => Matching::LowestMatch,
            2 => Matching::RoundRobin,
            _ => Matching::BestMatchLoad(key.at(6).below(3) as f64 / 2.0),
        };
        let intensity =
            if key.at(7).once_in(2) { Intensity::default() } else { Intensity::UNLIMITED };
        // Most worlds have no or few faults of each kind: many faults hide what a single one would
        // show.
        let rate = |fault: &SimulatedFault| {
            let key = key.at(8).at(*fault as u64);
            let rare = [0, 0, 0, 0, 0, 8, 40, 200][key.below(8) as usize];
            if limits.kinds.has(*fault) { rare } else { 0 }
        };
        #[cfg_attr(not(test), expect(unused_mut, reason = "tests spoil it"))]
        let mut dispatcher = Dispatcher::new(matching.scheme(), queues, Cache::Unlimited, workers);
        #[cfg(test)]
        dispatcher.corrupt(limits.flaw);
        let actors = (0..workers as u8).map(|worker| Actor::new(Incarnation { worker, inc: 0 }));
        let mut world = Self {
            key,
            rates: SimulatedFault::ALL.iter().map(rate).collect(),
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
    fn strikes(&mut self, fault: SimulatedFault, place: RngKey) -> bool {
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

    fn place(&self, who: Incarnation) -> RngKey {
        self.key.at(30).at(who.worker.into()).at(who.inc.into())
    }

    /// A worker's process, if it lives.
    fn actor(&mut self, who: Incarnation) -> Option<&mut Actor> {
        self.actors.get_mut(usize::from(who.worker)).filter(|a| a.who == who && a.is_alive)
    }

    /// Takes the next event from the list and handles it.
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
                if !self.actors[usize::from(who.worker)].is_reaped {
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
                if actor.who == who && !actor.is_reaped {
                    self.reap(who);
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
}
