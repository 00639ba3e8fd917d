//! The queue of requests: each turn receives all pending ones, so that every client gets a reply.
//!
//! A client gets the answer to its own request, or none: requests of a client that disconnects are
//! released before the next one is received. A killed client does not disconnect; its successor is
//! safe because no two clients choose the same sequence numbers.

use crate::stats::Stats;
use protocol::public::{Ask, CLIENTS_MAX, Reason, WireAnswer, WireState};
use runtime::clock;
use std::collections::VecDeque;
use transport::{Server, TakenRequest, UseError};

/// Most requests that are taken at once: some for each client. What is left finds the queue full,
/// so the service does not sleep before it takes them.
const TAKEN_MAX: usize = 4 * CLIENTS_MAX;

/// A request to execute.
pub(crate) struct Taken {
    pub(crate) ask: Box<Ask>,
    /// When it was received (ns).
    pub(crate) taken_ns: u64,
}

/// The server's port, the waiting requests, and the one being executed.
pub(crate) struct RequestQueue {
    pub(crate) server: Server,
    pub(crate) stats: Stats,
    /// Each with the time of receipt (ns).
    waiting: VecDeque<(TakenRequest, u64)>,
    /// The request that [`RequestQueue::next`] returned; `None` also if its client is gone since.
    at_work: Option<TakenRequest>,
    capacity: usize,
}

impl RequestQueue {
    pub(crate) fn new(server: Server, stats: Stats, capacity: usize) -> Self {
        let waiting = VecDeque::with_capacity(capacity);
        Self { server, stats, waiting, at_work: None, capacity }
    }

    /// Receives every pending request; those that find the queue full are answered *busy* at once.
    pub(crate) fn drain(&mut self) {
        self.drain_while(|| {});
    }

    /// [`RequestQueue::drain`], with something that happens before each request is received.
    fn drain_while(&mut self, mut happens: impl FnMut()) {
        for _ in 0..TAKEN_MAX {
            happens();
            // Before iceoryx2 updates its connections: it identifies a client by its slot in a
            // table and a request by a number that every client counts afresh, so a request of a
            // client that is gone would pass for one of its successor.
            self.forget_unwanted();
            let asked = match self.server.take() {
                Ok(Some(asked)) => asked,
                Ok(None) => return,
                // Its client has just withdrawn others.
                Err(UseError::Full) if self.forget_unwanted() > 0 => continue,
                // The housekeeping thread cleans up a broken channel.
                Err(error) => {
                    tracing::debug!(%error, "a request could not be received");
                    return;
                }
            };
            if self.waiting.len() < self.capacity {
                self.waiting.push_back((asked, clock::now_ns()));
                continue;
            }
            let text = "the queue is full: ask again";
            let sequence = asked.sequence();
            let answer =
                WireAnswer::without_ranking(sequence, WireState::Busy, Reason::QueueFull, text);
            self.hand_over(asked, &answer);
        }
    }

    /// Releases requests whose clients no longer wait; returns how many.
    fn forget_unwanted(&mut self) -> usize {
        let held = |queue: &Self| queue.waiting.len() + usize::from(queue.at_work.is_some());
        let before = held(self);
        self.waiting.retain(|(asked, _)| asked.is_wanted());
        self.at_work.take_if(|asked| !asked.is_wanted());
        let forgotten = before - held(self);
        self.stats.withdrawn += forgotten as u64;
        forgotten
    }

    /// The next request whose client still waits. [Answer](Self::answer) it before the next call.
    pub(crate) fn next(&mut self) -> Option<Taken> {
        self.forget_unwanted();
        let (mut asked, taken_ns) = self.waiting.pop_front()?;
        let ask = asked.take_ask()?;
        self.at_work = Some(asked);
        Some(Taken { ask, taken_ns })
    }

    /// Answers the request that [`RequestQueue::next`] returned, if its client is still there.
    pub(crate) fn answer(&mut self, answer: &WireAnswer) {
        if let Some(asked) = self.at_work.take() {
            self.hand_over(asked, answer);
        }
    }

    fn hand_over(&mut self, asked: TakenRequest, answer: &WireAnswer) {
        match asked.answer(&answer.sealed()) {
            Ok(()) => self.stats.answered(answer.verdict()),
            // The client is gone.
            Err(_) => self.stats.withdrawn += 1,
        }
    }

    pub(crate) fn waiting(&self) -> usize {
        self.waiting.len()
    }
}

#[cfg(test)]
mod tests;
