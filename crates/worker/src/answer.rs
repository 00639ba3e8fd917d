//! Writes the hits of one job into shared memory as the kernel finds them.

#[cfg(feature = "faults")]
use crate::fault::{self, Corruption};
use bvh::{Counters, NodePair, Sink};
use core::cell::Cell;
use core::ops::ControlFlow;
use core::sync::atomic::Ordering;
use crossbeam::utils::Backoff;
use executor::{Done, hit};
use protocol::result::{WireEnd, WireSeen, write_hit, write_last, write_rest, write_seen};
use protocol::{CoordinatorLine, Head, Incarnation, MessageKind, RequestId, Summary, WireJob};
use protocol::{WorkerLine, launch, status};
use runtime::clock;
use transport::{OpenMessage, Sender, UseError};

/// Where results are sent, and the status line that reports them.
pub(crate) struct Outlet<'w> {
    pub(crate) sender: &'w Sender,
    pub(crate) line: &'w WorkerLine,
    pub(crate) coordinator: &'w CoordinatorLine,
    pub(crate) wake_event: &'w runtime::EventFd,
    pub(crate) who: Incarnation,
    pub(crate) boot: protocol::Boot,
    /// Messages sent. The status page only shows it: other processes can write there.
    pub(crate) sent: Cell<u64>,
    /// Corruption of the next result, where faults are injected.
    #[cfg(feature = "faults")]
    pub(crate) corruption: Cell<Option<Corruption>>,
}

impl<'w> Outlet<'w> {
    /// Waits for a credit, then loans a message; `None` if the worker is to stop.
    pub(crate) fn open(&self) -> Result<Option<OpenMessage<'w>>, UseError> {
        let backoff = Backoff::new();
        loop {
            // More taken than sent is a corrupted count, which the coordinator restores. A message
            // too many finds the queue full, and this worker ends.
            let taken = self.coordinator.consumed.load(Ordering::Acquire);
            let waiting = self.sent.get().wrapping_sub(taken).cast_signed();
            if waiting < launch::RESULTS as i64 {
                return self.sender.loan().map(Some);
            }
            if self.coordinator.stop.load(Ordering::Acquire) == 1 {
                return Ok(None);
            }
            // The coordinator still takes a cancelled request's results, so there will be credit.
            self.line.beat.fetch_add(1, Ordering::Relaxed);
            self.notify();
            backoff.snooze();
        }
    }

    /// Whether the jobs of a request are still wanted.
    pub(crate) fn is_wanted(&self, request: RequestId) -> bool {
        self.coordinator.stop.load(Ordering::Relaxed) != 1
            && self.coordinator.cancelled.load(Ordering::Relaxed) < request.0
    }

    pub(crate) fn head(&self, request: RequestId, kind: MessageKind) -> Head {
        Head::new(self.boot, request, self.who, kind)
    }

    pub(crate) fn send(
        &self,
        message: OpenMessage<'_>,
        head: Head,
        used: usize,
    ) -> Result<(), UseError> {
        let seq = (self.sent.get() & 0xffff_ffff) as u32;
        let head = Head { seq, ..head };
        #[cfg(not(feature = "faults"))]
        message.send(head, used)?;
        #[cfg(feature = "faults")]
        fault::send(self.corruption.take(), message, head, used)?;
        self.line.bytes.fetch_add(64 + 8 * used as u64, Ordering::Relaxed);
        // A coordinator that counts this message sees all that preceded it.
        self.sent.set(self.sent.get() + 1);
        self.line.sent.store(self.sent.get(), Ordering::SeqCst);
        Ok(())
    }

    /// Sends a message without payload, and wakes the coordinator.
    pub(crate) fn tell(&self, head: Head) -> Result<(), UseError> {
        if let Some(message) = self.open()? {
            self.send(message, head, 0)?;
        }
        self.notify();
        Ok(())
    }

    /// Wakes the coordinator if it sleeps. Not called for every result: a wake-up takes as long as
    /// some jobs, and until the batch is done this worker is busy anyway.
    pub(crate) fn notify(&self) {
        if self.coordinator.sleeping.load(Ordering::SeqCst) == 1 {
            self.wake_event.notify();
        }
    }
}

/// The result of one job while it is being written.
pub(crate) struct Answer<'w> {
    outlet: &'w Outlet<'w>,
    request: RequestId,
    job: WireJob,
    message: Option<OpenMessage<'w>>,
    hits: usize,
    hits_before: u32,
    part: u16,
    /// Tests of this job already added to the status line.
    tests: u64,
    fault: Option<UseError>,
}

impl<'w> Answer<'w> {
    pub(crate) fn new(outlet: &'w Outlet<'w>, request: RequestId, job: WireJob) -> Self {
        Self {
            outlet,
            request,
            job,
            message: None,
            hits: 0,
            hits_before: 0,
            part: 0,
            tests: 0,
            fault: None,
        }
    }

