//! A real service and real clients: the same ranking as `trolley rank`, even if clients send
//! invalid requests, vanish or are killed; and nothing is left behind.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::members::known_by;
use crate::support::service::heard_signals;
use crate::support::service::{deployment, left_behind, of_ways, ranked, ranking, serve, shipped};
use crate::support::ways;
use crate::support::{self, Place, children, patience, run, signal, text, trolley, wait_for};
use client::public::{Ask, Reason, WireParty, WirePath, WirePathKind, WirePathState, WireState};
use client::{Client, Waiting};
use rustix::process::Signal;
use std::time::Duration;

pub(crate) fn connect(instance: &str) -> Client {
    Client::connect(None, instance, Waiting::Nap(Duration::from_micros(100))).unwrap()
}

/// An ego at 10 m/s and a wall ahead; models 1 and 2.
pub(crate) fn into_a_wall() -> Box<Ask> {
    let mut ask = Ask::new(5.0);
    ask.ego = ask.add_party(WireParty::of_model(1)).unwrap();
    let wall = WirePathState::at(0.0, [10.0, 0.0], 90.0);
    let stands = WirePath::of_kind(WirePathKind::Place);
    ask.add_party_on(WireParty::of_model(2), stands, &[wall]).unwrap();
    let now = WirePathState::at(0.0, [0.0, 0.0], 0.0).with_velocity([10.0, 0.0]);
    let path = ask.add_path(WirePath::of_kind(WirePathKind::Onward), &[now]).unwrap();
    ask.add_candidate(path, &[]).unwrap();
    ask
}

pub(crate) const WALL: &[(&str, u32, u32)] = &[("sedan", 2000, 0), ("wall", 600, 0)];

#[test]
fn who_is_told_to_end_again_and_again_cleans_up_all_the_same() {
    let place = Place::new();
    let mut serving = serve(&deployment(&place, 2, WALL), &[]);
    let told_every_millisecond = wait_for(20_000, || {
        signal(serving.child.id(), Signal::TERM);
        serving.child.try_wait().unwrap()
    });
    // In order, or by force at the second signal: in both cases nothing is left.
    let code = told_every_millisecond.expect("it ends").code();
    assert!(matches!(code, Some(0 | 143)), "{code:?}");
    assert_eq!(left_behind(&serving.instance), Vec::<String>::new());
}

// verifies REQ-END
#[test]
fn every_signal_that_ends_a_program_by_default_ends_it_cleanly() {
    for number in heard_signals() {
        let place = Place::new();
        let mut serving = serve(&deployment(&place, 1, WALL), &[]);
        signal(serving.child.id(), number);
        let ended = wait_for(20_000, || serving.child.try_wait().unwrap());
        assert!(ended.is_some_and(|status| status.success()), "{number:?}: {ended:?}");
        serving.end();
    }
}

// verifies REQ-SAME-ANSWER
#[test]
fn the_service_ranks_as_rank_does_in_every_bit_with_workers_and_without() {
    let place = Place::new();
    let scenario = place.write("ways.toml", &ways(2000));
    let expected = ranked(&run(&["rank", scenario.to_str().unwrap(), "--json"]));
    assert_eq!(expected.len(), 6);
    let file = deployment(&place, 2, &of_ways(2000));
    for extra in [&[][..], &["--idle", "spin"], &["--in-process"]] {
        let serving = serve(&file, extra);
        for _ in 0..3 {
            let output = serving.query(&scenario, &["--json"]);
            assert!(output.status.success(), "{extra:?}: {}", text(&output.stderr));
            assert_eq!(ranking(&output), expected, "{extra:?}");
        }
        serving.end();
    }
}

#[test]
fn the_shipped_deployment_answers_the_shipped_scenario() {
    let minimal = shipped("config/scenarios/wall-or-pole.toml");
    let expected = ranked(&run(&["rank", minimal.to_str().unwrap(), "--json"]));
    let serving = serve(&shipped("config/deployments/minimal.toml"), &[]);
    let output = serving.query(&minimal, &["--json"]);
    assert_eq!(ranking(&output), expected, "{}", text(&output.stderr));
    let people = text(&serving.query(&minimal, &[]).stdout);
    assert!(people.contains("Touches nobody") && people.contains("COMPLETE"), "{people}");
    #[cfg(feature = "lab")]
    {
        let latency = support::json(&serving.query(&minimal, &["--repeat", "50", "--json"]));
        let counts = (&latency["wrong"], &latency["answers"][0]);
        assert_eq!(counts, (&0.into(), &50.into()), "{latency}");
    }
    serving.end();
}

