//! One worker as the coordinator sees it: its process, its channels, its lines on the status page.

use super::{Hardware, Options, WorkerReport};
use core::sync::atomic::Ordering;
use dispatch::{Liveness, Patience, Pulse, StartPatience, StartPulse, StartWatch, Watch};
use protocol::launch::{self, EVENT_FD, PATHS_FD, STATUS_FD, STORE_FD};
use protocol::status::read_started;
use protocol::{Head, Incarnation, JobId, Launch, MessageKind, Reject, RequestId};
use runtime::counters::{HardwareCounters, HardwareCounts};
use runtime::{Child, EventFd, Exit, OsError, SealedMemory, Spawn, StatusMemory, WrittenWords};
use runtime::{futex, process};
use transport::{CoordinatorLink, Domain, OpenError, Sizes, Traffic, UseError};

/// How long a worker that has ended, or was killed, is waited for (ms).
const END_MS: u64 = 1_000;

/// The coordinator's handle of one worker.
#[derive(Debug)]
pub(super) struct WorkerHandle {
    pub(super) who: Incarnation,
    pub(super) report: WorkerReport,
    link: CoordinatorLink,
    child: Child,
    watch: Watch,
    is_alive: bool,
    /// Whether its channels work and it takes jobs.
    pub(super) has_greeted: bool,
    /// How its start goes, until it has greeted.
    start_watch: StartWatch,
    /// Corruption of the next batch, where faults are injected.
    #[cfg(feature = "faults")]
    pub(super) corruption: Option<super::Corruption>,
    /// Messages taken. The status page only shows it: other processes can write there.
    taken: u64,
    /// Batches known to be answered.
    answered: u64,
    /// Number of the next batch: all below were sent.
    batches: u64,
    /// Whether messages wait until it takes some of what it was sent.
    pub(super) has_backlog: bool,
    seq: u32,
    /// Counts before this request: of the worker, and at both ends of its channels.
    before: Before,
    /// Hardware counters with their counts before this request, or why there are none.
    counters: Result<(HardwareCounters, HardwareCounts), Hardware>,
    /// Kept open: the worker holds the other end.
    _wake_fd: EventFd,
}

/// Counts at the start of a request.
#[derive(Clone, Copy, Debug, Default)]
struct Before {
    jobs: u64,
    tests: u64,
    sent: Traffic,
    taken: Traffic,
}

/// A worker that could not be opened.
#[derive(Debug)]
pub(super) enum StartError {
    System(OsError),
    Open(OpenError),
}

impl From<OsError> for StartError {
    fn from(error: OsError) -> Self {
        Self::System(error)
    }
}

impl From<OpenError> for StartError {
    fn from(error: OpenError) -> Self {
        Self::Open(error)
    }
}

impl From<StartError> for super::WorkerPoolError {
    fn from(error: StartError) -> Self {
        match error {
            StartError::System(error) => Self::System(error),
            StartError::Open(error) => Self::Open(error),
        }
    }
}

