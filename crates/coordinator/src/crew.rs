//! The crew: worker processes, their channels, and the loop that keeps them busy.
//!
//! ```text
//! loop: take results --> dispatcher --> send batches;  nothing to take: sleep on one epoll
//!       a worker's end (pidfd) or silence --> drain its results --> its jobs go to the others
//! ```
//!
//! A request that loses a worker goes on with the others. [`Crew::mend`] starts a successor once
//! the request is answered; it takes jobs as soon as it has greeted, in whatever request that is.
//!
//! Order at start: preflight, seal store, status page, services, processes, greetings. Order at
//! stop: stop flags, a moment to end, SIGKILL, channels, domain. Every wait has a bound.

mod error;
mod idle;
mod incident;
mod mend;
mod parcel;
mod preflight;
mod report;
mod station;

pub use error::CrewError;
pub use idle::Attendant;
pub use incident::{Incident, Sight};
pub use mend::{Mended, Spoiled};
pub use preflight::{Lack, preflight};
pub use report::{CrewReport, Duty, Hardware, Share, WorkerReport};

use crate::gather::Part;
use crate::work::{Errands, PartOf};
use core::sync::atomic::Ordering;
use crossbeam::utils::Backoff;
use dispatch::{
    Cache, Dispatcher, Effect, Entry, Event, Intensity, Matching, Patience, Progress, Queues,
    Restarts, Scheme,
};
use parcel::{Outgoing, parcels};
use protocol::job::{Job, write_batch};
use protocol::result::{read_hits, read_last};
use protocol::{Boot, Head, Incarnation, JobId, Kind, Reject, RequestId, Section, Task};
use runtime::{Poller, SealedMemory, StatusMemory, Wake, clock};
use station::Station;
use std::path::{Path, PathBuf};
use transport::{Domain, UseError};

/// How workers are started.
#[derive(Clone, Debug)]
pub struct Options {
    /// The program that plays the worker: `program worker WORD`.
    pub program: PathBuf,
    /// Name of the instance, part of every shared name.
    pub instance: String,
    /// Build id: both ends must have the same.
    pub build: String,
    /// The core of each worker; `None`: wherever the system puts it.
    pub cores: Vec<Option<usize>>,
    /// Who gets which job.
    pub matching: Matching,
    /// Jobs per message, on their way to one worker at most, and how long a message waits.
    pub queues: Queues,
    /// How much the ledger says that a worker holds.
    pub cache: Cache,
    /// Whether workers get copies of sections, and do not read the store in place.
    pub copies: bool,
    /// Whether to write down who got which job.
    pub log: bool,
    /// How long a busy worker may stand still.
    pub patience: Patience,
    /// How often workers are replaced.
    pub intensity: Intensity,
    /// Whether workers misbehave on order: for fault injection alone.
    pub obeys: bool,
}

/// How long workers may take to greet (ns): a process start, and a few opened files.
const GREETING_NS: u64 = 20_000_000_000;
/// How long the coordinator sleeps at most before it looks at the workers' pulse (ns).
const NAP_NS: u64 = 20_000_000;
/// How long a worker may take to end by itself (ns).
const FAREWELL_MS: u64 = 200;

/// Puts model files into sealed memory, where every process reads them in place.
///
/// # Errors
///
/// If there is not enough memory.
pub fn seal(files: &[&[u8]]) -> Result<SealedMemory, runtime::OsError> {
    let len = model::store::length(files);
    SealedMemory::create("trolley-models", len, |bytes| model::store::fill(bytes, files))
}

