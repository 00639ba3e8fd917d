//! What comes from the workers: parts of results, failures, greetings, counts of answered batches.
//!
//! A message damaged on the way is counted, and what it held is requested again. A sound message
//! with impossible contents ends its sender. Whether a part is still wanted is decided by the
//! dispatcher's fence, not here.

use super::{Observation, WorkerPool};
use crate::gather::{Part, Rest};
use crate::work::{PartOf, TaskSource};
use dispatch::{Effect, Event, Progress};
use protocol::result::{read_hits, read_last};
use protocol::{Head, JobId, MessageKind, Reject, RequestId, launch};
use runtime::clock;

impl WorkerPool {
    /// Takes all available results. Returns whether there was one.
    pub(super) fn take_results<W: TaskSource>(
        &mut self,
        work: &mut W,
        effects: &mut Vec<Effect>,
        mut progress: Progress,
    ) -> (bool, Progress) {
        let mut any = false;
        for number in 0..self.workers.len() {
            // Read before the channel is drained: what was sent for these batches is already in it.
            let answered = self.workers[number].newly_answered(&self.status);
            // At most what the channel holds: a worker that sends without end keeps nobody waiting.
            for _ in 0..launch::RESULTS {
                let Some(after) = self.take_one(number, work, effects) else { break };
                (any, progress) = (true, after);
                // However fast results come, the deadline holds.
                if work.is_over(clock::now_ns()) {
                    return (any, progress);
                }
            }
            let Some(answered) = answered else { continue };
            let batches = self.workers[number].note_answered(answered);
            let (who, before) = (self.workers[number].who, self.dispatcher.counts().reissued);
            progress = self.step(Event::Answered { who, batches }, work, effects);
            if self.dispatcher.counts().reissued > before {
                self.observe(who, Observation::Unanswered);
            }
        }
        (any, progress)
    }

    /// Takes one message from one worker; `None` if there is none.
    pub(super) fn take_one<W: TaskSource>(
        &mut self,
        number: usize,
        work: &mut W,
        effects: &mut Vec<Effect>,
    ) -> Option<Progress> {
        let mut scratch = std::mem::take(&mut self.scratch);
        let begun_ns = clock::now_ns();
        let taken = self.workers[number].take(&self.status, &mut scratch);
        if matches!(taken, Ok(Some(_))) {
            self.duty.take_ns += clock::now_ns() - begun_ns;
        }
        let progress = match taken {
            Ok(Some(Ok(head))) => Some(self.take_message(number, &head, &scratch, work, effects)),
            Ok(Some(Err(reject))) => Some(self.turn_away(number, reject, work, effects)),
            Ok(None) | Err(_) => None,
        };
        self.scratch = scratch;
        progress
    }

    /// Handles one sound message.
    fn take_message<W: TaskSource>(
        &mut self,
        number: usize,
        head: &Head,
        words: &[u64],
        work: &mut W,
        effects: &mut Vec<Effect>,
    ) -> Progress {
        let (from, job) = (self.workers[number].who, JobId(head.job));
        let request = RequestId(head.request);
        let event = match MessageKind::from_number(head.kind) {
            Some(kind @ (MessageKind::Result | MessageKind::Rest)) => {
                match read_part(kind, head, words) {
                    Some(part) => return self.take_part(number, head, part, work, effects),
                    None => {
                        self.distrust(number, "counts that do not match");
                        Event::Poll
                    }
                }
            }
            Some(MessageKind::Nack) => {
                tracing::warn!(worker = number, job = head.job, "a job failed");
                self.observe(from, Observation::Failed);
                Event::Failed { from, request, job, attempt: head.attempt }
            }
            Some(MessageKind::Hello) => {
                self.workers[number].has_greeted = true;
                Event::Ready(from)
            }
            Some(MessageKind::Batch | MessageKind::Section) | None => Event::Poll,
        };
        self.step(event, work, effects)
    }

    /// Hands a part of a result to the dispatcher, which knows whether it is still wanted.
    fn take_part<W: TaskSource>(
        &mut self,
        number: usize,
        head: &Head,
        part: Part<'_>,
        work: &mut W,
        effects: &mut Vec<Effect>,
    ) -> Progress {
        let worker = &mut self.workers[number];
        if let (Some(last), true) = (&part.last, head.request == self.request) {
            worker.report.busy_ns += last.summary.wall_ns;
            worker.report.spans.push([clock::now_ns(), last.summary.wall_ns]);
        }
        let from = worker.who;
        let event = Event::Part {
            from,
            request: RequestId(head.request),
            job: JobId(head.job),
            attempt: head.attempt,
            part: head.part,
            last: part.last.is_some(),
            body: PartOf(part),
        };
        let before = self.dispatcher.counts().fence;
        let progress = self.step(event, work, effects);
        if self.dispatcher.counts().fence != before {
            self.observe(from, Observation::Fenced);
        }
        progress
    }

    /// Handles a rejected message. What it held is unknown; the dispatcher finds out by counting
    /// what is missing once its sender has answered everything.
    fn turn_away<W: TaskSource>(
        &mut self,
        number: usize,
        reject: Reject,
        work: &mut W,
        effects: &mut Vec<Effect>,
    ) -> Progress {
        let from = self.workers[number].who;
        self.observe(from, Observation::TurnedAway(reject));
        if reject == Reject::NotOwner {
            self.distrust(number, &reject.to_string());
            return self.step(Event::Poll, work, effects);
        }
        tracing::warn!(worker = number, why = %reject, "message rejected");
        self.rejected += 1;
        self.step(Event::Garbled { from }, work, effects)
    }

    /// Handles a sound message with impossible contents: its sender is killed, and its jobs go to
    /// the others.
    fn distrust(&mut self, number: usize, why: &str) {
        tracing::warn!(worker = number, why, "message rejected: killing its sender");
        self.rejected += 1;
        self.workers[number].kill(&format!("sent a message that was rejected: {why}"));
    }
}

/// The part of a result that a message holds; `None` if counts and words do not match.
fn read_part<'w>(kind: MessageKind, head: &Head, words: &'w [u64]) -> Option<Part<'w>> {
    if kind == MessageKind::Rest {
        let fits = words.len() == 1 + head.hits as usize;
        return fits.then_some(Part { hits: &[], rest: Rest::Words(words), last: None });
    }
    if !head.is_last() {
        return Some(Part { hits: read_hits(words, head.hits)?, rest: Rest::NONE, last: None });
    }
    let last = read_last(words, head.hits)?;
    Some(Part { hits: last.hits, rest: Rest::NONE, last: Some(last) })
}