impl WorkerHandle {
    /// Creates the channels, then starts the process that opens them.
    pub(super) fn start(
        launch: &Launch,
        domain: &Domain,
        options: &Options,
        core: Option<usize>,
        (store, status, paths): (&SealedMemory, &StatusMemory, &WrittenWords),
        wake_fd: EventFd,
        spawn: fn(Spawn<'_>) -> Result<Child, OsError>,
    ) -> Result<Self, StartError> {
        let sizes = Sizes {
            job_words: launch.batch_words(),
            job_queue: launch.batches(),
            result_words: launch::RESULT_WORDS,
            result_queue: launch::RESULTS,
        };
        let link = CoordinatorLink::create(domain, launch.who, &sizes, &options.build)?;
        let args = ["worker".to_owned(), launch.to_word()];
        let fds = [
            (store.fd(), STORE_FD),
            (status.fd(), STATUS_FD),
            (wake_fd.fd(), EVENT_FD),
            (paths.fd(), PATHS_FD),
        ];
        // Nobody waits until it runs: its greeting shows that.
        let child = spawn(Spawn { program: &options.program, args: &args, fds: &fds, core })?;
        let report = WorkerReport {
            worker: launch.who.worker,
            pid: child.pid(),
            core,
            jobs: 0,
            tests: 0,
            batches: 0,
            batch_bytes: 0,
            batch_lines: 0,
            results: 0,
            result_bytes: 0,
            result_lines: 0,
            busy_ns: 0,
            spans: Vec::new(),
            hardware: Hardware::Counted { instructions: 0, cache_misses: 0 },
            lost: None,
        };
        let counters = HardwareCounters::of(child.pid()).map_err(Hardware::from);
        Ok(Self {
            who: launch.who,
            report,
            link,
            child,
            watch: Watch::default(),
            is_alive: true,
            has_greeted: false,
            start_watch: StartWatch::new(runtime::clock::now_ns()),
            #[cfg(feature = "faults")]
            corruption: None,
            taken: 0,
            answered: 0,
            batches: 0,
            has_backlog: false,
            seq: 0,
            before: Before::default(),
            counters: counters.map(|counters| (counters, HardwareCounts::default())),
            _wake_fd: wake_fd,
        })
    }

    pub(super) fn child(&self) -> &Child {
        &self.child
    }

    pub(super) fn is_alive(&self) -> bool {
        self.is_alive
    }

    /// Whether it takes jobs.
    pub(super) fn is_ready(&self) -> bool {
        self.is_alive && self.has_greeted
    }

    /// Whether it was started and has not greeted yet.
    pub(super) fn is_starting(&self) -> bool {
        self.is_alive && !self.has_greeted
    }

    /// Whether it holds batches that it has not answered, of this request or an earlier one, or
    /// its queue is full.
    pub(super) fn is_busy(&self, status: &StatusMemory) -> bool {
        let answered = status.page().workers[self.line()].answered.load(Ordering::SeqCst);
        self.is_alive && (answered < self.batches || self.has_backlog)
    }

    /// Number of batches answered, if not yet passed on.
    pub(super) fn newly_answered(&self, status: &StatusMemory) -> Option<u64> {
        let line = &status.page().workers[self.line()];
        let answered = line.answered.load(Ordering::SeqCst);
        let is_new = answered > self.answered && answered <= self.batches;
        (self.is_alive && is_new).then_some(answered)
    }

    /// Notes that this number of answered batches was passed on.
    pub(super) fn note_answered(&mut self, answered: u64) -> u32 {
        self.answered = answered;
        answered.min(u64::from(u32::MAX)) as u32
    }

    fn line(&self) -> usize {
        usize::from(self.who.worker)
    }

    /// Restarts the counts from zero.
    pub(super) fn begin(&mut self, status: &StatusMemory) {
        self.before = self.counted(status);
        if let Ok((counters, before)) = &mut self.counters {
            // What cannot be read now cannot be read at the end either, and is reported then.
            *before = counters.read().unwrap_or_default();
        }
        self.report.busy_ns = 0;
        self.report.spans.clear();
    }

    fn counted(&self, status: &StatusMemory) -> Before {
        let line = &status.page().workers[self.line()];
        Before {
            jobs: line.jobs.load(Ordering::Relaxed),
            tests: line.tests.load(Ordering::Relaxed),
            sent: self.link.jobs.traffic(),
            taken: self.link.results.traffic(),
        }
    }

    /// The counts since then, with those that the worker reports.
    pub(super) fn report(&self, status: &StatusMemory) -> WorkerReport {
        let (now, before) = (self.counted(status), &self.before);
        WorkerReport {
            jobs: now.jobs.saturating_sub(before.jobs),
            tests: now.tests.saturating_sub(before.tests),
            batches: now.sent.messages - before.sent.messages,
            batch_bytes: now.sent.bytes - before.sent.bytes,
            batch_lines: now.sent.lines - before.sent.lines,
            results: now.taken.messages - before.taken.messages,
            result_bytes: now.taken.bytes - before.taken.bytes,
            result_lines: now.taken.lines - before.taken.lines,
            hardware: self.hardware(),
            ..self.report.clone()
        }
    }
    fn hardware(&self) -> Hardware {
        let (counters, before) = match &self.counters {
            Ok((counters, before)) => (counters, before),
            Err(why) => return why.clone(),
        };
        counters.read().map_or_else(Hardware::from, |now| Hardware::Counted {
            instructions: now.instructions.saturating_sub(before.instructions),
            cache_misses: now.cache_misses.saturating_sub(before.cache_misses),
        })
    }

    /// Why its program could not be run, if that is so.
    pub(super) fn exec_error(&mut self) -> Option<OsError> {
        self.child.exec_error()
    }

    /// The verdict on a worker that has not greeted and must be killed.
    pub(super) fn start_pulse(&mut self, now: u64, patience: &StartPatience) -> Option<Liveness> {
        // One that has ended is reported by its pidfd.
        let stat = process::stat(self.report.pid)?;
        let pulse = StartPulse {
            cpu_ns: stat.cpu_ns,
            stopped: matches!(stat.state, 'T' | 't'),
            runnable: matches!(stat.state, 'R' | 'D'),
        };
        let verdict = self.start_watch.look(pulse, now, patience);
        (verdict != Liveness::Alive).then_some(verdict)
    }

    /// How it ended, if it has.
    pub(super) fn exit(&mut self) -> Result<Option<Exit>, OsError> {
        self.child.try_wait()
    }

    /// Waits for the end of a process that was reported ended or killed; `None`: it is still alive.
    pub(super) fn wait_end(&mut self) -> Result<Option<Exit>, OsError> {
        let exit = self.child.wait_ms(END_MS)?;
        if let (Some(exit), None) = (exit, &self.report.lost) {
            self.report.lost = Some(exit.to_string());
        }
        Ok(exit)
    }

    pub(super) fn send(
        &mut self,
        status: &StatusMemory,
        head: Head,
        words: &[u64],
    ) -> Result<(), UseError> {
        if !self.is_alive {
            return Err(UseError::Broken);
        }
        let mut message = self.link.jobs.loan()?;
        message.words().get_mut(..words.len()).ok_or(UseError::Broken)?.copy_from_slice(words);
        let sealed = Head { seq: self.seq, ..head };
        #[cfg(not(feature = "faults"))]
        message.send(sealed, words.len())?;
        #[cfg(feature = "faults")]
        super::inject::send(self.corruption.take(), message, sealed, words.len())?;
        self.seq = self.seq.wrapping_add(1);
        if head.kind == MessageKind::Batch as u8 {
            if !self.is_busy(status) {
                // It had nothing to do until now: its silence is measured from here.
                self.watch = Watch::default();
            }
            self.batches = u64::from(head.job) + 1;
        }
        self.wake(status);
        Ok(())
    }

    /// Changes the futex word, and wakes the worker if it sleeps on it.
    fn wake(&self, status: &StatusMemory) {
        let page = status.page();
        let word = &page.coordinator[self.line()].wake;
        word.fetch_add(1, Ordering::SeqCst);
        if page.workers[self.line()].sleeping.load(Ordering::SeqCst) == 1 {
            futex::wake(word);
        }
    }

    /// Whether the worker has sent more than was taken.
    pub(super) fn has_mail(&self, status: &StatusMemory) -> bool {
        let page = status.page();
        let sent = page.workers[self.line()].sent.load(Ordering::SeqCst);
        let waiting = sent.wrapping_sub(self.taken).cast_signed();
        // A worker sends, and then counts. Interrupted in between, it has sent one more than it
        // says: if that were mail, a coordinator of higher priority would look for it forever, and
        // on the same core it would never let the worker run.
        //
        // A count that is too high is no mail, or a corrupted one would never let this sleep.
        self.is_alive && (1..=launch::RESULTS as i64).contains(&waiting)
    }

    /// What is impossible about its line on the status page, which any process of the run can
    /// write.
    pub(super) fn impossible(&self, status: &StatusMemory) -> Option<&'static str> {
        let line = &status.page().workers[self.line()];
        let waiting = line.sent.load(Ordering::SeqCst).wrapping_sub(self.taken).cast_signed();
        if !self.is_alive {
            None
        } else if waiting > launch::RESULTS as i64 {
            Some("it says that it sent more than fits in its queue")
        } else if line.answered.load(Ordering::SeqCst) > self.batches {
            Some("it says that it answered more than it was sent")
        } else {
            None
        }
    }

