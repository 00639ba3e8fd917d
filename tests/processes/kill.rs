//! Real processes, real signals: whichever process dies, the answer is the same or there is none,
//! and nothing is left behind.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::{
    self, DEPTH, Place, answer, builder, children, cpu_ticks, heavy, instance, json, left_in_shm,
    library_answer, run, signal, text, trolley, wait_for, workers_at_work,
};
use ::trolley::dispatch_options::{DispatchOptions, TransferMode};
use ::trolley::{Limits, Scenario};
use rustix::process::Signal;
use std::process::{Child, Output};

struct Started {
    child: Child,
    instance: String,
    workers: Vec<u32>,
}

/// Starts a run and waits until its workers are in the middle of it.
fn start(path: &str, workers: usize, extra: &[&str]) -> Option<Started> {
    let instance = instance();
    let mut child = trolley()
        .args(["rank", path, "--json", "--depth", DEPTH, "--workers", &workers.to_string()])
        .args(["--instance", &instance])
        .args(extra)
        .spawn()
        .unwrap();
    let Some(workers) = workers_at_work(&mut child, workers) else {
        child.wait_with_output().unwrap();
        return None;
    };
    Some(Started { child, instance, workers })
}

impl Started {
    fn finish(self) -> Output {
        let output = self.child.wait_with_output().unwrap();
        assert_eq!(left_in_shm(&self.instance), Vec::<String>::new());
        output
    }
}

/// Disturbs a run in its middle; if it was too fast, tries again with more work.
fn disturbed(
    place: &Place,
    workers: usize,
    extra: &[&str],
    disturb: impl Fn(&Started),
    is_hit: impl Fn(&Output) -> bool,
) -> (Output, String) {
    for triangles in [10_000, 20_000, 40_000, 80_000, 160_000] {
        let path = place.write("heavy.toml", &heavy(triangles));
        let path = path.to_str().unwrap().to_owned();
        let Some(started) = start(&path, workers, extra) else { continue };
        disturb(&started);
        let output = started.finish();
        if is_hit(&output) {
            return (output, path);
        }
    }
    panic!("no run took long enough to be disturbed");
}

fn lost(output: &Output) -> usize {
    if !output.status.success() {
        return 0;
    }
    let document = json(output);
    let workers = document["run"]["workers"].as_array().unwrap();
    workers.iter().filter(|worker| !worker["lost"].is_null()).count()
}

fn reference(path: &str) -> String {
    answer(&run(&["rank", path, "--json", "--in-process"]))
}

// verifies REQ-WORKER-LOST
#[test]
fn a_killed_worker_changes_nothing_in_the_answer() {
    let place = Place::new();
    let kill = |run: &Started| signal(run.workers[1], Signal::KILL);
    let (output, path) = disturbed(&place, 4, &[], kill, |output| lost(output) == 1);
    assert_eq!(answer(&output), reference(&path));
}

#[test]
fn a_killed_worker_that_copied_changes_nothing_in_the_answer() {
    let place = Place::new();
    let dispatch_options = DispatchOptions {
        transfer: TransferMode::Copy,
        memory_budget: Some(999_999_999),
        ..DispatchOptions::default()
    };
    let limits = Limits::default();
    for triangles in [10_000, 20_000, 40_000, 80_000, 160_000] {
        let scenario = Scenario::open(place.write("heavy.toml", &heavy(triangles))).unwrap();
        let mut engine =
            builder().workers(3).depth(14).dispatch_options(dispatch_options).build().unwrap();
        let reference = library_answer(&mut engine, &scenario, &limits);
        let victim = engine.worker_pids()[1];
        let ticks = cpu_ticks(victim).unwrap();
        let ranking = std::thread::scope(|scope| {
            scope.spawn(|| {
                wait_for(2_000, || (cpu_ticks(victim)? >= ticks + 2).then_some(()));
                signal(victim, Signal::KILL);
            });
            engine.rank(&scenario, &limits).unwrap()
        });
        assert_eq!(serde_json::to_string(&ranking.answer).unwrap(), reference);
        if ranking.run.workers.iter().filter(|worker| worker.lost.is_some()).count() == 1 {
            return;
        }
    }
    panic!("no run took long enough to be disturbed");
}

// verifies REQ-WORKER-LOST
#[test]
fn three_of_four_may_die() {
    let place = Place::new();
    let kill = |run: &Started| run.workers[..3].iter().for_each(|pid| signal(*pid, Signal::KILL));
    let (output, path) = disturbed(&place, 4, &[], kill, |output| lost(output) == 3);
    assert_eq!(answer(&output), reference(&path));
}