    fn head(&self, last: bool) -> Head {
        Head {
            job: self.job.job,
            attempt: self.job.attempt as u8,
            part: self.part,
            count: u16::from(last),
            hits: self.hits as u32,
            ..self.outlet.head(self.request, MessageKind::Result)
        }
    }

    /// Sends the current part, full of hits.
    fn turn_over(&mut self) -> Result<(), UseError> {
        let Some(message) = self.message.take() else { return Ok(()) };
        self.outlet.send(message, self.head(false), self.hits.div_ceil(2))?;
        self.part += 1;
        self.hits_before += self.hits as u32;
        self.hits = 0;
        Ok(())
    }

    fn put(&mut self, hit: u32) -> Result<bool, UseError> {
        for _ in 0..2 {
            if self.message.is_none() {
                self.message = self.outlet.open()?;
            }
            let Some(message) = &mut self.message else { return Ok(false) };
            if write_hit(message.words(), self.hits, hit) {
                self.hits += 1;
                return Ok(true);
            }
            self.turn_over()?;
        }
        Ok(false)
    }

    /// Abandons the job: nothing more is sent.
    pub(crate) fn abandon(self) -> Result<(), UseError> {
        self.fault.map_or(Ok(()), Err)
    }

    /// Sends what the job left open, in as many parts as needed.
    fn leave(&mut self, rest: &[NodePair]) -> Result<(), UseError> {
        let mut first = 0;
        self.turn_over()?;
        while first < rest.len() {
            let Some(mut message) = self.outlet.open()? else { return Ok(()) };
            let pairs = rest[first..].iter().map(|pair| (pair.a, pair.b));
            let count = write_rest(message.words(), first, pairs);
            let head =
                Head { hits: count as u32, kind: MessageKind::Rest as u8, ..self.head(false) };
            self.outlet.send(message, head, 1 + count)?;
            self.part += 1;
            first += count;
        }
        Ok(())
    }

    /// Sends what is left open, then the last part.
    pub(crate) fn finish(
        mut self,
        done: &Done,
        rest: &[NodePair],
        started_ns: u64,
    ) -> Result<(), UseError> {
        if let Some(fault) = self.fault {
            return Err(fault);
        }
        // Before anything waits for a credit: waiting does not count as the job's time.
        let wall_ns = clock::now_ns() - started_ns;
        if !rest.is_empty() {
            self.leave(rest)?;
        }
        if self.message.is_none() {
            self.message = self.outlet.open()?;
        }
        let Some(mut message) = self.message.take() else { return Ok(()) };
        let summary = done.summary(self.hits_before + self.hits as u32, wall_ns);
        let used = write_last(message.words(), self.hits, &summary, done.supports());
        self.send_last(message, used)
    }

    /// Sends what a look showed.
    pub(crate) fn finish_look(
        self,
        seen: &WireSeen,
        Counters { nb, np }: Counters,
        started_ns: u64,
    ) -> Result<(), UseError> {
        let wall_ns = clock::now_ns() - started_ns;
        let Some(mut message) = self.outlet.open()? else { return Ok(()) };
        let end = WireEnd::Complete as u32;
        let summary = Summary { nb, np, wall_ns, end, ..Summary::default() };
        let used = write_seen(message.words(), &summary, seen);
        self.send_last(message, used)
    }

    fn send_last(&self, message: OpenMessage<'_>, used: usize) -> Result<(), UseError> {
        let head = self.head(true);
        #[cfg(feature = "faults")]
        let Some(message) = fault::last(self.outlet, message, head, used)? else {
            return Ok(());
        };
        self.outlet.send(message, head, used)
    }
}

impl Sink for Answer<'_> {
    fn hit(&mut self, side: bvh::Side, triangle: u32) -> ControlFlow<()> {
        match self.put(hit(side, triangle)) {
            Ok(true) => ControlFlow::Continue(()),
            Ok(false) => ControlFlow::Break(()),
            Err(fault) => {
                self.fault = Some(fault);
                ControlFlow::Break(())
            }
        }
    }

    fn beat(&mut self, tests: u64) -> ControlFlow<()> {
        self.outlet.line.beat.fetch_add(1, Ordering::Relaxed);
        self.outlet.line.tests.fetch_add(tests - self.tests, Ordering::Relaxed);
        self.tests = tests;
        if self.outlet.is_wanted(self.request) {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    }
}

/// Marks a job as started for as long as it lives, so that a crash is blamed on the right job.
pub(crate) struct Started<'w>(&'w WorkerLine);

impl<'w> Started<'w> {
    pub(crate) fn new(outlet: &Outlet<'w>, request: RequestId, job: &WireJob) -> Self {
        let number = protocol::JobId(job.job);
        let word = status::started(outlet.who, request, number, job.attempt as u8);
        outlet.line.started.store(word, Ordering::SeqCst);
        outlet.line.beat.fetch_add(1, Ordering::Relaxed);
        Self(outlet.line)
    }
}

impl Drop for Started<'_> {
    fn drop(&mut self) {
        self.0.started.store(0, Ordering::SeqCst);
        self.0.jobs.fetch_add(1, Ordering::Relaxed);
    }
}
