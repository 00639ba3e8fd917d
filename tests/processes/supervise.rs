//! A supervised service is replaced when it dies or stands still, and ends with its supervisor.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use super::serve::connect;
use crate::support::service::heard_signals;
use crate::support::service::{
    Serving, deployment, left_behind, of_ways, ranked, ranking, serve, serve_as,
};
use crate::support::{self, Place, children, instance, run, signal, text, trolley, wait_for, ways};
use runtime::clock;
use rustix::process::Signal;
use std::io::ErrorKind;
use std::os::unix::net::UnixDatagram;
use std::process::Output;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

const SUPERVISE: &[&str] = &["--supervise"];
const BODIES: &[(&str, u32, u32)] = &[("sedan", 2000, 0), ("wall", 600, 0)];
/// How long supervisor and service may take to end.
const BOUND: Duration = Duration::from_secs(2);
const MS: u64 = 1_000_000;

/// The service that a supervisor runs at the moment.
fn service_of(supervisor: u32) -> Option<u32> {
    children(supervisor).first().copied()
}

/// Waits for another service than `old` that has this many workers.
fn successor(serving: &Serving, old: u32, workers: usize) -> Option<u32> {
    wait_for(30_000, || {
        let new = service_of(serving.child.id()).filter(|new| *new != old)?;
        (children(new).len() == workers).then_some(new)
    })
}

/// The answer of a service that may just be starting.
fn answer(serving: &Serving, scenario: &std::path::Path) -> Option<Output> {
    wait_for(200, || {
        let output = serving.query(scenario, &["--json"]);
        output.status.success().then_some(output)
    })
}

// verifies REQ-SERVICE-LOST
#[test]
fn a_killed_service_is_replaced_and_answers_again() {
    let place = Place::new();
    let scenario = place.write("ways.toml", &ways(600));
    let expected = ranked(&run(&["rank", scenario.to_str().unwrap(), "--json"]));
    let serving = serve(&deployment(&place, 2, &of_ways(600)), SUPERVISE);
    let mut service = service_of(serving.child.id()).unwrap();
    for number in [Signal::KILL, Signal::ABORT, Signal::KILL] {
        signal(service, number);
        service = successor(&serving, service, 2).expect("a successor");
        let output = answer(&serving, &scenario).expect("an answer");
        assert_eq!(ranking(&output), expected);
    }
    let said = serving.end();
    assert!(said.contains("ended by SIGKILL") && said.contains("started again"), "{said}");
}

// verifies REQ-SERVICE-LOST
#[cfg(feature = "lab")]
#[test]
fn a_service_whose_answering_thread_stands_still_is_replaced_and_answers_again() {
    use runtime::process::{Frozen, may_trace};
    if !may_trace() {
        return support::skipped("a service that hangs: this machine does not permit ptrace");
    }
    let place = Place::new();
    let scenario = place.write("ways.toml", &ways(600));
    let serving = serve(&deployment(&place, 2, &of_ways(600)), SUPERVISE);
    let service = service_of(serving.child.id()).unwrap();
    let frozen = Frozen::first_thread(service).unwrap();
    let begun_ns = clock::now_ns();
    let ended = wait_for(20_000, || frozen.has_ended().then_some(()));
    let took_ms = (clock::now_ns() - begun_ns) / MS;
    drop(frozen);
    assert!(ended.is_some(), "it is not ended");
    // The last ping may have come just before, and a busy machine is late.
    assert!((1_000..6_000).contains(&took_ms), "{took_ms} ms");
    successor(&serving, service, 2).expect("a successor");
    assert!(answer(&serving, &scenario).is_some(), "no answer");
    let said = serving.end();
    assert!(said.contains("fell silent"), "{said}");
}

#[test]
fn a_stopped_service_is_replaced() {
    let place = Place::new();
    let scenario = place.write("ways.toml", &ways(600));
    let serving = serve(&deployment(&place, 1, &of_ways(600)), SUPERVISE);
    let service = service_of(serving.child.id()).unwrap();
    signal(service, Signal::STOP);
    successor(&serving, service, 1).expect("a successor");
    assert!(answer(&serving, &scenario).is_some(), "no answer");
    serving.end();
}