#[test]
fn a_second_instance_is_refused_and_the_first_goes_on() {
    let place = Place::new();
    let serving = serve(&deployment(&place, 1, WALL), &[]);
    let second = trolley()
        .args(["serve", serving.deployment.to_str().unwrap(), "--instance", &serving.instance])
        .output()
        .unwrap();
    assert_eq!(second.status.code(), Some(75));
    let said = text(&second.stderr);
    assert!(said.contains("already served by process") && said.contains("help:"), "{said}");
    let answer = connect(&serving.instance).ask(&into_a_wall(), patience());
    assert_eq!(answer.verdict(), WireState::Complete, "{}", answer.text());
    serving.end();
}

/// Regression: batches answered while a result ended the request at its deadline were never counted
/// as answered, and their slots in the worker's queue were lost.
#[test]
fn what_hasty_requests_leave_behind_keeps_no_worker_from_the_next() {
    let place = Place::new();
    let serving = serve(&deployment(&place, 1, WALL), &[]);
    let mut client = connect(&serving.instance);
    for step in 0..300 {
        let _late_or_not = client.ask(&into_a_wall(), Duration::from_micros(1_000 + 40 * step));
    }
    // Requests of impatient clients may still be in the queue.
    let answer = wait_for(20_000, || {
        let answer = client.ask(&into_a_wall(), patience());
        (answer.verdict() != WireState::Busy).then_some(answer)
    });
    let answer = answer.expect("a slot is free again");
    assert_eq!(answer.verdict(), WireState::Complete, "{}", answer.text());
    drop(client);
    serving.end();
}

// verifies REQ-INPUT
#[test]
fn what_is_wrong_is_refused_with_a_reason_and_the_next_is_answered() {
    let place = Place::new();
    let serving = serve(&deployment(&place, 1, WALL), &[]);
    let mut client = connect(&serving.instance);
    type Mistake = (fn(&mut Ask), Reason);
    let mistakes: &[Mistake] = &[
        (|ask| ask.version = 7, Reason::Malformed),
        (|ask| ask.candidate_count = 4_000_000_000, Reason::Malformed),
        (|ask| ask.parties[1].model = 99, Reason::UnknownModel),
        (|ask| ask.states[1].position_m[2] = f64::NAN, Reason::OutOfRange),
        (|ask| ask.model_set[3] = 1, Reason::OtherModels),
        (|ask| ask.parties[0].model = 2, Reason::Misfit),
        (|ask| ask.parties[1].flags = WireParty::UNKNOWN, Reason::UnknownKind),
        (|ask| ask.set_members(1025, 0), Reason::OutOfRange),
        (|ask| ask.set_members(8, 4), Reason::OutOfRange),
        (|ask| known_by(ask, f64::NAN), Reason::OutOfRange),
        (|ask| known_by(ask, -0.1), Reason::OutOfRange),
        (|ask| ask.parties[1].lateral_m = 0.1, Reason::Malformed),
    ];
    for (make, reason) in mistakes {
        let mut ask = into_a_wall();
        make(&mut ask);
        let answer = client.ask(&ask, patience());
        assert_eq!(answer.verdict(), WireState::Refused, "{reason:?}");
        assert_eq!(answer.reason(), *reason, "{}", answer.text());
        assert!(!answer.text().is_empty());
        let answer = client.ask(&into_a_wall(), patience());
        assert_eq!(answer.verdict(), WireState::Complete, "{}", answer.text());
    }
    drop(client);
    serving.end();
}

#[cfg(feature = "lab")]
#[test]
fn clients_that_are_killed_in_the_middle_leave_room_for_others() {
    let place = Place::new();
    let scenario = place.write("ways.toml", &ways(2000));
    let serving = serve(&deployment(&place, 2, &of_ways(2000)), &[]);
    // More than the sixteen slots.
    for round in 0..5_u32 {
        let start = || {
            trolley()
                .args(["query", serving.deployment.to_str().unwrap(), scenario.to_str().unwrap()])
                .args(["--instance", &serving.instance, "--repeat", "1000000"])
                .spawn()
                .unwrap()
        };
        let mut clients: Vec<_> = (0..5).map(|_| start()).collect();
        let _at_work = wait_for(300 + 100 * round, || None::<()>);
        for client in &mut clients {
            client.kill().unwrap();
            client.wait().unwrap();
        }
        // A slot is freed within a second.
        let output = wait_for(10_000, || {
            let output = serving.query(&scenario, &["--json"]);
            output.status.success().then_some(output)
        });
        assert_eq!(ranking(&output.expect("an answer")).len(), 6, "round {round}");
    }
    serving.end();
}

