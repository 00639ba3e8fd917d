//! Both ends of a link in one process, each with a node of its own.

use super::*;
use crate::error::UseError;
use protocol::head::MAGIC;
use protocol::{Boot, Head, MessageKind, Reject, RequestId};
use std::fs::File;
use std::os::unix::fs::{FileExt, MetadataExt};

const PEER: Incarnation = Incarnation { worker: 3, inc: 7 };
const SIZES: Sizes = Sizes { job_words: 300, job_queue: 4, result_words: 500, result_queue: 2 };
const BUILD: &str = "test-build";

/// A domain of its own for each test, seen from both sides.
fn pair(instance: &str, boot: u64) -> (CoordinatorLink, WorkerLink) {
    let domain = Domain::create(None, instance, Boot(boot)).unwrap();
    let coordinator = CoordinatorLink::create(&domain, PEER, &SIZES, BUILD).unwrap();
    let entered = Domain::open(domain.text()).unwrap();
    assert_eq!(entered.boot(), Boot(boot));
    let worker = WorkerLink::open(&entered, PEER, &SIZES, BUILD).unwrap();
    coordinator.connect().unwrap();
    (coordinator, worker)
}

fn head(boot: u64, kind: MessageKind) -> Head {
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
        send(&coordinator.jobs, head(1, MessageKind::Batch), &batch).unwrap();
        let got = worker.jobs.take(&mut scratch).unwrap().unwrap().unwrap();
        assert_eq!((got.seq, got.len, got.kind), (round as u32, batch.len() as u32, 1));
        assert_eq!(scratch, batch);
        assert!(worker.jobs.take(&mut scratch).unwrap().is_none());

        for part in 0..2 {
            let head = Head { part, ..head(1, MessageKind::Result) };
            send(&worker.results, head, &[round, u64::from(part)]).unwrap();
        }
        for part in 0..2 {
            let got = coordinator.results.take(&mut scratch).unwrap().unwrap().unwrap();
            assert_eq!((got.part, scratch.as_slice()), (part, [round, u64::from(part)].as_slice()));
        }
    }
    let bytes = 50 * 64 + 8 * (0..50).map(|round| round * 6).sum::<u64>();
    // 64 bytes of header wherever they lie, and payloads that begin anywhere in a line.
    let crate::Traffic { messages, bytes: sent, lines } = coordinator.jobs.traffic();
    assert_eq!((messages, sent), (50, bytes));
    assert!(lines >= bytes / 64 && lines <= bytes / 64 + 3 * 50, "{lines} lines for {bytes} bytes");
    assert_eq!(worker.jobs.traffic(), coordinator.jobs.traffic());
    assert_eq!(worker.results.traffic(), coordinator.results.traffic());
}

#[test]
fn cache_lines_are_those_that_are_touched() {
    for (address, bytes) in (0..130).flat_map(|a| (0..200).map(move |b| (a, b))) {
        let touched: std::collections::BTreeSet<usize> =
            (address..address + bytes).map(|byte| byte / 64).collect();
        assert_eq!(crate::lines(address, bytes), touched.len() as u64, "{bytes} at {address}");
    }
}

#[test]
fn a_full_queue_is_said_so_and_nobody_waits() {
    let (coordinator, worker) = pair("full", 2);
    let mut scratch = Vec::new();
    for _ in 0..3 {
        for job in 0..SIZES.job_queue as u64 {
            send(&coordinator.jobs, head(2, MessageKind::Batch), &[job]).unwrap();
        }
        for _ in 0..5 {
            // It does not block, although nothing is taken meanwhile.
            let refused = send(&coordinator.jobs, head(2, MessageKind::Batch), &[99]);
            assert_eq!(refused, Err(UseError::Full));
        }
        for job in 0..SIZES.job_queue as u64 {
            worker.jobs.take(&mut scratch).unwrap().unwrap().unwrap();
            assert_eq!(scratch, [job], "what was there first is not overwritten");
        }
        assert!(worker.jobs.take(&mut scratch).unwrap().is_none());
    }
    assert_eq!(coordinator.jobs.traffic().messages, 3 * SIZES.job_queue as u64);
}

#[test]
fn without_a_worker_nothing_is_handed_over() {
    let domain = Domain::create(None, "alone", Boot(3)).unwrap();
    let link = CoordinatorLink::create(&domain, PEER, &SIZES, BUILD).unwrap();
    assert_eq!(send(&link.jobs, head(3, MessageKind::Batch), &[1]), Err(UseError::Full));
    assert!(link.results.take(&mut Vec::new()).unwrap().is_none());
}

