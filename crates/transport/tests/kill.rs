//! Real processes: the test binary runs as its own worker or coordinator, and is killed.
//!
//! A child is told what it is by a further name on its command line, which the test runner takes
//! for a filter that matches nothing: the domain to enter, or the word `own` to make one.

use protocol::{Boot, Head, Incarnation, MessageKind, RequestId};
use rustix::process::{Pid, Signal};
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use trolley_transport::{
    CoordinatorLink, Domain, Sizes, UseError, WorkerLink, default_folder, sweep_leftovers,
};

const PEER: Incarnation = Incarnation { worker: 1, inc: 0 };
const SIZES: Sizes = Sizes { job_words: 64, job_queue: 4, result_words: 1024, result_queue: 8 };
const BUILD: &str = "kill-test";
const OWN: &str = "own";
/// What the name of a domain holds.
const TEXT: &str = "/trolley.";

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// What this process was told to be, if it is a child. Then it does not outlive the test either.
fn told() -> std::io::Result<Option<String>> {
    let told = std::env::args().find(|arg| arg == OWN || arg.contains(TEXT));
    if told.is_some() {
        rustix::process::set_parent_process_death_signal(Some(Signal::KILL))?;
    }
    Ok(told)
}

/// Starts a test of this file again. The child speaks on its standard output: there, lines that
/// begin with `> ` are ours, and the others are the test runner's.
struct Victim {
    child: Child,
    said: BufReader<std::process::ChildStdout>,
}

impl Victim {
    fn start(test: &str, told: &str) -> std::io::Result<Self> {
        let mut child = Command::new(std::env::current_exe()?)
            .args(["--exact", test, told, "--nocapture", "--test-threads=1"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let said = BufReader::new(child.stdout.take().ok_or(std::io::ErrorKind::BrokenPipe)?);
        Ok(Self { child, said })
    }

    fn hear(&mut self) -> std::io::Result<String> {
        let mut line = String::new();
        loop {
            line.clear();
            if self.said.read_line(&mut line)? == 0 {
                return Err(std::io::ErrorKind::UnexpectedEof.into());
            }
            // The runner's own line may stand before it, without an end.
            if let Some((_, said)) = line.split_once("> ") {
                return Ok(said.trim_end().to_owned());
            }
        }
    }

    fn signal(&self, signal: Signal) -> std::io::Result<()> {
        let pid =
            Pid::from_raw(self.child.id().cast_signed()).ok_or(std::io::ErrorKind::NotFound)?;
        Ok(rustix::process::kill_process(pid, signal)?)
    }

    fn kill(&mut self) -> std::io::Result<()> {
        self.child.kill()?;
        self.child.wait().map(|_status| ())
    }
}

impl Drop for Victim {
    fn drop(&mut self) {
        // Whatever the test found, no process is left.
        let _dead_already = self.kill();
    }
}

fn say(text: &str) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "> {text}")?;
    out.flush()
}

/// For a child that waits to be killed.
fn wait_for_the_end() {
    let _nobody_writes = std::io::stdin().read_line(&mut String::new());
}

fn head(domain: &Domain, kind: MessageKind, request: u64) -> Head {
    Head::new(domain.boot(), RequestId(request), PEER, kind)
}

fn left(domain: &str) -> Vec<String> {
    if Path::new(domain).exists() { vec![domain.to_owned()] } else { Vec::new() }
}

#[test]
fn a_worker_in_another_process_answers() -> Outcome {
    let mut scratch = Vec::with_capacity(SIZES.result_words);
    if let Some(text) = told()? {
        let domain = Domain::open(&text)?;
        let link = WorkerLink::open(&domain, PEER, &SIZES, BUILD)?;
        link.results.loan()?.send(head(&domain, MessageKind::Hello, 0), 0)?;
        loop {
            let Some(batch) = link.jobs.take(&mut scratch)? else { continue };
            let batch = batch?;
            if batch.count == 0 {
                return Ok(());
            }
            let mut answer = link.results.loan()?;
            for (to, from) in answer.words().iter_mut().zip(&scratch) {
                *to = from * from;
            }
            answer.send(head(&domain, MessageKind::Result, batch.request), scratch.len())?;
        }
    }
    let domain = Domain::create(None, "k-answers", Boot(1))?;
    let link = CoordinatorLink::create(&domain, PEER, &SIZES, BUILD)?;
    let mut worker = Victim::start("a_worker_in_another_process_answers", domain.text())?;
    let mut take = || loop {
        if let Some(taken) = link.results.take(&mut scratch)? {
            return Ok::<_, UseError>((taken, scratch.clone()));
        }
        std::thread::yield_now();
    };
    assert_eq!(take()?.0?.kind, MessageKind::Hello as u8);
    link.connect()?;
    for request in 1..1000_u64 {
        let mut batch = link.jobs.loan()?;
        batch.words()[..3].copy_from_slice(&[request, request + 1, 5]);
        batch.send(Head { count: 3, ..head(&domain, MessageKind::Batch, request) }, 3)?;
        let (got, words) = take()?;
        assert_eq!(got?.request, request);
        assert_eq!(words, [request * request, (request + 1) * (request + 1), 25]);
    }
    link.jobs.loan()?.send(head(&domain, MessageKind::Batch, 0), 0)?;
    assert!(worker.child.wait()?.success());
    let text = domain.text().to_owned();
    drop((link, domain));
    assert_eq!(left(&text), [""; 0]);
    Ok(())
}