#[test]
fn no_two_clients_number_their_requests_alike() {
    let place = Place::new();
    let serving = serve(&deployment(&place, 1, WALL), &[]);
    let mut clients = [connect(&serving.instance), connect(&serving.instance)];
    let mut ask = |client: usize| clients[client].ask(&into_a_wall(), patience()).sequence;
    let (first, second) = (ask(0), ask(1));
    assert_eq!((ask(0), ask(1)), (first.wrapping_add(1), second.wrapping_add(1)));
    assert!(first.abs_diff(second) > 1 << 20, "{first} {second}");
    drop(clients);
    serving.end();
}

// verifies REQ-OVERLOAD
#[test]
fn a_flood_is_answered_busy_and_nobody_waits_unheard() {
    let place = Place::new();
    let file = deployment(&place, 1, WALL);
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replace("[engine]", "queue = 1\n[engine]")).unwrap();
    let serving = serve(&file, &[]);
    let instance = serving.instance.as_str();
    let answers = std::thread::scope(|scope| {
        // Each asks until it is served: how often it is answered busy depends on the machine.
        let flood = || {
            let mut client = connect(instance);
            let (mut verdicts, mut served) = (Vec::new(), 0);
            while served < 20 {
                verdicts.push(client.ask(&into_a_wall(), patience()).verdict());
                served += usize::from(verdicts.last() != Some(&WireState::Busy));
            }
            verdicts
        };
        let floods: Vec<_> = (0..6).map(|_| scope.spawn(flood)).collect();
        floods.into_iter().flat_map(|flood| flood.join().unwrap()).collect::<Vec<_>>()
    });
    let count = |verdict| answers.iter().filter(|answer| **answer == verdict).count();
    let (complete, busy) = (count(WireState::Complete), count(WireState::Busy));
    assert!(complete == 120 && busy > 0, "{complete} complete and {busy} busy");
    assert_eq!(complete + busy, answers.len());
    serving.end();
}

// verifies REQ-OVERLOAD
#[test]
fn the_seventeenth_client_is_told_to_try_again_and_then_gets_its_answer() {
    let place = Place::new();
    let serving = serve(&deployment(&place, 1, &of_ways(600)), &["--in-process"]);
    let scenario = place.write("ways.toml", &ways(600));
    let mut clients: Vec<Client> = (0..16).map(|_| connect(&serving.instance)).collect();
    let busy = serving.query(&scenario, &[]);
    let said = text(&busy.stderr);
    assert_eq!(busy.status.code(), Some(75), "{said}");
    assert!(said.contains("busy") && said.contains("16 clients"), "{said}");
    assert!(said.contains("help: try again"), "{said}");
    clients.pop();
    let answered = serving.query(&scenario, &[]);
    assert_eq!(answered.status.code(), Some(0), "{}", text(&answered.stderr));
    drop(clients);
    serving.end();
}

// verifies REQ-WORKER-LOST
#[test]
fn killed_workers_are_replaced_and_no_answer_is_wrong() {
    let place = Place::new();
    let scenario = place.write("ways.toml", &ways(2000));
    let expected = ranked(&run(&["rank", scenario.to_str().unwrap(), "--json"]));
    let serving = serve(&deployment(&place, 2, &of_ways(2000)), &[]);
    let service = serving.child.id();
    for round in 0..6 {
        let workers = wait_for(20_000, || Some(children(service)).filter(|list| list.len() == 2));
        let workers = workers.unwrap_or_else(|| panic!("round {round}: not replaced"));
        let doomed = &workers[..1 + round % 2];
        doomed.iter().for_each(|pid| signal(*pid, Signal::KILL));
        let output = wait_for(20_000, || {
            let output = serving.query(&scenario, &["--json"]);
            // All workers may have died during it: then it is refused, and retried.
            output.status.success().then_some(output)
        });
        assert_eq!(ranking(&output.expect("an answer")), expected, "round {round}");
    }
    serving.end();
}

