//! Nothing that a child does holds the coordinator up: not in its start, not in its requests.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::{self, Place, instance, left_in_shm, wait_for};
use ::trolley::bodies::{Bodies, SILENT};
use ::trolley::{BUILD, Scenario};
use coordinator::{Options, PairWork, WorkerPool};
use geometry::RelativePose;
use runtime::clock;
use rustix::process::Signal;

const MS: u64 = 1_000_000;

fn bodies(place: &Place) -> Bodies {
    bodies_of(place, 600)
}

fn bodies_of(place: &Place, triangles: u32) -> Bodies {
    let scenario = Scenario::open(place.write("small.toml", &support::ways(triangles))).unwrap();
    Bodies::of_scenario(&scenario, SILENT).unwrap()
}

fn options(instance: &str, workers: usize) -> Options {
    Options {
        program: env!("CARGO_BIN_EXE_trolley").into(),
        ..Options::new(instance, BUILD, vec![None; workers])
    }
}

// verifies REQ-WORKER-STUCK
#[cfg(feature = "lab")]
#[test]
fn a_worker_stopped_before_exec_is_replaced_and_one_that_stops_again_is_given_up() {
    let place = Place::new();
    let bodies = bodies(&place);
    // Of two workers: none greets at first, then one never does, then neither.
    for (stopped_starts, ready) in [(0, 2), (1, 2), (2, 2), (4, 0)] {
        let instance = instance();
        let begun_ns = clock::now_ns();
        let options = Options { stopped_starts, ..options(&instance, 2) };
        let started = WorkerPool::start(bodies.store(), &options);
        let took_ms = (clock::now_ns() - begun_ns) / MS;
        match started {
            Ok(pool) => assert_eq!(pool.ready(), ready),
            Err(error) => {
                assert!(
                    matches!(error, coordinator::WorkerPoolError::HandshakeTimeout { .. }),
                    "{error}"
                );
                assert!(error.to_string().contains("stopped"), "{error}");
                assert_eq!(ready, 0);
                assert!((200..2_000).contains(&took_ms), "{took_ms} ms");
            }
        }
        assert_eq!(left_in_shm(&instance), Vec::<String>::new());
    }
}

#[test]
fn a_program_that_cannot_be_run_is_an_error_at_once() {
    let place = Place::new();
    let bodies = bodies(&place);
    let instance = instance();
    let options = Options { program: "/absent/program".into(), ..options(&instance, 2) };
    let error = WorkerPool::start(bodies.store(), &options).unwrap_err();
    assert!(error.to_string().contains("cannot start '/absent/program'"), "{error}");
    assert_eq!(left_in_shm(&instance), Vec::<String>::new());
}

/// A program that runs, but never greets.
#[test]
fn a_program_that_does_nothing_is_given_up_within_two_seconds() {
    let place = Place::new();
    let bodies = bodies(&place);
    let program = place.write("idle", "#!/bin/sh\nexec sleep 1000\n");
    let mode = std::os::unix::fs::PermissionsExt::from_mode(0o700);
    std::fs::set_permissions(&program, mode).unwrap();
    let instance = instance();
    let begun_ns = clock::now_ns();
    let error = WorkerPool::start(bodies.store(), &Options { program, ..options(&instance, 2) });
    let took_ms = (clock::now_ns() - begun_ns) / MS;
    let error = error.unwrap_err();
    assert!(error.to_string().contains("silent"), "{error}");
    assert!(took_ms < 2_500, "{took_ms} ms");
}

/// A stopped worker that has greeted already may rest: it has nothing to do.
#[test]
fn a_worker_stopped_at_rest_is_no_loss() {
    let place = Place::new();
    let bodies = bodies(&place);
    let instance = instance();
    let mut pool = WorkerPool::start(bodies.store(), &options(&instance, 2)).unwrap();
    let pid = pool.pids()[0];
    support::signal(pid, Signal::STOP);
    wait_for(300, || None::<()>);
    assert!(pool.mend(bodies.store()).unwrap().started.is_empty());
    support::signal(pid, Signal::CONT);
    drop(pool);
    assert_eq!(left_in_shm(&instance), Vec::<String>::new());
}

/// Sections are larger than the queue of a worker: with a worker that takes none, batches never go
/// out, and it is not busy by what it was sent.
#[test]
fn a_stopped_worker_that_should_copy_is_replaced_without_a_deadline() {
    let place = Place::new();
    let bodies = bodies_of(&place, 60_000);
    let views = bodies.views().unwrap();
    let instance = instance();
    let options = Options { copies: true, ..options(&instance, 2) };
    let mut pool = WorkerPool::start(bodies.store(), &options).unwrap();
    let rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let poses = [RelativePose { rotation, translation: [0.0; 3] }];
    let mut usual = PairWork::new([views[0].1, views[1].1], &poses, 3);
    pool.work_off(&mut usual).unwrap();
    support::signal(pool.pids()[0], Signal::STOP);
    let begun_ns = clock::now_ns();
    let mut work = PairWork::new([views[0].1, views[1].1], &poses, 3);
    pool.work_off(&mut work).unwrap();
    let took_ms = (clock::now_ns() - begun_ns) / MS;
    assert_eq!(work.found().unwrap()[0].hash, usual.found().unwrap()[0].hash);
    assert!(took_ms < 2_000, "{took_ms} ms");
    drop(pool);
    assert_eq!(left_in_shm(&instance), Vec::<String>::new());
}