#[test]
fn a_killed_worker_loses_nothing_it_sent_and_sends_nothing_it_did_not() -> Outcome {
    if let Some(text) = told()? {
        let domain = Domain::open(&text)?;
        let link = WorkerLink::open(&domain, PEER, &SIZES, BUILD)?;
        for request in 1..4 {
            let mut sent = link.results.loan()?;
            sent.words()[..2].fill(request);
            sent.send(head(&domain, MessageKind::Result, request), 2)?;
        }
        let mut open = link.results.loan()?;
        open.words().fill(77);
        say("three sent, one open")?;
        wait_for_the_end();
        drop(open);
        return Ok(());
    }
    let domain = Domain::create(None, "k-sent", Boot(2))?;
    let text = domain.text().to_owned();
    let link = CoordinatorLink::create(&domain, PEER, &SIZES, BUILD)?;
    let name = "a_killed_worker_loses_nothing_it_sent_and_sends_nothing_it_did_not";
    let mut worker = Victim::start(name, domain.text())?;
    assert_eq!(worker.hear()?, "three sent, one open");
    // Never connected before: what is taken here was left by the dead worker.
    worker.kill()?;
    let mut scratch = Vec::new();
    for request in 1..4 {
        let got = link.results.take(&mut scratch)?.ok_or("sent before the kill, lost")??;
        assert_eq!((got.request, scratch.as_slice()), (request, [request, request].as_slice()));
    }
    assert!(link.results.take(&mut scratch)?.is_none(), "what was never sent must not arrive");
    // Its jobs go nowhere, and nothing waits for it.
    let refused = (0..20).find_map(|_| {
        let sent =
            link.jobs.loan().and_then(|job| job.send(head(&domain, MessageKind::Batch, 9), 1));
        sent.err()
    });
    assert_eq!(refused, Some(UseError::Full));

    // The successor has services of its own, and the dead node can be reaped meanwhile.
    drop(link);
    let next = Incarnation { inc: 1, ..PEER };
    let link = CoordinatorLink::create(&domain, next, &SIZES, BUILD)?;
    let entered = Domain::open(&text)?;
    let successor = WorkerLink::open(&entered, next, &SIZES, BUILD)?;
    let hello = Head::new(domain.boot(), RequestId(0), next, MessageKind::Hello);
    successor.results.loan()?.send(hello, 0)?;
    assert!(link.results.take(&mut scratch)?.ok_or("no hello")?.is_ok());
    drop((successor, entered, link, domain));
    assert_eq!(left(&text), [""; 0]);
    Ok(())
}

#[test]
fn a_stopped_worker_makes_nobody_wait() -> Outcome {
    if let Some(text) = told()? {
        let domain = Domain::open(&text)?;
        let link = WorkerLink::open(&domain, PEER, &SIZES, BUILD)?;
        say("ready")?;
        let mut scratch = Vec::new();
        loop {
            while let Some(taken) = link.jobs.take(&mut scratch)? {
                link.results.loan()?.send(head(&domain, MessageKind::Result, taken?.request), 0)?;
            }
            std::thread::yield_now();
        }
    }
    let domain = Domain::create(None, "k-stopped", Boot(3))?;
    let link = CoordinatorLink::create(&domain, PEER, &SIZES, BUILD)?;
    let mut worker = Victim::start("a_stopped_worker_makes_nobody_wait", domain.text())?;
    assert_eq!(worker.hear()?, "ready");
    link.connect()?;
    worker.signal(Signal::STOP)?;
    while !fs::read_to_string(format!("/proc/{}/stat", worker.child.id()))?.contains(") T ") {
        std::thread::yield_now();
    }
    let sent = SIZES.job_queue as u64;
    for request in 0..sent {
        link.jobs.loan()?.send(head(&domain, MessageKind::Batch, request), 0)?;
    }
    for _ in 0..100 {
        let refused = link.jobs.loan()?.send(head(&domain, MessageKind::Batch, sent), 0);
        assert_eq!(refused, Err(UseError::Full));
    }
    worker.signal(Signal::CONT)?;
    let mut scratch = Vec::new();
    let mut answered = 0;
    while answered < sent {
        match link.results.take(&mut scratch)? {
            Some(taken) => {
                assert_eq!(taken?.request, answered, "all, in order, once");
                answered += 1;
            }
            None => std::thread::yield_now(),
        }
    }
    Ok(())
}

#[test]
fn a_killed_coordinator_leaves_nothing_that_a_sweep_does_not_remove() -> Outcome {
    if told()?.is_some() {
        let domain = Domain::create(None, "k-swept", Boot(u64::from(std::process::id())))?;
        let _link = CoordinatorLink::create(&domain, PEER, &SIZES, BUILD)?;
        say(domain.text())?;
        wait_for_the_end();
        return Ok(());
    }
    let name = "a_killed_coordinator_leaves_nothing_that_a_sweep_does_not_remove";
    for _ in 0..3 {
        let mut coordinator = Victim::start(name, OWN)?;
        let text = coordinator.hear()?;
        let worker = Domain::open(&text)?;
        let link = WorkerLink::open(&worker, PEER, &SIZES, BUILD)?;
        let before = left(&text);
        assert!(Path::new(&text).join("1.0").is_dir());
        let _none_of_these = sweep_leftovers(&default_folder());
        assert_eq!(left(&text), before, "it lives");
        coordinator.kill()?;
        let _none_of_these = sweep_leftovers(&default_folder());
        assert!(Path::new(&text).is_dir(), "its worker lives");
        drop((link, worker));
        for _ in 0..50 {
            // Another test may be sweeping this very run.
            let _runs = sweep_leftovers(&default_folder());
            if left(&text).is_empty() {
                break;
            }
        }
        assert_eq!(left(&text), [""; 0]);
        assert!(Domain::open(&text).is_err());
    }
    Ok(())
}