// verifies REQ-SERVICE-LOST
#[test]
fn a_killed_service_is_a_refusal_and_its_successor_is_found_by_the_same_client() {
    let place = Place::new();
    let file = deployment(&place, 1, WALL);
    let mut serving = serve(&file, &[]);
    let mut client = connect(&serving.instance);
    assert_eq!(client.ask(&into_a_wall(), patience()).verdict(), WireState::Complete);
    serving.child.kill().unwrap();
    serving.child.wait().unwrap();
    let answer = client.ask(&into_a_wall(), Duration::from_millis(200));
    assert_eq!(answer.verdict(), WireState::Refused);
    assert!(matches!(answer.reason(), Reason::Silence | Reason::NoService), "{answer:?}");
    let instance = serving.instance.clone();
    let mut next = trolley()
        .args(["serve", file.to_str().unwrap(), "--instance", &instance, "--quiet"])
        .spawn()
        .unwrap();
    let verdict = wait_for(20_000, || {
        let answer = client.ask(&into_a_wall(), Duration::from_millis(500));
        (answer.verdict() == WireState::Complete).then_some(())
    });
    assert!(verdict.is_some(), "the successor is not found");
    drop(client);
    signal(next.id(), Signal::TERM);
    assert!(next.wait().unwrap().success());
    assert_eq!(left_behind(&instance), Vec::<String>::new());
}

// verifies REQ-LATE
#[test]
fn an_answer_that_would_come_too_late_is_refused_by_the_client_in_time() {
    let place = Place::new();
    let serving = serve(&deployment(&place, 1, WALL), &[]);
    let mut client = connect(&serving.instance);
    signal(serving.child.id(), Signal::STOP);
    let begun = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    let answer = client.ask(&into_a_wall(), Duration::from_millis(50));
    let ended = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    assert_eq!(answer.reason(), Reason::Silence, "{}", answer.text());
    // A busy machine may be late; the call must return in any case.
    assert!(ended.tv_sec - begun.tv_sec < 15);
    signal(serving.child.id(), Signal::CONT);
    let answered = wait_for(20_000, || {
        let answer = client.ask(&into_a_wall(), patience());
        (answer.verdict() == WireState::Complete).then_some(())
    });
    assert!(answered.is_some());
    drop(client);
    serving.end();
}

#[test]
fn a_service_that_cannot_be_started_says_why() {
    let place = Place::new();
    let file = deployment(&place, 1, WALL);
    let good = std::fs::read_to_string(&file).unwrap();
    for (from, to, code, said) in [
        ("workers = 1", "wrokers = 1", 78, "unknown field"),
        ("generate = { shape = \"wall\"", "model = \"no.trolley\" #", 65, "no.trolley"),
        ("[engine]", "policy = \"none.toml\"\n[engine]", 65, "none.toml"),
        ("[engine]", "folder = \"/nowhere-at-all\"\n[engine]", 69, "nowhere-at-all"),
        ("workers = 1", "workers = 1\ncores = [1000]", 78, "core 1000"),
    ] {
        if from == "[engine]" && to.contains("nowhere") && rustix::process::getuid().is_root() {
            // Root may create the folder.
            continue;
        }
        let wrong = place.write("wrong.toml", &good.replacen(from, to, 1));
        let output = trolley()
            .args(["serve", wrong.to_str().unwrap(), "--instance", &support::instance()])
            .output()
            .unwrap();
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{to}: {stderr}");
        assert!(stderr.contains(said), "{to}: {stderr}");
    }
    let scenario = place.write("ways.toml", &ways(600));
    let output = trolley()
        .args(["query", file.to_str().unwrap(), scenario.to_str().unwrap()])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(65), "{}", text(&output.stderr));
    let wall = shipped("config/scenarios/wall-or-pole.toml");
    let minimal = shipped("config/deployments/minimal.toml");
    let output = trolley()
        .args(["query", minimal.to_str().unwrap(), wall.to_str().unwrap()])
        .args(["--instance", &support::instance()])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(75), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("no service is running"), "{}", text(&output.stderr));
}

