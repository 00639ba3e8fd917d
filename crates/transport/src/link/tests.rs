//! Messages arrive once, whole and checked, or not at all; and nothing ever blocks.

use super::*;
use crate::UseError;
use protocol::{Boot, Head, Kind, Reject, RequestId};
use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Stdio};

pub(crate) const SIZES: Sizes = Sizes { job_words: 64, jobs: 4, result_words: 256, results: 3 };
const WHO: Incarnation = Incarnation { worker: 1, inc: 4 };
const CHILD: &str = "--trolley-child-boot=";

pub(crate) fn unique_boot() -> Boot {
    use std::hash::{BuildHasher as _, Hasher as _};
    let random = std::collections::hash_map::RandomState::new().build_hasher().finish();
    Boot(random ^ u64::from(std::process::id()))
}

/// The test binary plays its own victim: the boot it was given, if this is the child.
pub(crate) fn lives_in_child() -> Option<Boot> {
    let arg = std::env::args().find_map(|arg| arg.strip_prefix(CHILD).map(str::to_owned));
    arg.map(|boot| Boot(boot.parse().unwrap()))
}

/// Starts this test again in a child, and waits until it says that it is ready.
pub(crate) fn start_child(test: &str, boot: Boot) -> Child {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", test, "--nocapture", "--skip", &format!("{CHILD}{}", boot.0)])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap().contains("ready")));
    child
}

struct Pair {
    coordinator: CoordinatorLink,
    worker: WorkerLink,
    _theirs: Domain,
    domain: Domain,
}

fn pair() -> Pair {
    let domain = Domain::create("tlink", unique_boot()).unwrap();
    let coordinator = CoordinatorLink::create(&domain, WHO, &SIZES, "b1").unwrap();
    let theirs = Domain::open(&domain.text()).unwrap();
    let worker = WorkerLink::open(&theirs, WHO, &SIZES, "b1").unwrap();
    Pair { coordinator, worker, _theirs: theirs, domain }
}

fn head(boot: Boot, job: u32) -> Head {
    Head { job, ..Head::new(boot, RequestId(1), WHO, Kind::Result) }
}

#[test]
fn words_arrive_in_order_both_ways() {
    let Pair { coordinator, worker, domain, .. } = pair();
    let mut scratch = Vec::new();
    assert!(coordinator.results.take(&mut scratch).unwrap().is_none());
    for job in 0..100 {
        let sent: Vec<u64> = (0..u64::from(job % 60)).map(|i| i ^ u64::from(job) << 32).collect();
        worker.results.send(head(domain.boot(), job), &sent).unwrap();
        let (got, kind) = coordinator.results.take(&mut scratch).unwrap().unwrap().unwrap();
        assert_eq!((got.job, kind, &scratch), (job, Kind::Result, &sent));
        coordinator.jobs.send(head(domain.boot(), job), &sent).unwrap();
        let (got, _) = worker.jobs.take(&mut scratch).unwrap().unwrap().unwrap();
        assert_eq!((got.job, &scratch), (job, &sent));
    }
}

#[test]
fn a_full_queue_is_an_error_at_once_and_keeps_what_it_holds() {
    let Pair { coordinator, worker, domain, .. } = pair();
    for job in 0..3 {
        worker.results.send(head(domain.boot(), job), &[7]).unwrap();
    }
    assert_eq!(worker.results.send(head(domain.boot(), 3), &[7]), Err(UseError::Full));
    let mut scratch = Vec::new();
    for job in 0..3 {
        let (got, _) = coordinator.results.take(&mut scratch).unwrap().unwrap().unwrap();
        assert_eq!(got.job, job);
    }
    assert!(coordinator.results.take(&mut scratch).unwrap().is_none());
}

#[test]
fn a_dropped_message_comes_back_and_a_foreign_one_is_turned_away() {
    let Pair { coordinator, worker, domain, .. } = pair();
    let mut scratch = Vec::new();
    for _ in 0..10 {
        drop(worker.results.loan().unwrap());
    }
    worker.results.send(head(Boot(domain.boot().0 ^ 1), 0), &[1]).unwrap();
    let turned_away = coordinator.results.take(&mut scratch).unwrap().unwrap();
    assert_eq!(turned_away.unwrap_err(), Reject::Stale);
}

#[test]
fn another_build_is_refused_by_name() {
    let domain = Domain::create("tskew", unique_boot()).unwrap();
    let _coordinator = CoordinatorLink::create(&domain, WHO, &SIZES, "b1").unwrap();
    let theirs = Domain::open(&domain.text()).unwrap();
    let error = WorkerLink::open(&theirs, WHO, &SIZES, "b2").unwrap_err();
    assert!(matches!(error, OpenError::Skew { .. }), "{error}");
}

#[test]
fn a_killed_worker_loses_nothing_it_sent_and_adds_nothing_it_did_not() {
    if let Some(boot) = lives_in_child() {
        let domain = Domain::open(&format!("tkill.{:016x}", boot.0)).unwrap();
        let link = WorkerLink::open(&domain, WHO, &SIZES, "b1").unwrap();
        link.results.send(head(boot, 8), &[1, 2, 3]).unwrap();
        let mut open = link.results.loan().unwrap();
        open.words()[0] = 9;
        println!("ready");
        std::thread::park();
        return;
    }
    let boot = unique_boot();
    let domain = Domain::create("tkill", boot).unwrap();
    let link = CoordinatorLink::create(&domain, WHO, &SIZES, "b1").unwrap();
    let test = "link::tests::a_killed_worker_loses_nothing_it_sent_and_adds_nothing_it_did_not";
    let mut child = start_child(test, boot);
    child.kill().unwrap();
    child.wait().unwrap();
    let mut scratch = Vec::new();
    let (got, _) = link.results.take(&mut scratch).unwrap().unwrap().unwrap();
    assert_eq!((got.job, &scratch[..]), (8, &[1, 2, 3][..]));
    assert!(link.results.take(&mut scratch).unwrap().is_none());
    // The name is not broken: a successor gets services of its own.
    let next = Incarnation { inc: 5, ..WHO };
    CoordinatorLink::create(&domain, next, &SIZES, "b1").unwrap();
}
