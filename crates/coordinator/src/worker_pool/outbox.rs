//! What goes to the workers: batches of jobs, and before them the sections that a worker needs
//! copies of.
//!
//! A batch that does not fit in its channel is refused, and the dispatcher tries again; a worker
//! that copies has a queue here instead, because a batch must not overtake its sections.

use super::WorkerPool;
use super::chunk::chunks;
use crate::work::TaskSource;
use dispatch::{Effect, Event, Progress};
use protocol::job::{WireJob, write_batch};
use protocol::{Head, Incarnation, JobId, MessageKind, RequestId, Section, WireTask};
use transport::UseError;

/// Scratch for laying out batches.
#[derive(Debug, Default)]
pub(super) struct BatchWriter {
    tasks: Vec<WireTask>,
    jobs: Vec<WireJob>,
    words: Vec<u64>,
}

impl WorkerPool {
    /// Lays out a batch, and sends it after the sections that it needs.
    pub(super) fn send<W: TaskSource>(
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
            rows.push(WireJob {
                job: job.0,
                task: place as u32,
                node_a: spec.a.node,
                node_b: spec.b.node,
                budget: work.budget(),
                attempt: u32::from(*attempt),
                reserved: 0,
            });
        }
        write_batch(words, tasks, rows);
        let head = Head {
            job: batch,
            count: rows.len() as u16,
            ..Head::new(self.boot, RequestId(self.request), to, MessageKind::Batch)
        };
        let worker = &mut self.workers[usize::from(to.worker)];
        let Some(outgoing) = &mut self.outgoing else {
            return worker.send(&self.status, head, words);
        };
        let outgoing = &mut outgoing[usize::from(to.worker)];
        for section in fetch {
            let Some(body) = work.body(section.model) else { continue };
            let head = Head::new(self.boot, RequestId(self.request), to, MessageKind::Section);
            for chunk in chunks(&body, *section) {
                outgoing.push(head, chunk);
            }
        }
        outgoing.push(head, words.clone());
        outgoing.flush(worker, &self.status)
    }

    /// Sends what waits for capacity. Returns whether something still waits.
    pub(super) fn flush<W: TaskSource>(
        &mut self,
        work: &mut W,
        effects: &mut Vec<Effect>,
        mut progress: Progress,
    ) -> (bool, Progress) {
        let Some(outgoing) = &mut self.outgoing else { return (false, progress) };
        let mut broken = Vec::new();
        for (number, outgoing) in outgoing.iter_mut().enumerate() {
            let worker = &mut self.workers[number];
            if !worker.is_alive() {
                outgoing.clear(worker);
            } else if let Err(error) = outgoing.flush(worker, &self.status) {
                broken.push((number, error));
            }
        }
        let waits = outgoing.iter().any(|outgoing| !outgoing.is_empty());
        for (number, error) in broken {
            let (who, started) = self.give_up(number, error);
            progress = self.step(Event::Lost { who, started }, work, effects);
        }
        (waits, progress)
    }
}
