//! The cost of a message, with its checksum: printed, not asserted. Run by hand, optimised:
//!
//! `cargo test --release -p transport --test cost -- --ignored --nocapture --test-threads=1`

use protocol::{Boot, Head, Incarnation, MessageKind, RequestId};
use rustix::process::Signal;
use rustix::thread::{CpuSet, sched_setaffinity};
use rustix::time::{ClockId, clock_gettime};
use std::process::{Command, Stdio};
use trolley_transport::{CoordinatorLink, Domain, Receiver, Sender, Sizes, WorkerLink};

const PEER: Incarnation = Incarnation { worker: 0, inc: 0 };
const WORDS: usize = 8192;
const SIZES: Sizes = Sizes { job_words: WORDS, job_queue: 4, result_words: WORDS, result_queue: 4 };
const ROUNDS: usize = 20_000;

type Outcome<T = ()> = Result<T, Box<dyn std::error::Error>>;

fn now_ns() -> u64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec.cast_unsigned() * 1_000_000_000 + now.tv_nsec.cast_unsigned()
}

fn pin(core: usize) -> Outcome {
    let mut set = CpuSet::new();
    set.set(core);
    Ok(sched_setaffinity(None, &set)?)
}

fn percentile(times: &mut [u64], percent: usize) -> u64 {
    times.sort_unstable();
    times[(times.len() - 1) * percent / 100]
}

fn send(sender: &Sender, kind: MessageKind, request: usize, words: usize) -> Outcome {
    let mut open = sender.loan()?;
    open.words()[..words].fill(request as u64);
    let head = Head::new(Boot(1), RequestId(request as u64), PEER, kind);
    Ok(open.send(head, words)?)
}

fn wait(receiver: &Receiver, scratch: &mut Vec<u64>) -> Outcome<Head> {
    loop {
        if let Some(taken) = receiver.take(scratch)? {
            return Ok(taken?);
        }
        core::hint::spin_loop();
    }
}

#[test]
#[ignore = "prints times, which mean something on a quiet machine alone"]
fn one_message() -> Outcome {
    pin(0)?;
    let domain = Domain::create(None, "c-one", Boot(1))?;
    let coordinator = CoordinatorLink::create(&domain, PEER, &SIZES, "cost")?;
    let entered = Domain::open(domain.text())?;
    let worker = WorkerLink::open(&entered, PEER, &SIZES, "cost")?;
    coordinator.connect()?;
    let mut scratch = Vec::with_capacity(WORDS);
    println!("one process, p50 of {ROUNDS}: loan + fill + seal + send, then take + copy + check");
    for words in [8, 64, 512, 4096] {
        let (mut sending, mut taking) = (Vec::new(), Vec::new());
        for request in 0..ROUNDS {
            let start = now_ns();
            send(&worker.results, MessageKind::Result, request, words)?;
            let sent = now_ns();
            wait(&coordinator.results, &mut scratch)?;
            sending.push(sent - start);
            taking.push(now_ns() - sent);
        }
        println!(
            "{:>6} B: send {:>5} ns, take {:>5} ns",
            words * 8,
            percentile(&mut sending, 50),
            percentile(&mut taking, 50)
        );
    }
    let start = now_ns();
    for _ in 0..ROUNDS {
        assert!(coordinator.results.take(&mut scratch)?.is_none());
    }
    println!("nothing there: {} ns", (now_ns() - start) / ROUNDS as u64);
    Ok(())
}

#[test]
#[ignore = "prints times, which mean something on a quiet machine alone"]
fn round_trip_between_processes() -> Outcome {
    let mut scratch = Vec::with_capacity(WORDS);
    if let Some(text) = std::env::args().find(|arg| arg.contains("/trolley.")) {
        rustix::process::set_parent_process_death_signal(Some(Signal::KILL))?;
        pin(1)?;
        let domain = Domain::open(&text)?;
        let link = WorkerLink::open(&domain, PEER, &SIZES, "cost")?;
        send(&link.results, MessageKind::Hello, 0, 0)?;
        loop {
            let job = wait(&link.jobs, &mut scratch)?;
            send(&link.results, MessageKind::Result, job.request as usize, scratch.len())?;
        }
    }
    pin(0)?;
    let domain = Domain::create(None, "c-trip", Boot(1))?;
    let link = CoordinatorLink::create(&domain, PEER, &SIZES, "cost")?;
    let mut worker = Command::new(std::env::current_exe()?)
        .args(["--exact", "round_trip_between_processes", domain.text(), "--ignored"])
        .stdout(Stdio::null())
        .spawn()?;
    let outcome = (|| {
        wait(&link.results, &mut scratch)?;
        link.connect()?;
        println!("two processes on cores 0 and 1, spinning, {ROUNDS} round trips");
        for words in [8, 64, 512, 4096] {
            let mut times = Vec::new();
            for request in 0..ROUNDS {
                let start = now_ns();
                send(&link.jobs, MessageKind::Batch, request, words)?;
                wait(&link.results, &mut scratch)?;
                times.push(now_ns() - start);
            }
            let (p50, p99) = (percentile(&mut times, 50), percentile(&mut times, 99));
            println!("{:>6} B: round trip p50 {p50:>6} ns, p99 {p99:>6} ns", words * 8);
        }
        Ok(())
    })();
    worker.kill()?;
    worker.wait()?;
    outcome
}