// verifies REQ-END
#[test]
fn one_signal_ends_supervisor_and_service_within_two_seconds_and_leaves_nothing() {
    let place = Place::new();
    let file = deployment(&place, 2, BODIES);
    for number in heard_signals() {
        let mut serving = serve(&file, SUPERVISE);
        let service = service_of(serving.child.id()).unwrap();
        let status = told(&mut serving, number);
        assert_eq!(status, Some(0), "{number:?}");
        assert!(!is_alive(service), "{number:?}");
        serving.end();
    }
}

/// Sends a signal to a supervisor; returns the exit code, which must come in time.
fn told(serving: &mut Serving, number: Signal) -> Option<i32> {
    let told_ns = clock::now_ns();
    signal(serving.child.id(), number);
    let status = wait_for(10_000, || serving.child.try_wait().unwrap()).expect("it ends");
    let lasted = Duration::from_nanos(clock::now_ns() - told_ns);
    assert!(lasted < BOUND, "{number:?}: {lasted:?}");
    assert_eq!(left_behind(&serving.instance), Vec::<String>::new(), "{number:?}");
    status.code()
}

/// Whether a process runs; one that has ended may be a zombie.
fn is_alive(pid: u32) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    stat.rsplit_once(") ").is_some_and(|(_, rest)| !rest.starts_with(['Z', 'X']))
}

#[test]
fn a_stopped_service_ends_with_its_supervisor_in_time_too() {
    let place = Place::new();
    let mut serving = serve(&deployment(&place, 1, BODIES), SUPERVISE);
    let service = service_of(serving.child.id()).unwrap();
    signal(service, Signal::STOP);
    assert_eq!(told(&mut serving, Signal::TERM), Some(0));
    assert!(!is_alive(service));
}

#[cfg(feature = "lab")]
#[test]
fn a_service_that_hangs_ends_with_its_supervisor_in_time_and_leaves_nothing() {
    use runtime::process::{Frozen, may_trace};
    if !may_trace() {
        return support::skipped("a service that hangs: this machine does not permit ptrace");
    }
    let place = Place::new();
    let mut serving = serve(&deployment(&place, 2, BODIES), SUPERVISE);
    let service = service_of(serving.child.id()).unwrap();
    let frozen = Frozen::first_thread(service).unwrap();
    let told_ns = clock::now_ns();
    signal(serving.child.id(), Signal::TERM);
    let status = wait_for(10_000, || {
        let _reaped = frozen.has_ended();
        serving.child.try_wait().unwrap()
    });
    let lasted = Duration::from_nanos(clock::now_ns() - told_ns);
    drop(frozen);
    assert_eq!(status.expect("it ends").code(), Some(128 + 15));
    assert!(lasted < BOUND, "{lasted:?}");
    assert!(!is_alive(service));
    assert_eq!(left_behind(&serving.instance), Vec::<String>::new());
}

#[test]
fn a_killed_supervisor_takes_its_service_along_and_the_next_one_cleans_up() {
    let place = Place::new();
    let file = deployment(&place, 1, BODIES);
    let mut serving = serve(&file, SUPERVISE);
    let service = service_of(serving.child.id()).unwrap();
    serving.child.kill().unwrap();
    serving.child.wait().unwrap();
    let gone = wait_for(5_000, || (!is_alive(service)).then_some(()));
    assert!(gone.is_some(), "the service is left");
    let instance = serving.instance.clone();
    drop(serving);
    serve_as(&file, &instance, SUPERVISE).end();
}

#[test]
fn what_the_service_refuses_is_passed_on_with_its_code() {
    let place = Place::new();
    let good = std::fs::read_to_string(deployment(&place, 1, BODIES)).unwrap();
    for (from, to, code, said) in [
        ("workers = 1", "wrokers = 1", 78, "unknown field"),
        ("generate = { shape = \"wall\"", "model = \"no.trolley\" #", 65, "no.trolley"),
        ("workers = 1", "workers = 1\ncores = [1000]", 78, "core 1000"),
    ] {
        let wrong = place.write("wrong.toml", &good.replacen(from, to, 1));
        let begun_ns = clock::now_ns();
        let instance = instance();
        let output = supervised(&wrong, &instance).output().unwrap();
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{to}: {stderr}");
        assert_eq!(stderr.matches(said).count(), 1, "{to}: {stderr}");
        assert!(clock::now_ns() - begun_ns < 10_000 * MS, "it was tried again");
        assert_eq!(left_behind(&instance), Vec::<String>::new());
    }
}

