//! Where requests are taken: all there are, each turn, so that nobody waits unheard.
//!
//! Whoever asks gets the answer to what it asked, or none: what is held for a client that said
//! that it goes is let go before the next one is looked for. A client that was killed does not say;
//! one in its place is safe because no two clients choose the same sequence numbers.

use crate::stats::Stats;
use protocol::public::{Ask, Reason, WireAnswer, WireState};
use runtime::clock;
use std::collections::VecDeque;
use transport::{Server, TakenRequest, UseError};

/// A request that is to be worked off.
pub(crate) struct Taken {
    pub(crate) ask: Ask,
    /// When it was taken (ns).
    pub(crate) taken_ns: u64,
}

/// The server's port, who waits before it, and who is being attended to.
pub(crate) struct RequestQueue {
    pub(crate) server: Server,
    pub(crate) stats: Stats,
    /// With the time of taking (ns).
    waiting: VecDeque<(TakenRequest, u64)>,
    /// What [`RequestQueue::next`] gave out; `None` also if its client has gone since.
    at_work: Option<TakenRequest>,
    capacity: usize,
}

impl RequestQueue {
    pub(crate) fn new(server: Server, stats: Stats, capacity: usize) -> Self {
        let waiting = VecDeque::with_capacity(capacity);
        Self { server, stats, waiting, at_work: None, capacity }
    }

    /// Takes every request there is; those that find the queue full are answered *busy* at once.
    pub(crate) fn drain(&mut self) {
        loop {
            // Before iceoryx2 looks who is there: it knows a client by its place in a table and a
            // request by a number that every client begins anew, so that the request of one that
            // has gone would pass for the request of one that came in its place.
            self.forget_unwanted();
            let asked = match self.server.take() {
                Ok(Some(asked)) => asked,
                Ok(None) => return,
                // Its client gave others up, just now.
                Err(UseError::Full) if self.forget_unwanted() > 0 => continue,
                // A broken channel is cleaned up.
                Err(error) => {
                    tracing::debug!(%error, "a request could not be taken");
                    return;
                }
            };
            if self.waiting.len() < self.capacity {
                self.waiting.push_back((asked, clock::now_ns()));
                continue;
            }
            let text = "the queue is full: ask again";
            let sequence = asked.ask().sequence;
            let answer =
                WireAnswer::without_ranking(sequence, WireState::Busy, Reason::QueueFull, text);
            self.hand_over(asked, &answer);
        }
    }

    /// Lets go of requests that nobody wants any more; says how many.
    fn forget_unwanted(&mut self) -> usize {
        let held = |queue: &Self| queue.waiting.len() + usize::from(queue.at_work.is_some());
        let before = held(self);
        self.waiting.retain(|(asked, _)| asked.is_wanted());
        self.at_work.take_if(|asked| !asked.is_wanted());
        let forgotten = before - held(self);
        self.stats.withdrawn += forgotten as u64;
        forgotten
    }

    /// The next one whose client still waits: to be [answered](Self::answer) before the next.
    pub(crate) fn next(&mut self) -> Option<Taken> {
        self.forget_unwanted();
        let (asked, taken_ns) = self.waiting.pop_front()?;
        let ask = *asked.ask();
        self.at_work = Some(asked);
        Some(Taken { ask, taken_ns })
    }

    /// Answers what [`RequestQueue::next`] gave out, if its client is still there.
    pub(crate) fn answer(&mut self, answer: &WireAnswer) {
        if let Some(asked) = self.at_work.take() {
            self.hand_over(asked, answer);
        }
    }

    fn hand_over(&mut self, asked: TakenRequest, answer: &WireAnswer) {
        match asked.answer(answer) {
            Ok(()) => self.stats.answered(answer.verdict()),
            // The client has gone: nobody is left to tell.
            Err(_) => self.stats.withdrawn += 1,
        }
    }

    pub(crate) fn waiting(&self) -> usize {
        self.waiting.len()
    }
}

#[cfg(test)]
mod tests;