#[test]
fn metrics_and_decisions_are_written_and_bounded() {
    let place = Place::new();
    let file = deployment(&place, 1, WALL);
    let with_files = std::fs::read_to_string(&file).unwrap().replace(
        "[engine]",
        "[metrics]\nfile = \"metrics.prom\"\n[decisions]\nfolder = \"kept\"\nper_file = 4\n\
         files = 2\n[engine]",
    );
    std::fs::write(&file, with_files).unwrap();
    let serving = serve(&file, &[]);
    let mut client = connect(&serving.instance);
    let mut last = 0;
    for _ in 0..11 {
        let answer = client.ask(&into_a_wall(), patience());
        assert_eq!(answer.verdict(), WireState::Complete);
        last = answer.sequence;
    }
    drop(client);
    serving.end();
    let metrics = std::fs::read_to_string(place.path().join("metrics.prom")).unwrap();
    assert!(metrics.contains("verdict=\"complete\"} 11\n"), "{metrics}");
    assert!(metrics.contains("trolley_ready{"), "{metrics}");
    let mut kept: Vec<_> =
        std::fs::read_dir(place.path().join("kept")).unwrap().flatten().collect();
    kept.sort_by_key(std::fs::DirEntry::path);
    assert_eq!(kept.len(), 2, "{kept:?}");
    let entries: Vec<_> =
        kept.iter().flat_map(|file| service::read_decisions(&file.path()).unwrap()).collect();
    assert_eq!(entries.len(), 4 + 3);
    assert!(entries.iter().all(|entry| entry.answer.verdict() == WireState::Complete));
    assert_eq!(entries.last().unwrap().ask.sequence, last);
}

/// Nothing grows with the number of requests.
#[test]
fn a_request_takes_as_much_from_the_heap_as_those_before() {
    const REQUESTS: u64 = 60;
    let place = Place::new();
    let file = deployment(&place, 1, WALL);
    let serving = serve(&file, &["--in-process"]);
    let mut client = connect(&serving.instance);
    let mut taken = Vec::new();
    // In turns the scene as stated, and members.
    for round in 1..=4 {
        let mut ask = into_a_wall();
        ask.set_members(if round % 2 == 0 { 2 } else { 1 }, 0);
        for _ in 0..REQUESTS {
            let answer = client.ask(&ask, patience());
            assert_eq!(answer.verdict(), WireState::Complete, "{}", answer.text());
        }
        // The first page may cover a second that still had requests.
        let top = trolley()
            .args(["top", file.to_str().unwrap(), "--instance", &serving.instance])
            .args(["--times", "2", "--json"])
            .output()
            .unwrap();
        let last = text(&top.stdout).lines().last().map(str::to_owned).unwrap();
        let last: serde_json::Value = serde_json::from_str(&last).unwrap();
        assert_eq!(last["answers"][0][1], round * REQUESTS, "{last}");
        taken.push(last["allocations"].as_u64().unwrap());
    }
    let [stated, drawn] = [0, 1].map(|from| taken[from..].iter().step_by(2).collect::<Vec<_>>());
    for taken in [stated, drawn] {
        assert!(*taken[0] > 0 && taken.iter().all(|now| *now == taken[0]), "{taken:?}");
    }
    drop(client);
    serving.end();
}

/// What an answer says of its bodies can be asked for, and is the same for every build of them.
// verifies REQ-BODIES
#[test]
fn a_client_may_insist_on_the_bodies_that_it_knows() {
    let place = Place::new();
    let serving = serve(&deployment(&place, 1, WALL), &["--in-process"]);
    let mut client = connect(&serving.instance);
    let first = client.ask(&into_a_wall(), patience());
    assert!(first.model_set != [0; 32]);
    let mut insists = into_a_wall();
    insists.model_set = first.model_set;
    assert_eq!(client.ask(&insists, patience()).verdict(), WireState::Complete);
    drop(client);
    serving.end();
    let text = std::fs::read_to_string(place.path().join("deployment.toml")).unwrap();
    let file =
        place.write("deployment.toml", &text.replace("[engine]", "[engine]\nbuild = \"sah\""));
    let rebuilt = serve(&file, &["--in-process"]);
    let answer = connect(&rebuilt.instance).ask(&insists, patience());
    assert_eq!((answer.verdict(), answer.places), (WireState::Complete, first.places));
    rebuilt.end();
    let file = deployment(&place, 1, &[("sedan", 2000, 0), ("wall", 602, 0)]);
    let other = serve(&file, &["--in-process"]);
    let answer = connect(&other.instance).ask(&insists, patience());
    assert_eq!(answer.reason(), Reason::OtherModels, "{}", answer.text());
    other.end();
}