fn supervised(file: &std::path::Path, instance: &str) -> std::process::Command {
    let mut command = trolley();
    command.args(["serve", file.to_str().unwrap(), "--instance", instance, "--supervise"]);
    command
}

#[test]
fn a_service_that_ends_again_and_again_is_given_up_after_ten_starts() {
    let place = Place::new();
    let file = deployment(&place, 1, BODIES);
    let first = serve(&file, &[]);
    // Its name is taken.
    let output = supervised(&file, &first.instance).output().unwrap();
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(75), "{stderr}");
    assert!(stderr.contains("started 10 times within 60 s"), "{stderr}");
    assert_eq!(stderr.matches("already served").count(), 10, "{stderr}");
    assert!(stderr.contains("help: what it said before"), "{stderr}");
    // The first one is unharmed.
    first.end();
}

#[test]
fn supervision_within_supervision_is_refused_with_the_remedy() {
    let place = Place::new();
    let file = deployment(&place, 1, BODIES);
    let output = supervised(&file, &instance()).env("NOTIFY_SOCKET", "/run/none").output().unwrap();
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(78), "{stderr}");
    assert!(stderr.contains("NOTIFY_SOCKET") && stderr.contains("--supervise"), "{stderr}");
}

/// Pings come from the thread that answers, so it must not forget them while it works: within one
/// request there are several.
#[test]
fn pings_go_on_while_a_long_request_is_worked_on() {
    const WATCHDOG_US: u64 = 60_000;
    let place = Place::new();
    let file = deployment(&place, 1, &[("sedan", 120_000, 0)]);
    let deep = format!("[engine]\ndepth = {}\n", support::DEPTH);
    let text = std::fs::read_to_string(&file).unwrap().replacen("[engine]\n", &deep, 1);
    std::fs::write(&file, text).unwrap();
    let scenario =
        ::trolley::Scenario::open(place.write("long.toml", &support::long(120_000))).unwrap();
    let opened = ::trolley::OpenDeployment::open(&file, None).unwrap();
    let ask = opened.ask(&scenario, false).unwrap();
    for extra in [&[][..], &["--in-process"]] {
        let socket = place.path().join("notify");
        let _none_yet = std::fs::remove_file(&socket);
        let manager = UnixDatagram::bind(&socket).unwrap();
        manager.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        let instance = instance();
        let mut child = trolley()
            .args(["serve", file.to_str().unwrap(), "--instance", &instance, "--quiet"])
            .args(extra)
            .env("NOTIFY_SOCKET", &socket)
            .env("WATCHDOG_USEC", WATCHDOG_US.to_string())
            .spawn()
            .unwrap();
        let pings = AtomicU64::new(0);
        let next = || {
            let mut message = [0; 64];
            // A wait with a limit ends early, too, when this process was stopped and goes on.
            let received = loop {
                match manager.recv(&mut message) {
                    Err(error) if error.kind() == ErrorKind::Interrupted => {}
                    received => break received,
                }
            };
            let len = received.expect("a message in time");
            String::from_utf8_lossy(&message[..len]).into_owned()
        };
        std::thread::scope(|scope| {
            assert_eq!(next(), "READY=1\n", "{extra:?}");
            let listener = scope.spawn(|| {
                while next() == "WATCHDOG=1\n" {
                    pings.fetch_add(1, Ordering::SeqCst);
                }
            });
            let mut client = connect(&instance);
            let (before, begun_ns) = (pings.load(Ordering::SeqCst), clock::now_ns());
            let answer = client.ask(&ask, Duration::from_secs(60));
            let took_ms = (clock::now_ns() - begun_ns) / MS;
            let within = pings.load(Ordering::SeqCst) - before;
            drop(client);
            signal(child.id(), Signal::TERM);
            assert!(child.wait().unwrap().success(), "{extra:?}");
            listener.join().unwrap();
            assert!(answer.verdict().has_ranking(), "{extra:?}: {}", answer.text());
            assert!(took_ms > 2 * WATCHDOG_US / 1_000, "{took_ms} ms are too few");
            assert!(within >= 4, "{extra:?}: {within} pings within {took_ms} ms");
        });
        assert_eq!(left_behind(&instance), Vec::<String>::new());
    }
}