/// Worker processes, ready for requests.
#[derive(Debug)]
pub struct Crew {
    // Dropped in this order: channels before the domain that they live in.
    stations: Vec<Station>,
    status: StatusMemory,
    poller: Poller,
    domain: Domain,
    dispatcher: Dispatcher<Box<dyn Scheme>>,
    boot: Boot,
    request: u64,
    options: Options,
    restarts: Restarts,
    /// What was seen since the start of the request.
    incidents: Vec<Incident>,
    /// There is no core without a worker: to spin would take a worker's time.
    shares_core: bool,
    /// Per worker; `None` if nothing is copied.
    outgoing: Option<Vec<Outgoing>>,
    rejected: u64,
    duty: Duty,
    /// Workers whose end was told and who are not buried yet: it is told once.
    ended: Vec<usize>,
    /// When all pulses were felt last (ns): short requests follow on each other, too.
    looked_ns: u64,
    scratch: Vec<u64>,
    effects: Vec<Effect>,
    batch: BatchWriter,
    /// Whoever has to be heard while a request is worked on.
    attendant: Option<Attendant>,
}

/// Scratch for laying out batches.
#[derive(Debug, Default)]
struct BatchWriter {
    tasks: Vec<Task>,
    jobs: Vec<Job>,
    words: Vec<u64>,
}

impl Crew {
    /// Starts the workers and waits until each has greeted.
    ///
    /// # Errors
    ///
    /// If shared memory, a process or a core is not to be had, or a worker does not greet.
    pub fn start(store: &SealedMemory, options: &Options) -> Result<Self, CrewError> {
        let workers = options.cores.len();
        if let Some(lack) = preflight(options).into_iter().find(|lack| lack.is_fatal) {
            return Err(CrewError::Lack(lack));
        }
        let boot = Boot(clock::random_u64()?);
        let swept = transport::sweep_leftovers();
        if swept > 0 {
            tracing::info!(swept, "removed what killed runs had left");
        }
        let status = StatusMemory::create()?;
        let mut poller = Poller::new()?;
        poller.catch_signals()?;
        let domain = Domain::create(&options.instance, boot)?;
        let scheme = options.matching.scheme();
        let mut dispatcher = Dispatcher::new(scheme, options.queues, options.cache, workers);
        if options.log {
            dispatcher.keep_log();
        }
        let mut crew = Self {
            stations: Vec::with_capacity(workers),
            status,
            poller,
            domain,
            dispatcher,
            boot,
            request: 0,
            options: options.clone(),
            restarts: Restarts::new(options.intensity),
            incidents: Vec::new(),
            shares_core: runtime::affinity::allowed_cores().len() <= workers,
            outgoing: options.copies.then(|| (0..workers).map(|_| Outgoing::default()).collect()),
            rejected: 0,
            duty: Duty::default(),
            ended: Vec::new(),
            looked_ns: 0,
            scratch: Vec::with_capacity(protocol::launch::RESULT_WORDS),
            effects: Vec::new(),
            batch: BatchWriter::default(),
            attendant: None,
        };
        for worker in 0..workers {
            let station = crew.man(Incarnation { worker: worker as u8, inc: 0 }, store)?;
            crew.stations.push(station);
        }
        crew.await_greetings()?;
        Ok(crew)
    }

    /// Process ids of the workers, in order.
    #[must_use]
    pub fn pids(&self) -> Vec<u32> {
        self.stations.iter().map(|station| station.report.pid).collect()
    }