    /// Writes the coordinator's line again: whatever else was written there is gone.
    pub(super) fn restore(&self, status: &StatusMemory, cancelled: u64) {
        let line = &status.page().coordinator[self.line()];
        line.consumed.store(self.taken, Ordering::Release);
        line.cancelled.store(cancelled, Ordering::SeqCst);
        if self.is_alive {
            line.stop.store(0, Ordering::SeqCst);
        }
    }

    /// Takes one message, giving its credit back.
    pub(super) fn take(
        &mut self,
        status: &StatusMemory,
        scratch: &mut Vec<u64>,
    ) -> Result<Option<Result<Head, Reject>>, UseError> {
        // Until it has opened its channels, it may still be making what this end would open.
        let is_open = self.has_greeted || status.page().workers[self.line()].has_opened();
        if !self.is_alive || !is_open {
            return Ok(None);
        }
        let taken = self.link.results.take(scratch)?;
        if taken.is_some() {
            self.taken += 1;
            status.page().coordinator[self.line()].consumed.store(self.taken, Ordering::Release);
        }
        Ok(taken)
    }

    /// The verdict on a worker that must be killed.
    pub(super) fn pulse(
        &mut self,
        status: &StatusMemory,
        now: u64,
        patience: &Patience,
    ) -> Option<Liveness> {
        if !self.is_busy(status) {
            self.watch = Watch::default();
            return None;
        }
        let stat = process::stat(self.report.pid)?;
        let beat = status.page().workers[self.line()].beat.load(Ordering::Relaxed);
        let stopped = matches!(stat.state, 'T' | 't');
        let pulse = Pulse { beat, cpu_ns: stat.cpu_ns, stopped, busy: true };
        let verdict = self.watch.look(pulse, now, patience);
        (verdict != Liveness::Alive).then_some(verdict)
    }