#[test]
fn one_message_is_open_at_a_time_and_a_dropped_one_was_never_there() {
    let (coordinator, worker) = pair("open", 4);
    let mut scratch = Vec::new();
    for round in 0..20 {
        let mut open = coordinator.jobs.loan().unwrap();
        assert_eq!(open.words().len(), coordinator.jobs.capacity());
        open.words().fill(round);
        assert_eq!(coordinator.jobs.loan().unwrap_err(), UseError::Full);
        drop(open);
        assert!(worker.jobs.take(&mut scratch).unwrap().is_none());
    }
    let too_long = coordinator.jobs.loan().unwrap().send(head(4, MessageKind::Batch), 301);
    assert_eq!(too_long, Err(UseError::TooLong));
    coordinator.jobs.loan().unwrap().send(head(4, MessageKind::Batch), 300).unwrap();
    let got = worker.jobs.take(&mut scratch).unwrap().unwrap().unwrap();
    assert_eq!((got.seq, scratch.len()), (0, 300));
}

#[test]
fn scratch_of_the_right_size_never_grows() {
    let (coordinator, worker) = pair("scratch", 5);
    let mut scratch = Vec::with_capacity(SIZES.job_words);
    let (place, room) = (scratch.as_ptr(), scratch.capacity());
    for words in [0, 1, 300, 17] {
        coordinator.jobs.loan().unwrap().send(head(5, MessageKind::Batch), words).unwrap();
        worker.jobs.take(&mut scratch).unwrap().unwrap().unwrap();
        assert_eq!((scratch.len(), scratch.as_ptr(), scratch.capacity()), (words, place, room));
    }
}

#[test]
fn mail_of_others_is_turned_away() {
    let (coordinator, worker) = pair("others", 6);
    let good = head(6, MessageKind::Result);
    let cases = [
        (Head { boot: 7, ..good }, Reject::Stale),
        (Head { inc: PEER.inc - 1, ..good }, Reject::NotOwner),
        (Head { worker: PEER.worker + 1, ..good }, Reject::NotOwner),
        (Head { magic: MAGIC + 1, ..good }, Reject::Foreign),
        (Head { layout: protocol::LAYOUT + 1, ..good }, Reject::Foreign),
        (Head { kind: 0, ..good }, Reject::Foreign),
    ];
    let mut scratch = Vec::new();
    for (head, reject) in cases {
        send(&worker.results, head, &[1, 2, 3]).unwrap();
        assert_eq!(coordinator.results.take(&mut scratch).unwrap(), Some(Err(reject)), "{head:?}");
        assert!(scratch.is_empty());
        send(&worker.results, good, &[1, 2, 3]).unwrap();
        assert!(coordinator.results.take(&mut scratch).unwrap().unwrap().is_ok());
    }
}

/// The shared memory in which this header lies, and where.
fn find(root: &std::path::Path, request: u64) -> (File, u64) {
    for entry in std::fs::read_dir(root).unwrap() {
        let entry = entry.unwrap();
        if !entry.file_type().unwrap().is_file() {
            continue;
        }
        let bytes = std::fs::read(entry.path()).unwrap();
        let place = bytes.windows(24).position(|window| {
            window[..4] == MAGIC.to_le_bytes() && window[16..] == request.to_le_bytes()
        });
        if let Some(place) = place {
            let file = File::options().read(true).write(true).open(entry.path()).unwrap();
            return (file, place as u64);
        }
    }
    panic!("message {request} is nowhere in shared memory");
}

fn flip(file: &File, place: u64, bit: u64) {
    let mut byte = [0];
    file.read_exact_at(&mut byte, place + bit / 8).unwrap();
    byte[0] ^= 1 << (bit % 8);
    file.write_all_at(&byte, place + bit / 8).unwrap();
}

/// What a wild write of any process can do to a message in flight: one bit of the header or of the
/// payload, each in turn. None gets through, and the next message is sound.
#[test]
fn no_flipped_bit_gets_through() {
    let (coordinator, worker) = pair("flips", 8);
    let root = coordinator.root().to_owned();
    let mut scratch = Vec::new();
    let words = [0, u64::MAX, 0x0123_4567_89ab_cdef];
    // A pattern unlike anything else in memory.
    let request = |bit: u64| 0x5eed_0000_0000_0000 | bit;
    for bit in 0..8 * 64 {
        let head = Head { request: request(bit), ..head(8, MessageKind::Result) };
        send(&worker.results, head, &words).unwrap();
        let (file, place) = find(&root, request(bit));
        flip(&file, place, bit);
        let taken = coordinator.results.take(&mut scratch).unwrap().unwrap();
        assert!(taken.is_err() && scratch.is_empty(), "bit {bit} of the header");
    }
    for bit in 0..8 * size_of_val(&words) as u64 {
        let head = Head { request: request(1 << 32 | bit), ..head(8, MessageKind::Result) };
        send(&worker.results, head, &words).unwrap();
        let (file, head_place) = find(&root, request(1 << 32 | bit));
        let payload = head_place + payload_offset(&file, head_place, &words);
        flip(&file, payload, bit);
        let taken = coordinator.results.take(&mut scratch).unwrap();
        assert_eq!(taken, Some(Err(Reject::Corrupt)), "bit {bit} of the payload");
    }
    send(&worker.results, head(8, MessageKind::Result), &words).unwrap();
    assert!(coordinator.results.take(&mut scratch).unwrap().unwrap().is_ok());
    assert_eq!(scratch, words);
}

