//! Where requests are taken: all there are, each turn, so that nobody waits unheard.

use crate::stats::Stats;
use protocol::public::{Answer, Reason, Verdict};
use runtime::clock;
use std::collections::VecDeque;
use transport::{Asked, Server, UseError};

/// A request that waits.
pub(crate) struct Waiting {
    pub(crate) asked: Asked,
    /// When it was taken (ns).
    pub(crate) taken_ns: u64,
}

/// The server's port, and who waits before it.
pub(crate) struct Desk {
    pub(crate) server: Server,
    pub(crate) stats: Stats,
    waiting: VecDeque<Waiting>,
    capacity: usize,
}

impl Desk {
    pub(crate) fn new(server: Server, stats: Stats, capacity: usize) -> Self {
        Self { server, stats, waiting: VecDeque::with_capacity(capacity), capacity }
    }

    /// Takes every request there is; those that find the queue full are answered *busy* at once.
    pub(crate) fn drain(&mut self) {
        loop {
            let asked = match self.server.take() {
                Ok(Some(asked)) => asked,
                Ok(None) => return,
                // Its client gave others up that still wait here.
                Err(UseError::Full) if self.forget_unwanted() > 0 => continue,
                // What is being worked on for nobody ends soon; a broken channel is cleaned up.
                Err(error) => {
                    tracing::debug!(%error, "a request could not be taken");
                    return;
                }
            };
            let taken_ns = clock::now_ns();
            if self.waiting.len() < self.capacity {
                self.waiting.push_back(Waiting { asked, taken_ns });
                continue;
            }
            let text = "the queue is full: ask again";
            let sequence = asked.ask().sequence;
            let answer = Answer::without_ranking(sequence, Verdict::Busy, Reason::QueueFull, text);
            self.answer(asked, &answer);
        }
    }

    /// Lets go of requests that nobody wants any more; says how many.
    fn forget_unwanted(&mut self) -> usize {
        let before = self.waiting.len();
        self.waiting.retain(|waiting| waiting.asked.is_wanted());
        let forgotten = before - self.waiting.len();
        self.stats.withdrawn += forgotten as u64;
        forgotten
    }

    /// The next one whose client still waits.
    pub(crate) fn next(&mut self) -> Option<Waiting> {
        while let Some(waiting) = self.waiting.pop_front() {
            if waiting.asked.is_wanted() {
                return Some(waiting);
            }
            self.stats.withdrawn += 1;
        }
        None
    }

    /// Hands an answer over, and counts it.
    pub(crate) fn answer(&mut self, asked: Asked, answer: &Answer) {
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
