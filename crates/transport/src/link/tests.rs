//! Both ends of a link in one process, each with a node of its own.

use super::*;
use crate::error::UseError;
use protocol::{Boot, Head, Kind, Reject, RequestId};

const PEER: Incarnation = Incarnation { worker: 3, inc: 7 };
const SIZES: Sizes = Sizes { job_words: 300, job_queue: 4, result_words: 500, result_queue: 2 };
const BUILD: &str = "test-build";

/// A domain of its own for each test, seen from both sides.
pub(crate) fn pair(instance: &str, boot: u64) -> (CoordinatorLink, WorkerLink) {
    let domain = Domain::create(instance, Boot(boot)).unwrap();
    let coordinator = CoordinatorLink::create(&domain, PEER, &SIZES, BUILD).unwrap();
    let entered = Domain::open(domain.text()).unwrap();
    assert_eq!(entered.boot(), Boot(boot));
    let worker = WorkerLink::open(&entered, PEER, &SIZES, BUILD).unwrap();
    coordinator.connect().unwrap();
    (coordinator, worker)
}

fn head(boot: u64, kind: Kind) -> Head {
    Head::new(Boot(boot), RequestId(1), PEER, kind)
}

fn send(sender: &Sender, head: Head, words: &[u64]) -> Result<(), UseError> {
    let mut message = sender.loan()?;
    message.words()[..words.len()].copy_from_slice(words);
    message.send(head, words.len())
}

#[test]
fn what_is_sent_arrives_in_order_and_whole() {
    let (coordinator, worker) = pair("order", 1);
    let mut scratch = Vec::new();
    for round in 0..50_u64 {
        let batch: Vec<u64> = (0..round * 6).map(|i| i * i + round).collect();
        send(&coordinator.jobs, head(1, Kind::Batch), &batch).unwrap();
        let got = worker.jobs.take(&mut scratch).unwrap().unwrap().unwrap();
        assert_eq!((got.seq, got.len, got.kind), (round as u32, batch.len() as u32, 1));
        assert_eq!(scratch, batch);
        assert!(worker.jobs.take(&mut scratch).unwrap().is_none());

        for part in 0..2 {
            let head = Head { part, ..head(1, Kind::Result) };
            send(&worker.results, head, &[round, u64::from(part)]).unwrap();
        }
        for part in 0..2 {
            let got = coordinator.results.take(&mut scratch).unwrap().unwrap().unwrap();
            assert_eq!((got.part, scratch.as_slice()), (part, [round, u64::from(part)].as_slice()));
        }
    }
    let bytes = 50 * 64 + 8 * (0..50).map(|round| round * 6).sum::<u64>();
    assert_eq!(coordinator.jobs.traffic(), crate::Traffic { messages: 50, bytes });
    assert_eq!(worker.jobs.traffic(), coordinator.jobs.traffic());
    assert_eq!(worker.results.traffic(), coordinator.results.traffic());
}