    /// Waits until every worker has greeted or is gone; one that greeted is enough.
    fn await_greetings(&mut self) -> Result<(), CrewError> {
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

    /// Tells the workers that nobody waits for this request any more.
    fn cancel(&self) {
        for line in &self.status.page().coordinator {
            line.cancelled.store(self.request, Ordering::SeqCst);
        }
    }

    /// Works a request off, or as far as it is wanted.
    ///
    /// # Errors
    ///
    /// If no worker is left and no deadline says when to answer all the same, or a signal came.
    pub fn run<W: Errands>(&mut self, work: &mut W) -> Result<CrewReport, CrewError> {
        self.work_off(work)?;
        Ok(self.report())
    }

    /// The same without a report, which costs copies: see [`Crew::shares`].
    ///
    /// # Errors
    ///
    /// As [`Crew::run`].
    pub fn work_off<W: Errands>(&mut self, work: &mut W) -> Result<(), CrewError> {
        let mut effects = std::mem::take(&mut self.effects);
        effects.clear();
        let done = self.work_off_by(work, &mut effects);
        self.effects = effects;
        done
    }

    /// What each worker did for the last request.
    pub fn shares(&self) -> impl Iterator<Item = Share> {
        self.stations.iter().map(|station| station.share(&self.status))
    }

    fn work_off_by<W: Errands>(
        &mut self,
        work: &mut W,
        effects: &mut Vec<Effect>,
    ) -> Result<(), CrewError> {
        let begun_ns = clock::now_ns();
        work.accept(begun_ns);
        self.request += 1;
        self.rejected = 0;
        self.duty = Duty::default();
        self.incidents.clear();
        self.dispatcher.begin(RequestId(self.request));
        for outgoing in self.outgoing.iter_mut().flatten() {
            outgoing.clear();
        }
        for station in &mut self.stations {
            station.begin(&self.status);
        }
        for station in self.stations.iter().filter(|station| station.is_ready()) {
            self.dispatcher.admit(station.who);
        }
        // Whoever died since the last request was not seen dying.
        self.sleep(0)?;
        let mut progress = self.step(Event::Poll, work, effects);
        let backoff = Backoff::new();
        while self.is_working(progress) {
            let waits = self.flush(work, effects);
            let (taken, after) = self.take_results(work, effects, progress);
            progress = after;
            let now = clock::now_ns();
            if now - self.looked_ns > NAP_NS {
                self.looked_ns = now;
                // While results keep coming nobody sleeps, and an end would go unnoticed.
                self.sleep(0)?;
                progress = self.look_after(now, work, effects, progress)?;
            }
            let due_ns = self.dispatcher.due_ns();
            if due_ns.is_some_and(|due_ns| due_ns <= now) {
                progress = self.step(Event::Poll, work, effects);
            }
            while let Some(worker) = self.ended.pop() {
                progress = self.bury(worker, work, effects)?;
            }
            if !self.is_working(progress) {
                break;
            }
            if work.is_over(now) {
                self.cancel();
                break;
            }
            if taken || waits {
                backoff.reset();
            } else if self.shares_core || backoff.is_completed() {
                let due_ns = [due_ns, work.deadline_ns()].into_iter().flatten().min();
                let nap_ns = due_ns.map_or(NAP_NS, |due_ns| due_ns.saturating_sub(now).min(NAP_NS));
                self.sleep(nap_ns)?;
            } else {
                backoff.snooze();
            }
        }
        self.duty.run_ns = clock::now_ns() - begun_ns;
        let counts = self.dispatcher.counts();
        if let Some(thrash) = self.dispatcher.thrash() {
            return Err(CrewError::Thrashed(thrash));
        }
        if progress == Progress::Stranded && work.deadline_ns().is_none() {
            let lost = self.stations.iter().filter_map(|station| {
                let how = station.report.lost.as_deref()?;
                Some(format!("worker {} by {how}", station.who.worker))
            });
            return Err(CrewError::NobodyLeft {
                open: counts.jobs - counts.done - counts.cut - counts.abandoned - counts.late,
                jobs: counts.jobs,
                lost: lost.collect::<Vec<_>>().join(", "),
            });
        }
        Ok(())
    }

    /// Whether there is something to wait for: jobs, or somebody who is about to greet.
    fn is_working(&self, progress: Progress) -> bool {
        match progress {
            Progress::Working => true,
            Progress::Stranded => self.stations.iter().any(Station::is_starting),
            Progress::Finished | Progress::Thrashed => false,
        }
    }

    /// Who got which job in the last request, if that is written down.
    #[must_use]
    pub fn log(&self) -> &[Entry] {
        self.dispatcher.log()
    }

    fn report(&self) -> CrewReport {
        CrewReport {
            duty: self.duty,
            counts: self.dispatcher.counts(),
            transfer: self.dispatcher.transfer(),
            rejected: self.rejected,
            workers: self.stations.iter().map(|station| station.report(&self.status)).collect(),
        }
    }

    /// One event, and everything that follows from it.
    fn step<W: Errands>(
        &mut self,
        event: Event<PartOf<'_>>,
        work: &mut W,
        effects: &mut Vec<Effect>,
    ) -> Progress {
        let begun_ns = clock::now_ns();
        let mut progress = self.dispatcher.step(begun_ns, event, work, effects);
        let mut stepped_ns = clock::now_ns();
        self.duty.step_ns += stepped_ns - begun_ns;
        // In order: a batch may need sections that went with the one before it. And whose queue
        // refused one gets none that were made before that was known.
        let mut refused = 0_u32;
        while !effects.is_empty() {
            let (to, batch, jobs, fetch) = match effects.remove(0) {
                Effect::Send { to, batch, jobs, fetch } => (to, batch, jobs, fetch),
                Effect::Kill { who, why } => {
                    let station = &mut self.stations[usize::from(who.worker)];
                    if station.who == who && station.is_alive() {
                        station.kill(&why.to_string());
                        self.see(who, Sight::Distrusted(why));
                    }
                    continue;
                }
            };
            let sent = match refused >> to.worker & 1 == 1 {
                true => Err(UseError::Full),
                false => self.send(to, batch, &jobs, &fetch, work),
            };
            self.dispatcher.reuse(jobs, fetch);
            let sent_ns = clock::now_ns();
            self.duty.send_ns += sent_ns - stepped_ns;
            stepped_ns = sent_ns;
            let event = match sent {
                Ok(()) => continue,
                Err(UseError::Full) => {
                    self.see(to, Sight::Full);
                    refused |= 1 << to.worker;
                    Event::Unsent { to, batch }
                }
                // The channel is broken, or its worker was buried since.
                Err(error) => {
                    let station = &mut self.stations[usize::from(to.worker)];
                    if station.is_alive() {
                        station.kill(&format!("its job channel broke ({error})"));
                    }
                    let (who, started) = station.bury(&self.status, self.request);
                    self.lay_to_rest(usize::from(to.worker));
                    Event::Lost { who, started }
                }
            };
            progress = self.dispatcher.step(clock::now_ns(), event, work, effects);
        }
        progress
    }

    fn send<W: Errands>(
        &mut self,
        to: Incarnation,
        batch: u32,
        jobs: &[(JobId, u8)],
        fetch: &[Section],
        work: &W,
    ) -> Result<(), UseError> {
        let BatchWriter { tasks, jobs: rows, words } = &mut self.batch;
        tasks.clear();
        rows.clear();
        for (job, attempt) in jobs {
            let Some(spec) = self.dispatcher.spec(*job) else { continue };
            let Some(task) = work.task(spec.task) else { continue };
            let place = tasks.iter().position(|known| known.task == task.task);
            let place = place.unwrap_or_else(|| {
                tasks.push(*task);
                tasks.len() - 1
            });
            rows.push(Job {
                job: job.0,
                task: place as u32,
                node_a: spec.a.node,
                node_b: spec.b.node,
                budget: work.budget(),
                attempt: u32::from(*attempt),
                spare: 0,
            });
        }
        write_batch(words, tasks, rows);
        let head = Head {
            job: batch,
            count: rows.len() as u16,
            ..Head::new(self.boot, RequestId(self.request), to, Kind::Batch)
        };
        let station = &mut self.stations[usize::from(to.worker)];
        let Some(outgoing) = &mut self.outgoing else {
            return station.send(&self.status, head, words);
        };
        let outgoing = &mut outgoing[usize::from(to.worker)];
        for section in fetch {
            let Some(body) = work.body(section.model) else { continue };
            let head = Head::new(self.boot, RequestId(self.request), to, Kind::Section);
            for parcel in parcels(&body, *section) {
                outgoing.push(head, parcel);
            }
        }
        outgoing.push(head, words.clone());
        outgoing.flush(station, &self.status)
    }

    /// Hands over what has waited for room. Says whether something still does.
    fn flush<W: Errands>(&mut self, work: &mut W, effects: &mut Vec<Effect>) -> bool {
        let Some(outgoing) = &mut self.outgoing else { return false };
        let mut broken = None;
        for (station, outgoing) in self.stations.iter_mut().zip(outgoing.iter_mut()) {
            if !station.is_alive() {
                outgoing.clear();
            } else if let Err(error) = outgoing.flush(station, &self.status) {
                station.kill(&format!("its job channel broke ({error})"));
                broken = Some(station.bury(&self.status, self.request));
                self.restarts.note(station.who.worker, clock::now_ns());
            }
        }
        let waits = outgoing.iter().any(|outgoing| !outgoing.is_empty());
        if let Some((who, started)) = broken {
            self.step(Event::Lost { who, started }, work, effects);
        }
        waits
    }

    /// Takes all results there are by now. Says whether there was one.
    fn take_results<W: Errands>(
        &mut self,
        work: &mut W,
        effects: &mut Vec<Effect>,
        mut progress: Progress,
    ) -> (bool, Progress) {
        let mut any = false;
        for number in 0..self.stations.len() {
            // Read before the channel is emptied: what was sent for these batches is in it by now.
            let answered = self.stations[number].newly_answered(&self.status);
            while let Some(after) = self.take_one(number, work, effects) {
                (any, progress) = (true, after);
                // However fast results come, the answer is due when it is due.
                if work.is_over(clock::now_ns()) {
                    return (any, progress);
                }
            }
            let Some(answered) = answered else { continue };
            let batches = self.stations[number].note_answered(answered);
            let (who, before) = (self.stations[number].who, self.dispatcher.counts().reissued);
            progress = self.step(Event::Answered { who, batches }, work, effects);
            if self.dispatcher.counts().reissued > before {
                self.see(who, Sight::Unanswered);
            }
        }
        (any, progress)
    }

    /// Takes one message from one worker; `None` if there is none.
    fn take_one<W: Errands>(
        &mut self,
        number: usize,
        work: &mut W,
        effects: &mut Vec<Effect>,
    ) -> Option<Progress> {
        let mut scratch = std::mem::take(&mut self.scratch);
        let begun_ns = clock::now_ns();
        let taken = self.stations[number].take(&self.status, &mut scratch);
        if matches!(taken, Ok(Some(_))) {
            self.duty.take_ns += clock::now_ns() - begun_ns;
        }
        let progress = match taken {
            Ok(Some(Ok(head))) => Some(self.handle(number, &head, &scratch, work, effects)),
            Ok(Some(Err(reject))) => Some(self.turn_away(number, reject, work, effects)),
            Ok(None) | Err(_) => None,
        };
        self.scratch = scratch;
        progress
    }

    fn handle<W: Errands>(
        &mut self,
        number: usize,
        head: &Head,
        words: &[u64],
        work: &mut W,
        effects: &mut Vec<Effect>,
    ) -> Progress {
        let (from, job) = (self.stations[number].who, JobId(head.job));
        let request = RequestId(head.request);
        match Kind::from_number(head.kind) {
            Some(Kind::Result) => {
                let last = head.is_last().then(|| read_last(words, head.hits));
                let hits = match &last {
                    Some(last) => last.map(|last| last.hits),
                    None => read_hits(words, head.hits),
                };
                let Some(hits) = hits else {
                    self.distrust(number, "counts that do not fit");
                    return self.step(Event::Poll, work, effects);
                };
                let last = last.flatten();
                if let (Some(last), true) = (&last, head.request == self.request) {
                    let report = &mut self.stations[number].report;
                    report.busy_ns += last.summary.wall_ns;
                    report.spans.push([clock::now_ns(), last.summary.wall_ns]);
                }
                let event = Event::Part {
                    from,
                    request,
                    job,
                    attempt: head.attempt,
                    part: head.part,
                    last: last.is_some(),
                    body: PartOf(Part { hits, rest: &[], last }),
                };
                let before = self.dispatcher.counts().fence;
                let progress = self.step(event, work, effects);
                if self.dispatcher.counts().fence != before {
                    self.see(from, Sight::Fenced);
                }
                progress
            }
            Some(Kind::Rest) if words.len() == 1 + head.hits as usize => {
                let event = Event::Part {
                    from,
                    request,
                    job,
                    attempt: head.attempt,
                    part: head.part,
                    last: false,
                    body: PartOf(Part { hits: &[], rest: words, last: None }),
                };
                self.step(event, work, effects)
            }
            Some(Kind::Rest) => {
                self.distrust(number, "counts that do not fit");
                self.step(Event::Poll, work, effects)
            }
            Some(Kind::Nack) => {
                tracing::warn!(worker = number, job = head.job, "a job failed");
                self.see(from, Sight::Failed);
                let attempt = head.attempt;
                self.step(Event::Failed { from, request, job, attempt }, work, effects)
            }
            Some(Kind::Hello) => {
                self.stations[number].has_greeted = true;
                self.step(Event::Ready(from), work, effects)
            }
            Some(Kind::Batch | Kind::Section) | None => self.step(Event::Poll, work, effects),
        }
    }

    /// A message was turned away. What it held is not known; the dispatcher finds out what is
    /// missing when its sender has answered all it had, and counts.
    fn turn_away<W: Errands>(
        &mut self,
        number: usize,
        reject: Reject,
        work: &mut W,
        effects: &mut Vec<Effect>,
    ) -> Progress {
        let from = self.stations[number].who;
        self.see(from, Sight::TurnedAway(reject));
        if reject == Reject::Masquerade {
            self.distrust(number, &reject.to_string());
            return self.step(Event::Poll, work, effects);
        }
        tracing::warn!(worker = number, why = %reject, "message turned away");
        self.rejected += 1;
        self.step(Event::Garbled { from }, work, effects)
    }

    /// A message that is sound and says what cannot be: its sender ends, and all that it had goes
    /// to the others.
    fn distrust(&mut self, number: usize, why: &str) {
        tracing::warn!(worker = number, why, "message turned away: killing its sender");
        self.rejected += 1;
        self.stations[number].kill(&format!("sent a message that was turned away: {why}"));
    }

    /// Looks at every worker's pulse, and kills who stands still.
    fn look_after<W: Errands>(
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
        station.kill(&format!("{verdict:?}").to_lowercase());
        self.see(self.stations[number].who, Sight::StoodStill(verdict));
        true
    }

    /// Takes leave of a worker that has ended: its last results first, then its jobs to the others.
    fn bury<W: Errands>(
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

    /// Sleeps until a worker rings or ends, at most so long.
    fn sleep(&mut self, timeout_ns: u64) -> Result<(), CrewError> {
        let flag = |value| {
            for line in &self.status.page().coordinator {
                line.sleeping.store(value, Ordering::SeqCst);
            }
        };
        flag(1);
        // A result sent before the flag was up rang nobody.
        let waiting = self.stations.iter().any(|station| station.has_mail(&self.status));
        let wakes = self.poller.wait(Some(if waiting { 0 } else { timeout_ns }));
        flag(0);
        if let Some(attendant) = &mut self.attendant {
            attendant.attend();
        }
        for wake in wakes? {
            match wake {
                Wake::Process(worker) => {
                    self.ended.push(worker as usize);
                    self.see(self.stations[worker as usize].who, Sight::Ended);
                }
                Wake::Signal(_) => return Err(CrewError::Interrupted),
                Wake::Event(_) | Wake::Ready(_) | Wake::Timer => {}
            }
        }
        Ok(())
    }
}

impl Drop for Crew {
    fn drop(&mut self) {
        for station in &self.stations {
            station.tell_to_stop(&self.status);
        }
        let end = clock::now_ns() + FAREWELL_MS * 1_000_000;
        for station in &mut self.stations {
            station.part(end.saturating_sub(clock::now_ns()) / 1_000_000);
        }
        self.stations.clear();
    }
}

/// The program that is running: workers are started from the same file.
impl Options {
    /// This program itself.
    #[must_use]
    pub fn own_program() -> &'static Path {
        runtime::process::self_exe()
    }
}
