//! What comes from the workers: parts of results, failures, greetings, counts of answered batches.
//!
//! A message that was damaged on the way is counted, and what it held is asked for again. One that
//! is sound and says what cannot be ends its sender. Whether a part is still wanted is not known
//! here: the dispatcher's fence decides that.

use super::{Observation, WorkerPool};
use crate::gather::{Part, Rest};
use crate::work::{PartOf, TaskSource};
use dispatch::{Effect, Event, Progress};
use protocol::result::{read_hits, read_last};
use protocol::{Head, JobId, MessageKind, Reject, RequestId};
use runtime::clock;

impl WorkerPool {
    /// Takes all results there are by now. Says whether there was one.
    pub(super) fn take_results<W: TaskSource>(
        &mut self,
        work: &mut W,
        effects: &mut Vec<Effect>,
        mut progress: Progress,
    ) -> (bool, Progress) {
        let mut any = false;
        for number in 0..self.workers.len() {
            // Read before the channel is emptied: what was sent for these batches is in it by now.
            let answered = self.workers[number].newly_answered(&self.status);
            while let Some(after) = self.take_one(number, work, effects) {
                (any, progress) = (true, after);
                // However fast results come, the answer is due when it is due.
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

    /// One sound message, and what follows from it.
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
                        self.distrust(number, "counts that do not fit");
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

    /// A message was turned away. What it held is not known; the dispatcher finds out what is
    /// missing when its sender has answered all it had, and counts.
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
        tracing::warn!(worker = number, why = %reject, "message turned away");
        self.rejected += 1;
        self.step(Event::Garbled { from }, work, effects)
    }

    /// A message that is sound and says what cannot be: its sender ends, and all that it had goes
    /// to the others.
    fn distrust(&mut self, number: usize, why: &str) {
        tracing::warn!(worker = number, why, "message turned away: killing its sender");
        self.rejected += 1;
        self.workers[number].kill(&format!("sent a message that was turned away: {why}"));
    }
}

/// What a message holds of a result; `None` if counts and words do not fit.
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