// verifies REQ-WORKER-STUCK
#[test]
fn a_stopped_worker_is_found_and_replaced_by_the_others() {
    let place = Place::new();
    let stop = |run: &Started| signal(run.workers[0], Signal::STOP);
    let (output, path) = disturbed(&place, 2, &[], stop, |output| lost(output) == 1);
    assert!(text(&output.stdout).contains("stopped"), "{}", text(&output.stdout));
    assert_eq!(answer(&output), reference(&path));
}

// verifies REQ-NO-WORKER
#[test]
fn without_any_worker_left_there_is_a_clear_error() {
    let place = Place::new();
    let kill = |run: &Started| run.workers.iter().for_each(|pid| signal(*pid, Signal::KILL));
    let (output, _) = disturbed(&place, 2, &[], kill, |output| !output.status.success());
    assert_eq!(output.status.code(), Some(69));
    assert!(text(&output.stderr).contains("no worker is left"), "{}", text(&output.stderr));
    assert!(text(&output.stdout).is_empty());
}

#[test]
fn a_run_that_is_told_to_end_says_so_and_leaves_nothing() {
    let place = Place::new();
    let end = |run: &Started| signal(run.child.id(), Signal::TERM);
    let (output, _) = disturbed(&place, 2, &[], end, |output| !output.status.success());
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
}

// verifies REQ-REMAINS
#[test]
fn workers_die_with_their_coordinator_and_the_next_run_sweeps() {
    let place = Place::new();
    let started = [40_000, 80_000, 160_000].into_iter().find_map(|triangles| {
        let path = place.write("heavy.toml", &heavy(triangles));
        start(path.to_str().unwrap(), 2, &[])
    });
    let mut started = started.expect("enough work to be killed in");
    assert_eq!(children(started.child.id()).len(), 2);
    started.child.kill().unwrap();
    started.child.wait().unwrap();
    let gone = wait_for(5_000, || {
        let alive = |pid: &u32| std::path::Path::new(&format!("/proc/{pid}")).exists();
        (!started.workers.iter().any(alive)).then_some(())
    });
    assert!(gone.is_some(), "orphans");
    // The next run, maybe of another test, cleans up what it left.
    run(&["rank", place.write("small.toml", &support::ways(600)).to_str().unwrap()]);
    assert_eq!(left_in_shm(&started.instance), Vec::<String>::new());
}

#[test]
fn a_worker_killed_at_start_up_is_seen_at_once_whenever_it_dies() {
    let place = Place::new();
    let path = place.write("small.toml", &support::ways(2_000));
    let path = path.to_str().unwrap();
    let expected = reference(path);
    for delay in [0, 1, 2, 4, 6, 8, 12, 16, 24, 32] {
        let instance = instance();
        let mut child = trolley()
            .args(["rank", path, "--json", "--workers", "2", "--instance", &instance])
            .spawn()
            .unwrap();
        let pid = child.id();
        let born = wait_for(60_000, || {
            let workers = children(pid);
            (workers.len() == 2 || child.try_wait().unwrap().is_some()).then_some(workers)
        });
        let _later = wait_for(delay, || None::<()>);
        if let Some(worker) = born.unwrap_or_default().first() {
            signal(*worker, Signal::KILL);
        }
        let output = child.wait_with_output().unwrap();
        assert_eq!(left_in_shm(&instance), Vec::<String>::new());
        assert!(output.status.success(), "after {delay} ms: {}", text(&output.stderr));
        assert_eq!(answer(&output), expected, "after {delay} ms");
        let said = text(&output.stdout);
        assert!(!said.contains("silent") && !said.contains("hung"), "after {delay} ms: {said}");
    }
}

/// The record of a run that lost a worker names the loss, and is replayed bit for bit.
#[test]
fn a_record_of_a_run_that_lost_a_worker_is_replayed() {
    let place = Place::new();
    let records = place.path().join("records");
    let record = records.join("000000.record");
    let (records, record) = (records.to_str().unwrap(), record.to_str().unwrap());
    for triangles in [10_000, 20_000, 40_000, 80_000, 160_000] {
        let _none_yet = std::fs::remove_dir_all(records);
        let path = place.write("heavy.toml", &heavy(triangles));
        let started = start(path.to_str().unwrap(), 3, &["--record", records]);
        let Some(started) = started else { continue };
        signal(started.workers[1], Signal::KILL);
        if lost(&started.finish()) == 0 {
            continue;
        }
        let shown = trolley().args(["record", "show", record, "--json"]).output().unwrap();
        let faults = json(&shown)["faults"].to_string();
        assert!(faults.contains("was lost"), "{faults}");
        let replayed = trolley().args(["record", "replay", record, "--json"]).output().unwrap();
        assert!(replayed.status.success(), "{}", text(&replayed.stderr));
        assert_eq!(json(&replayed)["same"], true);
        return;
    }
    panic!("no run took long enough to be disturbed");
}