    /// Kills it, and remembers why.
    pub(super) fn kill(&mut self, why: &str) {
        self.report.lost = Some(format!("SIGKILL by the coordinator: {why}"));
        if let Err(error) = self.child.kill() {
            tracing::debug!(%error, "cannot kill a worker");
        }
    }

    /// Closes its channels. Returns what it had started.
    pub(super) fn close(
        &mut self,
        status: &StatusMemory,
        request: u64,
    ) -> (Incarnation, Option<(JobId, u8)>) {
        self.is_alive = false;
        let started = status.page().workers[self.line()].started.load(Ordering::SeqCst);
        (self.who, read_started(started, self.who, RequestId(request)))
    }

    pub(super) fn tell_to_stop(&self, status: &StatusMemory) {
        status.page().coordinator[self.line()].stop.store(1, Ordering::SeqCst);
        self.wake(status);
    }

    /// Gives it `timeout_ms` to end, then kills it.
    pub(super) fn terminate(&mut self, timeout_ms: u64) {
        match self.child.wait_ms(timeout_ms) {
            Ok(Some(_)) => {}
            Ok(None) | Err(_) => {
                tracing::debug!(worker = self.who.worker, "did not end by itself: killed");
                if let Err(error) = self.child.kill() {
                    tracing::debug!(%error, "cannot kill a worker");
                }
            }
        }
    }
}