fn payload_offset(file: &File, head: u64, words: &[u64]) -> u64 {
    let mut bytes = vec![0; 64 + 64 + size_of_val(words)];
    file.read_exact_at(&mut bytes, head).unwrap();
    let wanted: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    bytes.windows(wanted.len()).position(|window| window == wanted).unwrap() as u64
}

#[test]
fn another_build_is_refused_and_both_are_named() {
    let domain = Domain::create(None, "skew", Boot(9)).unwrap();
    let _link = CoordinatorLink::create(&domain, PEER, &SIZES, "build-of-the-coordinator").unwrap();
    let worker = Domain::open(domain.text()).unwrap();
    let error = WorkerLink::open(&worker, PEER, &SIZES, "build-of-the-worker").unwrap_err();
    assert!(error.is_skew());
    let text = error.to_string();
    assert!(text.contains("build-of-the-coordinator") && text.contains("build-of-the-worker"));
    assert!(WorkerLink::open(&worker, PEER, &SIZES, "build-of-the-coordinator").is_ok());
}

#[test]
fn a_link_that_was_not_created_is_not_there() {
    let domain = Domain::create(None, "absent", Boot(10)).unwrap();
    let error = WorkerLink::open(&domain, PEER, &SIZES, BUILD).unwrap_err();
    assert!(!error.is_skew(), "{error}");
    let _link = CoordinatorLink::create(&domain, PEER, &SIZES, BUILD).unwrap();
    let again = CoordinatorLink::create(&domain, PEER, &SIZES, BUILD).unwrap_err();
    assert!(again.to_string().contains("3.7"), "{again}");
}

#[test]
fn incarnations_and_workers_do_not_share_mail() {
    let domain = Domain::create(None, "several", Boot(11)).unwrap();
    let peers = [(0, 0), (0, 1), (1, 0)].map(|(worker, inc)| Incarnation { worker, inc });
    let links = peers.map(|peer| {
        let coordinator = CoordinatorLink::create(&domain, peer, &SIZES, BUILD).unwrap();
        let entered = Domain::open(domain.text()).unwrap();
        (peer, coordinator, WorkerLink::open(&entered, peer, &SIZES, BUILD).unwrap())
    });
    let mut scratch = Vec::new();
    for (peer, coordinator, _) in &links {
        let head = Head::new(Boot(11), RequestId(1), *peer, MessageKind::Batch);
        send(&coordinator.jobs, head, &[u64::from(peer.worker), u64::from(peer.inc)]).unwrap();
    }
    for (peer, _, worker) in &links {
        worker.jobs.take(&mut scratch).unwrap().unwrap().unwrap();
        assert_eq!(scratch, [u64::from(peer.worker), u64::from(peer.inc)]);
        assert!(worker.jobs.take(&mut scratch).unwrap().is_none());
    }
}

/// Otherwise a full file system would kill the process with SIGBUS in the middle of a request.
#[test]
fn all_memory_is_taken_before_it_is_used() {
    let (coordinator, _worker) = pair("commit", 12);
    let mut bytes = 0;
    for entry in std::fs::read_dir(coordinator.root()).unwrap() {
        let entry = entry.unwrap();
        let file = entry.metadata().unwrap();
        if file.is_file() {
            assert!(file.blocks() * 512 >= file.len(), "{:?} is sparse", entry.file_name());
            bytes += file.len();
        }
    }
    assert!(bytes >= (SIZES.job_words * 8 * 6 + SIZES.result_words * 8 * 4) as u64);
    assert!(bytes <= SIZES.pool_bytes() as u64 + 200_000, "{bytes} bytes");
}

/// What both ends of a link take, in whole pages; `real` are those of the default engine.
#[test]
fn a_link_takes_no_more_memory_than_is_held_back_for_one() {
    let real = Sizes { job_words: 190, job_queue: 8, result_words: 2_048, result_queue: 32 };
    for (boot, sizes) in [(70, SIZES), (71, real)] {
        let domain = Domain::create(None, "bytes", Boot(boot)).unwrap();
        let coordinator = CoordinatorLink::create(&domain, PEER, &sizes, BUILD).unwrap();
        let worker = WorkerLink::open(&Domain::open(domain.text()).unwrap(), PEER, &sizes, BUILD);
        let worker = worker.unwrap();
        coordinator.connect().unwrap();
        let (mut folders, mut bytes) = (vec![coordinator.root().to_owned()], 0);
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let entry = entry.unwrap();
                let stat = entry.metadata().unwrap();
                bytes += stat.blocks() * 512;
                folders.extend(stat.is_dir().then(|| entry.path()));
            }
        }
        let (bytes, most) = (usize::try_from(bytes).unwrap(), sizes.link_bytes());
        assert!(bytes <= most && bytes * 4 >= sizes.pool_bytes(), "{bytes} of {most}");
        drop(worker);
    }
}
